"""`RegionSLAM/Mission-v0`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

from regionslam_env.arguments import CommonArguments
from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.missions.mission import Mission
from regionslam_env.tasks.mission import MissionTask
from regionslam_env.tasks.rewards import MISSION_REWARD_SETS, MissionRewardConfig, reward_set


class MissionEnv(SemanticNavigationEnv):
    """Do one thing after another, as told in words, on a floor that is not known, with a pose that is only believed.

    Spaces, further arguments and what else all environments share: `SemanticNavigationEnv`.

    ## Description

    A mission is a sequence of instructions: "go to the kitchen, then explore, then return". Observations tell the
    instruction that has to be followed now: its kind in `progress`, and in `goal` the type of place to go to.

    * *go to*: be in a region of that type.
    * *explore*: bring `map_share` of the regions that can be entered onto the map, furniture left out.
    * *return*: be back, within 1 m of way, where the map was begun. That is the origin of the map frame.

    An instruction is done as in the environment of its own. With `arrival="stay"`, by 1 s in the place, or by the map
    itself; the step after that belongs to the next one. With `arrival="declare"`, by declaring it there; one wrong
    declaration ends the episode.

    ## Rewards

    | Term | Weight | When |
    | --- | --- | --- |
    | progress | 1 per metre | shorten the way that leads through all places up to the next exploration |
    | recall | 20 for all | exploring: the map gains regions that can be entered; what it loses costs as much |
    | edges | 10 for all | exploring: it closes their edges |
    | instruction | 5 | an instruction is done |
    | success | 10 | the mission is done |
    | time | -0.002 | every step |
    | collision | -0.05 | every step that something holds the robot back |
    | false_arrival | -10 | something declared done that is not |

    ## Starting State

    Anywhere with a free way of at least `start_distance` to the first place to go to, if one comes first, and a way
    through all of them. The mission goes to `n_goals` drawn types of room and returns, unless it is given;
    `reset(options={"mission": "go to the kitchen, then return"})` sets it for one episode.

    ## Episode End

    * Termination: the last instruction is done, or with `arrival="declare"` a declaration is wrong.

    Lengths in the metrics are those of the shortest way through all places in their order. They are None for missions
    to explore, `completed` is the share of the instructions that are done.

    ## Arguments

    | Argument | Default | Meaning |
    | --- | --- | --- |
    | mission | None | in words or as a `Mission`, for every episode; None draws one |
    | n_goals | 2 | places that a drawn mission goes to before it returns; fewer on floors of fewer types |
    | start_distance | 2.0 | least geodesic distance of a drawn start from the first place, m |
    | map_share | 0.9 | share of the regions that has to be mapped in order to have explored |
    | reward | "standard" | "standard", "sparse", or keys of `MissionRewardConfig` |
    | max_steps | 6000 | steps of 0.1 s until truncation (`max_episode_steps` would end it without metrics) |
    """

    task_type = MissionTask

    def __init__(
        self,
        *,
        mission: str | Mission | None = None,
        n_goals: int = 2,
        start_distance: float = 2.0,
        map_share: float = 0.9,
        reward: str | Mapping[str, Any] | MissionRewardConfig = "standard",
        max_steps: int = 6000,
        **common: Unpack[CommonArguments],
    ) -> None:
        self.reward = reward_set(reward, MISSION_REWARD_SETS)
        arguments = {
            "rewards": self.reward,
            "n_goals": n_goals,
            "start_distance": start_distance,
            "map_share": map_share,
        }
        super().__init__(arguments, mission, max_steps, **common)
