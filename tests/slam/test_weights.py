from __future__ import annotations

import numpy as np
import pytest

from slam.weights import normalise, weights
from tests.slam.drawn import particles


def test_weights_sum_to_one_however_small_they_are() -> None:
    w = weights(np.array([-2000.0, -2000.0 + np.log(3.0)]))
    np.testing.assert_allclose(w, [0.25, 0.75])


def test_normalising_returns_the_effective_sample_size() -> None:
    robots = particles(count=4)
    robots["log_weight"] = np.log([4.0, 2.0, 1.0, 1.0]) - 5000.0
    ess = normalise(robots)
    np.testing.assert_allclose(np.exp(robots["log_weight"]), [0.5, 0.25, 0.125, 0.125])
    assert ess == pytest.approx(1 / (0.25 + 0.0625 + 2 * 0.015625))


def test_effective_sample_size_lies_between_one_and_all() -> None:
    robots = particles(count=8)
    robots["log_weight"] = 3.0
    assert normalise(robots) == pytest.approx(8.0)
    robots["log_weight"][3] = 800.0
    assert normalise(robots) == pytest.approx(1.0)
