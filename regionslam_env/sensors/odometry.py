"""Odometry: the robot's motion since the last step, with drift."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import NoiseConfig
from slam.motion import Odometry


class OdometrySensor:
    """Measures the motion between two true poses.

    The distance has a variance that grows with the metres driven, the rotation one that grows with the metres driven
    and with the radians turned; a robot that stands still measures exactly nothing.

    Parameters
    ----------
    noise
        Told variances, and by what factor the simulated ones differ.
    rng
        The sensor's own generator.
    """

    def __init__(self, noise: NoiseConfig, rng: np.random.Generator) -> None:
        told, factor = noise.odometry, noise.odometry_factor
        self._distance = told.distance * factor
        self._heading_per_metre = told.heading_per_metre * factor
        self._heading_per_radian = told.heading_per_radian * factor
        self._rng = rng

    def reset(self, rng: np.random.Generator) -> None:
        """Start a new episode with a generator of its own."""
        self._rng = rng

    def measure(self, before: NDArray[np.float64], after: NDArray[np.float64]) -> Odometry:
        """Return the measured motion from pose `before` to pose `after`, each x (m), y (m), theta (rad), shape (3,)."""
        x, y, theta = before.tolist()
        x1, y1, theta1 = after.tolist()
        c, s = math.cos(theta), math.sin(theta)
        forward, left = c * (x1 - x) + s * (y1 - y), c * (y1 - y) - s * (x1 - x)
        rotation = math.remainder(theta1 - theta, 2 * math.pi)
        metres, radians = math.hypot(forward, left), abs(rotation)
        distance_noise, heading_noise = self._rng.standard_normal(2).tolist()
        forward += math.sqrt(self._distance * metres) * distance_noise
        variance = self._heading_per_metre * metres + self._heading_per_radian * radians
        return Odometry(forward, left, rotation + math.sqrt(variance) * heading_noise)
