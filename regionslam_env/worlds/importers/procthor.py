"""Houses of ProcTHOR (Deitke et al. 2022) as JSON: floor polygons in x and z, doors with the ids of their two rooms.

Unity's frame is left-handed with y up; x stays x and z becomes y, which keeps the plan as seen from above. A door's
hole is measured along its wall; walls stand in the file once from each side and have no thickness. A door that names
one room twice leads outside. Objects have no sizes and are left out.
"""

from __future__ import annotations

import re

import numpy as np

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor
from regionslam_env.worlds.importers.node import Node
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.source import Source
from slam.rows import Floats


def refusal(source: Source) -> str | None:
    """Return why a file is no house, None where it is one."""
    value = source.json.value
    if not isinstance(value, dict):
        return "no object"
    rooms = value.get("rooms")
    if not (isinstance(rooms, list) and any(isinstance(room, dict) and "floorPolygon" in room for room in rooms)):
        return "no 'rooms' with a 'floorPolygon'"
    return None


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of a house; it has one level."""
    root = source.json
    drawing = Drawing(source.path.stem)
    for room in root["rooms"].items():
        kind = room.text_of("roomType", "room")
        drawing.add_room(room["id"].text(), kind, None, room["floorPolygon"].points(3, "x", "z"))
    keys = {room.key for room in drawing.rooms}
    walls = {wall["id"].text(): wall for wall in root.listed("walls")}
    for door in root.listed("doors"):
        _add_door(drawing, door, walls, keys)
    drawing.passages = _open_plan(walls)
    count = sum(1 for _ in root.listed("objects"))
    if count:
        drawing.notes.append(f"{count} objects left out: the format gives them no size")
    return drawing


def _add_door(drawing: Drawing, door: Node, walls: dict[str, Node], keys: set[str]) -> None:
    rooms = tuple(dict.fromkeys(door.text_of(key) for key in ("room0", "room1")))
    what = f"door {door.text_of('id')!r}"
    if len(rooms) < 2:
        drawing.drop(what, "leads outside")
        return
    if not keys.issuperset(rooms):
        drawing.drop(what, "names a room that is not there")
        return
    hole = door["holePolygon"].points(2, "x", "y")
    along = sorted(x for x, _ in hole[:2])
    name = door["wall0"].text()
    if name not in walls:
        raise WorldError(f"{door.file}: {door.place}.wall0: no wall {name!r}")
    start, end = _ends(walls[name])
    length = float(np.hypot(*(end - start)))
    if length < 1e-6:
        drawing.drop(what, "its wall has no length")
        return
    first, second = (start + (end - start) * np.clip(a / length, 0, 1) for a in along)
    drawing.doors.append(DrawnDoor.between(first, second, rooms))


def _ends(wall: Node) -> tuple[Floats, Floats]:
    """Return the ends of a wall, the way holes are measured: the id names them in that order, or else the polygon."""
    numbers = re.findall(r"\|(-?\d+\.\d+)" * 4 + "$", wall["id"].text())
    points = wall["polygon"].points(2, "x", "z")
    first = points[0]
    second = max(points, key=lambda p: np.hypot(p[0] - first[0], p[1] - first[1]))
    if numbers:
        named = np.array(numbers[0], dtype=np.float64).reshape(2, 2)
        if np.hypot(*(named[0] - first)) > np.hypot(*(named[0] - second)):
            first, second = second, first
    return np.array(first), np.array(second)


def _open_plan(walls: dict[str, Node]) -> list[tuple[str, str]]:
    """Return the pairs of rooms with an empty wall in the same place."""
    sides: dict[tuple[tuple[float, float], ...], list[str]] = {}
    for wall in walls.values():
        if wall.value.get("empty") is True:
            place = tuple(sorted((round(float(x), 2), round(float(y), 2)) for x, y in map(tuple, _ends(wall))))
            sides.setdefault(place, []).append(wall.text_of("roomId"))
    return [(rooms[0], rooms[1]) for rooms in sides.values() if len(set(rooms)) == 2]
