"""How accurate is the filter? A tour with the simulated sensors and no agent, many seeds, errors in the map frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
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
from slam import RegionMap, RegionSLAM, SlamConfig
from slam.evaluation.consistency import pose_nees
from slam.evaluation.map_quality import map_quality
from slam.evaluation.trajectory import ape
from slam.rows import Floats
from slam.se2 import between

REGULAR = 1e-6
"""Added to pose variances (m², rad²): a robot that has not moved yet is certain of its pose."""
WARM_UP = 20
"""Steps of a tour that run every kernel once."""


@dataclass(frozen=True)
class Tour:
    """What the filter made of one tour.

    Attributes
    ----------
    estimated, covariances, true
        Of the poses in the map frame, which is the start pose: shapes (T, 3), (T, 3, 3), (T, 3).
    map
        The filter's, after the last step.
    seen
        Ids of the true regions measured often enough to be confirmed.
    """

    estimated: Floats
    covariances: Floats
    true: Floats
    map: RegionMap
    seen: list[str]


@cache
def institute() -> tuple[World, Floats]:
    """Return the world of the tour and its poses, shape (T + 1, 3)."""
    world = load("institute")
    return world, course(world, INSTITUTE_TOUR)


def warm_up() -> None:
    """Compile all that a tour runs."""
    drive(0, steps=WARM_UP)


def drive(
    seed: int,
    n_particles: int = 4,
    noise: str = "standard",
    occlusion: bool = False,
    misclassification: float = 0.0,
    steps: int | None = None,
) -> Tour:
    """Run the filter along the tour of the institute, or its first steps, with unknown correspondence."""
    world, poses = institute()
    poses = poses[: None if steps is None else steps + 1]
    settings = replace(noise_set(noise), misclassification=misclassification)
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
    seen = [r.id for r, n in zip(world.regions, sensor.sightings, strict=True) if n >= config.confirmed_after]
    return Tour(estimated, covariances, true, slam.belief.map, seen)


def tour(
    seed: int,
    n_particles: int = 4,
    noise: str = "standard",
    occlusion: bool = False,
    misclassification: float = 0.0,
) -> dict[str, Any]:
    """Return the figures of one tour.

    Returns
    -------
    dict
        `ape_max`, `ape_rmse`, `ape_end` (m, raw: the map frame is the start pose), `pose_nees` (mean over the course,
        divided by 3), and of the map `regions_seen` (true regions measured often enough to be confirmed),
        `regions_mapped`, `duplicates`, `spurious`, `missed`, `type_accuracy`, `region_iou`, `link_f1`.
    """
    return {"seed": seed, **figures(drive(seed, n_particles, noise, occlusion, misclassification))}


def figures(run: Tour) -> dict[str, Any]:
    """Return the figures of a tour that was driven, as in `tour`."""
    world, poses = institute()
    error = ape(run.estimated, run.true).position
    links = [(link.source, link.target) for link in world.links]
    quality = map_quality(run.map.regions, world.regions, links, run.seen, pose=poses[0])
    covariances = run.covariances + REGULAR * np.eye(3)
    return {
        "ape_max": error.max,
        "ape_rmse": error.rmse,
        "ape_end": error.end,
        "pose_nees": float(np.mean(pose_nees(run.estimated, covariances, run.true))) / 3,
        "regions_seen": len(run.seen),
        "regions_mapped": len(run.map.regions),
        "duplicates": len(quality.duplicates),
        "spurious": len(quality.spurious),
        "missed": len(quality.missed),
        "type_accuracy": quality.type_accuracy,
        "region_iou": quality.iou,
        "link_f1": quality.link_f1,
        "containment_f1": quality.containment_f1,
    }
