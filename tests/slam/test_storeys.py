"""Levels, storeys and buildings, on a hand-drawn building of three levels above each other."""

from __future__ import annotations

import json

import pytest

from slam.region import RegionFeature
from slam.region_map import RegionMap
from slam.storeys import is_on, ordinal
from tests.slam.conftest import feature

BUILDING, ANNEX = 1, 2
GROUND, FIRST, SECOND = 3, 4, 5
LOBBY, STAIRS_0, STAIRS_1, STAIRS_2 = 10, 11, 12, 13
HALL_1, HALL_2, KITCHEN, DOOR, LAB, DESK, LAMP = 20, 21, 22, 23, 24, 25, 26


def building() -> RegionMap:
    """Building 2: a lobby below, hallways above each other, and off the upper one a kitchen behind a door and a lab."""
    return RegionMap(
        [
            feature(BUILDING, "building", 10, 5, 22, 12, name="building 2", children={GROUND: 2, FIRST: 2, SECOND: 2}),
            feature(ANNEX, "building", 40, 5, 10, 12),
            feature(GROUND, "floor", 10, 5, 22, 12, children={LOBBY: 2, STAIRS_0: 2}),
            feature(FIRST, "floor", 10, 5, 22, 12, level=1, children={HALL_1: 2, STAIRS_1: 2}),
            feature(SECOND, "floor", 10, 5, 22, 12, level=2, children={HALL_2: 2, KITCHEN: 2, LAB: 2, STAIRS_2: 2}),
            feature(LOBBY, "lobby", 10, 4, 18, 8, neighbours={"l": {STAIRS_0: 2}}),
            feature(STAIRS_0, "stairs", 0, 1, 2, 2, neighbours={"t": {STAIRS_1: 2}}),
            feature(STAIRS_1, "stairs", 0, 1, 2, 2, level=1, neighbours={"r": {HALL_1: 2}}),
            feature(STAIRS_2, "stairs", 0, 1, 2, 2, level=2, neighbours={"r": {HALL_2: 2}}),
            feature(HALL_1, "hallway", 10, 1, 18, 2, level=1),
            feature(HALL_2, "hallway", 10, 1, 18, 2, level=2, neighbours={"t": {DOOR: 2}}),
            feature(KITCHEN, "kitchen", 5, 5, 6, 6, level=2, neighbours={"b": {DOOR: 2}}),
            feature(DOOR, "door", 5, 2, 0.9, 0.2, level=2),
            feature(LAB, "laboratory", 12, 5, 8, 6, level=2, name="B 4.12", children={DESK: 2}),
            feature(DESK, "desk", 12, 5, 3, 2, level=2, children={LAMP: 2}),
            feature(LAMP, "lamp", 12, 5, 0.3, 0.3, level=2),
        ]
    )


@pytest.mark.parametrize(
    ("level", "name"),
    [
        (0, "ground floor"),
        (2, "second floor"),
        (10, "tenth floor"),
        (11, "11th floor"),
        (21, "21st floor"),
        (112, "112th floor"),
        (123, "123rd floor"),
        (-1, "basement"),
        (-2, "second basement"),
    ],
)
def test_ordinals(level: int, name: str) -> None:
    assert ordinal(level) == name


@pytest.mark.parametrize(
    ("point", "level", "sentence"),
    [
        # The sentence of Oberländer et al. 2008, section I.
        (
            (5, 1),
            2,
            "I am in the hallway on the second floor of building 2, next to the door leading to the kitchen.",
        ),
        ((5, 1), 1, "I am in the middle of the hallway on the first floor of building 2."),
        ((5, 5), 0, "I am in the middle of the lobby on the ground floor of building 2."),
        (
            (1.5, 1.5),
            0,
            "I am in the lobby on the ground floor of building 2, next to the stairs leading to the first floor.",
        ),
        ((0, 1), 1, "I am in the stairs on the first floor of building 2, next to the stairs on the ground floor."),
        ((5, 2), 2, "I am in the door between the hallway and the kitchen on the second floor of building 2."),
        ((12, 5), 2, "I am in B 4.12 on the second floor of building 2, at the lamp."),
        ((13, 5), 2, "I am in B 4.12 on the second floor of building 2, at the desk."),
        ((5, 5), 1, "I am on the first floor of building 2, in a place that I do not know yet."),
        ((9, 2.5), 1, "I am on the first floor of building 2, next to the hallway."),
        ((40, 5), 1, "I am on the first floor of building 2, in a place that I do not know yet."),
        ((99, 5), 7, "I am on the seventh floor, in a place that I do not know yet."),
    ],
)
def test_describe(point: tuple[float, float], level: int, sentence: str) -> None:
    assert building().describe(point, level) == sentence


def test_without_storeys_in_the_map_the_level_is_told_where_there_are_several() -> None:
    offices = [feature(1, "office", 0, 0, 4, 4), feature(2, "office", 0, 0, 4, 4, level=1)]
    assert RegionMap(offices).describe((1.9, 1.9)) == "I am in the office on the ground floor."
    assert RegionMap(offices).describe((1.9, 1.9, 0.0), 1) == "I am in the office on the first floor."
    assert RegionMap(offices[:1]).describe((1.9, 1.9)) == "I am in the office."
    house = feature(3, "house", 0, 0, 9, 9)
    assert RegionMap([offices[0], house]).describe((1.9, 1.9)) == "I am in the office of the house."


def test_queries_look_at_one_level_or_at_all() -> None:
    drawn = building()
    assert drawn.levels == (0, 1, 2)
    assert [r.id for r in drawn.regions_of_type("hallway")] == [HALL_1, HALL_2]
    assert [r.id for r in drawn.regions_of_type("hallway", level=2)] == [HALL_2]
    assert [r.id for r in drawn.regions_of_type("building", level=2)] == [BUILDING, ANNEX]
    assert [r.id for r in drawn.regions_at(5, 0.5, level=1)] == [HALL_1, FIRST, BUILDING]
    assert [r.id for r in drawn.regions_at(5, 1)] == [HALL_1, HALL_2, LOBBY, GROUND, FIRST, SECOND, BUILDING]
    innermost = drawn.region_at(12, 5, level=2)
    assert innermost is not None and innermost.id == LAMP
    assert drawn.region_at(12, 5, level=3) == drawn[BUILDING]


def test_furniture_is_nested_in_rooms_and_rooms_in_storeys() -> None:
    drawn = building()
    assert [r.id for r in drawn.ancestors(LAMP)] == [DESK, LAB, SECOND, BUILDING]
    assert [r.id for r in drawn.children(BUILDING)] == [GROUND, FIRST, SECOND]
    assert drawn.parent(LAMP) == drawn[DESK]


def test_names_count_on_one_level() -> None:
    drawn = building()
    assert [drawn.name(i) for i in (BUILDING, ANNEX, SECOND, HALL_1, HALL_2, LAB)] == [
        "building 2",
        "building 2",  # the second of its type
        "second floor",
        "hallway",
        "hallway",
        "B 4.12",
    ]


def test_regions_above_each_other_are_no_neighbours() -> None:
    drawn = building()
    assert not drawn.next_to(HALL_1, KITCHEN)
    assert drawn.next_to(HALL_2, KITCHEN)
    assert drawn.next_to(STAIRS_0, STAIRS_1)  # linked
    assert not drawn.next_to(STAIRS_1, STAIRS_2)
    assert not drawn.at_the_end_of(STAIRS_2, HALL_1)
    assert drawn.at_the_end_of(STAIRS_2, HALL_2)
    assert not drawn.in_the_middle_of(HALL_2, HALL_1) and drawn.in_the_middle_of(HALL_2, HALL_2)
    assert not drawn.in_front_of(LOBBY, DOOR) and not drawn.in_front_of(HALL_1, DOOR)


def test_a_door_is_no_furniture_of_its_storey() -> None:
    storey = feature(1, "floor", 0, 0, 20, 20, children={2: 3.0})
    door = feature(2, "door", 0, 0, 0.9, 0.2)
    drawn = RegionMap([storey, door])
    assert drawn.in_front_of((0, 1), 2) and drawn.in_front_of((0, -1), 2) and not drawn.in_front_of((1, 0), 2)


def test_geojson_there_and_back() -> None:
    drawn = building()
    read = RegionMap.from_geojson(json.loads(json.dumps(drawn.to_geojson())))
    assert read.describe((5, 1), 2) == drawn.describe((5, 1), 2)
    assert [(r.level, r.name) for r in read.hypotheses] == [(r.level, r.name) for r in drawn.hypotheses]


def test_the_graph_knows_levels() -> None:
    pytest.importorskip("networkx")
    assert building().graph().to_networkx().nodes[HALL_2]["level"] == 2


def test_a_building_is_on_every_level() -> None:
    tower, room = RegionFeature(1, "tower", 0.0, 0, 0, 1, 1, 0.0), RegionFeature(2, "room", 0.0, 0, 0, 1, 1, 0.0)
    assert is_on(tower, 5) and is_on(tower, None)
    assert is_on(room, 0) and is_on(room, None) and not is_on(room, 5)
