"""Odd values of arguments and options: each is used, or refused by an error that names the argument and the value."""

import dataclasses
import inspect
import math

import numpy as np
import pytest

from regionslam_env.arguments import CommonArguments, ResetOptions
from regionslam_env.config import DynamicsConfig, NoiseConfig, RobotConfig, SensorConfig
from regionslam_env.envs import ExploreEnv, GoToEnv, MissionEnv
from regionslam_env.errors import ConfigError, WorldError
from regionslam_env.tasks.rewards import ExploreRewardConfig, MissionRewardConfig, RewardConfig
from regionslam_env.worlds.generate.options import WorldOptions
from slam.measurement import MeasurementNoise
from slam.motion import MotionNoise
from tests.floors import two_rooms

FLOOR = two_rooms()
FEW = (None, -1, 10**400, math.nan, "x", [], np.zeros(3))
ODD = (
    *FEW,
    *(True, 0, 3, 10**30, -0.5, 1e-300, 1e300, math.inf, -math.inf, 1j, "", "1", "office\x00", b"slam"),
    *({}, set(), [1, 2], [math.nan] * 3, {"x": 1}, {1: 2}, object),
    *(np.float32(0.5), np.int64(2), np.array("slam"), np.array(["a", "b"])),
)
odd_values = pytest.mark.parametrize("odd", [FEW, pytest.param(ODD, marks=pytest.mark.slow)], ids=["few", "many"])

ENVIRONMENTS = (GoToEnv, ExploreEnv, MissionEnv)
NESTED = {
    "robot": RobotConfig,
    "sensors": SensorConfig,
    "noise": NoiseConfig,
    "dynamics": DynamicsConfig,
}
REWARDS = {GoToEnv: RewardConfig, ExploreEnv: ExploreRewardConfig, MissionEnv: MissionRewardConfig}


def own_arguments(env_class):
    """Return the names of the arguments that an environment adds to the common ones."""
    parameters = inspect.signature(env_class.__init__).parameters.values()
    return [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]


def attempt(env_class, name, kwargs, options=None):
    """Make an environment and use it, or be refused; return what is wrong with how."""
    try:
        env = env_class(**({"world": FLOOR} | kwargs))
        env.reset(seed=0, options=options)
        for _ in range(2):
            observation, reward, terminated, truncated, _ = env.step(np.zeros(env.action_space.shape))
            if terminated or truncated:
                break
        if not np.isfinite(reward) or not all(np.isfinite(v).all() for v in observation.values()):
            return "not finite"
    except (ConfigError, WorldError) as error:
        message = str(error)
        too_large = "reached by the robot" in message or "start_distance" in message  # for this floor
        if name not in message.replace(" ", "_") and not (name == "radius" and too_large):
            return f"{name} is not named: {message}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


def troubles(cases):
    """Return what went wrong, by argument and value."""
    found = {(*labels, repr(value)[:40]): attempt(*case) for labels, value, case in cases}
    return {key: trouble for key, trouble in found.items() if trouble is not None}


@odd_values
@pytest.mark.parametrize("name", CommonArguments.__annotations__)
def test_common_arguments(name, odd):
    cases = [
        ((name,), value, (GoToEnv, name, {name: value})) for value in odd if not (name == "world" and value is None)
    ]
    assert troubles(cases) == {}


@odd_values
@pytest.mark.parametrize("env_class", ENVIRONMENTS)
def test_own_arguments(env_class, odd):
    assert own_arguments(env_class)
    cases = [((name,), value, (env_class, name, {name: value})) for name in own_arguments(env_class) for value in odd]
    assert troubles(cases) == {}


@odd_values
@pytest.mark.parametrize("env_class", ENVIRONMENTS)
def test_options_of_reset(env_class, odd):
    cases = [((name,), value, (env_class, name, {}, {name: value})) for name in ResetOptions._fields for value in odd]
    assert troubles(cases) == {}


@odd_values
@pytest.mark.parametrize("name", NESTED)
def test_keys_of_settings(name, odd):
    fields = [field.name for field in dataclasses.fields(NESTED[name])]
    cases = [((name, key), value, (GoToEnv, key, {name: {key: value}})) for key in fields for value in odd]
    assert troubles(cases) == {}


@odd_values
@pytest.mark.parametrize("env_class", ENVIRONMENTS)
def test_weights_of_rewards(env_class, odd):
    fields = [field.name for field in dataclasses.fields(REWARDS[env_class])]
    cases = [((key,), value, (env_class, key, {"reward": {key: value}})) for key in fields for value in odd]
    assert troubles(cases) == {}


@odd_values
@pytest.mark.parametrize(("part", "config"), [("odometry", MotionNoise), ("regions", MeasurementNoise)])
def test_noise_by_sensor(part, config, odd):
    fields = [field.name for field in dataclasses.fields(config)]
    cases = [((part, key), value, (GoToEnv, key, {"noise": {part: {key: value}}})) for key in fields for value in odd]
    assert troubles(cases) == {}


@odd_values
def test_options_of_generated_worlds(odd):
    fields = [field.name for field in dataclasses.fields(WorldOptions)]
    cases = [
        ((key,), value, (GoToEnv, key, {"world": "apartment", "world_options": {key: value}}))
        for key in fields
        for value in odd
    ]
    assert troubles(cases) == {}
