"""Any polygon to the row of at most three rectangles that fits it best (Oberländer et al. 2008, II-B and Fig. 2).

The polygon is cut into cells by lines through its corners, along and across a direction of its sides. Every run of
cells is a candidate for a rectangle, and the best row of one, two or three is found by exhaustive search.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from regionslam_env.errors import WorldError
from slam.rows import MAX_RECTANGLES, Floats, Row

MAX_LINES = 20
"""Most lines of cells along an axis."""

MAX_CORNERS = 200
"""Corners of a polygon above this number are smoothed away."""

GAIN = 0.01
"""IoU that a further rectangle must bring to be worth it."""

SAME_DIRECTION = np.radians(1.5)
"""Directions nearer than this count as one."""


def annotate(
    polygon: shapely.Polygon, directions: Iterable[float] | None = None, most: int = MAX_RECTANGLES
) -> tuple[Row, float]:
    """Return the best row of at most three rectangles for a polygon, and its IoU.

    Parameters
    ----------
    polygon
        Shape in metres; holes count as not covered.
    directions
        Headings (rad) that the row's frame may take, each also turned by 90 degrees; default: its longest sides'.
    most
        Largest number of rectangles.

    Raises
    ------
    WorldError
        For an empty or broken polygon.
    """
    if polygon.is_empty or not polygon.is_valid or not np.isfinite(polygon.bounds).all() or polygon.area <= 0:
        reason = "empty" if polygon.is_empty else shapely.is_valid_reason(polygon)
        raise WorldError(f"polygon: expected a simple polygon with an area, got {reason}")
    polygon = _simpler(polygon)
    best: tuple[float, float, Row] | None = None
    for heading in side_directions(polygon) if directions is None else directions:
        for count, iou, row in _rows_along(polygon, heading, most):
            score = iou - GAIN * count
            if best is None or score > best[0] + 1e-9:
                best = (score, iou, row)
    assert best is not None
    return best[2], best[1]


def _simpler(polygon: shapely.Polygon) -> shapely.Polygon:
    """Return a polygon of at most `MAX_CORNERS` corners, as near to the given one as they allow."""
    tolerance = float(np.sqrt(polygon.area)) / 1000
    simpler = polygon
    while shapely.get_num_coordinates(simpler) > MAX_CORNERS:
        simpler = shapely.simplify(polygon, tolerance)
        tolerance *= 2
    return simpler


def side_directions(polygon: shapely.Polygon, most: int = 4) -> list[float]:
    """Return the headings of a polygon's sides modulo 90 degrees, longest total first, rad in (-45, 45] degrees."""
    corners = shapely.get_coordinates(polygon.exterior)
    sides = np.diff(corners, axis=0)
    lengths = np.hypot(sides[:, 0], sides[:, 1])
    sides, lengths = sides[lengths > 1e-9], lengths[lengths > 1e-9]
    headings = _quarter(np.arctan2(sides[:, 1], sides[:, 0]))
    found: list[float] = []
    while len(headings) and len(found) < most:
        near = np.abs(_quarter(headings[:, None] - headings[None, :])) <= SAME_DIRECTION
        pick = int(np.argmax(np.round(near @ lengths, 9)))
        members = near[pick]
        offset = np.average(_quarter(headings[members] - headings[pick]), weights=lengths[members])
        heading = float(_quarter(np.array([headings[pick] + offset]))[0])
        found.append(0.0 if abs(heading) < 1e-9 else heading)
        headings, lengths = headings[~members], lengths[~members]
    return found


def _quarter(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return angles modulo 90 degrees, in (-45, 45] degrees, rad."""
    return np.asarray(np.pi / 4 - np.mod(np.pi / 4 - angles, np.pi / 2))


def _rows_along(polygon: shapely.Polygon, heading: float, most: int) -> Iterable[tuple[int, float, Row]]:
    """Yield (number of rectangles, IoU, row) for either axis of a frame and every number of rectangles."""
    c, s = np.cos(heading), np.sin(heading)
    turned = shapely.transform(polygon, lambda p: p @ np.array([[c, -s], [s, c]]))
    us, vs = (_lines(turned, axis) for axis in (0, 1))
    low = np.array(np.meshgrid(us[:-1], vs[:-1], indexing="ij"))
    high = np.array(np.meshgrid(us[1:], vs[1:], indexing="ij"))
    cells = shapely.intersection(shapely.box(low[0], low[1], high[0], high[1]), turned)
    covered = shapely.area(cells)
    longer = 0 if us[-1] - us[0] >= vs[-1] - vs[0] else 1
    for axis in (longer, 1 - longer):
        along, across = (us, vs) if axis == 0 else (vs[:], -us[::-1])
        matrix = covered if axis == 0 else covered.T[:, ::-1]
        for count in range(1, most + 1):
            pieces = _best_row(along, across, matrix, float(polygon.area), count)
            if pieces is not None:
                row = _row(pieces, along, across, heading + axis * np.pi / 2)
                yield count, _iou(row, polygon), row


def _lines(polygon: shapely.Polygon, axis: int) -> Floats:
    """Return the lines of cells along an axis: through corners, close ones joined, wide gaps divided."""
    rings = [polygon.exterior, *polygon.interiors]
    corners = [shapely.get_coordinates(ring)[:-1] for ring in rings]
    values = np.concatenate([c[:, axis] for c in corners])
    beside = [np.abs(np.roll(c[:, 1 - axis], k) - c[:, 1 - axis]) for c in corners for k in (1, -1)]
    weights = np.add(*(np.concatenate(beside[k::2]) for k in (0, 1)))
    order = np.argsort(values, kind="stable")
    values, weights = values[order], weights[order]
    extent = values[-1] - values[0]
    closeness = extent / 500
    while True:
        groups = np.split(np.arange(len(values)), np.nonzero(np.diff(values) > closeness)[0] + 1)
        if len(groups) <= MAX_LINES:
            break
        closeness *= 1.5
    lines = [float(values[g[np.argmax(weights[g])]]) for g in groups]
    lines[0], lines[-1] = (lines[0], lines[-1]) if len(lines) > 1 else (float(values[0]), float(values[-1]))
    while len(lines) < MAX_LINES // 2:
        gaps = np.diff(lines)
        k = int(np.argmax(np.round(gaps, 9)))
        if gaps[k] < extent / 6:
            break
        lines.insert(k + 1, (lines[k] + lines[k + 1]) / 2)
    return np.array(lines)


def _best_row(
    along: Floats, across: Floats, covered: Floats, area: float, count: int
) -> list[tuple[int, int, int, int]] | None:
    """Return the row with the largest IoU as (first line, last line, bottom line, top line) of each rectangle.

    With intersection I and row area R, IoU = I / (area + R - I) is maximised by Dinkelbach's method: repeatedly the row
    with the largest I - iou (area + R - I), which is a sum over its rectangles.
    """
    n = len(along) - 1
    if count > n:
        return None
    heights = np.diff(across)
    columns = np.concatenate([np.zeros((1, len(heights))), np.cumsum(covered, axis=0)])
    first, last = (np.array(k) for k in zip(*combinations(range(n + 1), 2), strict=True))
    overlap = columns[last] - columns[first]
    size = (along[last] - along[first])[:, None] * heights
    place = np.zeros((n + 1, n + 1), dtype=np.int64)
    place[first, last] = np.arange(len(first))
    splits = np.array(list(combinations(range(n + 1), count + 1)))
    parts = place[splits[:, :-1], splits[:, 1:]]
    iou, chosen = 0.0, None
    for _ in range(8):
        score, bottom, top = _best_runs((1 + iou) * overlap - iou * size)
        total = np.where(_touching(bottom[parts], top[parts]), score[parts].sum(axis=1), -np.inf)
        pick = parts[int(np.argmax(total))]
        inside = sum(overlap[p, bottom[p] : top[p]].sum() for p in pick)
        whole = sum(size[p, bottom[p] : top[p]].sum() for p in pick)
        better = inside / (area + whole - inside)
        if not np.isfinite(total.max()) or (chosen is not None and better <= iou + 1e-9):
            break
        iou = better
        chosen = [(int(first[p]), int(last[p]), int(bottom[p]), int(top[p])) for p in pick]
    return chosen


def _best_runs(values: Floats) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Return for every line of values the largest sum of a run, its begin and its end (Kadane's algorithm)."""
    best = np.full(len(values), -np.inf)
    begin, end = np.zeros(len(values), np.int64), np.zeros(len(values), np.int64)
    running, start = np.zeros(len(values)), np.zeros(len(values), np.int64)
    for k in range(values.shape[1]):
        fresh = running <= 0
        start = np.where(fresh, k, start)
        running = np.where(fresh, 0.0, running) + values[:, k]
        better = running > best + 1e-12
        best, begin, end = np.where(better, running, best), np.where(better, start, begin), np.where(better, k + 1, end)
    return best, begin, end


def _touching(bottom: NDArray[np.int64], top: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which rows have all neighbouring rectangles overlap across the row; runs are (k, rectangles)."""
    overlap = np.minimum(top[:, 1:], top[:, :-1]) > np.maximum(bottom[:, 1:], bottom[:, :-1])
    return np.asarray(overlap.all(axis=1))


def _row(pieces: list[tuple[int, int, int, int]], along: Floats, across: Floats, heading: float) -> Row:
    """Return the row of some pieces."""
    u = [along[pieces[0][0]], *(along[p[1]] for p in pieces)]
    return row_along(heading, u, [across[p[2]] for p in pieces], [across[p[3]] for p in pieces])


def row_along(heading: float, u: Sequence[float], b: Sequence[float], t: Sequence[float]) -> Row:
    """Return the row of edges u[0..n], bottoms and tops in a frame turned by a heading (rad) about the origin.

    The main rectangle is the middle one of three, else the largest.
    """
    areas = np.diff(u) * (np.array(t) - np.array(b))
    main = 1 if len(b) == MAX_RECTANGLES else int(np.argmax(np.round(areas, 9)))
    phi = heading if heading <= np.pi / 2 else heading - np.pi
    if phi != heading:
        u, b, t, main = (
            [-x for x in reversed(u)],
            [-x for x in reversed(t)],
            [-x for x in reversed(b)],
            len(b) - 1 - main,
        )
    return Row.from_parameters(**Row(0.0, 0.0, phi, np.array(u), np.array(b), np.array(t), main).parameters())


def _iou(row: Row, polygon: shapely.Polygon) -> float:
    """Return intersection over union of a row and a polygon."""
    union = shapely.union_all(shapely.polygons(row.rectangles()))
    inside = union.intersection(polygon).area
    return float(inside / (union.area + polygon.area - inside))
