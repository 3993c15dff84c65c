"""A believed map in characters, for terminals and logs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from regionslam_env.rendering.palette import BELIEF, GOAL, type_colour
from regionslam_env.rendering.shapes import Shape, main_direction
from slam.rows import Floats

CHARACTERS = {
    "hallway": ".",
    "office": "o",
    "kitchen": "k",
    "laboratory": "l",
    "meeting room": "m",
    "toilet": "t",
    "storage": "s",
    "classroom": "c",
    "lobby": "y",
    "stairs": "/",
    "elevator": "e",
    "entrance": "n",
    "service room": "x",
    "living room": "i",
    "bedroom": "b",
    "ward": "w",
    "outdoor": ",",
    "door": "+",
    "desk": "D",
    "cupboard": "C",
    "table": "T",
    "bed": "B",
    "sofa": "S",
}
"""Of the semantic types: capitals are furniture. All other types share `OTHER`."""

OTHER = "?"
TARGET = "*"
"""Regions of the goal's type."""

HEADINGS = ">^<v"
"""The robot, by the quarter of its heading, counter-clockwise."""

FINEST = 0.25
"""Least width of a character, m; characters count as twice as high."""


def text_picture(
    shapes: Sequence[Shape],
    pose: ArrayLike,
    goal: str | None = None,
    width: int = 78,
    height: int = 24,
    colour: bool = False,
    upright: float = 0.0,
) -> str:
    """Return a picture made of lines, and a legend below it; unknown floor is blank.

    It is turned so that most walls run along its sides, and its lines are no longer than `width`.

    Parameters
    ----------
    shapes
        Regions in the map frame (`shapes_of_map`).
    pose
        Believed pose (x, y, theta) in the map frame, m and rad.
    goal
        Semantic type to highlight.
    width, height
        Most characters and lines of the picture without legend.
    colour
        Whether characters get the colours of the pictures, by ANSI escape codes.
    upright
        Direction in the map frame that shall point to the right, rad: of the four turns that fit the walls, the one
        nearest to it is taken.
    """
    x, y, heading = np.asarray(pose, dtype=np.float64)
    turn = wall_direction(shapes, upright)
    points, (row, column) = _grid(shapes, (float(x), float(y)), turn, width, height)
    grid = np.full(points.shape[:2], " ")
    for shape in sorted(shapes, key=lambda s: -s.area):
        character = _character(shape.type, goal)
        grid[shape.row.contains(points.reshape(-1, 2)).reshape(grid.shape)] = character
        middle = np.hypot(*np.moveaxis(points - shape.centre, -1, 0))
        grid[np.unravel_index(np.argmin(middle), grid.shape)] = character  # what is smaller than a character shows
    grid[row, column] = HEADINGS[round((heading - turn) / (math.pi / 2)) % 4]
    codes = _codes(shapes, goal) if colour else {}
    lines = ["".join(codes.get(c, "") + c + "\x1b[0m" * (c in codes) for c in line) for line in grid.tolist()]
    if not colour:
        lines = [line.rstrip() for line in lines]
    return "\n".join([*lines, *_legend(shapes, goal, grid[row, column], width)])


class TextRenderer:
    """Draws the frames of one episode, all turned alike: walls askew by half a right angle would flip to and fro."""

    def __init__(self) -> None:
        self._upright = 0.0

    def frame(self, shapes: Sequence[Shape], pose: ArrayLike, goal: str | None = None) -> str:
        """Return the `text_picture` of a moment."""
        self._upright = wall_direction(shapes, self._upright)
        return text_picture(shapes, pose, goal, upright=self._upright)


def wall_direction(shapes: Sequence[Shape], near: float) -> float:
    """Return the direction of most walls, rad: of the four along and across them the one nearest to `near`."""
    direction, quarter = main_direction(shapes), math.pi / 2
    return direction + quarter * round((near - direction) / quarter)


def _grid(
    shapes: Sequence[Shape], robot: tuple[float, float], turn: float, width: int, height: int
) -> tuple[Floats, tuple[int, int]]:
    """Return the middles of all characters in the map frame, shape (lines, columns, 2), and the robot's place."""
    c, s = math.cos(turn), math.sin(turn)
    to_map = np.array([[c, -s], [s, c]])
    known = np.concatenate([[robot], *(shape.rectangles.reshape(-1, 2) for shape in shapes)]) @ to_map
    low, high = known.min(axis=0), known.max(axis=0)
    cell = max(FINEST, float((high[0] - low[0]) / width), float((high[1] - low[1]) / (2 * height)))
    step = np.array([cell, 2 * cell])
    size = np.maximum(1, np.ceil((high - low) / step - 1e-6)).astype(np.int64)
    origin = (low + high - size * step) / 2
    u, v = (origin[k] + step[k] * (np.arange(size[k]) + 0.5) for k in range(2))
    across, up = np.meshgrid(u, v[::-1])
    column, line = np.clip(np.floor((np.array(robot) @ to_map - origin) / step).astype(int), 0, size - 1).tolist()
    return np.stack([across, up], axis=-1) @ to_map.T, (int(size[1]) - 1 - line, column)


def _character(kind: str, goal: str | None) -> str:
    return TARGET if kind == goal else CHARACTERS.get(kind, OTHER)


def _codes(shapes: Sequence[Shape], goal: str | None) -> dict[str, str]:
    """Return the escape code before each character: the type's colour behind it."""
    backgrounds = {_character(s.type, goal): type_colour(s.type) for s in shapes}
    backgrounds |= {TARGET: GOAL} | dict.fromkeys(HEADINGS, BELIEF)
    return {c: f"\x1b[30;48;2;{red};{green};{blue}m" for c, (red, green, blue) in backgrounds.items()}


def _legend(shapes: Sequence[Shape], goal: str | None, robot: str, width: int) -> list[str]:
    """Return lines that explain the characters."""
    named: dict[str, list[str]] = {}
    for kind in sorted({s.type for s in shapes if s.type != goal}):
        named.setdefault(_character(kind, goal), []).append(kind)
    signs = [f"{robot} me"]
    if goal is not None:
        found = any(s.type == goal for s in shapes)
        signs.append(f"{TARGET} {goal} (the goal{'' if found else ', not known yet'})")
    lines = [""]
    for sign in [*signs, *(f"{c} {' or '.join(names)}" for c, names in named.items())]:
        if lines[-1] and len(lines[-1]) + 2 + len(sign) > width:
            lines.append("")
        lines[-1] += f"  {sign}" if lines[-1] else sign
    return lines
