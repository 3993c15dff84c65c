"""What is seen of one rectangle: how much of each edge, and the box around its visible part.

The view is a fan of beams, each between two neighbouring rays. A beam crosses an edge where both of its rays get that
far. Everything is computed relative to the sensor, along the rectangle's own axes.
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

_LOST, _STOPPED, _THROUGH = 0, 1, 2  # a ray ends before an edge, at a wall just before it, beyond it
_FEWEST_RAYS = 3  # into a rectangle, for it to be seen from outside
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
) -> None:
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
    """
    left, right, bottom, top = bounds
    seen[:BOX_U] = 0.0
    seen[BOX_U] = seen[BOX_V] = math.inf
    seen[BOX_U + 1] = seen[BOX_V + 1] = -math.inf
    inside = left <= 0 <= right and bottom <= 0 <= top
    entered = 0
    for k in range(8):
        near, edge = k < 4, k % 4  # near edges first: most rectangles are hidden, and nothing comes in there
        if near == _faces(edge, bounds):
            if not (near or inside or entered >= _FEWEST_RAYS):
                seen[BOX_U], seen[BOX_U + 1] = math.inf, -math.inf
                return
            entered += _look_at_edge(edge, bounds, axis, directions, ranges, reach, tolerance, seen)
    if inside:
        _look_around(bounds, axis, directions, ranges, seen)


@njit
def _look_around(bounds: Bounds, axis: tuple[float, float], directions: Floats, ranges: Floats, seen: Floats) -> None:
    """Widen the box by the sensor's place and the ends of all rays inside the rectangle."""
    left, right, bottom, top = bounds
    if seen[BOX_U] <= left and seen[BOX_U + 1] >= right and seen[BOX_V] <= bottom and seen[BOX_V + 1] >= top:
        return
    least_u = most_u = least_v = most_v = 0.0
    for i in range(ranges.shape[0]):
        u = ranges[i] * (axis[0] * directions[0, i] + axis[1] * directions[1, i])
        v = ranges[i] * (axis[0] * directions[1, i] - axis[1] * directions[0, i])
        if left - _ROUNDING <= u <= right + _ROUNDING and bottom - _ROUNDING <= v <= top + _ROUNDING:
            least_u, most_u = min(least_u, u), max(most_u, u)
            least_v, most_v = min(least_v, v), max(most_v, v)
    _stretch(seen, BOX_U, least_u)
    _stretch(seen, BOX_U, most_u)
    _stretch(seen, BOX_V, least_v)
    _stretch(seen, BOX_V, most_v)


@njit
def _faces(edge: int, bounds: Bounds) -> bool:
    """Return whether the rectangle lies behind this edge, seen from the sensor."""
    left, right, bottom, top = bounds
    if edge == TOP:
        return top < 0
    if edge == BOTTOM:
        return bottom > 0
    return left > 0 if edge == LEFT else right < 0


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
    """Follow the beams across one edge; return how many rays get through it into the rectangle or out of it.

    The edge lies at `line` across and from `low` to `high` along. Rays that come in through it may end inside.
    """
    left, right, bottom, top = bounds
    if edge in (TOP, BOTTOM):
        line, far, low, high = (top, bottom, left, right) if edge == TOP else (bottom, top, left, right)
        across, along, across_x, across_y, along_x, along_y = BOX_V, BOX_U, -axis[1], axis[0], axis[0], axis[1]
    else:
        line, far, low, high = (left, right, bottom, top) if edge == LEFT else (right, left, bottom, top)
        across, along, across_x, across_y, along_x, along_y = BOX_U, BOX_V, axis[0], axis[1], -axis[1], axis[0]
    side = 1.0 if line > 0 else -1.0
    distance, depth = line * side, far * side
    # A wall on the far edge is inside the rectangle, one on the near edge in front of it.
    through = distance + _ROUNDING if depth > distance else distance - _ROUNDING
    if distance < _ON_THE_LINE or distance > reach:
        return 0
    n = ranges.shape[0]
    first, last = _rays(
        line * across_x + low * along_x,
        line * across_y + low * along_y,
        line * across_x + high * along_x,
        line * across_y + high * along_y,
        n,
    )
    length, passed = 0.0, 0
    least, most, nearest, farthest = math.inf, -math.inf, math.inf, -math.inf  # of the box, along and across
    before, run_start, at_before, last_slide, last_rise = _LOST, 0.0, 0.0, 0.0, 1.0
    for k in range(first, last + 2):  # one more than there are, to end the last run
        i = k if k < n else k - n
        r = ranges[i]
        rise = side * (across_x * directions[0, i] + across_y * directions[1, i])
        end = r * rise
        now, slide = _LOST, 0.0
        if rise > 0 and end >= distance - tolerance and k <= last:
            slide = along_x * directions[0, i] + along_y * directions[1, i]
            if end >= through:
                now = _THROUGH
            elif 0 < r < reach:
                now = _STOPPED
        if before == _THROUGH and now != _THROUGH:
            # Within a run of rays that get through, the first and the last one tell all.
            at_before = distance * last_slide / last_rise
            seen_here = _common(run_start, at_before, low, high)
            if seen_here > 0:
                length += seen_here
                least = min(least, max(min(run_start, at_before), low))
                most = max(most, min(max(run_start, at_before), high))
                nearest, farthest = min(nearest, distance), max(farthest, distance)
        if now == _THROUGH:
            if before != _THROUGH:
                run_start = distance * slide / rise
                if before == _STOPPED:
                    length += _common(at_before, run_start, low, high)
            last_slide, last_rise = slide, rise
            if low * rise <= distance * slide <= high * rise:
                passed += 1
                stop = r * slide
                if end <= depth + _ROUNDING and low - _ROUNDING <= stop <= high + _ROUNDING:
                    least, most = min(least, stop), max(most, stop)
                    nearest, farthest = min(nearest, end), max(farthest, end)
        elif now == _STOPPED:
            if before != _LOST:
                length += _common(at_before, r * slide, low, high)
            at_before = r * slide
        before = now
    seen[edge] = length
    if most >= least:
        _stretch(seen, along, least)
        _stretch(seen, along, most)
        _stretch(seen, across, side * nearest)
        _stretch(seen, across, side * farthest)
    return passed


@njit
def _common(start: float, stop: float, low: float, high: float) -> float:
    """Return how much the interval between `start` and `stop`, in whichever order, has in common with [low, high]."""
    return max(min(max(start, stop), high) - max(min(start, stop), low), 0.0)


@njit
def _rays(px: float, py: float, qx: float, qy: float, n: int) -> tuple[int, int]:
    """Return the first and last ray of the beams that meet a segment from p to q (sensor frame); both may exceed n."""
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
