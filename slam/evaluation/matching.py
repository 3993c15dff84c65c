"""Settles which mapped region stands for which true one.

Regions are compared by overlap: intersection over union if all edges of the mapped one were seen, over the smaller area
if some are open, for then its size says nothing. Maps drift, and a door is 0.2 m thick: to decide which is which, a
mapped region may be shifted by a tolerance. Pairs above a threshold are matched one to one, best first; of equal fits
the one of the right type counts as better. What is left over is a duplicate if it lies on a place already taken, and
spurious otherwise. The overlap that is reported is that in place, unshifted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from slam.overlap import covered, iou, overlap_area
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
    """A mapped and a true region (indices) with enough overlap: how well they fit, and the intersection over union."""

    fit: float
    mapped: int
    true: int
    iou: float


def overlapping_pairs(
    mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion], threshold: float, tolerance: float
) -> list[Pair]:
    """Return all pairs of enough overlap, best first."""
    centres, radii = _circles(rows)
    true_centres, true_radii = _circles([region.row for region in truth])
    distances = np.hypot(*np.moveaxis(centres[:, None] - true_centres, 2, 0))
    pairs = []
    for i, j in np.argwhere(distances < radii[:, None] + true_radii + tolerance):
        shifted, shift = _shifted(rows[i], truth[j].row, tolerance)
        common, areas = overlap_area(shifted, truth[j].row), (shifted.area, truth[j].row.area)
        over_union = common / (sum(areas) - common)
        overlap = common / min(areas) if mapped[i].open_edges else over_union
        if overlap >= threshold:
            bonus = TYPE_BONUS if mapped[i].type == truth[j].type else 0.0
            malus = SHIFT_MALUS * shift / tolerance if shift > 0 else 0.0
            pairs.append(Pair(overlap + over_union / 2 + bonus - malus, int(i), int(j), over_union))
    return sorted(pairs, key=lambda pair: (-pair.fit, pair.mapped, pair.true))


def match_pairs(
    pairs: list[Pair], mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion]
) -> list[Match]:
    """Return the one-to-one matches, best first."""
    used: set[int] = set()
    taken: set[int] = set()
    matches = []
    for pair in pairs:
        if pair.mapped not in used and pair.true not in taken:
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

    A piece of furniture of the wrong type inside an office is no second office.
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


def _shifted(row: Row, target: Row, tolerance: float) -> tuple[Row, float]:
    """Move a row by at most `tolerance` so that, along the target's axes, the smaller extent lies in the larger one.

    Returns the moved row and how far it was moved, m.
    """
    corners = target.to_local(row.rectangles().reshape(-1, 2))
    low, high = corners.min(axis=0), corners.max(axis=0)
    target_low = np.array([target.u[0], target.b.min()])
    target_high = np.array([target.u[-1], target.t.max()])
    at_low, at_high = target_low - low, target_high - high  # the shifts that make either end meet
    shift = np.clip(0.0, np.minimum(at_low, at_high), np.maximum(at_low, at_high))
    length = float(np.hypot(*shift))
    if length > tolerance:
        shift, length = shift * (tolerance / length), tolerance
    dx, dy = target.to_world([shift])[0] - (target.x, target.y)
    return Row(row.x + float(dx), row.y + float(dy), row.phi, row.u, row.b, row.t, row.main), length


def _circles(rows: Sequence[Row]) -> tuple[Floats, Floats]:
    """Return centres (k, 2) and radii (k,) of circles around rows, m."""
    boxes = [row.rectangles().reshape(-1, 2) for row in rows]
    centres = np.array([(box.min(axis=0) + box.max(axis=0)) / 2 for box in boxes]).reshape(-1, 2)
    radii = np.array([np.hypot(*(box - centre).T).max() for box, centre in zip(boxes, centres, strict=True)])
    return centres, radii
