import math

import numpy as np
import pytest

from regionslam_env.config import NOISE_SETS, NoiseConfig
from regionslam_env.sensors.odometry import OdometrySensor
from slam.motion import MotionNoise, Odometry


def measure(before, after, noise=NOISE_SETS["none"], seed=0):
    return OdometrySensor(noise, np.random.default_rng(seed)).measure(np.array(before, float), np.array(after, float))


def test_motion_is_told_in_the_frame_of_its_start():
    odometry = measure((1, 2, math.pi / 2), (0, 5, math.pi / 2 + 0.4))
    assert (odometry.distance, odometry.lateral, odometry.rotation) == pytest.approx((3, 1, 0.4))


def test_a_turn_over_the_seam_is_short():
    assert measure((0, 0, 3.1), (0, 0, -3.1)).rotation == pytest.approx(2 * math.pi - 6.2)


def test_no_motion_no_noise():
    for seed in range(5):
        assert measure((1, 2, 3), (1, 2, 3), NOISE_SETS["heavy"], seed) == Odometry(0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("after", "variance_of_distance", "variance_of_rotation"),
    [((2, 0, 0), 0.0018, 0.0002), ((0, 0, -1.5), 0.0, 0.00135), ((2, 0, 0.5), 0.0018, 0.0002 + 0.00045)],
)
def test_variances_grow_with_metres_and_radians(after, variance_of_distance, variance_of_rotation):
    sensor = OdometrySensor(NOISE_SETS["standard"], np.random.default_rng(1))
    start, end = np.zeros(3), np.array(after, float)
    readings = [sensor.measure(start, end) for _ in range(4000)]
    distances, rotations = (np.array([getattr(r, name) for r in readings]) for name in ("distance", "rotation"))
    tolerance = 5 * math.sqrt(2 / 4000)
    assert distances.var() == pytest.approx(variance_of_distance, rel=tolerance)
    assert rotations.var() == pytest.approx(variance_of_rotation, rel=tolerance)
    assert distances.mean() == pytest.approx(end[0], abs=5 * math.sqrt(variance_of_distance / 4000) + 1e-12)
    assert rotations.mean() == pytest.approx(end[2], abs=5 * math.sqrt(variance_of_rotation / 4000))


def test_ten_short_steps_drift_as_much_as_a_long_one():
    sensor = OdometrySensor(NoiseConfig(odometry=MotionNoise(0.01, 0.0, 0.0)), np.random.default_rng(2))
    start, end = np.zeros(3), np.array([0.1, 0, 0])
    sums = [sum(sensor.measure(start, end).distance for _ in range(10)) for _ in range(2000)]
    assert np.var(sums) == pytest.approx(0.01, rel=5 * math.sqrt(2 / 2000))


def test_same_seed_same_readings():
    sensor = OdometrySensor(NOISE_SETS["standard"], np.random.default_rng(3))
    first = sensor.measure(np.zeros(3), np.ones(3))
    assert sensor.measure(np.zeros(3), np.ones(3)) != first
    sensor.reset(np.random.default_rng(3))
    assert sensor.measure(np.zeros(3), np.ones(3)) == first
