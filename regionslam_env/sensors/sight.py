"""What is seen of one rectangle: how much of each edge, and the box around its visible part.

The view is a fan of beams, each between two neighbouring rays. A beam crosses an edge where both of its rays get that far.
Everything is computed relative to the sensor, along the rectangle's own axes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slam.jit import njit

Floats = NDArray[np.float64]
Bounds = tuple[float, float, float, float]

TOP, BOTTOM, LEFT, RIGHT = 0, 1, 2, 3  # edges, in the order of EDGE_NAMES
BOX_U, BOX_V = 4, 6  # smallest and largest coordinate of the visible part along the first and the second axis
SIGHT = 8  # entries of a sight

_ROUNDING = 1e-9
_ON_THE_LINE = 1e-6  # an edge whose line runs through the sensor is not seen, m


@njit
def look(
    bounds: Bounds,
    axis: tuple[float, float],
    directions: Floats,
    ranges: Floats,
    reach: float,
    tolerance: float,
    seen: Floats,
) -> int:
    """Look at a rectangle.

    Parameters
    ----------
    bounds
        Its left, right, bottom and top along its axes, relative to the sensor, m.
    axis
        Its first axis (unit vector) in the sensor's frame.
    directions, ranges
        Rays in the sensor's frame, shape (2, n), and how far they see, shape (n,), m.
    reach
        Range of the sensor: a ray as long as this has met nothing, m.
    tolerance
        Distance at which a wall in front of an edge counts as the edge, m.
    seen
        Written: metres seen of the top, bottom, left and right edge, then the box around the visible part (smallest and
        largest u, smallest and largest v; infinite and reversed where nothing is visible), shape (8,).

    Returns
    -------
    int
        Number of crossings of an edge by a beam.
    """
    left, right, bottom, top = bounds
    seen[:BOX_U] = 0.0
    seen[BOX_U] = seen[BOX_V] = math.inf
    seen[BOX_U + 1] = seen[BOX_V + 1] = -math.inf
    crossings = 0
    for edge in range(4):
        crossings += _look_at_edge(edge, bounds, axis, directions, ranges, reach, tolerance, seen)
    if left <= 0 <= right and bottom <= 0 <= top:
        _stretch(seen, BOX_U, 0.0)
        _stretch(seen, BOX_V, 0.0)
        for i in range(ranges.shape[0]):
            u = ranges[i] * (axis[0] * directions[0, i] + axis[1] * directions[1, i])
            v = ranges[i] * (axis[0] * directions[1, i] - axis[1] * directions[0, i])
            if left - _ROUNDING <= u <= right + _ROUNDING and bottom - _ROUNDING <= v <= top + _ROUNDING:
                _stretch(seen, BOX_U, u)
                _stretch(seen, BOX_V, v)
    return crossings


@njit
def _look_at_edge(
    edge: int,
    bounds: Bounds,
    axis: tuple[float, float],
    directions: Floats,
    ranges: Floats,
    reach: float,
    tolerance: float,
    seen: Floats,
) -> int:
    """Follow the beams across one edge; return how many cross it.

    The edge lies at `line` across and from `low` to `high` along. If the rectangle is behind it, rays end inside it as well.
    """
    left, right, bottom, top = bounds
    if edge == TOP or edge == BOTTOM:
        line, far, low, high = (top, bottom, left, right) if edge == TOP else (bottom, top, left, right)
        across, along, across_x, across_y, along_x, along_y = BOX_V, BOX_U, -axis[1], axis[0], axis[0], axis[1]
    else:
        line, far, low, high = (left, right, bottom, top) if edge == LEFT else (right, left, bottom, top)
        across, along, across_x, across_y, along_x, along_y = BOX_U, BOX_V, axis[0], axis[1], -axis[1], axis[0]
    distance, side = abs(line), 1.0 if line > 0 else -1.0
    if distance < _ON_THE_LINE or distance > reach:
        return 0
    depth = far * side  # beyond `distance` if the rectangle is behind the edge
    n = ranges.shape[0]
    first, last = _rays(
        line * across_x + low * along_x,
        line * across_y + low * along_y,
        line * across_x + high * along_x,
        line * across_y + high * along_y,
        n,
    )
    before, at_before, crossings = 0, 0.0, 0
    for k in range(first, last + 1):
        i = k if k < n else k - n
        rise = side * (across_x * directions[0, i] + across_y * directions[1, i])
        slide = along_x * directions[0, i] + along_y * directions[1, i]
        end = ranges[i] * rise
        now, at = 0, 0.0
        if rise > 0 and end >= distance - _ROUNDING:
            now, at = 2, distance * slide / rise
            stop = ranges[i] * slide
            if end <= depth + _ROUNDING and low - _ROUNDING <= stop <= high + _ROUNDING:
                _stretch(seen, across, side * end)
                _stretch(seen, along, stop)
        elif rise > 0 and end >= distance - tolerance and 0 < ranges[i] < reach:
            now, at = 1, ranges[i] * slide
        if now > 0 and before > 0:
            start, stop = max(min(at, at_before), low), min(max(at, at_before), high)
            if stop > start:
                seen[edge] += stop - start
                if now == 2 and before == 2:
                    crossings += 1
                    _stretch(seen, across, line)
                    _stretch(seen, along, start)
                    _stretch(seen, along, stop)
        before, at_before = now, at
    return crossings


@njit
def _rays(px: float, py: float, qx: float, qy: float, n: int) -> tuple[int, int]:
    """Return the first and last of the beams' rays that meet the segment from p to q (sensor frame); they may exceed n."""
    cross = px * qy - py * qx
    if cross < 0:
        px, py, qx, qy, cross = qx, qy, px, py, -cross
    per_radian = n / (2 * math.pi)
    start = (math.atan2(py, px) + math.pi) * per_radian
    end = start + math.atan2(cross, px * qx + py * qy) * per_radian
    return math.floor(start), math.ceil(end)


@njit
def _stretch(seen: Floats, entry: int, value: float) -> None:
    """Widen the interval seen[entry], seen[entry + 1] to a value."""
    seen[entry] = min(seen[entry], value)
    seen[entry + 1] = max(seen[entry + 1], value)
