"""The robot's body among walls and furniture, in pymunk.

A velocity that is written into a body before each step replaces the one the contacts have just allowed, and the robot
drives through walls. Here the wheels push: the space damps every velocity to zero, and each step's force alone brings
it to what the wheels command, after the positions have moved and before the contacts are solved. So a contact has the
last word. Where nothing is near, the engine is left out.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import pymunk
from numpy.typing import NDArray

from regionslam_env.config import RobotConfig
from regionslam_env.exact import principal
from regionslam_env.simulation.chipmunk import Push, fast_push
from regionslam_env.simulation.driving import (
    AHEAD,
    COLLIDED,
    IN_ENGINE,
    LEFT,
    LENGTH,
    RIGHT,
    SPEED_X,
    SPEED_Y,
    STATE,
    STEP,
    THETA,
    X,
    Y,
    compare,
    drive,
)
from regionslam_env.simulation.engine import engine_of
from regionslam_env.simulation.robot import drive_of
from regionslam_env.worlds.clearance import clearance_grid
from regionslam_env.worlds.world import WALL_RADIUS, World

SLOP = 0.001  # depth that a contact leaves alone, m
_FAR_AWAY = 1e6  # where the body forgets its contacts, m


class Simulation:
    """A differential-drive robot in a world.

    Speeds reach the position one substep later: a velocity is commanded, then cut by the contacts, then driven.

    Parameters
    ----------
    world
        Walls and obstacles; both hold the robot.
    config
        Of the robot.

    Attributes
    ----------
    state
        Numbers of the robot, by the places that `driving` names.
    """

    def __init__(self, world: World, config: RobotConfig | None = None) -> None:
        self.config = config or RobotConfig()
        self._drive = tuple(drive_of(self.config))
        self._dt = self.config.step / self.config.substeps
        self._space, self._body = _build(world, self.config.radius, self._dt)
        self._connect()
        # Whoever is that far from everything touches nothing in this step, and the engine has forgotten the last touch.
        forgotten = (self._space.collision_persistence + 1) * self._dt
        self._margin = self.config.max_speed * (self.config.step + forgotten) + STEP
        self._grid = _clearance(world, self.config.radius)
        self._velocities = np.zeros((self.config.substeps, 2))
        self.state = np.zeros(STATE)
        self.reset(0.0, 0.0, 0.0)

    def _connect(self) -> None:
        """Take hold of the engine: in kernels by its addresses, else by its functions."""
        self._push: Push = fast_push(self._space, self._body)
        self._engine = engine_of(self._space, self._body)

    def reset(self, x: float, y: float, theta: float) -> None:
        """Put the robot at rest at a pose (m, m, rad)."""
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(theta)):
            raise ValueError(f"the robot is put at {(x, y, theta)}, expected finite numbers")
        # Out of all contacts for longer than the engine remembers them, so that no episode depends on the one before.
        self._move(_FAR_AWAY, _FAR_AWAY)
        for _ in range(self._space.collision_persistence + 2):
            self._push(0.0, 0.0, self._dt)
        self._move(float(x), float(y))
        self.state[:] = 0.0
        self.state[X], self.state[Y], self.state[IN_ENGINE] = x, y, True
        self.state[THETA] = self.state[AHEAD] = principal(float(theta))

    def _move(self, x: float, y: float) -> None:
        self._body.position = (x, y)
        self._body.velocity = (0.0, 0.0)
        self._space.reindex_shapes_for_body(self._body)

    def step(self, speed: float, turn_rate: float) -> None:
        """Drive for one environment step towards a commanded speed (m/s) and turn rate (rad/s).

        Raises
        ------
        ValueError
            For a command that is not finite.
        """
        if not (math.isfinite(speed) and math.isfinite(turn_rate)):
            raise ValueError(f"the command is {speed} m/s and {turn_rate} rad/s, expected finite numbers")
        velocities = self._velocities
        if not drive(
            self.state, self._drive, float(speed), float(turn_rate), self._grid, self._margin, self._engine, velocities
        ):
            self.touch()

    def touch(self) -> None:
        """Do what `driving.touch` does, after a `drive` that has not, by Python's way into the engine."""
        body, state, velocities = self._body, self.state, self._velocities
        if not state[IN_ENGINE]:
            body.position, body.velocity = tuple(state[[X, Y]].tolist()), tuple(state[[SPEED_X, SPEED_Y]].tolist())
        for force_x, force_y in velocities.tolist():
            self._push(force_x, force_y, self._dt)
        compare(state, velocities, self._dt, *body.position, *body.velocity)
        # Drops what contacts would still push the body next: hidden in the engine, it would not survive pickling.
        pymunk.Body.update_position(body, 0.0)

    @property
    def pose(self) -> NDArray[np.float64]:
        """True pose x (m), y (m), theta (rad, in [-pi, pi]), a fresh array of shape (3,)."""
        return self.state[: THETA + 1].copy()

    @property
    def settings(self) -> tuple[tuple[float, ...], float]:
        """Parts of the `Drive`, and the clearance (m) from which on nothing can be touched, as kernels take them."""
        return self._drive, self._margin

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """State, velocities, engine, and the grid of clearance with its frame: what a kernel drives with."""
        return self.state, self._velocities, self._engine, self._grid[3], np.array(self._grid[:3])

    @property
    def collided(self) -> bool:
        """Whether a wall or an obstacle held the robot back during the last step."""
        return bool(self.state[COLLIDED])

    @property
    def path_length(self) -> float:
        """Metres driven since the reset."""
        return float(self.state[LENGTH])

    @property
    def wheel_speeds(self) -> tuple[float, float]:
        """Speeds of the left and the right wheel, m/s."""
        return float(self.state[LEFT]), float(self.state[RIGHT])

    @property
    def twist(self) -> NDArray[np.float64]:
        """Speed forwards and to the left (m/s) and turn rate (rad/s) after contacts, a fresh array of shape (3,)."""
        left, right = self.wheel_speeds
        turn_rate = (right - left) / self.config.wheel_base
        # The velocity is that of the substep to come, along the heading half way through it.
        heading = float(self.state[THETA]) + turn_rate * self._dt / 2
        c, s = math.cos(heading), math.sin(heading)
        speed_x, speed_y = self.state[[SPEED_X, SPEED_Y]].tolist()
        return np.array((c * speed_x + s * speed_y, c * speed_y - s * speed_x, turn_rate))

    def __getstate__(self) -> dict[str, Any]:
        """Pickle everything but the pointers into the engine."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_push", "_engine")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._connect()


@lru_cache(maxsize=8)
def _clearance(world: World, radius: float) -> tuple[Any, ...]:
    """Return the parts of the `Grid` of a robot's clearance, which all robots of that radius in a world share."""
    return tuple(clearance_grid(world, radius, STEP, 0.0))


def _build(world: World, radius: float, mass: float) -> tuple[pymunk.Space, pymunk.Body]:
    """Return a space without gravity that holds the world's walls and obstacles, and the robot's round body in it."""
    space = pymunk.Space()
    space.damping = 0.0
    space.collision_slop = SLOP
    ground = space.static_body
    shapes: list[pymunk.Shape] = [
        pymunk.Segment(ground, (x0, y0), (x1, y1), WALL_RADIUS) for x0, y0, x1, y1 in world.walls.tolist()
    ]
    shapes += [pymunk.Poly(ground, polygon.tolist()) for polygon in world.obstacles]
    body = pymunk.Body(mass, math.inf)  # the heading is the wheels' alone: a disc without friction takes no torque
    footprint = pymunk.Circle(body, radius)
    for shape in (*shapes, footprint):
        shape.friction = shape.elasticity = 0.0
    space.add(body, footprint, *shapes)
    return space, body
