"""`RegionSLAM/Explore-v0`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

from regionslam_env.arguments import CommonArguments
from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.tasks.explore import ExploreTask
from regionslam_env.tasks.rewards import EXPLORE_REWARD_SETS, ExploreRewardConfig, reward_set


class ExploreEnv(SemanticNavigationEnv):
    """Map a floor that is not known, with a pose that is only believed.

    Spaces, further arguments and what else all environments share: `SemanticNavigationEnv`.

    ## Description

    The robot has to bring the regions of the floor onto its map: all that it can get into, furniture left out. Every
    two seconds the believed map is compared with the truth.

    ## Rewards

    | Term | Weight | When |
    | --- | --- | --- |
    | recall | 20 for all | the map gains regions that can be entered; what it loses costs as much |
    | edges | 10 for all | it closes their edges |
    | success | 10 | the mission is done |
    | time | -0.002 | every step |
    | collision | -0.05 | every step that something holds the robot back |
    | false_arrival | -10 | end declared before enough is mapped |

    ## Starting State

    Anywhere in the largest connected part of the floor.

    ## Episode End

    * Termination with `arrival="stay"`: `map_share` of the regions of that part, furniture left out, are on the map.
    * Termination with `arrival="declare"`: the robot declares so, right or wrong.

    ## Arguments

    | Argument | Default | Meaning |
    | --- | --- | --- |
    | map_share | 0.9 | share of the regions that has to be mapped |
    | reward | "standard" | "standard", "sparse", or keys of `ExploreRewardConfig` |
    | max_steps | 6000 | steps of 0.1 s until truncation (`max_episode_steps` would end it without metrics) |
    """

    task_type = ExploreTask

    def __init__(
        self,
        *,
        map_share: float = 0.9,
        reward: str | Mapping[str, Any] | ExploreRewardConfig = "standard",
        max_steps: int = 6000,
        **common: Unpack[CommonArguments],
    ) -> None:
        self.reward = reward_set(reward, EXPLORE_REWARD_SETS)
        super().__init__({"rewards": self.reward, "map_share": map_share}, None, max_steps, **common)
