"""People who walk from room to room: where they want to go, and how they keep from running into anything.

Each walks along the shortest path for a disc of its size. Whoever is in its way it passes on the right or the left if
there is room, else it stops; and once it has not got on for a while, it wants to go somewhere else.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import DynamicsConfig
from regionslam_env.worlds.clearance import Grid, clearance_at, segment_distance
from regionslam_env.worlds.geodesic import shared_geodesic
from regionslam_env.worlds.world import WALL_RADIUS, World
from slam.jit import njit

Floats = NDArray[np.float64]

PERSON = np.dtype(
    (
        np.record,
        [
            ("x", np.float64),  # m, world frame
            ("y", np.float64),
            ("heading", np.float64),  # rad
            ("speed_x", np.float64),  # wanted, m/s
            ("speed_y", np.float64),
            ("to_x", np.float64),  # next corner of the route, m
            ("to_y", np.float64),
            ("nearest", np.float64),  # least distance from that corner so far, m
            ("idle", np.int64),  # steps without getting nearer
            ("patience", np.int64),  # steps of that which are borne
            ("rest", np.int64),  # steps to stay
            ("asks", np.int64),  # for the next corner, or for somewhere else to go
        ],
    )
)

PRIVACY = 1.5
"""Least distance (m) of a person's first place from the robot."""
PATIENCE = (2.0, 6.0)
"""Shortest and longest time that a person bears not getting on, s."""
REST = (1.0, 6.0)
"""Shortest and longest time that a person stays where it wanted to go, s."""

_TRIES = 50  # to find a place
_ROOM = 0.1  # around a person at the ends of its way, m
_OVERLAP = 0.02  # of robot and person (m) that a contact may leave
_ARRIVED = 0.15  # distance from a corner of the route (m) at which the next one is headed for
_GAIN = 0.05  # being nearer by that much (m) is getting on
_PERSON_GAP = 0.3  # a person stops this far from another one in its way, m
_ROBOT_GAP = 0.5  # and this far from a robot, which may be coming
_DOOR_GAP = 0.2  # and this far from a closed door
_STRIDE = 0.35  # length of a side step that has to be free of walls, m
_NOTHING, _NEXT_CORNER, _ELSEWHERE = 0, 1, 2  # what a person asks for
_TURNS = np.array([0.0, -0.9, 0.9])  # directions to try in turn, from the one wanted, rad


class People:
    """Everybody who walks about in a world.

    Parameters
    ----------
    world
        The truth.
    config
        How many there are, and how they walk.
    step
        Duration of an environment step, s.

    Attributes
    ----------
    records
        Their state, an array of `PERSON`.
    """

    def __init__(self, world: World, config: DynamicsConfig, step: float) -> None:
        self.radius, self._speed = config.person_radius, config.walking_speed
        self._count, self._step = config.people, step
        self._geodesic = shared_geodesic(world, self.radius)
        self._grid: tuple[Any, ...] = tuple(self._geodesic.grid)
        self._rooms = [i for i, r in enumerate(world.regions) if r.parent is None and r.type != "door"]
        self._floors: dict[int, NDArray[np.int64]] = {}
        self.records = np.zeros(0, PERSON)

    def draw(self, rng: np.random.Generator, robot: tuple[float, float]) -> None:
        """Put everybody somewhere, away from the robot (m, world frame); who finds no free place stays away."""
        self._rng = rng
        taken: list[tuple[float, float]] = []
        for _ in range(self._count):
            place = self._place(robot, taken)
            if place is not None:
                taken.append(place)
        self.records = np.zeros(len(taken), PERSON)
        self._routes: list[list[list[float]]] = [[] for _ in taken]
        self.put(np.array(taken).reshape(-1, 2))
        self.records["heading"] = rng.uniform(-math.pi, math.pi, len(taken))
        self.records["rest"] = [1 + self._steps((0.0, REST[1])) for _ in taken]

    def make_way(self, robot: tuple[float, float, float]) -> None:
        """Put everybody on whom the robot is put down (position and radius, m) somewhere else, if there is room."""
        places = self.places
        apart = self.radius + robot[2] - _OVERLAP
        for k in np.flatnonzero(np.hypot(places[:, 0] - robot[0], places[:, 1] - robot[1]) < apart).tolist():
            place = self._place(robot[:2], list(map(tuple, places.tolist())))
            if place is not None:
                places[k] = place
                self._routes[k].clear()
                self.records[k]["rest"] = 1
        self.put(places)

    @property
    def places(self) -> Floats:
        """Where everybody is, a fresh array of shape (N, 2), m."""
        return np.stack([self.records["x"], self.records["y"]], axis=1)

    def put(self, places: Floats) -> None:
        """Take note of where everybody is now, shape (N, 2), m."""
        self.records["x"], self.records["y"] = places[:, 0], places[:, 1]

    def decide(self, robot: tuple[float, float, float], closed: Floats) -> None:
        """Set the wanted speeds of everybody.

        Parameters
        ----------
        robot
            Position and radius, m.
        closed
            Closed doors as segments x0, y0, x1, y1, shape (k, 4), m.
        """
        for k in np.flatnonzero(self.records["asks"]):
            self._answer(int(k))
        walk(self.records, robot, self.radius, self._speed, closed, self._grid)

    def _answer(self, k: int) -> None:
        """Send a person to the next corner of its route, or elsewhere; at the end of its route it rests."""
        person, route = self.records[k], self._routes[k]
        asks, person.asks = person.asks, _NOTHING
        if asks == _ELSEWHERE:
            route[:] = self._way(person.x, person.y)
        if route:
            person.to_x, person.to_y = route.pop(0)
            person.nearest, person.idle, person.patience = math.inf, 0, self._steps(PATIENCE)
        else:
            person.rest = self._steps(REST)

    def _way(self, x: float, y: float) -> list[list[float]]:
        """Draw a destination and return the corners on the way there, m; none where no way was found."""
        place = self._spot()
        way = None if place is None else self._geodesic.route((float(x), float(y)), place)
        return [] if way is None else way[1:].tolist()

    def _spot(self) -> tuple[float, float] | None:
        """Draw a place in a room, m; None where there is none in that room."""
        grid = self._geodesic.grid
        room = self._rooms[self._rng.integers(len(self._rooms))]
        if room not in self._floors:
            self._floors[room] = np.flatnonzero(self._geodesic.floor([room]) & (grid.clearance >= _ROOM))
        nodes = self._floors[room]
        if not len(nodes):
            return None
        i, j = divmod(int(nodes[self._rng.integers(len(nodes))]), grid.clearance.shape[1])
        return grid.x0 + i * grid.step, grid.y0 + j * grid.step

    def _place(self, robot: tuple[float, float], taken: list[tuple[float, float]]) -> tuple[float, float] | None:
        """Draw a place away from the robot and apart from everybody; None where none was found."""
        apart = 2 * self.radius + _ROOM
        for _ in range(_TRIES):
            place = self._spot()
            if (
                place is not None
                and math.dist(place, robot) >= PRIVACY
                and all(math.dist(place, other) >= apart for other in taken)
            ):
                return place
        return None

    def _steps(self, seconds: tuple[float, float]) -> int:
        return round(self._rng.uniform(*seconds) / self._step)


@njit
def walk(
    people: NDArray[np.void],
    robot: tuple[float, float, float],
    radius: float,
    speed: float,
    closed: Floats,
    grid: tuple[Any, ...],
) -> None:
    """Write the wanted speeds of one step, and what each person asks for before the next one.

    Parameters
    ----------
    people
        Array of `PERSON`.
    robot
        Position and radius, m.
    radius, speed
        Of a person, m and m/s.
    closed
        Closed doors as segments x0, y0, x1, y1, shape (k, 4), m.
    grid
        The parts of a `Grid` of a person's clearance.
    """
    for k in range(len(people)):
        person = people[k]
        person.speed_x = person.speed_y = 0.0
        if person.rest > 0:
            person.rest -= 1
            person.asks = _ELSEWHERE if person.rest == 0 else _NOTHING
            continue
        dx, dy = person.to_x - person.x, person.to_y - person.y
        distance = math.hypot(dx, dy)
        if distance < _ARRIVED:
            person.asks = _NEXT_CORNER
            continue
        person.idle += 1
        if distance < person.nearest - _GAIN:
            person.nearest, person.idle = distance, 0
        if person.idle > person.patience:
            person.asks = _ELSEWHERE
            continue
        for turn in _TURNS:
            c, s = math.cos(turn) / distance, math.sin(turn) / distance
            ux, uy = c * dx - s * dy, s * dx + c * dy
            if turn != 0 and clearance_at(Grid(*grid), person.x + _STRIDE * ux, person.y + _STRIDE * uy) < 0:
                continue
            if _is_clear(k, ux, uy, people, robot, radius, closed):
                person.speed_x, person.speed_y = speed * ux, speed * uy
                person.heading = math.atan2(uy, ux)
                break


@njit
def _is_clear(
    k: int,
    ux: float,
    uy: float,
    people: NDArray[np.void],
    robot: tuple[float, float, float],
    radius: float,
    closed: Floats,
) -> bool:
    """Return whether person k can walk along (ux, uy) without coming too near to anybody or a closed door."""
    x, y = people[k].x, people[k].y
    if _in_the_way(robot[0] - x, robot[1] - y, ux, uy, radius + robot[2], _ROBOT_GAP):
        return False
    for other in range(len(people)):
        if other != k and _in_the_way(people[other].x - x, people[other].y - y, ux, uy, 2 * radius, _PERSON_GAP):
            return False
    for door in range(len(closed)):
        gap = segment_distance(x, y, closed[door]) - radius - WALL_RADIUS
        if gap < _DOOR_GAP and segment_distance(x + 0.1 * ux, y + 0.1 * uy, closed[door]) - radius - WALL_RADIUS < gap:
            return False
    return True


@njit
def _in_the_way(dx: float, dy: float, ux: float, uy: float, touch: float, gap: float) -> bool:
    """Return whether somebody at (dx, dy) is ahead along (ux, uy), in the way, and nearer than a gap."""
    ahead, aside = dx * ux + dy * uy, abs(dx * uy - dy * ux)
    return ahead > 0 and aside < touch + 0.05 and dx * dx + dy * dy < (touch + gap) ** 2
