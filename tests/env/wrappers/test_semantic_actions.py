import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from regionslam_env.envs import GoToEnv, MissionEnv
from regionslam_env.wrappers import DiscreteActions, SemanticActions, TextObservation
from tests.floors import two_rooms

pytestmark = pytest.mark.compiled
DECLARE, LAST = 32, -1
START = {"goal": "kitchen", "start": (2.0, 2.0, np.pi / 2)}


def make(**kwargs):
    return GoToEnv(world=two_rooms(), **kwargs)


def begin(env, seed=1):
    """Reset and wait until the map has a region; return the slots by name."""
    _, info = env.reset(seed=seed, options=START)
    while not info["action_mask"][: len(env.unwrapped.slot_ids)].any():
        *_, info = env.step(0)
    base = env.unwrapped
    return {base.belief.map.name(int(base.slot_ids[s])): int(s) for s in np.flatnonzero(info["action_mask"][:32])}


def test_one_action_drives_through_the_door_and_sums_the_rewards():
    steps = []

    class Watched(gymnasium.Wrapper):
        def step(self, action):
            steps.append(self.env.step(action))
            return steps[-1]

    env = SemanticActions(Watched(make()))
    slots = begin(env)
    assert {"office", "kitchen", "door"} <= set(slots)
    steps.clear()
    observation, reward, terminated, _, info = env.step(slots["kitchen"])
    assert terminated and info["success"] and info["outcome"] == "ended"
    assert info["steps"] == len(steps) > 20
    assert reward == pytest.approx(sum(step[1] for step in steps))
    assert sum(info["reward_terms"].values()) == pytest.approx(reward)
    assert info["reward_terms"]["success"] == 10 and info["reward_terms"]["collision"] == 0
    assert observation is steps[-1][0]


def test_it_arrives_where_the_episode_goes_on():
    env = SemanticActions(make(arrival="declare"))
    slots = begin(env)
    *_, info = env.step(slots["kitchen"])
    assert info["outcome"] == "arrived" and env.unwrapped.true_pose[0] > 6
    _, _, terminated, _, info = env.step(DECLARE)
    assert terminated and info["success"] and info["outcome"] == "declared" and info["steps"] == 1


@pytest.mark.parametrize("arrival", ["stay", "declare"])
def test_a_mission_out_and_back_by_three_choices(arrival):
    mission = {"mission": "go to the kitchen, then return", "start": (2.0, 2.0, np.pi / 2)}
    env = SemanticActions(MissionEnv(world=two_rooms(), arrival=arrival))
    _, info = env.reset(seed=1, options=mission)
    start, declare = 32, 33  # in a mission the start comes before the declaration
    assert info["action_mask"][start] == 0  # nothing is mapped yet
    while not info["action_mask"][:32].any():
        *_, info = env.step(0)
    assert info["action_mask"][start] == 1
    base = env.unwrapped
    names = {base.belief.map.name(int(base.slot_ids[s])): int(s) for s in np.flatnonzero(info["action_mask"][:32])}
    for action in (names["kitchen"], start):
        *_, terminated, _, info = env.step(action)
        if arrival == "declare":
            *_, terminated, _, info = env.step(declare)
    assert terminated and info["success"] and np.hypot(*(base.true_pose[:2] - (2.0, 2.0))) < 1


def test_the_mask_tells_what_is_mapped_and_an_empty_slot_is_refused():
    env = SemanticActions(make())
    observation, info = env.reset(seed=1, options=START)
    assert info["action_mask"].tolist() == [0] * 32 + [1]
    pose = env.unwrapped.true_pose
    observation, _, terminated, _, info = env.step(31)
    assert not terminated and info["outcome"] == "refused" and info["steps"] == 1
    assert env.unwrapped.true_pose == pytest.approx(pose)
    assert (info["action_mask"][:LAST] == observation["regions_mask"]).all()
    assert info["action_mask"][LAST] == 1 and info["action_mask"].dtype == np.int8
    assert env.action_space.sample(info["action_mask"]) in env.action_space
    declaring = SemanticActions(make(arrival="declare"))
    assert declaring.reset(seed=1)[1]["action_mask"].tolist() == [0] * 32 + [1, 1]


def look_around(env, **kwargs):
    """Reset and look around at once; return the whole turn of the true heading (rad) and the step's result."""
    headings = []

    class Watched(gymnasium.Wrapper):
        def step(self, action):
            result = self.env.step(action)
            headings.append(self.unwrapped.true_pose[2])
            return result

    env = SemanticActions(Watched(env), **kwargs)
    env.reset(seed=1, options=START)
    headings.append(env.unwrapped.true_pose[2])
    result = env.step(env.action_space.n - 1)
    return float(np.sum(np.remainder(np.diff(headings) + np.pi, 2 * np.pi) - np.pi)), result


@pytest.mark.parametrize("arrival", ["stay", "declare"])
def test_the_last_action_looks_once_around_on_the_spot_even_on_an_empty_map(arrival):
    env = make(arrival=arrival)
    turn, (_, reward, terminated, truncated, info) = look_around(env)
    assert turn == pytest.approx(2 * np.pi, abs=0.2) and env.true_pose[:2] == pytest.approx((2.0, 2.0), abs=0.05)
    assert info["outcome"] == "looked" and not (terminated or truncated)
    assert info["steps"] > 20 and sum(info["reward_terms"].values()) == pytest.approx(reward)
    assert info["action_mask"][:32].any()


def test_a_look_around_ends_at_its_limit_and_with_the_episode():
    *_, info = look_around(make(), limit=7)[1]
    assert info["outcome"] == "limit" and info["steps"] == 7
    _, _, terminated, truncated, info = look_around(make(max_steps=10))[1]
    assert truncated and not terminated and info["outcome"] == "ended" and info["steps"] == 10


def test_it_has_the_mask_as_sb3_contrib_asks_for_it():
    env = SemanticActions(make())
    with pytest.raises(ResetNeeded):
        env.action_masks()
    _, info = env.reset(seed=1, options=START)
    assert env.action_masks().dtype == np.bool_ and (env.action_masks() == info["action_mask"]).all()
    *_, info = env.step(env.action_space.n - 1)
    assert env.action_masks().sum() > 1 and (env.action_masks() == info["action_mask"]).all()


def test_maskable_ppo_learns_with_it():
    sb3_contrib = pytest.importorskip("sb3_contrib")
    from sb3_contrib.common.maskable.utils import is_masking_supported
    from stable_baselines3.common.env_util import make_vec_env

    env = make_vec_env(lambda: SemanticActions(make(max_steps=40)), n_envs=2, seed=0)
    assert is_masking_supported(env) and is_masking_supported(SemanticActions(make()))
    model = sb3_contrib.MaskablePPO("MultiInputPolicy", env, n_steps=32, batch_size=32, n_epochs=1, seed=0)
    assert model.learn(64).num_timesteps == 64


def test_a_drive_ends_at_its_limit_and_with_the_episode():
    env = SemanticActions(make(), limit=7)
    *_, info = env.step(begin(env)["kitchen"])
    assert info["outcome"] == "limit" and info["steps"] == 7
    env = SemanticActions(make(max_steps=10))
    _, _, terminated, truncated, info = env.step(begin(env)["kitchen"])
    assert truncated and not terminated and info["outcome"] == "ended" and "spl" in info


@pytest.mark.parametrize("action", [-1, 33, "kitchen", 1.5])
def test_what_is_no_number_of_an_action_is_an_error(action):
    env = SemanticActions(make())
    env.reset(seed=0)
    with pytest.raises(ValueError, match=f"^action is {action!r}, expected a whole number from 0 to 32$"):
        env.step(action)


def test_without_a_running_episode_it_asks_for_a_reset():
    env = SemanticActions(make(arrival="declare"))
    with pytest.raises(ResetNeeded):
        env.step(0)
    begin(env)
    env.step(DECLARE)
    with pytest.raises(ResetNeeded):
        env.step(DECLARE)


def test_the_same_choices_give_the_same_episode():
    def episode():
        env = SemanticActions(make(arrival="declare"))
        slots = begin(env, seed=4)
        return [env.step(slots[name]) for name in ("door", "kitchen", "office")]

    for (a, r, *_, info), (b, s, *_, other) in zip(episode(), episode(), strict=True):
        assert all((a[key] == b[key]).all() for key in a) and r == s and info["steps"] == other["steps"]


def test_what_does_not_fit_is_refused():
    with pytest.raises(TypeError, match="with its own spaces"):
        SemanticActions(DiscreteActions(make()))
    with pytest.raises(TypeError, match="expected a SemanticNavigationEnv"):
        SemanticActions(gymnasium.make("CartPole-v1"))
    with pytest.raises(ValueError, match="limit is 0"):
        SemanticActions(make(), limit=0)


def test_observations_of_another_form_go_around_it():
    env = TextObservation(SemanticActions(make(arrival="declare")))
    slot = begin(env)["kitchen"]
    text, *_ = env.step(slot)
    assert text in env.observation_space and "Place: I am" in text and "the kitchen" in text
    assert f"[{slot}] kitchen: I am in it" in text


def test_gymnasium_accepts_it():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version.*")
        warnings.filterwarnings("ignore", message=".*not having a spec.*")
        check_env(SemanticActions(make()))
