import numpy as np
import pytest

from regionslam_env.control.controller import LocalController
from regionslam_env.control.window import Window
from regionslam_env.wrappers.region_drive import PATIENCE, STANDING_ROOM, RegionDrive
from slam.motion import Odometry
from tests.env.believed import Believed
from tests.env.wrappers.still import TYPES, belief_of, observer

N_RAYS = 72


@pytest.fixture(scope="module")
def controller():
    return LocalController(n_rays=N_RAYS, window=Window(n_rays=N_RAYS))


def suite(at=(0.0, 0.0), door=True):
    """The robot in an office, and a kitchen beside it behind a door at (2, 3)."""
    built = Believed(TYPES, pose=(*at, 0.0)).put(0, 10, "office", u=(-2.0, 2.0), b=(-4.0,), t=(4.0,))
    built.put(1, 11, "kitchen", at=(5.0, 0.0), u=(-2.9, 2.9), b=(-4.0,), t=(4.0,))
    if door:
        built.put(2, 12, "door", at=(2.0, 3.0), u=(-0.1, 0.1), b=(-0.5,), t=(0.5,)).link(0, 2).link(2, 1)
    return built


def seen(built, made, reach=9.0):
    return made.observe(belief_of(built), Odometry(0.0), np.full(N_RAYS, reach), 0.0, 0.0, False)


def begin(controller, built, slot, arrived_after=3):
    made = observer()
    observation = seen(built, made)
    return RegionDrive(controller, observation, made.slot_ids, slot, arrived_after), observation, made


def test_it_heads_for_the_door_that_leads_there(controller):
    drive, observation, _ = begin(controller, suite(), 1)
    assert drive.act(observation)[1] > 0
    straight, observation, _ = begin(controller, suite(door=False), 1)
    assert straight.act(observation)[1] == pytest.approx(0, abs=0.05)


def test_behind_the_door_it_heads_for_the_region(controller):
    drive, _, made = begin(controller, suite(), 1)
    drive.act(seen(suite(at=(2.0, 3.0)), made))
    assert controller.path[-1] == pytest.approx([3.0, -3.0], abs=0.1)


def test_it_has_arrived_after_some_steps_in_the_region(controller):
    drive, _, made = begin(controller, suite(), 1)
    inside = seen(suite(at=(3.5, 3.0)), made)
    outcomes = []
    for _ in range(3):
        drive.act(inside)
        outcomes.append(drive.judge(inside, made.slot_ids))
    assert outcomes == ["", "", "arrived"]


def test_a_region_around_the_robot_means_its_middle(controller):
    drive, _, made = begin(controller, suite(at=(1.5, 3.0)), 0, arrived_after=1)
    beside, middle = seen(suite(at=(1.0, 1.0)), made), seen(suite(at=(0.1, 0.1)), made)
    drive.act(beside)
    assert drive.judge(beside, made.slot_ids) == ""
    assert drive.judge(middle, made.slot_ids) == "arrived"


def test_standing_still_far_away_is_being_blocked(controller):
    drive, observation, made = begin(controller, suite(), 1)
    outcomes = [drive.judge(observation, made.slot_ids) for _ in range(PATIENCE)]
    assert outcomes == [""] * (PATIENCE - 1) + ["blocked"]


def furnished(x, inside=True):
    built = Believed(TYPES, pose=(x, 0.0, 0.0)).put(0, 10, "office", u=(-4.0, 4.0))
    built.put(1, 11, "other", at=(2.0, 0.0), u=(-0.5, 0.5), b=(-1.2 if inside else -0.5,), t=(1.2 if inside else 0.5,))
    return built.link(1, 0, kind=1) if inside else built


@pytest.mark.parametrize("inside", [True, False])
def test_a_thing_is_driven_to_and_not_into(controller, inside):
    drive, observation, made = begin(controller, furnished(0.0, inside), 1)
    drive.act(observation)
    assert controller.path[-1] == pytest.approx([1.5 - STANDING_ROOM, 0.0], abs=0.06)
    beside = seen(furnished(1.0, inside), made)
    assert [drive.judge(beside, made.slot_ids) for _ in range(3)] == ["", "", "arrived"]


def test_standing_still_beside_a_region_that_cannot_be_entered_is_having_arrived(controller):
    drive, _, made = begin(controller, suite(at=(-1.0, 0.0)), 1)
    beside = seen(suite(at=(1.6, 0.0)), made)
    assert [drive.judge(beside, made.slot_ids) for _ in range(PATIENCE + 1)][-1] == "arrived"


def test_the_region_is_kept_when_it_gets_another_slot_or_none(controller):
    drive, _, made = begin(controller, suite(door=False), 1, arrived_after=1)
    moved = seen(suite(door=False).put(1, 11, "kitchen", at=(0.0, 5.0)), made)
    drive.judge(moved, made.slot_ids)
    drive.act(moved)
    assert controller.path[-1, 1] > 3
    gone = seen(suite(door=False).remove(1), made)
    assert drive.judge(gone, made.slot_ids) == ""
    assert drive.act(gone) == pytest.approx(drive.act(moved))
    swapped = made.slot_ids[[1, 0, *range(2, len(made.slot_ids))]]
    other = seen(suite(door=False).put(0, 11, "kitchen", at=(0.0, -5.0)).remove(1), observer())
    drive.judge(other, swapped)
    drive.act(other)
    assert controller.path[-1, 1] < -3
