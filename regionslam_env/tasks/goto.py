"""The task `GoTo`: be in a region of a type. It draws missions and judges them on the truth, which no agent sees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from regionslam_env.errors import ConfigError, unknown
from regionslam_env.missions.mission import GoTo, Mission
from regionslam_env.tasks.approach import Approach, Outcome
from regionslam_env.tasks.rewards import REWARD_SETS, RewardConfig, goto_reward
from regionslam_env.tasks.start import Pose, checked_distance, checked_start, distance_from, draw_start
from regionslam_env.tasks.task import DrawnMission, Moment, Task, TaskSettings, Verdict
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import World
from slam.belief import Belief

_NO_GOALS = frozenset({"door", "other"})  # passages and places without a name are drawn for nobody


class GoToTask(Task):
    """Be in a region of the goal type, by staying there for a second or by declaring it.

    Parameters
    ----------
    world, geodesic, settings
        As in `Task`.
    rewards
        Weights of the reward terms.
    start_distance
        Least geodesic distance of a drawn start from every goal region, m.

    Raises
    ------
    ConfigError
        For a distance that is none.
    """

    option = "goal"

    def __init__(
        self,
        world: World,
        geodesic: Geodesic,
        settings: TaskSettings,
        rewards: RewardConfig = REWARD_SETS["standard"],
        start_distance: float = 2.0,
    ) -> None:
        super().__init__(world, geodesic, settings)
        self.rewards, self.start_distance = rewards, checked_distance(start_distance)
        self.goals = drawable_types(world, settings.types)

    @classmethod
    def read(cls, wanted: Any, types: Sequence[str]) -> Mission:
        """Return the mission to go to a region of the type that is wanted."""
        if not isinstance(wanted, str):
            raise ConfigError(f"goal is {wanted!r}, expected a semantic type such as 'hallway'")
        if wanted not in types:
            raise ConfigError(unknown("goal", wanted, types))
        return Mission((GoTo(wanted),))

    def draw(
        self,
        rng: np.random.Generator,
        mission: Mission | None = None,
        start: Sequence[float] | None = None,
        *,
        standing: bool = False,
        home: Pose | None = None,
    ) -> DrawnMission:
        """Draw what is not given and begin the episode.

        A robot that is `standing` at the start may touch something, and a goal that is drawn for it is at least
        `start_distance` away, if there is one.

        Raises
        ------
        ConfigError
            Where the goal cannot be reached, the start is not free, or no place is far enough from the goal.
        """
        if mission is None:
            goal, pose, shortest = self._any(rng, start, standing)
        else:
            (goal,) = mission.types
            goal, pose, shortest = self._towards(rng, goal, start, standing)
        self._instruction = GoTo(goal)
        self._approach = Approach(self.geodesic, self.geodesic.field_to_type(goal), self.settings)
        self._approach.begin(shortest)
        self._done = False
        return DrawnMission(Mission((self._instruction,)), pose, shortest)

    def judge(self, x: float, y: float, declared: bool) -> Outcome:
        """Judge a step that ends at this true position (world frame, m)."""
        return self._approach.step(x, y, declared)

    def verdict(self, moment: Moment) -> Verdict:
        """Judge a step by where it ends and what is declared there."""
        x, y, _ = moment.pose.tolist()
        outcome = self.judge(x, y, moment.declared)
        self._done = outcome.success
        terms = goto_reward(self.rewards, outcome.progress, outcome.success, moment.collided, outcome.false_arrival)
        return Verdict(terms, outcome.success, outcome.success or outcome.false_arrival)

    def quiet_terms(self, progress: Any, collided: Any) -> dict[str, Any]:
        """Return the terms of the reward of steps that end nothing."""
        return goto_reward(self.rewards, progress, False, collided, False)

    @property
    def approach(self) -> Approach:
        """The way to the goal of the running episode."""
        return self._approach

    @property
    def instruction(self) -> GoTo:
        """What the robot has to do now."""
        return self._instruction

    @property
    def completed(self) -> float:
        """1 once the robot has arrived, 0 before."""
        return float(self._done)

    def believed(self, belief: Belief) -> float:
        """Return the probability, by the belief, of being in a region of the goal type."""
        return belief.probability_in(self._instruction.type)

    @property
    def remaining(self) -> float:
        """Geodesic distance to the goal after the last step, m."""
        return self._approach.remaining

    def _any(self, rng: np.random.Generator, start: Sequence[float] | None, standing: bool) -> tuple[str, Pose, float]:
        """Draw a goal among those that can be reached from somewhere far enough; see `_towards`."""
        reasons, near = [], []
        for k in rng.permutation(len(self.goals)):
            try:
                drawn = self._towards(rng, self.goals[k], start, standing)
            except ConfigError as error:
                reasons.append(str(error))
                continue
            if not standing or drawn[2] >= self.start_distance:
                return drawn
            near.append(drawn)
        if near:
            return max(near, key=lambda drawn: drawn[2])
        raise ConfigError(reasons[0] if reasons else f"world {self.world.name!r} has no region that can be a goal")

    def _towards(
        self, rng: np.random.Generator, goal: str, start: Sequence[float] | None, standing: bool
    ) -> tuple[str, Pose, float]:
        """Draw a start, or check the one given; return goal, start, and the distance between them, m."""
        field = self.geodesic.field_to_type(goal)
        if start is None:
            pose = draw_start(rng, self.geodesic, field, goal, self.start_distance)
        else:
            pose = checked_start(self.geodesic, start, standing)
        shortest = distance_from(field, pose, standing)
        if not math.isfinite(shortest):
            raise ConfigError(f"world {self.world.name!r}: no way from ({pose[0]:.2f}, {pose[1]:.2f}) to any {goal!r}")
        return goal, pose, shortest


def drawable_types(world: World, types: Sequence[str]) -> tuple[str, ...]:
    """Return the types, out of these, that a drawn mission may lead to: those of the world's rooms."""
    rooms = {region.type for region in world.regions if region.parent is None}
    return tuple(t for t in world.types if t in rooms and t in types and t not in _NO_GOALS)
