"""`RegionSLAM/GoTo-v0`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

from regionslam_env.arguments import CommonArguments
from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.tasks.goto import GoToTask
from regionslam_env.tasks.rewards import REWARD_SETS, RewardConfig, reward_set


class GoToEnv(SemanticNavigationEnv):
    """Go to a place by its meaning, on a floor that is not known, with a pose that is only believed.

    Spaces, further arguments and what else all environments share: `SemanticNavigationEnv`.

    ## Description

    The robot is told what kind of place to go to: any hallway, any kitchen. It has to find one, get into it, and,
    with `arrival="declare"`, know that it is there.

    ## Rewards

    | Term | Weight | When |
    | --- | --- | --- |
    | progress | 1 per metre | come nearer to the goal, geodesically |
    | success | 10 | the mission is done |
    | time | -0.01 | every step |
    | collision | -0.05 | every step that something holds the robot back |
    | false_arrival | -10 | arrival declared outside of the goal |

    ## Starting State

    Anywhere with a free way of at least `start_distance` to the nearest goal region. The goal is a drawn type of room,
    unless it is given; `reset(options={"goal": "kitchen"})` sets it for one episode.

    ## Episode End

    * Termination with `arrival="stay"`: the robot's centre has been inside a goal region for 1 s.
    * Termination with `arrival="declare"`: the robot declares its arrival, right or wrong.

    ## Arguments

    | Argument | Default | Meaning |
    | --- | --- | --- |
    | goal | None | semantic type to go to in every episode; None draws one |
    | start_distance | 2.0 | least geodesic distance of a drawn start from every goal region, m |
    | reward | "standard" | "standard", "sparse", or keys of `RewardConfig` |
    | max_steps | 1000 | steps of 0.1 s until truncation (`max_episode_steps` would end it without metrics) |
    """

    task_type = GoToTask

    def __init__(
        self,
        *,
        goal: str | None = None,
        start_distance: float = 2.0,
        reward: str | Mapping[str, Any] | RewardConfig = "standard",
        max_steps: int = 1000,
        **common: Unpack[CommonArguments],
    ) -> None:
        self.reward = reward_set(reward, REWARD_SETS)
        super().__init__({"rewards": self.reward, "start_distance": start_distance}, goal, max_steps, **common)
