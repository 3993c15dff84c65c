"""From a draft in decimetres to a world in metres: walls raised on the borders, names given, links set."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable

import numpy as np

from regionslam_env.worlds.floorplan import Opening, assemble
from regionslam_env.worlds.generate.draft import Box, Draft, Gap, Room, sides
from regionslam_env.worlds.world import Region, World
from slam.rows import Floats, Row

PER_METRE = 10
"""Decimetres."""

Interval = tuple[int, int]


def raise_world(name: str, draft: Draft) -> World:
    """Return the world of a draft."""
    numbers: Counter[str] = Counter()
    regions = {room: _region(room, numbers) for room in draft.rooms}
    gaps = sorted(draft.gaps, key=lambda gap: not gap.door)  # doors first, which are numbered
    openings = [_opening(f"door {k + 1}", gap, regions) for k, gap in enumerate(gaps)]
    furniture = []
    for item in draft.items:
        numbers[item.type] += 1
        label = f"{item.type} {numbers[item.type]}"
        furniture.append(Region(label, item.type, label, _row([item.box], None), parent=regions[item.room].id))
    walls = np.array(walls_of(draft), dtype=np.float64).reshape(-1, 4) / PER_METRE
    return assemble(name, list(regions.values()), openings, furniture, borders=[], jambs=walls)


def walls_of(draft: Draft) -> list[tuple[int, int, int, int]]:
    """Return the walls x0, y0, x1, y1 (dm) around all rooms, joined along each line, with the gaps cut."""
    solid: dict[tuple[int, int], list[Interval]] = defaultdict(list)
    open_: dict[tuple[int, int], list[Interval]] = defaultdict(list)
    for room in draft.rooms:
        for axis, at, low, high in sides(room):
            solid[axis, at].append((low, high))
    for gap in draft.gaps:
        open_[gap.axis, gap.at].append((gap.low, gap.high))
    walls = []
    for (axis, at), intervals in sorted(solid.items()):
        for low, high in _without(_united(intervals), _united(open_[axis, at])):
            walls.append((low, at, high, at) if axis == 0 else (at, low, at, high))
    return walls


def _united(intervals: Iterable[Interval]) -> list[Interval]:
    """Return the union of intervals, ascending; those that touch become one."""
    united: list[Interval] = []
    for low, high in sorted(intervals):
        if united and low <= united[-1][1]:
            united[-1] = (united[-1][0], max(united[-1][1], high))
        else:
            united.append((low, high))
    return united


def _without(intervals: list[Interval], cuts: list[Interval]) -> list[Interval]:
    """Return what the cuts leave of some intervals; both ascending and apart."""
    left = []
    for low, high in intervals:
        for start, end in cuts:
            if end <= low or start >= high:
                continue
            if start > low:
                left.append((low, start))
            low = end
        if low < high:
            left.append((low, high))
    return left


def _region(room: Room, numbers: Counter[str]) -> Region:
    numbers[room.type] += 1
    label = f"{room.type} {numbers[room.type]}"
    name = room.title or label
    return Region(label, room.type, f"{name}, {room.building}" if room.building else name, _row(room.boxes, room.axis))


def _row(boxes: list[Box], axis: int | None) -> Row:
    """Return the row of boxes along an axis; a single box lies along its longer side where none is given."""
    if axis is None or len(boxes) == 1:
        x0, y0, x1, y1 = boxes[0]
        axis = 0 if x1 - x0 >= y1 - y0 else 1
    # Turned by a right angle, the row's first axis is y, its second one -x.
    local = sorted(box if axis == 0 else (box[1], -box[2], box[3], -box[0]) for box in boxes)
    sizes = [(u1 - u0) * (t - b) for u0, b, u1, t in local]
    main = 1 if len(local) == 3 else sizes.index(max(sizes))
    u0, b, u1, t = local[main]
    along, across = (u0 + u1) / 2, (b + t) / 2
    left, right = (_beside(local[k], across) if 0 <= k < len(local) else None for k in (main - 1, main + 1))
    x, y = (along, across) if axis == 0 else (-across, along)
    phi = 0.0 if axis == 0 else np.pi / 2
    return Row.from_parameters(
        x / PER_METRE, y / PER_METRE, (u1 - u0) / PER_METRE, (t - b) / PER_METRE, phi, left, right
    )


def _beside(box: Box, across: float) -> tuple[float, float, float]:
    """Return width, height and displacement (m) of a subrectangle from the middle of the main one, dm."""
    u0, b, u1, t = box
    return (u1 - u0) / PER_METRE, (t - b) / PER_METRE, ((b + t) / 2 - across) / PER_METRE


def _ends(gap: Gap) -> Floats:
    low, high = ((gap.low, gap.at), (gap.high, gap.at)) if gap.axis == 0 else ((gap.at, gap.low), (gap.at, gap.high))
    return np.array([*low, *high], dtype=np.float64) / PER_METRE


def _opening(name: str, gap: Gap, regions: dict[Room, Region]) -> Opening:
    first, second = (regions[room].id for room in gap.rooms)
    x0, y0, x1, y1 = _ends(gap).tolist()
    return Opening(name, (first, second), x0, y0, x1, y1, name=name, door=gap.door)
