"""The ids under which Gymnasium finds the environments. Importing this module loads neither physics nor filter."""

from __future__ import annotations

from typing import Any

TASKS = {
    "GoTo": ("regionslam_env.envs.goto:GoToEnv", "regionslam_env.vector:goto"),
    "Explore": ("regionslam_env.envs.explore:ExploreEnv", "regionslam_env.vector:explore"),
    "Mission": ("regionslam_env.envs.mission:MissionEnv", "regionslam_env.vector:mission"),
}
"""Entry points of the tasks by name: of one environment, and of many."""

VARIANTS: dict[str, dict[str, Any]] = {
    "": {},
    "-Declare": {"arrival": "declare"},
    "-Oracle": {"localization": "oracle"},
    "-Odometry": {"localization": "odometry"},
}
"""Keyword arguments that set a variant of a task apart."""

ENVIRONMENTS: dict[str, dict[str, Any]] = {
    f"RegionSLAM/{task}{variant}-v0": {"entry_point": one, "vector_entry_point": many, "kwargs": kwargs}
    for task, (one, many) in TASKS.items()
    for variant, kwargs in VARIANTS.items()
}
"""What is registered by id; other keyword arguments can be given to `gymnasium.make`."""


def register_envs() -> None:
    """Register every id; called by the entry point `gymnasium.envs` and by ``import regionslam_env``, once or twice."""
    from gymnasium.envs.registration import register, registry

    for env_id, entry in ENVIRONMENTS.items():
        if env_id not in registry:
            # No TimeLimit: the environment counts its own steps, so that the last info always holds the metrics.
            register(env_id, **entry)
