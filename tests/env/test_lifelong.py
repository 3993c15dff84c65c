"""Episodes that keep the map of the one before."""

import pickle

import numpy as np
import pytest

from regionslam_env.envs import GoToEnv, MissionEnv
from regionslam_env.errors import ConfigError
from tests.floors import two_rooms

KEEP = {"keep_map": True}
OFFICE, KITCHEN = (3.0, 2.0, 0.0), (9.0, 2.0, 0.0)


def make(**kwargs):
    return GoToEnv(**({"world": two_rooms()} | kwargs))


def drive(env, n, action=(0.6, 0.0)):
    for _ in range(n):
        result = env.step(np.array(action))
    return result


def mapped(env, goal="kitchen"):
    """Let a robot see the office, and end in the middle of its floor."""
    env.reset(seed=1, options={"start": OFFICE, "goal": goal})
    drive(env, 20, (0.3, 0.2))
    return env


@pytest.mark.parametrize("localization", ["slam", "oracle", "odometry"])
def test_map_pose_and_rows_go_on(localization):
    env = mapped(make(localization=localization))
    before, pose, belief = drive(env, 1, (0.0, 0.0))[0], env.true_pose, env.belief.pose_mean
    ids = {region.id for region in env.belief.map.regions}
    observation, info = env.reset(seed=2, options=KEEP)
    assert env.true_pose == pytest.approx(pose) and env.mission.start == pytest.approx(tuple(pose))
    assert env.belief.pose_mean == pytest.approx(belief, abs=0.05)
    assert np.array_equal(observation["regions_mask"], before["regions_mask"]) and before["regions_mask"].sum() >= 2
    assert {r.id for r in env.belief.map.regions} == ids and info["mission"] == "go to the kitchen"
    assert not env.belief.lost and observation["progress"].tolist() == [0, 0, 0, 1, 0, 0]


def test_without_it_the_map_is_forgotten():
    env = mapped(make())
    env.reset(seed=2, options={"start": OFFICE})
    assert not any(region.sightings > 1 for region in env.belief.map.regions)
    assert env.belief.pose_mean == pytest.approx(np.zeros(3), abs=0.1)


def test_errors_are_taken_in_the_frame_of_the_first_start():
    env = mapped(make(localization="oracle", max_steps=30, reveal_truth=True))
    _, info = env.reset(seed=2, options=KEEP)
    x, y, theta = env.true_pose
    assert info["truth"]["pose_in_map"] == pytest.approx([x - OFFICE[0], y - OFFICE[1], theta])
    info = drive(env, 30, (0.0, 0.2))[4]
    assert info["ape_max"] == pytest.approx(0, abs=1e-9)
    assert info["region_recall"] > 0.5 and info["region_iou"] > 0.8


def test_a_carried_robot_is_lost_until_it_finds_itself():
    env = mapped(make())
    drive(env, 100, (0.0, 0.2))
    env.reset(seed=2, options=KEEP | {"start": (2.0, 1.2, 2.0), "goal": "kitchen"})
    assert env.belief.lost
    drive(env, 60, (0.0, 0.3))
    assert not env.belief.lost
    true = env.episode.in_map(env.true_pose)
    assert np.hypot(*(env.belief.pose_mean - true)[:2]) < 0.3


def test_the_oracle_is_told_where_it_was_carried_to():
    env = mapped(make(localization="oracle"))
    env.reset(seed=2, options=KEEP | {"start": KITCHEN, "goal": "office"})
    assert not env.belief.lost and env.belief.pose_mean == pytest.approx([6, 0, 0], abs=1e-9)


def test_a_drawn_goal_is_not_where_the_robot_stands():
    env = mapped(make())
    for seed in range(4):
        env.reset(seed=seed, options=KEEP)
        assert env.goal == "kitchen" and env.mission.shortest >= 2
    env.reset(seed=0, options=KEEP | {"goal": "office"})
    assert env.mission.shortest == 0


def test_a_robot_against_a_wall_goes_on_from_there():
    env = make(goal="kitchen")
    env.reset(seed=1, options={"start": (1.0, 2.0, np.pi)})
    drive(env, 30, (1.0, 0.0))
    assert env.task.geodesic.clearance(*env.true_pose[:2]) < 0.01
    env.reset(seed=2, options=KEEP)
    assert env.true_pose[0] == env.mission.start[0] and 5 < env.mission.shortest < 7


def test_a_pickle_keeps_the_map_as_well():
    env = mapped(make())
    copy = pickle.loads(pickle.dumps(env))
    for one in (env, copy):
        one.reset(seed=4, options=KEEP)
    assert all(np.array_equal(a, b) for a, b in zip(*(drive(e, 5)[0].values() for e in (env, copy)), strict=True))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"keep_map": 1}, "keep_map is 1, expected True or False"),
        (KEEP | {"world_seed": 3}, "world_seed is 3, expected that of the map to keep: 'two rooms'"),
        (KEEP | {"start": (0.0, 0.0, 0.0)}, "not free"),
        (KEEP | {"goal": "kitchn"}, "did you mean 'kitchen'"),
    ],
)
def test_what_cannot_go_on_is_refused(options, message):
    env = mapped(make())
    with pytest.raises(ConfigError, match=message):
        env.reset(options=options)


def test_there_is_no_map_before_the_first_episode():
    with pytest.raises(ConfigError, match="there is no map yet"):
        make().reset(options=KEEP)


def test_dead_reckoning_cannot_be_carried():
    env = mapped(make(localization="odometry"))
    with pytest.raises(ConfigError, match="dead reckoning cannot find a robot that was carried"):
        env.reset(options=KEEP | {"start": KITCHEN, "goal": "office"})
    assert np.isfinite(drive(env, 1)[1]) and env.goal == "kitchen"  # the episode before goes on


@pytest.mark.compiled
def test_the_map_of_a_generated_world_is_kept_in_it_alone():
    env = GoToEnv(world="apartment", world_options={"size": 8})
    _, info = env.reset(seed=1)
    number, world = info["world_seed"], env.world
    assert env.reset(seed=2, options=KEEP)[1]["world_seed"] == number and env.world is world
    env.reset(seed=3, options=KEEP | {"world_seed": number})
    with pytest.raises(ConfigError, match=f"expected that of the map to keep: {number}"):
        env.reset(options=KEEP | {"world_seed": number + 1})


def test_to_return_is_to_go_where_the_kept_map_was_begun():
    env = MissionEnv(world=two_rooms(), mission="return", reveal_truth=True)
    env.reset(seed=0, options={"start": (3.0, 2.0, 0.0), "mission": "go to the kitchen"})
    for _ in range(40):
        env.step([1.0, 0.0])
    assert env.true_pose[0] > 6.0
    _, info = env.reset(options={"keep_map": True})
    assert info["mission"] == "return to the start"
    assert info["truth"]["distance_to_goal"] == pytest.approx(env.true_pose[0] - 3.0 - 1.0, abs=0.02)
