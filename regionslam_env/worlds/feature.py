"""One feature of a world file: typed access to its fields, with errors that say where and what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.annotate import annotate
from slam.rows import Floats, Row

FARTHEST = 1e5
"""Largest coordinate (m) of a plausible building."""

SMALLEST = 1e-3
"""Smallest width (m) of a region or obstacle."""

AGREEMENT = 0.98
"""Least IoU of a region's row with its polygon: someone edited one without the other."""

_ROW_FIELDS = ("x", "y", "w", "h", "phi", "left", "right")
_MISSING = object()


@dataclass(frozen=True)
class Feature:
    """A feature with its place in the file."""

    path: Path
    number: int
    kind: str
    properties: dict[str, Any]
    geometry: dict[str, Any] | None

    @classmethod
    def read(cls, path: Path, number: int, item: Any, kinds: Sequence[str]) -> Feature:
        """Check the outer form of a feature."""
        place = f"{path}: features[{number}]"
        if not isinstance(item, dict) or item.get("type") != "Feature":
            raise WorldError(f"{place}: expected an object of type 'Feature', got {_short(item)}")
        properties = item.get("properties")
        if not isinstance(properties, dict):
            raise WorldError(f"{place}: properties: expected an object, got {_short(properties)}")
        kind = properties.get("kind")
        if not isinstance(kind, str) or kind not in kinds:
            raise WorldError(f"{place}: properties.kind: {unknown('kind', kind, kinds)}")
        geometry = item.get("geometry")
        if geometry is not None and not isinstance(geometry, dict):
            raise WorldError(f"{place}: geometry: expected an object or null, got {_short(geometry)}")
        return cls(path, number, kind, properties, geometry)

    @property
    def level(self) -> str:
        """Name of its level."""
        return str(self.properties.get("level", "0"))

    def error(self, field: str, value: Any, expected: str) -> WorldError:
        """Return an error about one field."""
        name = self.properties.get("id")
        what = f"{self.kind} {name!r}" if isinstance(name, str) else self.kind
        return WorldError(
            f"{self.path}: features[{self.number}] ({what}): {field}: expected {expected}, got {_short(value)}"
        )

    def text(self, field: str, default: str | None = None) -> str:
        """Return a property that must be a string with something in it."""
        value = self.properties.get(field, default)
        if not isinstance(value, str) or not value.strip():
            raise self.error(f"properties.{field}", value, "a string that is not empty")
        return value

    def optional_text(self, field: str) -> str | None:
        """Return a string property, or None where it is missing or null."""
        return None if self.properties.get(field) is None else self.text(field)

    def texts(self, field: str) -> tuple[str, ...]:
        """Return a property that must be a list of strings."""
        value = self.properties.get(field)
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            raise self.error(f"properties.{field}", value, "a list of strings")
        return tuple(value)

    def line(self) -> Floats:
        """Return the points of a LineString, shape (k >= 2, 2), m."""
        points = self._points("LineString", self._coordinates("LineString"))
        if len(points) < 2 or not (np.hypot(*np.diff(points, axis=0).T) > 0).all():
            raise self.error("geometry.coordinates", points.tolist(), "at least two points, neighbours apart")
        return points

    def polygon(self) -> shapely.Polygon:
        """Return a simple polygon without holes, counter-clockwise, m."""
        rings = self._coordinates("Polygon")
        if len(rings) != 1:
            raise self.error("geometry.coordinates", f"{len(rings)} rings", "one ring: holes are not supported")
        points = self._points("Polygon", rings[0])
        if len(points) < 4 or not np.array_equal(points[0], points[-1]):
            raise self.error(
                "geometry.coordinates", points.tolist(), "a ring of at least 4 points whose last is its first"
            )
        polygon = shapely.Polygon(points)
        if not polygon.is_valid:
            raise self.error(
                "geometry.coordinates", shapely.is_valid_reason(polygon), "a ring that does not cross itself"
            )
        if polygon.buffer(-SMALLEST / 2).is_empty:
            raise self.error("geometry.coordinates", f"area {polygon.area:.3g} m²", f"a width above {SMALLEST} m")
        return orient(polygon)

    def convex(self) -> Floats:
        """Return the corners of a convex polygon, counter-clockwise, shape (k, 2), m."""
        polygon = self.polygon()
        if polygon.area < 0.999 * polygon.convex_hull.area:
            raise self.error("geometry.coordinates", "a dent", "a convex polygon: split it into several obstacles")
        exact = polygon.area >= (1 - 1e-12) * polygon.convex_hull.area
        corners = (polygon if exact else orient(polygon.convex_hull)).exterior
        return np.asarray(shapely.get_coordinates(corners)[:-1])

    def row(self) -> Row:
        """Return the region's row: as given in the properties, else the best one for the polygon."""
        value = self.properties.get("row", _MISSING)
        if value is _MISSING:
            return annotate(self.polygon())[0]
        row = self._given_row(value)
        if self.geometry is not None:
            polygon = self.polygon()
            own = shapely.union_all([shapely.Polygon(r) for r in row.rectangles()])
            iou = own.intersection(polygon).area / own.union(polygon).area
            if iou < AGREEMENT:
                raise self.error("properties.row", f"IoU {iou:.2f}", f"the place of the polygon (IoU >= {AGREEMENT})")
        return row

    def _given_row(self, value: Any) -> Row:
        if not isinstance(value, dict):
            raise self.error("properties.row", value, f"an object of {', '.join(_ROW_FIELDS)}")
        for key in value:
            if key not in _ROW_FIELDS:
                raise self.error("properties.row", key, f"a known field ({unknown('field', key, _ROW_FIELDS)})")
        x, y, phi = (self._number(f"properties.row.{key}", value.get(key, 0.0)) for key in ("x", "y", "phi"))
        w, h = (self._size(f"properties.row.{key}", value.get(key)) for key in ("w", "h"))
        left, right = (self._subrectangle(key, value.get(key)) for key in ("left", "right"))
        return Row.from_parameters(x, y, w, h, phi, left, right)

    def _subrectangle(self, key: str, value: Any) -> tuple[float, float, float] | None:
        if value is None:
            return None
        field = f"properties.row.{key}"
        if not isinstance(value, list | tuple) or len(value) != 3:
            raise self.error(field, value, "[width, height, displacement] in metres")
        return self._size(field, value[0]), self._size(field, value[1]), self._number(field, value[2])

    def _size(self, field: str, value: Any) -> float:
        number = self._number(field, value)
        if number < SMALLEST:
            raise self.error(field, value, f"a size of at least {SMALLEST} m")
        return number

    def _number(self, field: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(field, value, "a number")
        if not abs(value) <= FARTHEST:  # NaN is neither
            raise self.error(field, value, f"a finite number of at most {FARTHEST:g}")
        return float(value)

    def _coordinates(self, form: str) -> list[Any]:
        geometry = self.geometry
        if geometry is None or geometry.get("type") != form:
            raise self.error("geometry.type", geometry and geometry.get("type"), f"{form!r}")
        coordinates = geometry.get("coordinates")
        if not isinstance(coordinates, list) or not coordinates:
            raise self.error("geometry.coordinates", coordinates, f"the coordinates of a {form}")
        return coordinates

    def _points(self, form: str, values: Any) -> Floats:
        if not isinstance(values, list):
            raise self.error("geometry.coordinates", values, f"the points of a {form}")
        points = []
        for i, value in enumerate(values):
            if not isinstance(value, list) or len(value) not in (2, 3):
                raise self.error(f"geometry.coordinates[{i}]", value, "a point [x, y] in metres")
            points.append([self._number(f"geometry.coordinates[{i}]", v) for v in value[:2]])
        return np.array(points, dtype=np.float64).reshape(-1, 2)


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= 80 else text[:77] + "..."
