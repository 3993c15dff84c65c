"""Rewards: a sum of named terms, which stand in ``info["reward_terms"]``.

Weights carry the sign; the terms are pure functions of what happened in one step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from regionslam_env.config import from_dict
from regionslam_env.errors import ConfigError, unknown


@dataclass(frozen=True)
class RewardConfig:
    """Weights of the reward terms.

    Parameters
    ----------
    progress
        Per metre that the robot has come nearer to the goal (geodesic); a metre farther away costs as much.
    success
        Once, when the mission is done.
    time
        In every step.
    collision
        In every step in which the robot touches something.
    false_arrival
        Once, when the robot declares its arrival and is not there.
    """

    progress: float = 1.0
    success: float = 10.0
    time: float = -0.01
    collision: float = -0.05
    false_arrival: float = -10.0


@dataclass(frozen=True)
class ExploreRewardConfig:
    """Weights of the reward terms of exploring.

    Parameters
    ----------
    recall
        For the whole floor: per share of the reachable regions that the believed map has gained; a loss costs as much.
    edges
        For the whole floor: per share of their edges that it has closed.
    success
        Once, when enough is mapped.
    time
        In every step.
    collision
        In every step in which the robot touches something.
    false_arrival
        Once, when the robot declares that it is done and has not mapped enough.
    """

    recall: float = 20.0
    edges: float = 10.0
    success: float = 10.0
    time: float = -0.002
    collision: float = -0.05
    false_arrival: float = -10.0


@dataclass(frozen=True)
class MissionRewardConfig:
    """Weights of the reward terms of missions.

    Parameters
    ----------
    progress
        Per metre by which the way through all places, up to the next exploration, has become shorter.
    recall, edges
        As in `ExploreRewardConfig`, while the robot explores.
    instruction
        Once for every instruction that is done.
    success
        Once, when the last one is done.
    time
        In every step.
    collision
        In every step in which the robot touches something.
    false_arrival
        Once, when the robot declares that an instruction is done and it is not.
    """

    progress: float = 1.0
    recall: float = 20.0
    edges: float = 10.0
    instruction: float = 5.0
    success: float = 10.0
    time: float = -0.002
    collision: float = -0.05
    false_arrival: float = -10.0


REWARD_SETS: Mapping[str, RewardConfig] = {
    "standard": RewardConfig(),
    "sparse": RewardConfig(progress=0.0, success=1.0, time=0.0, collision=0.0, false_arrival=0.0),
}
"""Reward weights by name: `standard` leads to the goal, `sparse` pays the success alone."""

EXPLORE_REWARD_SETS: Mapping[str, ExploreRewardConfig] = {
    "standard": ExploreRewardConfig(),
    "sparse": ExploreRewardConfig(recall=0.0, edges=0.0, success=1.0, time=0.0, collision=0.0, false_arrival=0.0),
}
"""The same of exploring."""

MISSION_REWARD_SETS: Mapping[str, MissionRewardConfig] = {
    "standard": MissionRewardConfig(),
    "sparse": MissionRewardConfig(
        progress=0.0,
        recall=0.0,
        edges=0.0,
        instruction=0.0,
        success=1.0,
        time=0.0,
        collision=0.0,
        false_arrival=0.0,
    ),
}
"""The same of missions."""

R = TypeVar("R", RewardConfig, ExploreRewardConfig, MissionRewardConfig)


def reward_set(reward: str | Mapping[str, Any] | R | None, sets: Mapping[str, R]) -> R:
    """Return the weights of that name, those given, or the standard ones with some of them changed.

    Parameters
    ----------
    reward
        A name, weights, or a dictionary of some of them; None for the standard ones.
    sets
        Of the task, by name.

    Raises
    ------
    ConfigError
        For an unknown name or key, with the nearest known ones.
    """
    if isinstance(reward, str):
        if reward not in sets:
            raise ConfigError(unknown("reward", reward, sets))
        return sets[reward]
    return from_dict(type(sets["standard"]), reward, "reward")


def _paid(weight: float, happened: Any) -> Any:
    """Return what something pays that has happened or not, in one step or in many (N,)."""
    return weight * happened + 0.0  # + 0.0: no negative zero


def goto_reward(
    weights: RewardConfig, progress: float, success: bool, collided: bool, false_arrival: bool
) -> dict[str, float]:
    """Return the terms of one step's reward by name; the reward is their sum.

    Parameters
    ----------
    weights
        What each term pays.
    progress
        Decrease of the geodesic distance to the goal in this step, m.
    success, collided, false_arrival
        What happened in this step.
    """
    return {
        "progress": weights.progress * progress,
        "success": _paid(weights.success, success),
        "time": weights.time,
        "collision": _paid(weights.collision, collided),
        "false_arrival": _paid(weights.false_arrival, false_arrival),
    }


def explore_reward(
    weights: ExploreRewardConfig, recall: float, edges: float, success: bool, collided: bool, false_arrival: bool
) -> dict[str, float]:
    """Return the terms of one step's reward by name; the reward is their sum.

    Parameters
    ----------
    weights
        What each term pays.
    recall, edges
        Increase of the shares of regions mapped and of edges closed in this step.
    success, collided, false_arrival
        What happened in this step.
    """
    return {
        "recall": weights.recall * recall,
        "edges": weights.edges * edges,
        "success": _paid(weights.success, success),
        "time": weights.time,
        "collision": _paid(weights.collision, collided),
        "false_arrival": _paid(weights.false_arrival, false_arrival),
    }


def mission_reward(
    weights: MissionRewardConfig,
    progress: float,
    recall: float,
    edges: float,
    done: bool,
    success: bool,
    collided: bool,
    false_arrival: bool,
) -> dict[str, float]:
    """Return the terms of one step's reward by name; the reward is their sum.

    Parameters
    ----------
    weights
        What each term pays.
    progress
        Decrease in this step of the way through all places, m.
    recall, edges
        Increase in this step of the shares of regions mapped and of edges closed.
    done, success
        The step does an instruction; it is the last one.
    collided, false_arrival
        What happened in this step.
    """
    return {
        "progress": weights.progress * progress,
        "recall": weights.recall * recall,
        "edges": weights.edges * edges,
        "instruction": _paid(weights.instruction, done),
        "success": _paid(weights.success, success),
        "time": weights.time,
        "collision": _paid(weights.collision, collided),
        "false_arrival": _paid(weights.false_arrival, false_arrival),
    }
