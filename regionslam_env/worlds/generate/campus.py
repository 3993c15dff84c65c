"""A campus: buildings along paths between hedges, which are walls to robot and sensors; each has its door to a path."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from regionslam_env.worlds.generate.building import Building, draw_building
from regionslam_env.worlds.generate.draft import Draft, Gap, Room, Turn
from regionslam_env.worlds.generate.filling import draw
from regionslam_env.worlds.generate.furniture import furnish
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.generate.programs import KITCHEN, PROGRAMS, RoomPlan

KINDS = ("office", "school", "hospital", "apartment")
SHARES = (0.5, 0.3, 0.05, 0.15)
"""What the buildings of a campus are like."""

PAVILION = 2.5
"""Buildings of fewer rooms than this have only one."""

PAVILIONS = (
    RoomPlan("classroom", (50, 80), layout="classroom", title="lecture room"),
    RoomPlan("storage", (50, 80), layout="shelves", title="workshop"),
    KITCHEN,
    RoomPlan("office", (50, 80), layout="office", title="gatehouse"),
)

STREET = (40, 60)
"""Width of the paths between buildings, dm."""

ACCESS = (22, 30)
"""Width of the way to a building's door, dm."""

LAWN = (30, 70)
"""Distance of buildings from the path and from each other, dm."""

BLOCK = 350
"""Longest stretch of path that counts as one place, dm."""


@dataclass
class _Site:
    """A building turned towards its path, from (0, 0) to width and depth; `door` is in its draft."""

    draft: Draft
    door: Gap
    width: int
    depth: int


def draw_campus(rooms: int, options: WorldOptions, rng: np.random.Generator) -> Draft:
    """Return buildings with about so many rooms in all, along one or more parallel paths."""
    each = draw(rng, (4, 12)) * max(1.0, (rooms / 80) ** 0.3)
    count = max(2 if rooms > 2 else 1, round(rooms / each))
    shares = rng.dirichlet(np.full(count, 4.0)) * rooms
    sites = []
    for number, share in enumerate(shares):
        if share < PAVILION:
            building = _pavilion(options, rng)
        else:
            kind = KINDS[int(rng.choice(len(KINDS), p=SHARES))]
            building = draw_building(PROGRAMS[kind], round(share), options, rng)
        sites.append(_turned(building, f"building {number + 1}", rng))
    return _along_paths(sites, rng)


def _pavilion(options: WorldOptions, rng: np.random.Generator) -> Building:
    """Return a building of one room."""
    plan = PAVILIONS[int(rng.integers(len(PAVILIONS)))]
    room = Room(plan.type, [(0, 0, draw(rng, (50, 80)), draw(rng, (40, 60)))], title=plan.title)
    middle = room.boxes[0][2] // 2
    door = Gap(0, 0, middle - 8, middle + 8, (room, room))
    draft = Draft([room])
    furnish(draft, room, plan.layout, options.clutter, rng, keep_free=(door,))
    return Building(draft, [door])


def _turned(building: Building, name: str, rng: np.random.Generator) -> _Site:
    """Return a building with one of its doors looking down, its lowest point at y = 0 and its leftmost at x = 0."""
    draft = building.draft
    free = [gap for gap in building.entrances if _is_free(draft, gap)] or building.entrances
    best = [gap for gap in free if gap.rooms[0].type == "lobby"] or free
    door = best[int(rng.integers(len(best)))]
    draft.gaps.append(door)
    draft.transform(Turn(swap=door.axis == 1))
    if _outward(door) > 0:
        draft.transform(Turn(flip_y=True))
    x0, y0, x1, y1 = draft.bounds
    draft.transform(Turn(dx=-x0, dy=-y0))
    for place in draft.rooms:
        place.building = name
    return _Site(draft, door, x1 - x0, y1 - y0)


def _outward(door: Gap) -> int:
    """Return on which side of a door to the outside that is: -1 or 1 across its axis."""
    across = 1 - door.axis
    inside = (b for b in door.rooms[0].boxes if b[door.axis] <= door.low and door.high <= b[door.axis + 2])
    return -1 if any(box[across] == door.at for box in inside) else 1


def _is_free(draft: Draft, door: Gap) -> bool:
    """Return whether the way straight out of a door meets no other part of the building."""
    side, along, across = _outward(door), door.axis, 1 - door.axis
    low, high = (door.low + door.high - ACCESS[1]) // 2, (door.low + door.high + ACCESS[1]) // 2
    beside = [b for room in draft.rooms for b in room.boxes if b[along] < high and b[along + 2] > low]
    return all(box[across] >= door.at if side < 0 else box[across + 2] <= door.at for box in beside)


def _along_paths(sites: list[_Site], rng: np.random.Generator) -> Draft:
    """Put buildings on both sides of parallel paths, which cross paths join."""
    total = sum(site.width + LAWN[1] for site in sites)
    deep = float(np.mean([site.depth for site in sites])) + LAWN[0]
    streets = max(1, round(float(np.sqrt(total / (2 * 1.6 * (2 * deep + STREET[0]))))))
    per_side = [sites[i :: 2 * streets] for i in range(2 * streets)]
    campus, y, length = Draft(), 0, 0
    paths: list[tuple[int, int, list[Gap]]] = []  # from y to y, doors of its buildings
    for street in range(streets):
        south, north = per_side[2 * street], per_side[2 * street + 1]
        setbacks = {id(site): draw(rng, LAWN) for site in (*south, *north)}
        y += max((site.depth + setbacks[id(site)] for site in south), default=0)
        width = draw(rng, STREET)
        for side, row in ((-1, south), (1, north)):
            edge = y if side < 0 else y + width
            x = draw(rng, LAWN) + STREET[1]
            for site in row:
                back = edge + side * setbacks[id(site)]
                site.draft.transform(Turn(flip_y=side < 0, dx=x, dy=back))
                campus.add(site.draft)
                x += site.width + draw(rng, LAWN)
            length = max(length, x)
        paths.append((y, y + width, [site.door for site in (*south, *north)]))
        y += width + max((site.depth + setbacks[id(site)] for site in north), default=0) + LAWN[0]
    _pave(campus, paths, length + STREET[1] if streets > 1 else length, rng)
    return campus


def _pave(
    campus: Draft,
    paths: list[tuple[int, int, list[Gap]]],
    length: int,
    rng: np.random.Generator,
) -> None:
    """Add the paths, the ways to the doors, and paths across at both ends that close loops."""
    across: list[tuple[Room, Room]] = []  # of each path: its first and its last stretch
    for low, high, doors in paths:
        count = -(-length // BLOCK)
        limits = [0, *(_beside_doors(round(length * k / count), doors) for k in range(1, count)), length]
        stretches = []
        for x0, x1 in itertools.pairwise(limits):
            stretches.append(_ground(campus, (x0, low, x1, high), "path"))
        for one, other in itertools.pairwise(stretches):
            campus.gaps.append(Gap(1, one.boxes[0][2], low, high, (one, other), door=False))
        for door in doors:
            room = door.rooms[0]
            width = draw(rng, ACCESS)
            stretch = next(s for s in stretches if door.high <= s.boxes[0][2])
            start = (door.low + door.high - width) // 2
            edge = low if door.at < low else high
            way = _ground(campus, (start, min(door.at, edge), start + width, max(door.at, edge)), "way")
            campus.gaps.append(Gap(0, edge, start, start + width, (way, stretch), door=False))
            door.rooms = (way, room)
        across.append((stretches[0], stretches[-1]))
    for (first, last), (next_first, next_last) in itertools.pairwise(across):
        for x0, one, other in ((0, first, next_first), (length - STREET[0], last, next_last)):
            y0, y1 = one.boxes[0][3], other.boxes[0][1]
            path = _ground(campus, (x0, y0, x0 + STREET[0], y1), "path")
            campus.gaps.append(Gap(0, y0, x0, x0 + STREET[0], (one, path), door=False))
            campus.gaps.append(Gap(0, y1, x0, x0 + STREET[0], (path, other), door=False))


def _beside_doors(x: int, doors: list[Gap]) -> int:
    """Return the place nearest to x where no way to a door meets the path."""
    reach = ACCESS[1]
    tried = (x + sign * k for k in range(10_000) for sign in (1, -1))
    return next(place for place in tried if not any(d.low - reach < place < d.high + reach for d in doors))


def _ground(campus: Draft, box: tuple[int, int, int, int], title: str) -> Room:
    x0, y0, x1, y1 = box
    room = Room("outdoor", [box], axis=0 if x1 - x0 >= y1 - y0 else 1, title=title)
    campus.rooms.append(room)
    return room
