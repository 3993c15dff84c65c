"""How good is a region map? Mapped regions against true ones: found, doubled, missed, in place, named, linked.

Which mapped region stands for which true one is settled in `slam.evaluation.matching`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from slam.evaluation.matching import Match, TrueRegion, find_duplicates, match_pairs, moved, overlapping_pairs
from slam.region import RegionFeature
from slam.region_map import RegionMap

T = TypeVar("T")


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
        Regions of a map. Of several type hypotheses for one place the most credible one counts (`RegionMap.regions`).
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
    mapped = RegionMap(mapped).regions
    rows = [moved(feature.row, pose) for feature in mapped]
    pairs = overlapping_pairs(mapped, rows, truth, threshold, tolerance)
    matches = match_pairs(pairs, mapped, rows, truth, threshold)
    places = {match.mapped: match.true for match in matches}
    found = set(places.values())
    duplicates = find_duplicates(pairs, mapped, truth, places)
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


def _mapped_links(mapped: Sequence[RegionFeature], places: dict[int, str]) -> set[frozenset[str]]:
    """Return the believed links as pairs of true ids; what lies on no true region keeps its own id, and is wrong."""
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


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
