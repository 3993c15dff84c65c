"""The ids under which Gymnasium finds the environments. Importing this module loads neither physics nor filter."""

from __future__ import annotations

from typing import Any

ENTRY_POINT = "regionslam_env.env:SemanticNavigationEnv"

ENVIRONMENTS: dict[str, dict[str, Any]] = {
    "RegionSLAM/GoTo-v0": {"arrival": "stay"},
    "RegionSLAM/GoTo-Declare-v0": {"arrival": "declare"},
    "RegionSLAM/GoTo-Oracle-v0": {"arrival": "stay", "localization": "oracle"},
    "RegionSLAM/GoTo-Odometry-v0": {"arrival": "stay", "localization": "odometry"},
    "RegionSLAM/Explore-v0": {"task": "explore", "arrival": "stay", "max_steps": 6000},
    "RegionSLAM/Explore-Declare-v0": {"task": "explore", "arrival": "declare", "max_steps": 6000},
    "RegionSLAM/Explore-Oracle-v0": {
        "task": "explore",
        "arrival": "stay",
        "max_steps": 6000,
        "localization": "oracle",
    },
    "RegionSLAM/Explore-Odometry-v0": {
        "task": "explore",
        "arrival": "stay",
        "max_steps": 6000,
        "localization": "odometry",
    },
}
"""Keyword arguments that set each id apart; the rest of them can be given to `gymnasium.make`."""


def register_envs() -> None:
    """Register every id; called by the entry point `gymnasium.envs` and by ``import regionslam_env``, once or twice."""
    from gymnasium.envs.registration import register, registry

    for env_id, kwargs in ENVIRONMENTS.items():
        if env_id not in registry:
            # No TimeLimit: the environment counts its own steps, so that the last info always holds the metrics.
            register(env_id, entry_point=ENTRY_POINT, kwargs=kwargs)
