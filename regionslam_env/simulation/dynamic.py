"""The robot among people who walk, doors that close and furniture that can be pushed.

Everything moves as the robot does (`physics`): velocities are damped to zero in each substep, so that people go where
their legs take them, and furniture goes on only as long as somebody pushes it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pymunk

from regionslam_env.config import RobotConfig
from regionslam_env.simulation.chipmunk import fast_crowd_push, fast_read
from regionslam_env.simulation.driving import X, Y
from regionslam_env.simulation.engine import NO_ENGINE
from regionslam_env.simulation.movers import Movers
from regionslam_env.simulation.physics import SLOP, Simulation
from regionslam_env.worlds.world import WALL_RADIUS

FIRM = 1000.0
"""Mass of a person over that of the robot: nobody is pushed away."""

ROBOT, PERSON, FURNITURE, FIXED, LINE = (1 << k for k in range(5))
"""Categories of shapes. Furniture meets walls without thickness (LINE): it is built flush with them."""

EVERYTHING = pymunk.ShapeFilter.ALL_MASKS()
CLOSED = pymunk.ShapeFilter(categories=FIXED)
OPEN = pymunk.ShapeFilter(categories=FIXED, mask=0)


class DynamicSimulation(Simulation):
    """A differential-drive robot in a world where other things move.

    Parameters
    ----------
    movers
        What moves; its `Movers.draw` comes before the reset.
    config
        Of the robot.
    """

    def __init__(self, movers: Movers, config: RobotConfig) -> None:
        self.movers = movers
        self._crowd: list[pymunk.Body] = []
        self._bodies: list[pymunk.Body] = []
        super().__init__(movers.fixed_world, config)
        self._margin = math.inf  # somebody may always be near: never without the engine

    def reset(self, x: float, y: float, theta: float) -> None:
        """Put the robot at rest at a pose (m, m, rad), among what stands where the movers say."""
        self._build_space()
        self._connect()
        super().reset(x, y, theta)

    def step(self, speed: float, turn_rate: float) -> None:
        """Let people decide, doors move and everything drive for one environment step, the robot as commanded."""
        movers = self.movers
        x, y = self.state[[X, Y]].tolist()
        for door in movers.step((x, y)):
            self._doors[door].filter = CLOSED if movers.doors.closed[door] else OPEN
        people = movers.people
        wanted = people.records["speed_x"], people.records["speed_y"]
        self._forces[:] = zip(*((FIRM * speed).tolist() for speed in wanted), strict=True)
        super().step(speed, turn_rate)
        if self._bodies:
            places = np.array(self._read())
            people.put(places[: len(self._crowd), :2])
            movers.poses[movers.movable] = places[len(self._crowd) :]
        movers.moved()

    def _build_space(self) -> None:
        """Fill a new space with what there is now."""
        movers, space = self.movers, pymunk.Space()
        space.damping, space.collision_slop = 0.0, SLOP
        ground, world = space.static_body, movers.fixed_world
        fixed = pymunk.ShapeFilter(categories=FIXED, mask=EVERYTHING ^ FURNITURE)
        line = pymunk.ShapeFilter(categories=LINE, mask=FURNITURE)
        shapes: list[pymunk.Shape] = []
        for x0, y0, x1, y1 in world.walls.tolist():
            shapes.append(_filtered(pymunk.Segment(ground, (x0, y0), (x1, y1), WALL_RADIUS), fixed))
            if len(movers.pieces):
                shapes.append(_filtered(pymunk.Segment(ground, (x0, y0), (x1, y1), 0.0), line))
        shapes += [_filtered(pymunk.Poly(ground, polygon.tolist()), CLOSED) for polygon in world.obstacles]
        self._doors = [
            _filtered(pymunk.Segment(ground, (x0, y0), (x1, y1), WALL_RADIUS), CLOSED if closed else OPEN)
            for (x0, y0, x1, y1), closed in zip(movers.doors.segments.tolist(), movers.doors.closed, strict=True)
        ]
        crowd = [self._person(x, y) for x, y in movers.people.places.tolist()]
        furniture = [self._piece(k) for k in np.flatnonzero(movers.movable).tolist()]
        for k in np.flatnonzero(~movers.movable):
            x, y, turn = movers.poses[k]
            place = pymunk.Transform(math.cos(turn), math.sin(turn), -math.sin(turn), math.cos(turn), x, y)
            shapes += [_filtered(pymunk.Poly(ground, p.tolist(), place), CLOSED) for p in movers.pieces[k].polygons]
        self._body = pymunk.Body(self._dt, math.inf)
        footprint = _filtered(pymunk.Circle(self._body, self.config.radius), pymunk.ShapeFilter(categories=ROBOT))
        self._crowd, self._bodies = crowd, [*crowd, *furniture]
        space.add(self._body, footprint, *shapes, *self._doors)
        for body in self._bodies:
            space.add(body, *body.shapes)
        self._space = space

    def _person(self, x: float, y: float) -> pymunk.Body:
        body = pymunk.Body(FIRM * self._dt, math.inf)
        body.position = (x, y)
        _filtered(pymunk.Circle(body, self.movers.people.radius), pymunk.ShapeFilter(categories=PERSON))
        return body

    def _piece(self, k: int) -> pymunk.Body:
        """Return the body of a piece that can be pushed; the robot's mass is one substep, and others in proportion."""
        movers = self.movers
        mass = self._dt * movers.config.furniture_mass / self.config.mass
        polygons = [solid.tolist() for solid in movers.pieces[k].solids]
        areas = [pymunk.Poly(None, polygon).area for polygon in polygons]
        moment = sum(
            pymunk.moment_for_poly(mass * area / sum(areas), polygon)
            for polygon, area in zip(polygons, areas, strict=True)
        )
        body = pymunk.Body(mass, moment)
        x, y, body.angle = movers.poses[k].tolist()
        body.position = (x, y)
        for polygon in polygons:
            _filtered(pymunk.Poly(body, polygon), pymunk.ShapeFilter(categories=FURNITURE))
        return body

    def _connect(self) -> None:
        """Take hold of the engine's own functions; a kernel would push the robot alone."""
        self._engine = NO_ENGINE
        self._forces = [(0.0, 0.0)] * len(self._crowd)
        self._push = fast_crowd_push(self._space, self._body, self._crowd, self._forces)
        self._read = fast_read(self._bodies)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in super().__getstate__().items() if name != "_read"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._connect()


def _filtered(shape: pymunk.Shape, shape_filter: pymunk.ShapeFilter) -> Any:
    """Return a smooth shape that meets what its filter says."""
    shape.filter, shape.friction, shape.elasticity = shape_filter, 0.0, 0.0
    return shape
