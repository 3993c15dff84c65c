"""Region features as GeoJSON, without loss, in local metres."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from slam.region import EDGE_NAMES, EdgeState, RegionFeature, Subrectangle
from slam.rows import Row

KIND = "region"
FRAME = "local metres"
VERSION = 2
"""Version 2 added `level` and `name`; files of version 1 are read with level 0 and no names."""


class MapError(ValueError):
    """A stored map that cannot be read; the message names the feature, the field and what was expected."""


def features_to_geojson(features: Iterable[RegionFeature]) -> dict[str, Any]:
    """Return a FeatureCollection: outlines as polygons, every field of Fig. 1 as a property. Coordinates are metres."""
    return {
        "type": "FeatureCollection",
        "name": "region map",
        "frame": FRAME,
        "version": VERSION,
        "features": [feature_to_geojson(feature) for feature in features],
    }


def feature_to_geojson(feature: RegionFeature) -> dict[str, Any]:
    """Return one region as a GeoJSON Feature."""
    properties = {
        "kind": KIND,
        "id": int(feature.id),
        "type": feature.type,
        "name": feature.name,
        "level": int(feature.level),
        **{name: _number(getattr(feature, name)) for name in _NUMBERS},
        **{name: EdgeState(getattr(feature, name)).name.lower() for name in ("t", "b", "l", "r")},
        "cov_xy": _matrix(feature.cov_xy),
        "cov_wh": _matrix(feature.cov_wh),
        "left": None if feature.left is None else _subrectangle(feature.left),
        "right": None if feature.right is None else _subrectangle(feature.right),
        "neighbours": {edge: _log_odds(links) for edge, links in feature.neighbours.items()},
        "children": _log_odds(feature.children),
        "sightings": int(feature.sightings),
        "visited": bool(feature.visited),
        "credible": bool(feature.credible),
        "open_edges": list(feature.open_edges),
    }
    return {"type": "Feature", "id": int(feature.id), "geometry": row_geometry(feature.row), "properties": properties}


def row_geometry(row: Row) -> dict[str, Any]:
    """Return a row's outline: a Polygon, or a MultiPolygon of its rectangles where two of them don't touch."""
    joined = all(min(row.t[i], row.t[i + 1]) > max(row.b[i], row.b[i + 1]) for i in range(row.n - 1))
    if joined:
        return {"type": "Polygon", "coordinates": [_ring(row.outline())]}
    return {"type": "MultiPolygon", "coordinates": [[_ring(corners)] for corners in row.rectangles()]}


def features_from_geojson(collection: object) -> tuple[RegionFeature, ...]:
    """Return the regions of a FeatureCollection that `features_to_geojson` made; features of another kind are skipped.

    Raises
    ------
    MapError
        If something is missing, of the wrong type or out of range.
    """
    if not isinstance(collection, Mapping) or collection.get("type") != "FeatureCollection":
        raise MapError("expected a GeoJSON object of type 'FeatureCollection'")
    version = collection.get("version", 1)
    if version not in range(1, VERSION + 1):
        raise MapError(f"version is {_shown(version)}, expected 1 to {VERSION}")
    features = collection.get("features")
    if not isinstance(features, list):
        raise MapError(f"features is {_shown(features)}, expected a list")
    found = []
    for index, feature in enumerate(features):
        properties = feature.get("properties") if isinstance(feature, Mapping) else None
        if not isinstance(properties, Mapping):
            raise MapError(f"feature {index}: properties is {_shown(properties)}, expected an object")
        if properties.get("kind") == KIND:
            if version == 1:
                properties = {"name": "", "level": 0, **properties}
            found.append(_feature(index, properties))
    return tuple(found)


_NUMBERS = ("type_log_odds", "x", "y", "w", "h", "phi", "var_phi", "existence")


def _feature(index: int, properties: Mapping[str, Any]) -> RegionFeature:
    def read(name: str, convert: Callable[[Any], Any], expected: str) -> Any:
        if name not in properties:
            raise MapError(f"feature {index}: {name} is missing, expected {expected}")
        try:
            return convert(properties[name])
        except (TypeError, ValueError, KeyError, AttributeError, OverflowError):
            raise MapError(f"feature {index}: {name} is {_shown(properties[name])}, expected {expected}") from None

    numbers = {name: read(name, float, "a number") for name in _NUMBERS}
    states = {name: read(name, _state, "open, closed or subrect") for name in ("t", "b", "l", "r")}
    matrices = {name: read(name, _read_matrix, "a 2 x 2 matrix") for name in ("cov_xy", "cov_wh")}
    sides = {name: read(name, _read_subrectangle, "a subrectangle or null") for name in ("left", "right")}
    flags = {name: read(name, _flag, "true or false") for name in ("visited", "credible")}
    feature = RegionFeature(
        id=read("id", _integer, "an integer"),
        type=read("type", _text, "a text"),
        name=read("name", _text, "a text"),
        level=read("level", _integer, "an integer"),
        sightings=read("sightings", _integer, "an integer"),
        neighbours=read("neighbours", _read_neighbours, f"links by edge name ({', '.join(EDGE_NAMES)})"),
        children=read("children", _read_log_odds, "log-odds by region id"),
        **numbers,
        **states,
        **matrices,
        **sides,
        **flags,
    )
    _check_geometry(index, feature)
    return feature


def _check_geometry(index: int, feature: RegionFeature) -> None:
    if not all(map(math.isfinite, (feature.x, feature.y, feature.w, feature.h, feature.phi))):
        raise MapError(f"feature {index}: x, y, w, h and phi must be finite")
    try:
        feature.row  # noqa: B018 - a row checks itself
    except ValueError as error:
        raise MapError(f"feature {index}: {error}") from None
    for name, side in (("l", feature.left), ("r", feature.right)):
        if (getattr(feature, name) is EdgeState.SUBRECT) != (side is not None):
            expected = "subrect exactly where there is a subrectangle on that side"
            raise MapError(f"feature {index}: {name} is {getattr(feature, name).name.lower()}, expected {expected}")


def _number(value: float) -> float | str:
    """Return a number as JSON can hold it: what isn't finite becomes a text that `float` reads."""
    value = float(value)
    return value if math.isfinite(value) else str(value)


def _matrix(matrix: Any) -> list[list[float | str]]:
    return [[_number(value) for value in row] for row in np.asarray(matrix)]


def _read_matrix(value: Any) -> Any:
    matrix = np.array([[float(entry) for entry in row] for row in value])
    if matrix.shape != (2, 2):
        raise ValueError
    return matrix


def _log_odds(links: Mapping[int, float]) -> dict[str, float | str]:
    return {str(int(other)): _number(log_odds) for other, log_odds in links.items()}


def _read_log_odds(value: Any) -> dict[int, float]:
    return {int(other): float(log_odds) for other, log_odds in value.items()}


def _read_neighbours(value: Any) -> dict[str, dict[int, float]]:
    if not set(value) <= set(EDGE_NAMES):
        raise ValueError
    return {edge: _read_log_odds(links) for edge, links in value.items()}


def _subrectangle(side: Subrectangle) -> dict[str, Any]:
    return {
        **{name: _number(getattr(side, name)) for name in ("w", "h", "y", "var_y")},
        **{name: EdgeState(getattr(side, name)).name.lower() for name in ("t", "b", "end")},
        "cov_wh": _matrix(side.cov_wh),
    }


def _read_subrectangle(value: Any) -> Subrectangle | None:
    if value is None:
        return None
    fields: dict[str, Any] = {name: float(value[name]) for name in ("w", "h", "y", "var_y")}
    fields |= {name: _state(value[name]) for name in ("t", "b", "end")}
    return Subrectangle(**fields, cov_wh=_read_matrix(value["cov_wh"]))


def _state(value: Any) -> EdgeState:
    return EdgeState[value.upper()]


def _integer(value: Any) -> int:
    if isinstance(value, bool) or int(value) != value:
        raise ValueError
    return int(value)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


def _ring(points: Any) -> list[list[float]]:
    """Return a closed ring without repeated points and without points on a straight line."""
    ring = [list(map(float, point)) for point in points]
    corners = []
    for i, point in enumerate(ring):
        before = next(p for k in range(1, len(ring)) if math.dist(p := ring[i - k], point) > 1e-9)
        after = next(p for k in range(len(ring)) if math.dist(p := ring[(i + k) % len(ring)], point) > 1e-9)
        turn = (point[0] - before[0]) * (after[1] - point[1]) - (point[1] - before[1]) * (after[0] - point[0])
        repeated = math.dist(ring[i - 1], point) <= 1e-9
        if abs(turn) > 1e-12 and not repeated:
            corners.append(point)
    return [*corners, corners[0]]


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
