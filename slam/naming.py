"""What to call regions: by name or type, doors by where they lead, places by their storey and building."""

from __future__ import annotations

from typing import Protocol

from slam.edges import Point, distance_to
from slam.region import RegionFeature
from slam.storeys import BUILDINGS, CONTAINERS, STAIRS, STOREYS, ordinal

PASSAGES = frozenset({"door", "doorway", "doors", "gate", "opening", "passage"})
"""Types of regions that one passes to get from one region to another."""

TOUCHING = 0.5
"""A door this near to a region belongs to it even before the link is believed, m."""


class Regions(Protocol):
    """What is asked of a map; `RegionMap` answers it."""

    @property
    def regions(self) -> tuple[RegionFeature, ...]:
        """All credible regions."""

    @property
    def levels(self) -> tuple[int, ...]:
        """Levels of the map."""

    def regions_at(self, x: float, y: float, level: int | None = None, /) -> tuple[RegionFeature, ...]:
        """Regions of a level around a point, innermost first."""

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


def called(regions: Regions, region: RegionFeature) -> str:
    """Return a region's name with the article it needs: "the kitchen", "the second floor", "office 3", "B 4.12"."""
    name = regions.name(region)
    is_noun = name == region.type or (name.islower() and not any(map(str.isdigit, name)))
    return f"the {name}" if is_noun or (region.type in STOREYS and not region.name) else name


def storey_of(regions: Regions, point: Point, level: int) -> str:
    """Return " on the second floor of building 2" for a point (m) of a level, as far as it is known, or ""."""
    inside = regions.regions_at(*point, level)
    around = [*inside, *(above for region in inside for above in regions.ancestors(region))]
    storey = next((region for region in around if region.type in STOREYS), None)
    words = ""
    if storey is not None:
        words = f" on {called(regions, storey)}"
    elif level != 0 or len(regions.levels) > 1:
        words = f" on the {ordinal(level)}"
    buildings = {region.id: region for region in around if region.type in BUILDINGS}
    for building in sorted(buildings.values(), key=lambda region: (region.row.area, region.id)):
        words += f" of {called(regions, building)}"
    return words


def object_in(regions: Regions, region: RegionFeature, room: RegionFeature) -> str:
    """Return what to call a door, a piece of furniture or a neighbour, seen from a room."""
    if region.type in PASSAGES:
        return door(regions, region, room)
    siblings = regions.children(room)
    if region in siblings and not region.name:
        only = sum(sibling.type == region.type for sibling in siblings) == 1
        return f"the {region.type}" if only else f"{article(region.type)} {region.type}"
    if region.level != room.level:
        return f"{called(regions, region)} on the {ordinal(region.level)}"
    beyond = [neighbour.level for neighbour in regions.neighbours(region) if neighbour.level != room.level]
    if region.type in STAIRS and beyond:
        return f"{called(regions, region)} leading to the {ordinal(beyond[0])}"
    return called(regions, region)


def door(regions: Regions, door: RegionFeature, room: RegionFeature | None) -> str:
    """Return "the door leading to the kitchen" from a room, and "the door between ... and ..." from inside the door."""
    sides = [region for region in regions.neighbours(door) if room is None or region.id != room.id]
    names = [called(regions, region) for region in sides if region.type not in PASSAGES | CONTAINERS]
    if not names:
        return f"{article(door.type)} {door.type}"
    if room is None and len(names) > 1:
        return f"the {door.type} between {names[0]} and {names[1]}"
    return f"the {door.type} leading to {names[0]}"


def belongs(regions: Regions, door: RegionFeature, room: RegionFeature) -> bool:
    """Return whether a door leads out of a room: linked to it or, while one side of it is unknown, touching it."""
    linked = regions.neighbours(door)
    if room in linked:
        return True
    touches = door.level == room.level and distance_to(room.row, door.row.centre) <= TOUCHING
    return len(linked) < 2 and touches


def article(noun: str) -> str:
    """Return "a" or "an"."""
    return "an" if noun[:1].lower() in "aeiou" else "a"
