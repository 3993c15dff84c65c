"""The ids under which Gymnasium finds the environments. Importing this module loads neither physics nor filter."""

from __future__ import annotations

from typing import Any

from regionslam_env.errors import short

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


def option_of(env_id: str) -> str | None:
    """Return the argument that says what is to be done in an environment; None where there is nothing to choose."""
    option: str | None = _class_of(env_id).task_type.option
    return option


def id_of(env_class: type) -> str:
    """Return the first id of a class, its name where it has none."""
    return next((env_id for env_id in ENVIRONMENTS if _class_of(env_id) is env_class), env_class.__name__)


def misplaced(env_id: str, own: str | None, name: str, value: object, dashes: str = "") -> str | None:
    """Return one line on an argument that belongs to environments of another task; None where it does not.

    Parameters
    ----------
    env_id, own
        The environment, and its argument that says what is to be done.
    name, value
        What came.
    dashes
        What stands before the name of an argument.
    """
    other = next((known for known in ENVIRONMENTS if option_of(known) == name), None)
    if name == own or other is None:
        return None
    takes = f"takes {dashes}{own}" if own else "is always the same"
    return f"{dashes}{name} is {short(value)}, but {env_id} {takes}; {other} takes {dashes}{name}"


def _class_of(env_id: str) -> Any:
    from gymnasium.envs.registration import load_env_creator

    return load_env_creator(ENVIRONMENTS[env_id]["entry_point"])


def register_envs() -> None:
    """Register every id; called by the entry point `gymnasium.envs` and by ``import regionslam_env``, once or twice."""
    from gymnasium.envs.registration import register, registry

    for env_id, entry in ENVIRONMENTS.items():
        if env_id not in registry:
            # No TimeLimit: the environment counts its own steps, so that the last info always holds the metrics.
            register(env_id, **entry)
