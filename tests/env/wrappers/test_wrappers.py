import re
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from regionslam_env.envs import GoToEnv
from regionslam_env.wrappers import MOTIONS, DiscreteActions, FlatObservation
from tests.floors import two_rooms


@pytest.fixture(scope="module")
def env():
    return GoToEnv(world=two_rooms())


@pytest.fixture(scope="module")
def declaring():
    return GoToEnv(world=two_rooms(), arrival="declare")


def test_a_flat_observation_holds_every_part_in_order(env):
    flat = FlatObservation(env)
    vector, _ = flat.reset(seed=3)
    parts, _ = env.reset(seed=3)
    assert vector in flat.observation_space and vector.dtype == np.float32
    assert vector.tolist() == [x for key in env.observation_space for x in parts[key].tolist()]
    assert flat.observation_space.shape == vector.shape


def test_every_motion_is_the_continuous_action_it_names(env):
    discrete = DiscreteActions(env)
    assert discrete.action_space.n == len(MOTIONS) and discrete.names == tuple(MOTIONS)
    for number, motion in enumerate(MOTIONS.values()):
        assert discrete.action(number) == pytest.approx(motion)
        assert discrete.action(number) in env.action_space


def test_only_the_last_action_declares(declaring):
    discrete = DiscreteActions(declaring)
    assert discrete.names[-1] == "declare"
    actions = np.array([discrete.action(number) for number in range(discrete.action_space.n)])
    assert (actions[:-1, 2] < 0).all() and actions[-1, 2] > 0
    discrete.reset(seed=0, options={"goal": "kitchen", "start": (9.0, 2.0, 0.0)})
    _, _, terminated, _, info = discrete.step(discrete.names.index("declare"))
    assert terminated and info["success"]


@pytest.mark.parametrize("action", [-1, len(MOTIONS), "forward", 1.5, None, [1], np.array([1])])
def test_what_is_no_number_of_an_action_is_refused(env, action):
    message = f"action is {action!r}, expected a whole number from 0 to {len(MOTIONS) - 1}"
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        DiscreteActions(env).step(action)


@pytest.mark.parametrize("action", [2, np.int64(2), np.array(2)])
def test_any_kind_of_whole_number_is_an_action(env, action):
    assert DiscreteActions(env).action(action) == pytest.approx(MOTIONS["forward right"])


def test_wrapping_what_does_not_fit_is_refused():
    with pytest.raises(TypeError, match="expected a Dict"):
        FlatObservation(gymnasium.make("CartPole-v1"))
    with pytest.raises(TypeError, match="expected a Box"):
        DiscreteActions(gymnasium.make("CartPole-v1"))


def test_gymnasium_accepts_the_wrapped_environment(env):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version.*")
        warnings.filterwarnings("ignore", message=".*not having a spec.*")
        check_env(DiscreteActions(FlatObservation(env)))
