"""Where shortest paths of a disc bend: points around the corners of walls and obstacles, and which see each other.

A disc rolls around a corner on an arc of its own radius. The arc is replaced by the sides of a regular polygon around
it, whose corners lie 3.5 % of a radius outside the arc; a right turn is 1 cm longer than the arc for a disc of 0.25 m.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.worlds.clearance import (
    TOUCH,
    Grid,
    Shapes,
    clearance_at,
    exact_clearance,
    rolls_straight,
    shapes_of,
)
from regionslam_env.worlds.heap import drop_first, lower
from regionslam_env.worlds.world import WALL_RADIUS, World
from slam.jit import Array, lean, njit
from slam.rows import Floats

SIDES = 12
"""Sides of the polygon that stands for the arc around a corner."""

TAUT = float(np.sin(np.pi / SIDES)) + 0.01
"""A path bends around a corner only if it leaves nearly tangentially: largest cosine with the corner's direction."""


class Corners(NamedTuple):
    """Bending points and the graph of those that see each other; edges of point k are ``first[k] : first[k + 1]``."""

    points: Floats  # (V, 2)
    first: NDArray[np.int64]  # (V + 1,)
    target: NDArray[np.int64]  # (E,)
    length: Floats  # (E,)


def corners_of(world: World, grid: Grid, radius: float) -> Corners:
    """Return the bending points for a disc in a world."""
    wall_ends = np.unique(np.round(world.walls.reshape(-1, 2), 6), axis=0)
    obstacle_corners = np.unique(np.round(world.obstacle_segments[:, :2], 6), axis=0)
    centres = np.concatenate([wall_ends, obstacle_corners])
    reach = np.repeat([radius + WALL_RADIUS, radius], [len(wall_ends), len(obstacle_corners)])
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    centres, reach = np.repeat(centres, SIDES, axis=0), np.repeat(reach, SIDES)
    points = centres + np.tile(circle, (len(centres) // SIDES, 1)) * (reach / np.cos(np.pi / SIDES))[:, None]
    shapes = shapes_of(world)
    free = np.zeros(len(points), np.bool_)
    _mark_free(points, grid, shapes, radius, free)
    points, centres = points[free], centres[free]
    capacity = 64 * len(points) + 64
    while True:
        pairs = np.empty((capacity, 2), np.int64)
        count = _seeing_pairs(points, centres, grid, pairs)
        if count <= capacity:
            break
        capacity = count
    both = np.concatenate([pairs[:count], pairs[:count, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    first = np.searchsorted(both[:, 0], np.arange(len(points) + 1)).astype(np.int64)
    length = np.hypot(*(points[both[:, 0]] - points[both[:, 1]]).T)
    return Corners(points, first, np.ascontiguousarray(both[:, 1]), length)


@njit
def _mark_free(points: Array, grid: Grid, shapes: Shapes, radius: float, free: Array) -> None:
    """Mark the points where a disc touches nothing; most of the others are told by the grid alone."""
    for k in range(len(points)):
        x, y = points[k, 0], points[k, 1]
        if clearance_at(grid, x, y) >= -2 * TOUCH:
            free[k] = exact_clearance(x, y, shapes, radius) > -1e-9


@lean
def _seeing_pairs(points: Array, centres: Array, grid: Grid, pairs: Array) -> int:
    """Write the pairs that see each other along a taut line; returns their number, also where `pairs` is too small."""
    count = 0
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            length = np.hypot(dx, dy)
            if length < 1e-9:
                continue
            taut = True
            for k in (i, j):
                rx, ry = points[k, 0] - centres[k, 0], points[k, 1] - centres[k, 1]
                taut = taut and abs(dx * rx + dy * ry) <= TAUT * length * np.hypot(rx, ry)
            if taut and rolls_straight(grid, points[i, 0], points[i, 1], points[j, 0], points[j, 1]):
                if count < len(pairs):
                    pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return count


@lean
def relax_corners(corners: Corners, distance: Array, towards: Array, heap: Array, place: Array) -> None:
    """Lower the distance of every corner to that through its neighbours (Dijkstra 1959).

    Parameters
    ----------
    distance
        Known bounds, (V,), infinite where none; shortest distances afterwards.
    towards
        Next corner on the way, (V,); written where a way through a neighbour is shorter.
    heap, place
        Room for a heap of V items; `place` filled with -1.
    """
    size = 0
    for v in range(len(distance)):
        if distance[v] < np.inf:
            size = lower(heap, place, distance, size, v)
    while size > 0:
        v = heap[0]
        size = drop_first(heap, place, distance, size)
        for e in range(corners.first[v], corners.first[v + 1]):
            w, through = corners.target[e], distance[v] + corners.length[e]
            if through < distance[w]:
                distance[w] = through
                towards[w] = v
                size = lower(heap, place, distance, size, w)
