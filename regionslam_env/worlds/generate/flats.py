"""Dwellings: a short hall with rooms on either side and the living room at its end, or one room with kitchen and bath.

Drawn like a room of a band: x along the corridor, y away from it, the entrance door at the corridor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from regionslam_env.worlds.generate.draft import Box, Draft, Gap, Room
from regionslam_env.worlds.generate.filling import Cell, draw
from regionslam_env.worlds.generate.furniture import furnish

DOOR = 9
BATH = (18, 24)
"""Extent of a bathroom across the hall, dm."""

OPEN_KITCHENS = 0.6
"""Share of the kitchens beside the living room that have no door to it."""

EXTENT = {"toilet": (18, 26), "kitchen": (24, 34), "bedroom": (28, 38), "storage": (14, 20), "office": (24, 32)}
"""Extent of rooms along the hall, dm."""

LAYOUT_OF = {
    "living room": "living room",
    "bedroom": "bedroom",
    "kitchen": "small kitchen",
    "storage": "shelves",
    "office": "office",
    "toilet": "",
    "hallway": "",
}


TITLES = {"toilet": "bathroom", "office": "study"}


def build_flat(
    part: Draft,
    cell: Cell,
    hallway_at: Callable[[int, int], Room | None],
    clutter: float,
    rng: np.random.Generator,
) -> None:
    """Add a dwelling to a draft: its rooms, their doors, the entrance door and furniture."""
    box = (cell.x0, cell.front, cell.x1, cell.depth)
    entrances = [x for x in range(cell.x0 + 2, cell.x1 - DOOR - 1) if hallway_at(x - 1, x + DOOR + 1)]
    flat = _studio(part, box, rng) if cell.width < 62 else _flat(part, box, entrances, rng)
    low, high = flat.entrance
    places = [x for x in entrances if low + 1 <= x and x + DOOR <= high - 1]
    places = places or [x for x in range(low, high - DOOR + 1) if hallway_at(x, x + DOOR)]
    start = min(places, key=lambda x: abs(2 * x + DOOR - low - high))
    corridor = hallway_at(start, start + DOOR)
    assert corridor is not None
    part.gaps.append(Gap(0, cell.front, start, start + DOOR, (flat.hall, corridor)))
    furnish_flat(part, clutter, rng)


def lone_flat(part: Draft, box: Box, clutter: float, rng: np.random.Generator, rooms: int) -> None:
    """Add a dwelling without an entrance door, of about so many rooms."""
    if rooms <= 3:
        _studio(part, box, rng)
    else:
        _flat(part, box, [], rng)
    furnish_flat(part, clutter, rng)


def furnish_flat(part: Draft, clutter: float, rng: np.random.Generator) -> None:
    """Add furniture to every room of a dwelling."""
    for room in part.rooms:
        furnish(part, room, LAYOUT_OF[room.type], clutter, rng)


@dataclass(frozen=True)
class _Flat:
    """The room behind the entrance, and between which x (dm) its door may be."""

    hall: Room
    entrance: tuple[int, int]


def _studio(part: Draft, box: Box, rng: np.random.Generator) -> _Flat:
    """Return a living room around a bathroom, and around a kitchen niche where it is wide enough."""
    x0, y0, x1, y1 = box
    bath, depth = draw(rng, BATH), draw(rng, (20, 26))
    left = rng.random() < 0.5
    kitchen = draw(rng, (20, 24)) if x1 - x0 - bath >= 44 and rng.random() < 0.7 else 0
    low = x0 + (bath if left else kitchen)
    high = x1 - (kitchen if left else bath)
    living = Room("living room", [(low, y0, high, y0 + depth), (x0, y0 + depth, x1, y1)], axis=1)
    part.rooms.append(living)
    corner = Room("toilet", [(x0, y0, low, y0 + depth) if left else (high, y0, x1, y0 + depth)], title="bathroom")
    part.rooms.append(corner)
    door = y0 + (depth - DOOR) // 2
    part.gaps.append(Gap(1, low if left else high, door, door + DOOR, (corner, living)))
    if kitchen:
        niche = Room("kitchen", [(high, y0, x1, y0 + depth) if left else (x0, y0, low, y0 + depth)])
        part.rooms.append(niche)
        start, end = (high, x1) if left else (x0, low)
        part.gaps.append(Gap(0, y0 + depth, start + 3, end - 3, (niche, living), door=False))
    return _Flat(living, (low, high))


def _flat(part: Draft, box: Box, entrances: list[int], rng: np.random.Generator) -> _Flat:
    """Return a hall with rooms on its left and right, and the living room across its end."""
    x0, y0, x1, y1 = box
    hall = draw(rng, (13, 17))
    side = x1 - x0 - hall
    wished = 0 if side < 52 else int(side * (0.38 + 0.24 * rng.random()))
    places = [*(range(25, side - 24) if side >= 52 else ()), 0, side]
    possible = [left for left in places if _leads_out(x0 + left, x0 + left + hall, entrances)]
    low = x0 + min(possible or places, key=lambda left: abs(left - wished))
    top = y1 - draw(rng, (36, 46)) if y1 - y0 >= 76 else y1 - 34
    passage = Room("hallway", [(low, y0, low + hall, top)], axis=1, title="hall")
    living = Room("living room", [(x0, top, x1, y1)])
    part.rooms += [passage, living]
    columns = [(x0, low, low), (low + hall, x1, low + hall)]  # from x to x, wall to the hall
    columns = [column for column in columns if column[1] - column[0] >= 24]
    if rng.random() < 0.5:
        columns.reverse()
    missing = ["toilet", "kitchen"]
    for start, end, wall in columns:
        kinds = _stack(top - y0, missing, rng)
        missing = [kind for kind in missing if kind not in dict(kinds)]
        _add_stack(part, kinds, (start, y0, end, top), wall, passage, living, rng)
    middle = low + (hall - DOOR) // 2
    part.gaps.append(Gap(0, top, middle, middle + DOOR, (passage, living)))
    return _Flat(passage, (low, low + hall))


def _leads_out(low: int, high: int, entrances: list[int]) -> bool:
    """Return whether an entrance door fits between low and high (dm); anywhere in a dwelling that has none."""
    return not entrances or any(low + 1 <= x and x + DOOR <= high - 1 for x in entrances)


def _stack(length: int, missing: list[str], rng: np.random.Generator) -> list[tuple[str, int]]:
    """Return (type, extent along the hall) of the rooms on one side of a hall, from the entrance on, dm.

    What a dwelling must have comes first, then bedrooms with a store room or a second bathroom between them.
    """
    kinds = list(missing)
    small = ["storage", "toilet"] if rng.random() < 0.7 else ["storage", "office"]
    kinds += ["bedroom", "bedroom", small[0], "bedroom", small[1], "bedroom", "bedroom"]
    if not missing and rng.random() < 0.25:
        kinds.insert(0, "storage")
    chosen: list[str] = []
    for kind in kinds:
        if sum(EXTENT[k][0] for k in (*chosen, kind)) <= length:
            chosen.append(kind)
        else:
            break
    if "kitchen" in chosen:  # beside the living room
        chosen.sort(key=lambda kind: kind == "kitchen")
    wished = [draw(rng, EXTENT[kind]) for kind in chosen]
    extents = [max(wish * length // sum(wished), EXTENT[kind][0]) for kind, wish in zip(chosen, wished, strict=True)]
    while sum(extents) != length:
        widest = max(range(len(extents)), key=lambda i: (extents[i] - EXTENT[chosen[i]][0], i))
        extents[widest] += length - sum(extents) if sum(extents) < length else -1
    return list(zip(chosen, extents, strict=True))


def _add_stack(
    part: Draft,
    kinds: list[tuple[str, int]],
    box: Box,
    wall: int,
    passage: Room,
    living: Room,
    rng: np.random.Generator,
) -> None:
    """Add the rooms on one side of the hall, each with a door to it or, a kitchen, open to the living room."""
    x0, y, x1, top = box
    for type_, extent in kinds:
        room = Room(type_, [(x0, y, x1, y + extent)], title=TITLES.get(type_, ""))
        part.rooms.append(room)
        if type_ == "kitchen" and y + extent == top and rng.random() < OPEN_KITCHENS:
            width = min(x1 - x0 - 6, 24)
            start = (x0 + x1 - width) // 2
            part.gaps.append(Gap(0, top, start, start + width, (room, living), door=False))
        else:
            start = y + 2 if rng.random() < 0.5 else y + extent - DOOR - 2
            part.gaps.append(Gap(1, wall, start, start + DOOR, (room, passage)))
        y += extent
