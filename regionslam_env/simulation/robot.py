"""The drive of the robot: two wheels with limits of speed and acceleration."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import RobotConfig
from slam.jit import njit


class DifferentialDrive:
    """Wheel speeds that follow a command as fast as the motors allow.

    Attributes
    ----------
    left, right
        Speeds of the wheels now, m/s.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._half_base = config.wheel_base / 2
        self._max_speed = config.max_speed
        self._max_turn_rate = config.max_turn_rate
        self._dt = config.step / config.substeps
        self._max_change = config.max_acceleration * self._dt
        self._velocities = np.zeros((config.substeps, 2))
        self.left = 0.0
        self.right = 0.0

    def reset(self) -> None:
        """Stop both wheels at once."""
        self.left = self.right = 0.0

    def wheels(self, speed: float, turn_rate: float) -> tuple[float, float]:
        """Return the wheel speeds (left, right) in m/s for a command in m/s and rad/s, cut to what the robot can do.

        A wheel that would turn too fast slows both, so that the robot keeps to its curve.

        Raises
        ------
        ValueError
            For a command that is not finite.
        """
        if not (math.isfinite(speed) and math.isfinite(turn_rate)):
            raise ValueError(f"the command is {speed} m/s and {turn_rate} rad/s, expected finite numbers")
        speed = min(max(speed, -self._max_speed), self._max_speed)
        turn = min(max(turn_rate, -self._max_turn_rate), self._max_turn_rate) * self._half_base
        fastest = abs(speed) + abs(turn)
        if fastest > self._max_speed:
            speed, turn = speed * self._max_speed / fastest, turn * self._max_speed / fastest
        return speed - turn, speed + turn

    def follow(self, speed: float, turn_rate: float, theta: float) -> tuple[NDArray[np.float64], float]:
        """Bring the wheels towards a command (m/s, rad/s) for one environment step.

        Parameters
        ----------
        speed, turn_rate
            The command.
        theta
            Heading at the start, rad.

        Returns
        -------
        velocities
            Of the robot in each physics step, world frame, shape (substeps, 2), m/s; valid until the next call.
        theta
            Heading at the end.
        """
        left, right = self.wheels(speed, turn_rate)
        self.left, self.right, theta = roll(
            self.left, self.right, left, right, self._max_change, self._half_base, theta, self._dt, self._velocities
        )
        return self._velocities, theta

    @property
    def turn_rate(self) -> float:
        """Turn rate now, rad/s."""
        return (self.right - self.left) / (2 * self._half_base)


@njit
def roll(
    left: float,
    right: float,
    left_goal: float,
    right_goal: float,
    max_change: float,
    half_base: float,
    theta: float,
    dt: float,
    velocities: NDArray[np.float64],
) -> tuple[float, float, float]:
    """Write the velocity (m/s, world frame) of every physics step; return wheel speeds and heading at the end.

    Within a physics step the robot drives the chord of its arc: along the heading in the middle of the step.
    """
    for k in range(velocities.shape[0]):
        left += min(max(left_goal - left, -max_change), max_change)
        right += min(max(right_goal - right, -max_change), max_change)
        speed = (left + right) / 2
        half_turn = (right - left) / (2 * half_base) * dt / 2
        velocities[k, 0] = speed * math.cos(theta + half_turn)
        velocities[k, 1] = speed * math.sin(theta + half_turn)
        theta += 2 * half_turn
    return left, right, theta
