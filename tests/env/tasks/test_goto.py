import math

import numpy as np
import pytest

from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.errors import ConfigError
from regionslam_env.missions.mission import GoTo, Mission
from regionslam_env.tasks.goto import GoToTask
from regionslam_env.tasks.task import TaskSettings
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import Door, Link, Region, World
from slam.rows import Row

ROBOT = 0.2


def two_rooms(open_door=True, right="kitchen"):
    """An office (4 x 4 m) left and another room right of x = 0, with a door of 1 m about the origin."""
    gap = [(0.0, -2.0, 0.0, -0.5), (0.0, 0.5, 0.0, 2.0)] if open_door else [(0.0, -2.0, 0.0, 2.0)]
    outer = [(-4.0, -2.0, 4.0, -2.0), (4.0, -2.0, 4.0, 2.0), (4.0, 2.0, -4.0, 2.0), (-4.0, 2.0, -4.0, -2.0)]
    regions = (
        Region("a", "office", "a", Row.from_parameters(-2.0, 0.0, 4.0, 4.0)),
        Region("b", right, "b", Row.from_parameters(2.0, 0.0, 4.0, 4.0)),
        Region("d", "door", "d", Row.from_parameters(0.0, 0.0, 0.2, 1.0)),
        Region("t", "desk", "t", Row.from_parameters(-3.5, 1.5, 1.0, 1.0), parent="a"),
    )
    doors = (Door("d", 0.0, -0.5, 0.0, 0.5, ("a", "b")),)
    links = (Link("a", "d", "r", "l"), Link("d", "b", "r", "l"))
    return World("two rooms", regions, np.array(gap + outer), doors, links=links)


@pytest.fixture(scope="module")
def world():
    return two_rooms()


@pytest.fixture(scope="module")
def geodesic(world):
    return Geodesic(world, ROBOT)


@pytest.fixture
def make(world, geodesic):
    def build(declares=False, step=0.1, types=SEMANTIC_TYPES, **arguments):
        return GoToTask(world, geodesic, TaskSettings(types, step, declares), **arguments)

    return build


def to(goal):
    return Mission((GoTo(goal),))


def rng(seed=0):
    return np.random.default_rng(seed)


def test_only_rooms_are_drawn_as_goals(make):
    task = make()
    assert task.goals == ("kitchen", "office")
    drawn = {str(task.draw(rng(seed)).mission) for seed in range(20)}
    assert drawn == {"go to the kitchen", "go to the office"}


def test_a_start_keeps_its_distance(make, geodesic):
    task = make(start_distance=3.0)
    missions = [task.draw(rng(seed), to("kitchen")) for seed in range(50)]
    assert all(m.shortest >= 3.0 for m in missions)
    assert min(m.shortest for m in missions) < 3.3 and max(m.shortest for m in missions) > 3.4
    for mission in missions:
        x, y, theta = mission.start
        assert geodesic.free(x, y) and x < 0 and -math.pi <= theta <= math.pi


def test_the_same_generator_draws_the_same_mission(make):
    assert make().draw(rng(7)) == make().draw(rng(7))
    assert make().draw(rng(7)) != make().draw(rng(8))


def test_distance_is_until_the_centre_is_inside(make):
    mission = make().draw(rng(), to("kitchen"), start=(-2.0, 0.0, 0.0))
    assert mission.shortest == pytest.approx(2.0, abs=0.05)
    assert mission.start == (-2.0, 0.0, 0.0)


def test_progress_sums_up_to_the_way_that_is_done(make):
    task = make()
    mission = task.draw(rng(), to("kitchen"), start=(-2.0, 0.0, 0.0))
    total = sum(task.judge(x, 0.0, False).progress for x in np.linspace(-1.9, 1.0, 30))
    assert total == pytest.approx(mission.shortest)
    assert task.judge(-1.0, 0.0, False).progress == pytest.approx(-1.0, abs=0.05)
    assert task.remaining == pytest.approx(1.0, abs=0.05)


def test_staying_for_a_second_succeeds_and_leaving_starts_over(make):
    task = make()
    task.draw(rng(), to("kitchen"), start=(-2.0, 0.0, 0.0))
    inside, outside = (1.0, 0.0, False), (-1.0, 0.0, False)
    assert not any(task.judge(*inside).success for _ in range(9))
    assert not task.judge(*outside).success
    assert not any(task.judge(*inside).success for _ in range(9))
    outcome = task.judge(*inside)
    assert outcome.success and outcome.inside and not outcome.false_arrival


def test_a_declaration_ends_right_or_wrong(make):
    task = make(declares=True)
    task.draw(rng(), to("kitchen"), start=(-2.0, 0.0, 0.0))
    right, wrong = task.judge(1.0, 0.0, True), task.judge(-0.01, 0.0, True)
    assert right.success and not right.false_arrival
    assert wrong.false_arrival and not wrong.success
    assert not any(task.judge(1.0, 0.0, False).success for _ in range(20))


def test_a_start_in_the_goal_by_hand(make):
    task = make()
    assert task.draw(rng(), to("kitchen"), start=(2.0, 0.0, 0.0)).shortest == 0.0


def test_an_unreachable_goal_is_never_drawn_and_raises_by_hand():
    world = two_rooms(open_door=False)
    task = GoToTask(world, Geodesic(world, ROBOT), TaskSettings(SEMANTIC_TYPES))
    with pytest.raises(ValueError, match=r"no way from .* to any 'kitchen'"):
        task.draw(rng(), to("kitchen"), (-2.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="no free place is 2 m or more from every"):
        task.draw(rng())


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"start_distance": -1.0}, "start_distance is -1.0"),
        ({"start_distance": math.nan}, "start_distance is nan"),
    ],
)
def test_what_cannot_be_meant_is_refused(make, kwargs, message):
    with pytest.raises(ValueError, match=message):
        make(**kwargs)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ((0.0, 0.0), "expected a pose"),
        ((0.0, math.nan, 0.0), "expected a pose"),
        ((-4.0, 0.0, 0.0), "not free"),
        ((100.0, 0.0, 0.0), "lies outside"),
    ],
)
def test_a_start_that_is_none_is_refused(make, start, message):
    with pytest.raises(ValueError, match=message):
        make().draw(rng(), to("kitchen"), start=start)


def test_no_place_far_enough_tells_how_far_the_farthest_is(make):
    with pytest.raises(ValueError, match=r"the farthest is \d\.\d m away"):
        make(start_distance=50.0).draw(rng(), to("kitchen"))


@pytest.mark.parametrize(("goal", "message"), [("kitchn", "did you mean 'kitchen'"), (3, "goal is 3, expected")])
def test_a_goal_outside_the_vocabulary_is_refused(goal, message):
    with pytest.raises(ConfigError, match=message):
        GoToTask.read(goal, ("kitchen", "other"))
    assert GoToTask.read("kitchen", ("kitchen", "other")) == to("kitchen")
