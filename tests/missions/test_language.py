from __future__ import annotations

import re

import pytest

from regionslam_env.errors import ConfigError
from regionslam_env.missions.language import MissionError, parse, place_type
from regionslam_env.missions.mission import Explore, GoTo, Instruction, Mission, Return

TYPES = ("hallway", "office", "kitchen", "laboratory", "meeting room", "toilet", "stairs", "cupboard", "other")


@pytest.mark.parametrize(
    ("text", "goal"),
    [
        ("go to the hallway", "hallway"),
        ("Go to the corridor.", "hallway"),
        ("  please   drive to a KITCHEN!", "kitchen"),
        ("go to the meeting room", "meeting room"),
        ("navigate to the nearest conference rooms, please", "meeting room"),
        ("find the laboratories", "laboratory"),
        ("go into the lab", "laboratory"),
        ("take me to the men's room", "toilet"),
        ("go to stairs", "stairs"),
        ("visit an office", "office"),
        ("go to the meeting_room", "meeting room"),
    ],
)
def test_sentence_becomes_mission(text: str, goal: str) -> None:
    assert parse(text, TYPES) == Mission((GoTo(goal),))


@pytest.mark.parametrize(
    ("text", "instructions"),
    [
        ("go to the kitchen, then return", (GoTo("kitchen"), Return())),
        ("explore, then go to the lab and return", (Explore(), GoTo("laboratory"), Return())),
        ("Please explore the whole floor; afterwards go back to the start.", (Explore(), Return())),
        ("first go to the kitchen, then the office, then back", (GoTo("kitchen"), GoTo("office"), Return())),
        ("go to the kitchen, please, and then return, robot", (GoTo("kitchen"), Return())),
        ("look for a kitchen & come back to where you started", (GoTo("kitchen"), Return())),
        ("go back to the kitchen then go home", (GoTo("kitchen"), Return())),
        ("return to the kitchen", (GoTo("kitchen"),)),
        ("map the floor\nvisit the office", (Explore(), GoTo("office"))),
        ("look around. Take me back!", (Explore(), Return())),
    ],
)
def test_sentences_become_instructions(text: str, instructions: tuple[Instruction, ...]) -> None:
    assert parse(text, TYPES).instructions == instructions


def test_the_name_of_a_place_may_hold_words_of_the_grammar() -> None:
    types = ("food and beverage", "home office", "kitchen")
    mission = parse("go to the food and beverage, then to the home office and the kitchen", types)
    assert mission.types == types


def test_mission_says_itself_in_words_that_parse() -> None:
    mission = parse("find a conference room", TYPES)
    assert str(mission) == "go to the meeting room"
    assert parse(str(mission), TYPES) == mission


def test_known_types_come_before_synonyms() -> None:
    assert place_type("corridor", ("corridor", "hallway")) == "corridor"
    assert place_type("corridor", ("Hallway",)) == "Hallway"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("lift", "no 'lift' ('elevator') here: expected one of 'hallway', 'kitchen'"),
        ("lifts", "no 'lifts' ('elevator') here"),
        ("elevator", "no 'elevator' here: expected one of 'hallway', 'kitchen'"),
    ],
)
def test_a_known_type_that_is_not_there_is_not_called_unknown(name: str, message: str) -> None:
    with pytest.raises(MissionError, match=re.escape(message)):
        place_type(name, ("kitchen", "hallway"))


def test_unknown_place_names_the_nearest() -> None:
    with pytest.raises(MissionError, match=r"kitchn.*kitchen"):
        parse("go to the kitchn", TYPES)


@pytest.mark.parametrize("text", ["", "go to", "hallway", "fly over the hallway", "go to the", "???", "go to the 🍕 §"])
def test_what_is_no_mission_is_refused(text: str) -> None:
    with pytest.raises(MissionError, match=r"mission|place"):
        parse(text, TYPES)


@pytest.mark.parametrize("instructions", [(), "hallway", [GoTo("kitchen")], ("return",)])
def test_a_mission_is_a_tuple_of_instructions(instructions: object) -> None:
    with pytest.raises(ConfigError, match="expected a"):
        Mission(instructions)


def test_it_says_which_instruction_is_due() -> None:
    mission = Mission((GoTo("kitchen"), Return()))
    assert mission.now(0.0) == "go to the kitchen (1 of 2)" and mission.now(0.5) == "return to the start (2 of 2)"
    assert mission.now(1.0) == Mission((Return(),)).now(0.0) == ""
