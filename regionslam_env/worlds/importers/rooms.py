"""Rooms out of what is not drawn as rooms: free space cut at narrow gaps, or walls that enclose it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
import shapely.ops

from regionslam_env.worlds.importers.drawing import cleaned, polygons
from slam.rows import Floats

ASIDE = 0.12
"""How far (m) the next wall may lie beside the line of the wall before a gap."""

THIN = 0.04
"""Width (m) that a wall without thickness takes up while rooms are looked for."""

EXTENSION = 0.25
"""How far (m) walls and doors are lengthened, so that corners drawn by hand close."""

LEAST = 1.0
"""Pieces below this (m²) are no rooms."""


@dataclass(frozen=True)
class Gap:
    """A narrow place between two rooms (indices): its ends across the way (m)."""

    rooms: tuple[int, int]
    x0: float
    y0: float
    x1: float
    y1: float


def enclosed(lines: Sequence[shapely.LineString], floors: Sequence[shapely.Polygon] = ()) -> list[shapely.Polygon]:
    """Return the spaces between lines (walls and closed doors, m), within the floors or what the lines enclose."""
    longer = [_longer(line) for line in lines if line.length > 1e-6]
    if not longer:
        return [piece for floor in floors for piece in polygons(floor) if piece.area >= LEAST]
    network = shapely.union_all(longer)
    faces = polygons(shapely.polygonize(shapely.get_parts(shapely.node(network))))
    space = shapely.union_all([*faces, *floors])
    free = space.difference(network.buffer(THIN / 2, cap_style="flat", join_style="mitre"))
    pieces = [piece for piece in polygons(free) if piece.buffer(-0.3).area > 0 and piece.area >= LEAST]
    return [cleaned(piece.buffer(THIN / 2, join_style="mitre")) for piece in pieces]


def closings(
    walls: Sequence[shapely.LineString],
    doors: Sequence[shapely.LineString] = (),
    widest: float = 2.2,
    widest_aside: float = 1.5,
) -> list[shapely.LineString]:
    """Return what closes gaps in walls: straight on from the end of a wall to the next one.

    Gaps are closed below a width (m), a smaller one where the next wall is not met at its end: that may be the other
    side of a corridor. A wall that another or a door goes on from, within 20 degrees, has no gap there.
    """
    segments = np.array([shapely.get_coordinates(line)[[0, -1]].ravel() for line in (*walls, *doors)]).reshape(-1, 4)
    lines = shapely.linestrings(segments.reshape(-1, 2, 2))
    tree = shapely.STRtree(lines)
    found: dict[tuple[tuple[float, ...], ...], shapely.LineString] = {}
    for k in range(len(walls)):
        for start, end in ((segments[k, :2], segments[k, 2:]), (segments[k, 2:], segments[k, :2])):
            length = float(np.hypot(*(end - start)))
            if length < 1e-6:
                continue
            along = (end - start) / length
            near = tree.query(shapely.Point(end).buffer(EXTENSION), predicate="intersects")
            if any(_goes_on(segments[j], end, along) for j in near if j != k):
                continue
            ray = shapely.LineString([end + 1.5 * EXTENSION * along, end + widest * along]).buffer(
                ASIDE, cap_style="flat"
            )
            hits = [ray.intersection(lines[j]) for j in tree.query(ray, predicate="intersects") if j != k]
            if not hits:
                continue
            first = min(shapely.get_coordinates(hits), key=lambda p: float((p - end) @ along))
            gap = float((first - end) @ along)
            aside = np.hypot(*(segments.reshape(-1, 2) - first).T).min() > 2 * EXTENSION
            if 2 * EXTENSION < gap < (widest_aside if aside else widest):
                key = tuple(sorted(tuple(np.round(p, 1)) for p in (end, first)))
                found.setdefault(key, shapely.LineString([end, first]))
    return list(found.values())


def _goes_on(segment: Floats, point: Floats, along: Floats) -> bool:
    """Return whether a segment leads away from a point in about a direction."""
    ends = segment.reshape(2, 2) - point
    far = ends[int(np.argmax(np.hypot(*ends.T)))]
    return bool(far @ along > np.cos(np.radians(20)) * np.hypot(*far))


def cut_at_gaps(free: shapely.Geometry, widest: float = 1.25) -> tuple[list[shapely.Polygon], list[Gap]]:
    """Return the rooms that free space falls into at gaps below a width (m), and the gaps that join two of them.

    Where the space is narrower than `widest`, an opening (erosion, then dilation) leaves nothing; what it takes away
    and what touches two rooms is a gap, unless it is as large as a room itself: then it is one, a narrow corridor.
    """
    half = widest / 2
    cores = polygons(free.buffer(-half, join_style="mitre", mitre_limit=2.0))
    grown = [core.buffer(half + 1e-6, join_style="mitre", mitre_limit=2.0).intersection(free) for core in cores]
    rooms = [room for shape in grown for room in polygons(shape) if room.area >= LEAST]
    rest = polygons(free.difference(shapely.union_all(rooms).buffer(1e-4)))
    slots = []
    for piece in sorted(rest, key=lambda p: -p.area):
        touched = [i for i, room in enumerate(rooms) if room.distance(piece) < 1e-3]
        if piece.area >= 2.0 * LEAST:
            rooms.append(cleaned(piece.buffer(1e-4)))
        elif len(touched) == 1:
            rooms[touched[0]] = cleaned(rooms[touched[0]].union(piece.buffer(2e-4)))
        elif touched:
            slots.append(piece)
    gaps = [gap for slot in slots for gap in _gaps(slot, rooms)]
    for i, first in enumerate(rooms):  # a narrow room borders others without a slot between
        for j in range(i + 1, len(rooms)):
            contact = first.buffer(2e-4).intersection(rooms[j].buffer(2e-4))
            if contact.area > 1e-5:
                gaps += _gaps(contact, rooms, (i, j))
    return rooms, gaps


def _gaps(slot: shapely.Polygon, rooms: list[shapely.Polygon], pair: tuple[int, int] | None = None) -> list[Gap]:
    """Return a gap for every pair of rooms that a slot touches, across the way between them."""
    touched = [pair] if pair else []
    if pair is None:
        near = [i for i, room in enumerate(rooms) if room.distance(slot) < 1e-3]
        touched = [(near[0], other) for other in near[1:]]
    found = []
    for i, j in touched:
        ends = []
        for k in (i, j):
            contact = slot.buffer(2e-3).intersection(rooms[k])
            box = shapely.minimum_rotated_rectangle(contact)
            corners = shapely.get_coordinates(box)
            sides = [(corners[m], corners[m + 1]) for m in range(min(2, len(corners) - 1))]
            if sides:
                ends.append(max(sides, key=lambda s: float(np.hypot(*(s[1] - s[0])))))
        if not ends:
            continue
        width = min(float(np.hypot(*(b - a))) for a, b in ends)
        first = ends[0][1] - ends[0][0]
        along = first / max(float(np.hypot(*first)), 1e-9)
        middle = np.mean([(a + b) / 2 for a, b in ends], axis=0)
        (x0, y0), (x1, y1) = middle - along * width / 2, middle + along * width / 2
        found.append(Gap((i, j), float(x0), float(y0), float(x1), float(y1)))
    return found


def _longer(line: shapely.LineString) -> shapely.LineString:
    """Return a straight line lengthened at both ends."""
    start, end = shapely.get_coordinates(line)[[0, -1]]
    more = (end - start) / max(float(np.hypot(*(end - start))), 1e-9) * EXTENSION
    return shapely.LineString([start - more, end + more])
