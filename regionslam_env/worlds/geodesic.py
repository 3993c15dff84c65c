"""Shortest distances of a disc to a region, any-angle: what SPL, starts and rewards are measured with.

A shortest path is straight but for bends at the corners of walls and furniture. Every grid node of a field therefore
stores no distance but the *root* of its last straight piece (a corner, or the goal itself), and a query is exact for the root:
its distance plus the straight line to it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.clearance import Grid, clearance_grid, exact_clearance, rolls_straight, shapes_of
from regionslam_env.worlds.corners import Corners, corners_of, relax_corners
from regionslam_env.worlds.heap import drop_first, push
from regionslam_env.worlds.world import World
from slam.jit import njit
from slam.rows import Floats

STEP = 0.15
"""Distance of grid nodes, m."""

MARGIN = 0.5
"""Extent of the grid beyond the world, m."""


class Roots(NamedTuple):
    """Everything a query needs: roots 0 .. V-1 are corners, V .. V+G-1 rectangles of the goal."""

    grid: Grid
    points: Floats  # (V, 2) corners
    distance: Floats  # (V,) from the corner to the goal
    goals: Floats  # (G, 8) rectangles: x, y, cos, sin of the row's frame, then u0, u1, b, t
    first: NDArray[np.int64]  # (V + 2,) corners whose next is corner k are behind[first[k + 1] : first[k + 2]]
    behind: NDArray[np.int64]  # (V,) corners by their next one; first those that see the goal (k = -1)
    root: NDArray[np.int32]  # (nx, ny), -1 where the goal cannot be reached
    value: Floats  # (nx, ny) distance at the node


@dataclass(frozen=True, eq=False)
class Field:
    """Distance to the nearest of some regions, everywhere.

    Parameters
    ----------
    goals
        Indices of the regions in `World.regions`.
    roots
        The field itself.
    towards
        Next corner of each corner on its way to the goal, -1 where the goal is next.
    """

    goals: tuple[int, ...]
    roots: Roots
    towards: NDArray[np.int64]

    def at(self, x: float, y: float) -> float:
        """Return the distance (m) from a point until the centre is inside a goal region; infinite if it cannot be."""
        return float(query(self.roots, x, y)[0])

    def path(self, x: float, y: float) -> Floats:
        """Return the corners of the shortest path from a point, itself first, shape (k, 2); WorldError if there is none."""
        distance, root = query(self.roots, x, y)
        if root < 0:
            raise WorldError(f"no path from ({x:.2f}, {y:.2f}) to the goal")
        points = [(x, y)]
        corners = self.roots.points
        while 0 <= root < len(corners):
            points.append((float(corners[root, 0]), float(corners[root, 1])))
            root = int(self.towards[root])
        feet = [foot(goal, *points[-1]) for goal in self.roots.goals]
        seen = [f for f in feet if rolls_straight(self.roots.grid, *points[-1], f[0], f[1])] or feet
        last = min(seen, key=lambda f: f[2])
        return np.array([*points, (last[0], last[1])])


class Geodesic:
    """Free space and shortest distances of a disc in a world.

    Parameters
    ----------
    world
        The truth.
    radius
        Radius of the disc, m; walls are `WALL_RADIUS` thick on either side.
    """

    def __init__(self, world: World, radius: float = 0.2) -> None:
        self.world = world
        self.radius = float(radius)
        self.shapes = shapes_of(world)
        self.grid = clearance_grid(world, self.radius, STEP, MARGIN)
        self._fields: dict[tuple[int, ...], Field] = {}

    @cached_property
    def corners(self) -> Corners:
        """Points around which shortest paths bend."""
        return corners_of(self.world, self.grid, self.radius)

    def clearance(self, x: float, y: float) -> float:
        """Return how far the disc at a point is from touching anything, m; negative where it overlaps."""
        return float(exact_clearance(float(x), float(y), self.shapes, self.radius))

    def free(self, x: float, y: float, margin: float = 0.0) -> bool:
        """Return whether a disc at a point touches nothing and has a margin (m) to everything."""
        return self.clearance(x, y) >= margin

    def distance(self, start: tuple[float, float], goals: Iterable[int | str]) -> float:
        """Return the distance (m) from a start until the centre is inside the nearest goal region; infinite if none is."""
        return self.field(goals).at(start[0], start[1])

    def field(self, goals: Iterable[int | str]) -> Field:
        """Return the distance field of some regions, given by index or id; fields are kept for the next call."""
        indices = tuple(sorted({self._index(goal) for goal in goals}))
        if indices not in self._fields:
            if len(self._fields) >= 64:
                self._fields.pop(next(iter(self._fields)))
            self._fields[indices] = self._field(indices)
        return self._fields[indices]

    def sample_free(
        self,
        rng: np.random.Generator,
        field: Field | None = None,
        at_least: float = 0.0,
        at_most: float = np.inf,
        margin: float = 0.1,
        regions: Iterable[int] | None = None,
    ) -> tuple[float, float]:
        """Draw a point uniformly from the free floor inside regions.

        Parameters
        ----------
        rng
            The owner's generator.
        field, at_least, at_most
            Only points whose distance in this field is finite and within these limits, m.
        margin
            Least distance from touching anything, m.
        regions
            Indices of the regions to draw from; default: all but doors.

        Raises
        ------
        WorldError
            Where there is no such point.
        """
        mask = (self.grid.clearance >= margin) & self._inside(regions)
        if field is not None:
            value = field.roots.value
            mask &= np.isfinite(value) & (value >= at_least) & (value <= at_most)
        nodes = np.argwhere(mask)
        if not len(nodes):
            where = "" if field is None else f" between {at_least:g} and {at_most:g} m from the goal"
            raise WorldError(f"world {self.world.name!r}: no free place{where} for a disc of {self.radius:g} m")
        for _ in range(1000):
            i, j = nodes[rng.integers(len(nodes))]
            dx, dy = rng.uniform(-0.5, 0.5, 2) * STEP
            x, y = self.grid.x0 + i * STEP + dx, self.grid.y0 + j * STEP + dy
            if self.free(x, y, margin) and (field is None or at_least <= field.at(x, y) <= at_most):
                break
        else:
            x, y = self.grid.x0 + i * STEP, self.grid.y0 + j * STEP
        return float(x), float(y)

    def _index(self, goal: int | str) -> int:
        if isinstance(goal, str):
            if goal not in self.world.region_index:
                raise WorldError(unknown("region", goal, self.world.region_index))
            return self.world.region_index[goal]
        if not 0 <= goal < len(self.world.regions):
            raise WorldError(f"region index {goal}: expected 0 to {len(self.world.regions) - 1}")
        return int(goal)

    def _field(self, indices: tuple[int, ...]) -> Field:
        goals = _rectangles(self.world, indices)
        corners = self.corners
        distance = np.full(len(corners.points), np.inf)
        towards = np.full(len(corners.points), -1, dtype=np.int64)
        see_goals(self.grid, corners.points, goals, distance)
        relax_corners(corners, distance, towards)
        behind = np.argsort(towards, kind="stable")
        behind = behind[np.isfinite(distance[behind])]
        first = np.searchsorted(towards[behind], np.arange(-1, len(towards) + 1)).astype(np.int64)
        root = np.full(self.grid.clearance.shape, -1, dtype=np.int32)
        value = np.full(self.grid.clearance.shape, np.inf)
        roots = Roots(self.grid, corners.points, distance, goals, first, behind, root, value)
        flood(roots)
        return Field(indices, roots, towards)

    def _inside(self, regions: Iterable[int] | None) -> NDArray[np.bool_]:
        """Return the grid nodes inside some regions, (nx, ny)."""
        if regions is None:
            return self._floor
        return self._cover(regions)

    @cached_property
    def _floor(self) -> NDArray[np.bool_]:
        return self._cover(i for i, region in enumerate(self.world.regions) if region.type != "door")

    def _cover(self, regions: Iterable[int]) -> NDArray[np.bool_]:
        grid = self.grid
        mask = np.zeros(grid.clearance.shape, dtype=bool)
        for index in regions:
            row = self.world.regions[self._index(index)].row
            corners = row.rectangles().reshape(-1, 2)
            i0, j0 = np.maximum(np.ceil((corners.min(axis=0) - (grid.x0, grid.y0)) / STEP), 0).astype(int)
            i1, j1 = np.floor((corners.max(axis=0) - (grid.x0, grid.y0)) / STEP).astype(int) + 1
            i, j = np.mgrid[i0:i1, j0:j1]
            nodes = np.stack([grid.x0 + i.ravel() * STEP, grid.y0 + j.ravel() * STEP], axis=1)
            mask[i0:i1, j0:j1] |= row.contains(nodes).reshape(i.shape)
        return mask


def _rectangles(world: World, indices: Iterable[int]) -> Floats:
    """Return the rectangles of some regions, (G, 8): x, y, cos, sin of the row's frame, then u0, u1, b, t."""
    rows = [world.regions[i].row for i in indices]
    listed = [
        (row.x, row.y, np.cos(row.phi), np.sin(row.phi), row.u[k], row.u[k + 1], row.b[k], row.t[k])
        for row in rows
        for k in range(row.n)
    ]
    return np.array(listed, dtype=np.float64).reshape(-1, 8)


@njit
def foot(goal: Any, x: float, y: float) -> Any:
    """Return the point of a rectangle nearest to (x, y), and its distance."""
    along = goal[2] * (x - goal[0]) + goal[3] * (y - goal[1])
    across = -goal[3] * (x - goal[0]) + goal[2] * (y - goal[1])
    u, v = min(max(along, goal[4]), goal[5]), min(max(across, goal[6]), goal[7])
    fx, fy = goal[0] + goal[2] * u - goal[3] * v, goal[1] + goal[3] * u + goal[2] * v
    return fx, fy, np.hypot(along - u, across - v)


@njit
def see_goals(grid: Any, points: Any, goals: Any, distance: Any) -> None:
    """Lower the distance of every corner that sees its nearest point of a goal rectangle."""
    for v in range(len(points)):
        for g in range(len(goals)):
            fx, fy, straight = foot(goals[g], points[v, 0], points[v, 1])
            if straight < distance[v] and rolls_straight(grid, points[v, 0], points[v, 1], fx, fy):
                distance[v] = straight


@njit
def through_root(roots: Any, root: int, x: float, y: float) -> Any:
    """Return the distance from (x, y) to the goal through a root, and the end of the straight piece."""
    corners = len(roots.points)
    if root < corners:
        px, py = roots.points[root, 0], roots.points[root, 1]
        return roots.distance[root] + np.hypot(x - px, y - py), px, py
    fx, fy, straight = foot(roots.goals[root - corners], x, y)
    return straight, fx, fy


@njit
def improve(roots: Any, i: int, j: int, root: int, failed: Any, stack: Any) -> bool:
    """Give a node this root, or one behind it, if that is shorter and its straight piece is free; returns whether it was.

    A node that cannot see the root stands in the shadow of a corner whose own way leads through that root; often the
    shadow is thinner than the grid and nobody else would hand the corner on.
    """
    grid, corners = roots.grid, len(roots.points)
    if grid.clearance[i, j] < 0 or failed[i, j] == root:
        return False
    x, y = grid.x0 + i * grid.step, grid.y0 + j * grid.step
    improved, size = False, 1
    stack[0] = root
    while size > 0:
        size -= 1
        tried = stack[size]
        value, px, py = through_root(roots, tried, x, y)
        if value > roots.value[i, j] - 1e-9:
            continue
        if rolls_straight(grid, x, y, px, py):
            roots.value[i, j], roots.root[i, j] = value, tried
            improved = True
            continue
        failed[i, j] = tried
        parent = tried if tried < corners else -1
        for c in range(roots.first[parent + 1], roots.first[parent + 2]):
            child = roots.behind[c]
            detour = through_root(roots, child, x, y)[0] - value
            if detour < 2 * grid.step and size < len(stack):
                stack[size] = child
                size += 1
    return improved


@njit
def flood(roots: Any) -> None:
    """Fill `root` and `value` outwards from the goals and the corners, nearest nodes first."""
    grid, corners = roots.grid, len(roots.points)
    nx, ny = grid.clearance.shape
    failed, stack = np.full((nx, ny), -1, np.int32), np.empty(256, np.int64)
    keys, items, size = np.empty(nx * ny, np.float64), np.empty(nx * ny, np.int64), 0
    for root in range(corners + len(roots.goals)):
        if root < corners and roots.distance[root] == np.inf:
            continue
        lx, ly, hx, hy = extent(roots, root)
        for i in range(max(0, int((lx - grid.x0) / grid.step)), min(nx, int((hx - grid.x0) / grid.step) + 2)):
            for j in range(max(0, int((ly - grid.y0) / grid.step)), min(ny, int((hy - grid.y0) / grid.step) + 2)):
                if improve(roots, i, j, root, failed, stack):
                    keys, items, size = push(keys, items, size, roots.value[i, j], i * ny + j)
    while size > 0:
        key, node = keys[0], items[0]
        size = drop_first(keys, items, size)
        i, j = node // ny, node % ny
        if key > roots.value[i, j]:
            continue
        for k in range(4):
            ni, nj = i + (k == 0) - (k == 1), j + (k == 2) - (k == 3)
            if 0 <= ni < nx and 0 <= nj < ny and improve(roots, ni, nj, roots.root[i, j], failed, stack):
                keys, items, size = push(keys, items, size, roots.value[ni, nj], ni * ny + nj)


@njit
def extent(roots: Any, root: int) -> Any:
    """Return the box (lowest x, y, highest x, y) of a root: a point, or a rectangle of the goal."""
    corners = len(roots.points)
    if root < corners:
        x, y = roots.points[root, 0], roots.points[root, 1]
        return x, y, x, y
    g = roots.goals[root - corners]
    u, v, half_u, half_v = (g[4] + g[5]) / 2, (g[6] + g[7]) / 2, (g[5] - g[4]) / 2, (g[7] - g[6]) / 2
    x, y = g[0] + g[2] * u - g[3] * v, g[1] + g[3] * u + g[2] * v
    half_x, half_y = abs(g[2]) * half_u + abs(g[3]) * half_v, abs(g[3]) * half_u + abs(g[2]) * half_v
    return x - half_x, y - half_y, x + half_x, y + half_y


@njit
def query(roots: Any, x: float, y: float) -> Any:
    """Return the distance from a point to the goal and its root (-1 if unreachable).

    The point takes the best root of the nodes around it. Where all of them are blocked (it touches a wall), the nearest
    ring of nodes with a root helps out, at most four nodes away.
    """
    grid = roots.grid
    nx, ny = grid.clearance.shape
    best, best_root = np.inf, -1
    i0, j0 = int(np.floor((x - grid.x0) / grid.step)), int(np.floor((y - grid.y0) / grid.step))
    for ring in range(5):
        for i in range(max(0, i0 - ring), min(nx, i0 + ring + 2)):
            for j in range(max(0, j0 - ring), min(ny, j0 + ring + 2)):
                if roots.root[i, j] >= 0:
                    value = through_root(roots, roots.root[i, j], x, y)[0]
                    if value < best:
                        best, best_root = value, roots.root[i, j]
        if best_root >= 0:
            break
    return best, best_root
