import pickle
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from regionslam_env.envs import GoToEnv
from regionslam_env.errors import ConfigError
from regionslam_env.worlds.generate.generator import KINDS
from regionslam_env.worlds.source import SPLITS, world_seed

SMALL = {"size": 16}
compiled_only = pytest.mark.compiled


@pytest.fixture(scope="module")
def env():
    return GoToEnv(world="office", world_options=SMALL)


@compiled_only
@pytest.mark.parametrize("kind", KINDS)
def test_gymnasium_has_nothing_to_complain_about(kind):
    env = gymnasium.make("RegionSLAM/GoTo-v0", world=kind, world_options=SMALL, max_steps=50).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env)


@compiled_only
def test_stable_baselines_has_nothing_to_complain_about():
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(gymnasium.make("RegionSLAM/GoTo-v0", world="office", world_options=SMALL).unwrapped)


@compiled_only
def test_every_reset_draws_a_world_and_the_seed_tells_which(env):
    numbers, walls = [], []
    for seed in (1, None, None, 1):
        _, info = env.reset(seed=seed)
        numbers.append(info["world_seed"])
        walls.append(env.world.walls)
        assert env.task.world is env.world and env.world.name == f"office {info['world_seed']}"
        assert env.task.geodesic.free(*env.mission.start[:2]) and np.isfinite(env.mission.shortest)
    assert len(set(numbers)) == 3 and numbers[0] == numbers[3]
    assert np.array_equal(walls[0], walls[3]) and not np.array_equal(walls[0], walls[1])


@compiled_only
def test_a_certain_world_can_be_entered_and_its_episodes_differ_by_seed(env):
    for seed in (0, 1):
        _, info = env.reset(seed=seed, options={"world_seed": 5})
        assert info["world_seed"] == 5 and env.world.name == "office 5"
    first = env.mission
    env.reset(seed=0, options={"world_seed": 5})
    assert env.mission.start != first.start


@compiled_only
def test_the_splits_see_other_worlds():
    names = set()
    for split in SPLITS:
        env = GoToEnv(world="apartment", world_options=SMALL, split=split)
        _, info = env.reset(seed=3)
        names.add(env.world.name)
        assert env.world.name == f"apartment {world_seed(split, info['world_seed'])}"
    assert len(names) == 3


@compiled_only
def test_worlds_are_drawn_until_one_has_the_goal():
    env = GoToEnv(world="office", world_options=SMALL, goal="kitchen")
    for seed in range(5):
        env.reset(seed=seed)
        assert env.goal == "kitchen" and env.world.regions_of_type("kitchen")


@compiled_only
def test_the_sensors_are_in_the_new_world(env):
    observation, _ = env.reset(seed=4)
    for action in np.random.default_rng(0).uniform(-1, 1, (30, 2)).astype(np.float32):
        observation, *_ = env.step(action)
        assert observation in env.observation_space
        assert env.task.geodesic.clearance(*env.true_pose[:2]) > -0.01
    assert observation["regions_mask"].any() and (observation["lidar"] < 10).any()


@compiled_only
def test_a_pickle_goes_on_in_the_same_worlds(env):
    env.reset(seed=9)
    copy = pickle.loads(pickle.dumps(env))
    assert np.array_equal(copy.world.walls, env.world.walls)
    assert copy.reset()[1] == env.reset()[1]


SCRIPT = """
import gymnasium
env = gymnasium.make("RegionSLAM/GoTo-v0", world="school", world_options={"size": 16})
observation, info = env.reset(seed=11)
print(info, env.unwrapped.mission, float(observation["lidar"].sum()))
"""


@compiled_only
def test_another_process_sees_the_same():
    command = [sys.executable, "-c", SCRIPT]
    runs = [subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2)]
    assert runs[0] == runs[1] and "world_seed" in runs[0]


@compiled_only
@pytest.mark.parametrize(
    ("kwargs", "options", "message"),
    [
        ({"world": "offise"}, None, "unknown world 'offise': did you mean 'office'?"),
        ({"world_options": {"sise": 3}}, None, "unknown key of world_options 'sise': did you mean 'size'?"),
        ({"goal": "kitchn"}, None, "unknown goal 'kitchn': did you mean 'kitchen'?"),
        ({"goal": "hospital ward"}, None, "unknown goal 'hospital ward': did you mean 'ward'?"),
        ({"world": "institute", "world_options": None}, {"world_seed": 1}, "world_seed is 1, expected none"),
        ({}, {"world_seed": -1}, "world_seed is -1, expected a whole number from 0 to 4294967295"),
        ({"goal": "ward"}, None, "none of 100 worlds of kind 'office' has a 'ward': expected one of "),
        ({}, {"world_seed": 2, "goal": "ward"}, "world 'office 2': unknown goal 'ward'"),
    ],
)
def test_what_cannot_be_is_told(kwargs, options, message):
    with pytest.raises(ValueError, match=message.replace("?", r"\?")):
        GoToEnv(**{"world": "office", "world_options": SMALL, **kwargs}).reset(seed=0, options=options)


@compiled_only
def test_an_environment_survives_a_refused_reset(env):
    env.reset(seed=2)
    before = env.world
    with pytest.raises(ConfigError):
        env.reset(options={"world_seed": 7, "goal": "ward"})
    assert env.world is before and env.task.world is before
    env.step(np.zeros(2, np.float32))
