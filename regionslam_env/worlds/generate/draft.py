"""A floor while it is being drawn: rooms, gaps in walls and furniture in whole decimetres, so that borders coincide.

A box is x0, y0, x1, y1. A wall runs along axis 0 (x) at a fixed y, or along axis 1 (y) at a fixed x.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

Box = tuple[int, int, int, int]
"""Smallest x and y, largest x and y, dm."""


@dataclass(eq=False)
class Room:
    """A place: one to three boxes in a row along an axis (0: x, 1: y).

    `building` names where it is, on a campus.
    """

    type: str
    boxes: list[Box]
    axis: int = 0
    title: str = ""
    building: str = ""

    @property
    def largest(self) -> Box:
        """The largest box; the first one of equals."""
        return max(self.boxes, key=lambda box: (box[2] - box[0]) * (box[3] - box[1]))


@dataclass(eq=False)
class Gap:
    """A gap in the wall between two rooms, from `low` to `high` along a wall's axis; with a door in it or without."""

    axis: int
    at: int
    low: int
    high: int
    rooms: tuple[Room, Room]
    door: bool = True


@dataclass(eq=False)
class Item:
    """A piece of furniture in a room."""

    type: str
    box: Box
    room: Room


@dataclass
class Draft:
    """Everything drawn so far."""

    rooms: list[Room] = field(default_factory=list)
    gaps: list[Gap] = field(default_factory=list)
    items: list[Item] = field(default_factory=list)

    @property
    def size(self) -> int:
        """Number of regions: rooms, doors and furniture."""
        return len(self.rooms) + sum(gap.door for gap in self.gaps) + len(self.items)

    @property
    def bounds(self) -> Box:
        """The box around all rooms."""
        boxes = [box for room in self.rooms for box in room.boxes]
        x0, y0, x1, y1 = zip(*boxes, strict=True)
        return min(x0), min(y0), max(x1), max(y1)

    def add(self, other: Draft) -> None:
        """Take over everything of another draft."""
        self.rooms += other.rooms
        self.gaps += other.gaps
        self.items += other.items

    def transform(self, turn: Turn) -> None:
        """Move everything."""
        for room in self.rooms:
            room.boxes = [turn.box(box) for box in room.boxes]
            room.axis = 1 - room.axis if turn.swap else room.axis
        for gap in self.gaps:
            gap.axis, gap.at, gap.low, gap.high = turn.wall((gap.axis, gap.at, gap.low, gap.high))
        for item in self.items:
            item.box = turn.box(item.box)


@dataclass(frozen=True)
class Turn:
    """A mirroring along x and y, then the two axes swapped or not, then a shift (dm)."""

    flip_x: bool = False
    flip_y: bool = False
    swap: bool = False
    dx: int = 0
    dy: int = 0

    def point(self, x: int, y: int) -> tuple[int, int]:
        """Return where a point goes."""
        x, y = (-x if self.flip_x else x), (-y if self.flip_y else y)
        x, y = (y, x) if self.swap else (x, y)
        return x + self.dx, y + self.dy

    def box(self, box: Box) -> Box:
        """Return where a box goes."""
        (x0, y0), (x1, y1) = self.point(box[0], box[1]), self.point(box[2], box[3])
        return min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)

    def wall(self, wall: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
        """Return where a wall (axis, at, low, high) goes."""
        axis, at, low, high = wall
        x0, y0, x1, y1 = self.box((low, at, high, at) if axis == 0 else (at, low, at, high))
        axis = 1 - axis if self.swap else axis
        return (axis, y0, x0, x1) if axis == 0 else (axis, x0, y0, y1)


def sides(room: Room) -> Iterator[tuple[int, int, int, int]]:
    """Yield the walls (axis, at, low, high) around a room; none between its own boxes."""
    along = room.axis
    boxes = sorted((box if along == 0 else (box[1], box[0], box[3], box[2])) for box in room.boxes)
    for u0, b, u1, t in boxes:
        yield along, b, u0, u1
        yield along, t, u0, u1
    first, last = boxes[0], boxes[-1]
    yield 1 - along, first[0], first[1], first[3]
    yield 1 - along, last[2], last[1], last[3]
    for (_, b, u, t), (_, next_b, _, next_t) in itertools.pairwise(boxes):
        if b != next_b:
            yield 1 - along, u, min(b, next_b), max(b, next_b)
        if t != next_t:
            yield 1 - along, u, min(t, next_t), max(t, next_t)
