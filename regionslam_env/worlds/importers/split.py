"""Rooms that no row of three rectangles describes (a ring of corridors, an open floor), cut into some that it does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
import shapely.ops

from regionslam_env.worlds.annotate import annotate, side_directions
from regionslam_env.worlds.importers.drawing import Drawing, DrawnRoom, cleaned, polygons
from slam.rows import Floats

ENOUGH = 0.95
"""IoU at which a room is left whole."""

GAIN = 0.04
"""IoU (area-weighted over the pieces) that a cut must bring."""

NARROWEST = 1.2
"""Least width (m) of a piece."""

DEEPEST = 3
"""Cuts one after the other: at most 2^3 pieces, more where a cut meets an outline several times."""

MOST_CUTS = 16
"""Cuts that are tried for a room, shortest first."""


def split_rooms(drawing: Drawing) -> None:
    """Cut the rooms of a drawing that fit badly; pieces stand open to each other, and are named by the first's key."""
    rooms: list[DrawnRoom] = []
    for room in drawing.rooms:
        pieces = split(room.polygon)
        parts = [
            replace(room, key=f"{room.key}/{k + 1}" if k else room.key, polygon=piece) for k, piece in enumerate(pieces)
        ]
        rooms += parts
        drawing.passages += [
            (a.key, b.key)
            for i, a in enumerate(parts)
            for b in parts[i + 1 :]
            if a.polygon.intersection(b.polygon.buffer(1e-3)).area > 1e-4
        ]
        if len(parts) > 1:
            drawing.pieces[room.key] = tuple(part.key for part in parts)
            drawing.notes.append(
                f"{room.name or room.key} is cut into {len(parts)} regions that stand open to each other"
            )
    drawing.rooms = rooms


def split(polygon: shapely.Polygon, depth: int = DEEPEST) -> list[shapely.Polygon]:
    """Return a polygon whole, or in pieces along chords through its inner corners where those fit better."""
    fit = _fit(polygon)
    if fit >= ENOUGH or depth == 0:
        return [polygon]
    best: tuple[float, list[shapely.Polygon]] = (fit + GAIN, [])
    for chord in _chords(polygon):
        pieces = [cleaned(p) for p in polygons(shapely.ops.split(polygon, chord))]
        if len(pieces) < 2 or any(p.buffer(-NARROWEST / 2).is_empty for p in pieces):
            continue
        score = sum(_fit(p) * p.area for p in pieces) / polygon.area
        if score > best[0] + 1e-9:
            best = (score, pieces)
    return [part for piece in best[1] for part in split(piece, depth - 1)] or [polygon]


def _fit(polygon: shapely.Polygon) -> float:
    return annotate(polygon, side_directions(polygon, most=1))[1]


def _chords(polygon: shapely.Polygon) -> list[shapely.Geometry]:
    """Return cuts along the polygon's main directions through its inner corners: the chord there, or the whole line."""
    corners = _inner_corners(shapely.simplify(polygon, 0.05))
    reach = float(np.hypot(*(np.array(polygon.bounds[2:]) - polygon.bounds[:2]))) + 1.0
    inside = polygon.buffer(1e-6)
    found: list[tuple[float, shapely.Geometry]] = []
    for heading in side_directions(polygon, most=1):
        for angle in (heading, heading + np.pi / 2):
            along = np.array([np.cos(angle), np.sin(angle)])
            for corner in corners:
                line = shapely.LineString([corner - reach * along, corner + reach * along])
                parts = list(shapely.get_parts(line.intersection(inside)))
                here = [part for part in parts if part.distance(shapely.Point(corner)) < 1e-3]
                for cut in ([line] if len(parts) > 1 or polygon.interiors else []) + here:
                    ends = shapely.get_coordinates(cut)
                    longer = shapely.LineString([ends[0] - 1e-3 * along, ends[-1] + 1e-3 * along])
                    found.append((round(float(cut.intersection(inside).length), 3), longer))
    unique: dict[tuple[float, ...], shapely.Geometry] = {}
    for length, cut in sorted(found, key=lambda item: item[0]):
        middle = cut.centroid
        unique.setdefault((length, round(middle.x, 1), round(middle.y, 1)), cut)
    return list(unique.values())[:MOST_CUTS]


def _inner_corners(polygon: shapely.Polygon) -> Floats:
    """Return the corners at which a counter-clockwise polygon turns inwards, those of its holes included, (k, 2)."""
    found = []
    for ring, sign in [(polygon.exterior, 1.0), *((hole, -1.0) for hole in polygon.interiors)]:
        points = shapely.get_coordinates(ring)[:-1]
        if ring.is_ccw != (sign > 0):
            points = points[::-1]
        before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        sine = cross / np.maximum(np.hypot(*before.T) * np.hypot(*after.T), 1e-12)
        found.append(points[sine < -0.1])
    return np.concatenate(found)
