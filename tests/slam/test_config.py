from __future__ import annotations

import math

import pytest

from slam.config import SlamConfig
from slam.measurement import MeasurementNoise


def test_probabilities_become_log_odds_and_the_range_a_density() -> None:
    config = SlamConfig(prior_link=0.2, sensor_range=5.0)
    assert config.priors().links[0, 0] == pytest.approx(math.log(0.25))
    assert config.priors().types[0, 0] == 0.0
    assert config.parameters().log_reference == pytest.approx(math.log(1 / 5))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("n_particles", 0),
        ("n_particles", 2.5),
        ("prior_type", 0.0),
        ("prior_link", 1.0),
        ("drawn_share", 1.5),
        ("resample_below", 1.5),
        ("sensor_range", math.inf),
        ("sensor_range", -1.0),
        ("gate_associate", 101.0),
        ("tolerance", 0.0),
        ("tolerance", math.inf),
        ("correspondence", "midpoints"),
        ("link_unseen", math.nan),
        ("geometric_update", "papers"),
        ("confirmed_after", 0),
        ("confirmed_after", True),
        ("existence_seen", -0.1),
        ("existence_missed", math.inf),
        ("existence_floor", 7.0),
        ("existence_ceiling", math.nan),
        ("semantics", "literal"),
    ],
)
def test_a_bad_setting_is_named_with_its_value(field: str, value: object) -> None:
    with pytest.raises(ValueError, match=field) as error:
        SlamConfig(**{field: value})  # type: ignore[arg-type]
    assert str(value) in str(error.value)


def test_tolerance_follows_from_the_noise_unless_given() -> None:
    noise = MeasurementNoise(sigma_xy=0.04)
    assert SlamConfig(measurement_noise=noise).parameters().tolerance == 0.04
    assert SlamConfig(measurement_noise=noise, tolerance=0.2).parameters().tolerance == 0.2
    with pytest.raises(ValueError, match="sigma_xy"):
        SlamConfig(measurement_noise=MeasurementNoise(sigma_xy=0.0))


def test_the_papers_update_knows_drawn_poses_alone() -> None:
    assert SlamConfig(geometric_update="paper").parameters().drawn_share == 1.0
    assert SlamConfig(geometric_update="paper", drawn_share=1.0).parameters().drawn_share == 1.0
    with pytest.raises(ValueError, match=r"drawn_share is 0\.1, expected 1 with geometric_update 'paper'"):
        SlamConfig(geometric_update="paper", drawn_share=0.1)
