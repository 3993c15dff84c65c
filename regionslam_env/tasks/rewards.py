"""Rewards: a sum of named terms, which stand in ``info["reward_terms"]``.

Weights carry the sign; the terms are pure functions of what happened in one step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

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


REWARD_SETS: Mapping[str, RewardConfig] = {
    "standard": RewardConfig(),
    "sparse": RewardConfig(progress=0.0, success=1.0, time=0.0, collision=0.0, false_arrival=0.0),
}
"""Reward weights by name: `standard` leads to the goal, `sparse` pays the success alone."""


def reward_set(reward: str | Mapping[str, Any] | RewardConfig | None) -> RewardConfig:
    """Return the weights of that name, those given, or the standard ones with some of them changed.

    Raises
    ------
    ConfigError
        For an unknown name or key, with the nearest known ones.
    """
    if isinstance(reward, str):
        if reward not in REWARD_SETS:
            raise ConfigError(unknown("reward", reward, REWARD_SETS))
        return REWARD_SETS[reward]
    return from_dict(RewardConfig, reward, "reward")


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
        "success": weights.success if success else 0.0,
        "time": weights.time,
        "collision": weights.collision if collided else 0.0,
        "false_arrival": weights.false_arrival if false_arrival else 0.0,
    }
