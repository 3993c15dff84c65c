"""The truth about one floor: regions, doors, walls, furniture. Immutable, and known to no agent.

Lengths are metres, angles radians, all in the world frame. Walls are segments without thickness, from which the
openings of the doors have been cut; the borders of neighbouring rooms coincide with the walls between them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from regionslam_env.errors import WorldError, unknown
from slam.region import EDGE_NAMES
from slam.rows import MAX_RECTANGLES, Floats, Row

WALL_RADIUS = 0.05
"""Half the thickness of a wall where a robot collides with it, m."""

TRUE_REGION = np.dtype(
    (
        np.record,
        [
            ("x", np.float64),
            ("y", np.float64),
            ("phi", np.float64),
            ("n", np.int32),
            ("main", np.int32),
            ("u", np.float64, (MAX_RECTANGLES + 1,)),
            ("b", np.float64, (MAX_RECTANGLES,)),
            ("t", np.float64, (MAX_RECTANGLES,)),
            ("type", np.int32),  # index into WorldArrays.types
            ("cx", np.float64),  # centre and radius of a circle around the region
            ("cy", np.float64),
            ("radius", np.float64),
        ],
    )
)
"""One true region for kernels: its row in edge form (unused entries are 0), its type and a circle around it."""


@dataclass(frozen=True, eq=False)
class Region:
    """A named place of one semantic type; `parent` is the id of the region that contains it (a desk's office)."""

    id: str
    type: str
    name: str
    row: Row
    parent: str | None = None


@dataclass(frozen=True)
class Door:
    """An opening in a wall, from (x0, y0) to (x1, y1), m; a region of type "door" with the same id straddles it."""

    id: str
    x0: float
    y0: float
    x1: float
    y1: float
    regions: tuple[str, ...]


@dataclass(frozen=True)
class Link:
    """An adjacency with a passage, through one named edge (`EDGE_NAMES`) of each region; each pair is held once."""

    source: str
    target: str
    source_edge: str
    target_edge: str

    def reversed(self) -> Link:
        """Return the same link seen from its other end."""
        return Link(self.target, self.source, self.target_edge, self.source_edge)


@dataclass(frozen=True, eq=False)
class WorldArrays:
    """A world as plain arrays for kernels; indices are those of `World.regions`."""

    rows: np.recarray[Any, Any]  # (R,) of TRUE_REGION
    links: NDArray[np.int64]  # (L, 2) indices of linked regions, each pair once
    walls: Floats  # (W, 4) segments x0, y0, x1, y1
    obstacles: Floats  # (O, 4) segments
    types: tuple[str, ...]  # what `rows.type` indexes


@dataclass(frozen=True, eq=False)
class World:
    """One floor of a building.

    Parameters
    ----------
    name
        Name of the building or floor.
    regions
        Every region, doors and furniture included; ids are unique.
    walls
        Segments x0, y0, x1, y1 with the openings already cut, shape (W, 4), m.
    doors
        The openings; `Door.id` is also the id of a region of type "door".
    obstacles
        Convex counter-clockwise polygons, each of shape (k, 2), m: furniture that collides.
    links
        Adjacencies by passage: room and door, or room and hallway where no door region is between.
    level
        Name of the level.
    spawn
        Preferred start pose (x, y, theta), if any.

    Raises
    ------
    WorldError
        Where ids, parents, links or shapes contradict each other.
    """

    name: str
    regions: tuple[Region, ...]
    walls: Floats
    doors: tuple[Door, ...] = ()
    obstacles: tuple[Floats, ...] = ()
    links: tuple[Link, ...] = ()
    level: str = "0"
    spawn: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "walls", _frozen(self.walls, 4))
        object.__setattr__(self, "obstacles", tuple(_frozen(o, 2) for o in self.obstacles))
        for field in ("regions", "doors", "links"):
            object.__setattr__(self, field, tuple(getattr(self, field)))
        self._check_references()

    def _check_references(self) -> None:
        ids = [r.id for r in self.regions]
        known = set(ids)
        if len(known) < len(ids):
            raise WorldError(
                f"world {self.name!r}: region id {next(i for i in ids if ids.count(i) > 1)!r} is used twice"
            )
        for region in self.regions:
            if region.parent is not None and region.parent not in known:
                raise WorldError(f"world {self.name!r}: region {region.id!r}: {unknown('parent', region.parent, ids)}")
            seen, parent = {region.id}, region.parent
            while parent is not None:
                if parent in seen:
                    raise WorldError(f"world {self.name!r}: region {region.id!r} is its own ancestor")
                seen.add(parent)
                parent = self.regions[self.region_index[parent]].parent
        for door in self.doors:
            for name in (door.id, *door.regions):
                if name not in known:
                    raise WorldError(f"world {self.name!r}: door {door.id!r}: {unknown('region', name, ids)}")
        for link in self.links:
            for name, edge in ((link.source, link.source_edge), (link.target, link.target_edge)):
                if name not in known:
                    raise WorldError(f"world {self.name!r}: link: {unknown('region', name, ids)}")
                if edge not in EDGE_NAMES:
                    raise WorldError(f"world {self.name!r}: link of {name!r}: {unknown('edge', edge, EDGE_NAMES)}")

    def __reduce__(self) -> tuple[type[World], tuple[Any, ...]]:
        """Pickle the fields alone: caches are rebuilt, and arrays stay read-only (kernels compile once for either)."""
        return World, tuple(getattr(self, field.name) for field in fields(self))

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest x and y, largest x and y over walls and regions, m."""
        points = [self.walls.reshape(-1, 2), *(r.row.outline() for r in self.regions)]
        corners = np.concatenate(points)
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        return float(x0), float(y0), float(x1), float(y1)

    @cached_property
    def region_index(self) -> dict[str, int]:
        """Place of each region id in `regions`."""
        return {region.id: i for i, region in enumerate(self.regions)}

    @cached_property
    def types(self) -> tuple[str, ...]:
        """Every semantic type that occurs, sorted."""
        return tuple(sorted({region.type for region in self.regions}))

    def region(self, region_id: str) -> Region:
        """Return the region with this id; `WorldError` with the nearest ids if there is none."""
        if region_id not in self.region_index:
            raise WorldError(f"world {self.name!r}: {unknown('region', region_id, self.region_index)}")
        return self.regions[self.region_index[region_id]]

    def regions_of_type(self, region_type: str) -> tuple[Region, ...]:
        """Return every region of a semantic type, in the order of `regions`."""
        return tuple(region for region in self.regions if region.type == region_type)

    def region_at(self, x: float, y: float) -> Region | None:
        """Return the innermost (smallest) region that contains a point, or None."""
        near = np.nonzero(np.hypot(self.arrays.rows.cx - x, self.arrays.rows.cy - y) <= self.arrays.rows.radius)[0]
        inside = [self.regions[i] for i in near if self.regions[i].row.contains([[x, y]])[0]]
        return min(inside, key=lambda region: region.row.area, default=None)

    def parent(self, region_id: str) -> Region | None:
        """Return the region that contains this one, or None."""
        parent = self.region(region_id).parent
        return None if parent is None else self.region(parent)

    def children(self, region_id: str) -> tuple[Region, ...]:
        """Return the regions directly inside this one."""
        return tuple(region for region in self.regions if region.parent == region_id)

    def links_of(self, region_id: str) -> tuple[Link, ...]:
        """Return the links of a region, each turned so that the region is its source."""
        return self._links_by_region.get(region_id, ())

    @cached_property
    def _links_by_region(self) -> dict[str, tuple[Link, ...]]:
        by_region: dict[str, tuple[Link, ...]] = {}
        for link in (*self.links, *(link.reversed() for link in self.links)):
            by_region[link.source] = (*by_region.get(link.source, ()), link)
        return by_region

    @cached_property
    def obstacle_segments(self) -> Floats:
        """Sides of every obstacle as segments x0, y0, x1, y1, shape (O, 4), m."""
        sides = [np.concatenate([o, np.roll(o, -1, axis=0)], axis=1) for o in self.obstacles]
        return _frozen(np.concatenate(sides) if sides else np.empty((0, 4)), 4)

    @cached_property
    def arrays(self) -> WorldArrays:
        """The world as plain arrays for kernels."""
        rows = np.zeros(len(self.regions), TRUE_REGION).view(np.recarray)
        for record, region in zip(rows, self.regions, strict=True):
            row = region.row
            record.x, record.y, record.phi, record.n, record.main = row.x, row.y, row.phi, row.n, row.main
            record.u[: row.n + 1], record.b[: row.n], record.t[: row.n] = row.u, row.b, row.t
            record.type = self.types.index(region.type)
            low, high = np.array([row.u[0], row.b.min()]), np.array([row.u[-1], row.t.max()])
            record.cx, record.cy = row.to_world([(low + high) / 2])[0]
            record.radius = float(np.hypot(*(high - low))) / 2 + 1e-9
        pairs = [(self.region_index[link.source], self.region_index[link.target]) for link in self.links]
        links = np.array(pairs, dtype=np.int64).reshape(-1, 2)
        rows.flags.writeable = links.flags.writeable = False
        return WorldArrays(rows, links, self.walls, self.obstacle_segments, self.types)


def _frozen(values: ArrayLike, columns: int) -> Floats:
    """Return a contiguous copy that nobody can write to, shape (-1, columns)."""
    array = np.array(values, dtype=np.float64).reshape(-1, columns)
    array.flags.writeable = False
    return array
