"""Rooms along a corridor: walls, doors, bathrooms in corners, neighbours that reach around; then their furniture.

Everything is drawn in the band's own frame, x along the corridor and y away from it, and then turned into place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from regionslam_env.worlds.generate.draft import Box, Draft, Gap, Room, Turn
from regionslam_env.worlds.generate.filling import Cell, draw
from regionslam_env.worlds.generate.flats import build_flat
from regionslam_env.worlds.generate.furniture import furnish

DOOR = 9
"""Least width of a door, dm."""

BATH = (18, 20)
"""Extent of a corner bathroom along the corridor, dm."""

BATH_DEPTH = (19, 22)

SIDE_DOORS = 0.3
"""Share of the rooms beside a crossing that have their door there."""


@dataclass(frozen=True)
class Beside:
    """What a segment of band adjoins: the hallways in front of it, and the crossings at its ends."""

    hallways: Sequence[tuple[int, int, Room]]
    start: Room | None = None
    end: Room | None = None

    def at(self, low: int, high: int) -> Room | None:
        """Return the hallway that has all of low to high (dm), None across a joint."""
        return next((room for x0, x1, room in self.hallways if x0 <= low and high <= x1), None)


def build_segment(
    draft: Draft, cells: Sequence[Cell], turn: Turn, beside: Beside, clutter: float, rng: np.random.Generator
) -> None:
    """Add the rooms of a segment to a draft; `turn` puts the band's frame into place."""
    local = Draft()
    taken: set[int] = set()
    for i, cell in enumerate(cells):
        behind = [] if cell.standard or not cell.plan.wraps else _behind(cells, i, taken)
        own = np.random.default_rng(cell.standard.seed) if cell.standard is not None else rng
        part = Draft()
        if cell.plan.layout == "flat":
            build_flat(part, cell, beside.at, clutter, own)
        else:
            crossings = []
            if i == 0 and beside.start is not None:
                crossings.append((cell.x0, beside.start))
            if i == len(cells) - 1 and beside.end is not None:
                crossings.append((cell.x1, beside.end))
            _build_room(part, cell, behind, beside, crossings, clutter, own)
        local.add(part)
    local.transform(turn)
    draft.add(local)


def _behind(cells: Sequence[Cell], i: int, taken: set[int]) -> list[Box]:
    """Return the boxes at the back of shallower neighbours, which a room takes over."""
    boxes = []
    for k in (i - 1, i + 1):
        if 0 <= k < len(cells) and k not in taken and cells[i].depth - cells[k].depth >= 18:
            taken.add(k)
            boxes.append((cells[k].x0, cells[k].depth, cells[k].x1, cells[i].depth))
    return boxes


def _build_room(
    part: Draft,
    cell: Cell,
    behind: list[Box],
    beside: Beside,
    crossings: Sequence[tuple[int, Room]],
    clutter: float,
    rng: np.random.Generator,
) -> None:
    """Add a room with its bathroom, if any, and its door: to the corridor or a crossing (x of the wall, hallway)."""
    plan = cell.plan
    room = Room(plan.type, [(cell.x0, cell.front, cell.x1, cell.depth), *behind], title=plan.title)
    part.rooms.append(room)
    low, high = cell.x0, cell.x1
    if plan.bath and cell.width >= 36 and cell.depth - cell.front >= 46:
        low, high = _add_bath(part, room, cell, beside, rng)
    if crossings and cell.standard is None and not plan.bath and plan.door < 12 and rng.random() < SIDE_DOORS:
        at, side = crossings[0]
        start = cell.front + 3 if rng.random() < 0.5 else cell.depth - 3 - plan.door
        part.gaps.append(Gap(1, at, start, start + plan.door, (room, side)))
    else:
        share = cell.standard.door if cell.standard is not None else None
        part.gaps.append(door_to(beside, room, cell.front, low, high, plan.door, rng, share))
    furnish(part, room, plan.layout, clutter, rng)


def door_to(
    beside: Beside,
    room: Room,
    at: int,
    low: int,
    high: int,
    width: int,
    rng: np.random.Generator,
    share: float | None = None,
) -> Gap:
    """Return a door from a room to the hallway, between low and high (dm): near one end, in the middle of long ones."""
    margin = min(4, (high - low - width) // 2)
    places = [x for x in range(low + margin, high - margin - width + 1) if beside.at(x - 1, x + width + 1)]
    if not places:  # a joint of two hallways is in the way
        width = min(width, DOOR)
        places = [x for x in range(low, high - width + 1) if beside.at(x, x + width)]
    usual = rng.random() if share is None else share
    if high - low >= 80 or width >= 14:
        wish = low + (high - low - width) * (0.3 + 0.4 * usual)
    else:
        wish = low + margin if usual < 0.5 else high - margin - width
    start = min(places, key=lambda x: abs(x - wish))
    hallway = beside.at(start, start + width)
    assert hallway is not None
    return Gap(0, at, start, start + width, (room, hallway))


def _has_door(beside: Beside, low: int, high: int) -> bool:
    """Return whether a stretch of the corridor's side has a place for a door."""
    return any(beside.at(x, x + DOOR) for x in range(low, high - DOOR + 1))


def _add_bath(part: Draft, room: Room, cell: Cell, beside: Beside, rng: np.random.Generator) -> tuple[int, int]:
    """Cut a bathroom out of a room's corner at the corridor; return the rest of the corridor's side (dm)."""
    width, depth = draw(rng, BATH), draw(rng, BATH_DEPTH)
    left = rng.random() < 0.5
    if not _has_door(beside, *((cell.x0 + width, cell.x1) if left else (cell.x0, cell.x1 - width))):
        left = not left
        if not _has_door(beside, *((cell.x0 + width, cell.x1) if left else (cell.x0, cell.x1 - width))):
            return cell.x0, cell.x1
    x0, x1, y = cell.x0, cell.x1, cell.front + depth
    low, high = (x0 + width, x1) if left else (x0, x1 - width)
    room.boxes, room.axis = [(low, cell.front, high, y), (x0, y, x1, cell.depth)], 1
    start, end = (x0, x0 + width) if left else (x1 - width, x1)
    bath = Room("toilet", [(start, cell.front, end, y)], title="bathroom")
    part.rooms.append(bath)
    door = cell.front + (depth - 9) // 2
    part.gaps.append(Gap(1, low if left else high, door, door + 9, (bath, room)))
    return low, high
