"""One step of the robot in one compiled call: without the engine where nothing can be touched, else with it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.exact import hypot, principal
from regionslam_env.simulation.engine import Engine, push, put, read
from regionslam_env.simulation.robot import Drive, roll, wheels
from regionslam_env.worlds.clearance import Grid, clearance_at
from slam.jit import njit

STEP = 0.15
"""Distance of the nodes of the clearance grid, m; between them a clearance is at most this much too large."""

HELD_BACK = 1e-6
"""Difference of the way driven and the way commanded that counts as a collision, m."""

X, Y, THETA, SPEED_X, SPEED_Y, AHEAD, LEFT, RIGHT, LENGTH, COLLIDED, IN_ENGINE = range(11)
"""State of a robot: pose and velocity (world frame; m, rad, m/s), heading after the velocity that is commanded but not
yet driven, speeds of the wheels (m/s), metres driven; whether something held it back in the last step, and whether the
engine knows where it is."""

STATE = 11

Floats = NDArray[np.float64]


@njit
def drive(
    state: Floats,
    robot: tuple[float, ...],
    speed: float,
    turn_rate: float,
    grid: tuple[Any, ...],
    margin: float,
    engine: Engine,
    velocities: Floats,
) -> bool:
    """Drive for one environment step towards a command.

    Parameters
    ----------
    state
        Of the robot; updated.
    robot
        The parts of `Drive`.
    speed, turn_rate
        The command, m/s and rad/s.
    grid
        The parts of a `Grid` of the robot's clearance.
    margin
        Clearance (m) from which on nothing can be touched.
    engine
        That of the world.
    velocities
        Written: of every substep, shape (substeps, 2), m/s.

    Returns
    -------
    bool
        Whether the robot has driven. Without an engine it has not where something is near: only heading and wheels are
        new then.
    """
    moves = Drive(*robot)
    left, right = wheels(moves, speed, turn_rate)
    state[LEFT], state[RIGHT], state[AHEAD] = roll(
        moves, state[LEFT], state[RIGHT], left, right, state[AHEAD], velocities
    )
    turning = (state[RIGHT] - state[LEFT]) / (2 * moves.half_base)
    state[THETA] = principal(state[AHEAD] - turning * moves.dt)
    if clearance_at(Grid(*grid), state[X], state[Y]) >= margin:
        coast(state, velocities, moves.dt)
        return True
    if len(engine) > 0:
        touch(state, velocities, moves.dt, engine)
        return True
    return False


@njit
def coast(state: Floats, velocities: Floats, dt: float) -> None:
    """Drive velocities (m/s), one for each substep of a duration (s), where nothing is near.

    Positions and velocities are those of the engine, bit by bit: each substep drives the last velocity, and the next
    one passes through a force on the mass dt.
    """
    x, y, speed_x, speed_y = state[X], state[Y], state[SPEED_X], state[SPEED_Y]
    per_mass = 1.0 / dt
    for k in range(len(velocities)):
        x += speed_x * dt
        y += speed_y * dt
        speed_x, speed_y = velocities[k, 0] * per_mass * dt, velocities[k, 1] * per_mass * dt
    state[COLLIDED] = state[IN_ENGINE] = 0.0
    arrive(state, x, y, speed_x, speed_y)


@njit
def touch(state: Floats, velocities: Floats, dt: float, engine: Engine) -> None:
    """Drive velocities in the engine, and see whether something cuts them."""
    if state[IN_ENGINE] == 0.0:
        put(engine, state[X], state[Y], state[SPEED_X], state[SPEED_Y])
    for k in range(len(velocities)):  # forces are velocities: the body's mass is dt
        push(engine, velocities[k, 0], velocities[k, 1], dt)
    x, y, speed_x, speed_y = read(engine)
    compare(state, velocities, dt, x, y, speed_x, speed_y)


@njit
def compare(state: Floats, velocities: Floats, dt: float, x: float, y: float, speed_x: float, speed_y: float) -> None:
    """Take over where the engine has brought the robot, and note whether that is where the velocities take it."""
    way_x, way_y, last_x, last_y = 0.0, 0.0, state[SPEED_X], state[SPEED_Y]
    for k in range(len(velocities)):
        way_x, way_y, last_x, last_y = way_x + last_x, way_y + last_y, velocities[k, 0], velocities[k, 1]
    off = abs(x - state[X] - way_x * dt) + abs(y - state[Y] - way_y * dt)
    cut = abs(speed_x - last_x) + abs(speed_y - last_y)
    state[COLLIDED], state[IN_ENGINE] = off + cut * dt > HELD_BACK, 1.0
    arrive(state, x, y, speed_x, speed_y)


@njit
def arrive(state: Floats, x: float, y: float, speed_x: float, speed_y: float) -> None:
    """Take over the position (m) and velocity (m/s) at the end of a step."""
    state[LENGTH] += hypot(x - state[X], y - state[Y])
    state[X], state[Y], state[SPEED_X], state[SPEED_Y] = x, y, speed_x, speed_y
