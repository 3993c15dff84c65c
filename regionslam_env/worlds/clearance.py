"""How far a disc is from touching anything, at points and on a grid, and whether it can roll straight from A to B.

Clearance (m) is the distance of the disc's centre from the nearest wall or obstacle less the disc's radius, and less
half the thickness of a wall; negative where the disc would overlap it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.worlds.world import WALL_RADIUS, World
from slam.jit import Array, lean, njit
from slam.rows import Floats

CAP = 1.0
"""Clearances above this (m) are not told apart on the grid."""

TOUCH = 0.02
"""Overlap (m) that still counts as touching: the grid's interpolation is that exact."""


class Grid(NamedTuple):
    """Clearance on grid nodes: node (i, j) stands at (x0 + i step, y0 + j step)."""

    x0: float
    y0: float
    step: float
    clearance: Floats  # (nx, ny), m


class Shapes(NamedTuple):
    """What a disc can touch: walls (W, 4), sides of convex obstacles (O, 4), first side of each obstacle (P + 1,)."""

    walls: Floats
    sides: Floats
    first: NDArray[np.int64]


def shapes_of(world: World) -> Shapes:
    """Return what a disc can touch in a world."""
    first = np.cumsum([0, *(len(o) for o in world.obstacles)]).astype(np.int64)
    return Shapes(world.walls, world.obstacle_segments, first)


def clearance_grid(world: World, radius: float, step: float, margin: float) -> Grid:
    """Return the clearance of a disc on a grid over the world's bounds and a margin, m."""
    x0, y0, x1, y1 = world.bounds
    x0, y0 = x0 - margin, y0 - margin
    nx, ny = (int(np.ceil((high + margin - low) / step)) + 1 for low, high in ((x0, x1), (y0, y1)))
    clearance = np.full((nx, ny), CAP)
    fill_clearance(x0, y0, step, clearance, shapes_of(world), radius)
    return Grid(x0, y0, step, clearance)


@njit
def segment_distance(x: float, y: float, s: Array) -> float:
    """Return the distance of a point from the segment s = (x0, y0, x1, y1)."""
    dx, dy = s[2] - s[0], s[3] - s[1]
    along = (x - s[0]) * dx + (y - s[1]) * dy
    length2 = dx * dx + dy * dy
    f = min(max(along / length2, 0.0), 1.0) if length2 > 0 else 0.0
    return float(np.hypot(x - s[0] - f * dx, y - s[1] - f * dy))


@njit
def polygon_distance(x: float, y: float, sides: Array, begin: int, end: int) -> float:
    """Return the distance of a point from a convex counter-clockwise polygon, negative inside."""
    nearest, inside = np.inf, True
    for k in range(begin, end):
        s = sides[k]
        nearest = min(nearest, segment_distance(x, y, s))
        inside = inside and (s[2] - s[0]) * (y - s[1]) - (s[3] - s[1]) * (x - s[0]) >= 0
    return -nearest if inside else nearest


@njit
def exact_clearance(x: float, y: float, shapes: Shapes, radius: float) -> float:
    """Return the clearance of a disc at a point; infinite in an empty world."""
    nearest = np.inf
    for k in range(len(shapes.walls)):
        nearest = min(nearest, segment_distance(x, y, shapes.walls[k]) - WALL_RADIUS)
    for p in range(len(shapes.first) - 1):
        nearest = min(nearest, polygon_distance(x, y, shapes.sides, shapes.first[p], shapes.first[p + 1]))
    return nearest - radius


@njit
def fill_clearance(x0: float, y0: float, step: float, out: Array, shapes: Shapes, radius: float) -> None:
    """Lower every node of `out` to its clearance; each shape touches only the nodes near it."""
    reach = CAP + radius + WALL_RADIUS
    n_walls = len(shapes.walls)
    for k in range(n_walls + len(shapes.first) - 1):
        if k < n_walls:
            corners, begin, end = shapes.walls, k, k + 1
        else:
            corners, begin, end = shapes.sides, shapes.first[k - n_walls], shapes.first[k - n_walls + 1]
        lx, ly, hx, hy = np.inf, np.inf, -np.inf, -np.inf
        for s in range(begin, end):
            lx, hx = min(lx, corners[s, 0], corners[s, 2]), max(hx, corners[s, 0], corners[s, 2])
            ly, hy = min(ly, corners[s, 1], corners[s, 3]), max(hy, corners[s, 1], corners[s, 3])
        for i in range(max(0, int((lx - reach - x0) / step)), min(out.shape[0], int((hx + reach - x0) / step) + 2)):
            for j in range(max(0, int((ly - reach - y0) / step)), min(out.shape[1], int((hy + reach - y0) / step) + 2)):
                x, y = x0 + i * step, y0 + j * step
                if k < n_walls:
                    distance = segment_distance(x, y, corners[k]) - WALL_RADIUS
                else:
                    distance = polygon_distance(x, y, corners, begin, end)
                out[i, j] = min(out[i, j], distance - radius)


@lean
def clearance_at(grid: Grid, x: float, y: float) -> float:
    """Return the clearance at a point, between grid nodes bilinear; -1 beyond the grid."""
    u, v = (x - grid.x0) / grid.step, (y - grid.y0) / grid.step
    i, j = int(np.floor(u)), int(np.floor(v))
    if i < 0 or j < 0 or i + 1 >= grid.clearance.shape[0] or j + 1 >= grid.clearance.shape[1]:
        return -1.0
    u, v, c = u - i, v - j, grid.clearance
    low = (1 - v) * c[i, j] + v * c[i, j + 1]
    return float((1 - u) * low + u * ((1 - v) * c[i + 1, j] + v * c[i + 1, j + 1]))


@lean
def rolls_straight(grid: Grid, x: float, y: float, to_x: float, to_y: float) -> bool:
    """Return whether the disc can move straight between two points, in strides of the clearance found on the way."""
    length = np.hypot(to_x - x, to_y - y)
    done = 0.0
    while True:
        f = done / length if length > 0 else 0.0
        c = clearance_at(grid, x + f * (to_x - x), y + f * (to_y - y))
        if c < -TOUCH:
            return False
        if done >= length:
            return True
        done = min(done + max(c, grid.step), length)
