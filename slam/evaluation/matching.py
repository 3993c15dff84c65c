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
from slam.rows import Floats, Row
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

    `fit` ranks pairs; `overlap` decides on a match, `covered` (over the smaller area) on a duplicate.
    """

    fit: float
    mapped: int
    true: int
    overlap: float
    covered: float
    iou: float


def overlapping_pairs(
    mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion], threshold: float, tolerance: float
) -> list[Pair]:
    """Return all pairs whose overlap over the smaller area reaches the threshold, best first."""
    shapes, true_shapes = [_shape(row) for row in rows], [_shape(region.row) for region in truth]
    pairs = []
    for i, j in np.argwhere(_near(shapes, true_shapes, tolerance)):
        (corners, _, area), true_area = shapes[i], true_shapes[j].area
        same_type = mapped[i].type == truth[j].type
        if not (same_type or mapped[i].open_edges) and min(area, true_area) < threshold * max(area, true_area):
            continue  # closed all around, of another size and another type
        common, shift = _shifted_overlap(rows[i], corners, truth[j].row, tolerance)
        share, over_union = common / min(area, true_area), common / (area + true_area - common)
        if share >= threshold:
            overlap = share if mapped[i].open_edges else over_union
            malus = SHIFT_MALUS * shift / tolerance if shift > 0 else 0.0
            fit = overlap + over_union / 2 + TYPE_BONUS * same_type - malus
            pairs.append(Pair(fit, int(i), int(j), overlap, share, over_union))
    return sorted(pairs, key=lambda pair: (-pair.fit, pair.mapped, pair.true))


def match_pairs(
    pairs: list[Pair], mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion], threshold: float
) -> list[Match]:
    """Return the one-to-one matches, best first."""
    used: set[int] = set()
    taken: set[int] = set()
    matches = []
    for pair in pairs:
        if pair.overlap >= threshold and pair.mapped not in used and pair.true not in taken:
            used.add(pair.mapped)
            taken.add(pair.true)
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


class _Shape(NamedTuple):
    """Corners (4 n, 2) of a row, its upright bounding box (low, high) (2, 2), and its area, m and m²."""

    corners: Floats
    box: Floats
    area: float


@lru_cache(maxsize=1024)
def _shape(row: Row) -> _Shape:
    """Return the shape of a row; the true ones are asked for at the end of every episode."""
    corners = row.rectangles().reshape(-1, 2)
    return _Shape(corners, np.array([corners.min(axis=0), corners.max(axis=0)]), row.area)


def _near(shapes: list[_Shape], others: list[_Shape], distance: float) -> NDArray[np.bool_]:
    """Return which bounding boxes are less than a distance apart along either axis, shape (k, l)."""
    if not shapes or not others:
        return np.zeros((len(shapes), len(others)), bool)
    low, high = np.moveaxis(np.array([shape.box for shape in shapes]), 1, 0)[:, :, None]
    other_low, other_high = np.moveaxis(np.array([shape.box for shape in others]), 1, 0)
    return np.asarray(((low < other_high + distance) & (other_low < high + distance)).all(axis=2))


def _shifted_overlap(row: Row, corners: Floats, target: Row, tolerance: float) -> tuple[float, float]:
    """Shift a row so that, along the target's axes, the smaller extent lies in the larger one; by `tolerance` at most.

    Returns the area (m²) that it has then in common with the target, and how far it was shifted (m).
    """
    local = target.to_local(corners)
    # The shifts that make either end meet: any in between puts the smaller extent inside the larger one.
    at_low = (target.u[0], target.b.min()) - local.min(axis=0)
    at_high = (target.u[-1], target.t.max()) - local.max(axis=0)
    shift = np.maximum(np.minimum(at_low, at_high), 0.0) + np.minimum(np.maximum(at_low, at_high), 0.0)
    length = float(np.hypot(*shift))
    if length > tolerance:
        shift, length = shift * (tolerance / length), tolerance
    dx, dy = target.to_world(shift) - (target.x, target.y)
    x, y = row.x + dx, row.y + dy
    common = rows_overlap(
        x,
        y,
        row.phi,
        row.u,
        row.b,
        row.t,
        row.n,
        target.x,
        target.y,
        target.phi,
        target.u,
        target.b,
        target.t,
        target.n,
    )
    return float(common), length
