"""A lidar: distances to walls and obstacles all around."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import NoiseConfig, SensorConfig
from regionslam_env.geometry import NearbyIndex, cast, ray_angles, ray_directions, segment_boxes
from regionslam_env.sensors.normals import Normals
from regionslam_env.simulation.movers import Movers
from regionslam_env.worlds.world import WorldArrays
from slam.jit import lean

Floats = NDArray[np.float64]

_SCANS = 32  # of which normal numbers are drawn at a time


class Lidar:
    """Casts rays against walls and obstacles, and what moves among them, with noise on what they hit.

    Parameters
    ----------
    config
        Number of rays and range.
    noise
        Standard deviation of a ray.
    arrays
        Of the world, without what moves.
    rng
        The sensor's own generator.
    movers
        What moves.

    Attributes
    ----------
    angles
        Of the rays in the robot's frame, ascending from -pi (straight back), rad.
    ranges
        Distance along every ray in the last measurement, shape (n,), m.
    normals
        The noise to come.
    """

    def __init__(
        self,
        config: SensorConfig,
        noise: NoiseConfig,
        arrays: WorldArrays,
        rng: np.random.Generator,
        movers: Movers | None = None,
    ) -> None:
        self._range, self._sigma = config.lidar_range, noise.lidar_sigma
        self.angles = ray_angles(config.n_lidar_rays)
        self.ranges = np.zeros(config.n_lidar_rays)
        self.normals = Normals(_SCANS * config.n_lidar_rays)
        self.normals.begin(rng)
        self._directions = ray_directions(config.n_lidar_rays)
        self._segments, self._nearby = _fixed_segments(arrays, self._range)
        self._movers, self._fixed = movers, len(self._segments)
        if movers is not None:
            self._segments = np.concatenate([self._segments, movers.segments])

    def reset(self, rng: np.random.Generator) -> None:
        """Start a new episode with a generator of its own."""
        self.normals.begin(rng)

    def measure(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distance along every ray from a pose, shape (n,), m: the range where there is nothing."""
        x, y, theta = pose.tolist()
        normals = self.normals.take(len(self.angles))
        scan_ranges(
            x,
            y,
            theta,
            self._range,
            self._directions,
            self._segments,
            self._near(x, y),
            normals,
            self._sigma,
            self.ranges,
        )
        return self.ranges.copy()

    @property
    def settings(self) -> tuple[float, float, Floats]:
        """Range (m), standard deviation (m) and directions of the rays, as kernels take them."""
        return self._range, self._sigma, self._directions

    @property
    def surroundings(self) -> tuple[NDArray[Any], ...]:
        """Segments of the world, and the lists of those that are near, as kernels take them."""
        return (self._segments, *self._nearby.cells)

    def _near(self, x: float, y: float) -> NDArray[np.int64]:
        """Return the indices of the segments that may be within reach, after a look at what has moved."""
        nearby, movers = self._nearby.near(x, y), self._movers
        if movers is None:
            return nearby
        self._segments[self._fixed :] = movers.segments
        return np.concatenate((nearby, self._fixed + movers.present))


@lru_cache(maxsize=8)
def _fixed_segments(arrays: WorldArrays, reach: float) -> tuple[Floats, NearbyIndex]:
    """Return walls and sides of obstacles, and which are near where; all lidars in a world share them."""
    segments = np.concatenate([arrays.walls, arrays.obstacles])
    return segments, NearbyIndex(segment_boxes(segments), reach)


@lean
def scan_ranges(
    x: float,
    y: float,
    theta: float,
    reach: float,
    directions: Floats,
    segments: Floats,
    nearby: NDArray[np.int64],
    normals: Floats,
    sigma: float,
    ranges: Floats,
) -> None:
    """Write noisy distances; for the arguments see `cast` and `blur`."""
    cast(x, y, theta, reach, directions, segments, nearby, ranges)
    if sigma > 0:
        blur(ranges, normals, sigma, reach)


@lean
def blur(ranges: Floats, normals: Floats, sigma: float, reach: float) -> None:
    """Add noise of standard deviation `sigma` to every distance below `reach`, within [0, reach]."""
    for k in range(ranges.shape[0]):
        if ranges[k] < reach:
            ranges[k] = min(max(ranges[k] + sigma * normals[k], 0.0), reach)
