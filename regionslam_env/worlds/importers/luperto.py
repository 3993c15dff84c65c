"""Floor plans in the XML of Luperto and Amigoni: real schools and offices with labelled rooms and doors.

Rooms are polygons in pixels, y down. A portal names the two spaces that it joins and a line segment, often of no
length. The scale takes a door to be 90 cm wide and is often far off, see `plan_scale`.
"""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
import shapely

from regionslam_env.errors import WorldError
from regionslam_env.worlds.plan import Portal, Space, build
from regionslam_env.worlds.world import World

MAX_BYTES = 50_000_000

TRUSTED = 1.3
"""Factor by which typical room areas must contradict the file's scale before they overrule it."""


def load_luperto(path: str | Path, scale: float | None = None, door_width: float = 0.9) -> World:
    """Read a plan and return its world.

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
    path = Path(path)
    root = _parse(path)
    if scale is None:
        scale = plan_scale(path)
    if not (math.isfinite(scale) and scale > 0):
        raise WorldError(f"{path}: scale: expected metres per pixel above 0, got {scale!r}")
    counts: dict[str, int] = {}
    ids: dict[str, str] = {}
    spaces = []
    for key, label, polygon in _spaces(path, root):
        kind = type_of(label)
        counts[kind] = counts.get(kind, 0) + 1
        ids[key] = f"{kind} {counts[kind]}"
        outline = shapely.transform(polygon, lambda p: p * (scale, -scale))
        spaces.append(Space(ids[key], kind, f"{label.lower()} {counts[kind]}", outline))
    if not spaces:
        raise WorldError(f"{path}: no <space> with a <bounding_polygon>, expected at least one")
    portals = [
        Portal(x * scale, -y * scale, (ids[first], ids[second]))
        for x, y, first, second in _portals(path, root)
        if first in ids and second in ids
    ]
    return build(path.stem, spaces, portals, door_width)


def plan_scale(path: str | Path) -> float:
    """Return metres per pixel: the file's own scale, unless rooms would be far too large or small for what they are.

    Rooms whose label has a typical area vote with the square root of typical over drawn area; the median overrules the
    file where it differs by more than `TRUSTED`.
    """
    path = Path(path)
    root = _parse(path)
    stated = _stated_scale(path, root)
    votes = []
    for _, label, polygon in _spaces(path, root):
        area = _table().get(label.upper(), ("other", None))[1]
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


def type_of(label: str) -> str:
    """Return our semantic type for a space's label; "other" for an unknown one."""
    return _table().get(label.strip().upper(), ("other", None))[0]


@cache
def _table() -> dict[str, tuple[str, float | None]]:
    text = (resources.files("regionslam_env.worlds.importers") / "luperto_types.json").read_text(encoding="utf-8")
    return {label: (kind, area) for label, (kind, area) in json.loads(text)["labels"].items()}


def _parse(path: Path) -> ElementTree.Element:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise WorldError(f"{path}: {path.stat().st_size} bytes, expected at most {MAX_BYTES}")
        data = path.read_bytes()
    except OSError as error:
        raise WorldError(f"{path}: cannot be read: {error.strerror or error}") from None
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise WorldError(f"{path}: has a document type declaration, expected a plain <building>")
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise WorldError(f"{path}: {error}, expected XML") from None
    if root.tag != "building":
        raise WorldError(f"{path}: root element is <{root.tag}>, expected <building>")
    return root


def _stated_scale(path: Path, root: ElementTree.Element) -> float | None:
    """Return the file's metres per pixel, None where it states none."""
    drawn, real = root.findtext("scale/represented_distance/value"), root.findtext("scale/real_distance/value")
    if drawn is None or real is None:
        return None
    unit = (root.findtext("scale/real_distance/um") or "cm").strip().lower()
    metres = {"cm": 0.01, "mm": 0.001, "m": 1.0}.get(unit)
    if metres is None:
        raise WorldError(f"{path}: scale/real_distance/um: expected cm, mm or m, got {unit!r}")
    pixels, length = (
        _number(path, "scale/represented_distance/value", drawn),
        _number(path, "scale/real_distance/value", real),
    )
    if pixels <= 0 or length <= 0:
        raise WorldError(f"{path}: scale: expected distances above 0, got {drawn!r} and {real!r}")
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
            raise WorldError(f"{path}: <space id={key!r}>: expected an id that no other space has")
        seen.add(key)
        where = f"<space id={key!r}>/<bounding_polygon>"
        points = [_point(path, where, point) for point in ring.findall("point")]
        if len(set(points)) < 3:
            raise WorldError(f"{path}: {where}: expected at least 3 different points, got {len(set(points))}")
        shape = shapely.make_valid(shapely.Polygon(points))
        parts = [part for part in shapely.get_parts(shape) if isinstance(part, shapely.Polygon)]
        polygon = max(parts, key=lambda part: part.area, default=shapely.Polygon())
        if polygon.area <= 0:
            raise WorldError(f"{path}: {where}: expected an outline with an area, got {polygon.area:g} square pixels")
        label = space.findtext("labels/label") or "other"
        yield key, " ".join(label.split()), polygon


def _portals(path: Path, root: ElementTree.Element) -> Iterator[tuple[float, float, str, str]]:
    """Yield the midpoint (pixels) of every portal once, and the ids of its two spaces."""
    middles = {}
    for segment in root.iter("linesegment"):
        points = [_point(path, f"<linesegment id={segment.get('id')!r}>", p) for p in segment.findall("point")]
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
    if not math.isfinite(value) or abs(value) > 1e7:
        raise WorldError(f"{path}: {field}: expected a number, got {text!r}")
    return value
