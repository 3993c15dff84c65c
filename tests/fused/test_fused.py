"""A step in one compiled call gives what the same step gives part by part, bit by bit."""

import pickle
from dataclasses import replace

import gymnasium
import numpy as np
import pytest

from regionslam_env.envs.goto import GoToEnv
from regionslam_env.errors import ConfigError
from regionslam_env.fused.addresses import Addresses
from regionslam_env.registration import ENVIRONMENTS
from regionslam_env.sensors.normals import Normals
from slam.fastslam import DOUBT
from slam.lost import LOST
from tests.floors import two_rooms

pytestmark = pytest.mark.compiled

GOTO = "RegionSLAM/GoTo-v0"


def pair(env_id=GOTO, world=None, **kwargs):
    """Two environments, one of which steps in one call, the other part by part."""
    fused, parted = (gymnasium.make(env_id, world=world or two_rooms(), **kwargs) for _ in range(2))
    assert fused.unwrapped.fusible and parted.unwrapped.fusible
    parted.unwrapped.fusible = False
    return fused, parted


def assert_same(one, other):
    assert list(one) == list(other)
    for key, value in one.items():
        if isinstance(value, dict):
            assert_same(value, other[key])
        elif isinstance(value, np.ndarray):
            assert value.dtype == other[key].dtype and value.tobytes() == other[key].tobytes()
        else:
            assert type(value) is type(other[key])
            assert value == other[key] or (value != value and other[key] != other[key])


def drive_both(fused, parted, steps, seed=0):
    """Drive both alike, and reset them where an episode ends; return how many have ended."""
    rng, ended = np.random.default_rng(seed), 0
    for k in range(steps):
        action = rng.uniform(-1, 1, fused.action_space.shape).astype(np.float32)
        action[0] = 1 if k // 25 % 2 else action[0]
        action[2:] = 1 if rng.random() < 0.02 else -1
        one, other = fused.step(action), parted.step(action)
        assert_same(one[0], other[0])
        assert one[1:4] == other[1:4]
        assert_same(one[4], other[4])
        assert fused.unwrapped.belief.ess == parted.unwrapped.belief.ess
        if one[2] or one[3]:
            ended += 1
            assert_same(fused.reset()[0], parted.reset()[0])
    return ended


@pytest.mark.parametrize(
    ("env_id", "kwargs"),
    [
        (GOTO, {"max_steps": 60}),
        ("RegionSLAM/GoTo-Declare-v0", {"max_steps": 60, "reveal_truth": True}),
        ("RegionSLAM/Explore-v0", {"max_steps": 80, "map_share": 0.5}),
        ("RegionSLAM/Mission-v0", {"max_steps": 80}),
        ("RegionSLAM/Mission-Declare-v0", {"max_steps": 80, "mission": "explore, then return", "map_share": 0.1}),
        (GOTO, {"max_steps": 80, "n_particles": 1, "noise": "heavy", "occlusion": False}),
        (GOTO, {"max_steps": 80, "reward": {"collision": -1, "time": -0.1}, "render_mode": "rgb_array"}),
        (GOTO, {"max_steps": 60, "world": "apartment", "world_options": {"size": 5}}),  # a new one in each episode
    ],
)
def test_same_as_part_by_part(env_id, kwargs):
    fused, parted = pair(env_id, **kwargs)
    assert_same(fused.reset(seed=1)[0], parted.reset(seed=1)[0])
    assert drive_both(fused, parted, 200) >= 2


class Eager(GoToEnv):
    """Resamples whenever its particles differ a little in weight."""

    def _slam_config(self, n_particles):
        return replace(super()._slam_config(n_particles), resample_below=0.9)


def test_same_where_maps_outgrow_their_room_and_particles_are_resampled():
    fused, parted = (Eager(world="institute", n_particles=40) for _ in range(2))
    parted.fusible = False
    fused.reset(seed=0), parted.reset(seed=0)
    before, fewest = len(fused.belief.maps.pool), np.inf
    for k in range(30):
        drive_both(fused, parted, 1, seed=k)
        fewest = min(fewest, fused.belief.ess)
    assert len(fused.belief.maps.pool) > before
    assert fewest < 0.9 * 40


def test_steps_in_one_call_and_part_by_part_take_turns():
    fused, parted = pair()
    fused.reset(seed=3), parted.reset(seed=3)
    for k in range(6):
        drive_both(fused, parted, 10, seed=k)
        fused.unwrapped.fusible = k % 2 == 1


def test_what_an_environment_tells_of_itself():
    fused, parted = pair()
    fused.reset(seed=2), parted.reset(seed=2)
    drive_both(fused, parted, 15)
    one, other = fused.unwrapped, parted.unwrapped
    for name in ("true_pose", "slot_ids", "ranges"):
        assert np.array_equal(getattr(one, name), getattr(other, name))
    assert one.scan.records.tobytes() == other.scan.records.tobytes()
    assert one.scan.links.tobytes() == other.scan.links.tobytes()
    assert one.scan.view.tobytes() == other.scan.view.tobytes()
    assert np.array_equal(one.region_sensor.sources, other.region_sensor.sources)
    assert np.array_equal(one.belief.pose_mean, other.belief.pose_mean)
    assert one.belief.map.to_geojson() == other.belief.map.to_geojson()
    assert one.task.remaining == other.task.remaining


def test_a_filter_that_gets_lost_and_lifelong_mapping():
    fused, parted = pair()
    fused.reset(seed=5), parted.reset(seed=5)
    drive_both(fused, parted, 10)
    for env in (fused, parted):
        env.unwrapped.localizer.filter.progress[1] = 20.0
    drive_both(fused, parted, 1)
    assert fused.unwrapped.belief.lost
    drive_both(fused, parted, 10)
    assert_same(*(env.reset(options={"keep_map": True})[0] for env in (fused, parted)))
    drive_both(fused, parted, 20)
    with pytest.raises(ConfigError):
        fused.reset(options={"goal": "harbour"})
    drive_both(fused, parted, 5)
    carried = {"keep_map": True, "start": (9.0, 2.0, 1.0)}
    assert_same(*(env.reset(options=dict(carried))[0] for env in (fused, parted)))
    drive_both(fused, parted, 20)


class Trusting(GoToEnv):
    """Never takes its filter for lost."""

    def _slam_config(self, n_particles):
        return replace(super()._slam_config(n_particles), relocalise=False)


class Joint(GoToEnv):
    """Maps with the joint posterior."""

    def _slam_config(self, n_particles):
        return replace(super()._slam_config(n_particles), posterior="joint", relocalise=False)


def test_settings_of_the_filter_count():
    fused, parted = Trusting(world=two_rooms()), Trusting(world=two_rooms())
    parted.fusible = False
    fused.reset(seed=5), parted.reset(seed=5)
    drive_both(fused, parted, 10)
    for env in (fused, parted):
        env.localizer.filter.progress[DOUBT] = 0.9 * LOST
        env.simulation.reset(1.0, 3.0, 2.5)  # somewhere else, unseen
    drive_both(fused, parted, 25)
    assert not fused.belief.lost
    assert not Joint(world=two_rooms()).fusible


def test_observations_come_in_the_order_of_the_space():
    env, _ = pair()
    first, _ = env.reset(seed=0)
    assert list(first) == list(env.observation_space) == list(env.step(env.action_space.sample())[0])


def test_what_does_not_get_on_is_no_endless_loop(monkeypatch):
    env, _ = pair()
    env.reset(seed=0)
    monkeypatch.setattr(Normals, "refill", lambda normals: None)
    with pytest.raises(RuntimeError, match="copy 0 doesn't get beyond stage 1"):
        env.step(env.action_space.sample())


def test_a_pickled_episode_goes_on_identically():
    fused, parted = pair(max_steps=40)
    fused.reset(seed=4), parted.reset(seed=4)
    drive_both(fused, parted, 12)
    copy = pickle.loads(pickle.dumps(fused))
    drive_both(copy, parted, 40)


def test_steps_of_an_episode_may_change_while_it_runs():
    env, _ = pair()
    env.reset(seed=0)
    env.step(env.action_space.sample())
    env.unwrapped.max_steps = 2
    assert env.step(env.action_space.sample())[3]


def test_observations_are_not_overwritten_by_the_next_step():
    env, _ = pair()
    env.reset(seed=0)
    first = env.step(np.array([1, 0.5], np.float32))[0]
    kept = {key: value.copy() for key, value in first.items()}
    env.step(np.array([1, 0.5], np.float32))
    assert_same(first, kept)


@pytest.mark.parametrize(
    ("env_id", "kwargs"),
    [
        *((env_id, {}) for env_id in ENVIRONMENTS if "Oracle" in env_id or "Odometry" in env_id),
        (GOTO, {"noise": {"misses": 0.1}}),
        (GOTO, {"sensors": {"field_of_view": 2.0}}),
        (GOTO, {"dynamics": "people"}),
    ],
)
def test_what_the_kernels_do_not_know(env_id, kwargs):
    env = gymnasium.make(env_id, world=two_rooms(), **kwargs)
    assert not env.unwrapped.fusible
    env.reset(seed=0)
    env.step(env.action_space.sample())


def test_steps_that_are_hardly_any_time():
    fused, parted = pair(robot={"step": 1e-300})
    fused.reset(seed=0), parted.reset(seed=0)
    drive_both(fused, parted, 3)
    assert fused.unwrapped.task.approach.state.dtype == np.float64


@pytest.mark.parametrize("array", [np.array([10**300]), np.zeros((4, 4))[:, 0]])
def test_only_arrays_of_numbers_have_addresses(array):
    with pytest.raises(ValueError, match="no contiguous array of numbers"):
        Addresses(1, 1).put(0, 0, (array,))
