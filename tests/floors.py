"""Hand-drawn worlds for exact assertions."""

from __future__ import annotations

import numpy as np

from regionslam_env.worlds.world import Door, Link, Region, World
from slam.rows import Row

Segment = tuple[float, float, float, float]


def box(x0: float, y0: float, x1: float, y1: float) -> list[Segment]:
    """Return the four sides of a box."""
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]


def single_room(width: float = 6.0, height: float = 4.0) -> World:
    """Return one office about the origin."""
    row = Row.from_parameters(0, 0, width, height)
    walls = box(-width / 2, -height / 2, width / 2, height / 2)
    return World("room", (Region("office", "office", "office", row),), np.array(walls))


def long_hallway() -> World:
    """Return a hallway 30 m long and 2 m wide, about the origin."""
    row = Row.from_parameters(0, 0, 30, 2)
    return World("hallway", (Region("hallway", "hallway", "hallway", row),), np.array(box(-15, -1, 15, 1)))


def two_rooms() -> World:
    """Return an office (0..6 x 0..4 m), a kitchen (6..12 x 0..4) and a door of 1 m between them, at (6, 2)."""
    regions = (
        Region("office", "office", "office", Row.from_parameters(3, 2, 6, 4)),
        Region("kitchen", "kitchen", "kitchen", Row.from_parameters(9, 2, 6, 4)),
        Region("door", "door", "door", Row.from_parameters(6, 2, 1, 0.2, np.pi / 2)),
    )
    walls = [*box(0, 0, 12, 4), (6, 0, 6, 1.5), (6, 2.5, 6, 4)]
    links = (Link("office", "door", "r", "t"), Link("door", "kitchen", "b", "l"))
    doors = (Door("door", 6, 1.5, 6, 2.5, ("office", "kitchen")),)
    return World("two rooms", regions, np.array(walls), doors, links=links)


def bent_hallway(main: int = 0) -> World:
    """Return an L: 6 m along x (y from -1 to 1), then 2 m further, there up to y = 5; one row of two rectangles."""
    row = Row(0, 0, 0, np.array([0, 6, 8]), np.array([-1, -1]), np.array([1, 5]), main)
    corners = [(0, -1), (8, -1), (8, 5), (6, 5), (6, 1), (0, 1)]
    walls = [(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    return World("bent hallway", (Region("hallway", "hallway", "hallway", row),), np.array(walls))


def furnished_room() -> World:
    """Return an office of 6 x 4 m about the origin with a desk of 1 x 1 m whose centre is (1, 0)."""
    desk = np.array([(0.5, -0.5), (1.5, -0.5), (1.5, 0.5), (0.5, 0.5)])
    regions = (
        Region("office", "office", "office", Row.from_parameters(0, 0, 6, 4)),
        Region("desk", "desk", "desk", Row.from_parameters(1, 0, 1, 1), parent="office"),
    )
    return World("furnished room", regions, np.array(box(-3, -2, 3, 2)), obstacles=(desk,))


def crowded_room() -> World:
    """Return the two rooms with a bed of 2 x 2.2 m in the middle of the office, about (3, 2)."""
    world = two_rooms()
    bed = np.array([(2, 0.9), (4, 0.9), (4, 3.1), (2, 3.1)])
    region = Region("bed", "bed", "bed", Row.from_parameters(3, 2, 2, 2.2), parent="office")
    return World("crowded room", (*world.regions, region), world.walls, world.doors, (bed,), links=world.links)
