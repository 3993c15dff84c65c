import dataclasses
import inspect
import os
import pickle
import re
import subprocess
import sys
import warnings
from itertools import pairwise

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from regionslam_env.arguments import CommonArguments
from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.envs import ExploreEnv, GoToEnv, MissionEnv
from regionslam_env.errors import ConfigError
from regionslam_env.observations import RegionColumn, region_table
from regionslam_env.registration import ENVIRONMENTS
from regionslam_env.tasks.metrics import METRICS
from regionslam_env.tasks.rewards import ExploreRewardConfig, MissionRewardConfig, RewardConfig
from regionslam_env.worlds.format import save_world
from tests.floors import two_rooms
from tests.worlds.importers.examples import DATA

IDS = tuple(ENVIRONMENTS)
FLOOR = two_rooms()
OFFICE, KITCHEN = (3.0, 2.0, 0.0), (9.0, 2.0, 0.0)

compiled_only = pytest.mark.compiled


def make(env_class=GoToEnv, **kwargs):
    """Return an environment on a floor of two rooms."""
    return env_class(**({"world": FLOOR} | kwargs))


@pytest.fixture(scope="module")
def floor(tmp_path_factory):
    """Path of the two rooms, for what takes plain data alone."""
    path = tmp_path_factory.mktemp("worlds") / "rooms.geojson"
    save_world(FLOOR, path)
    return str(path)


def actions(env, n, seed=0):
    """Return actions that mostly drive forward, none of which declares."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(-1, 1, (n, env.action_space.shape[0])).astype(np.float32)
    drawn[:, 0] = np.abs(drawn[:, 0])
    if drawn.shape[1] == 3:
        drawn[:, 2] = -1
    return drawn


def rollout(env, n, action_seed=0):
    """Step on and return everything that came back."""
    return [env.step(action) for action in actions(env, n, action_seed)]


def whole(env, n):
    """Step on until the episode ends, at most n times, and return everything that came back."""
    results = []
    for action in actions(env, n):
        results.append(env.step(action))
        if results[-1][2] or results[-1][3]:
            break
    return results


def equal(a, b):
    """Whether two results are bit-identical, whatever they are made of."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(equal(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(equal, a, b))
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    return type(a) is type(b) and a == b


@pytest.fixture(scope="module")
def env():
    return make()


@pytest.mark.parametrize("env_id", IDS)
def test_gymnasium_has_nothing_to_complain_about(env_id, floor):
    env = gymnasium.make(env_id, world=floor, max_steps=50).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env)


@pytest.mark.parametrize("env_id", IDS)
def test_stable_baselines_has_nothing_to_complain_about(env_id, floor):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(gymnasium.make(env_id, world=floor, max_steps=50).unwrapped)


@pytest.mark.parametrize("env_id", IDS)
def test_the_spec_is_plain_data(env_id, floor):
    spec = gymnasium.make(env_id, world=floor, noise={"lidar_sigma": 0.1}).spec
    assert gymnasium.envs.registration.EnvSpec.from_json(spec.to_json()).kwargs == spec.kwargs


@pytest.mark.parametrize("env_id", IDS)
def test_an_id_is_what_its_entry_says_and_comes_back_from_json_as_it_was(env_id, floor):
    env = gymnasium.make(env_id, world=floor, max_steps=50)
    copy = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    told = {**ENVIRONMENTS[env_id]["kwargs"], "max_steps": 50}
    assert type(env.unwrapped).__name__ == env_id.split("/")[1].split("-")[0] + "Env"
    assert all(getattr(env.unwrapped, name) == value for name, value in told.items())
    assert equal(env.reset(seed=3), copy.reset(seed=3))
    other = pickle.loads(pickle.dumps(env.unwrapped))
    results = whole(env, 50)
    assert len(results) > 10 and equal(results, whole(copy, 50)) and equal(results, whole(other, 50))
    metrics = [results[-1][4][name] for name in METRICS]
    assert all(value is None or np.isfinite(value) for value in metrics)


@pytest.mark.parametrize("localization", ["slam", "oracle", "odometry"])
def test_same_seed_and_actions_give_identical_everything(localization):
    env, other = make(localization=localization), make(localization=localization)
    for episode_seed in (3, None):  # also the next episode, which goes on without a seed
        assert equal(env.reset(seed=episode_seed), other.reset(seed=episode_seed))
        assert equal(rollout(env, 40), rollout(other, 40))


def test_an_episode_does_not_depend_on_the_one_before(env):
    env.reset(seed=4)
    rollout(env, 40)
    first = env.reset(seed=5), rollout(env, 40)
    assert equal(first, (env.reset(seed=5), rollout(env, 40)))


def test_another_seed_gives_another_episode(env):
    assert not equal(env.reset(seed=1)[0], env.reset(seed=2)[0])


SCRIPT = """
import hashlib, sys, gymnasium, numpy as np
from regionslam_env.registration import ENVIRONMENTS

def values(x):
    if isinstance(x, dict):
        return [v for key in x for v in (key, *values(x[key]))]
    return [x.tobytes() if isinstance(x, np.ndarray) else repr(x)]

def digest(env, n):
    found = hashlib.sha256()
    rng = np.random.default_rng(0)
    for options in (None, {"keep_map": True}):
        results = [env.reset(seed=11 if options is None else None, options=options)]
        for action in rng.uniform(-1, 1, (n, env.action_space.shape[0])).astype(np.float32):
            action[2:] = -1
            results.append(env.step(action))
            if results[-1][2] or results[-1][3]:
                break
        for result in results:
            for value in result:
                found.update(repr(values(value)).encode())
    return found.hexdigest()

digests = [digest(gymnasium.make(name, max_steps=20), 20) for name in ENVIRONMENTS]
worlds = ("apartment", *PLANS)
digests += [digest(gymnasium.make("RegionSLAM/GoTo-v0", world=world, max_steps=20), 20) for world in worlds]
"""
PLANS = [str(DATA / name) for name in ("azure", "floor.yaml")]


@compiled_only
def test_another_process_sees_the_same():
    """Every id, generated and imported worlds; the order of sets and the addresses of objects decide nothing."""
    script = SCRIPT.replace("PLANS", repr(PLANS))
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", script + "print(digests)"],
            env={**os.environ, "PYTHONHASHSEED": hash_seed},
            stdout=subprocess.PIPE,
            text=True,
        )
        for hash_seed in ("1", "2")
    ]
    told = [run.communicate()[0] for run in runs]
    assert [run.returncode for run in runs] == [0, 0]
    assert told[0] == told[1] and len(set(eval(told[0]))) == len(ENVIRONMENTS) + 1 + len(PLANS)


def test_a_pickle_in_the_middle_of_an_episode_goes_on_identically(env):
    env.reset(seed=6)
    rollout(env, 40)
    copy = pickle.loads(pickle.dumps(env))
    assert equal(rollout(env, 40, 1), rollout(copy, 40, 1))
    assert equal(env.reset(), copy.reset())


def test_observations_stay_in_their_space_and_share_no_memory(env):
    observations = [env.reset(seed=8)[0], *(result[0] for result in rollout(env, 40))]
    for observation in observations:
        assert observation in env.observation_space
        assert all(np.isfinite(value).all() for value in observation.values())
    for before, after in pairwise(observations):
        assert not any(np.shares_memory(before[key], after[key]) for key in before)
    assert observations[-1]["regions_mask"].sum() >= 2


def test_the_ladder_shares_world_mission_start_and_sensor_noise():
    envs = [make(localization=rung) for rung in ("slam", "oracle", "odometry")]
    for env in envs:
        env.reset(seed=12)
    assert envs[0].mission == envs[1].mission == envs[2].mission
    for results in zip(*(rollout(env, 30) for env in envs), strict=True):
        for key in ("lidar", "velocity", "goal", "progress"):
            assert equal(results[0][0][key], results[1][0][key]) and equal(results[0][0][key], results[2][0][key])
        assert results[0][1] == results[1][1] == results[2][1]


def test_the_ladder_is_one():
    errors = {}
    for rung in ("oracle", "odometry"):
        env = make(localization=rung, max_steps=80, goal="kitchen", noise="heavy")
        env.reset(seed=12, options={"start": OFFICE})
        errors[rung] = rollout(env, 80)[-1][4]
    assert errors["oracle"]["ape_max"] == pytest.approx(0.0, abs=1e-9) and errors["oracle"]["pose_nees"] is None
    assert errors["odometry"]["ape_max"] > 0.02 and errors["odometry"]["pose_nees"] > 0


def test_dead_reckoning_grows_more_uncertain_with_the_way():
    env = make(localization="odometry")
    env.reset(seed=1)
    traces = [np.trace(result[0]["pose_cov"].reshape(3, 3)) for result in rollout(env, 60)]
    assert traces[-1] > traces[20] > traces[0] >= 0
    assert all(b >= a for a, b in pairwise(traces))


def test_the_pose_is_in_the_map_frame(env):
    observation, _ = env.reset(seed=3)
    assert observation["pose"] == pytest.approx([0, 0, 1, 0], abs=0.2)


def test_the_oracle_observes_the_true_pose():
    env = make(localization="oracle", reveal_truth=True)
    env.reset(seed=3)
    for observation, *_, info in rollout(env, 30):
        x, y, theta = info["truth"]["pose_in_map"]
        assert observation["pose"] == pytest.approx([x, y, np.cos(theta), np.sin(theta)], abs=1e-5)


def test_truth_is_hidden_unless_it_is_asked_for(env):
    _, info = env.reset(seed=0)
    assert set(info) == {"mission"}
    assert set(env.step(np.zeros(2))[4]) == {"reward_terms"}
    revealing = make(reveal_truth=True)
    assert "truth" in revealing.reset(seed=0)[1] and "truth" in revealing.step(np.zeros(2))[4]


@pytest.mark.parametrize("env_id", IDS)
def test_the_reward_is_the_sum_of_its_terms(env_id, floor):
    env = gymnasium.make(env_id, world=floor).unwrapped
    env.reset(seed=2)
    results = whole(env, 20)
    for _, reward, *_, info in results:
        terms = info["reward_terms"]
        assert type(reward) is float and reward == sum(terms.values()) and any(terms.values())
        assert all(type(term) is float and hasattr(env.reward, name) for name, term in terms.items())
    assert all(a[4]["reward_terms"] is not b[4]["reward_terms"] for a, b in pairwise(results))


def test_metrics_come_with_the_last_info_only():
    env = make(max_steps=5)
    env.reset(seed=2)
    *before, last = rollout(env, 5)
    assert all(set(result[4]) == {"reward_terms"} for result in before)
    assert set(last[4]) == {"reward_terms", *METRICS}
    assert last[3] is True and last[2] is False and last[4]["success"] is False
    assert last[4]["false_arrival"] is None and last[0]["progress"].tolist() == [1, 0, 0, 1, 0, 0]
    assert not any(isinstance(v, float) and np.isnan(v) for v in last[4].values() if v is not None)


def test_standing_in_the_goal_for_a_second_succeeds(env):
    env.reset(seed=2, options={"goal": "kitchen", "start": KITCHEN})
    results = [env.step(np.zeros(2)) for _ in range(10)]
    assert [result[2] for result in results] == [False] * 9 + [True]
    info = results[-1][4]
    assert (info["success"], info["spl"], info["soft_spl"], info["path_length"]) == (True, 1.0, 1.0, 0.0)
    assert info["distance_to_goal"] == 0 and info["belief_success"] is True
    assert info["reward_terms"]["success"] == 10


@pytest.mark.parametrize("inside", [True, False])
def test_a_declaration_ends_the_episode(inside):
    env = make(arrival="declare")
    env.reset(seed=2, options={"goal": "kitchen", "start": KITCHEN if inside else OFFICE})
    assert not env.step([0, 0, -1])[2]
    _, reward, terminated, truncated, info = env.step([0, 0, 1])
    assert terminated and not truncated
    assert info["success"] is inside and info["false_arrival"] is not inside
    assert (reward > 0) is inside


def test_no_step_without_a_running_episode():
    env = make(max_steps=1)
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(2))
    env.reset(seed=0)
    env.step(np.zeros(2))
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(2))


def test_goal_and_start_by_hand(env):
    pose = (2.0, 1.0, -0.5)
    _, info = env.reset(seed=1, options={"goal": "kitchen", "start": pose})
    assert info["mission"] == "go to the kitchen" and env.goal == "kitchen"
    assert env.true_pose == pytest.approx(pose)
    assert make(goal="office").reset(seed=4)[1]["mission"] == "go to the office"


def test_a_start_as_far_away_as_wanted():
    env = make(goal="kitchen", start_distance=4.0)
    for seed in range(5):
        env.reset(seed=seed)
        assert env.mission.shortest >= 4


def test_splits_are_disjoint():
    missions = set()
    for split in ("train", "val", "test"):
        env = make(split=split)
        env.reset(seed=0)
        missions.add(env.mission)
    assert len(missions) == 3


def test_types_outside_the_vocabulary_are_observed_as_other():
    env = make(semantic_types=("hallway", "office"), goal="office")
    assert env.semantic_types == ("hallway", "office", "other")
    env.reset(seed=0)
    observation = rollout(env, 10)[-1][0]
    table = region_table(observation)
    assert table.shape == (32, RegionColumn.TYPES + 3)
    types = table[observation["regions_mask"] == 1, RegionColumn.TYPES :]
    assert types.sum(axis=1) == pytest.approx(np.ones(len(types)), abs=1e-5) and (types[:, 2] > 0.5).any()


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"world": "institut"}, "did you mean 'institute'"),
        ({"localization": "orakle"}, "did you mean 'oracle'"),
        ({"env_class": MissionEnv, "mission": "go to the kitchn"}, "did you mean 'kitchen'"),
        ({"env_class": MissionEnv, "mission": "go to the meeting room"}, "unknown goal 'meeting room'"),
        ({"env_class": MissionEnv, "mission": 3}, "mission is 3, expected words such as"),
        ({"env_class": MissionEnv, "n_goals": 0}, "n_goals is 0"),
        ({"goal": ["kitchen"]}, "goal is ['kitchen'], expected a semantic type"),
        (
            {"env_class": ExploreEnv, "goal": "kitchen"},
            "goal is 'kitchen', but RegionSLAM/Explore-v0 is always the same; RegionSLAM/GoTo-v0 takes goal",
        ),
        (
            {"mission": "explore"},
            "mission is 'explore', but RegionSLAM/GoTo-v0 takes goal; RegionSLAM/Mission-v0 takes mission",
        ),
        (
            {"env_class": MissionEnv, "goal": "kitchen"},
            "goal is 'kitchen', but RegionSLAM/Mission-v0 takes mission; RegionSLAM/GoTo-v0 takes goal",
        ),
        ({"localization": None}, "unknown localization None: expected one of 'odometry', 'oracle', 'slam'"),
        ({"robot": {"mass": -1}}, "robot.mass is -1"),
        ({"arrival": "say"}, "did you mean 'stay'? Expected one of 'declare', 'stay'"),
        ({"wrld": "office"}, "did you mean 'world'"),
        ({"start_dist": 3}, "did you mean 'start_distance'"),
        ({"env_class": ExploreEnv, "map_share": 0}, "map_share is 0"),
        ({"env_class": ExploreEnv, "reward": {"edgs": 1}}, "did you mean 'edges'"),
        ({"arrival": "declares"}, "did you mean 'declare'"),
        ({"split": "tests"}, "did you mean 'test'"),
        ({"goal": "kitchn"}, "did you mean 'kitchen'"),
        ({"noise": "hevy"}, "did you mean 'heavy'"),
        ({"noise": {"lidar_sigm": 1}}, "did you mean 'lidar_sigma'"),
        ({"noise": {"odometry": {"distanc": 1}}}, "did you mean 'distance'"),
        ({"reward": "sparce"}, "did you mean 'sparse'"),
        ({"reward": {"succes": 1}}, "did you mean 'success'"),
        ({"robot": {"max_sped": 1}}, "did you mean 'max_speed'"),
        ({"robot": "standart"}, "did you mean 'standard'"),
        ({"sensors": {"n_lidar_ray": 3}}, "did you mean 'n_lidar_rays'"),
        ({"render_mode": "rgb_aray"}, "did you mean 'rgb_array'"),
        ({"max_regions": 0}, "max_regions is 0"),
        ({"max_steps": 1.5}, "max_steps is 1.5"),
        ({"n_particles": 0}, "n_particles is 0"),
        ({"semantic_types": "office"}, "semantic_types is 'office'"),
    ],
)
def test_what_is_unknown_is_told_with_the_nearest_known(kwargs, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        make(**kwargs)


def test_unknown_options_of_reset_are_refused(env):
    with pytest.raises(ValueError, match="did you mean 'start'"):
        env.reset(options={"strat": (0, 0, 0)})


def test_a_start_outside_of_the_world_is_told_as_that(env):
    with pytest.raises(ValueError, match=r"start \(1000, 2\) lies outside, expected x from -?[\d.]+ to [\d.]+ m and y"):
        env.reset(options={"start": (1000, 2, 0)})


def test_noise_by_name_or_dictionary():
    heavy = make(noise="heavy").noise
    assert heavy.regions.sigma_xy == 0.15
    assert make(noise={"regions": {"sigma_xy": 0.3}}).noise.regions.sigma_xy == 0.3
    assert make(reward={"time": -1}).reward.time == -1
    assert make(robot={"max_speed": 0.5}).robot.max_speed == 0.5


def test_the_page_tells_the_spaces_as_they_are(env):
    page = SemanticNavigationEnv.__doc__
    rows = re.findall(r"^\s*\| (\w+) \| (Box|MultiBinary) \| (\([\d, ]+\)) \|", page, re.MULTILINE)
    told = {key: (kind, eval(shape)) for key, kind, shape in rows}
    true = {key: (type(space).__name__, space.shape) for key, space in env.observation_space.items()}
    assert told == true
    assert "`Box(-1, 1, (2,), float32)`" in page and env.action_space == gymnasium.spaces.Box(-1, 1, (2,), np.float32)


def defaults(function):
    """Return the default of every argument that has one, in their order."""
    parameters = inspect.signature(function).parameters.values()
    return {p.name: p.default for p in parameters if p.default is not inspect.Parameter.empty}


@pytest.mark.parametrize("env_class", [SemanticNavigationEnv, GoToEnv, ExploreEnv, MissionEnv])
def test_the_page_tells_every_argument(env_class):
    arguments = re.search(r"## Arguments(.*?)(\n\s*## |$)", env_class.__doc__, re.DOTALL)[1]
    told = dict(re.findall(r"^\s*\| (\w+) \| (.*?) \|", arguments, re.MULTILINE)[1:])
    true = defaults(env_class.__init__)
    assert list(told) == list(true)
    for name, default in told.items():
        assert eval(default.strip("`"), {"SEMANTIC_TYPES": SEMANTIC_TYPES}) == true[name], name


def test_every_common_argument_is_typed_where_the_environments_hand_it_on():
    assert list(CommonArguments.__annotations__) == list(defaults(SemanticNavigationEnv.__init__))


@pytest.mark.parametrize(
    ("env_class", "weights"),
    [(GoToEnv, RewardConfig()), (ExploreEnv, ExploreRewardConfig()), (MissionEnv, MissionRewardConfig())],
)
def test_the_page_tells_every_reward(env_class, weights):
    rewards = re.search(r"## Rewards(.*?)\n\s*## ", env_class.__doc__, re.DOTALL)[1]
    told = {name: float(weight) for name, weight in re.findall(r"^\s*\| (\w+) \| (-?[\d.]+)", rewards, re.MULTILINE)}
    assert told == dataclasses.asdict(weights)


@compiled_only
@pytest.mark.parametrize("env_id", IDS)
def test_the_built_in_floor_by_its_id_alone(env_id):
    env = gymnasium.make(env_id)
    for seed in range(3):
        env.reset(seed=seed)
        results = rollout(env, 30)
        assert all(result[0] in env.observation_space for result in results)
        assert results[-1][0]["regions_mask"].sum() >= 2 and results[-1][0]["links_mask"].any()


def test_a_picture_and_words():
    env = make(render_mode="rgb_array")
    env.reset(seed=0)
    rollout(env, 5)
    frame = env.render()
    assert frame.dtype == np.uint8 and frame.ndim == 3 and frame.shape[2] == 3 and frame.std() > 1
    env = make(render_mode="ansi")
    env.reset(seed=0)
    rollout(env, 10)
    words, *picture = env.render().split("\n")
    assert words.startswith(f"go to the {env.goal}: ")
    assert len(picture) > 2 and any("+" in line for line in picture) and "door" in picture[-1]


@compiled_only
def test_physics_and_filter_run_without_a_renderer():
    code = (
        "import sys, gymnasium; env = gymnasium.make('RegionSLAM/GoTo-v0'); env.reset(seed=0); "
        "env.step(env.action_space.sample()); assert not {'PIL', 'pygame', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_refused_reset_changes_nothing_of_what_follows():
    env, other = make(), make()
    env.reset(seed=3), other.reset(seed=3)
    with pytest.raises(ConfigError):
        env.reset(seed=8, options={"start": (-50, 0, 0)})
    assert equal(rollout(env, 5), rollout(other, 5)) and equal(env.reset(), other.reset())
