import dataclasses
import math

import numpy as np
import pytest

from regionslam_env.config import NOISE_SETS, NoiseConfig, SensorConfig
from regionslam_env.geometry import ray_angles
from regionslam_env.sensors.lidar import Lidar
from tests import naive
from tests.floors import furnished_room, long_hallway, two_rooms


def lidar(world, noise=NOISE_SETS["none"], seed=0, **config):
    return Lidar(SensorConfig(**config), noise, world.arrays, np.random.default_rng(seed))


def test_distances_in_a_furnished_room():
    ranges = lidar(furnished_room()).measure(np.array([-1.0, 0, 0]))
    assert ranges.shape == (180,)
    assert ranges[90] == pytest.approx(1.5)  # the desk
    assert ranges[0] == pytest.approx(2)
    assert ranges[45] == pytest.approx(2)
    assert ranges[135] == pytest.approx(2)


def test_rays_turn_with_the_robot():
    ranges = lidar(furnished_room()).measure(np.array([-1.0, 0, math.pi]))
    assert ranges[90] == pytest.approx(2)
    assert ranges[0] == pytest.approx(1.5)


def test_the_range_where_there_is_nothing():
    ranges = lidar(long_hallway()).measure(np.array([0.0, 0, 0]))
    assert ranges[90] == ranges[0] == 10
    assert lidar(long_hallway(), lidar_range=3.0).measure(np.array([0.0, 0, 0])).max() == 3


def test_same_as_the_naive_caster():
    world = two_rooms()
    for pose in np.random.default_rng(1).uniform((0.5, 0.5, -3), (11.5, 3.5, 3), (5, 3)):
        expected = naive.cast(pose, ray_angles(90), 10.0, world.walls)
        assert lidar(world, n_lidar_rays=90).measure(pose) == pytest.approx(expected)


def test_noise_is_on_hits_alone_and_within_the_range():
    noise = dataclasses.replace(NoiseConfig(), lidar_sigma=0.5)
    pose = np.array([0.0, 0, 0])
    exact = lidar(long_hallway()).measure(pose)
    eye = lidar(long_hallway(), noise)
    readings = np.array([eye.measure(pose) for _ in range(500)])
    assert np.all(readings[:, exact == 10] == 10)
    assert readings.min() >= 0
    assert readings.max() <= 10
    near = np.abs(exact - 1) < 0.5
    deviations = readings[:, near] - exact[near]
    assert deviations.std() == pytest.approx(0.5, rel=0.05)
    assert deviations.mean() == pytest.approx(0, abs=0.02)


def test_fresh_arrays_and_seeds():
    eye, pose = lidar(two_rooms(), NoiseConfig(), seed=4), np.array([3.0, 2, 0])
    first, second = eye.measure(pose), eye.measure(pose)
    assert not np.shares_memory(first, second)
    assert not np.array_equal(first, second)
    eye.reset(np.random.default_rng(4))
    assert np.array_equal(eye.measure(pose), first)
