import dataclasses

import numba
import numpy as np
import pytest

from regionslam_env.config import NOISE_SETS, NoiseConfig, SensorConfig
from regionslam_env.sensors.region_sensor import RegionSensor
from slam.measurement import MeasurementNoise
from tests.floors import bent_hallway, single_room, two_rooms
from tests.sensors.reading import find, kinds, look, sensor

COUNT = 400 if numba.config.DISABLE_JIT else 8000
POSE = np.array([1.0, 0.5, 0.2])


def samples(eye, kind, pose, fields, count=COUNT):
    records = [find(eye.measure(np.array(pose)), kind) for _ in range(count)]
    return np.array([[field(record) for field in fields] for record in records])


def assert_independent(values, means, variances):
    """Compare samples with independent normals: five standard errors of every mean, variance and correlation."""
    n = len(values)
    deviations = (values - means) / np.sqrt(variances)
    assert np.abs(deviations.mean(axis=0)).max() < 5 / np.sqrt(n)
    assert np.abs(deviations.var(axis=0) - 1).max() < 5 * np.sqrt(2 / n)
    correlations = np.corrcoef(deviations.T) - np.eye(len(means))
    assert np.abs(correlations).max() < 5 / np.sqrt(n)


def test_simulated_covariances_are_12_tenths_of_the_told():
    eye = sensor(single_room(6, 0.8), NOISE_SETS["standard"])
    fields = [lambda z, name=name: z[name] for name in ("x", "y", "w", "h", "phi")]
    exact = find(look(single_room(6, 0.8), (1, 0.1, 0.2)), "office")
    told = [exact.cov_xy[0, 0], exact.cov_xy[1, 1], exact.cov_wh[0, 0], exact.cov_wh[1, 1], exact.var_phi]
    assert told == pytest.approx([0.01, 0.01, 0.0225, 0.0225 * 0.64, 0.0009])
    values = samples(eye, "office", (1, 0.1, 0.2), fields)
    assert_independent(values, [exact.x, exact.y, 6, 0.8, -0.2], 1.2 * np.array(told))


def test_noise_of_subrectangles():
    eye = sensor(bent_hallway(), NOISE_SETS["standard"])
    fields = [lambda z: z.sub_w[1], lambda z: z.sub_h[1], lambda z: z.sub_y[1], lambda z: z.w, lambda z: z.y]
    values = samples(eye, "hallway", (7, 0, 0), fields)
    assert_independent(values, [2, 6, 2, 6, 0], 1.2 * np.array([0.0225, 0.0225, 0.01, 0.0225, 0.01]))


def test_the_factor_and_the_told_noise_can_be_set():
    noise = NoiseConfig(regions=MeasurementNoise(0.2, 0.1, 0.05), simulated_factor=1.0)
    values = samples(sensor(single_room(), noise), "office", (0, 0, 0), [lambda z: z.x, lambda z: z.w, lambda z: z.phi])
    assert_independent(values, [0, 6, 0], [0.04, 0.01, 0.0025])


def test_sizes_stay_above_zero_whatever_the_noise():
    noise = NoiseConfig(regions=MeasurementNoise(0.1, 5.0, 0.03))
    for room in (single_room(), bent_hallway(), two_rooms()):
        eye = sensor(room, noise)
        for _ in range(100):
            for z in eye.measure(np.array([1.0, 0.5, 0.0])).records:
                assert z.w > 0
                assert z.h > 0
                assert np.all(z.sub_w[:2][[z.edges[2] == 2, z.edges[3] == 2]] > 0)


def test_noisy_headings_are_canonical_and_turn_the_row_with_them():
    eye = sensor(bent_hallway(), NOISE_SETS["standard"])
    sides = []
    for _ in range(200):
        z = find(eye.measure(np.array([7.0, 0.0, np.pi / 2])), "hallway")
        assert -np.pi / 2 < z.phi <= np.pi / 2
        right = z.edges[3] == 2
        # The arm leads off ahead of the robot, whichever end of the row it is called.
        assert z.sub_y[int(right)] == pytest.approx(2 if right else -2, abs=0.7)
        assert (z.phi < 0) == right
        sides.append(right)
    assert 50 < sum(sides) < 150


def test_same_seed_same_scans():
    noise = dataclasses.replace(NoiseConfig(), misses=0.2, misclassification=0.3, false_positives=0.5)
    first, second, other = (sensor(two_rooms(), noise, seed=seed) for seed in (1, 1, 2))
    for x in np.linspace(1, 11, 15):
        scans = [eye.measure(np.array([x, 2.0, 0.4])) for eye in (first, second, other)]
        for name in ("records", "links", "view"):
            assert np.array_equal(getattr(scans[0], name), getattr(scans[1], name))
        assert not np.array_equal(scans[0].records, scans[2].records)


def test_a_reset_starts_the_episode_anew():
    eye = sensor(two_rooms(), NOISE_SETS["standard"])
    pose = np.array([5.0, 2, 0])
    eye.reset(np.random.default_rng(5))
    first = [eye.measure(pose).records for _ in range(3)]
    eye.reset(np.random.default_rng(5))
    assert all(np.array_equal(eye.measure(pose).records, records) for records in first)


def test_noise_goes_on_after_many_scans():
    eye = sensor(single_room(), NOISE_SETS["standard"], n_view_rays=24)
    seen = {float(eye.measure(POSE).records[0].x) for _ in range(1000)}  # more than one block of numbers
    assert len(seen) == 1000


def test_no_noise_without_noise():
    eye = sensor(single_room())
    assert eye.measure(POSE).records[0] == eye.measure(POSE).records[0]


def test_every_region_can_be_missed():
    eye = sensor(two_rooms(), dataclasses.replace(NOISE_SETS["none"], misses=0.25), n_view_rays=72)
    scans = [eye.measure(np.array([5.0, 2, 0])) for _ in range(400)]
    assert np.mean([len(scan) for scan in scans]) == pytest.approx(3 * 0.75, abs=0.2)
    for scan in scans:
        names = kinds(scan)
        assert len(scan.links) == (2 if "door" in names else 0) * (len(names) - 1)
        for link in scan.links:
            assert "door" in {scan.types[scan.records[k].type] for k in (link.source, link.target)}


def test_types_can_be_wrong():
    eye = sensor(two_rooms(), dataclasses.replace(NOISE_SETS["none"], misclassification=1.0))
    exact = [z.type for z in look(two_rooms(), (5, 2, 0)).records]
    told = np.array([eye.measure(np.array([5.0, 2, 0])).records["type"] for _ in range(100)])
    assert not np.any(told == exact)
    assert {len(set(column)) for column in told.T} == {2}  # either of the other two


def test_regions_can_be_invented():
    noise = dataclasses.replace(NOISE_SETS["none"], false_positives=0.5)
    eye = sensor(single_room(), noise)
    scans = [eye.measure(POSE) for _ in range(400)]
    invented = [z for scan in scans for z in scan.records[1:]]
    assert len(invented) / 400 == pytest.approx(0.5, abs=0.12)
    assert all(z.w > 0 and z.h > 0 and np.hypot(z.x, z.y) < 8 and z.cov_wh[0, 0] > 0 for z in invented)


def test_nothing_is_invented_in_a_world_without_types():
    empty = type(single_room())("empty", (), np.zeros((0, 4)))
    noise = NoiseConfig(false_positives=5.0)
    eye = RegionSensor(SensorConfig(), noise, empty.arrays, np.random.default_rng(0))
    assert len(eye.measure(POSE)) == 0
