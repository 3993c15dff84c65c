"""What the sensors measured along the tour of the institute: the same data for every filter that is to be compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import NoiseConfig, SensorConfig, noise_set
from regionslam_env.sensors.odometry import OdometrySensor
from regionslam_env.sensors.region_sensor import RegionSensor
from regionslam_env.worlds.course import INSTITUTE_TOUR, course
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.world import World
from slam import Odometry, Scan
from slam.rows import Floats
from slam.se2 import between


@dataclass(frozen=True, eq=False)
class Recording:
    """The data of one tour of T steps, and the truth.

    Attributes
    ----------
    world, start
        Where it was, and the first true pose (3,): the map frame lies there.
    moves, scans
        What was measured at every step.
    sources
        For every scan where its measurements come from, `SOURCE`.
    true
        True poses after every step in the map frame, shape (T, 3).
    sightings
        How often each true region was measured, shape (R,).
    noise
        Of the sensors.
    filter_seed
        Left over for a filter.
    """

    world: World
    start: Floats
    moves: list[Odometry]
    scans: list[Scan]
    sources: list[NDArray[np.void]]
    true: Floats
    sightings: NDArray[np.int64]
    noise: NoiseConfig
    filter_seed: np.random.SeedSequence


@cache
def institute() -> tuple[World, Floats]:
    """Return the world of the tour and its poses, shape (T + 1, 3)."""
    world = load("institute")
    return world, course(world, INSTITUTE_TOUR)


def record(
    seed: int,
    noise: str = "standard",
    occlusion: bool = False,
    misclassification: float = 0.0,
    calibrated: bool = False,
    steps: int | None = None,
) -> Recording:
    """Measure along the tour, or its first steps.

    Parameters
    ----------
    calibrated
        Simulate the noise that the filter is told, and not a larger one.
    """
    world, poses = institute()
    poses = poses[: None if steps is None else steps + 1]
    settings = replace(noise_set(noise), misclassification=misclassification)
    if calibrated:
        settings = replace(settings, simulated_factor=1.0, odometry_factor=1.0)
    odometry_seed, region_seed, filter_seed = np.random.SeedSequence(seed).spawn(3)
    odometer = OdometrySensor(settings, np.random.default_rng(odometry_seed))
    sensor = RegionSensor(SensorConfig(occlusion=occlusion), settings, world.arrays, np.random.default_rng(region_seed))
    moves, scans, sources = [], [], []
    for before, after in pairwise(poses):
        moves.append(odometer.measure(before, after))
        scans.append(sensor.measure(after))
        sources.append(sensor.sources)
    true = between(poses[0], poses[1:])
    return Recording(world, poses[0], moves, scans, sources, true, sensor.sightings, settings, filter_seed)
