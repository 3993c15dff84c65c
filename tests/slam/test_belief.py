from __future__ import annotations

import numpy as np
import pytest

from slam.belief import Belief
from slam.mixture import moments
from tests.slam import naive
from tests.slam.drawn import mapped, maps, particles, stored


def cloud() -> np.ndarray:
    """Three proposals about the heading pi, where angles jump."""
    robots = particles(count=3)
    robots["log_weight"] = np.log([0.2, 0.5, 0.3])
    robots["expected"] = [[0.0, 0.0, np.pi - 0.05], [1.0, 0.5, -np.pi + 0.02], [2.0, -1.0, -np.pi + 0.04]]
    rng = np.random.default_rng(0)
    robots["spread"] = [naive.random_covariance(rng, 3, 0.2) for _ in range(3)]
    return robots


def test_moments_are_those_of_the_mixture() -> None:
    robots, mean, cov = cloud(), np.empty(3), np.empty((3, 3))
    heaviest = moments(robots, mean, cov)
    w = np.array([0.2, 0.5, 0.3])
    poses = robots["expected"].copy()
    poses[0, 2] -= 2 * np.pi  # unwrapped about -pi
    expected = w @ poses
    assert heaviest == 1
    np.testing.assert_allclose(mean[:2], expected[:2])
    assert np.remainder(mean[2] - expected[2] + np.pi, 2 * np.pi) - np.pi == pytest.approx(0, abs=1e-4)
    offset = poses - expected
    spread = np.einsum("i,ij,ik->jk", w, offset, offset) + np.einsum("i,ijk->jk", w, robots["spread"])
    np.testing.assert_allclose(cov, spread, atol=1e-4)


def belief_of(robots: np.ndarray, regions: np.ndarray) -> Belief:
    return Belief(np.zeros(3), np.eye(3), 1.0, np.zeros(3), 0, robots, stored(regions), ["office"], 3)


def test_where_is_a_probability_over_all_particles() -> None:
    """Two of three particles are certain to stand in the room, the third is on its threshold."""
    regions = maps(mapped([0.0, -2, 2, -1, 1]), mapped([0.0, -2, 2, -1, 1], (50, 0)), particles=3)
    regions["sightings"] = 3
    robots = particles(count=3)
    robots["log_weight"] = np.log([0.2, 0.5, 0.3])
    robots["expected"] = [[0, 0, 0], [9, 0, 0], [2, 0, 0]]
    robots["spread"] = np.diag([0.04, 1e-6, 0.01])
    assert belief_of(robots, regions).where() == {100: pytest.approx(0.2 + 0.3 / 2, abs=1e-6)}


def test_where_counts_particles_that_know_the_region() -> None:
    regions = maps(mapped([0.0, -2, 2, -1, 1]), mapped([0.0, -1, 1, -1, 1], (9, 0)), particles=2)
    regions["sightings"] = 3
    regions["n"][1, 0] = 0
    robots = particles(count=2)
    robots["log_weight"] = np.log(0.5)
    assert belief_of(robots, regions).where() == {100: pytest.approx(0.5)}


def test_the_map_holds_confirmed_regions() -> None:
    regions = maps(mapped([0.0, -2, 2, -1, 1]), mapped([0.0, -1, 1, -1, 1], (9, 0)))
    regions["sightings"][0, :2] = 3, 2
    belief = belief_of(particles(), regions)
    assert [m.id for m in belief.map.hypotheses] == [100]
    assert belief.map is belief.map


def test_only_confirmed_and_credible_regions_count() -> None:
    regions = maps(*(mapped([0, -2, 2, -1, 1]) for _ in range(3)))
    regions["sightings"][0, :3] = 3, 2, 5
    regions["rival"][0, 2] = 0
    assert belief_of(particles(), regions).where() == {100: pytest.approx(1.0)}
