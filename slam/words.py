"""What a robot says about where it is."""

from __future__ import annotations

from typing import Protocol

from slam.edges import Point, distance_to
from slam.region import RegionFeature
from slam.relations import IN_FRONT_OF, NEXT_TO, at_the_end_of, in_front_of, in_the_middle_of

PASSAGES = frozenset({"door", "doorway", "doors", "gate", "opening", "passage"})
"""Types of regions that one passes to get from one region to another."""

NEAR = 1.0
"""Outside of every region, one this near is named, m."""

TOUCHING = 0.5
"""A door this near to a region belongs to it even before the link is believed, m."""


LONG = 3.0
"""One speaks of the end of a region that is this many times as long as it is wide on average."""


class Regions(Protocol):
    """What is asked of a map; `RegionMap` answers it."""

    @property
    def regions(self) -> tuple[RegionFeature, ...]:
        """All credible regions."""

    def regions_at(self, x: float, y: float, /) -> tuple[RegionFeature, ...]:
        """Regions around a point, innermost first."""

    def neighbours(self, region: RegionFeature, /) -> tuple[RegionFeature, ...]:
        """Linked regions."""

    def parent(self, region: RegionFeature, /) -> RegionFeature | None:
        """Region that contains another."""

    def children(self, region: RegionFeature, /) -> tuple[RegionFeature, ...]:
        """Regions directly inside another."""

    def ancestors(self, region: RegionFeature, /) -> tuple[RegionFeature, ...]:
        """Regions around another, from its parent outwards."""

    def name(self, region: RegionFeature, /) -> str:
        """Words for a region."""


def describe(regions: Regions, point: Point) -> str:
    """Return one sentence about where a point (x, y), m, lies among mapped regions.

    The region around it, and then what is near: a door or a piece of furniture that it is next to (within 1.5 m) or in
    front of (2 m), the end of a long region, or the middle.
    """
    around = regions.regions_at(*point)
    rooms = [region for region in around if region.type not in PASSAGES and regions.parent(region) is None]
    if around and not rooms and around[0].type in PASSAGES:
        return f"I am in {_door(regions, around[0], None)}."
    if not around:
        return _outside(regions, point)
    room = rooms[0] if rooms else (regions.ancestors(around[0]) or around)[-1]
    if around[0].type in PASSAGES:
        return f"I am in {_door(regions, around[0], None)}."
    if around[0].id != room.id:
        return f"I am in {called(regions, room)}, at {_object(regions, around[0], room)}."
    near = _what_is_near(regions, point, room)
    if near:
        return f"I am in {called(regions, room)}, {near}."
    if _is_long(room) and at_the_end_of(point, room):
        return f"I am at the end of {called(regions, room)}."
    if in_the_middle_of(point, room):
        return f"I am in the middle of {called(regions, room)}."
    return f"I am in {called(regions, room)}."


def called(regions: Regions, region: RegionFeature) -> str:
    """Return a region's name with the article it needs: "the kitchen", "office 3"."""
    name = regions.name(region)
    return f"the {name}" if name == region.type else name


def _outside(regions: Regions, point: Point) -> str:
    near = [(distance_to(region.row, point), region.id, region) for region in regions.regions]
    distance, _, region = min(near, key=lambda entry: entry[:2], default=(float("inf"), 0, None))
    if region is None or distance > NEAR:
        return "I am in a place that I do not know yet."
    name = _door(regions, region, None) if region.type in PASSAGES else called(regions, region)
    return f"I am next to {name}."


def _what_is_near(regions: Regions, point: Point, room: RegionFeature) -> str:
    """Return "next to ..." or "in front of ..." for the nearest door, piece of furniture or linked region, or ""."""
    children = regions.children(room)
    doors = [region for region in regions.regions if region.type in PASSAGES and _belongs(regions, region, room)]
    others = [region for region in regions.neighbours(room) if region.type not in PASSAGES]
    for candidates in ([*doors, *children], others):
        near = sorted((distance_to(region.row, point), region.id, region) for region in candidates)
        for distance, _, region in near:
            if distance > IN_FRONT_OF:
                break
            name = _object(regions, region, room)
            if distance <= NEXT_TO:
                return f"next to {name}"
            if region not in others and in_front_of(point, region, room if region in children else None):
                return f"in front of {name}"
    return ""


def _object(regions: Regions, region: RegionFeature, room: RegionFeature) -> str:
    """Return what to call a door, a piece of furniture or a neighbour, seen from a room."""
    if region.type in PASSAGES:
        return _door(regions, region, room)
    siblings = regions.children(room)
    if region in siblings:
        only = sum(sibling.type == region.type for sibling in siblings) == 1
        return f"the {region.type}" if only else f"{_article(region.type)} {region.type}"
    return called(regions, region)


def _door(regions: Regions, door: RegionFeature, room: RegionFeature | None) -> str:
    """Return "the door leading to the kitchen" from a room, and "the door between ... and ..." from inside the door."""
    sides = [region for region in regions.neighbours(door) if room is None or region.id != room.id]
    sides = [region for region in sides if region.type not in PASSAGES]
    names = [called(regions, region) for region in sides]
    if not names:
        return f"{_article(door.type)} {door.type}"
    if room is None and len(names) > 1:
        return f"the {door.type} between {names[0]} and {names[1]}"
    return f"the {door.type} leading to {names[0]}"


def _belongs(regions: Regions, door: RegionFeature, room: RegionFeature) -> bool:
    """Return whether a door leads out of a room: linked to it or, while one side of it is unknown, touching it."""
    linked = regions.neighbours(door)
    if room in linked:
        return True
    return len(linked) < 2 and distance_to(room.row, door.row.centre) <= TOUCHING


def _is_long(region: RegionFeature) -> bool:
    row = region.row
    longest = max(row.u[-1] - row.u[0], row.t.max() - row.b.min())
    return bool(longest * longest >= LONG * row.area)


def _article(noun: str) -> str:
    return "an" if noun[:1].lower() in "aeiou" else "a"
