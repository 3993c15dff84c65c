"""Writing an animation: nothing half-written is ever left behind."""

from __future__ import annotations

import itertools
import os
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from slam.storage import replacing

OWN_COLOURS = 128
LEVELS = (0, 64, 128, 191, 255)


class GifWriter:
    """Collects frames and writes them as one looping GIF on leaving the `with` block without an error.

    Frames are reduced to one palette as they come, without dithering: the colours of the first (its legend shows most),
    and a coarse cube for what appears later.

    Parameters
    ----------
    path
        Where the GIF goes.
    frame_ms
        Duration of a frame, ms.
    last_ms
        Duration of the last frame, ms.
    """

    def __init__(self, path: str | os.PathLike[str], frame_ms: int = 80, last_ms: int = 2500) -> None:
        self.path = Path(path)
        self.frame_ms, self.last_ms = frame_ms, last_ms
        self._frames: list[Image.Image] = []
        self._palette: Image.Image | None = None

    def __enter__(self) -> GifWriter:
        return self

    def add(self, frame: NDArray[np.uint8]) -> None:
        """Append a frame of shape (height, width, 3)."""
        image = Image.fromarray(frame)
        if self._palette is None:
            self._palette = _palette(image)
        self._frames.append(image.quantize(palette=self._palette, dither=Image.Dither.NONE))

    def __len__(self) -> int:
        return len(self._frames)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None and self._frames:
            self.write()

    def write(self) -> None:
        """Write to a temporary file beside the target and move it there."""
        durations = [self.frame_ms] * (len(self._frames) - 1) + [self.last_ms]
        with replacing(self.path) as temporary:
            self._frames[0].save(
                temporary,
                format="GIF",
                save_all=True,
                append_images=self._frames[1:],
                duration=durations,
                loop=0,
                optimize=False,
            )


def _palette(image: Image.Image) -> Image.Image:
    """Return a palette of 128 colours of an image and 125 spread evenly over all colours."""
    own = image.quantize(OWN_COLOURS, method=Image.Quantize.MEDIANCUT).getpalette() or []
    cube = [level for colour in itertools.product(LEVELS, repeat=3) for level in colour]
    palette = Image.new("P", (1, 1))
    palette.putpalette(own[: 3 * OWN_COLOURS] + cube)
    return palette
