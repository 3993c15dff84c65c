"""Maps of a drawn floor: perfect, drifted, doubled, partial, misnamed."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest

from slam.evaluation.map_quality import f1, map_quality
from slam.evaluation.matching import moved
from slam.region import EdgeState, RegionFeature
from slam.rows import Row
from slam.se2 import inverse

OPEN = EdgeState.OPEN


@dataclass(frozen=True, eq=False)
class Truth:
    id: str
    type: str
    row: Row
    parent: str | None = None


def true(id: str, x: float, y: float, w: float, h: float, parent: str | None = None) -> Truth:
    return Truth(id, id.rstrip("0123456789"), Row.from_parameters(x, y, w, h), parent)


FLOOR = [
    true("hallway", 10, 1, 20, 2),
    true("office1", 4, 5, 8, 6),
    true("office2", 12, 5, 8, 6),
    true("door1", 4, 2, 0.9, 0.2),
    true("door2", 12, 2, 0.9, 0.2),
    true("desk1", 1, 5, 1, 2, "office1"),
]
LINKS = [("hallway", "door1"), ("door2", "hallway"), ("office1", "door1"), ("office2", "door2")]


def mapped_floor() -> list[RegionFeature]:
    """The same floor as mapped regions, number 1 to 6."""
    neighbours = [{"t": {4: 1.0, 5: 1.0}}, {"b": {4: 1.0}}, {"b": {5: 1.0}}, {"b": {1: 1.0}}, {}, {}]
    features = []
    for number, (region, links) in enumerate(zip(FLOOR, neighbours, strict=True), start=1):
        p = region.row.parameters()
        shape = {name: p[name] for name in ("x", "y", "w", "h", "phi")}
        children = {6: 2.0} if region.id == "office1" else {}
        features.append(RegionFeature(number, region.type, 2.0, **shape, neighbours=links, children=children))
    return features


def change(features: list[RegionFeature], number: int, **fields: object) -> list[RegionFeature]:
    return [dataclasses.replace(f, **fields) if f.id == number else f for f in features]  # type: ignore[arg-type]


def test_a_perfect_map() -> None:
    quality = map_quality(mapped_floor(), FLOOR, LINKS)
    figures = (quality.precision, quality.recall, quality.type_accuracy, quality.link_f1, quality.containment_f1)
    assert figures == (1, 1, 1, 1, 1)
    assert quality.iou == pytest.approx(1)
    assert {match.mapped: match.true for match in quality.matches} == dict(enumerate([t.id for t in FLOOR], start=1))
    assert quality.duplicates == quality.spurious == quality.missed == ()


def test_an_empty_map_has_no_precision() -> None:
    quality = map_quality([], FLOOR, LINKS)
    assert quality.recall == 0 and quality.link_f1 == 0 and quality.containment_f1 == 0
    assert quality.precision is None and quality.iou is None and quality.type_accuracy is None
    assert quality.missed == tuple(sorted(t.id for t in FLOOR))
    assert map_quality([], []).recall is None and map_quality([], []).link_f1 is None


def test_the_pose_takes_the_map_to_the_truth() -> None:
    pose = (3.0, -1.0, 0.8)
    features = []
    for feature in mapped_floor():
        p = moved(feature.row, inverse(pose)).parameters()
        features.append(dataclasses.replace(feature, x=p["x"], y=p["y"], phi=p["phi"]))
    assert map_quality(features, FLOOR, LINKS, pose=pose).iou == pytest.approx(1)
    assert map_quality(features, FLOOR, LINKS).recall < 0.5


def test_drift_lowers_overlap_but_loses_no_region() -> None:
    features = [dataclasses.replace(f, x=f.x + 0.3, y=f.y + 0.4) for f in mapped_floor()]
    quality = map_quality(features, FLOOR, LINKS)
    assert (quality.precision, quality.recall, quality.link_f1, quality.containment_f1) == (1, 1, 1, 1)
    overlaps = {match.true: match.overlap for match in quality.matches}
    assert overlaps["door1"] == 0  # 0.4 m beside a door of 0.2 m
    common = (20 - 0.3) * (2 - 0.4)
    assert overlaps["hallway"] == pytest.approx(common / (80 - common))
    strict = map_quality(features, FLOOR, LINKS, tolerance=0.0)
    assert set(strict.missed) == {"door1", "door2", "desk1"}


def test_a_region_beyond_the_tolerance_is_spurious() -> None:
    quality = map_quality(change(mapped_floor(), 4, x=6.0), FLOOR)
    assert quality.missed == ("door1",) and quality.spurious == (4,)
    assert quality.precision == quality.recall == pytest.approx(5 / 6)


def test_a_place_mapped_twice_is_a_duplicate_whatever_its_type() -> None:
    copy = dataclasses.replace(mapped_floor()[1], id=9, x=4.5, children={})
    for type_ in ("office", "kitchen"):
        quality = map_quality([*mapped_floor(), dataclasses.replace(copy, type=type_)], FLOOR, LINKS)
        assert quality.duplicates == (9,) and quality.spurious == ()
        assert quality.precision == pytest.approx(6 / 7) and quality.recall == 1
        assert {match.true: match.mapped for match in quality.matches}["office1"] == 2


def test_a_piece_of_a_hallway_beside_the_whole_is_a_duplicate() -> None:
    for state in (OPEN, EdgeState.CLOSED):
        piece = RegionFeature(9, "hallway", 1.0, 17, 1, 6, 2, 0.0, l=state)
        assert map_quality([*mapped_floor(), piece], FLOOR).duplicates == (9,)


def test_furniture_of_no_truth_is_spurious_not_a_second_office() -> None:
    phantom = RegionFeature(9, "desk", 1.0, 12, 5, 1, 1, 0.0, l=OPEN)
    quality = map_quality([*mapped_floor(), phantom], FLOOR)
    assert quality.spurious == (9,) and quality.duplicates == ()


def test_a_part_counts_by_the_overlap_over_the_smaller_area() -> None:
    partly = change(mapped_floor(), 3, x=9.0, w=2.0, r=OPEN)  # a quarter of office2, open to the right
    quality = map_quality(partly, FLOOR)
    assert quality.recall == 1
    assert {match.true: match.overlap for match in quality.matches}["office2"] == pytest.approx(1)
    closed = map_quality(change(mapped_floor(), 3, x=9.0, w=2.0), FLOOR)
    assert closed.missed == ("office2",)  # the same size, claimed to be all of it


def test_a_partly_seen_desk_stands_for_the_desk_and_not_for_its_office() -> None:
    wrong = change(mapped_floor(), 6, type="cupboard", h=1.5, y=4.75, t=OPEN)
    quality = map_quality(wrong, FLOOR)
    assert {match.mapped: match.true for match in quality.matches}[6] == "desk1"
    assert quality.type_accuracy == pytest.approx(5 / 6)


def test_recall_asks_for_what_was_seen() -> None:
    features = [f for f in mapped_floor() if f.id in (1, 2, 4)]
    quality = map_quality(features, FLOOR, LINKS, seen={"hallway", "office1", "door1", "office2"})
    assert quality.recall == pytest.approx(3 / 4) and quality.missed == ("office2",)
    assert quality.precision == 1
    assert quality.link_f1 == 1  # both links between regions seen
    assert quality.containment_f1 is None
    with pytest.raises(ValueError, match="seen names regions that the truth doesn't have: \\['cellar'\\]"):
        map_quality(features, FLOOR, seen={"cellar"})


def test_links_count_in_both_ways() -> None:
    extra = change(mapped_floor(), 2, neighbours={"b": {4: 1.0}, "r": {3: 0.5}})  # office1 - office2 is no passage
    assert map_quality(extra, FLOOR, LINKS).link_f1 == pytest.approx(2 * 4 / (5 + 4))
    doubtful = change(mapped_floor(), 3, neighbours={"b": {5: -1.0}})
    assert map_quality(doubtful, FLOOR, LINKS).link_f1 == pytest.approx(2 * 3 / (3 + 4))


def test_a_link_to_a_spurious_region_is_wrong() -> None:
    ghost = RegionFeature(9, "office", 1.0, 40, 40, 3, 3, 0.0, neighbours={"b": {1: 2.0}})
    assert map_quality([*mapped_floor(), ghost], FLOOR, LINKS).link_f1 == pytest.approx(2 * 4 / (5 + 4))


def test_containment_has_a_direction() -> None:
    turned = change(change(mapped_floor(), 2, children={}), 6, children={2: 2.0})
    assert map_quality(turned, FLOOR).containment_f1 == 0


def test_f1() -> None:
    assert f1({1, 2}, {2, 3}) == 0.5
    assert f1(set(), set()) is None
    assert f1(set(), {1}) == 0


def test_the_nearer_of_two_alike_is_matched() -> None:
    doors = [true("door1", 0, 0, 0.9, 0.2), true("door2", 1.2, 0, 0.9, 0.2)]
    drifted = [RegionFeature(i, "door", 0.0, x + 0.4, 0, 0.9, 0.2, 0.0) for i, x in ((1, 0.0), (2, 1.2))]
    matches = map_quality(drifted, doors).matches
    assert {match.mapped: match.true for match in matches} == {1: "door1", 2: "door2"}


def test_rotated_rows_overlap_exactly() -> None:
    row = Row(1.0, 2.0, 0.6, np.array([0, 3, 5, 6]), np.array([0, -1, 0]), np.array([2, 2, 1]), main=1)
    p = row.parameters()
    shape = {name: p[name] for name in ("x", "y", "w", "h")}
    feature = RegionFeature(1, "lobby", 0.0, **shape, phi=0.6)  # its main rectangle alone: 6 of 13 m²
    (match,) = map_quality([feature], [Truth("a", "lobby", row)], threshold=0.3).matches
    assert match.overlap == pytest.approx(6 / 13)


def test_of_two_type_hypotheses_the_most_credible_counts() -> None:
    rival = dataclasses.replace(mapped_floor()[1], id=9, type="kitchen", children={6: 3.0}, neighbours={"b": {5: 2.0}})
    outdone = map_quality([*mapped_floor(), dataclasses.replace(rival, credible=False)], FLOOR, LINKS)
    assert outdone == map_quality(mapped_floor(), FLOOR, LINKS)
    believed = change(mapped_floor(), 2, credible=False)
    wrong = map_quality([*believed, rival], FLOOR, LINKS)
    assert (wrong.precision, wrong.recall, wrong.duplicates) == (1, 1, ())
    assert wrong.type_accuracy == pytest.approx(5 / 6)
    assert wrong.containment_f1 == 1  # the desk lies in that room, whatever it is called
    assert wrong.link_f1 == pytest.approx(2 * 3 / (4 + 4))  # it leads through door 2 instead of door 1


def test_what_is_more_likely_absent_is_not_counted() -> None:
    ghost = RegionFeature(9, "office", 1.0, 40, 40, 3, 3, 0.0, existence=-0.1)
    assert map_quality([*mapped_floor(), ghost], FLOOR).precision == 1
