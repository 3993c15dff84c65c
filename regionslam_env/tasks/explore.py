"""The task `Explore`: map the floor. What has been mapped is judged by the truth, which no agent sees."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from regionslam_env.errors import ConfigError, WorldError
from regionslam_env.missions.mission import Explore, Mission
from regionslam_env.tasks.rewards import EXPLORE_REWARD_SETS, ExploreRewardConfig, explore_reward
from regionslam_env.tasks.start import Pose, checked_start, distance_from
from regionslam_env.tasks.survey import Survey
from regionslam_env.tasks.task import DrawnMission, Moment, Task, TaskSettings, Verdict
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import World

_EXPLORE = Explore()


class ExploreTask(Task):
    """Map a share of the regions that the robot can get into, furniture left out.

    Without declarations the mission is done once that is so; with them, once the robot says so.

    Parameters
    ----------
    world, geodesic, settings
        As in `Task`.
    rewards
        Weights of the reward terms.
    map_share
        Share of these regions that has to be mapped.

    Raises
    ------
    ConfigError
        For a world whose regions cannot be entered, or a share that is none.
    """

    def __init__(
        self,
        world: World,
        geodesic: Geodesic,
        settings: TaskSettings,
        rewards: ExploreRewardConfig = EXPLORE_REWARD_SETS["standard"],
        map_share: float = 0.9,
    ) -> None:
        super().__init__(world, geodesic, settings)
        self.rewards = rewards
        self.survey = Survey(geodesic, settings, map_share)
        self._floor = geodesic.field(self.survey.reachable[:1])

    def draw(
        self,
        rng: np.random.Generator,
        mission: Mission | None = None,
        start: Sequence[float] | None = None,
        *,
        standing: bool = False,
        home: Pose | None = None,
    ) -> DrawnMission:
        """Draw a start in the largest connected part of the floor, or check the one given."""
        if start is None:
            try:
                x, y = self.geodesic.sample_free(rng, self._floor)
            except WorldError as error:
                raise ConfigError(str(error)) from error
            pose: Pose = (x, y, float(rng.uniform(-math.pi, math.pi)))
        else:
            pose = checked_start(self.geodesic, start, standing)
        if not math.isfinite(distance_from(self._floor, pose, standing)):
            raise ConfigError(
                f"world {self.world.name!r}: no way from ({pose[0]:.2f}, {pose[1]:.2f}) "
                "to the largest connected part of the floor"
            )
        self.survey.begin()
        self._done = False
        return DrawnMission(Mission((self.instruction,)), pose, None)

    def verdict(self, moment: Moment) -> Verdict:
        """Judge a step, and pay for what the map has gained."""
        gain = self.survey.step(moment)
        self._done = gain.success
        terms = explore_reward(self.rewards, gain.recall, gain.edges, gain.success, moment.collided, gain.false_arrival)
        return Verdict(terms, gain.success, gain.success or gain.false_arrival)

    def quiet_terms(self, progress: Any, collided: Any) -> dict[str, Any]:
        """Return the terms of the reward of steps that bring nothing."""
        return explore_reward(self.rewards, 0.0, 0.0, False, collided, False)

    @property
    def instruction(self) -> Explore:
        """What the robot has to do now."""
        return _EXPLORE

    @property
    def completed(self) -> float:
        """1 once enough is mapped, 0 before."""
        return float(self._done)

    @property
    def figures(self) -> Mapping[str, float | None]:
        """Shares of the wanted regions that are mapped, and of their edges that are closed."""
        return dict(zip(("explored", "closed_edges"), self.survey.shares, strict=True))
