"""The task `GoTo`: be in a region of a type. It draws missions and judges them on the truth, which no agent sees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from regionslam_env.errors import ConfigError, WorldError, unknown
from regionslam_env.missions.mission import GoTo
from regionslam_env.tasks.rewards import REWARD_SETS, goto_reward
from regionslam_env.tasks.task import DrawnMission, Moment, Task, TaskSettings, Verdict, distance_from
from regionslam_env.worlds.clearance import Grid
from regionslam_env.worlds.flooding import Roots, foot, query
from regionslam_env.worlds.geodesic import Field, Geodesic
from regionslam_env.worlds.world import World
from slam.jit import njit

STAY_SECONDS = 1.0
"""How long the robot's centre has to be inside a goal region where arrival is not declared, s."""

_NO_GOALS = frozenset({"door", "other"})  # passages and places without a name are drawn for nobody


@dataclass(frozen=True)
class GoToMission(DrawnMission):
    """A drawn mission that has a goal."""

    goal: str
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


class GoToTask(Task):
    """Be in a region of the goal type, by staying there for a second or by declaring it.

    Parameters
    ----------
    world, geodesic, settings
        As in `Task`.
    goal
        The goal type of every episode; None: drawn for each.

    Raises
    ------
    ConfigError
        For a goal that is no type of this world.
    """

    takes_goal = True
    reward_sets = REWARD_SETS

    def __init__(self, world: World, geodesic: Geodesic, settings: TaskSettings, goal: str | None = None) -> None:
        super().__init__(world, geodesic, settings)
        self.goal, self.start_distance = goal, float(settings.start_distance)
        self._steps_to_stay = max(1, math.ceil(STAY_SECONDS / settings.step - 1e-9))
        types = tuple(settings.types)
        rooms = {region.type for region in world.regions if region.parent is None}
        self.goals = tuple(t for t in world.types if t in rooms and t in types and t not in _NO_GOALS)
        self._types = types
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
        if self.settings.declares:
            return Outcome(progress, inside, declared and inside, declared and not inside)
        return Outcome(progress, inside, self._stayed >= self._steps_to_stay, False)

    def verdict(self, moment: Moment) -> Verdict:
        """Judge a step by where it ends and what is declared there."""
        x, y, _ = moment.pose.tolist()
        outcome = self.judge(x, y, moment.declared)
        terms = goto_reward(self.rewards, outcome.progress, outcome.success, moment.collided, outcome.false_arrival)
        return Verdict(terms, outcome.success, outcome.success or outcome.false_arrival)

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
            x, y, theta = self.checked(start, standing)
        shortest = distance_from(field, (x, y, theta), standing)
        if not math.isfinite(shortest):
            raise ConfigError(f"world {self.world.name!r}: no way from ({x:.2f}, {y:.2f}) to any {goal!r}")
        return GoToMission(str(GoTo(goal)), (x, y, theta), goal, shortest)

    def _no_start(self, goal: str, field: Field) -> str:
        reach = field.roots.value[np.isfinite(field.roots.value)]
        prefix = f"world {self.world.name!r}: "
        if not len(reach):
            return f"{prefix}no {goal!r} can be reached by the robot"
        return (
            f"{prefix}no free place is {self.start_distance:g} m or more from every {goal!r}: "
            f"the farthest is {reach.max():.1f} m away"
        )


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
