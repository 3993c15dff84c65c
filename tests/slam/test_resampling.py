from __future__ import annotations

import numpy as np
import pytest

from slam.resampling import SCHEMES, ancestors_of, residual, stratified, systematic
from tests.slam import naive


@pytest.mark.parametrize("seed", range(5))
def test_ancestors_are_those_of_walking_along_the_weights(seed: int) -> None:
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(9) * 0.3)
    uniform = rng.random()
    ancestors = systematic(weights, uniform)
    assert ancestors.tolist() == naive.systematic(weights, uniform)
    counts = np.bincount(ancestors, minlength=9)
    assert np.all(counts >= np.floor(9 * weights - 1e-9))
    assert np.all(counts <= np.ceil(9 * weights + 1e-9))


def test_equal_weights_keep_everyone() -> None:
    for uniform in (0.0, 0.5, 0.999999):
        assert systematic(np.full(4, 0.25), uniform).tolist() == [0, 1, 2, 3]


def test_a_cumulative_sum_below_one_is_survived() -> None:
    weights = np.full(10, 0.1)
    assert np.cumsum(weights)[-1] < 1.0
    assert systematic(weights, 1 - 1e-16).max() == 9
    assert systematic(weights * 0.9, 0.999999).tolist() == list(range(10))


def test_a_particle_without_weight_has_no_descendant() -> None:
    assert systematic(np.array([0.0, 1.0, 0.0]), 0.0).tolist() == [1, 1, 1]
    assert systematic(np.array([0.0, 1.0, 0.0]), 0.999999).tolist() == [1, 1, 1]


def test_counts_are_unbiased() -> None:
    weights = np.array([0.5, 0.3, 0.15, 0.05])
    counts = np.zeros(4)
    for uniform in (np.arange(2000) + 0.5) / 2000:
        counts += np.bincount(systematic(weights, uniform), minlength=4)
    np.testing.assert_allclose(counts / 2000, 4 * weights, atol=0.002)


@pytest.mark.parametrize("scheme", range(len(SCHEMES)))
@pytest.mark.parametrize("seed", range(3))
def test_every_scheme_expects_each_ancestor_in_proportion_to_its_weight(scheme: int, seed: int) -> None:
    """Means of 4,000 draws, within five standard errors of a multinomial draw, the widest of all."""
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.full(7, 0.5))
    draws = [ancestors_of(weights, scheme, rng.random(7)) for _ in range(4000)]
    counts = np.array([np.bincount(ancestors, minlength=7) for ancestors in draws])
    assert (counts.sum(axis=1) == 7).all()
    error = np.sqrt(7 * weights * (1 - weights) / 4000)
    assert np.all(np.abs(counts.mean(axis=0) - 7 * weights) < 5 * error + 1e-12)


def test_the_residual_scheme_keeps_what_is_due() -> None:
    rng = np.random.default_rng(0)
    weights = np.array([0.5, 0.25, 0.15, 0.1])
    for _ in range(50):
        counts = np.bincount(residual(weights, rng.random(4)), minlength=4)
        assert counts[0] >= 2
        assert counts[1] >= 1
    assert residual(np.full(10, 0.1), rng.random(10)).tolist() == list(range(10))


def test_strata_have_numbers_of_their_own() -> None:
    weights = np.array([0.375, 0.625])
    assert stratified(weights, np.array([0.9, 0.0])).tolist() == [1, 1]
    assert stratified(weights, np.array([0.0, 0.9])).tolist() == [0, 1]
