"""Queries on a hand-drawn map."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from slam.region import RegionFeature
from slam.region_map import RegionMap, UnknownRegionError

HALL, KITCHEN, OFFICE_1, OFFICE_2 = 10, 20, 31, 32
DOOR_K, DOOR_1, DOOR_2 = 41, 42, 43
WEST_DESK, EAST_DESK, TABLE = 51, 52, 53
STORAGE, GHOST = 60, 70


def square(id: int, x: float = 0.0, size: float = 2.0, type: str = "office", **fields: object) -> RegionFeature:
    return RegionFeature(id, type, 1.0, x, 0.0, size, size, 0.0, **fields)  # type: ignore[arg-type]


def ids(features: tuple[RegionFeature, ...]) -> list[int]:
    return [feature.id for feature in features]


def test_regions_are_the_credible_ones_by_id(drawn: RegionMap) -> None:
    assert ids(drawn.regions) == [10, 20, 31, 32, 41, 42, 43, 51, 52, 53]
    assert ids(drawn.hypotheses) == [10, 20, 31, 32, 41, 42, 43, 51, 52, 53, 60, 70]
    assert len(drawn) == 10
    assert [region.id for region in drawn] == ids(drawn.regions)
    assert drawn.types == ("desk", "door", "hallway", "kitchen", "office", "table")


def test_regions_of_type(drawn: RegionMap) -> None:
    assert ids(drawn.regions_of_type("office")) == [OFFICE_1, OFFICE_2]
    assert drawn.regions_of_type("storage") == ()
    assert drawn.regions_of_type("swimming pool") == ()


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((10, 1), HALL),
        ((5, 4), KITCHEN),
        ((5, 6), TABLE),
        ((8.4, 5.7), WEST_DESK),
        ((5, 1.95), DOOR_K),  # a door is smaller than the hallway that it overlaps
        ((5, 2.05), DOOR_K),
        ((5, -5), None),  # a region that is more likely absent
        ((30, 30), None),
    ],
)
def test_region_at_is_the_innermost(drawn: RegionMap, point: tuple[float, float], expected: int | None) -> None:
    region = drawn.region_at(*point)
    assert (None if region is None else region.id) == expected


def test_containment_beats_size() -> None:
    outer, inner = square(1, size=2.0), square(2, size=4.0)
    region_map = RegionMap([square(1, size=2.0, children={2: 1.0}), inner])
    assert ids(region_map.regions_at(0, 0)) == [2, 1]
    assert ids(RegionMap([outer, inner]).regions_at(0, 0)) == [1, 2]


def test_neighbours_are_linked_in_either_direction_surest_first(drawn: RegionMap) -> None:
    assert ids(drawn.neighbours(HALL)) == [DOOR_1, DOOR_K, DOOR_2]
    assert ids(drawn.neighbours(DOOR_K)) == [KITCHEN, HALL]  # 2.5 by the kitchen's own belief; no rival hypothesis
    assert ids(drawn.neighbours(OFFICE_1)) == [DOOR_1]
    assert drawn.neighbours(TABLE) == ()


def test_neighbours_take_features_as_well_as_ids(drawn: RegionMap) -> None:
    assert drawn.neighbours(drawn[HALL]) == drawn.neighbours(HALL) == drawn.neighbours(np.int64(HALL))


def test_parent_and_children(drawn: RegionMap) -> None:
    parent = drawn.parent(WEST_DESK)
    assert parent is not None and parent.id == OFFICE_1
    assert drawn.parent(OFFICE_1) is None
    assert drawn.parent(KITCHEN) is None  # believed less likely than not
    assert ids(drawn.children(OFFICE_1)) == [WEST_DESK, EAST_DESK]
    assert drawn.children(HALL) == ()


def test_parents_form_a_forest() -> None:
    """Of a circle of containments the least sure one goes; a child has one parent."""
    region_map = RegionMap(
        [
            square(1, children={2: 3.0, 4: 1.0}),
            square(2, children={3: 2.0, 4: 2.0}),
            square(3, children={1: 1.0}),
            square(4),
        ]
    )
    assert region_map.parent(1) is None
    assert ids(region_map.ancestors(3)) == [2, 1]
    assert ids(region_map.ancestors(4)) == [2, 1]


def test_unknown_regions_are_refused_with_near_ids(drawn: RegionMap) -> None:
    with pytest.raises(UnknownRegionError, match=r"no region 511 in a map of 12; nearest ids: .*51"):
        drawn.neighbours(511)
    assert 51 in drawn and drawn[51] in drawn and 511 not in drawn


def test_ids_are_unique() -> None:
    with pytest.raises(ValueError, match=r"\[7\] come more than once"):
        RegionMap([square(7), square(7), square(8)])


def test_an_empty_map_answers_everything() -> None:
    empty = RegionMap()
    assert empty.regions == () and empty.region_at(0, 0) is None and empty.graph().nodes == ()
    assert empty.to_geojson()["features"] == []


def test_names_count_regions_of_a_type_by_id(drawn: RegionMap) -> None:
    assert drawn.name(KITCHEN) == "kitchen"
    assert drawn.name(OFFICE_1) == "office 1"
    assert drawn.name(OFFICE_2) == "office 2"
    assert drawn.name(STORAGE) == "storage"


def test_graph_holds_links_once_and_containments(drawn: RegionMap) -> None:
    graph = drawn.graph()
    assert graph.nodes == (10, 20, 31, 32, 41, 42, 43, 51, 52, 53)
    edges = {(edge.source, edge.target, edge.kind): edge.probability for edge in graph.edges}
    assert set(edges) == {
        (HALL, DOOR_K, "adjacent"),
        (HALL, DOOR_1, "adjacent"),
        (HALL, DOOR_2, "adjacent"),
        (KITCHEN, DOOR_K, "adjacent"),
        (OFFICE_1, DOOR_1, "adjacent"),
        (KITCHEN, TABLE, "contains"),
        (OFFICE_1, WEST_DESK, "contains"),
        (OFFICE_1, EAST_DESK, "contains"),
    }
    assert len(edges) == len(graph.edges)
    assert edges[KITCHEN, DOOR_K, "adjacent"] == pytest.approx(1 / (1 + np.exp(-2.5)))
    assert edges[OFFICE_1, EAST_DESK, "contains"] == pytest.approx(1 / (1 + np.exp(-1.0)))


def test_graph_as_networkx(drawn: RegionMap) -> None:
    pytest.importorskip("networkx")
    graph = drawn.graph().to_networkx()
    assert graph.nodes[KITCHEN]["type"] == "kitchen"
    assert (graph.nodes[HALL]["x"], graph.nodes[HALL]["y"]) == pytest.approx((10, 1))
    assert graph.has_edge(HALL, DOOR_K) and graph.has_edge(DOOR_K, HALL)
    assert graph.has_edge(KITCHEN, TABLE) and not graph.has_edge(TABLE, KITCHEN)


def test_graph_without_networkx_says_what_to_do(drawn: RegionMap, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "networkx", None)
    with pytest.raises(ImportError, match="pip install networkx"):
        drawn.graph().to_networkx()


def test_relations_take_ids_points_and_poses(drawn: RegionMap) -> None:
    assert drawn.next_to(HALL, DOOR_K)
    assert drawn.in_front_of((9.5, 5), WEST_DESK)
    assert drawn.in_front_of(np.array([9.5, 5, 1.0]), drawn[WEST_DESK])
    assert not drawn.in_front_of((7.5, 5), WEST_DESK)  # behind the wall, in the kitchen
    assert drawn.in_the_middle_of(KITCHEN, KITCHEN)
    assert drawn.at_the_end_of((19.5, 1), HALL)
    with pytest.raises(ValueError, match=r"got shape \(4,\)"):
        drawn.in_the_middle_of((1, 2, 3, 4), KITCHEN)


def test_describe_reads_a_pose(drawn: RegionMap) -> None:
    assert drawn.describe((5.0, 1.0, 0.3)) == "I am in the hallway, next to the door leading to the kitchen."
