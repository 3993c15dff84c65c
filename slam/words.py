"""What a robot says about where it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from slam.edges import Point, distance_to
from slam.naming import PASSAGES, Regions, belongs, called, door, object_in, storey_of
from slam.region import RegionFeature
from slam.relations import IN_FRONT_OF, NEXT_TO, at_the_end_of, in_front_of, in_the_middle_of
from slam.storeys import CONTAINERS, is_on

NEAR = 1.0
"""Outside of every region, one this near is named, m."""

LONG = 3.0
"""One speaks of the end of a region that is this many times as long as it is wide on average."""

SURE = 0.8
"""From this probability on, one doesn't speak of a doubt."""

PLAUSIBLE = 0.1
"""Rooms less probable than this are not mentioned."""


def describe(regions: Regions, point: Point, level: int = 0) -> str:
    """Return one sentence about where a point (x, y), m, of a level lies among mapped regions.

    The region around it with its storey and building, and then what is near: a door or a piece of furniture that it is
    next to (within 1.5 m) or in front of (2 m), the end of a long region, or the middle.
    """
    around = [region for region in regions.regions_at(*point, level) if region.type not in CONTAINERS]
    storey = storey_of(regions, point, level)
    if not around:
        return _outside(regions, point, level, storey)
    room = _room(regions, around)
    if around[0].type in PASSAGES:
        return f"I am in {door(regions, around[0], None)}{storey}."
    place = called(regions, room) + storey
    if around[0].id != room.id:
        return f"I am in {place}, at {object_in(regions, around[0], room)}."
    near = _what_is_near(regions, point, room)
    if near:
        return f"I am in {place}, {near}."
    if _is_long(room) and at_the_end_of(point, room):
        return f"I am at the end of {place}."
    if in_the_middle_of(point, room):
        return f"I am in the middle of {place}."
    return f"I am in {place}."


def doubt(regions: Regions, point: Point, level: int, probabilities: Mapping[int, float]) -> str:
    """Return "I am probably in office 2 (70 %) or office 3 (25 %)." if the room is in doubt, else "".

    It is if the likeliest room has less than `SURE`. Doors, furniture, storeys and buildings are no alternatives.
    """
    inside = regions.regions_at(*point, level)
    if inside and inside[0].type in PASSAGES:
        return ""
    rooms = [region for region in regions.regions if region.type not in PASSAGES | CONTAINERS and is_on(region, level)]
    rooms = [room for room in rooms if _parent(regions, room) is None]
    likely = sorted(rooms, key=lambda room: (-probabilities.get(room.id, 0.0), room.id))[:3]
    chances = [(room, probabilities.get(room.id, 0.0)) for room in likely]
    named = [f"{called(regions, room)} ({100 * chance:.0f} %)" for room, chance in chances if chance >= PLAUSIBLE]
    if len(named) < 2 or chances[0][1] >= SURE:
        return ""
    how = "probably" if chances[0][1] > 0.5 else "perhaps"
    return f"I am {how} in {', '.join(named[:-1])} or {named[-1]}{storey_of(regions, point, level)}."


def _room(regions: Regions, around: Sequence[RegionFeature]) -> RegionFeature:
    """Return the room among the regions around a point, innermost first: what isn't inside another one, or a door."""
    rooms = [region for region in around if region.type not in PASSAGES and _parent(regions, region) is None]
    if rooms:
        return rooms[0]
    above = [region for region in regions.ancestors(around[0]) if region.type not in CONTAINERS]
    return (above or list(around))[-1]


def _parent(regions: Regions, region: RegionFeature) -> RegionFeature | None:
    """Return the region that contains another, unless that is a storey or a building."""
    parent = regions.parent(region)
    return None if parent is None or parent.type in CONTAINERS else parent


def _outside(regions: Regions, point: Point, level: int, storey: str) -> str:
    """Return the sentence for a point in no room."""
    rooms = [region for region in regions.regions if region.type not in CONTAINERS and is_on(region, level)]
    near = [(distance_to(region.row, point), region.id, region) for region in rooms]
    distance, _, region = min(near, key=lambda entry: entry[:2], default=(float("inf"), 0, None))
    start = f"I am{storey}, " if storey else "I am "
    if region is None or distance > NEAR:
        return f"{start}in a place that I do not know yet."
    name = door(regions, region, None) if region.type in PASSAGES else called(regions, region)
    return f"{start}next to {name}."


def _what_is_near(regions: Regions, point: Point, room: RegionFeature) -> str:
    """Return "next to ..." or "in front of ..." for the nearest door, piece of furniture or linked region, or ""."""
    children = regions.children(room)
    doors = [region for region in regions.regions if region.type in PASSAGES and belongs(regions, region, room)]
    others = [region for region in regions.neighbours(room) if region.type not in PASSAGES | CONTAINERS]
    for candidates in ([*doors, *children], others):
        near = sorted((distance_to(region.row, point), region.id, region) for region in candidates)
        for distance, _, region in near:
            if distance > IN_FRONT_OF:
                break
            name = object_in(regions, region, room)
            if distance <= NEXT_TO:
                return f"next to {name}"
            if region not in others and in_front_of(point, region, room if region in children else None):
                return f"in front of {name}"
    return ""


def _is_long(region: RegionFeature) -> bool:
    row = region.row
    longest = max(row.u[-1] - row.u[0], row.t.max() - row.b.min())
    return bool(longest * longest >= LONG * row.area)
