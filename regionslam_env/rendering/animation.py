"""Writing an animation: nothing half-written is ever left behind."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from regionslam_env.rendering.palette import Colour, colour_table
from slam.storage import replacing


class GifWriter:
    """Collects frames and writes them as one looping GIF on leaving the `with` block without an error.

    Frames are reduced to one palette as they come, without dithering, so that a colour stays the same throughout.

    Parameters
    ----------
    path
        Where the GIF goes.
    frame_ms
        Duration of a frame, ms.
    last_ms
        Duration of the last frame, ms.
    colours
        Colours that the palette has to hold; the rest of its 256 are spread evenly.
    """

    def __init__(
        self, path: str | os.PathLike[str], frame_ms: int = 80, last_ms: int = 2500, colours: Iterable[Colour] = ()
    ) -> None:
        self.path = Path(path)
        self.frame_ms, self.last_ms = frame_ms, last_ms
        self._frames: list[Image.Image] = []
        self._palette = _palette(colours)

    def __enter__(self) -> GifWriter:
        return self

    def add(self, frame: NDArray[np.uint8]) -> None:
        """Append a frame of shape (height, width, 3)."""
        image = Image.fromarray(frame)
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


def _palette(colours: Iterable[Colour]) -> Image.Image:
    """Return these colours, and others as there is room, as the palette of an image."""
    palette = Image.new("P", (1, 1))
    palette.putpalette([level for colour in colour_table(colours) for level in colour])
    return palette
