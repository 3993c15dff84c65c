"""Rays among segments, and the lists of what lies within reach of a place.

Rays start at the sensor, evenly over a full turn, counter-clockwise: the first one looks straight back (-pi), the
middle one of an even number straight ahead.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slam.jit import njit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_COLLINEAR = 1e-9  # below this cross product (m²) a segment is seen end on
_ROUNDING = 1e-9  # of a ray's index


def ray_angles(count: int) -> Floats:
    """Return the angles of `count` rays in the sensor's frame, rad, ascending from -pi."""
    return np.arange(count, dtype=np.float64) * (2 * math.pi / count) - math.pi


def ray_directions(count: int) -> Floats:
    """Return the unit vectors of `count` rays in the sensor's frame, shape (2, count)."""
    angles = ray_angles(count)
    return np.ascontiguousarray([np.cos(angles), np.sin(angles)])


@njit
def cast(
    x: float,
    y: float,
    theta: float,
    reach: float,
    directions: Floats,
    segments: Floats,
    nearby: Ints,
    ranges: Floats,
) -> None:
    """Write the distance to the nearest segment along every ray.

    An angular z-buffer: each segment visits only the rays it subtends. Along a ray with direction d, a segment from p
    to q lies at 1 / (d · m) with a vector m of its own, so the buffer holds inverse distances, one division a ray.

    Parameters
    ----------
    x, y, theta
        Pose of the sensor in the frame of the segments (m, rad).
    reach
        Longest distance, m: written where a ray meets nothing.
    directions
        `ray_directions`, shape (2, n).
    segments
        x0, y0, x1, y1, shape (S, 4), m.
    nearby
        Indices of the segments to look at, shape (k,).
    ranges
        Distances, shape (n,), m; overwritten.
    """
    n = ranges.shape[0]
    per_radian = n / (2 * math.pi)
    c, s = math.cos(theta), math.sin(theta)
    ranges[:] = 1 / reach
    for j in nearby:
        dx, dy = segments[j, 0] - x, segments[j, 1] - y
        px, py = c * dx + s * dy, c * dy - s * dx
        dx, dy = segments[j, 2] - x, segments[j, 3] - y
        qx, qy = c * dx + s * dy, c * dy - s * dx
        cross = px * qy - py * qx
        if cross < 0:
            px, py, qx, qy, cross = qx, qy, px, py, -cross
        ex, ey = qx - px, qy - py
        if _out_of_reach(px, py, qx, qy, cross, reach):
            continue
        start = (math.atan2(py, px) + math.pi) * per_radian
        end = start + math.atan2(cross, px * qx + py * qy) * per_radian
        if cross < _COLLINEAR:
            # End on: one point, if a ray meets it exactly.
            nearest = math.sqrt(min(px * px + py * py, qx * qx + qy * qy))
            k = round(start)
            if abs(start - k) < _ROUNDING and nearest > 0:
                ranges[k % n] = max(ranges[k % n], 1 / nearest)
            continue
        mx, my = ey / cross, -ex / cross
        first, last = math.ceil(start - _ROUNDING), math.floor(end + _ROUNDING)
        for k in range(first, min(last, n - 1) + 1):
            ranges[k] = max(ranges[k], directions[0, k] * mx + directions[1, k] * my)
        for k in range(max(first - n, 0), last - n + 1):
            ranges[k] = max(ranges[k], directions[0, k] * mx + directions[1, k] * my)
    for k in range(n):
        ranges[k] = 1 / ranges[k]


@njit
def _out_of_reach(px: float, py: float, qx: float, qy: float, cross: float, reach: float) -> bool:
    """Return whether the segment from p to q, with p x q >= 0, is farther than `reach` from the origin."""
    ex, ey = qx - px, qy - py
    if cross * cross > reach * reach * (ex * ex + ey * ey):
        return True
    if px * ex + py * ey >= 0:
        return px * px + py * py > reach * reach
    if qx * ex + qy * ey <= 0:
        return qx * qx + qy * qy > reach * reach
    return False


class NearbyIndex:
    """For every cell of a grid, which boxes come within a reach of it.

    Parameters
    ----------
    boxes
        Smallest x and y, largest x and y of each thing, shape (k, 4), m.
    reach
        Distance, m.
    cell
        Side of a cell, m.
    """

    def __init__(self, boxes: Floats, reach: float, cell: float = 4.0) -> None:
        boxes = np.asarray(boxes, dtype=np.float64).reshape(-1, 4)
        self._all = np.arange(len(boxes))
        low = boxes[:, :2].min(axis=0) if len(boxes) else np.zeros(2)
        high = boxes[:, 2:].max(axis=0) if len(boxes) else np.zeros(2)
        self._x, self._y = float(low[0]), float(low[1])
        # A floor of kilometres takes larger cells, not more of them.
        self._cell = max(cell, float(np.max(high - low)) / 256)
        self._columns, self._rows = (int(k) + 1 for k in (high - low) // self._cell)
        self._lists: list[Ints | None] = [None] * (self._columns * self._rows)
        self._boxes, self._reach = boxes, reach

    def near(self, x: float, y: float) -> Ints:
        """Return, ascending, the indices of all things within reach of a point, and of some more."""
        column, row = math.floor((x - self._x) / self._cell), math.floor((y - self._y) / self._cell)
        if not (0 <= column < self._columns and 0 <= row < self._rows):
            return self._all
        place = row * self._columns + column
        found = self._lists[place]
        if found is None:
            found = self._lists[place] = self._search(column, row)
        return found

    def _search(self, column: int, row: int) -> Ints:
        x, y = self._x + column * self._cell, self._y + row * self._cell
        boxes, cell = self._boxes, self._cell
        gap_x = np.maximum(np.maximum(boxes[:, 0] - (x + cell), x - boxes[:, 2]), 0)
        gap_y = np.maximum(np.maximum(boxes[:, 1] - (y + cell), y - boxes[:, 3]), 0)
        return np.nonzero(np.hypot(gap_x, gap_y) <= self._reach + 1e-9)[0]


def segment_boxes(segments: Floats) -> Floats:
    """Return the boxes around segments, shape (S, 4), for `NearbyIndex`."""
    x, y = segments[:, 0::2], segments[:, 1::2]
    return np.stack([x.min(axis=1), y.min(axis=1), x.max(axis=1), y.max(axis=1)], axis=1)
