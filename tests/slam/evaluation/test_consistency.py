"""Normalised errors, and chi-square quantiles against printed tables."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slam.evaluation.consistency import chi_square_cdf, chi_square_quantile, nees, nees_band, nis, pooled, pose_nees

# Abramowitz and Stegun 1964, table 26.8, and NIST/SEMATECH e-Handbook, 1.3.6.7.4.
TABLE = [
    (0.005, 1, 3.92704e-5),
    (0.025, 1, 9.82069e-4),
    (0.95, 1, 3.84146),
    (0.99, 1, 6.63490),
    (0.95, 2, 5.99146),
    (0.025, 3, 0.215795),
    (0.95, 3, 7.81473),
    (0.975, 3, 9.34840),
    (0.05, 10, 3.94030),
    (0.95, 10, 18.3070),
    (0.05, 20, 10.8508),
    (0.995, 30, 53.6720),
    (0.025, 100, 74.2219),
    (0.975, 100, 129.561),
]


@pytest.mark.parametrize(("probability", "freedom", "value"), TABLE)
def test_quantiles_of_the_tables(probability: float, freedom: int, value: float) -> None:
    assert chi_square_quantile(probability, freedom) == pytest.approx(value, rel=4e-6)


@pytest.mark.parametrize("probability", [1e-6, 0.025, 0.5, 0.999999])
def test_two_degrees_of_freedom_are_an_exponential(probability: float) -> None:
    assert chi_square_quantile(probability, 2) == pytest.approx(-2 * math.log1p(-probability), rel=1e-10)


@pytest.mark.parametrize("freedom", [0.3, 1, 7, 400, 30_000])
@pytest.mark.parametrize("probability", [1e-4, 0.025, 0.5, 0.975, 0.9999])
def test_the_quantile_undoes_the_distribution(probability: float, freedom: float) -> None:
    assert chi_square_cdf(chi_square_quantile(probability, freedom), freedom) == pytest.approx(probability, rel=1e-8)


@pytest.mark.parametrize(("probability", "freedom"), [(0, 1), (1, 1), (0.5, 0), (float("nan"), 1)])
def test_impossible_quantiles_are_refused(probability: float, freedom: float) -> None:
    with pytest.raises(ValueError, match="expected"):
        chi_square_quantile(probability, freedom)


def test_nees_is_the_squared_mahalanobis_distance() -> None:
    covariance = np.array([[4.0, 1.0], [1.0, 2.0]])
    error = np.array([1.0, -3.0])
    assert nees(error, covariance) == pytest.approx(error @ np.linalg.inv(covariance) @ error)
    np.testing.assert_allclose(nees([[2.0], [3.0]], [[[4.0]], [[1.0]]]), [1.0, 9.0])


def test_nees_of_a_certain_filter() -> None:
    assert nees([0.0, 0.0], np.zeros((2, 2))) == 0
    assert nees([0.1, 0.0], np.zeros((2, 2))) == math.inf


def test_nees_refuses_shapes_that_dont_fit() -> None:
    with pytest.raises(ValueError, match=r"need covariances of shape \(5, 3, 3\), got \(5, 2, 2\)"):
        nees(np.zeros((5, 3)), np.zeros((5, 2, 2)))


def test_pose_nees_wraps_the_heading() -> None:
    assert pose_nees((0, 0, 3.1), np.eye(3), (0, 0, -3.1)) == pytest.approx((2 * math.pi - 6.2) ** 2)


def test_the_band_of_one_value_is_that_of_the_table() -> None:
    assert nees_band(1, 3) == pytest.approx((0.215795, 9.34840), rel=1e-5)


def test_consistent_errors_lie_in_the_band_and_overconfident_ones_above() -> None:
    rng = np.random.default_rng(7)
    covariance = np.array([[0.04, 0.01, 0.0], [0.01, 0.09, 0.002], [0.0, 0.002, 0.001]])
    errors = rng.multivariate_normal(np.zeros(3), covariance, size=500)
    low, high = nees_band(500, 3)
    assert low < 3 < high and high - low < 0.5
    assert low < nees(errors, np.broadcast_to(covariance, (500, 3, 3))).mean() < high
    assert nees(errors, np.broadcast_to(covariance / 1.2, (500, 3, 3))).mean() > high


def test_values_of_different_dimensions_are_pooled() -> None:
    rng = np.random.default_rng(0)
    freedoms = rng.integers(1, 8, 300)
    values = rng.chisquare(freedoms)
    fine = pooled(values, freedoms, 0.999)
    assert fine.low < fine.ratio < fine.high and fine.freedom == freedoms.sum()
    assert pooled(1.3 * values, freedoms, 0.999).ratio > fine.high
    assert pooled(0.7 * values, freedoms, 0.999).ratio < fine.low
    by_hand = pooled([4.0, 8.0, 0.0], [3, 1, 0])
    assert by_hand.ratio == 3.0
    assert (by_hand.low, by_hand.high) == pytest.approx([x / 4 for x in (0.484419, 11.1433)], rel=1e-5)
    for wrong in (([1.0], [0]), ([1.0], [1, 2])):
        with pytest.raises(ValueError, match="at least one degree of freedom"):
            pooled(*wrong)


def test_innovations_with_their_own_covariance_are_chi_square() -> None:
    rng = np.random.default_rng(1)
    s = np.array([[0.04, 0.01], [0.01, 0.02]])
    values = nis(rng.multivariate_normal([0, 0], s, 500), np.broadcast_to(s, (500, 2, 2)))
    low, high = nees_band(500, 2, 0.999)
    assert low < np.mean(values) < high
