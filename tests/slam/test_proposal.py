from __future__ import annotations

import numpy as np
import pytest

from slam.edge_form import state_size
from slam.motion import Odometry
from slam.proposal import draw, place, predict, propose
from slam.region import REGION
from slam.se2 import compose
from slam.turning import turn
from tests.slam import naive
from tests.slam.drawn import P, links_to, mapped, maps, particles, random_state, sense, stored

NOISE = (0.0009, 0.0001, 0.0009)


@pytest.mark.parametrize("odometry", [(0.1, 0.0, 0.02), (-0.3, 0.1, -0.5), (0.0, 0.0, 0.4), (0.0, 0.0, 0.0)])
def test_prediction_is_that_of_the_textbook_ekf(odometry: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(1)
    pose, cov = np.array([1.0, -2.0, 2.5]), naive.random_covariance(rng, 3)
    robots = particles(pose, cov, count=2)
    predict(robots, *odometry, *NOISE)
    mean, expected = naive.predict(pose, cov, np.array(odometry), np.array(NOISE))
    np.testing.assert_allclose(robots[1].pose, mean, atol=1e-9)
    np.testing.assert_allclose(robots[1].cov, expected, atol=1e-9)
    np.testing.assert_array_equal(robots[0].cov, robots[0].cov.T)
    np.testing.assert_array_equal(robots["expected"], robots["pose"])
    np.testing.assert_array_equal(robots["spread"], robots["cov"])


def test_motion_composes_and_a_robot_at_rest_stays_certain() -> None:
    robots = particles((1, 2, 3.0))
    for _ in range(10):
        predict(robots, 0.2, 0.0, 0.3, 0.0, 0.0, 0.0)
    pose = np.array([1, 2, 3.0])
    for _ in range(10):
        pose = compose(pose, (0.2, 0.0, 0.3))
    np.testing.assert_allclose(robots[0].pose, pose, atol=1e-9)
    predict(robots, 0.0, 0.0, 0.0, *NOISE)
    assert not robots["cov"].any()
    assert Odometry(1.0) == Odometry(1.0, 0.0, 0.0)


def test_draws_have_the_proposals_covariance() -> None:
    """The pose is linear in the numbers, so unit vectors give the columns of a root of the covariance."""
    cov = naive.random_covariance(np.random.default_rng(2), 3, 0.01)
    pose = np.array([1.0, 2.0, 0.7])
    robots = particles(pose, cov, count=4)
    draw(robots, np.vstack([np.zeros(3), np.eye(3)]), 1.0)
    np.testing.assert_allclose(robots[0].pose, pose, atol=1e-14)
    root = (robots["pose"][1:] - pose).T
    np.testing.assert_allclose(root @ root.T, cov, atol=1e-14)
    assert not robots["cov"].any()


@pytest.mark.parametrize("share", [0.0, 0.01, 0.4, 1.0])
def test_what_is_drawn_and_what_stays_make_up_the_proposal(share: float) -> None:
    cov = naive.random_covariance(np.random.default_rng(2), 3, 0.01)
    pose = np.array([1.0, 2.0, 0.7])
    robots = particles(pose, cov, count=3)
    draw(robots, np.eye(3), share)
    root = (robots["pose"] - pose).T
    np.testing.assert_allclose(root @ root.T, share * cov, atol=1e-14)
    for robot in robots:
        np.testing.assert_allclose(root @ root.T + robot["cov"], cov, atol=1e-14)


def test_draws_of_a_flat_covariance_stay_in_its_plane() -> None:
    """A straight drive knows nothing but its length and heading; nothing may become NaN."""
    robots = particles((0, 0, 0.7))
    predict(robots, 1.0, 0.0, 0.0, 0.01, 0.0, 0.0)
    draw(robots, np.ones((1, 3)), 1.0)
    np.testing.assert_allclose(robots[0].pose, [1.1 * np.cos(0.7), 1.1 * np.sin(0.7), 0.7], atol=1e-9)
    draw(robots, np.ones((1, 3)), 1.0)
    assert np.all(np.isfinite(robots[0].pose))


def test_draws_count_along_the_robots_axes() -> None:
    """The same motion and the same numbers give the same step, wherever the map frame points."""
    steps = []
    for heading in (0.0, 2.0):
        robots = particles((0, 0, heading))
        predict(robots, 0.5, 0.1, 0.3, *NOISE)
        draw(robots, np.array([[0.3, -1.2, 0.8]]), 1.0)
        x, y, theta = robots[0].pose
        c, s = np.cos(heading), np.sin(heading)
        steps.append((c * x + s * y, c * y - s * x, theta - heading))
    assert steps[0] == pytest.approx(steps[1], abs=1e-9)


def scene(seed: int) -> tuple[np.ndarray, np.ndarray, list[np.record], list[np.record], list[np.ndarray]]:
    """A pose belief, three mapped regions, noisy measurements of them, and the regions' covariances."""
    rng = np.random.default_rng(seed)
    pose, cov = np.array([0.5, -0.4, 0.3]), naive.random_covariance(rng, 3, 0.1)
    regions, scan, covs = [], [], []
    for n in (1, 2, 3):
        size = state_size(n)
        covs.append(naive.random_covariance(rng, size, 0.05))
        covs[-1][0, :] = covs[-1][:, 0] = 0.0  # of a known heading the lines are linear in the pose and themselves
        regions.append(mapped(random_state(rng, n), rng.normal(0, 3, 2), covs[-1]))
        lines = naive.seen_from(regions[-1].state[:size], regions[-1].anchor, pose) + rng.normal(0, 0.05, size)
        closed = np.ones(size, int)
        closed[[1, 3]] = 0  # partial
        scan.append(sense(lines, naive.random_covariance(rng, size, 0.1), closed))
    return pose, cov, regions, scan, covs


def stacked(
    pose: np.ndarray, regions: list[np.record], scan: list[np.record], covs: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Jacobian of the pose, residuals, and their covariance for a certain pose, of all closed edges at once."""
    jacobians, residuals, blocks = [], [], []
    for z, m, cov in zip(scan, regions, covs, strict=True):
        size = state_size(m.n)
        closed = np.flatnonzero(z.closed[:size])
        anchor = m.anchor.copy()

        def by_pose(x: np.ndarray, m: np.record = m, a: np.ndarray = anchor, size: int = size) -> np.ndarray:
            return naive.seen_from(m.state[:size], a, x)

        def by_state(x: np.ndarray, a: np.ndarray = anchor) -> np.ndarray:
            return naive.seen_from(x, a, pose)

        h = naive.derivative(by_state, m.state[:size])
        jacobians.append(naive.derivative(by_pose, pose)[closed])
        residuals.append((z.state[:size] - by_pose(pose))[closed])
        blocks.append((h @ cov @ h.T + z.cov[:size, :size])[np.ix_(closed, closed)])
    noise = np.zeros((sum(map(len, blocks)),) * 2)
    at = 0
    for block in blocks:
        noise[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return np.vstack(jacobians), np.concatenate(residuals), noise


@pytest.mark.parametrize("seed", range(3))
def test_proposal_is_the_batch_posterior_and_the_weight_its_marginal_likelihood(seed: int) -> None:
    pose, cov, regions, scan, covs = scene(seed)
    h, residual, noise = stacked(pose, regions, scan, covs)
    mean, posterior = naive.kalman(pose, cov, h, residual, noise)
    robots = particles(pose, cov)
    records = np.zeros((3, 4), REGION)
    records[:, 0] = scan
    propose(robots, stored(maps(*regions)), records, links_to((0, 0, 0, 0), (1, 0, 0, 0), (2, 0, 0, 0)), P)
    np.testing.assert_allclose(robots[0].pose, mean, atol=1e-7)
    np.testing.assert_allclose(robots[0].cov, posterior, atol=1e-9)
    np.testing.assert_array_equal(robots[0].cov, robots[0].cov.T)
    np.testing.assert_allclose(robots[0].expected, mean, atol=1e-7)
    np.testing.assert_allclose(robots[0].spread, posterior, atol=1e-9)
    reference = (3 - len(residual)) * np.log(P.sensor_range) - 3 * np.log(2 * np.pi)
    assert robots[0].log_weight == pytest.approx(naive.log_density(residual, h @ cov @ h.T + noise) - reference)


def test_descriptions_of_a_pair_do_not_change_the_proposal() -> None:
    pose, cov, regions, scan, _ = scene(0)
    results = []
    for quarters in (0, 2):
        records = np.zeros((1, 4), REGION)
        records[0, 0] = scan[2]
        turn(records[0, 0], 2, records[0, 2])
        m = regions[2]
        if quarters == 2:
            other = np.zeros(1, REGION)[0]
            turn(m, 2, other)
            m = other
        robots = particles(pose, cov)
        propose(robots, stored(maps(m)), records, links_to((0, quarters, 0, 0)), P)
        results.append((*robots[0].pose, robots[0].log_weight))
    assert results[0] == pytest.approx(results[1], abs=1e-9)


def test_an_unexplained_measurement_counts_nothing() -> None:
    pose, cov, _, scan, _ = scene(0)
    for slot in (-1, -2):
        robots = particles(pose, cov)
        records = np.zeros((1, 4), REGION)
        records[0, 0] = scan[2]
        propose(robots, stored(maps()), records, links_to((slot, 0, 0, 0)), P)
        np.testing.assert_array_equal(robots[0].pose, pose)
        assert robots[0].log_weight == 0.0


def test_a_given_pose_is_certain() -> None:
    robots = particles((0, 0, 0), 0.1, count=3)
    place(robots, np.array([1.0, 2.0, 0.5]))
    assert robots["pose"].tolist() == robots["expected"].tolist() == [[1.0, 2.0, 0.5]] * 3
    assert not robots["cov"].any()
    assert not robots["spread"].any()
