"""Storeys and buildings: regions that others lie in, and what to call them.

A region has a `level`, 0 for the ground floor; regions of different levels share (x, y). A storey or a building may be
a region of its own that contains others through `children`, with or without a name of its own.
"""

from __future__ import annotations

from slam.region import RegionFeature

STOREYS = frozenset({"floor", "level", "storey", "story"})
"""Types of regions that are a whole level."""

BUILDINGS = frozenset({"building", "house", "tower", "wing"})
"""Types of regions that are on every level."""

CONTAINERS = STOREYS | BUILDINGS
"""Types of regions that one is in beside being in a room."""

STAIRS = frozenset({"elevator", "escalator", "lift", "ramp", "staircase", "stairs", "stairwell"})
"""Types of regions that lead to another level."""

_ORDINALS = (
    "ground", "first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth",
)  # fmt: skip


def is_on(region: RegionFeature, level: int | None) -> bool:
    """Return whether a region is on a level; None stands for any."""
    return level is None or region.level == level or region.type in BUILDINGS


def ordinal(level: int) -> str:
    """Return what to call a level: "ground floor", "second floor", "21st floor", "basement", "second basement"."""
    if level < 0:
        return "basement" if level == -1 else f"{_ordinal(-level)} basement"
    return f"{_ordinal(level)} floor"


def _ordinal(number: int) -> str:
    if number < len(_ORDINALS):
        return _ORDINALS[number]
    ending = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"
