"""Settings of robot, sensors, noise and what moves: frozen dataclasses of plain data, SI units, angles in radians.

Every one of them can be built from a dictionary with `from_dict`, which names the nearest known key for an unknown one.
"""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, TypeVar

from regionslam_env.errors import ConfigError, unknown
from slam.measurement import MeasurementNoise
from slam.motion import MotionNoise

C = TypeVar("C")

SEMANTIC_TYPES = (
    "hallway",
    "office",
    "kitchen",
    "laboratory",
    "meeting room",
    "toilet",
    "storage",
    "classroom",
    "lobby",
    "stairs",
    "elevator",
    "entrance",
    "service room",
    "living room",
    "bedroom",
    "ward",
    "outdoor",
    "door",
    "desk",
    "cupboard",
    "table",
    "bed",
    "sofa",
    "other",
)
"""Semantic types that an observation can tell apart. The filter's are free text: an unlisted one counts as the last."""


LARGEST = 1e4
"""Values above this are no setting of a robot, in no unit: a slip, or more than fits into memory."""


@dataclass(frozen=True)
class RobotConfig:
    """A round differential-drive robot.

    Parameters
    ----------
    radius
        Of the footprint, m.
    max_speed
        Forwards and backwards, m/s; also the highest speed of a wheel.
    max_turn_rate
        In both directions, rad/s.
    max_acceleration
        Of each wheel, m/s²: of the robot where it drives straight on.
    wheel_base
        Distance of the wheels, m.
    mass
        In kg; matters where the robot pushes furniture.
    step
        Duration of one environment step, s.
    substeps
        Physics steps in one environment step.
    """

    radius: float = 0.2
    max_speed: float = 1.0
    max_turn_rate: float = 2.0
    max_acceleration: float = 2.0
    wheel_base: float = 0.3
    mass: float = 20.0
    step: float = 0.1
    substeps: int = 10

    def __post_init__(self) -> None:
        for name in ("radius", "max_speed", "max_turn_rate", "max_acceleration", "wheel_base", "mass", "step"):
            _positive(self, name)
        _positive(self, "substeps")
        _whole(self, "substeps")


@dataclass(frozen=True)
class SensorConfig:
    """What the sensors see.

    Parameters
    ----------
    range
        Of the region sensor, m.
    field_of_view
        Of the region sensor, centred ahead, rad; 2 pi sees all around.
    n_view_rays
        Rays of the visible polygon.
    occlusion
        Whether walls hide regions from the region sensor.
    confidence
        Stated probability that a measured type is right.
    link_confidence
        Stated probability that a measured link exists.
    closed_length
        Length of an edge that has to be seen for it to count as seen, m; half of the edge where it is shorter.
    edge_tolerance
        Largest distance between a wall and the annotated edge on it, m.
    n_lidar_rays
        Rays of the lidar, evenly over a full turn; the first one looks straight back, the middle one ahead.
    lidar_range
        Of the lidar, m.
    """

    range: float = 8.0
    field_of_view: float = 2 * math.pi
    n_view_rays: int = 360
    occlusion: bool = True
    confidence: float = 0.9
    link_confidence: float = 0.9
    closed_length: float = 0.3
    edge_tolerance: float = 0.2
    n_lidar_rays: int = 180
    lidar_range: float = 10.0

    def __post_init__(self) -> None:
        for name in ("range", "field_of_view", "n_view_rays", "closed_length", "edge_tolerance", "n_lidar_rays"):
            _positive(self, name)
        _positive(self, "lidar_range")
        for name in ("n_view_rays", "n_lidar_rays"):
            _whole(self, name)
        if self.n_view_rays < 8:
            raise ConfigError(f"n_view_rays is {self.n_view_rays}, expected at least 8")
        if self.field_of_view > 2 * math.pi:
            raise ConfigError(f"field_of_view is {self.field_of_view} rad, expected at most 2 pi")
        for name in ("confidence", "link_confidence"):
            _probability(self, name)


@dataclass(frozen=True)
class NoiseConfig:
    """Noise of every sensor, as told to the filter, and how much more the simulation draws.

    Parameters
    ----------
    odometry
        Variances that grow with the motion, told to the filter.
    regions
        Standard deviations told to the filter.
    lidar_sigma
        Standard deviation of a lidar ray, m.
    simulated_factor
        Variance of the simulated over that of the told region noise (Oberländer et al. 2008, section IV-B); 0 for exact
        measurements.
    odometry_factor
        The same for odometry.
    misclassification
        Probability that a measurement tells a wrong type.
    misses
        Probability that a visible region is not measured.
    false_positives
        Expected number of invented regions per scan.
    """

    odometry: MotionNoise = field(default_factory=MotionNoise)
    regions: MeasurementNoise = field(default_factory=MeasurementNoise)
    lidar_sigma: float = 0.02
    simulated_factor: float = 1.2
    odometry_factor: float = 1.0
    misclassification: float = 0.0
    misses: float = 0.0
    false_positives: float = 0.0

    def __post_init__(self) -> None:
        for name in ("lidar_sigma", "simulated_factor", "odometry_factor", "false_positives"):
            _not_negative(self, name)
        for name in ("misclassification", "misses"):
            _probability(self, name)
        for part in ("odometry", "regions"):
            for entry in dataclasses.fields(getattr(self, part)):
                _not_negative(self, f"{part}.{entry.name}")
        if self.regions.sigma_xy == 0:
            raise ConfigError(
                "regions.sigma_xy is 0, expected a length above 0: the filter has to be told some noise "
                "(simulated_factor=0 makes measurements exact)"
            )


def noise_set(noise: str | Mapping[str, Any] | NoiseConfig) -> NoiseConfig:
    """Return the noise set of that name, the one given, or the standard one with some of its values changed.

    Raises
    ------
    ConfigError
        For an unknown name or key, with the nearest known ones.
    """
    if isinstance(noise, str):
        if noise not in NOISE_SETS:
            raise ConfigError(unknown("noise set", noise, NOISE_SETS))
        return NOISE_SETS[noise]
    return from_dict(NoiseConfig, noise, "noise")


@dataclass(frozen=True)
class DynamicsConfig:
    """What moves in a world beside the robot; by default nothing does.

    Parameters
    ----------
    people
        How many walk about; fewer where there is no free place for so many.
    walking_speed
        Of a person, m/s.
    person_radius
        Of a person, m.
    closing_doors
        Share of the doors that close and open again.
    time_open, time_closed
        How long such a door stays open and closed on average, s.
    movable_furniture
        Share of the furniture that can be pushed.
    furniture_mass
        Of a piece of furniture, kg: a robot that pushes one of its own mass goes on at half its speed.
    """

    people: int = 0
    walking_speed: float = 0.8
    person_radius: float = 0.25
    closing_doors: float = 0.0
    time_open: float = 20.0
    time_closed: float = 8.0
    movable_furniture: float = 0.0
    furniture_mass: float = 10.0

    def __post_init__(self) -> None:
        _not_negative(self, "people")
        _whole(self, "people")
        for name in ("walking_speed", "person_radius", "time_open", "time_closed", "furniture_mass"):
            _positive(self, name)
        for name in ("closing_doors", "movable_furniture"):
            _probability(self, name)

    @property
    def still(self) -> bool:
        """Whether nothing moves at all."""
        return not (self.people or self.closing_doors or self.movable_furniture)


def dynamics_set(dynamics: str | Mapping[str, Any] | DynamicsConfig | None) -> DynamicsConfig:
    """Return the dynamics of that name, those given, or none at all with some values changed.

    Raises
    ------
    ConfigError
        For an unknown name or key, with the nearest known ones.
    """
    if isinstance(dynamics, str):
        if dynamics not in DYNAMICS_SETS:
            raise ConfigError(unknown("dynamics", dynamics, DYNAMICS_SETS))
        return DYNAMICS_SETS[dynamics]
    return from_dict(DynamicsConfig, dynamics, "dynamics")


def from_dict(config: type[C], values: Mapping[str, Any] | C | None, where: str) -> C:
    """Build a configuration from a dictionary (nested where the configuration is), one given, or None for the default.

    Parameters
    ----------
    config
        The dataclass.
    values
        Keys are the names of its fields; those left out keep their defaults.
    where
        What to call it in an error.

    Raises
    ------
    ConfigError
        For an unknown key, with the nearest known ones, and for a value of the wrong type or range.
    """
    if values is None:
        return config()
    if isinstance(values, config):
        return values
    if not isinstance(values, Mapping):
        raise ConfigError(f"{where} is {values!r}, expected a dictionary or {config.__name__}")
    types = typing.get_type_hints(config)
    arguments: dict[str, Any] = {}
    for key, value in values.items():
        if key not in types:
            raise ConfigError(unknown(f"key of {where}", str(key), types))
        arguments[key] = _convert(types[key], value, f"{where}.{key}")
    try:
        return config(**arguments)
    except ValueError as error:  # most begin with the field, some of the filter's own settings do not
        first = str(error).partition(" ")[0].partition(".")[0]
        raise ConfigError(f"{where}{'.' if first in types else ': '}{error}") from None


def _convert(kind: Any, value: Any, where: str) -> Any:
    """Return a value as its field's type, or refuse it."""
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        return from_dict(kind, value, where)
    if kind is bool:
        if isinstance(value, bool):
            return value
        raise ConfigError(f"{where} is {value!r}, expected true or false")
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ConfigError(f"{where} is {value!r}, expected a number") from None
    if isinstance(value, bool | str):
        raise ConfigError(f"{where} is {value!r}, expected a number")
    if not math.isfinite(number):
        raise ConfigError(f"{where} is {value!r}, expected a finite number")
    if kind is int:
        if number != int(number):
            raise ConfigError(f"{where} is {value!r}, expected a whole number")
        return int(number)
    return number


def _positive(config: Any, name: str) -> None:
    value = getattr(config, name)
    if not 0 < value <= LARGEST:
        raise ConfigError(f"{name} is {value}, expected a number above 0 and up to {LARGEST:g}")


def _not_negative(config: Any, name: str) -> None:
    value = attrgetter(name)(config)
    if not 0 <= value <= LARGEST:
        raise ConfigError(f"{name} is {value}, expected a number of at least 0 and up to {LARGEST:g}")


def _probability(config: Any, name: str) -> None:
    value = getattr(config, name)
    if not 0 <= value <= 1:
        raise ConfigError(f"{name} is {value}, expected a probability in [0, 1]")


def _whole(config: Any, name: str) -> None:
    value = getattr(config, name)
    if value != int(value):
        raise ConfigError(f"{name} is {value}, expected a whole number")


NOISE_SETS: Mapping[str, NoiseConfig] = {
    "standard": NoiseConfig(),
    "heavy": NoiseConfig(MotionNoise(0.0025, 0.0004, 0.0025), MeasurementNoise(0.15, 0.20, 0.05)),
    "none": NoiseConfig(lidar_sigma=0.0, simulated_factor=0.0, odometry_factor=0.0),
}
"""Noise sets by name. `none` simulates no noise at all and tells the filter the standard one."""

DYNAMICS_SETS: Mapping[str, DynamicsConfig] = {
    "none": DynamicsConfig(),
    "people": DynamicsConfig(people=8),
    "doors": DynamicsConfig(closing_doors=0.5),
    "furniture": DynamicsConfig(movable_furniture=1.0),
    "all": DynamicsConfig(people=8, closing_doors=0.5, movable_furniture=1.0),
}
"""Dynamics by name."""
