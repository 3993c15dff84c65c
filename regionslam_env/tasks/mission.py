"""The task `Mission`: one instruction after another, each judged on the truth, which no agent sees."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from regionslam_env.errors import ConfigError, unknown
from regionslam_env.missions.language import parse
from regionslam_env.missions.mission import Explore, GoTo, Instruction, Mission, Return, goal_of
from regionslam_env.tasks.approach import Approach
from regionslam_env.tasks.goto import drawable_types
from regionslam_env.tasks.rewards import MISSION_REWARD_SETS, MissionRewardConfig, mission_reward
from regionslam_env.tasks.start import Pose, checked_distance, checked_start, distance_from, draw_start
from regionslam_env.tasks.survey import Survey
from regionslam_env.tasks.task import DrawnMission, Moment, Task, TaskSettings, Verdict
from regionslam_env.worlds.geodesic import Field, Geodesic
from regionslam_env.worlds.world import World
from slam.belief import Belief

AT_HOME = 1.0
"""Length of the way (m) within which the robot is back where the map was begun."""


class Plan(NamedTuple):
    """A drawn mission, the way of each of its instructions (None to explore), and the distance of the first place."""

    drawn: DrawnMission
    approaches: list[Approach | None]
    first: float


class MissionTask(Task):
    """Follow instructions in their order.

    Parameters
    ----------
    world, geodesic, settings
        As in `Task`.
    rewards
        Weights of the reward terms.
    n_goals
        Places that a drawn mission goes to before it returns.
    start_distance
        Least geodesic distance of a drawn start from the first place, m.
    map_share
        Share of the regions that has to be mapped in order to have explored.

    Raises
    ------
    ConfigError
        For a number that is none, or out of range.
    """

    option = "mission"

    def __init__(
        self,
        world: World,
        geodesic: Geodesic,
        settings: TaskSettings,
        rewards: MissionRewardConfig = MISSION_REWARD_SETS["standard"],
        n_goals: int = 2,
        start_distance: float = 2.0,
        map_share: float = 0.9,
    ) -> None:
        super().__init__(world, geodesic, settings)
        self.rewards, self.start_distance = rewards, checked_distance(start_distance)
        if isinstance(n_goals, bool) or not isinstance(n_goals, int) or n_goals < 1:
            raise ConfigError(f"n_goals is {n_goals!r}, expected a whole number of at least 1")
        self._n_goals = n_goals
        self._survey = Survey(geodesic, settings, map_share)
        self._floor = geodesic.field(self._survey.reachable[:1])
        self.goals = drawable_types(world, settings.types)

    @classmethod
    def read(cls, wanted: Any, types: Sequence[str]) -> Mission:
        """Return a mission in words, to places of these types, or check one that is made already."""
        if isinstance(wanted, str):
            return parse(wanted, types)
        if not isinstance(wanted, Mission):
            raise ConfigError(f"mission is {wanted!r}, expected words such as 'go to the kitchen, then return'")
        for region_type in wanted.types:
            if region_type not in types:
                raise ConfigError(unknown("goal", region_type, types))
        return wanted

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

        Raises
        ------
        ConfigError
            Where a place cannot be reached, the start is not free, or no place is far enough from the first goal.
        """
        if mission is not None:
            return self._begin(self._plan(rng, mission, start, standing, home))
        reasons, near = [], []
        order = rng.permutation(len(self.goals)).tolist()
        for k in range(len(order)):
            chosen = [GoTo(self.goals[i]) for i in (order[k:] + order[:k])[: self._n_goals]]
            try:
                plan = self._plan(rng, Mission((*chosen, Return())), start, standing, home)
            except ConfigError as error:
                reasons.append(str(error))
                continue
            if not standing or plan.first >= self.start_distance:
                return self._begin(plan)
            near.append(plan)
        if near:
            return self._begin(max(near, key=lambda plan: plan.first))
        raise ConfigError(reasons[0] if reasons else f"world {self.world.name!r} has no region that can be a goal")

    def verdict(self, moment: Moment) -> Verdict:
        """Judge a step by the present instruction; the step after the one that does it belongs to the next."""
        progress = recall = edges = 0.0
        approach = self._approaches[self._done]
        if approach is None:
            recall, edges, done, wrong = self._survey.step(moment)
        else:
            x, y, _ = moment.pose.tolist()
            progress, _, done, wrong = approach.step(x, y, moment.declared)
        if done:
            self._done += 1
        success = self._done == len(self._approaches)
        if done and not success:
            self._set_off(moment.pose.tolist())
        terms = mission_reward(self.rewards, progress, recall, edges, done, success, moment.collided, wrong)
        return Verdict(terms, success, success or wrong)

    def quiet_terms(self, progress: Any, collided: Any) -> dict[str, Any]:
        """Return the terms of the reward of steps that do no instruction and explore nothing."""
        return mission_reward(self.rewards, progress, 0.0, 0.0, False, False, collided, False)

    @property
    def approach(self) -> Approach | None:
        """The way of the present instruction; None to explore, and once all are done."""
        return self._approaches[self._done] if self._done < len(self._approaches) else None

    @property
    def instruction(self) -> Instruction:
        """What the robot has to do now; the last one when all are done."""
        instructions = self._mission.instructions
        return instructions[min(self._done, len(instructions) - 1)]

    @property
    def completed(self) -> float:
        """Share of the instructions that are done."""
        return self._done / len(self._approaches)

    def believed(self, belief: Belief) -> float | None:
        """Return the probability, by the belief, of being at the end of the mission; 0 before its last instruction.

        Near the start is meant straight here: the robot knows no ways.
        """
        last = self._mission.instructions[-1]
        if isinstance(last, Explore):
            return None
        if self._done < len(self._approaches) - 1:
            return 0.0
        if isinstance(last, GoTo):
            return belief.probability_in(last.type)
        near = np.hypot(*belief.particles["expected"][:, :2].T) <= AT_HOME
        return min(1.0, float(np.exp(belief.particles["log_weight"][near]).sum()))

    @property
    def remaining(self) -> float | None:
        """Length of the way that is left after the last step, m; None for a mission to explore."""
        if None in self._approaches:
            return None
        approach = self._approaches[min(self._done, len(self._approaches) - 1)]
        assert approach is not None
        return approach.remaining

    @property
    def figures(self) -> Mapping[str, float | None]:
        """Shares of the regions that are mapped and of their edges that are closed, for a mission to explore."""
        if None not in self._approaches:
            return {}
        return dict(zip(("explored", "closed_edges"), self._survey.shares, strict=True))

    def _plan(
        self,
        rng: np.random.Generator,
        mission: Mission,
        start: Sequence[float] | None,
        standing: bool,
        home: Pose | None,
    ) -> Plan:
        """Draw a start, or check the one given, and find the ways."""
        first = mission.instructions[0]
        goals = {str(part): self._goal_field(part) for part in mission.instructions if not isinstance(part, Return)}
        field = goals.get(str(first), self._floor)
        if start is None:
            at_least = self.start_distance if isinstance(first, GoTo) else 0.0
            pose = draw_start(rng, self.geodesic, field, goal_of(first) or "region", at_least, goals.values())
        else:
            pose = checked_start(self.geodesic, start, standing)
        x, y, _ = pose
        for words, goal in goals.items():
            if not math.isfinite(distance_from(goal, pose, standing)):
                raise ConfigError(f"world {self.world.name!r}: no way from ({x:.2f}, {y:.2f}) in order to {words}")
        approaches = self._ways(mission, pose if home is None else home)
        shortest = None if None in approaches else approaches[0].near(x, y)  # type: ignore[union-attr]
        return Plan(DrawnMission(mission, pose, shortest), approaches, field.near(x, y))

    def _goal_field(self, instruction: GoTo | Explore) -> Field:
        """Return the distance to where an instruction leads."""
        return self.geodesic.field_to_type(instruction.type) if isinstance(instruction, GoTo) else self._floor

    def _ways(self, mission: Mission, home: Pose) -> list[Approach | None]:
        """Return the way of each instruction, through its place and those that follow; None for an exploration."""
        ways: list[Approach | None] = []
        beyond: Approach | None = None
        for instruction in reversed(mission.instructions):
            if isinstance(instruction, Explore):
                beyond = None
            else:
                beyond = Approach(self.geodesic, self._place(instruction, home), self.settings, beyond)
            ways.append(beyond)
        return ways[::-1]

    def _place(self, instruction: GoTo | Return, home: Pose) -> Field:
        """Return the distance to the place of an instruction, 0 or less inside."""
        if isinstance(instruction, GoTo):
            return self._goal_field(instruction)
        return self.geodesic.field_to_points(np.array([home[:2]]), np.array([-AT_HOME]))

    def _begin(self, plan: Plan) -> DrawnMission:
        """Begin the episode."""
        self._mission, self._approaches, self._done = plan.drawn.mission, plan.approaches, 0
        self._survey.begin()
        self._set_off(plan.drawn.start)
        return plan.drawn

    def _set_off(self, pose: Sequence[float]) -> None:
        """Begin the present instruction at a pose, shape (3,)."""
        approach = self._approaches[self._done]
        if approach is None:
            self._survey.begin()
        else:
            approach.begin(approach.near(pose[0], pose[1]))
