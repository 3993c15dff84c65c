"""OpenStreetMap with Simple Indoor Tagging, as GeoJSON (overpass turbo, osmtogeojson) or as OSM XML (JOSM).

``indoor=room`` has walls, between ``indoor=corridor`` and ``indoor=area`` there are none. Doors are nodes with ``door``
or ``entrance`` on an outline, and rare: most rooms get an assumed one.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import shapely

from regionslam_env.errors import WorldError, short
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor
from regionslam_env.worlds.importers.geodetic import check_degrees, origin_of, polygons_of, projected
from regionslam_env.worlds.importers.levels import choose
from regionslam_env.worlds.importers.node import Node
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.source import Source

ROOMS = ("room", "corridor", "area", "yes")
UNWALLED = ("corridor", "area")
MOST_LEVELS = 60
Ring = list[tuple[float, float]]


@dataclass(frozen=True)
class _Element:
    """Tags and shape of a node (one point), an open way (`polygons` empty) or an area (its rings), in degrees."""

    id: str
    tags: dict[str, str]
    point: tuple[float, float] | None = None
    polygons: tuple[list[Ring], ...] = ()

    @property
    def levels(self) -> list[str]:
        return levels_of(self.tags.get("level", "0"))

    @property
    def door(self) -> bool:
        return self.point is not None and (self.tags.get("door", "no") != "no" or "entrance" in self.tags)


def refusal(source: Source) -> str | None:
    """Return why a file is none of these, None where it is one."""
    if source.ending in (".xml", ".osm"):
        return None if source.xml.tag == "osm" else f"root element is <{source.xml.tag[:80]}>, expected <osm>"
    value = source.json.value
    features = value.get("features") if isinstance(value, dict) else None
    for feature in features if isinstance(features, list) else ():
        properties = feature.get("properties") if isinstance(feature, dict) else None
        if isinstance(properties, dict) and ("indoor" in properties or "indoor" in (properties.get("tags") or ())):
            return None
    return "no feature with the tag 'indoor'"


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of one level."""
    in_xml = source.ending in (".xml", ".osm")
    elements = list(_from_xml(source.path, source.xml) if in_xml else _from_geojson(source.json))
    rooms = [e for e in elements if e.tags.get("indoor") in ROOMS and e.polygons]
    if not rooms:
        raise WorldError(f"{source.path}: no area tagged indoor=room, corridor or area, expected at least one")
    levels = sorted({level for room in rooms for level in room.levels}, key=float)
    level = choose(levels, [level for room in rooms for level in room.levels], options.level, source.path)
    plane = origin_of([p for room in rooms for rings in room.polygons for ring in rings for p in ring], source.path)
    drawing = Drawing(source.path.name.split(".")[0], level, levels)
    here = [e for e in elements if level in e.levels]
    lifts = [shapely.Point(plane.metres(e.point)[0]) for e in here if e.point and e.tags.get("highway") == "elevator"]
    for element in here:
        tags, name = element.tags, element.tags.get("name")
        if element.polygons and tags.get("indoor") in ROOMS:
            shape = shapely.union_all([projected(plane, rings) for rings in element.polygons])
            label = _label(tags)
            if label == "room" and any(shape.contains(lift) for lift in lifts):
                label = "elevator"
            drawing.add_room(element.id, label, name, shape, tags["indoor"] in UNWALLED)
        elif tags.get("indoor") in ROOMS and element.point is None:
            drawing.drop(f"{tags['indoor']} {name or element.id!r}", "its outline is not closed")
        elif element.door and element.point is not None:
            x, y = map(float, plane.metres(element.point)[0])
            drawing.doors.append(DrawnDoor(x, y, x, y, width=_width(tags)))
    return drawing


def levels_of(text: str) -> list[str]:
    """Return the levels that a tag names: "-1", "0;1", "0-2"."""
    found: list[float] = []
    for part in re.split(r"[;,]", text):
        span = re.fullmatch(r"\s*(-?\d{1,3}(?:\.\d+)?)\s*(?:-\s*(-?\d{1,3}(?:\.\d+)?))?\s*", part)
        if span is None:
            continue
        low = float(span[1])
        high = float(span[2]) if span[2] else low
        found += [low + k for k in range(min(max(int(high - low), 0) + 1, MOST_LEVELS))]
    return [f"{level:g}" for level in dict.fromkeys(found)] or ["0"]


def _label(tags: dict[str, str]) -> str:
    """Return the tag that says most about what a room is for."""
    if tags.get("stairs", "no") != "no" or tags.get("highway") == "steps":
        return "stairs"
    if "elevator" in (tags.get("highway"), tags.get("room")):
        return "elevator"
    for key in ("room", "amenity", "office", "shop", "tourism", "leisure"):
        value = tags.get(key)
        if value and value not in ("yes", "no"):
            return value if key in ("room", "amenity") else key
    return "corridor" if tags["indoor"] in UNWALLED else "room"


def _width(tags: dict[str, str]) -> float | None:
    found = re.match(r"\s*(\d{1,2}(?:\.\d+)?)", tags.get("door:width") or tags.get("width") or "")
    return float(found[1]) if found else None


def _from_geojson(root: Node) -> Iterator[_Element]:
    for feature in root["features"].items():
        properties, geometry = feature.get("properties"), feature.get("geometry")
        if properties is None or geometry is None:
            continue
        nested = properties.get("tags")
        named = nested.fields() if nested is not None and isinstance(nested.value, dict) else properties.fields()
        tags = {key: str(node.value)[:200] for key, node in named if isinstance(node.value, str | int | float)}
        key = feature.text_of("id") or feature.place
        if geometry.text_of("type") == "Point":
            point = geometry["coordinates"]
            yield _Element(key, tags, check_degrees(point, point.point()))
        else:
            yield _Element(key, tags, polygons=tuple(polygons_of(geometry)))


def _from_xml(path: Path, root: ElementTree.Element) -> Iterator[_Element]:
    nodes: dict[str, tuple[float, float]] = {}
    for node in root.iter("node"):
        nodes[node.get("id", "")] = point = _degrees(path, node)
        tags = _tags(node)
        if tags:
            yield _Element(f"node/{node.get('id')}", tags, point)
    rings: dict[str, Ring] = {}
    for way in root.iter("way"):
        ring = [nodes[ref] for ref in (nd.get("ref", "") for nd in way.iter("nd")) if ref in nodes]
        rings[way.get("id", "")] = ring
        closed = len(ring) >= 4 and ring[0] == ring[-1]
        yield _Element(f"way/{way.get('id')}", _tags(way), polygons=([ring],) if closed else ())
    for relation in root.iter("relation"):
        tags = _tags(relation)
        parts = {role: [rings.get(m.get("ref", ""), []) for m in relation.iter("member") if m.get("role") == role]
                 for role in ("outer", "inner")}  # fmt: skip
        closed_parts = [[r for r in parts[role] if len(r) >= 4 and r[0] == r[-1]] for role in ("outer", "inner")]
        if tags.get("type") == "multipolygon" and closed_parts[0]:
            shapes = tuple([outer, *closed_parts[1]] for outer in closed_parts[0])
            yield _Element(f"relation/{relation.get('id')}", tags, polygons=shapes)


def _tags(element: ElementTree.Element) -> dict[str, str]:
    return {tag.get("k", ""): tag.get("v", "")[:200] for tag in element.findall("tag")}


def _degrees(path: Path, node: ElementTree.Element) -> tuple[float, float]:
    values = []
    for key, most in (("lon", 180), ("lat", 89)):
        try:
            value = float(node.get(key) or "")
        except ValueError:
            value = math.nan
        if not abs(value) <= most:
            raise WorldError(
                f"{path}: <node id={short(node.get('id'))}> {key}: expected degrees up to {most}, "
                f"got {short(node.get(key))}"
            )
        values.append(value)
    return values[0], values[1]
