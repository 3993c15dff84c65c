from __future__ import annotations

import numpy as np
import pytest

from slam.edge_form import state_size
from slam.innovation import (
    condition,
    correspond,
    innovate,
    is_admissible,
    log_likelihood,
    n_closed,
    workspace,
    wrap,
)
from tests.slam import naive
from tests.slam.drawn import mapped, random_state, sense

POSE = np.array([0.8, -0.5, 0.3])
SLACK = 0.1**2


def pair(seed: int, n: int) -> tuple[np.record, np.record, np.ndarray]:
    """A mapped region, a noisy measurement of it from `POSE`, and the region's covariance."""
    rng = np.random.default_rng(seed)
    size = state_size(n)
    m = mapped(random_state(rng, n), rng.normal(0, 2, 2), naive.random_covariance(rng, size, 0.05))
    lines = naive.seen_from(m.state[:size], m.anchor, POSE) + rng.normal(0, 0.05, size)
    return sense(lines, naive.random_covariance(rng, size, 0.1)), m, m.cov[:size, :size].copy()


def rows_of(z: np.record, m: np.record, offset: int = 0, pose: np.ndarray = POSE) -> tuple[int, float, np.record]:
    work = workspace()
    rows, violation = correspond(z, m, offset, pose, SLACK, work, np.inf)
    return rows, violation, work


@pytest.mark.parametrize("n", [1, 2, 3])
def test_residuals_are_measured_minus_expected_lines(n: int) -> None:
    z, m, _ = pair(1, n)
    rows, violation, work = rows_of(z, m)
    size = state_size(n)
    assert (rows, violation) == (size, 0.0)
    expected = z.state[:size] - naive.seen_from(m.state[:size], m.anchor, POSE)
    np.testing.assert_allclose(work.residual[np.argsort(work.im[:rows])], expected, atol=1e-12)
    np.testing.assert_array_equal(work.iz[:rows], work.im[:rows])


@pytest.mark.parametrize("n", [1, 2, 3])
def test_jacobian_is_that_of_finite_differences(n: int) -> None:
    z, m, _ = pair(2, n)
    rows, _, work = rows_of(z, m)
    size = state_size(n)
    places = work.im[:rows]

    def expected(x: np.ndarray) -> np.ndarray:
        return naive.seen_from(x[3:], m.anchor, x[:3])[places]

    jacobian = naive.derivative(expected, [*POSE, *m.state[:size]])
    np.testing.assert_allclose(work.normal[:rows], jacobian[:, :3], atol=1e-8)
    by_state = np.zeros((rows, size))
    for r in range(rows):
        by_state[r, 0] += work.lever[r]
        by_state[r, places[r]] += 1.0
    np.testing.assert_allclose(by_state, jacobian[:, 3:], atol=1e-8)


def linear_model(z: np.record, m: np.record, rows: int, work: np.record) -> tuple[np.ndarray, ...]:
    """H of the pose, H of the region and R of the measurement, as matrices."""
    size = state_size(m.n)
    h = np.zeros((rows, size))
    for r in range(rows):
        h[r, work.im[r]] += 1.0
        h[r, 0] += work.lever[r]
    places = work.iz[:rows]
    return work.normal[:rows].copy(), h, z.cov[np.ix_(places, places)]


@pytest.mark.parametrize("n", [1, 2, 3])
def test_innovation_is_that_of_linear_algebra(n: int) -> None:
    z, m, cov = pair(3, n)
    rows, _, work = rows_of(z, m)
    pose_cov = naive.random_covariance(np.random.default_rng(0), 3)
    h_pose, h, noise = linear_model(z, m, rows, work)
    residual = work.residual[:rows].copy()
    s = h_pose @ pose_cov @ h_pose.T + h @ cov @ h.T + noise
    distance, log_det = innovate(z, m, rows, pose_cov, work)
    assert distance == pytest.approx(residual @ np.linalg.inv(s) @ residual)
    assert log_det == pytest.approx(np.linalg.slogdet(s)[1])
    reference = -np.log(2 * np.pi) - 3.0 * (rows - 1)
    assert log_likelihood(distance, log_det, rows, -3.0) == pytest.approx(naive.log_density(residual, s) - reference)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_conditioning_is_the_textbook_kalman_update(n: int) -> None:
    z, m, cov = pair(4, n)
    rows, _, work = rows_of(z, m)
    size = state_size(n)
    _, h, noise = linear_model(z, m, rows, work)
    mean, expected_cov = naive.kalman(m.state[:size], cov, h, work.residual[:rows], noise)
    innovate(z, m, rows, np.zeros((3, 3)), work)
    work.gain[:rows, :size] = h @ cov
    condition(m.state, m.cov, size, rows, work)
    np.testing.assert_allclose(m.state[:size], mean, atol=1e-12)
    np.testing.assert_allclose(m.cov[:size, :size], expected_cov, atol=1e-12)
    np.testing.assert_array_equal(m.cov, m.cov.T)


def test_equal_weights_give_the_innovation_of_the_paper() -> None:
    """Eqs. (20)-(23) for two rectangles with all edges closed."""
    rng = np.random.default_rng(5)
    w, h, w_hat, h_hat = rng.uniform(1, 4, 4)
    z, z_hat = np.array([2.0, 1.0, 0.4]), np.array([1.7, 1.3, 0.31])
    delta = z[2] - z_hat[2]
    c, s = np.cos(delta), np.sin(delta)
    rotated = np.array([[c, -s], [s, c]]) @ z_hat[:2]  # (21)
    along, across = naive.axes(z[2])
    d = np.array([along @ (z[:2] - rotated), across @ (z[:2] - rotated)])  # (22)
    d_x = [d[0] - (w - w_hat) / 2, d[0] + (w - w_hat) / 2]
    d_y = [d[1] - (h - h_hat) / 2, d[1] + (h - h_hat) / 2]

    seen = naive.edges_from_parameters(np.array([z[0], z[1], w, h, z[2]]), False, False)
    expected = naive.edges_from_parameters(np.array([z_hat[0], z_hat[1], w_hat, h_hat, z_hat[2]]), False, False)
    rows, _, work = rows_of(sense(seen, np.eye(5)), mapped(expected), pose=np.zeros(3))
    residual = dict(zip(work.im[:rows].tolist(), work.residual, strict=False))
    assert residual[0] == pytest.approx(delta)
    assert [residual[1], residual[2]] == pytest.approx(d_x)
    assert [residual[3], residual[4]] == pytest.approx(d_y)


def test_open_edges_give_no_row() -> None:
    m = mapped([0, -2, 2, -1, 1], open_edges=[2])
    z = sense(np.array([0.0, -2, 1, -1, 1]), np.eye(5) * 0.01, closed=[1, 1, 0, 1, 0])
    rows, violation, work = rows_of(z, m, pose=np.zeros(3))
    assert violation == 0.0
    assert work.im[:rows].tolist() == [0, 1, 3]
    assert n_closed(z) == 3


def test_a_view_beyond_a_closed_edge_violates_it() -> None:
    m = mapped([0, -2, 2, -1, 1], cov=0.02)
    z = sense(np.array([0.0, -1, 2.5, -1, 1]), np.eye(5) * 0.01, closed=[1, 0, 0, 1, 1])
    _, violation, _ = rows_of(z, m, pose=np.zeros(3))
    assert violation == pytest.approx(0.5**2 / (0.02 + 0.01 + SLACK))  # the left end, inside, is no violation
    open_right = mapped([0, -2, 2, -1, 1], cov=0.02, open_edges=[2])
    z = sense(np.array([0.0, -2, 1.7, -1, 1]), np.eye(5) * 0.01)
    _, violation, _ = rows_of(z, open_right, pose=np.zeros(3))
    assert violation == pytest.approx(0.3**2 / (0.01 + SLACK))


def test_rectangles_that_do_not_meet_are_penalised() -> None:
    m = mapped([0, -2, 0, -1, 1], open_edges=[2])
    z = sense(np.array([0.0, 0.5, 2, -1, 1]), np.eye(5) * 0.01, closed=[1, 0, 0, 1, 1])
    _, violation, _ = rows_of(z, m, pose=np.zeros(3))
    assert violation >= 0.5**2 / (2 * SLACK)


@pytest.mark.parametrize(
    ("nz", "nm", "offset", "open_z", "open_m", "admissible"),
    [
        (1, 1, 0, "", "", True),
        (2, 1, 0, "", "", False),  # z goes on where m has ended
        (2, 1, 0, "", "r", True),
        (2, 1, -1, "", "r", False),
        (2, 1, -1, "", "l", True),
        (1, 3, 1, "lr", "", True),  # a glimpse of the middle
        (1, 3, 1, "l", "", False),  # its closed right end meets the third rectangle
        (1, 3, 0, "r", "", True),
        (1, 3, 2, "l", "", True),
        (3, 1, -1, "", "lr", True),
        (2, 2, 1, "l", "r", True),
        (2, 2, -1, "r", "l", True),
        (3, 2, 1, "l", "r", False),  # four rectangles
        (3, 2, -2, "r", "l", False),
        (3, 2, -1, "", "l", True),
    ],
)
def test_alignments_that_can_be(nz: int, nm: int, offset: int, open_z: str, open_m: str, admissible: bool) -> None:
    rng = np.random.default_rng(0)

    def row(n: int, sides: str) -> np.record:
        ends = {"l": 1, "r": (2, 5, 8)[n - 1]}
        return mapped(random_state(rng, n), open_edges=[ends[side] for side in sides])

    assert is_admissible(row(nz, open_z), row(nm, open_m), offset) == admissible


def test_early_exit_gives_up_on_one_hopeless_edge() -> None:
    m = mapped([0, -2, 2, -1, 1], cov=0.01)
    z = sense(np.array([0.0, -2, 3, -1, 1]), np.eye(5) * 0.01)
    work = workspace()
    assert correspond(z, m, 0, np.zeros(3), 0.0, work, 49.0)[0] == -1  # 1 / 0.02 = 50
    assert correspond(z, m, 0, np.zeros(3), 0.0, work, 51.0)[0] == 5


def test_likelihoods_are_alike_in_every_unit_of_length() -> None:
    """With the reference density in the same unit, more or fewer rows."""
    both = []
    for unit in (1.0, 1000.0):
        scores = []
        for lines, closed in (([0.05, -2.1, 2.2, -1, 1.1], [1, 1, 1, 1, 1]), ([0.05, -2.1, 2, -1, 1], [1, 1, 0, 0, 0])):
            lengths = np.array([1, unit, unit, unit, unit])
            m = mapped(np.array([0, -2, 2, -1, 1]) * lengths, cov=0.01 * np.diag(lengths**2))
            z = sense(np.array(lines) * lengths, 0.02 * np.diag(lengths**2), closed)
            rows, _, work = rows_of(z, m, pose=np.zeros(3))
            distance, log_det = innovate(z, m, rows, np.zeros((3, 3)), work)
            scores.append(log_likelihood(distance, log_det, rows, -np.log(8 * unit)))
        both.append(scores)
    assert both[0] == pytest.approx(both[1])


def test_wrap() -> None:
    assert wrap(np.pi + 0.1) == pytest.approx(-np.pi + 0.1)
    assert wrap(-3 * np.pi - 0.1) == pytest.approx(np.pi - 0.1)
