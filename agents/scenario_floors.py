"""Small floors that are hard on a filter: twins, symmetry, length without landmarks; each with a path through it."""

from __future__ import annotations

import numpy as np

from regionslam_env.worlds.course import course
from regionslam_env.worlds.floorplan import Opening, assemble
from regionslam_env.worlds.world import Region, World
from slam.rows import Floats, Row

DOOR = 0.9
"""Width of doors, m."""


def twin_offices() -> tuple[World, Floats]:
    """Return a hallway with two offices side by side that are alike to the centimetre, visited in turn."""
    rooms = [
        _room("hallway", 0.0, 0.0, 20.0, 2.0),
        _room("office", 6.0, 2.0, 10.0, 6.0, " 1"),
        _room("office", 10.0, 2.0, 14.0, 6.0, " 2"),
        _room("kitchen", 0.0, 2.0, 4.0, 6.0),
    ]
    openings = [
        _opening("door 1", ("hallway", "office 1"), 8.0, 2.0),
        _opening("door 2", ("hallway", "office 2"), 12.0, 2.0),
        _opening("door 3", ("hallway", "kitchen"), 2.0, 2.0),
    ]
    world = assemble("twin offices", rooms, openings)
    visits = ("office 1", "hallway", "office 2", "hallway", "office 1", "hallway", "kitchen", "hallway")
    return world, course(world, ("hallway", *visits, *visits))


def symmetric_floor() -> tuple[World, Floats]:
    """Return four alike wings around a lobby, which look the same from it in four directions; two rounds."""
    rooms, openings = [_room("lobby", -3.0, -3.0, 3.0, 3.0)], []
    for k in range(4):
        c, s = round(np.cos(k * np.pi / 2)), round(np.sin(k * np.pi / 2))
        for kind, start, end, width in (("hallway", 3.0, 11.0, 2.0), ("office", 11.0, 15.0, 5.0)):
            middle, length = (start + end) / 2, end - start
            size = (length, width) if s == 0 else (width, length)
            row = Row.from_parameters(c * middle, s * middle, *size)
            rooms.append(Region(f"{kind} {k + 1}", kind, kind, row))
        inner, outer = (3.0 * c, 3.0 * s), (11.0 * c, 11.0 * s)
        openings.append(_opening(f"inner {k + 1}", ("lobby", f"hallway {k + 1}"), *inner, upright=s == 0))
        openings.append(_opening(f"outer {k + 1}", (f"hallway {k + 1}", f"office {k + 1}"), *outer, upright=s == 0))
    world = assemble("symmetric floor", rooms, openings)
    rounds = [stop for k in (1, 2, 3, 4) for stop in (f"office {k}", "lobby")]
    return world, course(world, ("lobby", *rounds, *rounds))


def long_hallway() -> tuple[World, Floats]:
    """Return a bare hallway of 60 m with an office at either end; there and back."""
    rooms = [
        _room("hallway", 0.0, 0.0, 60.0, 2.4),
        _room("office", -4.0, 0.0, 0.0, 4.0, " 1"),
        _room("office", 60.0, 0.0, 64.0, 4.0, " 2"),
    ]
    openings = [
        _opening("door 1", ("hallway", "office 1"), 0.0, 1.2, upright=True),
        _opening("door 2", ("hallway", "office 2"), 60.0, 1.2, upright=True),
    ]
    world = assemble("long hallway", rooms, openings)
    return world, course(world, ("office 1", "office 2", "office 1"))


def _room(kind: str, x0: float, y0: float, x1: float, y1: float, number: str = "") -> Region:
    row = Row.from_parameters((x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0)
    return Region(kind + number, kind, kind + number, row)


def _opening(name: str, rooms: tuple[str, str], x: float, y: float, upright: bool = False) -> Opening:
    dx, dy = (0.0, DOOR / 2) if upright else (DOOR / 2, 0.0)
    return Opening(name, rooms, x - dx, y - dy, x + dx, y + dy)
