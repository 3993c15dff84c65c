"""Walls as segments: join what lies on one line, cut the openings.

Segments are rows x0, y0, x1, y1 in metres.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from slam.rows import Floats

SHORTEST = 1e-3
"""Pieces of wall below this length (m) are dropped."""


def merge_collinear(segments: ArrayLike, tolerance: float = 1e-6) -> Floats:
    """Join overlapping and touching segments of one straight line, so that shared borders become one wall each.

    Parameters
    ----------
    segments
        Shape (k, 4), m.
    tolerance
        How far (m) a segment may lie from another's line, or its end from the other's end, to count as the same.

    Returns
    -------
    Shape (m, 4): longest pieces, in a deterministic order.
    """
    rest = np.array(segments, dtype=np.float64).reshape(-1, 4)
    lengths = np.hypot(rest[:, 2] - rest[:, 0], rest[:, 3] - rest[:, 1])
    rest = rest[np.argsort(-lengths, kind="stable")]
    rest = rest[np.sort(-lengths, kind="stable") < -SHORTEST]
    merged = []
    while len(rest):
        origin, along = rest[0, :2], rest[0, 2:] - rest[0, :2]
        along = along / np.hypot(*along)
        normal = np.array([-along[1], along[0]])
        ends = rest.reshape(-1, 2, 2) - origin
        on_line = (np.abs(ends @ normal) <= tolerance).all(axis=1)
        intervals = np.sort((ends @ along)[on_line], axis=1)
        for low, high in _unite(intervals, tolerance):
            merged.append(np.concatenate([origin + low * along, origin + high * along]))
        rest = rest[~on_line]
    return np.array(merged).reshape(-1, 4)


def _unite(intervals: Floats, tolerance: float) -> list[tuple[float, float]]:
    """Return the union of intervals (k, 2) as disjoint ones, ascending."""
    united: list[tuple[float, float]] = []
    for low, high in intervals[np.argsort(intervals[:, 0], kind="stable")]:
        if united and low <= united[-1][1] + tolerance:
            united[-1] = (united[-1][0], max(united[-1][1], float(high)))
        else:
            united.append((float(low), float(high)))
    return united


def cut(segments: ArrayLike, opening: tuple[float, float, float, float], depth: float) -> Floats:
    """Remove from every segment what lies inside an opening.

    Parameters
    ----------
    segments
        Shape (k, 4), m.
    opening
        Ends x0, y0, x1, y1 of the opening, m; its width is their distance.
    depth
        Extent of the opening across its own line, m (half on each side).
    """
    walls = np.array(segments, dtype=np.float64).reshape(-1, 4)
    x0, y0, x1, y1 = opening
    width = float(np.hypot(x1 - x0, y1 - y0))
    along = np.array([x1 - x0, y1 - y0]) / width
    frame = np.array([along, [-along[1], along[0]]]).T
    start = (walls[:, :2] - ((x0 + x1) / 2, (y0 + y1) / 2)) @ frame
    step = (walls[:, 2:] - walls[:, :2]) @ frame
    low, high = np.zeros(len(walls)), np.ones(len(walls))
    for axis, half in ((0, width / 2 - 1e-9), (1, depth / 2)):
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (-half - start[:, axis]) / step[:, axis], (half - start[:, axis]) / step[:, axis]
        parallel = np.abs(step[:, axis]) < 1e-12
        outside = parallel & (np.abs(start[:, axis]) >= half)
        low = np.where(parallel, low, np.maximum(low, np.minimum(first, second)))
        high = np.where(outside, -1.0, np.where(parallel, high, np.minimum(high, np.maximum(first, second))))
    pieces = []
    for wall, enter, leave in zip(walls, low, high, strict=True):
        if leave <= enter:
            pieces.append(wall)
            continue
        begin, vector = wall[:2], wall[2:] - wall[:2]
        pieces.append(np.concatenate([begin, begin + enter * vector]))
        pieces.append(np.concatenate([begin + leave * vector, wall[2:]]))
    result = np.array(pieces).reshape(-1, 4)
    lengths = np.hypot(result[:, 2] - result[:, 0], result[:, 3] - result[:, 1])
    return np.asarray(result[lengths > SHORTEST])
