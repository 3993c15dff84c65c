from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.config import SlamConfig
from slam.edge_form import state_size
from slam.innovation import correspond, innovation_covariance, workspace
from slam.paper_innovation import average, innovate_as_set
from tests.slam import naive
from tests.slam.drawn import P, mapped, random_state, sense

PAPER = SlamConfig(geometric_update="paper").parameters()


def innovation(z: np.ndarray, m: np.ndarray, anchor: np.ndarray, pose: np.ndarray, common: np.ndarray) -> np.ndarray:
    """Eqs. (20)-(23): midpoints, rotation about the robot, and means of the differences of common closed edges.

    Rows of one to three rectangles; `common`: by place in the state vector. Along an axis without a common edge the
    difference is left out, and the other one stays in z's axes.
    """
    n = (len(z) - 2) // 3
    expected = naive.seen_from(m, anchor, pose)  # h(m, x) in the robot's frame
    delta = z[0] - expected[0]  # (20)
    differences: tuple[list[float], list[float]] = ([], [])
    along_z, across_z = naive.axes(z[0])
    c, s = np.cos(delta), np.sin(delta)
    for i, (b, t) in enumerate(naive.bt_places(n)):
        k, k1 = naive.u_places(n)[i], naive.u_places(n)[i + 1]
        mids, sizes = [], []
        for row in (z, expected):
            along, across = naive.axes(row[0])
            mids.append(along * (row[k] + row[k1]) / 2 + across * (row[b] + row[t]) / 2)
            sizes.append((row[k1] - row[k], row[t] - row[b]))
        turned = np.array([[c, -s], [s, c]]) @ mids[1]  # (21)
        d_c = np.array([along_z @ (mids[0] - turned), across_z @ (mids[0] - turned)])  # (22)
        half_w, half_h = (sizes[0][0] - sizes[1][0]) / 2, (sizes[0][1] - sizes[1][1]) / 2
        for place, sign in ((k, -1), (k1, 1)):
            if common[place] and not (sign < 0 and i > 0):  # a joint counts once
                differences[0].append(d_c[0] + sign * half_w)
        for place, sign in ((b, -1), (t, 1)):
            if common[place]:
                differences[1].append(d_c[1] + sign * half_h)
    means = [np.mean(d) for d in differences if d]
    if len(means) == 2:
        means = list(along_z * means[0] + across_z * means[1])  # (23)
    return np.array([*means, delta])


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 3), st.integers(0, 2**32 - 1))
def test_innovation_and_its_covariance_are_those_of_the_equations(n: int, seed: int) -> None:
    """Every Jacobian by finite differences: of the pose, the region and the measurement."""
    rng = np.random.default_rng(seed)
    size = state_size(n)
    pose, pose_cov = np.array([0.8, -0.5, 0.3]), naive.random_covariance(rng, 3)
    m = mapped(random_state(rng, n), rng.normal(0, 2, 2), naive.random_covariance(rng, size, 0.05))
    anchor, state = m.anchor.copy(), m.state[:size].copy()
    lines = naive.seen_from(state, anchor, pose) + rng.normal(0, 0.1, size)
    z = sense(lines, naive.random_covariance(rng, size, 0.1), [1, *rng.integers(0, 2, size - 1)])
    m.closed[1:size] = rng.integers(0, 2, size - 1)
    common = (z.closed & m.closed)[:size]
    work = workspace()
    rows, _ = correspond(z, m, 0, pose, 0.01, work, np.inf)
    innovation_covariance(z, m, rows, pose_cov, work)
    rows = average(z, rows, work)
    expected = innovation(lines, state, anchor, pose, common)
    np.testing.assert_allclose(work.residual[:rows], expected, atol=1e-12)

    def of_all(x: np.ndarray) -> np.ndarray:
        return innovation(x[3 + size :], x[3 : 3 + size], anchor, x[:3], common)

    jacobian = naive.derivative(of_all, np.concatenate([pose, state, lines]))
    np.testing.assert_allclose(work.normal[:rows], -jacobian[:, :3], atol=1e-7)
    by_pose, by_m, by_z = np.split(jacobian, [3, 3 + size], axis=1)
    s = by_pose @ pose_cov @ by_pose.T + by_m @ m.cov[:size, :size] @ by_m.T + by_z @ z.cov[:size, :size] @ by_z.T
    np.testing.assert_allclose(np.tril(work.cov[:rows, :rows]), np.tril(s), atol=1e-7)


def test_the_position_part_does_not_depend_on_the_heading_of_the_robot() -> None:
    """NOTES on (21): the expected row is turned about the robot first."""
    rng = np.random.default_rng(1)
    m = mapped(random_state(rng, 2), (3.0, 1.0))
    state, anchor = m.state[:8].copy(), m.anchor.copy()
    lines = naive.seen_from(state, anchor, np.zeros(3)) + 0.05
    common = np.ones(8)
    ours, turned = (innovation(lines, state, anchor, np.array([0, 0, theta]), common) for theta in (0.0, 0.2))
    np.testing.assert_allclose(ours[:2], turned[:2], atol=1e-12)
    assert turned[2] - ours[2] == pytest.approx(0.2)


def test_the_setting_chooses_the_innovation() -> None:
    rng = np.random.default_rng(2)
    m = mapped(random_state(rng, 1), (3.0, 1.0))
    z = sense(naive.seen_from(m.state[:5], m.anchor, np.zeros(3)) + 0.05, np.eye(5) * 0.01)
    for p, expected in ((P, 5), (PAPER, 3)):
        work = workspace()
        rows, _ = correspond(z, m, 0, np.zeros(3), 0.01, work, np.inf)
        rows, distance, _ = innovate_as_set(z, m, rows, np.zeros((3, 3)), work, p)
        assert rows == expected
        assert distance > 0
