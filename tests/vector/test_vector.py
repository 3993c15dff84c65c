"""The native vector environment gives what `SyncVectorEnv` gives, bit by bit."""

import pickle

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from regionslam_env.errors import ConfigError
from regionslam_env.missions.mission import GoTo, Mission
from regionslam_env.observations import ProgressColumn
from regionslam_env.registration import ENVIRONMENTS
from regionslam_env.vector import NavigationVectorEnv
from regionslam_env.vector.environment import can_step_together
from regionslam_env.worlds.format import save_world
from tests.floors import two_rooms

pytestmark = pytest.mark.compiled

GOTO = "RegionSLAM/GoTo-v0"
MODES = [mode.value for mode in AutoresetMode]


@pytest.fixture(scope="module")
def floor(tmp_path_factory):
    path = tmp_path_factory.mktemp("worlds") / "rooms.geojson"
    save_world(two_rooms(), path)
    return str(path)


def native(env_id, num_envs=3, **kwargs):
    return gymnasium.make_vec(env_id, num_envs, vectorization_mode="vector_entry_point", **kwargs)


def sync(env_id, num_envs=3, autoreset_mode="NextStep", **kwargs):
    return gymnasium.make_vec(
        env_id, num_envs, vectorization_mode="sync", vector_kwargs={"autoreset_mode": autoreset_mode}, **kwargs
    )


def assert_same(a, b):
    if isinstance(a, dict):
        assert set(a) == set(b)
        for key in a:
            assert_same(a[key], b[key])
    elif isinstance(a, np.ndarray):
        assert (a.dtype, a.shape) == (b.dtype, b.shape)
        if a.dtype == object:
            for one, other in zip(a, b, strict=True):
                assert_same(one, other)
        else:
            assert a.tobytes() == b.tobytes()
    else:
        assert (type(a), a) == (type(b), b)


def drawn_actions(envs, steps, seed=0):
    """Random actions, every other run of 25 steps mostly ahead; a declaration in one of fifty."""
    rng = np.random.default_rng(seed)
    actions = rng.uniform(-1, 1, (steps, *envs.action_space.shape)).astype(np.float32)
    actions[np.arange(steps) // 25 % 2 == 1, :, 0] = 1
    if actions.shape[2] == 3:
        actions[:, :, 2] = np.where(rng.random(actions.shape[:2]) < 0.02, 1, -1)
    return actions


def drive_both(ours, theirs, steps):
    """Drive two vector environments alike; return how many episodes have ended."""
    ended = 0
    for actions in drawn_actions(ours, steps):
        result = ours.step(actions)
        for one, other in zip(result, theirs.step(actions), strict=True):
            assert_same(one, other)
        over = result[2] | result[3]
        ended += over.sum()
        if over.any() and ours.metadata["autoreset_mode"] == AutoresetMode.DISABLED:
            options = [{"reset_mask": over.copy()} for _ in range(2)]
            for one, other in zip(ours.reset(options=options[0]), theirs.reset(options=options[1]), strict=True):
                assert_same(one, other)
    return ended


@pytest.mark.parametrize(
    ("env_id", "kwargs"),
    [
        (GOTO, {"max_steps": 20}),
        ("RegionSLAM/GoTo-Declare-v0", {"max_steps": 40, "reveal_truth": True}),
        ("RegionSLAM/Explore-v0", {"max_steps": 30, "map_share": 0.5}),
        ("RegionSLAM/Mission-v0", {"max_steps": 60, "mission": "explore, then return", "map_share": 0.1}),
    ],
)
@pytest.mark.parametrize("mode", MODES)
def test_same_as_sync_over_several_episodes(env_id, kwargs, mode, floor):
    ours, theirs = (
        native(env_id, autoreset_mode=mode, world=floor, **kwargs),
        sync(env_id, 3, mode, world=floor, **kwargs),
    )
    assert isinstance(ours, NavigationVectorEnv) and isinstance(theirs, SyncVectorEnv)
    assert ours.metadata["autoreset_mode"] is AutoresetMode(mode)
    assert (ours.observation_space, ours.action_space) == (theirs.observation_space, theirs.action_space)
    for one, other in zip(ours.reset(seed=3), theirs.reset(seed=3), strict=True):
        assert_same(one, other)
    assert drive_both(ours, theirs, 90) >= 3


def test_same_as_sync_on_the_default_floor_where_maps_outgrow_their_room():
    ours, theirs = native(GOTO, 2, n_particles=40), sync(GOTO, 2, n_particles=40)
    ours.reset(seed=0), theirs.reset(seed=0)
    before = len(ours.envs[0].belief.maps.pool)
    drive_both(ours, theirs, 20)
    assert len(ours.envs[0].belief.maps.pool) > before


@pytest.mark.parametrize(
    ("env_id", "kwargs"),
    [
        ("RegionSLAM/GoTo-Oracle-v0", {}),
        ("RegionSLAM/GoTo-Odometry-v0", {}),
        (GOTO, {"noise": {"misses": 0.1}}),
        (GOTO, {"sensors": {"field_of_view": 2.0}}),
    ],
)
def test_what_the_kernels_do_not_know_is_stepped_alone(env_id, kwargs, floor):
    ours, theirs = native(env_id, 2, world=floor, **kwargs), sync(env_id, 2, world=floor, **kwargs)
    assert not can_step_together(ours.envs)
    ours.reset(seed=1), theirs.reset(seed=1)
    drive_both(ours, theirs, 10)


def test_worlds_that_are_drawn():
    kwargs = {"world": "apartment", "world_options": {"size": 5}, "max_steps": 15}
    ours, theirs = native(GOTO, 2, **kwargs), sync(GOTO, 2, **kwargs)
    for one, other in zip(ours.reset(seed=7), theirs.reset(seed=7), strict=True):
        assert_same(one, other)
    assert drive_both(ours, theirs, 40) >= 2


def test_a_filter_that_is_lost_is_stepped_alone(floor):
    ours, theirs = native(GOTO, world=floor), sync(GOTO, world=floor)
    ours.reset(seed=2), theirs.reset(seed=2)
    drive_both(ours, theirs, 20)
    for envs in (ours, theirs):
        envs.envs[1].unwrapped.localizer.carry()
    assert ours.call("belief")[1].lost
    drive_both(ours, theirs, 20)


def test_a_filter_that_gets_lost_in_a_step(floor):
    ours, theirs = native(GOTO, world=floor), sync(GOTO, world=floor)
    ours.reset(seed=2), theirs.reset(seed=2)
    drive_both(ours, theirs, 5)
    ours.call("belief")
    for envs in (ours, theirs):
        envs.envs[2].unwrapped.localizer.filter.progress[1] = 20.0
    ours.call("belief")
    drive_both(ours, theirs, 1)
    assert [belief.lost for belief in ours.call("belief")] == [False, False, True]
    drive_both(ours, theirs, 10)


def test_what_an_environment_tells_of_itself_is_up_to_date(floor):
    ours, theirs = native(GOTO, world=floor), sync(GOTO, world=floor)
    ours.reset(seed=[4, 9, 4]), theirs.reset(seed=[4, 9, 4])
    drive_both(ours, theirs, 12)
    for name in ("true_pose", "slot_ids", "ranges", "goal", "np_random_seed"):
        for one, other in zip(ours.get_attr(name), theirs.get_attr(name), strict=True):
            assert np.array_equal(one, other)
    for one, other in zip(ours.get_attr("scan"), theirs.get_attr("scan"), strict=True):
        assert one.records.tobytes() == other.records.tobytes()
        assert one.view.tobytes() == other.view.tobytes()
    for one, other in zip(ours.get_attr("belief"), theirs.get_attr("belief"), strict=True):
        assert np.array_equal(one.pose_mean, other.pose_mean)
        assert (one.ess, one.heaviest) == (other.ess, other.heaviest)
    ours.set_attr("max_steps", 13), theirs.set_attr("max_steps", 13)
    assert drive_both(ours, theirs, 1) == 3


def test_options_of_a_reset_and_lifelong_mapping(floor):
    ours, theirs = native(GOTO, world=floor), sync(GOTO, world=floor)
    ours.reset(seed=0), theirs.reset(seed=0)
    drive_both(ours, theirs, 15)
    for one, other in zip(*(envs.reset(options={"keep_map": True}) for envs in (ours, theirs)), strict=True):
        assert_same(one, other)
    drive_both(ours, theirs, 15)


def refuse(**kwargs):
    raise ConfigError("not today")


def test_a_reset_that_one_copy_refuses_counts_for_those_before():
    kwargs = {"world": "apartment", "world_options": {"size": 5}}
    ours, theirs = native(GOTO, 2, **kwargs), sync(GOTO, 2, **kwargs)
    ours.reset(seed=7), theirs.reset(seed=7)
    drive_both(ours, theirs, 5)
    for envs in (ours, theirs):
        second = envs.envs[1].unwrapped
        second.reset = refuse
        with pytest.raises(ConfigError, match="not today"):
            envs.reset()
        del second.reset
    drive_both(ours, theirs, 20)


def test_no_episode_goes_on_after_its_end_where_the_next_one_is_refused(floor):
    ours, theirs = (make(GOTO, 2, world=floor, max_steps=3, autoreset_mode="Disabled") for make in (native, sync))
    for envs in (ours, theirs):
        envs.reset(seed=0)
        for _ in range(3):
            envs.step(np.zeros((2, 2), np.float32))
        with pytest.raises(ConfigError, match="harbour"):
            envs.reset(options={"goal": "harbour"})
        with pytest.raises(ResetNeeded):
            envs.step(np.zeros((2, 2), np.float32))


def test_steps_together_and_alone_take_turns_while_maps_outgrow_their_room():
    ours, theirs = native(GOTO, 2, n_particles=40), sync(GOTO, 2, n_particles=40)
    ours.reset(seed=0), theirs.reset(seed=0)
    before = len(ours.envs[0].belief.maps.pool)
    for limits in ([900, 1000], [1000, 1000], [900, 1000], [1000, 1000]):
        ours.set_attr("max_steps", limits), theirs.set_attr("max_steps", limits)
        drive_both(ours, theirs, 2 if limits[0] == 900 else 20)
    assert len(ours.envs[0].belief.maps.pool) > before


def test_a_pickled_one_goes_on_identically(floor):
    first = native(GOTO, world=floor, max_steps=20)
    first.reset(seed=0)
    for actions in drawn_actions(first, 10):
        first.step(actions)
    second = pickle.loads(pickle.dumps(first))
    assert drive_both(first, second, 25) >= 3


def test_observations_are_copies_unless_they_need_not_be(floor):
    for copy in (True, False):
        envs = native(GOTO, 2, world=floor, copy=copy)
        before, _ = envs.reset(seed=0)
        after, *_ = envs.step(np.ones((2, 2), np.float32))
        shared = [np.shares_memory(before[key], after[key]) for key in before]
        assert shared == [not copy] * len(before)


def test_text_pictures_of_all_copies(floor):
    ours, theirs = native(GOTO, 2, world=floor, render_mode="ansi"), sync(GOTO, 2, world=floor, render_mode="ansi")
    ours.reset(seed=0), theirs.reset(seed=0)
    drive_both(ours, theirs, 5)
    assert ours.render() == theirs.render()


def test_wrong_use_is_refused(floor):
    envs = native(GOTO, 2, world=floor, max_steps=1, autoreset_mode="Disabled")
    with pytest.raises(ResetNeeded, match="call reset"):
        envs.step(np.zeros((2, 2)))
    envs.reset(seed=0)
    with pytest.raises(ValueError, match="shape"):
        envs.step(np.zeros(2))
    with pytest.raises(ValueError, match="action 1 is"):
        envs.step([[0, 0], [np.nan, 0]])
    envs.step(np.zeros((2, 2)))
    with pytest.raises(ResetNeeded, match=r"\[0, 1\]"):
        envs.step(np.zeros((2, 2)))
    envs.close()


@pytest.mark.parametrize("env_id", sorted(ENVIRONMENTS))
def test_every_id_can_be_made_as_many(env_id, floor):
    envs = gymnasium.make_vec(env_id, 2, world=floor)
    assert isinstance(envs, NavigationVectorEnv)
    observations, _ = envs.reset(seed=0)
    assert observations in envs.observation_space
    observations, *_ = envs.step(envs.action_space.sample())
    assert observations in envs.observation_space
    envs.close()


def test_the_same_instruction_twice(floor):
    mission = Mission((GoTo("office"),) * 2)
    kwargs = {"world": floor, "mission": mission, "start_distance": 0.0}
    ours, theirs = native("RegionSLAM/Mission-v0", 2, **kwargs), sync("RegionSLAM/Mission-v0", 2, **kwargs)
    ours.reset(seed=0), theirs.reset(seed=0)
    start = {"start": (3.0, 2.0, 0.0)}
    ours.reset(options=start), theirs.reset(options=start)
    told = set()
    for _ in range(15):
        result = ours.step(np.zeros((2, 2), np.float32))
        for one, other in zip(result, theirs.step(np.zeros((2, 2), np.float32)), strict=True):
            assert_same(one, other)
        told.add(float(result[0]["progress"][0, ProgressColumn.COMPLETED]))
    assert told == {0.0, 0.5}


@pytest.mark.parametrize(("name", "values"), [("max_steps", [4, 8, 50]), ("max_steps", 5), ("reveal_truth", True)])
def test_what_is_set_counts_for_each_copy(name, values, floor):
    ours, theirs = native(GOTO, world=floor), sync(GOTO, world=floor)
    ours.reset(seed=0), theirs.reset(seed=0)
    for envs in (ours, theirs):
        envs.set_attr(name, values)
    drive_both(ours, theirs, 12)


@pytest.mark.parametrize("num_envs", [0, 1.5])
def test_a_number_of_copies_that_is_none_is_refused(num_envs, floor):
    with pytest.raises(ConfigError, match=f"num_envs is {num_envs}"):
        native(GOTO, num_envs, world=floor)
