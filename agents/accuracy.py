"""How accurate is the filter? A tour with the simulated sensors and no agent, many seeds, errors in the map frame."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

from regionslam_env.config import SensorConfig, noise_set
from regionslam_env.sensors.odometry import OdometrySensor
from regionslam_env.sensors.region_sensor import RegionSensor
from regionslam_env.worlds.course import INSTITUTE_TOUR, course
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.world import World
from slam import RegionSLAM, SlamConfig
from slam.evaluation.consistency import pose_nees
from slam.evaluation.map_quality import map_quality
from slam.evaluation.trajectory import ape
from slam.rows import Floats
from slam.se2 import between

REGULAR = 1e-6
"""Added to pose variances (m², rad²): a robot that has not moved yet is certain of its pose."""


def tour_errors(
    seeds: int, n_particles: int = 4, noise: str = "standard", occlusion: bool = False
) -> Iterator[dict[str, Any]]:
    """Yield for each seed the figures of `tour`, in order."""
    for seed in range(seeds):
        yield tour(seed, n_particles, noise, occlusion)


@cache
def _institute() -> tuple[World, Floats]:
    world = load("institute")
    return world, course(world, INSTITUTE_TOUR)


def tour(seed: int, n_particles: int = 4, noise: str = "standard", occlusion: bool = False) -> dict[str, Any]:
    """Run the filter along the tour of the institute with unknown correspondence.

    Returns
    -------
    dict
        `ape_max`, `ape_rmse`, `ape_end` (m, raw: the map frame is the start pose), `pose_nees` (mean over the course,
        divided by 3), and of the map `regions_seen` (true regions measured often enough to be confirmed),
        `regions_mapped`, `duplicates`, `spurious`, `missed`, `type_accuracy`, `region_iou`, `link_f1`.
    """
    world, poses = _institute()
    settings = noise_set(noise)
    odometry_rng, region_rng, filter_rng = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(3))
    odometer = OdometrySensor(settings, odometry_rng)
    sensor = RegionSensor(SensorConfig(occlusion=occlusion), settings, world.arrays, region_rng)
    config = SlamConfig(n_particles, motion_noise=settings.odometry, measurement_noise=settings.regions)
    slam = RegionSLAM(config, filter_rng)
    estimated, covariances = np.empty((len(poses) - 1, 3)), np.empty((len(poses) - 1, 3, 3))
    for k, (before, after) in enumerate(pairwise(poses)):
        belief = slam.step(odometer.measure(before, after), sensor.measure(after))
        estimated[k], covariances[k] = belief.pose_mean, belief.pose_cov
    true = np.array([between(poses[0], pose) for pose in poses[1:]])
    error = ape(estimated, true).position
    seen = [r.id for r, n in zip(world.regions, sensor.sightings, strict=True) if n >= config.confirmed_after]
    links = [(link.source, link.target) for link in world.links]
    quality = map_quality(slam.belief.map.regions, world.regions, links, seen, pose=poses[0])
    return {
        "seed": seed,
        "ape_max": error.max,
        "ape_rmse": error.rmse,
        "ape_end": error.end,
        "pose_nees": float(np.mean(pose_nees(estimated, covariances + REGULAR * np.eye(3), true))) / 3,
        "regions_seen": len(seen),
        "regions_mapped": len(slam.belief.map.regions),
        "duplicates": len(quality.duplicates),
        "spurious": len(quality.spurious),
        "missed": len(quality.missed),
        "type_accuracy": quality.type_accuracy,
        "region_iou": quality.iou,
        "link_f1": quality.link_f1,
        "containment_f1": quality.containment_f1,
    }
