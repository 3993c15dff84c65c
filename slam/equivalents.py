"""Equivalent descriptions of a row: all rows of at most three rectangles that are the same place.

No sensor knows which end of a hallway an annotator called "left", or along which arm an L was written down. Exact, on
any `Row`, by the cells of the grid that its edges span; the filter's kernel for it is `slam.turning.turn`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, pairwise

import numpy as np

from slam.region import EdgeState
from slam.rows import MAX_RECTANGLES, Floats, Row

Description = tuple[Row, dict[str, EdgeState]]

Segment = tuple[str, float, float]
"""A piece of a line: the axis it is normal to ("u" or "v"), its position, and the middle of the piece."""


def equivalents(row: Row, states: Mapping[str, EdgeState]) -> list[Description]:
    """Return every row of at most three rectangles that covers the same set with the same edge states.

    A single rectangle has four descriptions; a row can be read from its other end; an L is two rectangles along either
    axis, a T three along its bar or two along its stem; a joint without a step may be left out. Joints that the row
    does not have are added only where the outline steps. A joint is a known line: what of it lies on the outline is
    closed.

    Parameters
    ----------
    row
        The row.
    states
        States of its edges by the names of `slam.region.EDGE_NAMES`.
    """
    outline = _outline(row, states)
    found = []
    for axis in range(2):
        for u, sides in _splits(row, axis):
            closed = _states(outline, u, sides, axis)
            if closed is not None:
                found += [_described(row, u, sides, closed, axis, half) for half in range(2)]
    return found


def _lines(row: Row) -> tuple[Floats, Floats]:
    """Return the positions of all edges along both axes, ascending."""
    return row.u, np.unique(np.concatenate([row.b, row.t]))


def _filled(row: Row, u: float, v: float) -> bool:
    return any(row.u[i] < u < row.u[i + 1] and row.b[i] < v < row.t[i] for i in range(row.n))


def _outline(row: Row, states: Mapping[str, EdgeState]) -> dict[Segment, bool]:
    """Return for every piece of the outline between grid lines whether it is closed."""
    across = _lines(row)[1]
    pieces: dict[Segment, bool] = {}
    for i in range(row.n):
        side = "" if i == row.main else "lr"[i > row.main]
        for name, v in (("b", row.b[i]), ("t", row.t[i])):
            pieces["v", v, (row.u[i] + row.u[i + 1]) / 2] = states[name + side] != EdgeState.OPEN
    for k, u in enumerate(row.u):
        end = {0: "l" if row.main == 0 else "ll", row.n: "r" if row.main == row.n - 1 else "rr"}.get(k)
        for low, high in pairwise(across):
            v = (low + high) / 2
            inside = [0 <= i < row.n and row.b[i] < v < row.t[i] for i in (k - 1, k)]
            if inside[0] != inside[1]:
                pieces["u", u, v] = end is None or states[end] != EdgeState.OPEN
    return pieces


def _splits(row: Row, axis: int) -> Iterator[tuple[list[float], list[tuple[float, float]]]]:
    """Yield boundaries along an axis, and the sides of every rectangle, of all rows that cover the set."""
    lines, others = _lines(row)[axis], _lines(row)[1 - axis]
    slabs = []
    for low, high in pairwise(lines):
        middle = (low + high) / 2
        inside = [_filled(row, *((middle, v) if axis == 0 else (v, middle))) for v in (others[:-1] + others[1:]) / 2]
        runs = [k for k, (a, b) in enumerate(pairwise([False, *inside, False])) if a != b]
        if len(runs) != 2:
            return  # empty or torn: no row along this axis
        slabs.append((float(others[runs[0]]), float(others[runs[1]])))
    if axis == 1 and any(min(a[1], b[1]) <= max(a[0], b[0]) for a, b in pairwise(slabs)):
        return  # parts that touch at most in a corner
    steps = [k for k, (a, b) in enumerate(pairwise(slabs), 1) if a != b]
    idle = [k for k in range(1, len(slabs)) if k not in steps] if axis == 0 else []
    for count in range(len(idle) + 1):
        for kept in combinations(idle, count):
            cuts = [0, *sorted([*steps, *kept]), len(slabs)]
            if len(cuts) - 1 <= MAX_RECTANGLES:
                yield [float(lines[k]) for k in cuts], [slabs[k] for k in cuts[:-1]]


def _states(
    outline: Mapping[Segment, bool], u: Sequence[float], sides: Sequence[tuple[float, float]], axis: int
) -> dict[tuple[int, int], bool] | None:
    """Return whether (rectangle, side) is closed, sides being left, right, bottom, top; None if that contradicts."""
    names = "uv" if axis == 0 else "vu"
    closed = {}
    for i, (low, high) in enumerate(sides):
        span = [(names[0], u[i], low, high), (names[0], u[i + 1], low, high)]
        span += [(names[1], low, u[i], u[i + 1]), (names[1], high, u[i], u[i + 1])]
        for side, (name, position, start, end) in enumerate(span):
            pieces = {
                state
                for (other, at, middle), state in outline.items()
                if other == name and at == position and start < middle < end
            }
            joint = (side == 0 and i > 0) or (side == 1 and i + 1 < len(sides))
            if len(pieces) > 1 or (joint and pieces == {False}):
                return None
            closed[i, side] = joint or pieces == {True}
    return closed


def _described(
    row: Row,
    u: Sequence[float],
    sides: Sequence[tuple[float, float]],
    closed: Mapping[tuple[int, int], bool],
    axis: int,
    half: int,
) -> Description:
    """Return the row along an axis, read from its other end if `half`, with its states by name."""
    n = len(sides)
    phi, b, t = row.phi, [low for low, _ in sides], [high for _, high in sides]
    order = {0: (0, 1, 2, 3), 1: (0, 1, 3, 2)}[axis]  # a quarter turn: what was left of the row is now its top
    if axis == 1:
        phi, b, t = phi + math.pi / 2, [-high for _, high in sides], [-low for low, _ in sides]
    rectangles, bounds = list(range(n)), list(u)
    if half:
        phi, b, t = phi + math.pi, [-v for v in t[::-1]], [-v for v in b[::-1]]
        bounds, rectangles = [-v for v in bounds[::-1]], rectangles[::-1]
        order = (order[1], order[0], order[3], order[2])
    main = n // 2 if n != 2 else _main_of_two(row, axis, u, half)
    states: dict[str, EdgeState] = {}
    for place, i in enumerate(rectangles):
        side = "" if place == main else "lr"[place > main]
        left, right, bottom, top = (EdgeState(int(closed[i, k])) for k in order)
        states |= {"t" + side: top, "b" + side: bottom}
        if place == main:
            states |= {"l": left if place == 0 else EdgeState.SUBRECT}
            states |= {"r": right if place == n - 1 else EdgeState.SUBRECT}
        else:
            states[side * 2] = left if side == "l" else right
    return Row(row.x, row.y, phi, np.array(bounds), np.array(b), np.array(t), main), states


def _main_of_two(row: Row, axis: int, u: Sequence[float], half: int) -> int:
    """Return which of two rectangles holds the middle of the row's main rectangle."""
    i = row.main
    middle = (row.u[i] + row.u[i + 1]) / 2 if axis == 0 else (row.b[i] + row.t[i]) / 2
    return int(middle > u[1]) ^ half
