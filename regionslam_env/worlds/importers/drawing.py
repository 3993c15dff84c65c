"""What every reader makes of one level of a file: rooms, doors and furniture as drawn, in metres, y up.

A reader knows its format and nothing else; from here on everything is shared (`realise`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry.polygon import orient

from regionslam_env.errors import WorldError

SHORTEST = 0.05
"""Doors shorter than this (m) are points."""

LEAST_AREA = 0.2
"""Rooms below this (m²) are dropped."""

LARGEST = 2000.0
"""Largest extent of a level, m."""

SAME = 0.9
"""IoU above which two rooms are one that was drawn twice."""

MOST_ROOMS = 3000
MOST_POINTS = 5000


@dataclass(frozen=True, eq=False)
class DrawnRoom:
    """A room: `key` is the file's name for it, `label` says what it is for.

    Between two rooms that are `open`, no wall stands.
    """

    key: str
    label: str
    name: str | None
    polygon: shapely.Polygon
    open: bool = False


@dataclass(frozen=True)
class DrawnDoor:
    """A door from (x0, y0) to (x1, y1), m, or a point, and the keys of its two rooms where the file names them."""

    x0: float
    y0: float
    x1: float
    y1: float
    rooms: tuple[str, ...] = ()
    width: float | None = None
    what: str = "door"

    @classmethod
    def between(
        cls,
        start: ArrayLike,
        end: ArrayLike,
        rooms: tuple[str, ...] = (),
        width: float | None = None,
        what: str = "door",
    ) -> DrawnDoor:
        """Return the door from one point (2,) to another, m, as wide as they are apart unless told otherwise."""
        (x0, y0), (x1, y1) = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
        apart = float(np.hypot(x1 - x0, y1 - y0))
        return cls(float(x0), float(y0), float(x1), float(y1), rooms, apart if width is None else width, what)

    @property
    def middle(self) -> tuple[float, float]:
        """Its middle, m."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    @property
    def direction(self) -> float | None:
        """Direction along it, rad, None for a point."""
        dx, dy = self.x1 - self.x0, self.y1 - self.y0
        return float(np.arctan2(dy, dx)) if np.hypot(dx, dy) > SHORTEST else None


@dataclass(frozen=True, eq=False)
class DrawnItem:
    """A piece of furniture: its label and footprint."""

    label: str
    name: str | None
    polygon: shapely.Polygon


@dataclass
class Drawing:
    """One level as drawn.

    Parameters
    ----------
    name, level, levels
        Of the building, of this level, of all levels.
    scale
        Metres per unit of the file, None where the file is in metres.
    rooms, doors, furniture
        What was found.
    passages
        Pairs of rooms that stand open to each other along their common border.
    pieces
        Keys of the pieces of rooms that were cut, by the room's own key.
    walls
        Shapes that close a border even between open rooms.
    dropped
        What was left out, and why.
    notes
        What else a person should know.
    """

    name: str
    level: str = "0"
    levels: Sequence[str] = ("0",)
    scale: float | None = None
    rooms: list[DrawnRoom] = field(default_factory=list)
    doors: list[DrawnDoor] = field(default_factory=list)
    furniture: list[DrawnItem] = field(default_factory=list)
    passages: list[tuple[str, str]] = field(default_factory=list)
    pieces: dict[str, tuple[str, ...]] = field(default_factory=dict)
    walls: list[Any] = field(default_factory=list)
    dropped: list[tuple[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def drop(self, what: str, why: str) -> None:
        """Note what is left out."""
        self.dropped.append((what, why))

    def add_room(self, key: str, label: str, name: str | None, shape: Any, open: bool = False) -> None:
        """Add a room from its corners (k, 2) or its polygon, m; one without an area is dropped."""
        polygon = cleaned(shape)
        if polygon.area < LEAST_AREA:
            self.drop(f"room {name or key!r}", f"area {polygon.area:.2f} m², expected at least {LEAST_AREA}")
            return
        if len(self.rooms) >= MOST_ROOMS:
            raise WorldError(f"plan {self.name!r}: more than {MOST_ROOMS} rooms on one level, expected at most that")
        self.rooms.append(DrawnRoom(key, label, name, polygon, open))

    def add_item(self, label: str, name: str | None, shape: Any) -> None:
        """Add furniture from its corners (k, 2), m."""
        polygon = cleaned(shape)
        if polygon.area < 1e-3:
            self.drop(f"furniture {name or label!r}", "a footprint without an area")
            return
        self.furniture.append(DrawnItem(label, name, polygon))

    def check(self) -> None:
        """Drop what is drawn twice; refuse a level without rooms, and one of a size that no building has."""
        self.doors = list(dict.fromkeys(self.doors))
        self._drop_doubles()
        if not self.rooms:
            why = "".join(f"; {what}: {reason}" for what, reason in self.dropped[:3])
            raise WorldError(f"plan {self.name!r}: level {self.level!r} has no room with an outline{why}")
        bounds = shapely.total_bounds([room.polygon for room in self.rooms])
        extent = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
        if extent > LARGEST:
            raise WorldError(
                f"plan {self.name!r}: {extent:.0f} m across, expected at most {LARGEST:.0f}: give a scale (--scale)"
            )

    def _drop_doubles(self) -> None:
        tree = shapely.STRtree([room.polygon for room in self.rooms])
        doubles = set()
        for i, room in enumerate(self.rooms):
            for j in sorted(tree.query(room.polygon, predicate="intersects")):
                other = self.rooms[j]
                if j <= i or j in doubles:
                    continue
                if room.polygon.intersection(other.polygon).area > SAME * room.polygon.union(other.polygon).area:
                    doubles.add(j)
                    self.drop(
                        f"room {other.name or other.key!r}", f"drawn in the place of room {room.name or room.key!r}"
                    )
        self.rooms = [room for j, room in enumerate(self.rooms) if j not in doubles]


def cleaned(shape: Any) -> shapely.Polygon:
    """Return the largest simple part of an outline (k, 2) or polygon, counter-clockwise; empty where it has none."""
    if not isinstance(shape, shapely.Geometry):
        points = np.asarray(shape, dtype=np.float64)
        points = points[:: -(-len(points) // MOST_POINTS)] if len(points) else points
        if len(points) < 3 or not np.isfinite(points).all():
            return shapely.Polygon()
        shape = shapely.Polygon(np.round(points, 9))  # far below any measure, slivers break operations on shapes
    shape = shapely.make_valid(shape)
    part = largest(shape)
    return orient(part) if not part.is_empty else part


def largest(shape: shapely.Geometry) -> shapely.Polygon:
    """Return the largest polygon of a shape, or an empty one."""
    return max(polygons(shape), key=lambda p: p.area, default=shapely.Polygon())


def polygons(shape: shapely.Geometry | Iterable[shapely.Geometry]) -> list[shapely.Polygon]:
    """Return the polygons that a shape consists of."""
    parts = shapely.get_parts(shapely.get_parts(shape))
    return [part for part in parts if isinstance(part, shapely.Polygon) and not part.is_empty]
