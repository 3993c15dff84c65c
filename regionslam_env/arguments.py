"""What users give to an environment: checked, with the nearest known names for what is unknown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, TypeVar

from regionslam_env.actions import Arrival
from regionslam_env.belief import Localization
from regionslam_env.config import DynamicsConfig, NoiseConfig, RobotConfig, SensorConfig, from_dict
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


FARTHEST = 1000.0
"""Range of the region sensor at most, m; observations are clipped there."""

ROBOTS: Mapping[str, RobotConfig] = {"standard": RobotConfig()}
"""Robots by name."""


def one_of(kind: str, value: T, known: Sequence[T]) -> T:
    """Return a value that is known; `ConfigError` with the nearest names if it is not."""
    if not isinstance(value, str) or value not in known:
        raise ConfigError(unknown(kind, value, map(str, known)))
    return value


def whole_number(name: str, value: int, most: float = math.inf) -> int:
    """Return a whole number of at least 1; `ConfigError` for anything else."""
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
        limit = "of at least 1" if most == math.inf else f"from 1 to {most}"
        raise ConfigError(f"{name} is {value!r}, expected a whole number {limit}")
    return value


def yes_or_no(name: str, value: bool) -> bool:
    """Return a truth value; `ConfigError` for anything else."""
    if not isinstance(value, bool):
        raise ConfigError(f"{name} is {value!r}, expected True or False")
    return value


def sensor_config(sensor_range: float, occlusion: bool, sensors: Mapping[str, Any] | None) -> SensorConfig:
    """Return the sensors of that range and occlusion, with some of the other values changed."""
    if sensors is not None and not isinstance(sensors, Mapping):
        raise ConfigError(f"sensors is {sensors!r}, expected a dictionary")
    number = isinstance(sensor_range, int | float) and not isinstance(sensor_range, bool)
    if not number or not 0 < sensor_range <= FARTHEST:
        raise ConfigError(f"sensor_range is {sensor_range!r}, expected a length above 0 and up to {FARTHEST:g} m")
    own = {"range": sensor_range, "occlusion": yes_or_no("occlusion", occlusion)}
    return from_dict(SensorConfig, own | dict(sensors or {}), "sensors")


def robot_config(robot: str | Mapping[str, Any] | RobotConfig) -> RobotConfig:
    """Return the robot of that name, the one given, or the standard one with some of its values changed."""
    if isinstance(robot, str):
        return ROBOTS[one_of("robot", robot, tuple(ROBOTS))]
    return from_dict(RobotConfig, robot, "robot")


def read_options(options: Mapping[str, Any] | None) -> ResetOptions:
    """Return the options of `reset(options=...)`; `ConfigError` for an unknown one."""
    if options is not None and not isinstance(options, Mapping):
        raise ConfigError(f"options is {options!r}, expected a dictionary")
    options = options or {}
    for name in options:
        one_of("option of reset", name, ResetOptions._fields)
    read = ResetOptions(**options)
    yes_or_no("keep_map", read.keep_map)
    return read
