"""The legend: the colours of the types and the signs of the pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PIL import Image

from regionslam_env.rendering.palette import (
    BELIEF,
    GOAL,
    INK,
    LIDAR,
    LINK,
    MUTED,
    PAPER,
    PERSON,
    SHUT,
    TRUTH,
    blend,
    text_width,
    type_colour,
)
from regionslam_env.rendering.panel import Panel

ROW = 20
SWATCH = 22
GAP = 16
TEXT = 13

Sign = Callable[[Panel, float, float], None]
NamedSign = tuple[str, Sign]


def _closed(panel: Panel, x: float, y: float) -> None:
    panel.line([(x, y), (x + SWATCH, y)], INK, 2.0)


def _open(panel: Panel, x: float, y: float) -> None:
    panel.dashes((x, y), (x + SWATCH, y), INK, 1.6)


def _inside(panel: Panel, x: float, y: float) -> None:
    panel.dashes((x, y), (x + SWATCH, y), blend(LINK, PAPER, 0.2), 1.0)


def _unsure(panel: Panel, x: float, y: float) -> None:
    for k in range(3):
        left, right = x + k * SWATCH / 3, x + (k + 1) * SWATCH / 3
        colour = blend(type_colour("office"), PAPER, 0.3 * k)
        panel.polygon([(left, y - 6), (right, y - 6), (right, y + 6), (left, y + 6)], colour)


def _path(colour: tuple[int, int, int]) -> Sign:
    def sign(panel: Panel, x: float, y: float) -> None:
        panel.line([(x, y + 3), (x + 7, y - 3), (x + 14, y + 3), (x + SWATCH, y - 3)], colour, 1.6)

    return sign


def _link(panel: Panel, x: float, y: float) -> None:
    panel.line([(x + 2, y), (x + SWATCH - 2, y)], LINK, 1.2)
    panel.disc((x + 2, y), 2.2, LINK)
    panel.disc((x + SWATCH - 2, y), 2.2, LINK)


def _lidar(panel: Panel, x: float, y: float) -> None:
    panel.polygon([(x, y - 6), (x + SWATCH, y - 6), (x + SWATCH, y + 6), (x, y + 6)], blend(PAPER, LIDAR, 0.15))
    for k in range(4):
        panel.disc((x + 3 + 5 * k, y - 6), 1.4, LIDAR)


def _ellipse(panel: Panel, x: float, y: float) -> None:
    panel.disc((x + SWATCH / 2, y), 7, blend(PAPER, BELIEF, 0.35))


def _goal(panel: Panel, x: float, y: float) -> None:
    panel.line(
        [(x, y - 6), (x + SWATCH, y - 6), (x + SWATCH, y + 6), (x, y + 6), (x, y - 6), (x + 1, y - 6)], GOAL, 2.5
    )


def _person(panel: Panel, x: float, y: float) -> None:
    panel.disc((x + SWATCH / 2, y), 6, PERSON)


def _shut(panel: Panel, x: float, y: float) -> None:
    panel.line([(x, y), (x + SWATCH, y)], SHUT, 4.0)


SIGNS: tuple[NamedSign, ...] = (
    ("goal", _goal),
    ("edge seen", _closed),
    ("edge still open", _open),
    ("paler: less sure", _unsure),
    ("passage", _link),
    ("part of", _inside),
    ("lidar", _lidar),
    ("true path", _path(TRUTH)),
    ("believed path", _path(BELIEF)),
    ("pose, 2 sigma", _ellipse),
)

MOVING_SIGNS: tuple[NamedSign, ...] = (*SIGNS, ("person", _person), ("closed door", _shut))
"""The same with those of what moves."""


def legend_height(width: int, types: Sequence[str], signs: Sequence[NamedSign] = SIGNS) -> int:
    """Return how many pixels the legend needs below its top, within a width in px."""
    return ROW * (1 + _places(width, types, [name for name, _ in signs])[-1][0]) + 10


def draw_legend(
    picture: Image.Image,
    x: int,
    y: int,
    width: int,
    types: Sequence[str],
    signs: Sequence[NamedSign] = SIGNS,
) -> None:
    """Draw the legend with its upper left corner at (x, y) of a picture: types first, then the signs."""
    panel = Panel((width, legend_height(width, types, signs)), PAPER)
    draw_sign = dict(signs)
    for line, left, name in _places(width, types, list(draw_sign)):
        middle = ROW * line + ROW / 2
        if name in draw_sign:
            draw_sign[name](panel, left, middle)
        else:
            corners = [(left, middle - 6), (left + SWATCH, middle - 6), (left + SWATCH, middle + 6), (left, middle + 6)]
            panel.polygon(corners, type_colour(name))
            panel.line([*corners, corners[0]], MUTED, 0.5)
        panel.text(left + SWATCH + 6 + text_width(name, TEXT) / 2, middle, name, INK, TEXT)
    picture.paste(panel.finish(), (x, y))


def _places(width: int, *groups: Sequence[str]) -> list[tuple[int, float, str]]:
    """Return line, left and name of each entry, broken into lines; each group begins a line."""
    places: list[tuple[int, float, str]] = []
    line = -1
    for group in groups:
        left = float("inf")
        for name in group:
            need = SWATCH + 6 + text_width(name, TEXT)
            if left + need > width:
                line, left = line + 1, 1.0
            places.append((line, left, name))
            left += need + GAP
    return places
