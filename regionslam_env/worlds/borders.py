"""Where two rooms lie side by side: stretches of wall that they share, open borders, and doors that a plan forgot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
import shapely

from regionslam_env.worlds.floorplan import DOOR_DEPTH, Opening
from regionslam_env.worlds.passages import PARALLEL
from regionslam_env.worlds.plan import Layout, Portal
from slam.rows import Floats

APART = 0.45
"""Largest distance (m) of two borders that one wall stands for."""

NARROWEST = 0.75
"""Least width (m) of an open border: a robot must fit through."""

SHORTER = 0.1
"""By how much (m) an open border is shortened at both ends as long as it would cut into an outer wall."""

ROOM_FOR_A_DOOR = 1.0
"""Least length (m) of a shared border that a door is assumed in."""


def shared_borders(first: Floats, second: Floats) -> Iterator[tuple[Floats, Floats, float]]:
    """Yield start, end and depth (m) of the stretches where two outlines (k, 2) run side by side, midway between."""
    for start, end in zip(first, np.roll(first, -1, axis=0), strict=True):
        length = float(np.hypot(*(end - start)))
        if length < 1e-6:
            continue
        along = (end - start) / length
        across = np.array([-along[1], along[0]])
        for other_start, other_end in zip(second, np.roll(second, -1, axis=0), strict=True):
            side = other_end - other_start
            if -(along @ side) < np.cos(PARALLEL) * np.hypot(*side) or not side.any():
                continue
            u = np.array([(other_start - start) @ along, (other_end - start) @ along])
            v = np.array([(other_start - start) @ across, (other_end - start) @ across])
            low, high = max(0.0, u.min()), min(length, u.max())
            if high - low < 1e-6:
                continue
            offsets = v[0] + (np.array([low, high]) - u[0]) * (v[1] - v[0]) / (u[1] - u[0])
            if np.abs(offsets).max() > APART:
                continue
            middle = across * (min(0.0, *offsets) + max(0.0, *offsets)) / 2
            yield start + along * low + middle, start + along * high + middle, float(np.abs(offsets).max())


def open_borders(
    layout: Layout, pairs: Iterable[tuple[str, str]], walls: shapely.Geometry | None = None
) -> list[Opening]:
    """Return the openings of rooms that stand open to each other, less what a wall (a shape in metres) covers."""
    openings: list[Opening] = []
    for a, b in pairs:
        rooms = [shapely.Polygon(layout.outlines[name]) for name in (a, b)]
        inside = shapely.union_all(rooms).buffer(APART / 2, join_style="mitre").buffer(-APART / 2, join_style="mitre")
        for start, end, depth in shared_borders(layout.outlines[a], layout.outlines[b]):
            line: shapely.Geometry = shapely.LineString([start, end])
            if walls is not None:
                line = line.difference(walls)
            for piece in (part for part in shapely.get_parts(line) if part.length >= NARROWEST):
                ends = _within(shapely.get_coordinates(piece), DOOR_DEPTH + depth, inside)
                if ends is not None:
                    (x0, y0), (x1, y1) = ends.tolist()
                    number = f"opening {len(openings) + 1}"
                    openings.append(Opening(number, (a, b), x0, y0, x1, y1, DOOR_DEPTH + depth, door=False))
    return openings


def _within(points: Floats, depth: float, inside: shapely.Geometry) -> Floats | None:
    """Return the ends (2, 2) of an opening, shortened until it cuts into nothing but its rooms; None if too short."""
    length = float(np.hypot(*(points[-1] - points[0])))
    along = (points[-1] - points[0]) / max(length, 1e-9)
    across = np.array([-along[1], along[0]]) * depth / 2
    allowed = inside.buffer(0.02)
    for step in range(int(max(length - NARROWEST, -1.0) / (2 * SHORTER)) + 1):
        start, end = points[0] + along * SHORTER * step, points[-1] - along * SHORTER * step
        if allowed.contains(shapely.Polygon([start - across, end - across, end + across, start + across])):
            return np.array([start, end])
    return None


def adjacent(layout: Layout) -> list[tuple[str, str]]:
    """Return the pairs of rooms that may share a border."""
    ids = list(layout.outlines)
    boxes = [shapely.box(*shapely.LinearRing(layout.outlines[i]).bounds).buffer(APART / 2) for i in ids]
    left, right = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    return [(ids[i], ids[j]) for i, j in zip(left, right, strict=True) if i < j]


def missing_doors(layout: Layout, openings: Sequence[Opening], circulation: Sequence[str]) -> list[Portal]:
    """Return doors that connect what the openings leave apart, each in the longest border that allows one.

    A group of rooms without a way to the others gets one door into a room of `circulation` (every room may be one where
    none is); a single room that borders none gets one into any neighbour.
    """
    borders = {}
    for a, b in adjacent(layout):
        stretches = list(shared_borders(layout.outlines[a], layout.outlines[b])) or _around(layout, a, b)
        longest = max(stretches, key=lambda s: float(np.hypot(*(s[1] - s[0]))), default=None)
        if longest is not None and np.hypot(*(longest[1] - longest[0])) >= ROOM_FOR_A_DOOR:
            borders[a, b] = longest
    groups = components(list(layout.outlines), [o.regions for o in openings])
    lengths = {pair: float(np.hypot(*(s[1] - s[0]))) for pair, s in borders.items()}
    halls = set(circulation)
    portals = []
    for alone in (False, True):
        for pair in sorted(borders, key=lambda pair: (-round(lengths[pair], 6), pair)):
            a, b = pair
            if groups[a] == groups[b]:
                continue
            sizes = [list(groups.values()).count(groups[room]) for room in pair]
            if (halls and not halls & set(pair) and not alone) or (alone and min(sizes) > 1):
                continue
            start, end, _ = borders[pair]
            middle = (start + end) / 2
            direction = float(np.arctan2(*(end - start)[::-1]))
            portals.append(Portal(float(middle[0]), float(middle[1]), pair, direction=direction))
            old, new = groups[a], groups[b]
            groups = {room: new if group == old else group for room, group in groups.items()}
    return portals


def _around(layout: Layout, a: str, b: str) -> list[tuple[Floats, Floats, float]]:
    """Return the sides of a room that lies inside another one."""
    shapes = {name: shapely.Polygon(layout.outlines[name]) for name in (a, b)}
    for inner, outer in ((a, b), (b, a)):
        if shapes[outer].contains(shapes[inner]):
            ring = layout.outlines[inner]
            return [(start, end, 0.0) for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True)]
    return []


def components(rooms: Sequence[str], joined: Iterable[Sequence[str]]) -> dict[str, int]:
    """Return for every room the number of its group of rooms that openings join."""
    group: Mapping[str, int] = {room: i for i, room in enumerate(rooms)}
    result = dict(group)
    for regions in joined:
        for a, b in combinations(regions, 2):
            old, new = result[a], result[b]
            if old != new:
                result = {room: new if g == old else g for room, g in result.items()}
    return result
