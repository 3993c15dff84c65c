from __future__ import annotations

import numpy as np
import pytest

from slam.innovation import correspond, innovate, workspace
from slam.joint_geometry import write_marginal
from slam.joint_rows import relative_covariance, write_rows, write_twin_rows
from slam.joint_update import Rows, condition
from slam.region import MAX_STATE
from tests.slam import naive
from tests.slam.drawn import mapped, measured, random_measurement, random_state, sense
from tests.slam.joint import joint_of
from tests.slam.test_joint_update import dense, motions

CERTAIN = np.zeros((3, 3))


def measured_lines(z: np.ndarray, phi: float) -> np.ndarray:
    """The lines of a measured row when its midpoint stays and its heading is `phi`."""
    n = (len(z) - 2) // 3
    main = n // 2
    middle = np.array([z[naive.u_places(n)[main : main + 2]].mean(), z[list(naive.bt_places(n)[main])].mean()])
    point = np.array(naive.axes(z[0])).T @ middle
    shift = np.array(naive.axes(phi)) @ point - middle
    out = z.copy()
    out[0] = phi
    out[naive.u_places(n)] += shift[0]
    out[[k for pair in naive.bt_places(n) for k in pair]] += shift[1]
    return out


@pytest.mark.parametrize("n", [1, 2, 3])
def test_rows_are_residuals_and_their_derivatives(n: int) -> None:
    rng = np.random.default_rng(n)
    state = random_state(rng, n)
    joint = joint_of(rng, state, pose=(0.5, -1.0, 0.4))
    anchor, size = joint.anchors[0], joint.used
    z = naive.seen_from(state, anchor, joint.mean[:3]) + 0.05 * rng.normal(size=len(state))

    def residual(x: np.ndarray) -> np.ndarray:
        m = x[3 : 3 + len(state)]
        expected = naive.seen_from(m, anchor, x[:3])
        out = measured_lines(z, m[0] - x[2]) - expected
        out[0] = z[0] - expected[0]
        return out

    rows = Rows.empty(MAX_STATE)
    count = write_rows(sense(z, np.eye(len(z)) * 0.01), mapped(state, anchor), 0, joint, 0, 0, rows)
    rows = rows.first(count)
    order = [int(np.flatnonzero(joint.entries[0] == place)[0]) for place in rows.places[:, 4]]
    np.testing.assert_allclose(rows.residual, residual(joint.mean[:size])[order], atol=1e-12)
    expected = -naive.derivative(residual, joint.mean[:size])[order]
    np.testing.assert_allclose(dense(rows, size), expected, atol=1e-7)


@pytest.mark.parametrize("n", [1, 3])
def test_the_noise_is_that_of_the_parameters_without_the_headings(n: int) -> None:
    """Freeze the heading, and edges are linear in midpoint and sizes."""
    rng = np.random.default_rng(n)
    z = random_measurement(rng, n)
    lines = measured(z)[0, 0]
    size = 2 + 3 * n
    state = lines.state[:size].copy()
    joint = joint_of(rng, state, pose=(0, 0, 0), anchors=[(0, 0)])
    rows = Rows.empty(MAX_STATE)
    count = write_rows(lines, mapped(state, (0, 0)), 0, joint, 0, 0, rows)
    rows = rows.first(count)
    parameters = [z.x, z.y, z.w, z.h, z.phi]
    covariances = [z.cov_xy, z.cov_wh, [[z.var_phi]]]
    for sub in (z.left, z.right):
        if sub is not None:
            parameters += [sub.w, sub.h, sub.y]
            covariances += [sub.cov_wh, [[sub.var_y]]]
    total = np.zeros((len(parameters), len(parameters)))
    start = 0
    for block in map(np.asarray, covariances):
        total[start : start + len(block), start : start + len(block)] = block
        start += len(block)
    jacobian = naive.derivative(
        lambda p: naive.edges_from_parameters(p, z.left is not None, z.right is not None), parameters
    )
    jacobian[1:, 4] = 0.0
    order = [int(np.flatnonzero(joint.entries[0] == place)[0]) for place in rows.places[:, 4]]
    np.testing.assert_allclose(rows.noise, (jacobian @ total @ jacobian.T)[np.ix_(order, order)], atol=1e-8)


def test_relative_covariance_gives_association_the_joint_innovation() -> None:
    """Pose and region are correlated; data association, which knows a region's record alone, must not miss it."""
    rng = np.random.default_rng(4)
    state = random_state(rng, 2)
    joint = joint_of(rng, state)
    n, anchor = joint.used, joint.anchors[0]
    pose = joint.mean[:3].copy()
    cov = naive.random_covariance(rng, len(state), 0.05)
    z = sense(naive.seen_from(state, anchor, pose), cov)
    m = mapped(state, anchor)
    relative_covariance(m, joint, 0)
    work = workspace()
    rows, _ = correspond(z, m, 0, pose, 0.01, work, np.inf)
    h = np.zeros((rows, n))
    h[:, :3] = work.normal[:rows]
    for r in range(rows):
        h[r, joint.entries[0, work.im[r]]] += 1.0
        h[r, joint.entries[0, 0]] += work.lever[r]
    expected = h @ joint.cov[:n, :n] @ h.T + cov[np.ix_(work.iz[:rows], work.iz[:rows])]
    innovate(z, m, rows, CERTAIN, work)
    factor = np.tril(work.cov[:rows, :rows])
    np.testing.assert_allclose(factor @ factor.T, expected, atol=1e-9)


def test_an_edge_seen_for_the_first_time_is_what_pose_heading_and_noise_make_it() -> None:
    """From a flat prior; the exact result is the limit, computed here by writing the edge as a function of the rest."""
    rng = np.random.default_rng(5)
    state = random_state(rng, 1)
    joint = joint_of(rng, state, open_edges=[2], pose=(0.2, 0.1, 0.3))
    n, anchor = joint.used, joint.anchors[0]
    m = mapped(state, anchor)
    z = naive.seen_from(state, anchor, joint.mean[:3]) + 0.05 * rng.normal(size=5)
    cov = naive.random_covariance(rng, 5, 0.1)
    rows = Rows.empty(MAX_STATE)
    count = write_rows(sense(z, cov), m, 0, joint, 0, 0, rows)
    rows = rows.first(count)
    assert rows.fresh.tolist() == [False] * 4 + [True]
    prior, h = joint.cov[:n, :n].copy(), dense(rows, n + 1)
    edge = joint.entries[0, 2]
    assert edge == n and h[4, edge] == 1.0
    # 0 = h_4 x + e - e_0 + v_4; with x and all noise as one Gaussian, the four other rows condition e.
    whole = np.zeros((n + 5, n + 5))
    whole[:n, :n], whole[n:, n:] = prior, rows.noise
    to_all = np.eye(n + 1, n + 5)
    to_all[n, :n], to_all[n, n:] = -h[4, :n], [0, 0, 0, 0, -1]
    to_rows = np.hstack([h[:4, :n], np.eye(4, 5)])
    mean, whole = naive.kalman(np.zeros(n + 5), whole, to_rows, rows.residual[:4], np.zeros((4, 4)))
    expected_mean = joint.mean[: n + 1] + to_all @ mean
    expected = to_all @ whole @ to_all.T
    centre, before = joint.mean[:2].copy(), joint.mean[: n + 1].copy()
    condition(joint, rows)
    carried = np.eye(n + 1)
    carried[:, :3] += motions(joint, centre) - motions(joint, centre, before)
    np.testing.assert_allclose(joint.mean[: n + 1], expected_mean, atol=1e-6)
    np.testing.assert_allclose(joint.cov[: n + 1, : n + 1], carried @ expected @ carried.T, atol=1e-6)


def test_twins_become_one_region() -> None:
    rng = np.random.default_rng(6)
    state = random_state(rng, 1)
    other = state + 0.02 * rng.normal(size=5)
    anchors = ((2.0, 1.0), (2.3, 0.9))
    other[1:] -= [naive.axes(state[0])[a] @ np.array([0.3, -0.1]) for a in (0, 0, 1, 1)]
    joint = joint_of(rng, state, other, anchors=anchors, scale=0.03)
    m, twin = mapped(state, anchors[0]), mapped(other, anchors[1])
    rows = Rows.empty(MAX_STATE)
    count = write_twin_rows(twin, m, 0, joint, 1, 0, 0.01, rows)
    np.testing.assert_allclose(dense(rows.first(count), joint.used) @ motions(joint, (9.0, 1.0)), 0.0, atol=1e-8)
    for _ in range(2):
        condition(joint, rows.first(count))
        count = write_twin_rows(twin, m, 0, joint, 1, 0, 0.01, rows)
    write_marginal(joint, 0, m, 0.1)
    write_marginal(joint, 1, twin, 0.1)
    seen = naive.seen_from(m.state[:5], anchors[0], (*anchors[1], 0.0))
    np.testing.assert_allclose(seen[1:], twin.state[1:5], atol=1e-3)
    assert np.cos(seen[0] - twin.state[0]) == pytest.approx(1.0)
