"""From longitude and latitude to metres on a plane that touches the earth at the building."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.node import Node
from slam.rows import Floats

EQUATOR = 6378137.0
"""Semi-major axis of WGS 84, m."""

ECCENTRICITY2 = 6.69437999014e-3
"""First eccentricity of WGS 84, squared."""


class LocalPlane:
    """East (x) and north (y) in metres from an origin; 1 km away it is off by less than a millimetre.

    With the radii of curvature M along the meridian and N across it at the origin, x = N cos(lat) dlon, y = M dlat.
    """

    def __init__(self, longitude: float, latitude: float) -> None:
        self.origin = (longitude, latitude)
        lat = math.radians(latitude)
        w = 1 - ECCENTRICITY2 * math.sin(lat) ** 2
        self._metres = math.radians(1) * np.array(
            [EQUATOR / math.sqrt(w) * math.cos(lat), EQUATOR * (1 - ECCENTRICITY2) / w**1.5]
        )

    def metres(self, points: ArrayLike) -> Floats:
        """Return points (k, 2) of longitude and latitude (degrees) in metres."""
        return (np.asarray(points, dtype=np.float64).reshape(-1, 2) - self.origin) * self._metres


def check_degrees(node: Node, point: tuple[float, float]) -> tuple[float, float]:
    """Return a point that can be longitude and latitude; `WorldError` for one that cannot."""
    if not (abs(point[0]) <= 180 and abs(point[1]) <= 89):
        raise node.error("longitude and latitude in degrees (is it a projected file?)")
    return point


def origin_of(points: list[tuple[float, float]], file: Any) -> LocalPlane:
    """Return the plane at the middle of some points of longitude and latitude."""
    if not points:
        raise WorldError(f"{file}: no coordinates, expected at least one outline")
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    if (high - low).max() > 0.2:
        raise WorldError(f"{file}: {(high - low).max():.2g} degrees across, expected one building")
    return LocalPlane(*((low + high) / 2).tolist())


def polygons_of(geometry: Node) -> list[list[list[tuple[float, float]]]]:
    """Return the rings of every polygon of a GeoJSON geometry in degrees; none for one that is no area."""
    form = geometry.text_of("type")
    if form not in ("Polygon", "MultiPolygon"):
        return []
    coordinates = geometry["coordinates"]
    shapes = [coordinates] if form == "Polygon" else list(coordinates.items())
    return [[[check_degrees(p, p.point()) for p in ring.items()] for ring in shape.items()] for shape in shapes]


def projected(plane: LocalPlane, rings: list[list[tuple[float, float]]]) -> shapely.Geometry:
    """Return a polygon of degrees in metres; rings of fewer than three points count as nothing."""
    loops = [plane.metres(ring) for ring in rings if len(ring) >= 4]
    if not loops:
        return shapely.Polygon()
    holes = shapely.union_all([shapely.make_valid(shapely.Polygon(loop)) for loop in loops[1:]])
    return shapely.make_valid(shapely.Polygon(loops[0])).difference(holes)
