"""The row of three rectangles that fits a room with slanted walls best: its edges move freely, off the corners."""

from __future__ import annotations

import numpy as np
import shapely

from regionslam_env.worlds.annotate import row_along
from slam.rows import MAX_RECTANGLES, Floats, Row

COARSEST = 1 / 8
"""First step of the search, in lengths of the room."""

FINEST = 0.01
"""Last step, m."""

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
    x0, y0, x1, y1 = polygon.bounds
    edges = np.array([*np.linspace(x0, x1, MAX_RECTANGLES + 1), *[y0] * MAX_RECTANGLES, *[y1] * MAX_RECTANGLES])
    iou = _iou(edges, polygon)
    step = max(x1 - x0, y1 - y0) * COARSEST
    while step > FINEST:
        moved = False
        for k in range(len(edges)):
            for way in (step, -step):
                trial = edges.copy()
                trial[k] += way
                score = _iou(trial, polygon)
                if score > iou + 1e-6:
                    edges, iou, moved = trial, score, True
                    break
        if not moved:
            step /= 2
    return [float(edge) for edge in edges], iou


def _iou(edges: Floats, polygon: shapely.Polygon) -> float:
    """Return intersection over union of a row along x and a polygon, 0 for edges that make no row."""
    n = MAX_RECTANGLES
    u, b, t = edges[: n + 1], edges[n + 1 : 2 * n + 1], edges[2 * n + 1 :]
    if (np.diff(u) < THINNEST).any() or (t - b < THINNEST).any():
        return 0.0
    if (np.minimum(t[1:], t[:-1]) - np.maximum(b[1:], b[:-1]) < THINNEST).any():
        return 0.0
    inside = sum(shapely.clip_by_rect(polygon, u[i], b[i], u[i + 1], t[i]).area for i in range(n))
    return float(inside / (polygon.area + np.diff(u) @ (t - b) - inside))


def _simple(polygon: shapely.Polygon) -> shapely.Polygon:
    """Return a polygon of at most `CORNERS` corners."""
    tolerance = float(np.sqrt(polygon.area)) / 500
    simple = polygon
    while shapely.get_num_coordinates(simple) > CORNERS and tolerance < 10:
        simple = shapely.simplify(polygon, tolerance)
        tolerance *= 2
    return simple if isinstance(simple, shapely.Polygon) and simple.area > 0 else polygon
