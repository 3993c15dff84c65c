"""How good is a region map? Mapped regions against true ones: found, doubled, missed, in place, named and linked rightly.

Each mapped region is compared with each true one by overlap: intersection over union if all its edges were seen, over
the smaller area if some are open, for then its size says nothing. Maps drift, and a door is 0.2 m thick: to decide which
is which, a mapped region may be shifted by a tolerance. Pairs above a threshold are matched one to one, best first; of
equal fits the one of the right type counts as better. What is left over is a duplicate if it lies on a place already
taken, and spurious otherwise. The overlap that is reported is that in place, unshifted.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from slam.overlap import covered, iou, overlap_area
from slam.region import RegionFeature
from slam.region_map import RegionMap
from slam.rows import Floats, Row
from slam.se2 import compose

TYPE_BONUS = 0.5
"""How much overlap a right type is worth when a mapped region fits several true ones."""

SHIFT_MALUS = 0.25
"""How much overlap a shift by the whole tolerance costs then."""

T = TypeVar("T")


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


@dataclass(frozen=True)
class MapQuality:
    """Figures of a map; None where one has no meaning (nothing mapped, nothing seen, no links at all).

    Attributes
    ----------
    matches
        One-to-one, best first.
    precision
        Matched share of the mapped regions.
    recall
        Matched share of the true regions that were seen.
    iou
        Mean overlap of the matches.
    type_accuracy
        Share of the matches with the right semantic type.
    link_f1, containment_f1
        Harmonic mean of precision and recall of adjacency links and of (parent, child) pairs, among regions seen.
    duplicates
        Ids of mapped regions on a place that another one stands for.
    spurious
        Ids of mapped regions on no place at all.
    missed
        Ids of true regions seen but not mapped.
    """

    matches: tuple[Match, ...]
    precision: float | None
    recall: float | None
    iou: float | None
    type_accuracy: float | None
    link_f1: float | None
    containment_f1: float | None
    duplicates: tuple[int, ...]
    spurious: tuple[int, ...]
    missed: tuple[str, ...]


def map_quality(
    mapped: Sequence[RegionFeature],
    truth: Sequence[TrueRegion],
    links: Iterable[tuple[str, str]] = (),
    seen: Collection[str] | None = None,
    pose: ArrayLike = (0.0, 0.0, 0.0),
    threshold: float = 0.5,
    tolerance: float = 1.0,
) -> MapQuality:
    """Compare mapped regions with the truth.

    Parameters
    ----------
    mapped
        Credible regions of a map (`RegionMap.regions`).
    truth
        All true regions.
    links
        Pairs of ids of true regions that are adjacent, in any order.
    seen
        Ids of the true regions that a sensor has seen, which the map can be asked for; None: all.
    pose
        truth_T_map: pose of the map's frame in the frame of the truth.
    threshold
        Least overlap of a match, shifted by up to `tolerance` (m).
    tolerance
        How far a mapped region may be off and still stand for a true one, m.

    Raises
    ------
    ValueError
        If `seen` names a region that the truth doesn't have.
    """
    by_id = {region.id: region for region in truth}
    seen = set(by_id) if seen is None else set(seen)
    if not seen <= set(by_id):
        raise ValueError(f"seen names regions that the truth doesn't have: {sorted(seen - set(by_id))[:5]}")
    rows = [moved(feature.row, pose) for feature in mapped]
    pairs = _pairs(mapped, rows, truth, threshold, tolerance)
    matches = _match(pairs, mapped, rows, truth)
    places = {match.mapped: match.true for match in matches}
    found = set(places.values())
    duplicates = _duplicates(pairs, mapped, truth, places)
    places |= duplicates
    types = {feature.id: feature.type for feature in mapped}
    right = [by_id[match.true].type == types[match.mapped] for match in matches]
    true_links = {frozenset(link) for link in links if set(link) <= seen}
    true_parents = {(region.parent, region.id) for region in truth if {region.parent, region.id} <= seen}
    return MapQuality(
        matches=tuple(matches),
        precision=_share(len(matches), len(mapped)),
        recall=_share(len(found & seen), len(seen)),
        iou=float(np.mean([match.overlap for match in matches])) if matches else None,
        type_accuracy=_share(sum(right), len(matches)),
        link_f1=f1(_mapped_links(mapped, places), true_links),
        containment_f1=f1(_mapped_parents(mapped, places), true_parents),
        duplicates=tuple(sorted(duplicates)),
        spurious=tuple(sorted(feature.id for feature in mapped if feature.id not in places)),
        missed=tuple(sorted(seen - found)),
    )


def f1(found: AbstractSet[T], true: AbstractSet[T]) -> float | None:
    """Return the harmonic mean of precision and recall of a set; None if nothing is true and nothing was found."""
    return _share(2 * len(found & true), len(found) + len(true))


def moved(row: Row, pose: ArrayLike) -> Row:
    """Return a row given in the frame of a pose, in the frame that the pose is given in."""
    x, y, phi = compose(pose, (row.x, row.y, row.phi))
    return Row(float(x), float(y), float(phi), row.u, row.b, row.t, row.main)


class _Pair(NamedTuple):
    """A mapped and a true region (indices) with enough overlap: how well they fit, and the intersection over union."""

    fit: float
    mapped: int
    true: int
    iou: float


def _pairs(
    mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion], threshold: float, tolerance: float
) -> list[_Pair]:
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
            pairs.append(_Pair(overlap + over_union / 2 + bonus - malus, int(i), int(j), over_union))
    return sorted(pairs, key=lambda pair: (-pair.fit, pair.mapped, pair.true))


def _match(
    pairs: list[_Pair], mapped: Sequence[RegionFeature], rows: list[Row], truth: Sequence[TrueRegion]
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


def _duplicates(
    pairs: list[_Pair], mapped: Sequence[RegionFeature], truth: Sequence[TrueRegion], places: dict[int, str]
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


def _mapped_links(mapped: Sequence[RegionFeature], places: dict[int, str]) -> set[frozenset[str]]:
    """Return the believed links as pairs of true ids; what lies on no true region keeps an id of its own, and is wrong."""
    ids = {feature.id for feature in mapped}
    believed = {
        frozenset((_place(feature.id, places), _place(other, places)))
        for feature in mapped
        for neighbours in feature.neighbours.values()
        for other, log_odds in neighbours.items()
        if log_odds > 0 and other in ids
    }
    return {pair for pair in believed if len(pair) == 2}


def _mapped_parents(mapped: Sequence[RegionFeature], places: dict[int, str]) -> set[tuple[str | None, str]]:
    """Return the believed (parent, child) pairs by true ids: the forest of `RegionMap`."""
    region_map = RegionMap(mapped)
    pairs = ((region_map.parent(feature), feature) for feature in region_map.regions)
    return {(_place(parent.id, places), _place(child.id, places)) for parent, child in pairs if parent is not None}


def _place(mapped: int, places: dict[int, str]) -> str:
    return places.get(mapped, f"mapped region {mapped}")


def _shifted(row: Row, target: Row, tolerance: float) -> tuple[Row, float]:
    """Move a row by at most `tolerance` so that, along the target's axes, the smaller extent lies within the larger one.

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


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
