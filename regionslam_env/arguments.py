"""What users give to an environment: checked, with the nearest known names for what is unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, TypeVar

from regionslam_env.actions import Arrival
from regionslam_env.belief import Localization
from regionslam_env.config import DynamicsConfig, NoiseConfig, RobotConfig, from_dict
from regionslam_env.errors import ConfigError, unknown
from regionslam_env.missions.mission import Mission
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.world import World

T = TypeVar("T")


class CommonArguments(TypedDict, total=False):
    """Keyword arguments that every environment takes; see `regionslam_env.env.SemanticNavigationEnv`."""

    world: str | Path | World
    world_options: Mapping[str, Any] | WorldOptions | None
    split: str
    localization: Localization
    arrival: Arrival
    n_particles: int
    sensor_range: float
    occlusion: bool
    sensors: Mapping[str, Any] | None
    robot: str | Mapping[str, Any] | RobotConfig
    noise: str | Mapping[str, Any] | NoiseConfig
    dynamics: str | Mapping[str, Any] | DynamicsConfig | None
    max_regions: int
    semantic_types: Sequence[str]
    reveal_truth: bool
    render_mode: str | None


class ResetOptions(NamedTuple):
    """What `reset(options=...)` takes.

    Parameters
    ----------
    goal
        Semantic type to go to.
    mission
        In words, or as a `Mission`.
    start
        True pose (x, y, theta) in the world frame, m and rad.
    world_seed
        Number of the world to enter.
    keep_map
        Whether the filter keeps its map.
    """

    goal: str | None = None
    mission: str | Mission | None = None
    start: Sequence[float] | None = None
    world_seed: int | None = None
    keep_map: bool = False

    def wanted(self, option: str | None) -> Any:
        """Return the value of the option that says what is to be done, None where it is not given.

        Raises
        ------
        ConfigError
            For a value of another one.
        """
        for name in ("goal", "mission"):
            value = getattr(self, name)
            if value is not None and name != option:
                instead = "this task is always the same" if option is None else f"this task takes a {option}"
                raise ConfigError(f"{name} is {value!r}, expected none: {instead}")
        return None if option is None else getattr(self, option)


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
