"""Writing an animation: nothing half-written is ever left behind."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from PIL import Image

COLOURS = 240


class GifWriter:
    """Collects frames and writes them as one looping GIF on leaving the `with` block without an error.

    Frames are reduced to the palette of the first (its legend shows every colour) as they come, without dithering.

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
            self._palette = image.quantize(COLOURS, method=Image.Quantize.MEDIANCUT)
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
        temporary = self.path.with_name(f".{self.path.name}.{os.getpid()}.part")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        try:
            self._frames[0].save(
                temporary,
                format="GIF",
                save_all=True,
                append_images=self._frames[1:],
                duration=durations,
                loop=0,
                optimize=False,
            )
            temporary.replace(self.path)
        finally:
            temporary.unlink(missing_ok=True)
