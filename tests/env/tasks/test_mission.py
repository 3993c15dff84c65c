import dataclasses
import math

import numpy as np
import pytest

from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.errors import ConfigError
from regionslam_env.missions.mission import Explore, GoTo, Mission, Return
from regionslam_env.tasks.explore import ExploreTask
from regionslam_env.tasks.mission import AT_HOME, MissionTask
from regionslam_env.tasks.task import Moment, TaskSettings
from regionslam_env.worlds.geodesic import STEP, Geodesic
from slam import Odometry, RegionMeasurement, RegionSLAM, Scan
from slam.region import EdgeState
from tests.floors import two_rooms

WORLD = two_rooms()
GEODESIC = Geodesic(WORLD, 0.2)
OFFICE, KITCHEN = (3.0, 2.0), (9.0, 2.0)
START = (*OFFICE, 0.0)


def believe(*regions):
    """Return a belief after some scans of these regions, seen from the middle of the office."""
    slam = RegionSLAM(seed=0)
    for _ in range(6):
        belief = slam.step(Odometry(0.0), Scan(list(regions)), pose=(0.0, 0.0, 0.0))
    return belief


NOTHING = believe()
ALL = believe(
    RegionMeasurement("office", x=0.0, y=0.0, w=6.0, h=4.0),
    RegionMeasurement("kitchen", x=6.0, y=0.0, w=6.0, h=4.0, r=EdgeState.OPEN),
    RegionMeasurement("door", x=3.0, y=0.0, w=1.0, h=0.2, phi=math.pi / 2),
)


def begun(*instructions, declares=False, start=START, **arguments):
    task = MissionTask(WORLD, GEODESIC, TaskSettings(SEMANTIC_TYPES, declares=declares), **arguments)
    return task, task.draw(np.random.default_rng(0), Mission(instructions), start)


def at(point, belief=NOTHING, declared=False, last=False):
    return Moment(np.array([*point, 0.0]), False, declared, lambda: belief, START, last)


def stay(task, point, seconds=1.0, **told):
    """Stand somewhere and return the verdicts."""
    return [task.verdict(at(point, **told)) for _ in range(round(10 * seconds))]


def test_one_instruction_after_another_by_staying():
    task, drawn = begun(GoTo("kitchen"), Return())
    assert str(drawn.mission) == "go to the kitchen, then return to the start"
    assert task.instruction == GoTo("kitchen")
    assert not any(v.terms["instruction"] for v in stay(task, OFFICE))  # not here yet
    *before, done = stay(task, KITCHEN)
    assert not any(v.terms["instruction"] for v in before)
    assert done.terms["instruction"] == 5 and not done.over and not done.terms["success"]
    assert task.instruction == Return() and task.completed == 0.5
    *before, last = stay(task, OFFICE)
    assert not any(v.success for v in before)
    assert last.success and last.over and last.terms["success"] == 10 and task.completed == 1


def test_the_step_that_does_an_instruction_does_not_count_for_the_next():
    task, _ = begun(GoTo("kitchen"), GoTo("kitchen"), Return())
    verdicts = stay(task, KITCHEN, 2.0)
    assert [k for k, v in enumerate(verdicts) if v.terms["instruction"]] == [9, 19]


def test_declarations_do_instructions_one_by_one_and_a_wrong_one_ends_it():
    task, _ = begun(GoTo("kitchen"), Return(), declares=True)
    assert not any(v.terms["instruction"] for v in stay(task, KITCHEN))
    assert not task.verdict(at(KITCHEN, declared=True)).over and task.instruction == Return()
    wrong = task.verdict(at(KITCHEN, declared=True))
    assert wrong.over and not wrong.success and wrong.terms["false_arrival"] == -10
    task, _ = begun(GoTo("kitchen"), Return(), declares=True)
    task.verdict(at(KITCHEN, declared=True))
    assert task.verdict(at(OFFICE, declared=True)).success


def test_the_way_leads_through_all_places_and_progress_sums_up_to_it():
    task, drawn = begun(GoTo("kitchen"), Return())
    way = GEODESIC.distance(START, ["kitchen"])
    assert drawn.shortest == pytest.approx(2 * way - AT_HOME, abs=0.01)
    there = np.linspace(3.0, 9.0, 61)
    walked = [task.verdict(at((x, 2.0))).terms["progress"] for x in there]
    walked += [v.terms["progress"] for v in stay(task, KITCHEN)]
    walked += [task.verdict(at((x, 2.0))).terms["progress"] for x in np.linspace(9.0, 3.5, 12)]
    assert sum(walked) == pytest.approx(drawn.shortest) and task.remaining == 0
    assert min(walked) < -0.05  # deeper into the kitchen than needed


def test_ways_through_the_floor_are_as_long_as_the_best_of_all_points_to_turn_at():
    kitchen, home = GEODESIC.field(["kitchen"]), GEODESIC.field_to_points(np.array([[1.0, 1.0]]), np.zeros(1))
    through = GEODESIC.field_through(kitchen, home)
    turns = (np.argwhere(GEODESIC.floor(["kitchen"])) * STEP + (GEODESIC.grid.x0, GEODESIC.grid.y0))[::20]
    onwards = [(GEODESIC.field_to_points(turn[None], np.zeros(1)), home.at(*turn)) for turn in turns]
    rng = np.random.default_rng(0)
    for _ in range(10):
        x, y = GEODESIC.sample_free(rng, kitchen, at_least=0.5)
        best = min(field.at(x, y) + rest for field, rest in onwards)
        assert kitchen.at(x, y) + kitchen.at(1.0, 1.0) - 0.5 <= through.at(x, y) <= best + 1e-6


def test_exploring_is_judged_by_the_map_and_has_no_way():
    task, drawn = begun(Explore(), GoTo("kitchen"))
    assert drawn.shortest is None and task.remaining is None and task.believed(NOTHING) == 0
    assert not any(v.terms["instruction"] for v in stay(task, OFFICE, 3.0))
    gained = stay(task, OFFICE, 2.0, belief=ALL)
    assert sum(v.terms["instruction"] for v in gained) == 5 and sum(v.terms["recall"] for v in gained) == 20
    assert task.instruction == GoTo("kitchen") and task.figures["explored"] == 1
    assert stay(task, KITCHEN)[-1].success


def test_being_back_is_a_matter_of_ways():
    task, _ = begun(Return(), start=(5.7, 0.5, 0.0))
    beside = (6.3, 0.5)  # across the wall
    assert not any(v.success for v in stay(task, beside, 2.0))
    assert stay(task, (5.0, 0.5))[-1].success


def test_the_robot_believes_to_be_back_near_the_origin_and_only_after_all_else():
    task, _ = begun(GoTo("kitchen"), Return())
    assert task.believed(ALL) == 0
    stay(task, KITCHEN)
    assert task.believed(ALL) == 1
    task, _ = begun(GoTo("office"))
    assert task.believed(ALL) == 1 and task.believed(NOTHING) == 0
    assert begun(Explore())[0].believed(ALL) is None


def test_a_drawn_mission_goes_to_different_places_and_returns():
    task = MissionTask(WORLD, GEODESIC, TaskSettings(SEMANTIC_TYPES))
    for seed in range(5):
        drawn = task.draw(np.random.default_rng(seed))
        first, second, last = drawn.mission.instructions
        assert {first, second} == {GoTo("office"), GoTo("kitchen")} and last == Return()
        assert GEODESIC.distance(drawn.start, [first.type]) >= 2 and math.isfinite(drawn.shortest)
    assert task.draw(np.random.default_rng(3)) == task.draw(np.random.default_rng(3))


def test_the_map_that_is_kept_was_begun_elsewhere():
    task = MissionTask(WORLD, GEODESIC, TaskSettings(SEMANTIC_TYPES))
    task.draw(np.random.default_rng(0), Mission((Return(),)), (*KITCHEN, 0.0), standing=True, home=START)
    assert task.remaining == pytest.approx(6.0 - AT_HOME)
    assert stay(task, OFFICE)[-1].success


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("go to the kitchn", "did you mean 'kitchen'"),
        ("sing", "cannot read the mission 'sing'"),
        (7, "mission is 7, expected words such as"),
        (Mission((GoTo("bar"),)), "unknown goal 'bar'"),
    ],
)
def test_what_is_no_mission_is_refused(wanted, message):
    with pytest.raises(ConfigError, match=message):
        MissionTask.read(wanted, ("kitchen", "office"))


@pytest.mark.parametrize("arguments", [{"n_goals": 0}, {"n_goals": 1.5}, {"map_share": 2}, {"start_distance": "far"}])
def test_arguments_that_are_none_are_refused(arguments):
    (name,) = arguments
    with pytest.raises(ConfigError, match=name):
        begun(Return(), **arguments)


def parted(**types):
    """Two rooms that no way connects."""
    world = two_rooms()
    regions = tuple(dataclasses.replace(r, type=types.get(r.id, r.type)) for r in world.regions)
    blocked = np.vstack([world.walls, (6.0, 1.5, 6.0, 2.5)])
    return dataclasses.replace(world, regions=regions, walls=blocked, doors=(), links=())


def test_starts_are_drawn_where_everything_can_be_done():
    world = parted(office="kitchen")
    task = MissionTask(world, Geodesic(world, 0.2), TaskSettings(SEMANTIC_TYPES), start_distance=0)
    explore, sides = ExploreTask(world, task.geodesic, task.settings), set()
    for seed in range(10):
        drawn = task.draw(np.random.default_rng(seed), Mission((GoTo("kitchen"), Explore())))
        explore.draw(np.random.default_rng(0), start=drawn.start)  # refuses what is not in the largest part
        sides.add(drawn.start[0] < 6)
    assert len(sides) == 1


def test_what_cannot_be_reached_is_named():
    world = parted()
    task = MissionTask(world, Geodesic(world, 0.2), TaskSettings(SEMANTIC_TYPES), start_distance=0)
    with pytest.raises(ConfigError, match=r"no way from .* in order to go to the kitchen"):
        task.draw(np.random.default_rng(0), Mission((GoTo("office"), GoTo("kitchen"))), START)


def test_figures_of_exploring_begin_anew_with_every_episode():
    task, _ = begun(Explore())
    task.verdict(at(OFFICE, belief=ALL))
    assert task.figures["explored"] == 1
    task.draw(np.random.default_rng(0), Mission((GoTo("kitchen"), Explore())), START)
    assert task.figures == {"explored": 0, "closed_edges": 0}
