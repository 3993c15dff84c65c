"""Houses of HouseExpo (Li et al. 2020) as JSON: the outline of all free space, and boxes that say what lies where.

``verts`` is the outline in metres; rooms are what remains when it is cut at its narrow gaps, the doors. Each takes the
category of ``room_category`` whose box covers most of it.
"""

from __future__ import annotations

import shapely

from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor, cleaned
from regionslam_env.worlds.importers.node import Node
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.rooms import cut_at_gaps
from regionslam_env.worlds.importers.source import Source

Box = tuple[str, shapely.Polygon]


def refusal(source: Source) -> str | None:
    """Return why a file is no house, None where it is one."""
    value = source.json.value
    return None if isinstance(value, dict) and "verts" in value else "no 'verts'"


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of a house; it has one level."""
    root = source.json
    scale = options.scale or 1.0
    free = cleaned(root["verts"].points(3))
    free = shapely.transform(free, lambda p: p * scale)
    drawing = Drawing(root.text_of("id") or source.path.stem, scale=options.scale)
    rooms, gaps = cut_at_gaps(free)
    boxes = [
        (kind, shapely.transform(box, lambda p: p * scale))
        for kind, listed in (root["room_category"].fields() if root.has("room_category") else ())
        for box in _boxes(listed)
    ]
    for i, room in enumerate(rooms):
        drawing.add_room(str(i), _category(room, boxes), None, room)
    for gap in gaps:
        keys = (str(gap.rooms[0]), str(gap.rooms[1]))
        drawing.doors.append(DrawnDoor.between((gap.x0, gap.y0), (gap.x1, gap.y1), keys))
    return drawing


def _boxes(listed: Node) -> list[shapely.Polygon]:
    """Return the boxes of a category, each [x, y, x, y]."""
    boxes = []
    for item in listed.items():
        values = [value.number() for value in item.items()]
        if len(values) != 4:
            raise item.error("a box [x, y, x, y]")
        boxes.append(shapely.box(*values))
    return boxes


def _category(room: shapely.Polygon, boxes: list[Box]) -> str:
    """Return the category of the box with the largest IoU, "room" where none covers a third of the room."""

    def overlap(box: Box) -> float:
        return float(room.intersection(box[1]).area / room.union(box[1]).area)

    covering = [box for box in boxes if room.intersection(box[1]).area > room.area / 3]
    return max(covering, key=overlap)[0].replace("_", " ") if covering else "room"
