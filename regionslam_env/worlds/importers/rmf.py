"""Buildings of Open-RMF's traffic editor (``building.yaml``): walls and doors as edges of vertices, no rooms.

Coordinates are pixels with y down (``coordinate_system: reference_image``) or metres with y up (``cartesian_meters``).
The scale is the median of a level's measurements. Rooms are what walls, doors and floors enclose; a room is named after
a waypoint in it; lifts are rooms of their own.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import shapely

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor, cleaned
from regionslam_env.worlds.importers.levels import choose
from regionslam_env.worlds.importers.node import Node
from regionslam_env.worlds.importers.realise import CIRCULATION, ImportOptions
from regionslam_env.worlds.importers.rooms import closings, enclosed
from regionslam_env.worlds.importers.source import Source
from regionslam_env.worlds.importers.vocabulary import OTHER, vocabulary
from slam.rows import Floats

SHAFT = 3.5
"""A space around a lift's cabin of at most so many times its area is the lift."""

HALL = 5
"""Doors from which on a room is a hallway, whatever the waypoints in it are called."""

MOST_EDGES = 5000


@dataclass(frozen=True)
class _Level:
    """A level's vertices (k, 2) in metres, y up, and their names."""

    node: Node
    points: Floats
    names: list[str]

    def edge(self, node: Node) -> tuple[Floats, Floats]:
        items = list(node.items())
        if len(items) < 2:
            raise node.error("an edge [vertex, vertex, parameters]")
        first, second = (self.points[item.index(len(self.points))] for item in items[:2])
        return first, second


def refusal(source: Source) -> str | None:
    """Return why a file is no building, None where it is one."""
    value = source.yaml.value
    levels = value.get("levels") if isinstance(value, dict) else None
    if not (isinstance(levels, dict) and any(isinstance(v, dict) and "vertices" in v for v in levels.values())):
        return "no 'levels' with 'vertices'"
    return None


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of one level."""
    root = source.yaml
    levels = {name: node for name, node in root["levels"].fields() if node.get("vertices") is not None}
    by_height = sorted(levels, key=lambda name: (levels[name].number_of("elevation", 0.0), list(levels).index(name)))
    wanted = options.level
    name = choose(by_height, [k for k in by_height for _ in levels[k].listed("walls")], wanted, source.path)
    metric = root.text_of("coordinate_system", "reference_image") == "cartesian_meters"
    scale = options.scale or (1.0 if metric else _scale(source, levels, name))
    if not (math.isfinite(scale) and scale > 0):
        raise WorldError(f"{source.path}: scale: expected metres per pixel above 0, got {scale!r}")
    factor = np.array([scale, scale if metric else -scale])
    level = _level(levels[name], factor)
    title = root.text_of("name") or source.path.name.split(".")[0]
    drawing = Drawing(title, name, by_height, None if metric else scale)
    _add_doors(drawing, level)
    walls = [shapely.LineString(level.edge(wall)) for wall in level.node.listed("walls")]
    if len(walls) > MOST_EDGES:
        raise WorldError(f"{source.path}: levels.{name}: {len(walls)} walls, expected at most {MOST_EDGES}")
    doors = [shapely.LineString([(d.x0, d.y0), (d.x1, d.y1)]) for d in drawing.doors]
    gaps = closings(walls, doors)
    for gap in gaps:
        drawing.doors.append(DrawnDoor.between(gap.coords[0], gap.coords[-1], width=gap.length - 0.1, what="gap"))
    spaces = enclosed([*walls, *doors, *gaps], [floor for floor in _floors(level) if not floor.is_empty])
    cabins = _cabins(root, level, factor, name, drawing)
    _add_rooms(drawing, level, spaces, cabins)
    count = sum(1 for _ in level.node.listed("models"))
    if count:
        drawing.notes.append(f"{count} models left out: the format gives them no size")
    return drawing


def _level(node: Node, factor: Floats) -> _Level:
    points, names = [], []
    for vertex in node["vertices"].items():
        points.append(vertex.point())
        items = list(vertex.items())
        names.append(items[3].text() if len(items) > 3 and items[3].value is not None else "")
    return _Level(node, np.array(points, dtype=np.float64).reshape(-1, 2) * factor, names)


def _scale(source: Source, levels: dict[str, Node], name: str) -> float:
    """Return metres per pixel: the median of a level's measurements, or those of the other levels where it has none."""
    for group in ([name], [k for k in levels if k != name]):
        found = []
        for key in group:
            level = _level(levels[key], np.ones(2))
            for node in levels[key].listed("measurements"):
                first, second = level.edge(node)
                parameters = list(node.items())[2:]
                distance = list(parameters[0]["distance"].items()) if parameters else []
                pixels = float(np.hypot(*(second - first)))
                if distance and pixels > 0:
                    found.append(distance[-1].number(1e-3, 1e5) / pixels)
        if found:
            return float(np.median(found))
    raise WorldError(
        f"{source.path}: levels.{name}.measurements: none that gives a scale: give metres per pixel (--scale)"
    )


def _add_doors(drawing: Drawing, level: _Level) -> None:
    for door in level.node.listed("doors"):
        drawing.doors.append(DrawnDoor.between(*level.edge(door)))


def _floors(level: _Level) -> list[shapely.Polygon]:
    """Return the floors, m."""
    count = len(level.points)
    return [
        cleaned(level.points[[v.index(count) for v in floor["vertices"].items()]])
        for floor in level.node.listed("floors")
    ]


def _cabins(
    root: Node, level: _Level, factor: Floats, name: str, drawing: Drawing
) -> list[tuple[str, shapely.Polygon]]:
    """Return name and outline of every lift that stops at a level; their doors are added to the drawing."""
    lifts = root.get("lifts")
    found = []
    for key, lift in lifts.fields() if lifts is not None else ():
        stops = lift.get("level_doors")
        if stops is not None and not stops.has(name):
            continue
        centre = _cabin_centre(level, key)
        if centre is None:
            if lift.text_of("reference_floor_name") != name:
                continue
            centre = np.array(lift.point()) * factor
        yaw = lift.number_of("yaw", 0.0, -10, 10)
        c, s = math.cos(yaw), math.sin(yaw)
        turn = np.array([[c, s], [-s, c]])
        half = np.array([lift.number_of("width", 2.0, 0.3, 20), lift.number_of("depth", 2.0, 0.3, 20)]) / 2
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        found.append((key, cleaned(corners @ turn + centre)))
        doors = lift.get("doors")
        names = {item.text() for item in stops[name].items()} if stops is not None else None
        for door_name, door in doors.fields() if doors is not None else ():
            if names is None or door_name in names:
                drawing.doors.append(_lift_door(door, turn, centre, yaw))
    return found


def _lift_door(door: Node, turn: Floats, centre: Floats, yaw: float) -> DrawnDoor:
    """Return the door of a lift: its place and direction are those of the cabin's frame."""
    middle = np.array(door.point()) @ turn + centre
    angle = yaw + door.number_of("motion_axis_orientation", 0.0, -10, 10)
    width = door.number_of("width", 1.0, 0.3, 10)
    half = np.array([math.cos(angle), math.sin(angle)]) * width / 2
    return DrawnDoor.between(middle - half, middle + half, what="lift door")


def _cabin_centre(level: _Level, lift: str) -> Floats | None:
    """Return where a level has a waypoint inside a lift, m."""
    for i, vertex in enumerate(level.node["vertices"].items()):
        parameters = list(vertex.items())[4:]
        if parameters and parameters[0].has("lift_cabin") and lift in map(str, parameters[0].value["lift_cabin"] or ()):
            return np.asarray(level.points[i])
    return None


def _add_rooms(
    drawing: Drawing, level: _Level, spaces: list[shapely.Polygon], cabins: list[tuple[str, shapely.Polygon]]
) -> None:
    shafts = {}
    for key, cabin in cabins:
        around = [i for i, s in enumerate(spaces) if s.intersection(cabin).area > 0.7 * cabin.area]
        if around and spaces[around[0]].area < SHAFT * cabin.area:
            shafts[around[0]] = key
        else:
            drawing.add_room(key, "lift", key, cabin)
    free = shapely.union_all([cabin for key, cabin in cabins if key not in shafts.values()])
    for i, space in enumerate(spaces):
        if i in shafts:
            drawing.add_room(shafts[i], "lift", shafts[i], space)
            continue
        outside = cleaned(space.difference(free)) if space.intersects(free) else space
        label, name = _label(level, outside)
        doors = sum(outside.distance(shapely.Point(door.middle)) < 0.3 for door in drawing.doors)
        if doors >= HALL and vocabulary("rmf").type_of(label) not in CIRCULATION:
            label, name = "hallway", None
        drawing.add_room(f"space {i + 1}", label, name, outside)


def _label(level: _Level, space: shapely.Polygon) -> tuple[str, str | None]:
    """Return what the waypoints in a room say it is for, and its name."""
    words = vocabulary("rmf")
    named = [
        re.sub(r"[_\s]+", " ", name).strip()
        for name, point in zip(level.names, level.points, strict=True)
        if name and space.contains(shapely.Point(point))
    ]
    known = [name for name in named if words.type_of(name) != OTHER]
    plain = [name for name in known or named if not re.search("charger|patrol|clean|park", name)]
    best = min(plain, key=len, default=None)
    return (best, best) if best else ("", None)
