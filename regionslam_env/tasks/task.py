"""The task `GoTo`: be in a region of a type. It draws missions and judges them on the truth, which no agent sees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from regionslam_env.errors import ConfigError, WorldError, unknown
from regionslam_env.worlds.clearance import Grid
from regionslam_env.worlds.flooding import Roots, foot, query
from regionslam_env.worlds.geodesic import Field, Geodesic
from regionslam_env.worlds.world import World
from slam.jit import njit

MIN_START_DISTANCE = 2.0
"""Geodesic distance that a drawn start keeps from every goal region, m."""

STAY_SECONDS = 1.0
"""How long the robot's centre has to be inside a goal region where arrival is not declared, s."""

CONTACT = 0.03
"""How far a touching robot is moved to measure its distance, m; contacts overlap by less than half of that."""

_NO_GOALS = frozenset({"door", "other"})  # passages and places without a name are drawn for nobody


@dataclass(frozen=True)
class GoToMission:
    """A drawn mission.

    Parameters
    ----------
    goal
        Semantic type to go to.
    start
        Pose (x, y, theta) in the world frame, m and rad.
    shortest
        Geodesic distance from the start into the nearest goal region, m.
    """

    goal: str
    start: tuple[float, float, float]
    shortest: float


class Outcome(NamedTuple):
    """What one step has brought.

    Parameters
    ----------
    progress
        Decrease of the geodesic distance to the goal, m.
    inside
        The robot's true centre is inside a goal region.
    success, false_arrival
        The mission ends with this step, well or with a wrong declaration.
    """

    progress: float
    inside: bool
    success: bool
    false_arrival: bool


class GoToTask:
    """Be in a region of the goal type, by staying there for a second or by declaring it.

    Parameters
    ----------
    world, geodesic
        The truth, and shortest distances in it.
    types
        Semantic types that an observation can tell apart: what a goal can be.
    step
        Duration of a step, s.
    declares
        Whether arrival is declared.
    goal
        The goal type of every episode; None: drawn for each.
    start_distance
        Least geodesic distance of a drawn start from every goal region, m.

    Raises
    ------
    ConfigError
        For a goal that is no type of this world, or a distance that is not a number.
    """

    def __init__(
        self,
        world: World,
        geodesic: Geodesic,
        types: Sequence[str],
        step: float,
        declares: bool = False,
        goal: str | None = None,
        start_distance: float = MIN_START_DISTANCE,
    ) -> None:
        if not (math.isfinite(start_distance) and start_distance >= 0):
            raise ConfigError(f"start_distance is {start_distance!r}, expected a length of at least 0 m")
        self.world, self.geodesic, self.declares = world, geodesic, declares
        self.goal, self.start_distance = goal, float(start_distance)
        self._steps_to_stay = max(1, math.ceil(STAY_SECONDS / step - 1e-9))
        rooms = {region.type for region in world.regions if region.parent is None}
        self.goals = tuple(t for t in world.types if t in rooms and t in types and t not in _NO_GOALS)
        self._types = tuple(types)
        if goal is not None:
            self._check_goal(goal)

    def draw(
        self,
        rng: np.random.Generator,
        goal: str | None = None,
        start: Sequence[float] | None = None,
        standing: bool = False,
    ) -> GoToMission:
        """Draw what is not given and begin the episode.

        A robot that is `standing` at the start may touch something, and a goal that is drawn for it is at least
        `start_distance` away, if there is one.

        Raises
        ------
        ConfigError
            Where the goal cannot be reached, the start is not free, or no place is far enough from the goal.
        """
        goal = self.goal if goal is None else goal
        if goal is not None:
            self._check_goal(goal)
            mission = self._mission(rng, goal, start, standing)
        else:
            mission = self._any_mission(rng, start, standing)
        roots = self._field_of(mission.goal).roots
        self._roots = (tuple(roots.grid), *roots[1:])
        self._remaining = mission.shortest
        self._stayed = 0
        return mission

    def judge(self, x: float, y: float, declared: bool) -> Outcome:
        """Judge a step that ends at this true position (world frame, m)."""
        distance, within = judge(self._roots, x, y)
        remaining, inside = float(distance), bool(within)  # not NumPy's own, without the JIT
        if not math.isfinite(remaining):  # squeezed against something: no nearer, no farther
            remaining = self._remaining
        progress, self._remaining = self._remaining - remaining, remaining
        self._stayed = self._stayed + 1 if inside else 0
        if self.declares:
            return Outcome(progress, inside, declared and inside, declared and not inside)
        return Outcome(progress, inside, self._stayed >= self._steps_to_stay, False)

    @property
    def remaining(self) -> float:
        """Geodesic distance to the goal after the last step, m."""
        return self._remaining

    def _check_goal(self, goal: str) -> None:
        for known in (self.world.types, self._types):
            if goal not in known:
                raise ConfigError(f"world {self.world.name!r}: {unknown('goal', goal, set(known) & set(self._types))}")

    def _field_of(self, goal: str) -> Field:
        return self.geodesic.field(i for i, region in enumerate(self.world.regions) if region.type == goal)

    def _any_mission(self, rng: np.random.Generator, start: Sequence[float] | None, standing: bool) -> GoToMission:
        """Draw a goal among those that can be reached from somewhere far enough."""
        reasons, near = [], []
        for k in rng.permutation(len(self.goals)):
            try:
                mission = self._mission(rng, self.goals[k], start, standing)
            except ConfigError as error:
                reasons.append(str(error))
                continue
            if not standing or mission.shortest >= self.start_distance:
                return mission
            near.append(mission)
        if near:
            return max(near, key=lambda mission: mission.shortest)
        raise ConfigError(reasons[0] if reasons else f"world {self.world.name!r} has no region that can be a goal")

    def _mission(
        self, rng: np.random.Generator, goal: str, start: Sequence[float] | None, standing: bool
    ) -> GoToMission:
        field = self._field_of(goal)
        if start is None:
            try:
                x, y = self.geodesic.sample_free(rng, field, at_least=self.start_distance)
            except WorldError as error:
                raise ConfigError(self._no_start(goal, field)) from error
            theta = float(rng.uniform(-math.pi, math.pi))
        else:
            x, y, theta = self._checked(start, standing)
        shortest = _from_contact(field, x, y) if standing else field.at(x, y)
        if not math.isfinite(shortest):
            raise ConfigError(f"world {self.world.name!r}: no way from ({x:.2f}, {y:.2f}) to any {goal!r}")
        return GoToMission(goal, (x, y, theta), shortest)

    def _no_start(self, goal: str, field: Field) -> str:
        reach = field.roots.value[np.isfinite(field.roots.value)]
        prefix = f"world {self.world.name!r}: "
        if not len(reach):
            return f"{prefix}no {goal!r} can be reached by the robot"
        return (
            f"{prefix}no free place is {self.start_distance:g} m or more from every {goal!r}: "
            f"the farthest is {reach.max():.1f} m away"
        )

    def _checked(self, start: Sequence[float], standing: bool) -> tuple[float, float, float]:
        values = np.asarray(start, dtype=np.float64).tolist()
        if not isinstance(values, list) or len(values) != 3 or not all(map(math.isfinite, values)):
            raise ConfigError(f"start is {start!r}, expected a pose (x, y, theta) in m, m, rad")
        x, y, theta = values
        if not standing and not self.geodesic.free(x, y):
            radius = self.geodesic.radius
            raise ConfigError(
                f"world {self.world.name!r}: start ({x:g}, {y:g}) is not free for a robot of {radius:g} m radius"
            )
        return x, y, theta


def _from_contact(field: Field, x: float, y: float) -> float:
    """Return the distance from where a robot stands, m: from beside it where it is squeezed against something."""
    turns = np.linspace(0, 2 * math.pi, 8, endpoint=False)
    beside = ((x + CONTACT * math.cos(turn), y + CONTACT * math.sin(turn)) for turn in turns)
    here = field.at(x, y)
    return here if math.isfinite(here) else min(field.at(*point) for point in beside)


@njit
def judge(field: Any, x: float, y: float) -> Any:
    """Return the distance from a point to the goal, and whether it is inside one of the goal's rectangles.

    `field` holds the parts of `Roots`, and those of its grid, as plain tuples: Numba unpacks them ten times faster.
    """
    roots = Roots(Grid(*field[0]), *field[1:])
    inside = False
    for g in range(len(roots.goals)):
        inside = inside or foot(roots.goals[g], x, y)[2] == 0
    return 0.0 if inside else query(roots, x, y)[0], inside
