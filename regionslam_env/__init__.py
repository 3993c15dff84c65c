"""Gymnasium environments for semantic navigation under SLAM uncertainty.

``import regionslam_env`` registers the environments and loads physics, filter and worlds only when they are asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from regionslam_env.registration import register_envs

if TYPE_CHECKING:
    from regionslam_env.config import SEMANTIC_TYPES, NoiseConfig, RobotConfig, SensorConfig
    from regionslam_env.env import SemanticNavigationEnv
    from regionslam_env.envs import ExploreEnv, GoToEnv, MissionEnv
    from regionslam_env.observations import LinkColumn, RegionColumn, link_table, region_table
    from regionslam_env.tasks.rewards import ExploreRewardConfig, MissionRewardConfig, RewardConfig
    from regionslam_env.worlds.world import World
    from regionslam_env.wrappers import (
        DiscreteActions,
        FlatObservation,
        GraphObservation,
        SemanticActions,
        TextObservation,
    )

__all__ = [
    "SEMANTIC_TYPES",
    "DiscreteActions",
    "ExploreEnv",
    "ExploreRewardConfig",
    "FlatObservation",
    "GoToEnv",
    "GraphObservation",
    "LinkColumn",
    "MissionEnv",
    "MissionRewardConfig",
    "NoiseConfig",
    "RegionColumn",
    "RewardConfig",
    "RobotConfig",
    "SemanticActions",
    "SemanticNavigationEnv",
    "SensorConfig",
    "TextObservation",
    "World",
    "link_table",
    "region_table",
    "register_envs",
]

_HOME = {
    "SEMANTIC_TYPES": "config",
    "DiscreteActions": "wrappers",
    "FlatObservation": "wrappers",
    "GraphObservation": "wrappers",
    "SemanticActions": "wrappers",
    "TextObservation": "wrappers",
    "NoiseConfig": "config",
    "RobotConfig": "config",
    "SensorConfig": "config",
    "SemanticNavigationEnv": "env",
    "ExploreEnv": "envs",
    "GoToEnv": "envs",
    "MissionEnv": "envs",
    "LinkColumn": "observations",
    "RegionColumn": "observations",
    "link_table": "observations",
    "region_table": "observations",
    "ExploreRewardConfig": "tasks.rewards",
    "MissionRewardConfig": "tasks.rewards",
    "RewardConfig": "tasks.rewards",
    "World": "worlds.world",
}


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


register_envs()
