"""What users give to an environment: checked, with the nearest known names for what is unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from regionslam_env.config import RobotConfig, from_dict
from regionslam_env.errors import ConfigError, unknown

T = TypeVar("T")


class ResetOptions(NamedTuple):
    """What `reset(options=...)` takes.

    Parameters
    ----------
    goal
        Semantic type to go to.
    start
        True pose (x, y, theta) in the world frame, m and rad.
    world_seed
        Number of the world to enter.
    keep_map
        Whether the filter keeps its map.
    """

    goal: str | None = None
    start: Sequence[float] | None = None
    world_seed: int | None = None
    keep_map: bool = False


ROBOTS: Mapping[str, RobotConfig] = {"standard": RobotConfig()}
"""Robots by name."""


def one_of(kind: str, value: T, known: Sequence[T]) -> T:
    """Return a value that is known; `ConfigError` with the nearest names if it is not."""
    if value not in known:
        raise ConfigError(unknown(kind, value, map(str, known)))
    return value


def whole_number(name: str, value: int) -> int:
    """Return a whole number of at least 1; `ConfigError` for anything else."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ConfigError(f"{name} is {value!r}, expected a whole number of at least 1")
    return value


def robot_config(robot: str | Mapping[str, Any] | RobotConfig) -> RobotConfig:
    """Return the robot of that name, the one given, or the standard one with some of its values changed."""
    if isinstance(robot, str):
        return ROBOTS[one_of("robot", robot, tuple(ROBOTS))]
    return from_dict(RobotConfig, robot, "robot")


def read_options(options: Mapping[str, Any] | None) -> ResetOptions:
    """Return the options of `reset(options=...)`; `ConfigError` for an unknown one."""
    options = options or {}
    for name in options:
        one_of("option of reset", name, ResetOptions._fields)
    read = ResetOptions(**options)
    if not isinstance(read.keep_map, bool):
        raise ConfigError(f"keep_map is {read.keep_map!r}, expected True or False")
    return read
