from __future__ import annotations

import numpy as np
import pytest

from slam.resampling import systematic
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
