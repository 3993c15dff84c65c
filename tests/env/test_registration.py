import subprocess
import sys

import gymnasium
import numpy as np
import pytest

import regionslam_env
from regionslam_env.registration import ENVIRONMENTS, register_envs
from regionslam_env.tasks.metrics import METRICS
from regionslam_env.worlds.format import save_world
from tests.floors import two_rooms


@pytest.fixture(scope="module")
def floor(tmp_path_factory):
    path = tmp_path_factory.mktemp("worlds") / "rooms.geojson"
    save_world(two_rooms(), path)
    return str(path)


def python(code):
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True
    ).stdout


def test_importing_the_package_registers_and_loads_nothing_heavy():
    code = (
        "import sys, regionslam_env, gymnasium; "
        "print(sorted(i for i in gymnasium.registry if i.startswith('RegionSLAM/'))); "
        "print({'numba', 'pymunk', 'PIL', 'shapely'} & set(sys.modules))"
    )
    assert python(code) == f"{sorted(ENVIRONMENTS)}\nset()\n"


def test_registering_twice_is_harmless():
    before = dict(gymnasium.registry)
    register_envs()
    assert gymnasium.registry == before


def test_every_public_name_is_there():
    for name in regionslam_env.__all__:
        assert getattr(regionslam_env, name) is not None
    assert set(regionslam_env.__all__) <= set(dir(regionslam_env))
    with pytest.raises(AttributeError, match="no attribute 'Nonsense'"):
        regionslam_env.Nonsense  # noqa: B018


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vector_environments_hand_on_the_metrics(mode, floor):
    envs = gymnasium.make_vec("RegionSLAM/GoTo-v0", num_envs=2, vectorization_mode=mode, world=floor, max_steps=3)
    try:
        observations, _ = envs.reset(seed=[1, 2])
        assert observations["regions"].shape == (2, *envs.single_observation_space["regions"].shape)
        for _ in range(3):
            _, _, _, truncated, infos = envs.step(np.zeros((2, 2), np.float32))
        assert truncated.tolist() == [True, True]
        assert set(METRICS) <= set(infos)
        assert infos["spl"].tolist() == [0.0, 0.0] and infos["false_arrival"].tolist() == [None, None]
    finally:
        envs.close()
