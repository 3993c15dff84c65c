"""The robot's body among walls and furniture, in pymunk.

A velocity that is written into a body before each step replaces the one the contacts have just allowed, and the robot
drives through walls. Here the wheels push: the space damps every velocity to zero, and each step's force alone brings
it to what the wheels command, after the positions have moved and before the contacts are solved. So a contact has the
last word. Where nothing is near, the engine is left out.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pymunk
from numpy.typing import NDArray

from regionslam_env.config import RobotConfig
from regionslam_env.simulation.chipmunk import Push, fast_push
from regionslam_env.simulation.coasting import STEP, coast
from regionslam_env.simulation.robot import DifferentialDrive
from regionslam_env.worlds.clearance import clearance_grid
from regionslam_env.worlds.world import WALL_RADIUS, World

SLOP = 0.001  # depth that a contact leaves alone, m
_HELD_BACK = 1e-6  # difference of the way driven and the way commanded that counts as a collision, m
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
    collided
        Whether a wall or an obstacle held the robot back during the last step.
    path_length
        Metres driven since the reset.
    """

    def __init__(self, world: World, config: RobotConfig | None = None) -> None:
        self.config = config or RobotConfig()
        self.drive = DifferentialDrive(self.config)
        self._dt = self.config.step / self.config.substeps
        self._space, self._body = _build(world, self.config.radius, self._dt)
        self._push: Push = fast_push(self._space, self._body)
        # Whoever is that far from everything touches nothing in this step, and the engine has forgotten the last touch.
        forgotten = (self._space.collision_persistence + 1) * self._dt
        self._margin = self.config.max_speed * (self.config.step + forgotten) + STEP
        self._grid: tuple[Any, ...] = tuple(clearance_grid(world, self.config.radius, STEP, 0.0))
        self.reset(0.0, 0.0, 0.0)

    def reset(self, x: float, y: float, theta: float) -> None:
        """Put the robot at rest at a pose (m, m, rad)."""
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(theta)):
            raise ValueError(f"the robot is put at {(x, y, theta)}, expected finite numbers")
        # Out of all contacts for longer than the engine remembers them, so that no episode depends on the one before.
        self._move(_FAR_AWAY, _FAR_AWAY)
        for _ in range(self._space.collision_persistence + 2):
            self._push(0.0, 0.0, self._dt)
        self._move(float(x), float(y))
        self._in_engine = True  # whether the engine knows where the robot is
        self._x, self._y, self._theta = float(x), float(y), math.remainder(theta, 2 * math.pi)
        self._ahead = self._theta  # heading after the velocity that is commanded but not yet driven
        self._speed_x = self._speed_y = 0.0
        self.drive.reset()
        self.collided = False
        self.path_length = 0.0

    def _move(self, x: float, y: float) -> None:
        self._body.position = (x, y)
        self._body.velocity = (0.0, 0.0)
        self._space.reindex_shapes_for_body(self._body)

    def step(self, speed: float, turn_rate: float) -> None:
        """Drive for one environment step towards a commanded speed (m/s) and turn rate (rad/s)."""
        velocities, self._ahead = self.drive.follow(speed, turn_rate, self._ahead)
        self._theta = math.remainder(self._ahead - self.drive.turn_rate * self._dt, 2 * math.pi)
        free, x, y, speed_x, speed_y = coast(
            self._grid, self._margin, self._x, self._y, self._speed_x, self._speed_y, velocities, self._dt
        )
        if free:
            self._in_engine = self.collided = False
            self._arrive(x, y, speed_x, speed_y)
        else:
            self._touch(velocities)

    def _touch(self, velocities: NDArray[np.float64]) -> None:
        """Drive these velocities (m/s), one for each substep, in the engine, and see whether something cuts them."""
        if not self._in_engine:
            self._body.position, self._body.velocity = (self._x, self._y), (self._speed_x, self._speed_y)
            self._in_engine = True
        push, dt = self._push, self._dt
        way_x, way_y, last_x, last_y = 0.0, 0.0, self._speed_x, self._speed_y
        for force_x, force_y in velocities.tolist():  # forces are velocities: the body's mass is dt
            way_x, way_y, last_x, last_y = way_x + last_x, way_y + last_y, force_x, force_y
            push(force_x, force_y, dt)
        self._compare(way_x * dt, way_y * dt, last_x, last_y)

    def _compare(self, way_x: float, way_y: float, last_x: float, last_y: float) -> None:
        """Read where the body is, and whether that is where the commanded way (m) and last velocity (m/s) take it."""
        (x, y), (speed_x, speed_y) = self._body.position, self._body.velocity
        dx, dy = x - self._x, y - self._y
        cut = abs(speed_x - last_x) + abs(speed_y - last_y)
        self.collided = abs(dx - way_x) + abs(dy - way_y) + cut * self._dt > _HELD_BACK
        self._arrive(x, y, speed_x, speed_y)
        # Drops what contacts would still push the body next: hidden in the engine, it would not survive pickling.
        pymunk.Body.update_position(self._body, 0.0)

    def _arrive(self, x: float, y: float, speed_x: float, speed_y: float) -> None:
        """Take over the position (m) and velocity (m/s) at the end of a step."""
        self.path_length += math.hypot(x - self._x, y - self._y)
        self._x, self._y, self._speed_x, self._speed_y = x, y, speed_x, speed_y

    @property
    def pose(self) -> NDArray[np.float64]:
        """True pose x (m), y (m), theta (rad, in [-pi, pi]), a fresh array of shape (3,)."""
        return np.array((self._x, self._y, self._theta))

    @property
    def twist(self) -> NDArray[np.float64]:
        """Speed forwards and to the left (m/s) and turn rate (rad/s) after contacts, a fresh array of shape (3,)."""
        # The velocity is that of the substep to come, along the heading half way through it.
        heading = self._theta + self.drive.turn_rate * self._dt / 2
        c, s = math.cos(heading), math.sin(heading)
        forward, lateral = c * self._speed_x + s * self._speed_y, c * self._speed_y - s * self._speed_x
        return np.array((forward, lateral, self.drive.turn_rate))

    def __getstate__(self) -> dict[str, Any]:
        """Pickle everything but the pointers into the engine."""
        return {name: value for name, value in self.__dict__.items() if name != "_push"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._push = fast_push(self._space, self._body)


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
