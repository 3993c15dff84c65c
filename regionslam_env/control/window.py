"""What one lidar scan says about the robot's surroundings: obstacle points and a grid of driving costs.

The grid is square, centred on the robot and aligned with its heading: which ray passes a cell is known beforehand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slam.jit import njit

UNKNOWN_COST = 3.0
"""Extra cost of a cell that no ray has passed."""
PROXIMITY_COST = 6.0
"""Extra cost of a cell right beside what the robot must not touch; falls off with the square of the clearance."""
ESCAPE_COST = 30.0
"""Cost of a forbidden cell next to a robot that stands in one already."""


@dataclass(frozen=True)
class Window:
    """Geometry of the grid.

    Parameters
    ----------
    half
        Cells from the robot's cell to the border; the grid has ``2 half + 1`` rows (y, ascending) and columns (x).
    cell
        Edge of a cell, m.
    n_rays
        Rays of the lidar; ray k points at ``-pi + 2 pi k / n_rays`` from the robot's heading.
    """

    half: int = 40
    cell: float = 0.1
    n_rays: int = 180

    @property
    def size(self) -> int:
        """Cells along one side."""
        return 2 * self.half + 1

    @property
    def centre(self) -> int:
        """Flat index of the robot's cell."""
        return self.half * self.size + self.half

    def angles(self) -> NDArray[np.float64]:
        """Return the direction of every ray, shape (n_rays,), rad."""
        return -np.pi + 2 * np.pi * np.arange(self.n_rays) / self.n_rays

    def polar(self) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Return for every cell the ray just before it (clockwise) and its distance from the robot (m)."""
        along = (np.arange(self.size) - self.half) * self.cell
        x, y = np.meshgrid(along, along)
        ray = np.floor((np.arctan2(y, x) + np.pi) / (2 * np.pi) * self.n_rays).astype(np.int32) % self.n_rays
        return ray, np.hypot(x, y).astype(np.float32)


@njit
def obstacle_points(
    ranges: NDArray[np.float64],
    directions: NDArray[np.float64],
    max_range: float,
    gap: float,
    spacing: float,
    points: NDArray[np.float64],
) -> int:
    """Write where rays ended, and points between ends too close for the robot to pass; return their number.

    Parameters
    ----------
    ranges, directions
        Lidar ranges (m), shape (n,), and the unit vectors of the rays, shape (n, 2).
    max_range
        A ray of this length or more hit nothing within reach and is left out.
    gap
        Ends of neighbouring rays closer than this (m) are joined.
    spacing
        Distance of the points in between, m.
    points
        Written: x, y in the robot's frame, shape (capacity, 2), m. What exceeds the capacity is dropped.
    """
    n, count = len(ranges), 0
    for k in range(n):
        if not ranges[k] < max_range:
            continue
        x, y = ranges[k] * directions[k, 0], ranges[k] * directions[k, 1]
        following = (k + 1) % n
        pieces = 1
        x1, y1 = ranges[following] * directions[following, 0], ranges[following] * directions[following, 1]
        if ranges[following] < max_range:
            distance = math.hypot(x1 - x, y1 - y)
            if distance < gap:
                pieces = int(distance / spacing) + 1
        for piece in range(pieces):
            if count < len(points):
                points[count, 0] = x + (x1 - x) * piece / pieces
                points[count, 1] = y + (y1 - y) * piece / pieces
                count += 1
    return count


@njit
def driving_cost(
    ranges: NDArray[np.float64],
    points: NDArray[np.float64],
    ray: NDArray[np.int32],
    distance: NDArray[np.float32],
    cell: float,
    forbidden: float,
    comfortable: float,
    cost: NDArray[np.float32],
) -> None:
    """Write the cost of driving through every cell: 1 in the open, more near obstacles and unseen, inf too near.

    Parameters
    ----------
    ranges, points
        Lidar ranges (m) and obstacle points in the robot's frame, shape (k, 2), m.
    ray, distance, cell
        As `Window.polar` and `Window.cell`.
    forbidden, comfortable
        Clearance of the robot's centre (m) below which a cell is forbidden, and from which obstacles no longer matter.
    cost
        Written, shape (size, size).
    """
    size = cost.shape[0]
    half = size // 2
    reach = math.ceil(comfortable / cell)
    nearest = np.empty((size, size), np.float32)  # squared distance to the nearest point
    nearest[:] = comfortable * comfortable
    for k in range(len(points)):
        px, py = points[k, 0] / cell + half, points[k, 1] / cell + half
        column, row = math.floor(px + 0.5), math.floor(py + 0.5)
        for r in range(max(0, row - reach), min(size, row + reach + 1)):
            dy2 = (r - py) ** 2
            for c in range(max(0, column - reach), min(size, column + reach + 1)):
                squared = np.float32((dy2 + (c - px) ** 2) * cell * cell)
                if squared < nearest[r, c]:
                    nearest[r, c] = squared
    n = len(ranges)
    trapped = nearest[half, half] < forbidden * forbidden
    for r in range(size):
        for c in range(size):
            clearance = math.sqrt(nearest[r, c])
            if clearance < forbidden:
                close = trapped and abs(r - half) + abs(c - half) <= 5
                cost[r, c] = ESCAPE_COST * (2.0 - clearance / forbidden) if close else math.inf
                continue
            k = ray[r, c]
            seen = min(ranges[k], ranges[(k + 1) % n])
            short = (comfortable - clearance) / (comfortable - forbidden)
            cost[r, c] = 1.0 + PROXIMITY_COST * short * short + (UNKNOWN_COST if distance[r, c] > seen else 0.0)
