"""The drive of the robot: two wheels with limits of speed and acceleration."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import RobotConfig
from slam.jit import njit


class Drive(NamedTuple):
    """What the drive can do, as kernels take it."""

    half_base: float  # half the distance of the wheels, m
    max_speed: float  # m/s
    max_turn_rate: float  # rad/s
    max_change: float  # of a wheel's speed in one physics step, m/s
    dt: float  # duration of a physics step, s


def drive_of(config: RobotConfig) -> Drive:
    """Return what the drive of a robot can do."""
    dt = config.step / config.substeps
    return Drive(config.wheel_base / 2, config.max_speed, config.max_turn_rate, config.max_acceleration * dt, dt)


@njit
def wheels(drive: Drive, speed: float, turn_rate: float) -> tuple[float, float]:
    """Return the wheel speeds (left, right) in m/s for a command in m/s and rad/s, cut to what the robot can do.

    A wheel that would turn too fast slows both, so that the robot keeps to its curve.
    """
    speed = min(max(speed, -drive.max_speed), drive.max_speed)
    turn = min(max(turn_rate, -drive.max_turn_rate), drive.max_turn_rate) * drive.half_base
    fastest = abs(speed) + abs(turn)
    if fastest > drive.max_speed:
        speed, turn = speed * drive.max_speed / fastest, turn * drive.max_speed / fastest
    return speed - turn, speed + turn


@njit
def roll(
    drive: Drive,
    left: float,
    right: float,
    left_goal: float,
    right_goal: float,
    theta: float,
    velocities: NDArray[np.float64],
) -> tuple[float, float, float]:
    """Bring the wheels towards their goals, as fast as the motors allow, for one environment step.

    Writes the velocity of the robot in every physics step, world frame, shape (substeps, 2), m/s; returns wheel speeds
    and heading at the end. Within a physics step the robot drives the chord of its arc: along the heading in the middle
    of the step.
    """
    for k in range(velocities.shape[0]):
        left += min(max(left_goal - left, -drive.max_change), drive.max_change)
        right += min(max(right_goal - right, -drive.max_change), drive.max_change)
        speed = (left + right) / 2
        half_turn = (right - left) / (2 * drive.half_base) * drive.dt / 2
        velocities[k, 0] = speed * math.cos(theta + half_turn)
        velocities[k, 1] = speed * math.sin(theta + half_turn)
        theta += 2 * half_turn
    return left, right, theta
