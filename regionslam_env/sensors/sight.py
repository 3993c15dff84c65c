"""What is seen of one rectangle: how much of each edge, and the box around its visible part.

The view is a fan of beams, each between two neighbouring rays. A beam crosses an edge where both of its rays get that
far. Everything is computed relative to the sensor, along the rectangle's own axes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.geometry import ray_span
from slam.jit import lean

Floats = NDArray[np.float64]
Bounds = tuple[float, float, float, float]

TOP, BOTTOM, LEFT, RIGHT = 0, 1, 2, 3  # edges, in the order of EDGE_NAMES
BOX_U, BOX_V = 4, 6  # smallest and largest coordinate of the visible part along the first and the second axis
SIGHT = 8  # entries of a sight

_LOST, _STOPPED, _THROUGH = 0, 1, 2  # a ray ends before an edge, at a wall just before it, beyond it
_FEWEST_RAYS = 3  # into a rectangle, for it to be seen from outside
_ROUNDING = 1e-9
_LEEWAY = 1e-6  # around what is seen, m
_ON_THE_LINE = 1e-6  # an edge whose line runs through the sensor is not seen, m


@lean
def look(
    bounds: Bounds,
    axis: tuple[float, float],
    ends: Floats,
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
    ends, ranges
        Where the rays end, along the rectangle's axes (`turn_rays`), shape (2, n), and their lengths, shape (n,), m.
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
            entered += _look_at_edge(edge, bounds, axis, ends, ranges, reach, tolerance, seen)
    if inside:
        _look_around(bounds, ends, seen)


@lean
def turn_rays(axis: tuple[float, float], directions: Floats, ranges: Floats, ends: Floats) -> Bounds:
    """Write where rays of the sensor's frame end, along `axis` and across it, shape (2, n).

    Returns
    -------
    tuple
        The box around the sensor and these ends: left, right, bottom and top, m.
    """
    for i in range(ranges.shape[0]):
        ends[0, i] = ranges[i] * (axis[0] * directions[0, i] + axis[1] * directions[1, i])
        ends[1, i] = ranges[i] * (axis[0] * directions[1, i] - axis[1] * directions[0, i])
    left = right = bottom = top = 0.0
    for i in range(ranges.shape[0]):
        left, right = min(left, ends[0, i]), max(right, ends[0, i])
        bottom, top = min(bottom, ends[1, i]), max(top, ends[1, i])
    return left, right, bottom, top


@lean
def out_of_view(row: Any, at_u: float, at_v: float, box: Bounds) -> bool:
    """Return whether no rectangle of a row touches the box around all that is seen: then no ray gets into one.

    The sensor is at (at_u, at_v) of the row's frame; for the box see `turn_rays`.
    """
    left, right, bottom, top = box
    for i in range(row.n):
        if (
            row.u[i] - at_u <= right + _LEEWAY
            and row.u[i + 1] - at_u >= left - _LEEWAY
            and row.b[i] - at_v <= top + _LEEWAY
            and row.t[i] - at_v >= bottom - _LEEWAY
        ):
            return False
    return True


@lean
def _look_around(bounds: Bounds, ends: Floats, seen: Floats) -> None:
    """Widen the box by the sensor's place and the ends of all rays inside the rectangle."""
    left, right, bottom, top = bounds
    if seen[BOX_U] <= left and seen[BOX_U + 1] >= right and seen[BOX_V] <= bottom and seen[BOX_V + 1] >= top:
        return
    least_u = most_u = least_v = most_v = 0.0
    for i in range(ends.shape[1]):
        u, v = ends[0, i], ends[1, i]
        if left - _ROUNDING <= u <= right + _ROUNDING and bottom - _ROUNDING <= v <= top + _ROUNDING:
            least_u, most_u = min(least_u, u), max(most_u, u)
            least_v, most_v = min(least_v, v), max(most_v, v)
    _stretch(seen, BOX_U, least_u)
    _stretch(seen, BOX_U, most_u)
    _stretch(seen, BOX_V, least_v)
    _stretch(seen, BOX_V, most_v)


@lean
def _faces(edge: int, bounds: Bounds) -> bool:
    """Return whether the rectangle lies behind this edge, seen from the sensor."""
    left, right, bottom, top = bounds
    if edge == TOP:
        return top < 0
    if edge == BOTTOM:
        return bottom > 0
    return left > 0 if edge == LEFT else right < 0


@lean
def _look_at_edge(
    edge: int,
    bounds: Bounds,
    axis: tuple[float, float],
    ends: Floats,
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
        across, along, rises, slides = BOX_V, BOX_U, ends[1], ends[0]
        from_u, from_v, to_u, to_v = low, line, high, line
    else:
        line, far, low, high = (left, right, bottom, top) if edge == LEFT else (right, left, bottom, top)
        across, along, rises, slides = BOX_U, BOX_V, ends[0], ends[1]
        from_u, from_v, to_u, to_v = line, low, line, high
    side = 1.0 if line > 0 else -1.0
    distance, depth = line * side, far * side
    # A wall on the far edge is inside the rectangle, one on the near edge in front of it.
    through = distance + _ROUNDING if depth > distance else distance - _ROUNDING
    lowest = max(distance - tolerance, _ROUNDING)
    if distance < _ON_THE_LINE or distance > reach:
        return 0
    n = ranges.shape[0]
    first, last = _rays(from_u, from_v, to_u, to_v, axis, n)
    length, passed = 0.0, 0
    least, most, nearest, farthest = math.inf, -math.inf, math.inf, -math.inf  # of the box, along and across
    before, run_start, at_before, last_through = _LOST, 0.0, 0.0, 0
    for k in range(first, last + 2):  # one more than there are, to end the last run
        i = k if k < n else k - n
        rise = side * rises[i]
        now = _LOST
        if rise < lowest or k > last:
            if before == _LOST:
                continue
        elif rise >= through:
            now = _THROUGH
        elif 0 < ranges[i] < reach:
            now = _STOPPED
        if before == _THROUGH and now != _THROUGH:
            # Within a run of rays that get through, the first and the last one tell all.
            at_before = line * slides[last_through] / rises[last_through]
            seen_here = _common(run_start, at_before, low, high)
            if seen_here > 0:
                length += seen_here
                least = min(least, max(min(run_start, at_before), low))
                most = max(most, min(max(run_start, at_before), high))
                nearest, farthest = min(nearest, distance), max(farthest, distance)
        if now == _THROUGH:
            slide = slides[i]
            if before != _THROUGH:
                run_start = distance * slide / rise
                if before == _STOPPED:
                    length += _common(at_before, run_start, low, high)
            last_through = i
            if low * rise <= distance * slide <= high * rise:
                passed += 1
                if rise <= depth + _ROUNDING and low - _ROUNDING <= slide <= high + _ROUNDING:
                    least, most = min(least, slide), max(most, slide)
                    nearest, farthest = min(nearest, rise), max(farthest, rise)
        elif now == _STOPPED:
            if before != _LOST:
                length += _common(at_before, slides[i], low, high)
            at_before = slides[i]
        before = now
    seen[edge] = length
    if most >= least:
        _stretch(seen, along, least)
        _stretch(seen, along, most)
        _stretch(seen, across, side * nearest)
        _stretch(seen, across, side * farthest)
    return passed


@lean
def _common(start: float, stop: float, low: float, high: float) -> float:
    """Return how much the interval between `start` and `stop`, in whichever order, has in common with [low, high]."""
    return max(min(max(start, stop), high) - max(min(start, stop), low), 0.0)


@lean
def _rays(from_u: float, from_v: float, to_u: float, to_v: float, axis: tuple[float, float], n: int) -> tuple[int, int]:
    """Return the first and last ray of the beams that point at a segment along the given axes; both may exceed n."""
    cross = from_u * to_v - from_v * to_u
    if cross < 0:
        from_u, from_v, to_u, to_v, cross = to_u, to_v, from_u, from_v, -cross
    x, y = axis[0] * from_u - axis[1] * from_v, axis[1] * from_u + axis[0] * from_v
    start, end = ray_span(x, y, cross, from_u * to_u + from_v * to_v, n)
    return math.floor(start), math.ceil(end)


@lean
def _stretch(seen: Floats, entry: int, value: float) -> None:
    """Widen the interval seen[entry], seen[entry + 1] to a value."""
    seen[entry] = min(seen[entry], value)
    seen[entry + 1] = max(seen[entry + 1], value)
