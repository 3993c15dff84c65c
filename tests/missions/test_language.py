from __future__ import annotations

import pytest

from regionslam_env.missions.language import MissionError, parse, place_type
from regionslam_env.missions.mission import GoTo, Mission

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


def test_mission_says_itself_in_words_that_parse() -> None:
    mission = parse("find a conference room", TYPES)
    assert str(mission) == "go to the meeting room"
    assert parse(str(mission), TYPES) == mission


def test_known_types_come_before_synonyms() -> None:
    assert place_type("corridor", ("corridor", "hallway")) == "corridor"
    assert place_type("corridor", ("Hallway",)) == "Hallway"


def test_synonym_of_an_unknown_type_is_unknown() -> None:
    with pytest.raises(MissionError, match="lift"):
        place_type("lift", TYPES)


def test_unknown_place_names_the_nearest() -> None:
    with pytest.raises(MissionError, match=r"kitchn.*kitchen"):
        parse("go to the kitchn", TYPES)


@pytest.mark.parametrize("text", ["", "go to", "hallway", "fly over the hallway", "go to the", "???", "go to the 🍕 §"])
def test_what_is_no_mission_is_refused(text: str) -> None:
    with pytest.raises(MissionError, match=r"mission|place"):
        parse(text, TYPES)


def test_a_mission_needs_an_instruction() -> None:
    with pytest.raises(ValueError, match="at least one"):
        Mission(())
