"""Settles which mapped region stands for which true one.

Regions are compared by overlap: intersection over union if all edges of the mapped one were seen, over the smaller area
if some are open, for then its size says nothing. Maps drift, and a door is 0.2 m thick: to decide which is which, a
mapped region may be shifted by a tolerance. Pairs above a threshold are matched one to one, best first; of equal fits
the one of the right type counts as better. What is left over is a duplicate if it lies on a place already taken, and
spurious otherwise. The overlap that is reported is that in place, unshifted.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.overlap import covered, iou, rows_overlap
from slam.region import RegionFeature
from slam.rows import MAX_RECTANGLES, Floats, Row
from slam.se2 import compose

TYPE_BONUS = 0.5
"""How much overlap a right type is worth when a mapped region fits several true ones."""

SHIFT_MALUS = 0.25
"""How much overlap a shift by the whole tolerance costs then."""


class TrueRegion(Protocol):
    """What is asked of a true region: identity, semantic type, geometry and the id of the region that contains it."""

    @property
    def id(self) -> str:
        """Identity."""

    @property
    def type(self) -> str:
        """Semantic type."""

    @property
    def row(self) -> Row:
        """Geometry in the frame of the truth."""

    @property
    def parent(self) -> str | None:
        """Id of the region that contains this one."""


class Match(NamedTuple):
    """A mapped region, the true one that it stands for, and their overlap in [0, 1] (see the module)."""

    mapped: int
    true: str
    overlap: float


class Pair(NamedTuple):
    """A mapped and a true region (indices) that overlap.

    `fit` ranks pairs; `overlap` decides on a match, `covered` (over the smaller area) on a duplicate; `found` is the
    share of the true region's area that is mapped.
    """

    fit: float
    mapped: int
    true: int
    overlap: float
    covered: float
    iou: float
    found: float


def overlapping_pairs(
    mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion], threshold: float, tolerance: float
) -> list[Pair]:
    """Return all pairs whose overlap over the smaller area reaches the threshold, best first."""
    if not mapped or not truth:
        return []
    shapes, true_shapes = _shapes(tuple(rows)), _shapes(tuple(region.row for region in truth))
    unfinished = [bool(feature.open_edges) for feature in mapped]
    near = np.argwhere(_near(shapes.boxes, true_shapes.boxes, tolerance))
    offsets, lengths, bounds = _shifts(shapes, true_shapes, near, tolerance)
    smaller = np.minimum(shapes.areas[near[:, 0]], true_shapes.areas[near[:, 1]])
    hopeful = bounds >= threshold * smaller
    pairs = []
    for (i, j), (dx, dy), shift in zip(*(x[hopeful].tolist() for x in (near, offsets, lengths)), strict=True):
        area, true_area = float(shapes.areas[i]), float(true_shapes.areas[j])
        same_type = mapped[i].type == truth[j].type
        if not (same_type or unfinished[i]) and min(area, true_area) < threshold * max(area, true_area):
            continue  # closed all around, of another size and another type
        common = _common(rows[i], dx, dy, truth[j].row)
        share, over_union = common / min(area, true_area), common / (area + true_area - common)
        if share >= threshold:
            overlap = share if unfinished[i] else over_union
            malus = SHIFT_MALUS * shift / tolerance if shift > 0 else 0.0
            fit = overlap + over_union / 2 + TYPE_BONUS * same_type - malus
            pairs.append(Pair(fit, i, j, overlap, share, over_union, common / true_area))
    return sorted(pairs, key=lambda pair: (-pair.fit, pair.mapped, pair.true))


def one_to_one(pairs: list[Pair], threshold: float) -> list[Pair]:
    """Return the best pairs, in which no region occurs twice; their overlap reaches the threshold."""
    used: set[int] = set()
    taken: set[int] = set()
    chosen = []
    for pair in pairs:
        if pair.overlap >= threshold and pair.mapped not in used and pair.true not in taken:
            used.add(pair.mapped)
            taken.add(pair.true)
            chosen.append(pair)
    return chosen


def match_pairs(
    pairs: list[Pair], mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion], threshold: float
) -> list[Match]:
    """Return the one-to-one matches, best first."""
    matches = []
    for pair in one_to_one(pairs, threshold):
        measure = covered if mapped[pair.mapped].open_edges else iou
        overlap = measure(rows[pair.mapped], truth[pair.true].row)
        matches.append(Match(mapped[pair.mapped].id, truth[pair.true].id, overlap))
    return matches


def find_duplicates(
    pairs: list[Pair], mapped: Sequence[RegionFeature], truth: Sequence[TrueRegion], places: dict[int, str]
) -> dict[int, str]:
    """Return the unmatched regions that lie on a true region, with its id: of the same type, or of the same extent.

    A piece of a hallway is a second hallway there, but a desk inside an office is no second office.
    """
    duplicates: dict[int, str] = {}
    for pair in pairs:
        feature, region = mapped[pair.mapped], truth[pair.true]
        if feature.id not in places and (feature.type == region.type or pair.iou >= 0.5):
            duplicates.setdefault(feature.id, region.id)
    return duplicates


def moved(row: Row, pose: ArrayLike) -> Row:
    """Return a row given in the frame of a pose, in the frame that the pose is given in."""
    x, y, phi = compose(pose, (row.x, row.y, row.phi))
    return Row(float(x), float(y), float(phi), row.u, row.b, row.t, row.main)


class _Shapes(NamedTuple):
    """Rows in numbers, lengths in m.

    Corners (k, 12, 2), some of them repeated where there are fewer; upright bounding boxes (low, high) (k, 2, 2); the
    rows' frames (x, y, cos, sin) (k, 4) and their extents there (low, high) (k, 2, 2); areas (k,), m².
    """

    corners: Floats
    boxes: Floats
    frames: Floats
    extents: Floats
    areas: Floats


@lru_cache(maxsize=8)
def _shapes(rows: tuple[Row, ...]) -> _Shapes:
    """Return the shapes of rows; those of the truth are asked for again and again."""
    # A row of fewer rectangles ends in rectangles without a width.
    edges = np.array([[*_padded(row.u, MAX_RECTANGLES + 1), *_padded(row.b), *_padded(row.t)] for row in rows])
    u, b, t = np.split(edges, [MAX_RECTANGLES + 1, 2 * MAX_RECTANGLES + 1], axis=1)
    left, right = u[:, :-1], u[:, 1:]
    along = np.concatenate([left, right, right, left], axis=1)
    across = np.concatenate([b, b, t, t], axis=1)
    x, y, phi = np.array([(row.x, row.y, row.phi) for row in rows]).T
    c, s = np.cos(phi)[:, None], np.sin(phi)[:, None]
    corners = np.stack([x[:, None] + c * along - s * across, y[:, None] + s * along + c * across], axis=2)
    low, high = np.stack([u[:, 0], b.min(axis=1)], axis=1), np.stack([u[:, -1], t.max(axis=1)], axis=1)
    return _Shapes(
        corners,
        np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1),
        np.stack([x, y, c[:, 0], s[:, 0]], axis=1),
        np.stack([low, high], axis=1),
        ((right - left) * (t - b)).sum(axis=1),
    )


def _padded(values: Floats, length: int = MAX_RECTANGLES) -> list[float]:
    """Return values as a list, the last one repeated up to a length."""
    found: list[float] = values.tolist()
    return found + found[-1:] * (length - len(found))


def _near(boxes: Floats, others: Floats, distance: float) -> NDArray[np.bool_]:
    """Return which bounding boxes (k, 2, 2) and (l, 2, 2) are less than a distance apart along either axis, (k, l)."""
    low, high = np.moveaxis(boxes, 1, 0)[:, :, None]
    other_low, other_high = np.moveaxis(others, 1, 0)
    return np.asarray(((low < other_high + distance) & (other_low < high + distance)).all(axis=2))


def _shifts(
    shapes: _Shapes, others: _Shapes, pairs: NDArray[np.int64], tolerance: float
) -> tuple[Floats, Floats, Floats]:
    """Return, per pair, how to shift the first shape so that, along the other's axes, the smaller extent is inside.

    Offsets (p, 2), m, in the frame that the shapes are given in; their lengths (p,), at most `tolerance`; and what the
    shapes have in common then at most (p,), m².
    """
    first, second = pairs.T
    frames, low, high = others.frames[second], others.extents[second, 0], others.extents[second, 1]
    c, s = frames[:, 2], frames[:, 3]
    dx, dy = np.moveaxis(shapes.corners[first] - frames[:, None, :2], 2, 0)
    local = np.stack([c[:, None] * dx + s[:, None] * dy, c[:, None] * dy - s[:, None] * dx], axis=2)
    own_low, own_high = local.min(axis=1), local.max(axis=1)
    # The shifts that make either end meet: any in between puts the smaller extent inside the larger one.
    at_low, at_high = low - own_low, high - own_high
    shift = np.maximum(np.minimum(at_low, at_high), 0.0) + np.minimum(np.maximum(at_low, at_high), 0.0)
    lengths = np.hypot(*shift.T)
    shift *= np.minimum(1.0, tolerance / np.maximum(lengths, 1e-12))[:, None]
    common = np.maximum(np.minimum(own_high + shift, high) - np.maximum(own_low + shift, low), 0.0)
    offsets = np.stack([c * shift[:, 0] - s * shift[:, 1], s * shift[:, 0] + c * shift[:, 1]], axis=1)
    return offsets, np.minimum(lengths, tolerance), common.prod(axis=1) + 1e-9


def _common(row: Row, dx: float, dy: float, target: Row) -> float:
    """Return the area (m²) that a row, shifted by (dx, dy), has in common with a target."""
    shifted = (row.x + dx, row.y + dy, row.phi, row.u, row.b, row.t, row.n)
    return float(rows_overlap(*shifted, target.x, target.y, target.phi, target.u, target.b, target.t, target.n))
