"""What users give to an environment: checked, with the nearest known names for what is unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from regionslam_env.config import RobotConfig, from_dict
from regionslam_env.errors import ConfigError, unknown

T = TypeVar("T")

OPTIONS = ("goal", "start", "world_seed")
"""What `reset(options=...)` takes."""

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


def read_options(options: Mapping[str, Any] | None) -> tuple[str | None, Sequence[float] | None, int | None]:
    """Return goal, start pose and world seed of `reset(options=...)`; `ConfigError` for an unknown option."""
    options = options or {}
    for name in options:
        one_of("option of reset", name, OPTIONS)
    return options.get("goal"), options.get("start"), options.get("world_seed")
