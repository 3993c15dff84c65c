"""Odometry: the robot's motion since the last step, with drift."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import NoiseConfig
from regionslam_env.exact import hypot, principal
from regionslam_env.sensors.normals import Normals
from slam.jit import njit
from slam.motion import Odometry

Floats = NDArray[np.float64]

DRAWS = 2
"""Normal numbers for one motion."""

_BLOCK = 512  # normal numbers drawn at a time


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

    Attributes
    ----------
    variances
        That are simulated: of the distance per metre driven, of the rotation per metre driven and per radian turned.
    normals
        The noise to come.
    """

    def __init__(self, noise: NoiseConfig, rng: np.random.Generator) -> None:
        told, factor = noise.odometry, noise.odometry_factor
        self.variances = (told.distance * factor, told.heading_per_metre * factor, told.heading_per_radian * factor)
        self.normals = Normals(_BLOCK)
        self.reset(rng)

    def reset(self, rng: np.random.Generator) -> None:
        """Start a new episode with a generator of its own."""
        self.normals.begin(rng)

    def measure(self, before: NDArray[np.float64], after: NDArray[np.float64]) -> Odometry:
        """Return the measured motion from pose `before` to pose `after`, each x (m), y (m), theta (rad), shape (3,)."""
        return Odometry(*measure_motion(before, after, self.normals.take(DRAWS), self.variances))


@njit
def measure_motion(
    before: Floats, after: Floats, normals: Floats, variances: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the motion from pose `before` to pose `after`, forwards, to the left (m) and turn (rad).

    Parameters
    ----------
    before, after
        Poses (x, y, theta), shape (3,).
    normals
        Standard normal numbers, shape (2,).
    variances
        Of the distance per metre driven, of the rotation per metre driven and per radian turned.
    """
    c, s = math.cos(before[2]), math.sin(before[2])
    dx, dy = after[0] - before[0], after[1] - before[1]
    forward, left = c * dx + s * dy, c * dy - s * dx
    rotation = principal(after[2] - before[2])
    metres, radians = hypot(forward, left), abs(rotation)
    forward += math.sqrt(variances[0] * metres) * normals[0]
    variance = variances[1] * metres + variances[2] * radians
    return forward, left, rotation + math.sqrt(variance) * normals[1]
