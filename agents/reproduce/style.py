"""What the reproduced figures share: matplotlib, loaded only when drawing, colours, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from agents.console import InputError
from regionslam_env.errors import hint
from regionslam_env.rendering import palette
from slam.storage import replacing


def colour(rgb: palette.Colour) -> tuple[float, float, float]:
    """Return a colour of the palette as matplotlib takes it."""
    red, green, blue = rgb
    return red / 255, green / 255, blue / 255


INK, MUTED, FAINT = colour(palette.INK), colour(palette.MUTED), colour(palette.FAINT)
TRUTH, BELIEF = colour(palette.TRUTH), colour(palette.BELIEF)


def new_figure(width: float, height: float) -> Any:
    """Return an empty figure of a size in inches that needs no display.

    Raises
    ------
    InputError
        If matplotlib isn't installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError(hint("figures need matplotlib", "plots")) from error
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def save(figure: Any, path: Path, dpi: int = 100) -> None:
    """Write a figure as PNG; folders are made as needed."""
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=dpi, metadata={"Software": None}, pil_kwargs={"optimize": True})


def plain_axes(axes: Any) -> None:
    """Take frame and ticks away from a picture with equal axes."""
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color(FAINT)
