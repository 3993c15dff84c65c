"""Does the joint posterior know how wrong it is? The tour of the institute with the noise that the filter is told."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from agents.accuracy import institute
from regionslam_env.config import SensorConfig, noise_set
from regionslam_env.sensors.odometry import OdometrySensor
from regionslam_env.sensors.region_sensor import RegionSensor
from slam import RegionSLAM, SlamConfig
from slam.evaluation.consistency import nees_band, pose_nees
from slam.evaluation.map_quality import map_quality
from slam.evaluation.region_consistency import region_nees
from slam.se2 import between

SEEDS, EVERY = 20, 480


def tour(seed: int) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Pose NEES of every step, over 3; region NEES over freedoms every EVERY steps; duplicates, spurious, missed."""
    world, poses = institute()
    noise = dataclasses.replace(noise_set("standard"), simulated_factor=1.0)
    odometry_rng, region_rng = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
    odometer = OdometrySensor(noise, odometry_rng)
    sensor = RegionSensor(SensorConfig(occlusion=False), noise, world.arrays, region_rng)
    config = SlamConfig(1, "joint", motion_noise=noise.odometry, measurement_noise=noise.regions)
    slam = RegionSLAM(config)
    poses_nees, regions_nees = [], []
    rows = {region.id: region.row for region in world.regions}
    for k, (before, after) in enumerate(pairwise(poses), 1):
        belief = slam.step(odometer.measure(before, after), sensor.measure(after))
        cov = belief.pose_cov + 1e-9 * np.eye(3)
        poses_nees.append(float(pose_nees(belief.pose_mean, cov, between(poses[0], after))) / 3)
        if k % EVERY == 0 or k == len(poses) - 1:
            records = {int(record.id): record for record in belief.features}
            quality = map_quality(belief.map.regions, world.regions, pose=poses[0])
            pairs = [region_nees(records[m.mapped], rows[m.true], poses[0]) for m in quality.matches]
            regions_nees.append(sum(value for value, _ in pairs) / sum(freedom for _, freedom in pairs))
    seen = [r.id for r, n in zip(world.regions, sensor.sightings, strict=True) if n >= config.confirmed_after]
    quality = map_quality(belief.map.regions, world.regions, seen=seen, pose=poses[0])
    return (
        np.array(poses_nees),
        np.array(regions_nees),
        [len(ids) for ids in (quality.duplicates, quality.spurious, quality.missed)],
    )


@pytest.mark.slow
@pytest.mark.compiled
def test_the_joint_posterior_is_calibrated() -> None:
    """Errors of one run last: the mean over time is as good as few of its values, so that runs are what is counted."""
    runs = [tour(seed) for seed in range(SEEDS)]
    poses, regions = (np.array([run[k] for run in runs]) for k in range(2))
    low, high = (limit / 3 for limit in nees_band(SEEDS, 3))
    at_times = poses[:, EVERY // 2 :: EVERY].mean(axis=0)
    assert np.mean((low < at_times) & (at_times < high)) >= 0.75
    for of_runs in (poses.mean(axis=1), regions.mean(axis=1), *regions.T):
        # Student's t with 19 degrees of freedom: 2.09.
        assert abs(of_runs.mean() - 1.0) < 2.09 * of_runs.std(ddof=1) / np.sqrt(SEEDS)
    assert not np.any([run[2] for run in runs])
