import math

import pytest

from regionslam_env.config import (
    DYNAMICS_SETS,
    NOISE_SETS,
    SEMANTIC_TYPES,
    DynamicsConfig,
    NoiseConfig,
    RobotConfig,
    SensorConfig,
    dynamics_set,
    from_dict,
    noise_set,
)
from regionslam_env.errors import ConfigError
from slam.measurement import MeasurementNoise
from slam.motion import MotionNoise


def test_the_noise_sets_of_the_notes():
    standard, heavy = noise_set("standard"), noise_set("heavy")
    assert standard.regions == MeasurementNoise(0.10, 0.15, 0.03)
    assert standard.odometry == MotionNoise(0.0009, 0.0001, 0.0009)
    assert heavy.regions == MeasurementNoise(0.15, 0.20, 0.05)
    assert heavy.odometry == MotionNoise(0.0025, 0.0004, 0.0025)
    assert standard.simulated_factor == heavy.simulated_factor == 1.2
    assert standard == NoiseConfig()


def test_no_noise_is_simulated_under_none():
    none = NOISE_SETS["none"]
    assert none.simulated_factor == none.odometry_factor == none.lidar_sigma == 0


def test_a_dictionary_changes_what_it_names():
    robot = from_dict(RobotConfig, {"radius": 0.3, "substeps": 5.0}, "robot")
    assert robot == RobotConfig(radius=0.3, substeps=5)
    assert isinstance(robot.substeps, int)
    noise = noise_set({"odometry": {"distance": 0.1}, "misses": 0.2})
    assert noise.odometry == MotionNoise(distance=0.1)
    assert noise.misses == 0.2
    assert noise.regions == MeasurementNoise()


def test_defaults_and_given_ones():
    assert from_dict(RobotConfig, None, "robot") == RobotConfig()
    given = SensorConfig(range=5.0)
    assert from_dict(SensorConfig, given, "sensor") is given


@pytest.mark.parametrize(
    ("config", "values", "message"),
    [
        (RobotConfig, {"radios": 1}, "unknown key of robot 'radios': did you mean 'radius'"),
        (NoiseConfig, {"odometry": {"distanc": 1}}, "unknown key of robot.odometry 'distanc': did you mean 'distance'"),
        (RobotConfig, {"radius": -1}, "robot.radius is -1"),
        (RobotConfig, {"radius": math.nan}, "robot.radius is nan, expected a finite number"),
        (RobotConfig, {"radius": "wide"}, "robot.radius is 'wide', expected a number"),
        (RobotConfig, {"radius": None}, "robot.radius is None, expected a number"),
        (RobotConfig, {"substeps": 2.5}, "robot.substeps is 2.5, expected a whole number"),
        (SensorConfig, {"occlusion": "yes"}, "robot.occlusion is 'yes', expected true or false"),
        (SensorConfig, {"confidence": 1.5}, "robot.confidence is 1.5, expected a probability"),
        (SensorConfig, {"field_of_view": 7.0}, "robot.field_of_view is 7.0 rad"),
        (SensorConfig, {"n_view_rays": 3}, "robot.n_view_rays is 3"),
        (NoiseConfig, {"misses": -0.1}, "robot.misses is -0.1"),
        (NoiseConfig, {"regions": {"sigma_xy": -1.0}}, "robot.regions.sigma_xy is -1.0"),
        (NoiseConfig, {"odometry": {"distance": -1}}, "robot.odometry: motion noise: distance is -1"),
        (NoiseConfig, {"regions": {"sigma_xy": 0}}, "robot.regions.sigma_xy is 0"),
        (NoiseConfig, {"odometry": {"distance": 1e5}}, "robot.odometry.distance is 100000.0, expected a number of at"),
        (NoiseConfig, 3, "robot is 3, expected a dictionary or NoiseConfig"),
    ],
)
def test_what_cannot_be_is_refused(config, values, message):
    with pytest.raises(ConfigError, match="^" + message.replace("(", r"\(")):
        from_dict(config, values, "robot")


def test_an_unknown_noise_set_names_the_nearest():
    with pytest.raises(ConfigError, match="unknown noise set 'havy': did you mean 'heavy'"):
        noise_set("havy")


def test_types_end_with_other():
    assert SEMANTIC_TYPES[-1] == "other"
    assert len(set(SEMANTIC_TYPES)) == len(SEMANTIC_TYPES)


def test_nothing_moves_by_default():
    assert dynamics_set(None) == dynamics_set("none") == dynamics_set({}) == DynamicsConfig()
    assert [name for name, dynamics in DYNAMICS_SETS.items() if dynamics.still] == ["none"]
    assert dynamics_set({"people": 3}) == DynamicsConfig(people=3)


@pytest.mark.parametrize(
    ("dynamics", "message"),
    [
        ("peple", "unknown dynamics 'peple': did you mean 'people'"),
        ({"persons": 1}, "unknown key of dynamics 'persons'"),
        ({"people": -1}, "dynamics.people is -1, expected a number of at least 0"),
        ({"people": 1.5}, "dynamics.people is 1.5, expected a whole number"),
        ({"closing_doors": 1.5}, r"dynamics.closing_doors is 1.5, expected a probability in \[0, 1\]"),
        ({"time_closed": 0}, "dynamics.time_closed is 0.0, expected a number above 0"),
        ({"furniture_mass": math.inf}, "dynamics.furniture_mass is inf, expected a finite number"),
        (3, "dynamics is 3, expected a dictionary or DynamicsConfig"),
    ],
)
def test_bad_dynamics_are_refused(dynamics, message):
    with pytest.raises(ConfigError, match="^" + message):
        dynamics_set(dynamics)
