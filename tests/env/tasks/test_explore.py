import dataclasses
import math

import numpy as np
import pytest

from regionslam_env.errors import ConfigError
from regionslam_env.tasks.explore import ExploreTask
from regionslam_env.tasks.survey import shares
from regionslam_env.tasks.task import Moment, TaskSettings
from regionslam_env.worlds.geodesic import Geodesic
from slam import Odometry, RegionMeasurement, RegionSLAM, Scan
from slam.region import EdgeState
from tests.floors import furnished_room, two_rooms

START = (3.0, 2.0, 0.0)
OFFICE = RegionMeasurement("office", x=0.0, y=0.0, w=6.0, h=4.0)
KITCHEN = RegionMeasurement("kitchen", x=6.0, y=0.0, w=6.0, h=4.0, r=EdgeState.OPEN)
DOOR = RegionMeasurement("door", x=3.0, y=0.0, w=1.0, h=0.2, phi=math.pi / 2)


def mapping(*regions, steps=6):
    """Return a belief after some scans of these regions, seen from the middle of the office."""
    slam = RegionSLAM(seed=0)
    for _ in range(steps):
        belief = slam.step(Odometry(0.0), Scan(list(regions)), pose=(0.0, 0.0, 0.0))
    return belief


NOTHING, ONE, ALL = mapping(), mapping(OFFICE), mapping(OFFICE, DOOR, KITCHEN)


def build(world=None, declares=False, **arguments):
    world = world or two_rooms()
    return ExploreTask(world, Geodesic(world, 0.2), TaskSettings(world.types, declares=declares), **arguments)


def begun(**settings):
    task = build(**settings)
    task.draw(np.random.default_rng(0), start=START)
    return task


def moment(belief, declared=False, last=False, collided=False):
    return Moment(np.array(START), collided, declared, lambda: belief, START, last)


def test_what_can_be_entered_is_wanted_and_furniture_is_not():
    assert build().survey.wanted == {"office", "door", "kitchen"}
    assert build(furnished_room()).survey.wanted == {"office"}


def test_a_room_that_no_door_leads_to_is_not_wanted():
    world = two_rooms()
    closed = dataclasses.replace(world, walls=np.vstack([world.walls, (6.0, 1.5, 6.0, 2.5)]), doors=(), links=())
    task = build(closed)
    assert len(task.survey.wanted & {"office", "kitchen"}) == 1
    lonely = (9.0, 2.0, 0.0) if "office" in task.survey.wanted else START
    with pytest.raises(ConfigError, match="no way from"):
        task.draw(np.random.default_rng(0), start=lonely)


def test_shares_are_of_the_whole_floor():
    world, wanted = two_rooms(), build().survey.wanted
    assert shares(NOTHING, START, world, wanted) == (0, 0)
    assert shares(ONE, START, world, wanted) == pytest.approx((1 / 3, 1 / 3))
    assert shares(ALL, START, world, wanted) == pytest.approx((1.0, (1 + 1 + 3 / 4) / 3))
    assert shares(ALL, (103.0, 2.0, 0.0), world, wanted) == (0, 0)  # all of it in the wrong place


@pytest.mark.parametrize(("depth", "found"), [(1.5, False), (2.5, False), (3.5, True), (6.0, True)])
def test_a_piece_of_a_room_seen_through_its_door_is_not_the_room(depth, found):
    piece = RegionMeasurement("kitchen", x=3.0 + depth / 2, y=0.0, w=depth, h=4.0, r=EdgeState.OPEN)
    world, wanted = two_rooms(), build().survey.wanted
    explored, _ = shares(mapping(OFFICE, piece), START, world, wanted)
    assert explored == pytest.approx((2 if found else 1) / 3)


def test_what_the_map_gains_is_paid_once_and_losing_it_costs_as_much():
    task = begun()
    assert task.verdict(moment(NOTHING)).terms["recall"] == 0
    verdicts = [task.verdict(moment(ONE)) for _ in range(30)]
    assert sum(v.terms["recall"] for v in verdicts) == pytest.approx(20 / 3)
    assert sum(v.terms["edges"] for v in verdicts) == pytest.approx(10 / 3)
    lost = [task.verdict(moment(NOTHING)) for _ in range(20)]
    assert sum(v.terms["recall"] for v in lost) == pytest.approx(-20 / 3)
    assert not any(v.over for v in (*verdicts, *lost))


def test_a_map_that_was_kept_is_not_paid_again():
    task = begun(map_share=1.0)
    assert task.verdict(moment(ONE)).terms["recall"] == 0
    assert task.figures["explored"] == pytest.approx(1 / 3)


@pytest.mark.parametrize(("share", "enough"), [(1 / 3, True), (0.34, False)])
def test_enough_is_enough(share, enough):
    task = begun(map_share=share)
    verdict = task.verdict(moment(ONE))
    assert verdict.success is verdict.over is enough
    assert verdict.terms["success"] == (10 if enough else 0)


@pytest.mark.parametrize(("belief", "right"), [(ALL, True), (ONE, False)])
def test_a_declaration_is_judged_on_the_map_of_its_own_step(belief, right):
    task = begun(declares=True)
    assert not task.verdict(moment(NOTHING)).over
    verdict = task.verdict(moment(belief, declared=True))
    assert verdict.over and verdict.success is right
    assert (verdict.terms["false_arrival"] < 0) is not right


def test_enough_without_a_declaration_goes_on():
    task = begun(declares=True)
    assert not any(task.verdict(moment(ALL)).over for _ in range(22))


def test_the_figures_are_those_of_the_last_step():
    task = begun()
    task.verdict(moment(NOTHING))
    task.verdict(moment(ONE))
    assert task.figures == {"explored": 0.0, "closed_edges": 0.0}
    task.verdict(moment(ONE, last=True))
    assert task.figures == pytest.approx({"explored": 1 / 3, "closed_edges": 1 / 3})


def test_starts_are_free_and_a_goal_is_refused():
    task = build()
    starts = {task.draw(np.random.default_rng(seed)).start for seed in range(10)}
    assert len(starts) == 10 and all(task.geodesic.free(x, y) for x, y, _ in starts)
    mission = task.draw(np.random.default_rng(0))
    assert (str(mission.mission), mission.shortest, task.remaining) == ("map the floor", None, None)
    with pytest.raises(ConfigError, match="expected none: this task is always the same"):
        ExploreTask.read("kitchen", ("kitchen",))
