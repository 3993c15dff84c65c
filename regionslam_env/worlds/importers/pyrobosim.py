"""Worlds of PyRoboSim as YAML: rooms and furniture as boxes or polygons in metres, hallways of some width between.

A hallway becomes a region of its own with an opening of its width at either end. Its way is that of PyRoboSim: straight
from middle to middle (``auto``), at an angle from the first middle (``angle``), or along points (``points``).
"""

from __future__ import annotations

import math

import numpy as np
import shapely
import shapely.ops
from numpy.typing import ArrayLike

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor, cleaned, largest
from regionslam_env.worlds.importers.node import Node
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.source import Source
from slam.rows import Floats

LARGEST = 1e4
NARROWEST = 0.8
"""Least width (m) of a hallway and of the openings at its ends: a robot must fit through."""


def refusal(source: Source) -> str | None:
    """Return why a file is no world, None where it is one."""
    value = source.yaml.value
    if not isinstance(value, dict):
        return "no object"
    rooms = value.get("rooms")
    if isinstance(rooms, list) and any(isinstance(room, dict) and "footprint" in room for room in rooms):
        return None
    if value and all(isinstance(v, dict) and "footprint" in v for v in value.values()):
        raise WorldError(
            f"{source.path}: footprints of furniture, which a PyRoboSim world names under metadata.locations: import "
            "the world's own file, with this one beside it"
        )
    return "no 'rooms' with a 'footprint'"


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of a world; it has one level."""
    root = source.yaml
    parameters = root.get("params")
    name = parameters.text_of("name") if parameters is not None else ""
    drawing = Drawing(name or source.path.stem)
    shapes: dict[str, shapely.Polygon] = {}
    for i, room in enumerate(root["rooms"].items()):
        key = room.text_of("name") or f"room {i + 1}"
        shapes[key] = _footprint(room["footprint"], room.get("pose"))
        drawing.add_room(key, key, key, shapes[key])
    for i, hallway in enumerate(root.listed("hallways")):
        _add_hallway(drawing, hallway, f"hallway {i + 1}", shapes)
    footprints = _footprints(source, root, drawing)
    for i, item in enumerate(root.listed("locations")):
        category = item.text_of("category")
        if category not in footprints:
            drawing.drop(
                f"{category} {item.text_of('name')}".strip() or f"location {i + 1}",
                "no footprint of its category in metadata.locations",
            )
            continue
        corners = shapely.get_coordinates(footprints[category].exterior)
        parent = shapes.get(item.text_of("parent"))
        place = item.get("pose")
        moved = (
            _moved(corners, place)
            if place is not None
            else corners + (0 if parent is None else parent.centroid.coords[0])
        )
        drawing.add_item(category, item.text_of("name") or None, moved)
    return drawing


def _footprint(node: Node, pose: Node | None = None) -> shapely.Polygon:
    """Return a footprint of type box, circle or polygon at a pose, m; empty for a mesh."""
    form = node.text_of("type")
    if form == "box":
        sides = list(node["dims"].items())
        if len(sides) != 2:
            raise node["dims"].error("[width, height] in metres")
        w, h = (side.number(0.01, LARGEST) for side in sides)
        corners = np.array([[-w, -h], [w, -h], [w, h], [-w, h]]) / 2
    elif form == "circle":
        r = node["radius"].number(0.01, LARGEST)
        angles = 2 * np.pi * (np.arange(12) + 0.5) / 12
        corners = r * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    elif form == "polygon":
        corners = np.array(node["coords"].points(3))
    elif form in ("mesh", "parent"):
        return shapely.Polygon()
    else:
        raise node.error(f"a footprint ({unknown('type', form, ('box', 'circle', 'polygon', 'mesh'))})")
    offset = node.get("offset")
    if offset is not None:
        corners = corners + offset.point()
    return cleaned(_moved(corners, pose) if pose is not None else corners)


def _moved(corners: Floats, pose: Node) -> Floats:
    """Return corners (k, 2) at a pose: [x, y, yaw], [x, y, z, yaw], or position with rotation_eul or rotation_quat."""
    yaw = 0.0
    if isinstance(pose.value, list):
        numbers = [item.number(-LARGEST, LARGEST) for item in pose.items()]
        if len(numbers) < 2:
            raise pose.error("a pose [x, y, yaw]")
        (x, y), yaw = numbers[:2], numbers[-1] if len(numbers) > 2 else 0.0
    else:
        position = pose.get("position")
        x, y = (0.0, 0.0) if position is None else (position.number_of(k, 0.0, -LARGEST, LARGEST) for k in "xy")
        euler, quaternion = pose.get("rotation_eul"), pose.get("rotation_quat")
        if euler is not None:
            degrees = euler.text_of("angle_units", "radians").startswith("deg")
            yaw = euler.number_of("yaw", 0.0) * (math.pi / 180 if degrees else 1.0)
        elif quaternion is not None:
            qx, qy, qz, qw = (quaternion.number_of(k, float(k == "w")) for k in "xyzw")
            yaw = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
    c, s = math.cos(yaw), math.sin(yaw)
    return corners @ np.array([[c, s], [-s, c]]) + (x, y)


def _add_hallway(drawing: Drawing, node: Node, key: str, shapes: dict[str, shapely.Polygon]) -> None:
    ends = []
    for field in ("room_start", "room_end"):
        room = node[field].text()
        if room not in shapes:
            raise WorldError(f"{node.file}: {node.place}.{field}: {unknown('room', room, shapes)}")
        ends.append(room)
    width = max(node["width"].number(0.01, LARGEST), NARROWEST)
    way = shapely.LineString(_way(node, shapes[ends[0]], shapes[ends[1]]))
    if way.length < 1e-3:
        drawing.drop(key, "its rooms are in one place")
        return
    own = way.buffer(width / 2, cap_style="flat", join_style="mitre")
    between = largest(own.difference(shapely.union_all(list(shapes.values()))))
    if between.area < 0.3 * width * width:  # the rooms touch: no more than a door
        contact = shapes[ends[0]].boundary.intersection(own)
        if contact.is_empty:
            drawing.drop(key, "its rooms lie inside one another")
            return
        x, y = contact.centroid.coords[0]
        drawing.doors.append(DrawnDoor(x, y, x, y, (ends[0], ends[1]), width))
        return
    drawing.add_room(key, "hallway", None, between)
    for room in ends:
        drawing.doors.append(_end(way, shapes[room], between, (room, key), width))


def _end(
    way: shapely.LineString, room: shapely.Polygon, hallway: shapely.Polygon, rooms: tuple[str, str], width: float
) -> DrawnDoor:
    """Return the door at one end of a hallway: across its way, where that leaves the room."""
    along = way.intersection(hallway)
    at = way.project(shapely.ops.nearest_points(along, room)[0])
    middle = np.array(way.interpolate(at).coords[0])
    before, after = (way.interpolate(min(max(at + d, 0.0), way.length)).coords[0] for d in (-0.05, 0.05))
    step = np.subtract(after, before)
    across = np.array([-step[1], step[0]]) / max(float(np.hypot(*step)), 1e-9) * width / 2
    return DrawnDoor.between(middle - across, middle + across, rooms)


def _way(node: Node, first: shapely.Polygon, second: shapely.Polygon) -> ArrayLike:
    """Return the points of a hallway's middle line, m."""
    method = node.text_of("conn_method", "auto")
    if method == "points":
        return node["conn_points"].points(2)
    if method not in ("auto", "angle"):
        raise node.error(
            f"conn_method auto, angle or points ({unknown('conn_method', method, ('auto', 'angle', 'points'))})"
        )
    start, end = (np.array(shape.centroid.coords[0]) for shape in (first, second))
    theta, length = math.atan2(end[1] - start[1], end[0] - start[0]), float(np.hypot(*(end - start)))
    if method == "angle":
        angle = node["conn_angle"].number(-10, 10)
        theta, length = angle, length * math.cos(theta - angle)
    along = np.array([math.cos(theta), math.sin(theta)])
    start = start + node.number_of("offset", 0.0, -LARGEST, LARGEST) * np.array([-along[1], along[0]])
    return [start, start + length * along]


def _footprints(source: Source, root: Node, drawing: Drawing) -> dict[str, shapely.Polygon]:
    """Return the footprint of every category of furniture in the files that a world names, where they lie beside it."""
    metadata = root.get("metadata")
    listed = metadata.get("locations") if metadata is not None else None
    found: dict[str, shapely.Polygon] = {}
    if listed is None:
        return found
    for entry in [listed] if isinstance(listed.value, str) else listed.items():
        file = source.path.parent / entry.text().replace("\\", "/").rsplit("/", 1)[-1]
        if not file.is_file():
            drawing.notes.append(f"{file.name} is not beside the world: its furniture is left out")
            continue
        for category, node in Source(file).yaml.fields():
            shape = _footprint(node["footprint"])
            if shape.is_empty:
                drawing.notes.append(f"{category}: a mesh has no footprint here")
            else:
                found[category] = shape
    return found
