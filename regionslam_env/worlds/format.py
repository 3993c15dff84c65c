"""Our world format: a GeoJSON FeatureCollection in local metres.

Every feature says in ``properties.kind`` what it is:

========  ==================  ===========================================================================
kind      geometry            further properties
========  ==================  ===========================================================================
region    Polygon             id, type; name, parent; row (the paper's parameters x, y, w, h, phi, left, right)
wall      LineString          none
door      LineString          id (also that of a region), regions
obstacle  Polygon (convex)    none
link      null                source, target, source_edge, target_edge
========  ==================  ===========================================================================

A region without `row` is annotated: its polygon becomes the best row of at most three rectangles. ``properties.level``
names the level of a feature (default "0").
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.feature import Feature
from regionslam_env.worlds.world import Door, Link, Region, World
from slam.rows import Floats, Row
from slam.storage import replacing

KINDS = ("region", "wall", "door", "obstacle", "link")
MAX_BYTES = 50_000_000


def load_world(path: str | Path, level: str | None = None) -> World:
    """Read and check a world file.

    Parameters
    ----------
    path
        A file of our format.
    level
        Which level of several; default: the file's `level`, else the first that occurs.

    Raises
    ------
    WorldError
        Naming file, feature, field, value and expectation.
    """
    path = Path(path)
    data = read_json(path)
    if not isinstance(data, dict) or data.get("type") != "FeatureCollection":
        found = data.get("type") if isinstance(data, dict) else type(data).__name__
        raise WorldError(f"{path}: type is {found!r}, expected 'FeatureCollection'")
    listed = data.get("features")
    if not isinstance(listed, list) or not listed:
        raise WorldError(f"{path}: features: expected a list of at least one feature, got {_short(listed)}")
    features = [Feature.read(path, i, item, KINDS) for i, item in enumerate(listed)]
    levels = list(dict.fromkeys(f.level for f in features))
    default = data.get("level")
    level = level if level is not None else str(default) if default is not None else levels[0]
    if level not in levels:
        raise WorldError(f"{path}: {unknown('level', level, levels)}")
    return _build(path, data, [f for f in features if f.level == level], level)


def _build(path: Path, data: dict[str, Any], features: list[Feature], level: str) -> World:
    """Make the world of one level's features."""
    regions = [_region(f) for f in features if f.kind == "region"]
    if not regions:
        raise WorldError(f"{path}: level {level!r} has no feature of kind 'region', expected at least one")
    walls = [segment for f in features if f.kind == "wall" for segment in _segments(f)]
    doors = [_door(f) for f in features if f.kind == "door"]
    links = [
        Link(*(f.text(key) for key in ("source", "target", "source_edge", "target_edge")))
        for f in features
        if f.kind == "link"
    ]
    name = data.get("name", path.stem)
    if not isinstance(name, str):
        raise WorldError(f"{path}: name: expected a string, got {_short(name)}")
    try:
        return World(
            name=name,
            regions=tuple(regions),
            walls=np.array(walls).reshape(-1, 4),
            doors=tuple(doors),
            obstacles=tuple(f.convex() for f in features if f.kind == "obstacle"),
            links=tuple(links),
            level=level,
            spawn=_spawn(path, data.get("spawn")),
        )
    except WorldError as error:
        raise WorldError(f"{path}: {error}") from None


def save_world(world: World, path: str | Path) -> None:
    """Write a world in our format; the file appears complete or not at all."""
    path = Path(path)
    lines = ",\n".join(json.dumps(f, ensure_ascii=False, allow_nan=False) for f in _features(world))
    head: dict[str, Any] = {"type": "FeatureCollection", "name": world.name, "level": world.level}
    if world.spawn is not None:
        head["spawn"] = list(world.spawn)
    text = json.dumps(head, ensure_ascii=False)[:-1] + f', "features": [\n{lines}\n]}}\n'
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def read_json(path: Path) -> Any:
    """Return the JSON value in a file; `WorldError` where there is none."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise WorldError(f"{path}: {path.stat().st_size} bytes, expected at most {MAX_BYTES}")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise WorldError(f"{path}: cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        raise WorldError(f"{path}: byte {error.start} is not UTF-8, expected text in UTF-8") from None
    return parse_json(path, text)


def is_native(path: Path) -> bool:
    """Return whether a JSON file is meant to be of our format: some feature has one of our kinds, or all have any."""
    if path.is_dir() or path.suffix.lower() not in (".geojson", ".json"):
        return False
    data = read_json(path)
    features = data.get("features") if isinstance(data, dict) else None
    if not isinstance(features, list):
        return False
    kinds = [p.get("kind") for f in features if isinstance(f, dict) and isinstance(p := f.get("properties"), dict)]
    return None not in kinds or any(kind in KINDS for kind in kinds if isinstance(kind, str))


def parse_json(path: Path, text: str) -> Any:
    """Return the JSON value of a file's text; `WorldError` where there is none."""
    if not text.strip():
        raise WorldError(f"{path}: is empty, expected a GeoJSON FeatureCollection")
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise WorldError(f"{path}: line {error.lineno}, column {error.colno}: {error.msg}, expected JSON") from None
    except (RecursionError, ValueError) as error:
        raise WorldError(f"{path}: {error}, expected JSON") from None


def _region(feature: Feature) -> Region:
    row = feature.row()
    return Region(
        id=feature.text("id"),
        type=feature.text("type"),
        name=feature.text("name", default=feature.text("id")),
        row=row,
        parent=feature.optional_text("parent"),
    )


def _segments(feature: Feature) -> Iterator[tuple[float, ...]]:
    points = feature.line()
    for start, end in pairwise(points):
        yield (*start, *end)


def _door(feature: Feature) -> Door:
    points = feature.line()
    if len(points) != 2:
        raise feature.error("geometry.coordinates", len(points), "two points, the ends of the opening")
    (x0, y0), (x1, y1) = points
    return Door(feature.text("id"), float(x0), float(y0), float(x1), float(y1), feature.texts("regions"))


def _spawn(path: Path, value: Any) -> tuple[float, float, float] | None:
    if value is None:
        return None
    numbers = value if isinstance(value, list) else []
    if len(numbers) != 3 or not all(type(v) in (int, float) and abs(v) < 1e6 for v in numbers):
        raise WorldError(f"{path}: spawn: expected [x, y, theta] in metres and radians, got {_short(value)}")
    return float(numbers[0]), float(numbers[1]), float(numbers[2])


def _features(world: World) -> Iterator[dict[str, Any]]:
    """Yield every feature of the file, GeoJSON."""
    for region in world.regions:
        properties: dict[str, Any] = {"kind": "region", "id": region.id, "type": region.type, "name": region.name}
        if region.parent is not None:
            properties["parent"] = region.parent
        geometry: dict[str, Any] = {"type": "Polygon", "coordinates": [_closed(region.row.outline())]}
        yield _feature(geometry, {**properties, "row": _plain(region.row)}, world.level)
    for wall in world.walls:
        yield _feature(
            {"type": "LineString", "coordinates": _rounded(wall.reshape(2, 2))}, {"kind": "wall"}, world.level
        )
    for door in world.doors:
        geometry = {"type": "LineString", "coordinates": [[door.x0, door.y0], [door.x1, door.y1]]}
        yield _feature(geometry, {"kind": "door", "id": door.id, "regions": list(door.regions)}, world.level)
    for obstacle in world.obstacles:
        yield _feature({"type": "Polygon", "coordinates": [_closed(obstacle)]}, {"kind": "obstacle"}, world.level)
    for link in world.links:
        yield _feature(None, {"kind": "link", **vars(link)}, world.level)


def _feature(geometry: dict[str, Any] | None, properties: dict[str, Any], level: str) -> dict[str, Any]:
    return {"type": "Feature", "properties": {**properties, "level": level}, "geometry": geometry}


def _plain(row: Row) -> dict[str, Any]:
    """Return a row's parameters without absent subrectangles."""
    return {key: value for key, value in row.parameters().items() if value is not None}


def _closed(ring: Floats) -> list[list[float]]:
    return _rounded(np.concatenate([ring, ring[:1]]))


def _rounded(points: Floats) -> list[list[float]]:
    """Return points as lists; nothing is rounded away but -0.0."""
    return [[float(x) + 0.0, float(y) + 0.0] for x, y in points]


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
