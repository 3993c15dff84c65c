"""Environments in which things move."""

import pickle
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from regionslam_env.envs import ExploreEnv, GoToEnv, MissionEnv
from regionslam_env.errors import ConfigError
from regionslam_env.rendering.palette import PERSON
from regionslam_env.worlds.format import save_world
from tests.env.test_env import FLOOR, KITCHEN, OFFICE, make, rollout
from tests.floors import crowded_room, furnished_room

pytestmark = pytest.mark.compiled

LIVELY = {"people": 2, "closing_doors": 1.0, "movable_furniture": 1.0, "time_open": 2.0, "time_closed": 1.0}


def same(first, second):
    return all(np.array_equal(a[0][key], b[0][key]) for a, b in zip(first, second, strict=True) for key in a[0]) and [
        a[1:4] for a in first
    ] == [b[1:4] for b in second]


def test_none_is_off():
    plain, none = make(), make(dynamics="none")
    assert plain.movers is None and none.movers is None and none.scene is None
    for env in (plain, none):
        env.reset(seed=5)
    assert same(rollout(plain, 60), rollout(none, 60))


def test_what_moves_changes_no_other_draw():
    still, lively = (make(dynamics=dynamics, reveal_truth=True) for dynamics in (None, LIVELY))
    for seed in range(5):
        (first, info), (second, other) = still.reset(seed=seed), lively.reset(seed=seed)
        assert info["mission"] == other["mission"]
        assert np.array_equal(info["truth"]["pose"], other["truth"]["pose"])
        assert np.array_equal(first["goal"], second["goal"])
        moves = [[env.step([0.0, 0.3])[0]["velocity"] for _ in range(20)] for env in (still, lively)]
        assert np.array_equal(*moves)


def test_the_same_seed_gives_the_same_episodes_and_another_one_does_not():
    first, second = make(dynamics=LIVELY), make(dynamics=LIVELY)
    for _ in range(2):
        for env in (first, second):
            env.reset(seed=7)
        assert same(rollout(first, 80), rollout(second, 80))
    second.reset(seed=8)
    assert not np.array_equal(first.scene.people, second.scene.people)


def test_a_pickled_one_goes_on_identically():
    first = make(dynamics=LIVELY)
    first.reset(seed=3)
    rollout(first, 40)
    second = pickle.loads(pickle.dumps(first))
    assert same(rollout(first, 60, 1), rollout(second, 60, 1))


def test_both_checkers_pass_without_a_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make(dynamics=LIVELY, reveal_truth=True), skip_render_check=True)


def test_the_spec_goes_to_json_and_back():
    env = gymnasium.make("RegionSLAM/GoTo-v0", dynamics={"people": 1})
    spec = gymnasium.envs.registration.EnvSpec.from_json(env.spec.to_json())
    again = gymnasium.make(spec)
    assert again.unwrapped.dynamics == env.unwrapped.dynamics


def test_the_truth_tells_where_everything_is():
    env = make(world=furnished_room(), goal="office", start_distance=0, dynamics=LIVELY, reveal_truth=True)
    _, info = env.reset(seed=0, options={"start": (0.2, 0, 0)})
    assert info["truth"]["people"].shape == (len(env.movers.people.records), 3)
    assert info["truth"]["closed_doors"] == ()
    before = info["truth"]["furniture"]["desk"].copy()
    for _ in range(10):
        info = env.step([1.0, 0.0])[-1]
    assert info["truth"]["furniture"]["desk"][0] > before[0] + 0.1
    assert env.reset(seed=0, options={"start": (0.2, 0, 0)})[1]["truth"]["furniture"]["desk"] == pytest.approx(before)


def test_the_map_is_judged_by_where_furniture_stands_now():
    env = ExploreEnv(world=furnished_room(), dynamics={"movable_furniture": 1.0}, max_steps=75, localization="oracle")
    env.reset(seed=0, options={"start": (0.2, 0, 0)})
    info = {}
    while "region_iou" not in info:
        info = env.step([0.8, 0.0])[-1]
    assert env.movers.poses[0, 0] > 1.8
    assert info["region_recall"] == 1


def test_a_kept_map_keeps_what_has_moved():
    env = make(dynamics=LIVELY, reveal_truth=True)
    _, info = env.reset(seed=0)
    for _ in range(30):
        info = env.step([0.2, 0.1])[-1]
    _, kept = env.reset(options={"keep_map": True})
    assert np.array_equal(kept["truth"]["people"], info["truth"]["people"])
    assert kept["truth"]["closed_doors"] == info["truth"]["closed_doors"]
    people = env.movers.people
    people.put(np.array([(9.0, 2.1), (9.0, 1.0)]))
    env.reset(options={"keep_map": True, "start": KITCHEN})
    moved, unmoved = people.places
    assert np.hypot(*(moved - KITCHEN[:2])) > 1
    assert unmoved == pytest.approx((9, 1))


def test_the_native_vector_environment_steps_them_as_single_ones(tmp_path):
    save_world(FLOOR, tmp_path / "rooms.geojson")
    kwargs = {"num_envs": 2, "world": str(tmp_path / "rooms.geojson"), "dynamics": LIVELY}
    native, sync = (
        gymnasium.make_vec("RegionSLAM/GoTo-v0", vectorization_mode=mode, **kwargs)
        for mode in ("vector_entry_point", "sync")
    )
    first, second = native.reset(seed=1)[0], sync.reset(seed=1)[0]
    for step in range(30):
        assert all(np.array_equal(first[key], second[key]) for key in first)
        action = np.full((2, 2), 0.5 if step % 5 else -0.5, np.float32)
        (first, *native_rest, _), (second, *sync_rest, _) = native.step(action), sync.step(action)
        assert all(map(np.array_equal, native_rest, sync_rest))
    native.close()
    sync.close()


def test_a_closed_door_ends_no_mission():
    dynamics = {"closing_doors": 1.0, "time_open": 0.5, "time_closed": 3.0}
    env = make(goal="kitchen", dynamics=dynamics, max_steps=400)
    held = 0
    for seed in range(5):
        env.reset(seed=seed, options={"start": OFFICE})
        info = {}
        while "success" not in info:
            info = env.step([0.5, 0.0])[-1]
            held += env.simulation.collided
        assert info["success"]
    assert held > 0


def test_people_are_in_the_picture():
    still, lively = (make(dynamics=dynamics, render_mode="rgb_array") for dynamics in (None, LIVELY))
    counts = []
    for env in (still, lively):
        env.reset(seed=0)
        env.step([0.0, 0.0])
        counts.append(int((env.render()[60:-80] == PERSON).all(axis=2).sum()))
    assert counts[0] == 0 and counts[1] > 50


def test_bad_dynamics_are_refused():
    with pytest.raises(ConfigError, match="unknown dynamics 'peeple': did you mean 'people'"):
        GoToEnv(world=FLOOR, dynamics="peeple")
    with pytest.raises(ConfigError, match="unknown key of dynamics 'door'"):
        GoToEnv(world=FLOOR, dynamics={"door": 1})


@pytest.mark.parametrize("max_steps", [26, 200])
def test_where_furniture_stood_there_is_a_way(max_steps):
    dynamics = {"movable_furniture": 1.0, "furniture_mass": 2.0}
    kwargs = {"world": crowded_room(), "dynamics": dynamics, "arrival": "declare", "max_steps": max_steps}
    env = MissionEnv(mission="go to the office, then go to the kitchen", start_distance=0.0, **kwargs)
    env.reset(seed=0, options={"start": (1.7, 2.0, 0.0)})
    results = [env.step([1.0, 0.0, float(k == 20)]) for k in range(26)]
    assert 2.8 < env.true_pose[0] < 4 and env.task.completed == 0.5  # where the bed stood
    assert all(np.isfinite(reward) for _, reward, *_ in results)
    if max_steps == 26:
        assert results[-1][3] and 1 < results[-1][4]["distance_to_goal"] < 8
    env.reset(options={"keep_map": True, "mission": "go to the kitchen"})
    assert 1 < env.task.remaining < 8


def test_a_robot_is_not_put_into_what_has_moved():
    env = make(world=crowded_room(), dynamics={"movable_furniture": 1.0, "furniture_mass": 2.0})
    env.reset(seed=0, options={"start": (1.7, 2.0, 0.0), "goal": "kitchen"})
    for _ in range(10):
        env.step([1.0, 0.0])
    with pytest.raises(ConfigError, match="furniture or a closed door is there now"):
        env.reset(options={"keep_map": True, "start": (4.3, 2.0, 0.0)})
