"""The row of three rectangles that fits a room with slanted walls best: its edges move freely, off the corners."""

from __future__ import annotations

import numpy as np
import shapely

from regionslam_env.worlds.annotate import row_along
from slam.rows import MAX_RECTANGLES, Row

COARSEST = 1 / 8
"""First step of the search, in lengths of the room."""

FINEST = 0.02
"""Last step, m."""

ENOUGH = 0.98
"""IoU at which the search ends."""

THINNEST = 0.2
"""Least extent of a rectangle, m."""

CORNERS = 60
"""Corners of a polygon above this number are smoothed away."""


def refine(polygon: shapely.Polygon, heading: float) -> tuple[Row, float]:
    """Return the row along a heading (rad), or across it, that coordinate search finds, and its IoU.

    The search starts at three rectangles of equal length over the whole room and moves one edge at a time, by halving
    steps, as long as the intersection over union grows.
    """
    best: tuple[float, Row] | None = None
    for turn in (0.0, np.pi / 2):
        c, s = np.cos(heading + turn), np.sin(heading + turn)
        turned = _simple(shapely.transform(polygon, lambda p, c=c, s=s: p @ np.array([[c, -s], [s, c]])))
        edges, iou = _search(turned)
        if best is None or iou > best[0] + 1e-9:
            n = MAX_RECTANGLES
            best = (iou, row_along(heading + turn, edges[: n + 1], edges[n + 1 : 2 * n + 1], edges[2 * n + 1 :]))
    assert best is not None
    return best[1], best[0]


def _search(polygon: shapely.Polygon) -> tuple[list[float], float]:
    """Return u[0..3], b[0..2], t[0..2] of the row along x that fits a polygon, and its IoU."""
    n = MAX_RECTANGLES
    x0, y0, x1, y1 = polygon.bounds
    edges = [*np.linspace(x0, x1, n + 1).tolist(), *[y0] * n, *[y1] * n]
    inside = [_inside(polygon, edges, i) for i in range(n)]
    iou = _iou(polygon, edges, inside)
    step = max(x1 - x0, y1 - y0) * COARSEST
    while step > FINEST and iou < ENOUGH:
        moved = False
        for k in range(len(edges)):
            touched = [i for i in (k - 1, k) if 0 <= i < n] if k <= n else [(k - n - 1) % n]
            for way in (step, -step):
                trial = edges.copy()
                trial[k] += way
                if not _is_row(trial):
                    continue
                parts = [_inside(polygon, trial, i) if i in touched else inside[i] for i in range(n)]
                score = _iou(polygon, trial, parts)
                if score > iou + 1e-6:
                    edges, inside, iou, moved = trial, parts, score, True
                    break
        if not moved:
            step /= 2
    return edges, iou


def _is_row(edges: list[float]) -> bool:
    """Return whether edges u, b, t make a row of rectangles that touch."""
    n = MAX_RECTANGLES
    u, b, t = edges[: n + 1], edges[n + 1 : 2 * n + 1], edges[2 * n + 1 :]
    return all(u[i + 1] - u[i] >= THINNEST and t[i] - b[i] >= THINNEST for i in range(n)) and all(
        min(t[i], t[i + 1]) - max(b[i], b[i + 1]) >= THINNEST for i in range(n - 1)
    )


def _inside(polygon: shapely.Polygon, edges: list[float], i: int) -> float:
    """Return the area of a polygon inside rectangle i, m²."""
    n = MAX_RECTANGLES
    box = edges[i], edges[n + 1 + i], edges[i + 1], edges[2 * n + 1 + i]
    try:
        return float(shapely.clip_by_rect(polygon, *box).area)
    except shapely.errors.GEOSException:  # the fast way fails where the polygon only just touches the rectangle
        return float(polygon.intersection(shapely.box(*box)).area)


def _iou(polygon: shapely.Polygon, edges: list[float], inside: list[float]) -> float:
    """Return intersection over union of a row along x and a polygon, of which parts (m²) are inside its rectangles."""
    n = MAX_RECTANGLES
    area = sum((edges[i + 1] - edges[i]) * (edges[2 * n + 1 + i] - edges[n + 1 + i]) for i in range(n))
    common = sum(inside)
    return common / (polygon.area + area - common)


def _simple(polygon: shapely.Polygon) -> shapely.Polygon:
    """Return a polygon of at most `CORNERS` corners."""
    tolerance = float(np.sqrt(polygon.area)) / 500
    simple = polygon
    while shapely.get_num_coordinates(simple) > CORNERS and tolerance < 10:
        simple = shapely.simplify(polygon, tolerance)
        tolerance *= 2
    return simple if isinstance(simple, shapely.Polygon) and simple.area > 0 else polygon
