import math
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from regionslam_env.envs import GoToEnv
from regionslam_env.missions.mission import Explore, GoTo, Mission, Return
from regionslam_env.wrappers import FlatObservation, TextObservation
from regionslam_env.wrappers.situation import Situation, bearing, certainty, direction, obstacles, seen
from regionslam_env.wrappers.text_observation import CHARACTERS, fit, spell
from slam.measurement import RegionMeasurement, Scan
from slam.motion import Odometry
from tests.env.believed import Believed
from tests.env.wrappers.still import TYPES, belief_of, observer
from tests.floors import two_rooms

MISSION = Mission((GoTo("kitchen"),))


def lines(built, scan=None, completed=0.0, declared=False, mission=MISSION):
    made, belief = observer(), belief_of(built)
    odometry, ranges = Odometry(0.05, 0.0, math.radians(2)), np.full(72, 4.0)
    observation = made.observe(belief, odometry, ranges, 0.25, completed, declared)
    return list(Situation(mission, observation, belief, scan or Scan(), made.slot_ids, TYPES, 1000).lines())


def test_it_tells_mission_progress_pose_and_motion():
    told = lines(Believed(TYPES, pose=(2.0, -1.0, math.pi / 2)))
    assert told[0] == "Mission: go to the kitchen."
    assert told[1] == "Progress: 250 of 1000 steps."
    assert lines(Believed(TYPES), declared=True)[1] == "Progress: 250 of 1000 steps, arrival declared."
    assert "2.0 m ahead and 1.0 m right from the start" in told[4] and "turned 90 degrees left" in told[4]
    assert told[5] == "Motion: 0.5 m/s forward, turning left at 20 degrees per second."
    assert told[-1] == "Known regions: none yet."


def test_of_several_instructions_it_tells_which_one_is_due():
    mission = Mission((GoTo("kitchen"), Explore(), Return()))
    told = lines(Believed(TYPES), completed=1 / 3, mission=mission)
    assert told[0] == "Mission: go to the kitchen, then map the floor, then return to the start."
    assert told[1] == "Now: map the floor (2 of 3)."
    assert "Now:" not in "\n".join(lines(Believed(TYPES), completed=1.0, mission=mission))


def test_regions_come_with_slots_bearings_and_links_the_goal_first():
    built = Believed(TYPES, pose=(0.0, 0.0, math.pi / 2))
    built.put(0, 10, "office").put(1, 11, "kitchen", at=(5.0, 0.0), p=0.8).put(2, 12, "door", at=(1.0, 0.0), visited=1)
    built.link(0, 2, p=0.9).link(2, 1, p=0.8)
    told = lines(built)[-3:]
    assert [line[:4] for line in told] == ["[1] ", "[0] ", "[2] "]
    kitchen, office, door = told
    assert "kitchen: 4.0 m away, centre 5.0 m, 90 degrees right, 2.0 x 2.0 m, not been there" in kitchen
    assert "exists with 80 %, of this type with 80 %, leads to [2] door (80 %)" in kitchen
    assert "I am in it (100 %)" in office and "leads to [2] door (90 %)" in office
    assert "been there" in door and "leads to [0] office (90 %), leads to [1] kitchen (80 %)" in door


def test_a_size_is_that_of_all_rectangles():
    built = Believed(TYPES).put(0, 10, "hallway", u=(-1.0, 2.0, 9.0), b=(-1.0, -1.0), t=(1.0, 4.0))
    assert "10.0 x 5.0 m" in lines(built)[-1]


def test_a_containment_is_told_from_both_sides():
    built = Believed(TYPES).put(0, 10, "office").put(1, 11, "other", u=(-0.2, 0.2)).link(1, 0, kind=1)
    told = " ".join(lines(built))
    assert "contains [1] other (90 %)" in told and "inside [0] office (90 %)" in told


def test_open_edges_are_told_as_directions_of_the_robot():
    built = Believed(TYPES, pose=(0.0, 0.0, math.pi / 2)).put(0, 10, "office")
    assert "may go on" not in lines(built)[-1]
    built.region(0).closed[:] = 0
    assert "may go on ahead and behind and left and right" in lines(built)[-1]


def test_what_was_seen_is_told_nearest_first():
    scan = Scan([RegionMeasurement("office", 3.0, 0.0, 4.0, 4.0), RegionMeasurement("door", 0.0, -1.0, 0.9, 0.2)])
    assert seen(scan) == "door 1.0 m, 90 degrees right; office 3.0 m, 0 degrees"
    assert seen(Scan()) == "nothing"


def test_the_certainty_is_that_of_the_worst_direction_or_being_lost():
    belief = belief_of(Believed(TYPES))
    assert certainty(belief) == "I know my position to within 0.20 m and my heading to within 2 degrees."
    belief.lost = True
    assert "lost" in certainty(belief)


def test_obstacles_are_the_nearest_in_every_eighth():
    ranges = np.full(72, 9.0)
    ranges[36 + 18] = 0.5  # straight left
    told = obstacles(ranges)
    assert "ahead 9.0 m, ahead left 9.0 m, left 0.5 m, behind left 9.0 m" in told
    assert obstacles(np.array([1.0, 2.0])) == "ahead 2.0 m, behind 1.0 m"


@pytest.mark.parametrize(
    ("degrees", "name", "words"),
    [
        (0, "ahead", "0 degrees"),
        (100, "left", "100 degrees left"),
        (-40, "ahead right", "40 degrees right"),
        (540, "behind", "180 degrees"),
    ],
)
def test_angles_have_a_side_and_a_direction(degrees, name, words):
    assert direction(math.radians(degrees)) == name
    assert bearing(math.radians(degrees)).startswith(words)


def test_a_long_text_ends_with_a_whole_line_and_a_note():
    rows = [f"line {k:03d}" for k in range(100)]
    text = fit(rows, 300)
    *kept, note = text.split("\n")
    assert len(text) <= 300 and kept == rows[: len(kept)] and note == f"({100 - len(kept)} more lines left out)"
    assert fit(rows[:10], 300) == "\n".join(rows[:10])
    exactly = "\n".join(rows[:10])
    assert fit(rows[:10], len(exactly)) == exactly
    assert len(fit(["x" * 1000, "y"], 300)) <= 300


@pytest.mark.parametrize(
    ("word", "spelt"), [("Küche", "Küche"), ("Ku\u0308che", "Küche"), ("①", "1"), ("厨房", "??"), ("a\tb", "a b")]
)
def test_every_text_is_spelt_with_the_characters_of_the_space(word, spelt):
    assert spell(word) == spelt and set(spell(word)) <= set(CHARACTERS)


def test_what_does_not_fit_is_refused():
    env = GoToEnv(world=two_rooms())
    with pytest.raises(TypeError, match="expected a SemanticNavigationEnv"):
        TextObservation(gymnasium.make("CartPole-v1"))
    with pytest.raises(TypeError, match="with its own observations"):
        TextObservation(FlatObservation(env))
    with pytest.raises(ValueError, match="max_length is 10, expected a whole number of at least 200"):
        TextObservation(env, max_length=10)


@pytest.mark.compiled
def test_gymnasium_accepts_it_and_a_drive_is_told_within_the_space():
    wrapper = TextObservation(GoToEnv(world=two_rooms()), max_length=900)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version.*")
        warnings.filterwarnings("ignore", message=".*not having a spec.*")
        check_env(wrapper)
    wrapper.reset(seed=1, options={"goal": "kitchen", "start": (2.0, 2.0, 0.0)})
    for _ in range(20):
        text, *_ = wrapper.step(np.float32([0.5, 0.0]))
        assert text in wrapper.observation_space
    assert "Place: I am in the middle of the office." in text and "\n[1] kitchen: " in text
    assert "more lines left out" in text
