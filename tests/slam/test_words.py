"""What the robot says about where it is."""

from __future__ import annotations

import pytest

from slam.naming import called
from slam.region import EdgeState, RegionFeature, Subrectangle
from slam.region_map import RegionMap


@pytest.mark.parametrize(
    ("point", "sentence"),
    [
        ((5, 1), "I am in the hallway, next to the door leading to the kitchen."),
        ((5, 0.2), "I am in the hallway, in front of the door leading to the kitchen."),
        ((11, 1), "I am in the hallway, next to the door leading to office 1."),
        ((17, 1), "I am in the hallway, next to a door."),  # nobody knows yet where it leads
        ((8, 1), "I am in the middle of the hallway."),
        ((19.8, 1), "I am at the end of the hallway."),
        ((14, 0.3), "I am in the hallway."),
        ((5, 2), "I am in the door between the kitchen and the hallway."),
        ((11, 3), "I am in office 1, next to the door leading to the hallway."),
        ((10.0, 5), "I am in office 1, next to a desk."),
        ((5, 5), "I am in the kitchen, next to the table."),
        ((5, 6), "I am in the kitchen, at the table."),
        ((17, 5), "I am in the middle of office 2."),
        ((15, 7.5), "I am in office 2."),
        ((20.9, 1), "I am next to the hallway."),
        ((30, 30), "I am in a place that I do not know yet."),
    ],
)
def test_describe(drawn: RegionMap, point: tuple[float, float], sentence: str) -> None:
    assert drawn.describe(point) == sentence


def test_only_long_regions_have_an_end_in_words() -> None:
    office = RegionFeature(1, "office", 0.0, 0, 0, 6, 3, 0.0)
    assert RegionMap([office]).at_the_end_of((2.8, 0), 1)
    assert RegionMap([office]).describe((2.8, 0)) == "I am in the office."
    ell = RegionFeature(1, "hallway", 0.0, 0, 0, 10, 2, 0.0, r=EdgeState.SUBRECT, right=Subrectangle(2, 10, -4))
    assert RegionMap([ell]).describe((6, -8.5)) == "I am at the end of the hallway."
    assert RegionMap([ell]).describe((6.5, 0.5)) == "I am in the hallway."


def test_names_with_articles(drawn: RegionMap) -> None:
    assert called(drawn, drawn[20]) == "the kitchen"
    assert called(drawn, drawn[32]) == "office 2"


def test_an_empty_map_has_words_too() -> None:
    assert RegionMap().describe((0, 0, 0)) == "I am in a place that I do not know yet."


def test_rooms_without_doors_are_next_to_each_other() -> None:
    kitchen = RegionFeature(1, "kitchen", 0.0, 0, 0, 6, 6, 0.0, neighbours={"r": {2: 2.0}})
    lobby = RegionFeature(2, "lobby", 0.0, 6, 0, 6, 6, 0.0)
    assert RegionMap([kitchen, lobby]).describe((2.5, 0)) == "I am in the kitchen, next to the lobby."


@pytest.mark.parametrize(
    ("probabilities", "sentence"),
    [
        ({31: 0.7, 32: 0.25}, "I am probably in office 1 (70 %) or office 2 (25 %)."),
        ({31: 0.4, 32: 0.35, 10: 0.2}, "I am perhaps in office 1 (40 %), office 2 (35 %) or the hallway (20 %)."),
        ({31: 0.9, 32: 0.1}, "I am in office 1, next to a desk."),
        ({31: 0.7, 32: 0.05, 51: 0.5, 41: 0.4}, "I am in office 1, next to a desk."),  # a desk is no other room
        ({}, "I am in office 1, next to a desk."),
    ],
)
def test_doubt_is_told(drawn: RegionMap, probabilities: dict[int, float], sentence: str) -> None:
    assert drawn.describe((10.0, 5), probabilities=probabilities) == sentence


def test_in_a_door_there_is_no_doubt(drawn: RegionMap) -> None:
    there = drawn.describe((5, 2), probabilities={10: 0.5, 20: 0.5})
    assert there == "I am in the door between the kitchen and the hallway."
