"""Everything that moves in a world beside the robot: people, doors that close, furniture that is pushed.

It says what there is and where; the engine (`dynamic`) moves it, and the sensors look at it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from regionslam_env.config import DynamicsConfig, RobotConfig
from regionslam_env.simulation.doors import Doors
from regionslam_env.simulation.furniture import moved_polygons, moved_row, pieces_of, without
from regionslam_env.simulation.people import People
from regionslam_env.worlds.clearance import segment_distance
from regionslam_env.worlds.world import WALL_RADIUS, Region, World, WorldArrays
from slam.jit import njit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DOORWAY = 0.2
"""A door closes only where everybody is this far from touching it, m."""

_SIDES = 12  # of the polygon that a person is to the lidar


@dataclass(frozen=True, eq=False)
class Scene:
    """What can move, at one moment, as plain data.

    Parameters
    ----------
    people
        Poses (x, y, heading) in the world frame, shape (N, 3), m and rad.
    person_radius
        m.
    closed_doors
        Ids of the closed doors.
    door_segments
        Where they are: x0, y0, x1, y1, shape (k, 4), m.
    furniture
        Regions of the furniture that is not part of the fixed world, where it stands now.
    obstacles
        Its polygons, each of shape (k, 2), m.
    """

    people: Floats
    person_radius: float
    closed_doors: tuple[str, ...]
    door_segments: Floats
    furniture: tuple[Region, ...]
    obstacles: tuple[Floats, ...]


class Movers:
    """What moves in one world.

    Parameters
    ----------
    world
        As it was built.
    config
        What moves in it, and how.
    robot
        Its size and the duration of a step.

    Attributes
    ----------
    people, doors
        Who walks about, and every door.
    pieces
        The furniture; none where none is movable.
    movable
        Which pieces can be pushed in this episode, shape (F,).
    poses
        Where the pieces stand: x, y of the centre and how far they are turned, shape (F, 3), m and rad.
    segments
        What the lidar can see: every door, then the sides of furniture and people, shape (M, 4), m; see `present`.
    regions, rows
        Indices of the pieces' regions in `World.regions`, shape (F,), and their `TRUE_REGION` where they stand now.
    """

    def __init__(self, world: World, config: DynamicsConfig, robot: RobotConfig) -> None:
        self.world, self.config, self._robot_radius = world, config, robot.radius
        self.people = People(world, config, robot.step)
        self.doors = Doors(world, config, robot.step)
        self.pieces = pieces_of(world) if config.movable_furniture else ()
        self._built = np.array([(*piece.centre, 0.0) for piece in self.pieces]).reshape(-1, 3)
        self.poses, self.movable = self._built.copy(), np.zeros(len(self.pieces), dtype=bool)
        self._sides, self._owners = self._outlines()
        self.segments = np.concatenate([self.doors.segments, self._sides])
        self.regions = np.array([piece.region for piece in self.pieces], dtype=np.int64)
        self._rows = np.asarray(world.arrays.rows).view(np.ndarray)[self.regions]
        self.rows = self._rows.copy()
        self.moved()

    def begin(self, rng: np.random.Generator, start: tuple[float, float, float], go_on: bool = False) -> None:
        """Draw everything for a robot at a start (m, m, rad); or go on, and only make way for it."""
        if go_on:
            self.people.make_way((*start[:2], self._robot_radius))
            self.moved()
        else:
            self.draw(rng, start[:2])

    def draw(self, rng: np.random.Generator, robot: tuple[float, float]) -> None:
        """Draw everything anew for a robot at a place (m): people, doors that close, furniture that is movable."""
        self.people.draw(rng, robot)
        self.doors.draw(rng)
        movable = rng.permutation(len(self.pieces))[: round(self.config.movable_furniture * len(self.pieces))]
        self.movable[:] = False
        self.movable[movable] = True
        self.poses[:] = self._built
        self.moved()

    def step(self, robot: tuple[float, float]) -> list[int]:
        """Let people decide and doors close and open; return which doors have, for a robot at a place (m)."""
        here = (*robot, self._robot_radius)
        self.people.decide(here, self.doors.segments[self.doors.closed])
        return self.doors.step(lambda door: self._is_free(door, here))

    def blocks(self, x: float, y: float) -> bool:
        """Return whether furniture or a closed door leaves a robot no room at a place (m); people make way for it."""
        footprint = shapely.Point(x, y).buffer(self._robot_radius)
        scene = self.scene
        doors = (shapely.LineString(line.reshape(2, 2)).buffer(WALL_RADIUS) for line in scene.door_segments)
        return any(footprint.intersects(solid) for solid in (*map(shapely.Polygon, scene.obstacles), *doors))

    def moved(self) -> None:
        """Take note of where people and furniture are now."""
        people = self.people.places
        places = np.zeros((len(self.poses) + len(people), 3))
        places[: len(self.poses)], places[len(self.poses) :, :2] = self.poses, people
        place_sides(self._sides, self._owners, places, self.segments[len(self.doors.segments) :])
        place_rows(self._rows, self._built, self.poses, self.rows)

    @property
    def present(self) -> Ints:
        """Indices of the segments in which there is something now: open doors and people who stay away are left out."""
        doors, people = len(self.doors.segments), len(self.people.records)
        last = len(self.segments) - _SIDES * (self.config.people - people)
        return np.concatenate((np.flatnonzero(self.doors.closed), np.arange(doors, last)))

    @cached_property
    def fixed_world(self) -> World:
        """The world without the furniture that may move."""
        return without(self.world, self.pieces)

    @property
    def fixed(self) -> WorldArrays:
        """The same for sensors, but with every region: `regions` of them have to be looked up in `rows`."""
        return replace(self.world.arrays, obstacles=self.fixed_world.obstacle_segments)

    @property
    def true_regions(self) -> tuple[Region, ...]:
        """Every region of the world, furniture where it stands now."""
        regions = list(self.world.regions)
        for piece, pose in zip(self.pieces, self.poses, strict=True):
            region = regions[piece.region]
            regions[piece.region] = replace(region, row=moved_row(region.row, piece, pose))
        return tuple(regions)

    @property
    def scene(self) -> Scene:
        """Where everything is now."""
        people, closed = self.people.records, np.flatnonzero(self.doors.closed)
        regions = self.true_regions
        return Scene(
            people=np.stack([people["x"], people["y"], people["heading"]], axis=1),
            person_radius=self.people.radius,
            closed_doors=tuple(self.world.doors[k].id for k in closed),
            door_segments=self.doors.segments[closed],
            furniture=tuple(regions[k] for k in self.regions),
            obstacles=tuple(
                polygon
                for piece, pose in zip(self.pieces, self.poses, strict=True)
                for polygon in moved_polygons(piece, pose)
            ),
        )

    @property
    def truth(self) -> dict[str, Any]:
        """The same for `info["truth"]`: poses of people and of movable furniture (m, rad), ids of closed doors."""
        scene, ids = self.scene, [self.world.regions[k].id for k in self.regions]
        furniture = {name: pose.copy() for name, pose, can in zip(ids, self.poses, self.movable, strict=True) if can}
        return {"people": scene.people, "closed_doors": scene.closed_doors, "furniture": furniture}

    def _is_free(self, door: int, robot: tuple[float, float, float]) -> bool:
        """Return whether nothing stands in a door that is about to close, or right beside it."""
        line = self.doors.segments[door]
        bodies = [robot, *((x, y, self.people.radius) for x, y in self.people.places.tolist())]
        if any(segment_distance(x, y, line) < radius + WALL_RADIUS + DOORWAY for x, y, radius in bodies):
            return False
        opening = shapely.LineString(line.reshape(2, 2))
        for piece, pose, can in zip(self.pieces, self.poses, self.movable, strict=True):
            if can and segment_distance(pose[0], pose[1], line) < piece.reach + WALL_RADIUS:
                shapes = map(shapely.Polygon, moved_polygons(piece, pose))
                if any(opening.distance(shape) < WALL_RADIUS for shape in shapes):
                    return False
        return True

    def _outlines(self) -> tuple[Floats, Ints]:
        """Return the sides of all pieces, then of all people, about their centres (k, 4), m, and whose they are."""
        angles = 2 * math.pi * np.arange(_SIDES) / _SIDES
        circle = self.people.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        bodies = [piece.polygons for piece in self.pieces] + [(circle,)] * self.config.people
        sides = [np.concatenate([polygon, np.roll(polygon, -1, axis=0)], axis=1) for body in bodies for polygon in body]
        owners = [k for k, body in enumerate(bodies) for polygon in body for _ in polygon]
        return np.concatenate([np.empty((0, 4)), *sides]), np.array(owners, dtype=np.int64)


@njit
def place_sides(sides: Floats, owners: Ints, places: Floats, out: Floats) -> None:
    """Write the sides, given about their owners' centres, where the owners are: x, y (m) and turn (rad), shape (n, 3).

    Sides of owners without a place stay as they are.
    """
    for k in range(len(sides)):
        if owners[k] >= len(places):
            return
        x, y, turn = places[owners[k]]
        c, s = math.cos(turn), math.sin(turn)
        for end in range(0, 4, 2):
            out[k, end] = x + c * sides[k, end] - s * sides[k, end + 1]
            out[k, end + 1] = y + s * sides[k, end] + c * sides[k, end + 1]


@njit
def place_rows(rows: NDArray[np.void], built: Floats, poses: Floats, out: NDArray[np.void]) -> None:
    """Write `TRUE_REGION` rows of furniture where it stands now: built and present poses, shape (F, 3), m and rad."""
    for k in range(len(rows)):
        turn = poses[k, 2] - built[k, 2]
        c, s = math.cos(turn), math.sin(turn)
        dx, dy = rows[k].x - built[k, 0], rows[k].y - built[k, 1]
        out[k].x, out[k].y = poses[k, 0] + c * dx - s * dy, poses[k, 1] + s * dx + c * dy
        dx, dy = rows[k].cx - built[k, 0], rows[k].cy - built[k, 1]
        out[k].cx, out[k].cy = poses[k, 0] + c * dx - s * dy, poses[k, 1] + s * dx + c * dy
        out[k].phi = rows[k].phi + turn
