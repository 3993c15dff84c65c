"""Driving where nothing is near enough to be touched: the engine's arithmetic without the engine."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.worlds.clearance import Grid, clearance_at
from slam.jit import njit

STEP = 0.15
"""Distance of the nodes of the clearance grid, m; between them a clearance is at most this much too large."""


@njit
def coast(
    grid: tuple[Any, ...],
    margin: float,
    x: float,
    y: float,
    speed_x: float,
    speed_y: float,
    velocities: NDArray[np.float64],
    dt: float,
) -> tuple[bool, float, float, float, float]:
    """Drive for one environment step, if the clearance at the start is at least `margin`.

    Positions and velocities are those of the engine, bit by bit: each substep drives the last velocity, and the next
    one passes through a force on the mass dt.

    Parameters
    ----------
    grid
        The parts of a `Grid` of the robot's clearance.
    margin
        Clearance (m) from which on nothing can be touched.
    x, y, speed_x, speed_y
        Position (m) and velocity (m/s) of the robot, world frame.
    velocities
        Commanded in each substep, shape (substeps, 2), m/s.
    dt
        Duration of a substep, s.

    Returns
    -------
    tuple
        Whether the robot has driven, then its position and velocity.
    """
    if clearance_at(Grid(*grid), x, y) < margin:
        return False, x, y, speed_x, speed_y
    per_mass = 1.0 / dt
    for k in range(len(velocities)):
        x += speed_x * dt
        y += speed_y * dt
        speed_x, speed_y = velocities[k, 0] * per_mass * dt, velocities[k, 1] * per_mass * dt
    return True, x, y, speed_x, speed_y
