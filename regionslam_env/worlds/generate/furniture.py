"""Furniture: against walls, in the middle or in rows, such that a robot still gets everywhere.

Two pieces either stand flush along one wall or leave a gap of `GAP`; so do a piece and a wall. In front of doors there
is nothing. What is left of a room is then in one piece, and every door leads to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from regionslam_env.worlds.generate.draft import Box, Draft, Gap, Item, Room
from regionslam_env.worlds.generate.filling import draw
from regionslam_env.worlds.generate.programs import Range

GAP = 9
"""Least width of a way between furniture, dm."""

DOORWAY = 10
"""Depth of the free floor in front of a door, dm."""

TRIES = 12
"""Places that are tried for one piece."""


@dataclass(frozen=True)
class Wish:
    """A piece of furniture that a room would like.

    Parameters
    ----------
    type
        Semantic type.
    along, off
        Extent along the wall and off it, or along x and y, dm.
    place
        "wall": anywhere along one; "middle": in the middle of the room, as long as it allows; "rows": in rows all over.
    """

    type: str
    along: Range
    off: Range
    place: str = "wall"


DESK = Wish("desk", (14, 18), (7, 8))
CUPBOARD = Wish("cupboard", (8, 14), (4, 5))
SOFA = Wish("sofa", (16, 22), (8, 9))

LAYOUTS: Mapping[str, tuple[Wish, ...]] = {
    "office": (DESK, CUPBOARD, DESK, Wish("table", (8, 12), (8, 10), "middle")),
    "open plan": (Wish("desk", (16, 18), (14, 16), "rows"), CUPBOARD, CUPBOARD),
    "meeting": (Wish("table", (18, 60), (10, 14), "middle"), CUPBOARD),
    "laboratory": (Wish("table", (16, 20), (8, 10), "rows"), CUPBOARD, DESK, CUPBOARD),
    "kitchen": (Wish("cupboard", (20, 32), (6, 6)), Wish("table", (8, 14), (8, 8), "middle"), CUPBOARD),
    "canteen": (Wish("table", (16, 20), (8, 8), "rows"), Wish("cupboard", (30, 44), (6, 6))),
    "lobby": (SOFA, DESK, SOFA, CUPBOARD),
    "shelves": (CUPBOARD, CUPBOARD),
    "classroom": (Wish("desk", (13, 14), (6, 6), "rows"), Wish("table", (14, 16), (7, 7)), CUPBOARD),
    "ward": (Wish("bed", (9, 10), (20, 21)), Wish("cupboard", (8, 10), (5, 6)), Wish("bed", (9, 10), (20, 21))),
    "living room": (SOFA, CUPBOARD, Wish("table", (8, 14), (8, 9), "middle"), SOFA, CUPBOARD),
    "bedroom": (Wish("bed", (14, 18), (20, 21)), Wish("cupboard", (12, 20), (6, 6)), DESK),
    "small kitchen": (Wish("cupboard", (18, 28), (6, 6)), Wish("table", (7, 9), (7, 8), "middle")),
    "": (),
}
"""What stands in rooms, most important first."""


def furnish(
    draft: Draft,
    room: Room,
    layout: str,
    clutter: float,
    rng: np.random.Generator,
    keep_free: Sequence[Gap] = (),
) -> None:
    """Add furniture to the largest box of a room whose gaps are all in the draft, but for some to come."""
    wishes = LAYOUTS[layout]
    if not wishes or clutter == 0:
        return
    floor = Floor(room, [*draft.gaps, *keep_free])
    count = min(int(clutter * len(wishes) + rng.random()), len(wishes))
    for wish in wishes[: max(count, wishes[0].place == "rows")]:
        size = draw(rng, wish.along), draw(rng, wish.off)
        if wish.place == "rows":
            boxes = [box for box in _rows(floor, *size) if floor.fits(box)]
            boxes = boxes[: int(clutter * len(boxes) + 0.9)]
        elif wish.place == "middle":
            boxes = _middle(floor, wish, *size)
        else:
            boxes = _against_wall(floor, *size, rng)
        for box in boxes:
            if floor.put(box):
                draft.items.append(Item(wish.type, box, room))


class Floor:
    """The free floor of a room's largest box.

    Parameters
    ----------
    room
        To be furnished.
    gaps
        All gaps so far; those in the walls of the box keep the floor before them free.
    """

    def __init__(self, room: Room, gaps: list[Gap]) -> None:
        self.box = room.largest
        self.taken: list[Box] = []
        self.free: list[Box] = [
            _before(self.box, gap.axis, gap.at, gap.low - 1, gap.high + 1, DOORWAY) for gap in gaps if room in gap.rooms
        ]
        for other in room.boxes:
            if other != self.box:
                x0, y0, x1, y1 = self.box
                ax0, ay0, ax1, ay1 = other
                if ax1 == x0 or ax0 == x1:
                    self.free.append(_before(self.box, 1, x0 if ax1 == x0 else x1, ay0, ay1, GAP))
                else:
                    self.free.append(_before(self.box, 0, y0 if ay1 == y0 else y1, ax0, ax1, GAP))

    def fits(self, box: Box) -> bool:
        """Return whether a piece can stand there."""
        room = self.box
        if not all(
            d == 0 or d >= GAP for d in (box[0] - room[0], box[1] - room[1], room[2] - box[2], room[3] - box[3])
        ):
            return False
        if any(_apart(box, zone) < 0 for zone in self.free):
            return False
        return all(_apart(box, other) >= GAP or self._flush(box, other) for other in self.taken)

    def put(self, box: Box) -> bool:
        """Take the place of a piece, if it can stand there."""
        if not self.fits(box):
            return False
        self.taken.append(box)
        return True

    def _flush(self, box: Box, other: Box) -> bool:
        """Return whether two pieces touch along the same wall."""
        return _apart(box, other) == 0 and any(box[k] == other[k] == self.box[k] for k in range(4))


def _apart(one: Box, other: Box) -> int:
    """Return the larger of the distances along x and y, dm; negative where the boxes overlap."""
    return max(one[0] - other[2], other[0] - one[2], one[1] - other[3], other[1] - one[3])


def _before(box: Box, axis: int, at: int, low: int, high: int, depth: int) -> Box:
    """Return the floor of a box before a part of one of its walls; empty for a part of another wall."""
    x0, y0, x1, y1 = box
    if axis == 0 and at in (y0, y1):
        return (low, y0, high, y0 + depth) if at == y0 else (low, y1 - depth, high, y1)
    if axis == 1 and at in (x0, x1):
        return (x0, low, x0 + depth, high) if at == x0 else (x1 - depth, low, x1, high)
    return x0, y0, x0, y0


def _against_wall(floor: Floor, along: int, off: int, rng: np.random.Generator) -> list[Box]:
    """Return a place against a wall where a piece fits: in a corner, beside another piece, or anywhere."""
    x0, y0, x1, y1 = floor.box
    for number in rng.integers(0, 1000, TRIES).tolist():
        wall, how = number % 4, number // 4 % 5
        axis = wall % 2  # walls: bottom, left, top, right
        low, high = (x0, x1) if axis == 0 else (y0, y1)
        if high - low < along:
            continue
        starts = [low, high - along]
        starts += [other[k] for other in floor.taken for k in (2 + axis,)]
        starts += [other[axis] - along for other in floor.taken]
        start = low + number * 7 % (high - low - along + 1) if how == 0 else starts[number // 20 % len(starts)]
        if start < low or start + along > high:
            continue
        if axis == 0:
            box = (start, y0, start + along, y0 + off) if wall == 0 else (start, y1 - off, start + along, y1)
        else:
            box = (x0, start, x0 + off, start + along) if wall == 1 else (x1 - off, start, x1, start + along)
        if floor.fits(box):
            return [box]
    return []


def _middle(floor: Floor, wish: Wish, along: int, off: int) -> list[Box]:
    """Return the place in the middle of a room, along its longer side, as long as a way is left all around."""
    x0, y0, x1, y1 = floor.box
    wide = x1 - x0 >= y1 - y0
    long, short = (x1 - x0, y1 - y0) if wide else (y1 - y0, x1 - x0)
    along, off = min(along, long - 2 * GAP - 4), min(off, short - 2 * GAP - 2)
    if along < wish.along[0] or off < wish.off[0]:
        return []
    size_x, size_y = (along, off) if wide else (off, along)
    x, y = (x0 + x1 - size_x) // 2, (y0 + y1 - size_y) // 2
    return [(x, y, x + size_x, y + size_y)]


def _rows(floor: Floor, along: int, off: int) -> list[Box]:
    """Return places in rows all over a room, evenly."""
    x0, y0, x1, y1 = floor.box
    columns, rows = ((high - low - GAP - 2) // (size + GAP + 1) for low, high, size in ((x0, x1, along), (y0, y1, off)))
    if columns < 1 or rows < 1:
        return []
    gap_x, gap_y = (x1 - x0 - columns * along) // (columns + 1), (y1 - y0 - rows * off) // (rows + 1)
    return [
        (x, y, x + along, y + off)
        for y in range(y0 + gap_y, y0 + gap_y + rows * (off + gap_y), off + gap_y)
        for x in range(x0 + gap_x, x0 + gap_x + columns * (along + gap_x), along + gap_x)
    ]
