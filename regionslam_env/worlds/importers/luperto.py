"""Floor plans in the XML of Luperto and Amigoni: real schools and offices with labelled rooms and doors.

Rooms are polygons in pixels, y down. A portal names the two spaces that it joins and a line segment, often of no
length. The scale takes a door to be 90 cm wide and is often far off, see `plan_scale`.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import shapely

from regionslam_env.errors import WorldError, short
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor, cleaned
from regionslam_env.worlds.importers.node import LARGEST
from regionslam_env.worlds.importers.realise import ImportOptions, realise
from regionslam_env.worlds.importers.source import Source
from regionslam_env.worlds.importers.vocabulary import vocabulary
from regionslam_env.worlds.world import World

TRUSTED = 1.3
"""Factor by which typical room areas must contradict the file's scale before they overrule it."""


def load_luperto(path: str | Path, scale: float | None = None, door_width: float = 0.9) -> World:
    """Read a plan and return its world, with the doors of the file alone.

    Parameters
    ----------
    path
        The XML file.
    scale
        Metres per pixel; default: `plan_scale`.
    door_width
        Width of the gaps cut at portals, m.

    Raises
    ------
    WorldError
        Naming file, element and expectation.
    """
    options = ImportOptions(scale=scale, door_width=door_width, assume_doors=False, split=False)
    return realise(read(Source(Path(path)), options), vocabulary("luperto"), options).world


def refusal(source: Source) -> str | None:
    """Return why a file is no such plan, None where it is one."""
    root = source.xml
    return None if root.tag == "building" else f"root element is <{root.tag[:80]}>, expected <building>"


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of a plan; it has one level."""
    path, root = source.path, source.xml
    reason = refusal(source)
    if reason:
        raise WorldError(f"{path}: {reason}")
    scale = options.scale
    if scale is None:
        scale = _scale(path, root)
    if not (math.isfinite(scale) and scale > 0):
        raise WorldError(f"{path}: scale: expected metres per pixel above 0, got {scale!r}")
    drawing = Drawing(path.stem, scale=scale)
    for key, label, polygon in _spaces(path, root):
        drawing.add_room(key, label, None, shapely.transform(polygon, lambda p: p * (scale, -scale)))
    if not drawing.rooms and not drawing.dropped:
        raise WorldError(f"{path}: no <space> with a <bounding_polygon>, expected at least one")
    for x, y, first, second in _portals(path, root):
        drawing.doors.append(DrawnDoor(x * scale, -y * scale, x * scale, -y * scale, (first, second)))
    return drawing


def plan_scale(path: str | Path) -> float:
    """Return metres per pixel: the file's own scale, unless rooms would be far too large or small for what they are.

    Rooms whose label has a typical area vote with the square root of typical over drawn area; the median overrules the
    file where it differs by more than `TRUSTED`.
    """
    source = Source(Path(path))
    return _scale(source.path, source.xml)


def type_of(label: str) -> str:
    """Return our semantic type for a space's label; "other" for an unknown one."""
    return vocabulary("luperto").type_of(label)


def _scale(path: Path, root: ElementTree.Element) -> float:
    stated = _stated_scale(path, root)
    votes = []
    for _, label, polygon in _spaces(path, root):
        area = vocabulary("luperto").area_of(label)
        if area is not None:
            votes.append(0.5 * math.log(area / polygon.area))
    if not votes:
        if stated is None:
            raise WorldError(
                f"{path}: <scale> is missing and no room has a typical size: give a scale in metres per pixel"
            )
        return stated
    typical = math.exp(float(np.median(votes)))
    if stated is not None and 1 / TRUSTED <= typical / stated <= TRUSTED:
        return stated
    return typical


def _stated_scale(path: Path, root: ElementTree.Element) -> float | None:
    """Return the file's metres per pixel, None where it states none."""
    drawn, real = root.findtext("scale/represented_distance/value"), root.findtext("scale/real_distance/value")
    if drawn is None or real is None:
        return None
    unit = (root.findtext("scale/real_distance/um") or "cm").strip().lower()
    metres = {"cm": 0.01, "mm": 0.001, "m": 1.0}.get(unit)
    if metres is None:
        raise WorldError(f"{path}: scale/real_distance/um: expected cm, mm or m, got {short(unit)}")
    pixels, length = (
        _number(path, "scale/represented_distance/value", drawn),
        _number(path, "scale/real_distance/value", real),
    )
    if pixels <= 0 or length <= 0:
        raise WorldError(f"{path}: scale: expected distances above 0, got {short(drawn)} and {short(real)}")
    return length * metres / pixels


def _spaces(path: Path, root: ElementTree.Element) -> Iterator[tuple[str, str, shapely.Polygon]]:
    """Yield id, label and polygon (pixels) of every space; one without a polygon only refers to a group."""
    seen = set()
    for space in root.iter("space"):
        ring = space.find("bounding_polygon")
        if ring is None:
            continue
        key = space.get("id") or ""
        if not key or key in seen:
            raise WorldError(f"{path}: <space id={short(key)}>: expected an id that no other space has")
        seen.add(key)
        where = f"<space id={short(key)}>/<bounding_polygon>"
        points = [_point(path, where, point) for point in ring.findall("point")]
        if len(set(points)) < 3:
            raise WorldError(f"{path}: {where}: expected at least 3 different points, got {len(set(points))}")
        polygon = cleaned(points)
        if polygon.area <= 0:
            raise WorldError(f"{path}: {where}: expected an outline with an area, got {polygon.area:g} square pixels")
        label = space.findtext("labels/label") or "other"
        yield key, " ".join(label.split()), polygon


def _portals(path: Path, root: ElementTree.Element) -> Iterator[tuple[float, float, str, str]]:
    """Yield the midpoint (pixels) of every portal once, and the ids of its two spaces."""
    middles = {}
    for segment in root.iter("linesegment"):
        points = [_point(path, f"<linesegment id={short(segment.get('id'))}>", p) for p in segment.findall("point")]
        if points and segment.get("id"):
            middles[segment.get("id")] = tuple(np.mean(points, axis=0))
    seen = set()
    for portal in root.iter("portal"):
        pair = [(target.text or "").strip() for target in portal.findall("target/id")]
        middle = middles.get((portal.findtext("linesegment") or "").strip())
        if len(pair) != 2 or pair[0] == pair[1] or middle is None:
            continue
        key = (frozenset(pair), middle)
        if key not in seen:
            seen.add(key)
            yield float(middle[0]), float(middle[1]), pair[0], pair[1]


def _point(path: Path, where: str, point: ElementTree.Element) -> tuple[float, float]:
    x, y = (_number(path, f"{where} point {axis}", point.get(axis)) for axis in ("x", "y"))
    return x, y


def _number(path: Path, field: str, text: str | None) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or abs(value) > LARGEST:
        raise WorldError(f"{path}: {field}: expected a number, got {short(text)}")
    return value
