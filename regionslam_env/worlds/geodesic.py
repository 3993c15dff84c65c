"""Shortest distances of a disc to a region, any-angle: what SPL, starts and rewards are measured with.

A shortest path is straight but for bends at the corners of walls and furniture. Every grid node of a field therefore
stores no distance but the *root* of its last straight piece (a corner, or the goal itself), and a query is exact for
the root: its distance plus the straight line to it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.clearance import clearance_grid, exact_clearance, rolls_straight, shapes_of
from regionslam_env.worlds.corners import Corners, corners_of, relax_corners
from regionslam_env.worlds.flooding import (
    Roots,
    distance_at,
    flood,
    foot,
    mark_leaving,
    query,
    see_goals,
    see_points,
    through_root,
)
from regionslam_env.worlds.world import World
from slam.rows import Floats

STEP = 0.15
"""Distance of grid nodes, m."""

MARGIN = 0.5
"""Extent of the grid beyond the world, m."""


@dataclass(frozen=True, eq=False)
class Field:
    """Distance to the nearest of some regions, everywhere.

    Parameters
    ----------
    goals
        Indices of the regions in `World.regions`; empty for a field to points.
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
        return float(distance_at(self._plain, x, y))

    def near(self, x: float, y: float) -> float:
        """Return the distance from a point, or, where it has no way itself, from the nearest node that has one."""
        here = self.at(x, y)
        if np.isfinite(here):
            return here
        grid, reached = self.roots.grid, np.argwhere(np.isfinite(self.nodes))
        if not len(reached):
            return np.inf
        beside = np.hypot(grid.x0 + reached[:, 0] * grid.step - x, grid.y0 + reached[:, 1] * grid.step - y)
        nearest = int(np.argmin(beside))
        return float(beside[nearest] + self.nodes[tuple(reached[nearest])])

    @cached_property
    def _plain(self) -> tuple[Any, ...]:
        """The roots, and their grid, as plain tuples: Numba unpacks them ten times faster."""
        return (tuple(self.roots.grid), *self.roots[1:])

    @cached_property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """The same as arrays alone: x0, y0, step and clearance of the grid, then the other parts of the roots."""
        grid = self.roots.grid
        return (np.array([grid.x0, grid.y0, grid.step]), grid.clearance, *self.roots[1:])

    @property
    def nodes(self) -> Floats:
        """Distance at every node of the grid, m; infinite where unreachable or blocked, (nx, ny)."""
        return self.roots.value.reshape(self.roots.grid.clearance.shape)

    def path(self, x: float, y: float) -> Floats:
        """Return the shortest path from a point as its corners, itself first, shape (k, 2); WorldError if none."""
        _, root = query(self.roots, x, y)
        if root < 0:
            raise WorldError(f"no path from ({x:.2f}, {y:.2f}) to the goal")
        points = [(x, y)]
        corners = self.roots.points
        while 0 <= root < len(corners):
            points.append((float(corners[root, 0]), float(corners[root, 1])))
            root = int(self.towards[root])
        if not len(self.roots.goals):
            return np.array(points)
        feet = [foot(goal, *points[-1]) for goal in self.roots.goals]
        seen = [f for f in feet if rolls_straight(self.roots.grid, *points[-1], f[0], f[1])] or feet
        last = min(seen, key=lambda f: f[2])
        if last[2] > 0:
            points.append((last[0], last[1]))
        return np.array(points)


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
        """Return the distance (m) from a start into the nearest goal region; infinite if none can be reached."""
        return self.field(goals).at(start[0], start[1])

    def field(self, goals: Iterable[int | str]) -> Field:
        """Return the distance field of some regions, given by index or id; fields are kept for the next call."""
        indices = tuple(sorted({self._index(goal) for goal in goals}))
        if indices not in self._fields:
            if len(self._fields) >= 64:
                self._fields.pop(next(iter(self._fields)))
            self._fields[indices] = self._field(indices)
        return self._fields[indices]

    def field_to_type(self, region_type: str) -> Field:
        """Return the distance field of all regions of a type; there is at least one."""
        return self.field(i for i, region in enumerate(self.world.regions) if region.type == region_type)

    def route(self, start: tuple[float, float], end: tuple[float, float]) -> Floats | None:
        """Return the shortest path between two points, with its corners and both ends, (k, 2); None where none is."""
        straight = np.array([start, end], dtype=np.float64)
        if rolls_straight(self.grid, *straight.ravel()):
            return straight
        points = self.corners.points
        before = np.full(len(points), np.inf)
        see_goals(self.grid, points, _point(start), before)
        behind, towards = self._to_goals(_point(end))
        total = before + behind
        corner = int(np.argmin(total)) if len(total) else -1
        if corner < 0 or not np.isfinite(total[corner]):
            return None
        path = [start]
        while corner >= 0:
            path.append((float(points[corner, 0]), float(points[corner, 1])))
            corner = int(towards[corner])
        return np.array([*path, end])

    def field_to_points(self, points: Floats, offsets: Floats) -> Field:
        """Return the field of the distance to the best of some points, to which an offset of its own is added.

        Parameters
        ----------
        points
            Free points, shape (P, 2), m.
        offsets
            Shape (P,), m.
        """
        corners = self.corners
        n = len(corners.points)
        distance, towards = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
        see_points(self.grid, corners.points, points, offsets, distance, towards)
        relax_corners(corners, distance, towards, np.empty(n, np.int64), np.full(n, -1))
        return self._flooded(
            (),
            np.vstack([corners.points, points]),
            np.concatenate([distance, offsets]),
            np.concatenate([towards, np.full(len(points), -1, dtype=np.int64)]),
            np.zeros((0, 8)),
        )

    def field_through(self, part: Field, beyond: Field) -> Field:
        """Return the field of the length of the shortest way into a part of the floor and from there along a field.

        Inside of that part the way is the one of `beyond`. A way leaves the part at one of finitely many points, less
        than a step of the grid from each other: it may be longer than the shortest by a part of that.

        Parameters
        ----------
        part
            Distance to the part, 0 or less inside.
        beyond
            Length of the way from there.
        """
        nodes = part.nodes <= 0
        leaving = np.zeros(nodes.size, dtype=bool)
        mark_leaving(beyond.roots, nodes.ravel(), leaving)
        exits = [self._exit(int(node), part, beyond.roots) for node in np.flatnonzero(leaving)]
        points = np.array(exits, dtype=np.float64).reshape(-1, 3)
        return self.field_to_points(points[:, :2].copy(), np.maximum(0.0, points[:, 2]))

    def _exit(self, node: int, part: Field, roots: Roots) -> tuple[float, float, float]:
        """Return the point at which the way from a node leaves a part of the floor, and the length of its rest, m."""
        i, j = divmod(node, self.grid.clearance.shape[1])
        x, y, value = self.grid.x0 + i * STEP, self.grid.y0 + j * STEP, float(roots.value[node])
        _, px, py = through_root(roots, int(roots.root[node]), x, y)
        straight = float(np.hypot(px - x, py - y))
        if value <= 0 or straight == 0:
            return x, y, value
        dx, dy = (px - x) / straight, (py - y) / straight
        inside, outside = 0.0, min(straight, 2 * STEP)
        if part.at(x + outside * dx, y + outside * dy) <= 0:
            return x, y, value
        for _ in range(10):
            middle = (inside + outside) / 2
            if part.at(x + middle * dx, y + middle * dy) <= 0:
                inside = middle
            else:
                outside = middle
        return x + inside * dx, y + inside * dy, value - inside

    def sample_free(
        self,
        rng: np.random.Generator,
        field: Field | None = None,
        at_least: float = 0.0,
        at_most: float = np.inf,
        margin: float = 0.1,
        regions: Iterable[int | str] | None = None,
        reaching: Iterable[Field] = (),
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
            Indices or ids of the regions to draw from; default: all but doors.
        reaching
            Only points from which there is a way in each of these fields.

        Raises
        ------
        WorldError
            Where there is no such point.
        """
        mask = self._floor if regions is None else self._cover(regions)
        mask = mask & (self.grid.clearance >= margin)
        if field is not None:
            value = field.nodes
            mask &= np.isfinite(value) & (value >= at_least) & (value <= at_most)
        for other in reaching:
            mask &= np.isfinite(other.nodes)
        nodes = np.flatnonzero(mask)
        if not len(nodes):
            where = "" if field is None else f" between {at_least:g} and {at_most:g} m from the goal"
            raise WorldError(f"world {self.world.name!r}: no free place{where} for a disc of {self.radius:g} m")
        for _ in range(1000):
            i, j = divmod(int(nodes[rng.integers(len(nodes))]), mask.shape[1])
            dx, dy = rng.uniform(-0.5, 0.5, 2) * STEP
            x, y = self.grid.x0 + i * STEP + dx, self.grid.y0 + j * STEP + dy
            if self.free(x, y, margin) and (field is None or at_least <= field.at(x, y) <= at_most):
                break
        else:  # every try fell beside a node that is itself free
            x, y = self.grid.x0 + i * STEP, self.grid.y0 + j * STEP
        return float(x), float(y)

    def floor(self, regions: Iterable[int | str]) -> NDArray[np.bool_]:
        """Return the grid nodes inside some regions on which a disc touches nothing, (nx, ny)."""
        return self._cover(regions) & (self.grid.clearance >= 0)

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
        distance, towards = self._to_goals(goals)
        return self._flooded(indices, self.corners.points, distance, towards, goals)

    def _flooded(
        self, goals: tuple[int, ...], points: Floats, distance: Floats, towards: NDArray[np.int64], rectangles: Floats
    ) -> Field:
        """Return the field of some roots: points, whose distances are known, and rectangles of the goal."""
        behind = np.argsort(towards, kind="stable")
        behind = behind[np.isfinite(distance[behind])]
        first = np.searchsorted(towards[behind], np.arange(-1, len(towards) + 1)).astype(np.int64)
        nodes = self.grid.clearance.size
        root, value = np.full(nodes, -1), np.full(nodes, np.inf)
        roots = Roots(self.grid, points, distance, rectangles, first, behind, root, value)
        flood(roots, np.empty(nodes, np.int64), np.full(nodes, -1), np.full(nodes, -1), np.empty(256, np.int64))
        return Field(goals, roots, towards)

    def _to_goals(self, goals: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """Return each corner's distance to the nearest of some rectangles (m), and its next corner on the way or -1."""
        corners = self.corners
        n = len(corners.points)
        distance, towards = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
        see_goals(self.grid, corners.points, goals, distance)
        relax_corners(corners, distance, towards, np.empty(n, np.int64), np.full(n, -1))
        return distance, towards

    @cached_property
    def _floor(self) -> NDArray[np.bool_]:
        return self._cover(i for i, region in enumerate(self.world.regions) if region.type != "door")

    def _cover(self, regions: Iterable[int | str]) -> NDArray[np.bool_]:
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


def _point(place: tuple[float, float]) -> Floats:
    """Return a point as a rectangle without extent, (1, 8)."""
    return np.array([[place[0], place[1], 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]])


@lru_cache(maxsize=8)
def shared_geodesic(world: World, radius: float) -> Geodesic:
    """Return the shortest distances in a world, the same ones to everybody who asks: worlds are immutable."""
    return Geodesic(world, radius)


def _rectangles(world: World, indices: Iterable[int]) -> Floats:
    """Return the rectangles of some regions, (G, 8): x, y, cos, sin of the row's frame, then u0, u1, b, t."""
    rows = [world.regions[i].row for i in indices]
    listed = [
        (row.x, row.y, np.cos(row.phi), np.sin(row.phi), row.u[k], row.u[k + 1], row.b[k], row.t[k])
        for row in rows
        for k in range(row.n)
    ]
    return np.array(listed, dtype=np.float64).reshape(-1, 8)
