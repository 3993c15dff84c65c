"""Where a door fits between two rooms whose borders run side by side, though perhaps not on one line."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from regionslam_env.worlds.floorplan import DOOR_DEPTH, Opening
from slam.rows import Floats

PARALLEL = np.radians(20.0)
"""Largest angle (rad) between the two borders."""

FARTHEST = 1.2
"""Largest distance (m) of the two borders."""

MARGINS = {0.25: 0.0, 0.1: 0.4, 0.02: 0.8}
"""Distances of the opening from the ends of the borders (m), and what each costs against metres of shift."""

AWAY = 4.0
"""Cost of a metre between the two borders."""

SHIFT = 0.2
"""Distance (m) of the places tried along a border where the nearest one meets a third room."""

CROSSED = 4.0
"""Cost of an opening that meets the border of a third room."""


def fit_opening(
    name: str,
    regions: tuple[str, str],
    outlines: tuple[Floats, Floats],
    point: tuple[float, float],
    others: Sequence[shapely.LinearRing] = (),
    width: float = 0.9,
    least: float = 0.75,
    reach: float = 3.0,
) -> Opening | None:
    """Return the opening nearest to a point through two borders, or None where there is none.

    Parameters
    ----------
    name
        Id of the opening.
    regions, outlines
        Ids and closed outlines (k, 2) of the two rooms, m.
    point
        Where the door is said to be, m.
    others
        Outlines of the other rooms; an opening that cuts into one of them is the last choice.
    width, least
        Width of the opening, and what is accepted where that does not fit, m.
    reach
        Farthest from the point, m.
    """
    for span in (width, (width + least) / 2, least):
        found = [
            (cost + extra, centre, along, depth)
            for margin, extra in MARGINS.items()
            for cost, centre, along, depth in _candidates(outlines, np.array(point), span, margin, reach, others)
        ]
        if found:
            _, centre, along, depth = min(found, key=lambda candidate: round(candidate[0], 6))
            (x0, y0), (x1, y1) = centre - along * span / 2, centre + along * span / 2
            return Opening(name, regions, float(x0), float(y0), float(x1), float(y1), depth)
    return None


def straight_opening(
    name: str,
    regions: tuple[str, str],
    outlines: tuple[Floats, Floats],
    point: tuple[float, float],
    direction: float,
    others: Sequence[shapely.LinearRing] = (),
    width: float = 0.9,
) -> Opening | None:
    """Return an opening at a point, along a direction (rad), as deep as the borders within its width are apart.

    A room around the other one has no border there. None where one of the two outlines does not come within `FARTHEST`
    of the point for another reason, or that of a third room does.
    """
    along, middle = np.array([np.cos(direction), np.sin(direction)]), np.array(point)
    across = np.array([-along[1], along[0]])
    half, reach = along * (width / 2 - 0.01), across * FARTHEST
    box = shapely.Polygon([middle - half - reach, middle + half - reach, middle + half + reach, middle - half + reach])
    inside = [shapely.LinearRing(outline).intersection(box) for outline in outlines]
    around = [shapely.Polygon(outline).contains(shapely.Point(point)) for outline in outlines]
    if any(line.is_empty and not contains for line, contains in zip(inside, around, strict=True)):
        return None
    spans = [np.sort((shapely.get_coordinates(line) - middle) @ across) for line in inside if not line.is_empty]
    if not spans:
        return None
    nearest = [span[np.argsort(np.abs(span))[:2]] for span in spans]
    low, high = min(map(np.min, nearest)), max(map(np.max, nearest))
    centre, depth = middle + across * (low + high) / 2, DOOR_DEPTH + float(high - low)
    if _crossed(others, centre, along, width, depth):
        return None
    (x0, y0), (x1, y1) = centre - half, centre + half
    return Opening(name, regions, float(x0), float(y0), float(x1), float(y1), depth)


def jambs(opening: Opening, inset: float = 0.0) -> Floats:
    """Return the walls on both sides of an opening that is deeper than a wall, shape (0 or 2, 4), m."""
    if opening.depth <= DOOR_DEPTH + 1e-6:
        return np.empty((0, 4))
    half = (opening.depth - DOOR_DEPTH) / 2 + inset
    start, end = np.array([opening.x0, opening.y0]), np.array([opening.x1, opening.y1])
    along = (end - start) / np.hypot(*(end - start))
    across = np.array([-along[1], along[0]]) * half
    return np.array([[*(start - across), *(start + across)], [*(end - across), *(end + across)]])


def _candidates(
    outlines: tuple[Floats, Floats],
    point: Floats,
    width: float,
    margin: float,
    reach: float,
    others: Sequence[shapely.LinearRing],
) -> list[tuple[float, Floats, Floats, float]]:
    """Return (cost, centre, direction, depth) of places where an opening fits, the best ones of each pair of sides."""
    found = []
    for start, end in _sides(outlines[0]):
        length = float(np.hypot(*(end - start)))
        if length < width:
            continue
        along = (end - start) / length
        for other_start, other_end in _sides(outlines[1]):
            side = other_end - other_start
            if -(along @ side) < np.cos(PARALLEL) * np.hypot(*side):
                continue  # both outlines turn counter-clockwise, so facing sides run in opposite directions
            u = np.sort([(other_start - start) @ along, (other_end - start) @ along])
            low, high = max(0.0, u[0]) + margin + width / 2, min(length, u[1]) - margin - width / 2
            if low > high + 1e-9:
                continue
            nearest = min(max(float((point - start) @ along), low), high)
            for place in (nearest, *np.arange(low, high, SHIFT)):
                centre, depth, between = _gap(start, along, other_start, side, place, width)
                shift = float(np.hypot(*(centre - point)))
                if abs(between) > FARTHEST or shift > reach:
                    continue
                crossed = _crossed(others, centre, along, width, depth)
                found.append((shift + AWAY * abs(between) + CROSSED * crossed, centre, along, depth))
                if crossed == 0 and place == nearest:
                    break
    return found


def _gap(
    start: Floats, along: Floats, other_start: Floats, side: Floats, place: float, width: float
) -> tuple[Floats, float, float]:
    """Return the centre and depth (m) of an opening at a place along a side, and how far the other side is there, m."""
    across = np.array([-along[1], along[0]])
    slope = (side @ across) / (side @ along)
    offsets = [
        float((other_start - start) @ across + slope * (place + f * width / 2 - (other_start - start) @ along))
        for f in (-1.0, 0.0, 1.0)
    ]
    near, far = min(0.0, *offsets), max(0.0, *offsets)
    return start + along * place + across * (near + far) / 2, DOOR_DEPTH + far - near, offsets[1]


def _crossed(others: Sequence[shapely.LinearRing], centre: Floats, along: Floats, width: float, depth: float) -> int:
    """Return how many outlines have a point inside the box of an opening."""
    across = np.array([-along[1], along[0]]) * (depth / 2 - 0.01)
    half = along * (width / 2 - 0.01)
    corners = [centre + f * half + g * across for f, g in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return int(np.sum(shapely.intersects(shapely.Polygon(corners), list(others)))) if others else 0


def _sides(outline: Floats) -> list[tuple[Floats, Floats]]:
    return list(zip(outline, np.roll(outline, -1, axis=0), strict=True))
