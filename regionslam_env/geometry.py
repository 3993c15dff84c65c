"""Rays among segments, and the lists of what lies within reach of a place.

Rays start at the sensor, evenly over a full turn, counter-clockwise: the first one looks straight back (-pi), the
middle one of an even number straight ahead.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slam.jit import lean, njit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_COLLINEAR = 1e-9  # below this cross product (m²) a segment is seen end on
_ROUNDING = 1e-9  # of a ray's index
_ARCTAN = 3e-5  # more than two of `_angle` are wrong by together, rad
_LEEWAY = 1e-9  # added to the reach of lists, m


def ray_angles(count: int) -> Floats:
    """Return the angles of `count` rays in the sensor's frame, rad, ascending from -pi."""
    return np.arange(count, dtype=np.float64) * (2 * math.pi / count) - math.pi


def ray_directions(count: int) -> Floats:
    """Return the unit vectors of `count` rays in the sensor's frame, shape (2, count)."""
    angles = ray_angles(count)
    return np.ascontiguousarray([np.cos(angles), np.sin(angles)])


@lean
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
        start, end = ray_span(px, py, cross, px * qx + py * qy, n)
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


@lean
def ray_span(x: float, y: float, cross: float, dot: float, n: int) -> tuple[float, float]:
    """Return between which of `n` rays an angle lies, as fractions of indices; the second may exceed n.

    Two arctangents are most of the work of a short segment. Between two rays it is enough to know which ones, so that
    only what lies close to a ray is computed to the last digit.

    Parameters
    ----------
    x, y
        Where the angle starts, in the frame of the rays, m.
    cross, dot
        Products of the directions where it starts and ends, m²; `cross` is not negative.
    n
        Number of rays.
    """
    per_radian = n / (2 * math.pi)
    start = (_angle(x, y) + math.pi) * per_radian
    end = start + _angle(dot, cross) * per_radian
    close = _ARCTAN * per_radian
    if abs(start - math.floor(start + 0.5)) < close or abs(end - math.floor(end + 0.5)) < close:
        start = (math.atan2(y, x) + math.pi) * per_radian
        end = start + math.atan2(cross, dot) * per_radian
    return start, end


@lean
def _angle(x: float, y: float) -> float:
    """Return the angle of a direction, wrong by 1.2e-5 rad at most (Abramowitz and Stegun 1964, 4.4.47)."""
    least, most = min(abs(x), abs(y)), max(abs(x), abs(y))
    t = least / most if most > 0 else 0.0
    q = t * t
    angle = t * (0.9998660 + q * (-0.3302995 + q * (0.1801410 + q * (-0.0851330 + q * 0.0208351))))
    if abs(y) > abs(x):
        angle = math.pi / 2 - angle
    if x < 0:
        angle = math.pi - angle
    return -angle if y < 0 else angle


@lean
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

    Attributes
    ----------
    cells
        Lists of the things near each cell, row by row of cells, then of all things, for places outside; as kernels take
        them: lowest corner x, y (m), side of a cell (m), columns and rows; where each list begins in the third array
        (columns * rows + 2,), so that list k is ``things[first[k] : first[k + 1]]``; the indices of all lists.
    """

    def __init__(self, boxes: Floats, reach: float, cell: float = 4.0) -> None:
        boxes = np.asarray(boxes, dtype=np.float64).reshape(-1, 4)
        low = boxes[:, :2].min(axis=0) if len(boxes) else np.zeros(2)
        high = boxes[:, 2:].max(axis=0) if len(boxes) else np.zeros(2)
        # A floor of kilometres takes larger cells, not more of them.
        cell = max(cell, float(np.max(high - low)) / 256)
        columns, rows = (int(k) + 1 for k in (high - low) // cell)
        frame = np.array([*low, cell, columns, rows])
        first = np.zeros(columns * rows + 2, np.int64)
        list_cells(boxes, reach, frame, first, np.zeros(0, np.int64))
        np.cumsum(first, out=first)
        things = np.empty(first[-1], np.int64)
        list_cells(boxes, reach, frame, first, things)
        self.cells: tuple[Floats, Ints, Ints] = (frame, first, things)

    def near(self, x: float, y: float) -> Ints:
        """Return, ascending, the indices of all things within reach of a point, and of some more."""
        first, last = list_of(self.cells, x, y)
        return self.cells[2][first:last]


@lean
def list_of(cells: tuple[Floats, Ints, Ints], x: float, y: float) -> tuple[int, int]:
    """Return where the list for a point begins and ends (`NearbyIndex.cells`)."""
    frame, first, _ = cells
    columns, rows = int(frame[3]), int(frame[4])
    column, row = math.floor((x - frame[0]) / frame[2]), math.floor((y - frame[1]) / frame[2])
    inside = 0 <= column < columns and 0 <= row < rows
    place = int(row) * columns + int(column) if inside else columns * rows
    return first[place], first[place + 1]


@njit
def list_cells(boxes: Floats, reach: float, frame: Floats, first: Ints, things: Ints) -> None:
    """List the boxes within reach of every cell.

    Without room in `things`, count those of list k in `first[k + 1]`; then, with `first` their sums, write the lists.
    """
    cell, columns, rows = frame[2], int(frame[3]), int(frame[4])
    counting, end, limit = len(things) == 0, first[:-1].copy(), reach + _LEEWAY
    for k in range(len(boxes)):
        x0, y0, x1, y1 = boxes[k, 0] - frame[0], boxes[k, 1] - frame[1], boxes[k, 2] - frame[0], boxes[k, 3] - frame[1]
        for row in range(max(0, math.floor((y0 - limit) / cell)), min(rows, math.floor((y1 + limit) / cell) + 1)):
            gap_y = max(y0 - (row + 1) * cell, row * cell - y1, 0.0)
            for column in range(
                max(0, math.floor((x0 - limit) / cell)), min(columns, math.floor((x1 + limit) / cell) + 1)
            ):
                gap_x = max(x0 - (column + 1) * cell, column * cell - x1, 0.0)
                if gap_x * gap_x + gap_y * gap_y <= limit * limit:
                    _enlist(row * columns + column, k, counting, first, end, things)
        _enlist(rows * columns, k, counting, first, end, things)


@njit
def _enlist(place: int, thing: int, counting: bool, first: Ints, end: Ints, things: Ints) -> None:
    if counting:
        first[place + 1] += 1
    else:
        things[end[place]] = thing
        end[place] += 1


def segment_boxes(segments: Floats) -> Floats:
    """Return the boxes around segments, shape (S, 4), for `NearbyIndex`."""
    x, y = segments[:, 0::2], segments[:, 1::2]
    return np.stack([x.min(axis=1), y.min(axis=1), x.max(axis=1), y.max(axis=1)], axis=1)
