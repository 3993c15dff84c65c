"""Maps of ROS (``map.yaml`` and its image) with annotations of ours beside them (``map.rooms.yaml``).

Free pixels become polygons; they are cut at the doors of the annotations, without any at their narrow gaps. A room is
annotated by a point in it or by an outline::

    rooms:
      - {type: kitchen, name: tea kitchen, at: [2.5, 1.0]}
      - {type: office, outline: [[4, 0], [8, 0], [8, 3], [4, 3]]}
    doors:
      - [[4, 1], [4, 1.9]]     # from jamb to jamb, in metres of the map's frame
    gap: 1.25                  # without doors: gaps narrower than this are doors
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor, cleaned, largest, polygons
from regionslam_env.worlds.importers.node import Node
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.rooms import LEAST, cut_at_gaps
from regionslam_env.worlds.importers.source import Source

ANNOTATIONS = ".rooms.yaml"
MOST_PIXELS = 30_000_000
MOST_RUNS = 60_000
JAMB = 0.15
"""How far (m) an annotated door reaches into its jambs, so that it closes the gap."""


def refusal(source: Source) -> str | None:
    """Return why a file is no map, None where it is one."""
    value = source.yaml.value
    if source.path.name.endswith(ANNOTATIONS):
        return f"annotations: import the map itself, {source.path.name.removesuffix(ANNOTATIONS)}.yaml"
    return (
        None if isinstance(value, dict) and "image" in value and "resolution" in value else "no 'image', 'resolution'"
    )


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of a map; it has one level."""
    root = source.yaml
    resolution = options.scale or root["resolution"].number(1e-3, 10)
    free = _free_space(source, root, resolution)
    drawing = Drawing(source.path.stem, scale=resolution)
    beside = source.path.with_name(source.path.stem + ANNOTATIONS)
    notes = Source(beside).yaml if beside.is_file() else None
    if notes is None:
        drawing.notes.append(f"no {beside.name} beside the map: rooms are what lies between gaps, of type other")
    elif not isinstance(notes.value, dict):
        raise notes.error("an object with rooms and doors")
    annotated = list(notes.listed("rooms")) if notes is not None else []
    outlined = [item for item in annotated if item.get("outline") is not None]
    for i, item in enumerate(outlined):
        outline = item["outline"].points(3)
        drawing.add_room(f"outline {i + 1}", item["type"].text(), item.text_of("name") or None, outline)
    given = [_segment(item) for item in notes.listed("doors")] if notes is not None else []
    drawing.doors += [DrawnDoor.between(door[:2], door[2:]) for door in given]
    taken = shapely.union_all([room.polygon for room in drawing.rooms]).buffer(2 * resolution)
    rest = shapely.union_all(free).difference(taken)
    if given:
        lines = shapely.union_all([_closing(door, resolution) for door in given])
        rooms = [cleaned(piece) for piece in polygons(rest.difference(lines)) if piece.area >= LEAST]
    else:
        widest = notes.number_of("gap", 1.25, 0.1, 5) if notes is not None else 1.25
        rooms, gaps = cut_at_gaps(rest, widest)
        for gap in gaps:
            keys = (str(gap.rooms[0]), str(gap.rooms[1]))
            drawing.doors.append(DrawnDoor.between((gap.x0, gap.y0), (gap.x1, gap.y1), keys))
    _add_rooms(drawing, rooms, [item for item in annotated if item not in outlined])
    return drawing


def _add_rooms(drawing: Drawing, rooms: list[shapely.Polygon], annotated: list[Node]) -> None:
    """Add the rooms that were found, each with the annotation whose point lies in it."""
    points = [shapely.Point(item["at"].point()) for item in annotated]
    for item, point in zip(annotated, points, strict=True):
        if not any(room.contains(point) for room in rooms):
            drawing.drop(f"annotation {item['type'].text()}", f"no free space at ({point.x:g}, {point.y:g})")
    for i, room in enumerate(rooms):
        mine = [item for item, point in zip(annotated, points, strict=True) if room.contains(point)]
        if len(mine) > 1:
            drawing.notes.append(
                f"{' and '.join(m['type'].text() for m in mine)} are annotated in one room: a door is missing"
            )
        label = mine[0]["type"].text() if mine else "other"
        drawing.add_room(str(i), label, (mine[0].text_of("name") or None) if mine else None, room)


def _segment(node: Node) -> tuple[float, float, float, float]:
    (x0, y0), (x1, y1) = node.points(2)[:2]
    if math.hypot(x1 - x0, y1 - y0) < 0.05:
        raise node.error("two points at least 0.05 m apart, the ends of a door")
    return x0, y0, x1, y1


def _closing(door: tuple[float, float, float, float], resolution: float) -> shapely.Polygon:
    start, end = np.array(door[:2]), np.array(door[2:])
    more = (end - start) / np.hypot(*(end - start)) * JAMB
    return shapely.LineString([start - more, end + more]).buffer(0.6 * resolution, cap_style="flat")


def _free_space(source: Source, root: Node, resolution: float) -> list[shapely.Polygon]:
    """Return the free pixels as polygons in metres of the map's frame."""
    origin = [item.number(-1e5, 1e5) for item in root["origin"].items()] if root.has("origin") else [0.0, 0.0, 0.0]
    if len(origin) < 2:
        raise root["origin"].error("[x, y, yaw]")
    grey = _pixels(source, root["image"].text())
    occupied = grey / 255 if root.get("negate") is not None and root["negate"].number() else 1 - grey / 255
    free = occupied < root.number_of("free_thresh", 0.196, 0, 1)
    boxes = _runs(free)
    if len(boxes) > MOST_RUNS:
        raise WorldError(
            f"{source.path}: image: {len(boxes)} runs of free pixels, expected at most {MOST_RUNS}: smooth it"
        )
    shape = shapely.union_all(shapely.box(boxes[:, 0], boxes[:, 1], boxes[:, 2], boxes[:, 3]))
    yaw = origin[2] if len(origin) > 2 else 0.0
    c, s = math.cos(yaw), math.sin(yaw)
    height = grey.shape[0]
    shape = shapely.transform(
        shape, lambda p: (p * (1, -1) + (0, height)) * resolution @ np.array([[c, s], [-s, c]]) + origin[:2]
    )
    found = [shapely.simplify(_filled(p), 1.01 * resolution) for p in polygons(shape) if p.area >= LEAST]
    if not found:
        raise WorldError(f"{source.path}: image: no free space of at least {LEAST:g} m²")
    return [largest(shapely.make_valid(p)) for p in found]


def _filled(polygon: shapely.Polygon, least: float = 0.1) -> shapely.Polygon:
    """Return a polygon without its holes below an area (m²): specks."""
    return shapely.Polygon(polygon.exterior, [r for r in polygon.interiors if shapely.Polygon(r).area >= least])


def _runs(free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return boxes (left, top, right, bottom) of free pixels, runs of a row joined with equal ones below."""
    padded = np.pad(free, ((0, 0), (1, 1))).astype(np.int8)
    rows, starts = np.nonzero(np.diff(padded, axis=1) == 1)
    ends = np.nonzero(np.diff(padded, axis=1) == -1)[1]
    boxes: list[tuple[int, int, int, int]] = []
    above: dict[tuple[int, int], int] = {}
    row = -1
    current: dict[tuple[int, int], int] = {}
    for y, x0, x1 in zip(rows.tolist(), starts.tolist(), ends.tolist(), strict=True):
        if y != row:
            above, current, row = (current if y == row + 1 else {}), {}, y
        if (x0, x1) in above:
            k = above[x0, x1]
            boxes[k] = (x0, boxes[k][1], x1, y + 1)
        else:
            k = len(boxes)
            boxes.append((x0, y, x1, y + 1))
        current[x0, x1] = k
    return np.array(boxes, dtype=np.float64).reshape(-1, 4)


def _pixels(source: Source, name: str) -> NDArray[np.float64]:
    """Return an image's grey values, 0 (black) to 255."""
    from PIL import Image  # an image is needed for this format alone

    path = Path(name) if Path(name).is_absolute() else source.path.parent / name
    try:
        with Image.open(path) as image:
            if image.width * image.height > MOST_PIXELS:
                raise WorldError(
                    f"{source.path}: image {name!r}: {image.width} x {image.height}, expected fewer pixels"
                )
            return np.asarray(image.convert("L"), dtype=np.float64)
    except (OSError, ValueError, SyntaxError, EOFError, Image.DecompressionBombError) as error:
        if isinstance(error, WorldError):
            raise
        raise WorldError(f"{source.path}: image {name!r}: cannot be read: {error}") from None
