"""The floor seen so far: free, occupied or unseen cells in the map frame, drawn from lidar and believed poses.

Where newer scans contradict older ones (the believed pose moves), the newer ones win within a few scans.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from regionslam_env.control.search import search, trace
from slam.jit import njit
from slam.rows import Floats, Row

UNSEEN = -128
"""Score of a cell no ray has passed; other cells are free up to a score of 0 and occupied above."""
FIRM = 6
"""Largest score, and the number of clear views that free an occupied cell."""


class Terrain:
    """Seen floor and ways over it.

    Parameters
    ----------
    n_rays, max_range
        Rays of the lidar (the first one looks straight back) and their reach, m.
    sight
        Distance up to which floor counts as seen (m): what the region sensor sees for certain.
    touch
        Distance of the robot's centre from an obstacle at which they touch, m.
    cell
        Edge of a cell, m.

    Attributes
    ----------
    scores : ndarray
        Score of every cell within reach of the places the robot has been at, shape (rows, columns).
    labels : ndarray
        What the floor of every cell was last believed to belong to, see `paint`; 0: nothing. Same shape.
    origin : ndarray
        Centre of cell (0, 0), x and y in the map frame, m.
    """

    scores: NDArray[np.int8]
    labels: NDArray[np.int16]
    origin: Floats

    def __init__(self, n_rays: int, max_range: float, sight: float, touch: float, cell: float = 0.1) -> None:
        self.max_range, self.sight, self.touch, self.cell = max_range, sight, touch, cell
        self._angles = -np.pi + 2 * np.pi * np.arange(n_rays) / n_rays
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        size = 2 * int(15 / self.cell) + 1
        self._grid = np.full((size, size), UNSEEN, np.int8)
        self._label_grid = np.zeros((size, size), np.int16)
        self._area_grid = np.zeros((size, size), np.float32)
        self._grid_origin = np.full(2, -(size // 2) * self.cell)
        self._low, self._high = np.full(2, np.inf), np.full(2, -np.inf)
        self._costs: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None  # until the next scan

    def insert(self, pose: Floats, ranges: ArrayLike) -> None:
        """Enter one scan taken at a pose (x, y, theta)."""
        self._grow(pose[:2])
        scan = np.asarray(ranges, dtype=np.float64)
        draw_scan(self._grid, self._grid_origin, self.cell, pose, self._angles, scan, self.sight, self.max_range - 0.1)
        self._crop(pose[:2])
        self._costs = None

    def paint(self, row: Row, label: int) -> None:
        """Label the floor within a row of rectangles (map frame), but for what belongs to a smaller row."""
        grids = self.labels, self._areas, self.origin, self.cell
        paint_row(*grids, row.x, row.y, row.phi, row.u, row.b, row.t, label, row.area)

    def index(self, point: ArrayLike) -> tuple[int, int]:
        """Return row and column of the cell at a point (map frame), within the grid."""
        column, row = np.rint((np.asarray(point) - self.origin) / self.cell).astype(int)
        return min(max(int(row), 0), self.scores.shape[0] - 1), min(max(int(column), 0), self.scores.shape[1] - 1)

    def points(self, cells: NDArray[np.int64]) -> Floats:
        """Return the map-frame centres of cells given as (row, column), shape (k, 2)."""
        return np.asarray(cells)[:, ::-1] * self.cell + self.origin

    def seen(self, point: ArrayLike) -> bool:
        """Tell whether the floor at a point has been seen."""
        return bool(self.scores[self.index(point)] != UNSEEN)

    def costs(self, start: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the cost of driving through every cell (inf: unseen or too near an obstacle) and the clearance (m)."""
        if self._costs is None:
            self._costs = driving_costs(self.scores, self.cell, self.touch - 0.05, self.touch + 0.4)
        cost, clearance = self._costs[0].copy(), self._costs[1]
        row, column = self.index(start)
        around = cost[max(0, row - 3) : row + 4, max(0, column - 3) : column + 4]
        around[~np.isfinite(around)] = 20.0  # wherever the robot is, it can leave
        return cost, clearance

    def route(self, start: ArrayLike, target: ArrayLike) -> Floats:
        """Return the way over seen floor from a point towards another, shape (k, 2), map frame."""
        cost, _ = self.costs(start)
        row, column = self.index(target)
        end, _, parent = self._search(cost, start, float(column), float(row))
        return self.points(trace(parent, end))

    def distances(self, start: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the cost (m) of the way to every cell, inf where there is none, and the clearances."""
        cost, clearance = self.costs(start)
        _, reach, _ = self._search(cost, start, np.nan, np.nan)
        return reach * np.float32(self.cell), clearance

    def _search(
        self, cost: NDArray[np.float32], start: ArrayLike, column: float, row: float
    ) -> tuple[int, NDArray[np.float32], NDArray[np.int32]]:
        r, c = self.index(start)
        reach, parent = np.empty(cost.shape, np.float32), np.empty(cost.shape, np.int32)
        return search(cost, r * cost.shape[1] + c, column, row, reach, parent), reach, parent

    def _crop(self, position: Floats) -> None:
        """Widen what has been looked at so far by the reach around a position."""
        self._low = np.minimum(self._low, position - self.max_range - 0.2)
        self._high = np.maximum(self._high, position + self.max_range + 0.2)
        c0, r0 = np.rint((self._low - self._grid_origin) / self.cell).astype(int)
        c1, r1 = np.rint((self._high - self._grid_origin) / self.cell).astype(int)
        self.scores = self._grid[r0 : r1 + 1, c0 : c1 + 1]
        self.labels = self._label_grid[r0 : r1 + 1, c0 : c1 + 1]
        self._areas = self._area_grid[r0 : r1 + 1, c0 : c1 + 1]
        self.origin = self._grid_origin + np.array([c0, r0]) * self.cell

    def _grow(self, position: Floats) -> None:
        """Widen the grid so that a scan at a position fits in."""
        need = self.max_range + 1.0
        last = self._grid_origin + (np.array(self._grid.shape[::-1]) - 1) * self.cell
        low = np.where(position - need < self._grid_origin, int(15 / self.cell), 0)
        high = np.where(position + need > last, int(15 / self.cell), 0)
        if low.any() or high.any():
            pads = ((low[1], high[1]), (low[0], high[0]))
            self._grid = np.pad(self._grid, pads, constant_values=UNSEEN)
            self._label_grid, self._area_grid = np.pad(self._label_grid, pads), np.pad(self._area_grid, pads)
            self._grid_origin = self._grid_origin - low * self.cell
            self._grow(position)


@njit
def draw_scan(
    scores: NDArray[np.int8],
    origin: NDArray[np.float64],
    cell: float,
    pose: NDArray[np.float64],
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    sight: float,
    max_range: float,
) -> None:
    """Lower the scores of cells that rays passed within sight, and raise those where rays ended.

    Between neighbouring rays, whose ends drift apart, further ones are taken to be as long as the shorter of the two.

    Parameters
    ----------
    scores
        Changed in place.
    origin, cell
        Centre of cell (0, 0) in the map frame and the edge of a cell, m.
    pose
        Of the lidar, (x, y, theta) in the map frame.
    angles, ranges
        Of the rays, in the robot's frame, shape (n,).
    sight
        Floor beyond this distance (m) counts as unseen.
    max_range
        Rays of this length or more hit nothing.
    """
    n = len(angles)
    ends = np.empty((n, 2))
    for k in range(n):
        angle = pose[2] + angles[k]
        ends[k, 0], ends[k, 1] = pose[0] + ranges[k] * math.cos(angle), pose[1] + ranges[k] * math.sin(angle)
    clear = np.empty(n)
    for k in range(n):
        clear[k] = min(sight, ranges[k] - _margin(ends, pose, ranges, k, max_range))
    between, width = 3, 2 * math.pi / n
    for k in range(n):
        for s in range(between):
            length = clear[k] if s == 0 else min(clear[k], clear[(k + 1) % n])
            angle = pose[2] + angles[k] + width * s / between
            dx, dy = math.cos(angle), math.sin(angle)
            distance = 0.0 if s == 0 else 0.7 * cell / width
            while distance < length:
                r = math.floor((pose[1] + distance * dy - origin[1]) / cell + 0.5)
                c = math.floor((pose[0] + distance * dx - origin[0]) / cell + 0.5)
                score = scores[r, c]
                scores[r, c] = 0 if score == UNSEEN else max(score - 1, -FIRM)
                distance += 0.7 * cell  # more would jump over corners of cells
    for k in range(n):
        if ranges[k] >= max_range:
            continue
        following = (k + 1) % n
        across, up = ends[following, 0] - ends[k, 0], ends[following, 1] - ends[k, 1]
        gap = math.hypot(across, up)
        pieces = int(gap / cell) + 1 if gap < 0.4 and ranges[following] < max_range else 1
        for piece in range(pieces):
            r = math.floor((ends[k, 1] + up * piece / pieces - origin[1]) / cell + 0.5)
            c = math.floor((ends[k, 0] + across * piece / pieces - origin[0]) / cell + 0.5)
            scores[r, c] = min(max(scores[r, c], 0) + 4, FIRM)


@njit
def _margin(
    ends: NDArray[np.float64],
    pose: NDArray[np.float64],
    ranges: NDArray[np.float64],
    k: int,
    max_range: float,
) -> float:
    """Return how far before its end (m) a ray comes within 0.12 m of the surface that it hits.

    A ray that grazes a wall runs along it for long: what it passes there is not free. The surface's direction is taken
    from the ends of the rays next but one, on the side where it is the more frontal.
    """
    n = len(ranges)
    sine, lonely = 0.0, True  # of the angle between ray and surface
    if ranges[k] >= max_range:
        return 0.15
    for side in (-2, 2):
        other = (k + side + n) % n
        if ranges[other] < max_range:
            x, y = ends[other, 0] - ends[k, 0], ends[other, 1] - ends[k, 1]
            cross = (ends[k, 0] - pose[0]) * y - (ends[k, 1] - pose[1]) * x
            sine, lonely = max(sine, abs(cross) / max(1e-9, ranges[k] * math.hypot(x, y))), False
    if lonely:
        return 0.15
    return min(3.0, max(0.15, 0.12 / max(1e-9, sine)))


@njit
def paint_row(
    labels: NDArray[np.int16],
    areas: NDArray[np.float32],
    origin: NDArray[np.float64],
    cell: float,
    x: float,
    y: float,
    phi: float,
    u: NDArray[np.float64],
    b: NDArray[np.float64],
    t: NDArray[np.float64],
    label: int,
    area: float,
) -> None:
    """Write a label into the cells in a row of rectangles, given as in `slam.rows.Row`, and its area (m²) into `areas`.

    Cells that belong to a row of another label, and clearly less area, keep it.
    """
    cosine, sine = math.cos(phi), math.sin(phi)
    for i in range(len(b)):
        along, across = (u[i] + u[i + 1]) / 2, (b[i] + t[i]) / 2
        half_u, half_v = (u[i + 1] - u[i]) / 2, (t[i] - b[i]) / 2
        column = (x + cosine * along - sine * across - origin[0]) / cell
        row = (y + sine * along + cosine * across - origin[1]) / cell
        wide = (abs(cosine) * half_u + abs(sine) * half_v) / cell
        high = (abs(sine) * half_u + abs(cosine) * half_v) / cell
        for r in range(max(0, int(row - high)), min(labels.shape[0], int(row + high) + 2)):
            for c in range(max(0, int(column - wide)), min(labels.shape[1], int(column + wide) + 2)):
                dx, dy = (c - column) * cell, (r - row) * cell
                if abs(cosine * dx + sine * dy) > half_u or abs(cosine * dy - sine * dx) > half_v:
                    continue
                if labels[r, c] == 0 or (labels[r, c] + 1) // 2 == (label + 1) // 2 or area < 1.3 * areas[r, c]:
                    labels[r, c], areas[r, c] = label, area


@njit
def driving_costs(
    scores: NDArray[np.int8], cell: float, forbidden: float, comfortable: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the cost of driving through every cell and its clearance.

    Parameters
    ----------
    scores, cell
        The grid and the edge of its cells, m.
    forbidden, comfortable
        Clearance (m) below which a cell is forbidden, and from which obstacles no longer matter.

    Returns
    -------
    cost, clearance
        1 in the open, up to 5 near obstacles, inf too near or unseen; distance to the nearest occupied cell, m.
    """
    clearance = clearances(scores)
    cost = np.empty_like(clearance)
    for r in range(scores.shape[0]):
        for c in range(scores.shape[1]):
            clearance[r, c] *= np.float32(cell)
            short = max(0.0, (comfortable - clearance[r, c]) / (comfortable - forbidden))
            closed = scores[r, c] == UNSEEN or clearance[r, c] < forbidden
            cost[r, c] = math.inf if closed else 1.0 + 4.0 * short * short
    return cost, clearance


@njit
def clearances(scores: NDArray[np.int8]) -> NDArray[np.float32]:
    """Return each cell's distance to the nearest occupied cell, in cells (3 x 3 chamfer, within 4 %)."""
    rows, columns = scores.shape
    out = np.empty((rows, columns), np.float32)
    for r in range(rows):
        for c in range(columns):
            if scores[r, c] > 0:
                out[r, c] = 0.0
                continue
            best = np.float32(1e6)
            if r > 0:
                best = min(best, out[r - 1, c] + np.float32(0.96))
                if c > 0:
                    best = min(best, out[r - 1, c - 1] + np.float32(1.36))
                if c + 1 < columns:
                    best = min(best, out[r - 1, c + 1] + np.float32(1.36))
            if c > 0:
                best = min(best, out[r, c - 1] + np.float32(0.96))
            out[r, c] = best
    for r in range(rows - 1, -1, -1):
        for c in range(columns - 1, -1, -1):
            best = out[r, c]
            if r + 1 < rows:
                best = min(best, out[r + 1, c] + np.float32(0.96))
                if c > 0:
                    best = min(best, out[r + 1, c - 1] + np.float32(1.36))
                if c + 1 < columns:
                    best = min(best, out[r + 1, c + 1] + np.float32(1.36))
            if c + 1 < columns:
                best = min(best, out[r, c + 1] + np.float32(0.96))
            out[r, c] = best
    return out
