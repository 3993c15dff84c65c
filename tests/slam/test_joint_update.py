from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import ArrayLike

from slam.joint_gaussian import JointGaussian
from slam.joint_rows import write_rows
from slam.joint_update import Rows, condition, scene_motions
from slam.region import MAX_STATE
from tests.slam import naive
from tests.slam.drawn import mapped, random_state, sense
from tests.slam.joint import joint_of

Floats = np.ndarray


def rows_of(rng: np.random.Generator, joint: JointGaussian, states: list[Floats]) -> Rows:
    """Noisy measurements of all regions at their means."""
    rows, n = Rows.empty(MAX_STATE * len(states)), 0
    for slot, state in enumerate(states):
        anchor = joint.anchors[slot]
        size = len(state)
        cov = naive.random_covariance(rng, size, 0.1)
        seen = naive.seen_from(state, anchor, joint.mean[:3]) + 0.1 * rng.normal(size=size)
        n = write_rows(sense(seen, cov), mapped(state, anchor), 0, joint, slot, n, rows)
    return rows.first(n)


def dense(rows: Rows, size: int) -> Floats:
    h = np.zeros((len(rows.residual), size))
    for r in range(len(h)):
        for place, coefficient in zip(rows.places[r], rows.coefficient[r], strict=True):
            h[r, place] += coefficient
    return h


def moved(mean: Floats, joint: JointGaussian, motion: Floats, centre: ArrayLike) -> Floats:
    """The mean after pose and map have been turned about a centre and shifted; anchors stay where they are."""
    c, s = np.cos(motion[2]), np.sin(motion[2])
    rotation, centre = np.array([[c, -s], [s, c]]), np.asarray(centre)
    out = mean.copy()
    out[:2] = rotation @ (mean[:2] - centre) + centre + motion[:2]
    out[2] += motion[2]
    for slot in range(len(joint.entries)):
        entries, anchor = joint.entries[slot], joint.anchors[slot]
        if entries[0] < 0:
            continue
        out[entries[0]] += motion[2]
        for k in np.flatnonzero(entries[1:] >= 0) + 1:
            axis = 0 if k in naive.u_places(3) else 1
            before, after = naive.axes(mean[entries[0]])[axis], naive.axes(mean[entries[0]] + motion[2])[axis]
            on_line = rotation @ (anchor + before * mean[entries[k]] - centre) + centre + motion[:2]
            out[entries[k]] = after @ (on_line - anchor)
    return out


def motions(joint: JointGaussian, centre: ArrayLike, mean: Floats | None = None) -> Floats:
    """Derivative of the mean by shift and turn of the scene, shape (used, 3)."""
    at = joint.mean[: joint.used] if mean is None else mean
    return naive.derivative(lambda motion: moved(at, joint, motion, centre), np.zeros(3))


@pytest.mark.parametrize("seed", range(4))
def test_an_update_is_the_textbook_one_that_carries_the_scenes_motions_along(seed: int) -> None:
    rng = np.random.default_rng(seed)
    states = [random_state(rng, n) for n in (1, 3, 2)]
    joint = joint_of(rng, *states)
    rows, n = rows_of(rng, joint, states), joint.used
    before, prior = joint.mean[:n].copy(), joint.cov[:n, :n].copy()
    h = dense(rows, n)
    mean, cov = naive.kalman(before, prior, h, rows.residual, rows.noise)
    a = np.eye(n)
    a[:, :3] += motions(joint, before[:2], mean) - motions(joint, before[:2], before)
    distance, log_det, known = condition(joint, rows)
    np.testing.assert_allclose(joint.mean[:n], mean, atol=1e-9)
    np.testing.assert_allclose(joint.cov[:n, :n], a @ cov @ a.T, atol=1e-8)
    np.testing.assert_array_equal(joint.cov, joint.cov.T)
    innovation = h @ prior @ h.T + rows.noise
    assert known == len(rows.residual)
    assert distance == pytest.approx(rows.residual @ np.linalg.solve(innovation, rows.residual))
    assert log_det == pytest.approx(np.linalg.slogdet(innovation)[1])


def test_beyond_the_gate_nothing_changes() -> None:
    rng = np.random.default_rng(5)
    states = [random_state(rng, 1)]
    joint = joint_of(rng, *states)
    rows = rows_of(rng, joint, states)
    before = joint.copy()
    distance = condition(joint, rows, gate=0.0)[0]
    assert distance > 0.0
    np.testing.assert_array_equal(joint.cov, before.cov)
    np.testing.assert_array_equal(joint.mean, before.mean)


def test_the_scenes_motions_are_those_of_finite_differences() -> None:
    rng = np.random.default_rng(6)
    joint = joint_of(rng, random_state(rng, 3), random_state(rng, 1), open_edges=[1, 4])
    out = np.zeros((3, joint.used))
    scene_motions(joint, np.array([1.0, -2.0]), out)
    np.testing.assert_allclose(out.T, motions(joint, (1.0, -2.0)), atol=1e-8)


def test_no_row_knows_how_the_scene_is_turned_or_shifted() -> None:
    rng = np.random.default_rng(7)
    states = [random_state(rng, 3), random_state(rng, 1)]
    joint = joint_of(rng, *states)
    rows = rows_of(rng, joint, states)
    np.testing.assert_allclose(dense(rows, joint.used) @ motions(joint, (3.0, 1.0)), 0.0, atol=1e-8)


def test_scans_of_a_map_leave_the_place_of_the_scene_unknown() -> None:
    """A hundred updates at estimates that move must not teach what no measurement tells."""
    rng = np.random.default_rng(8)
    states = [random_state(rng, 1), random_state(rng, 1)]
    joint = joint_of(rng, *states, scale=1e-3)
    n = joint.used
    # All that is uncertain is where the scene is, beside a little of everything else.
    spread = motions(joint, (-20.0, 30.0)) * [0.2, 0.3, 0.05]
    joint.cov[:n, :n] += spread @ spread.T
    prior, truth = joint.cov[:3, :3].copy(), joint.mean[:n].copy()
    for _ in range(100):
        rows, k = Rows.empty(2 * MAX_STATE), 0
        for slot in range(2):
            seen = naive.seen_from(truth[joint.entries[slot, :5]], joint.anchors[slot], truth[:3])
            z = sense(seen + 0.03 * rng.normal(size=5), np.eye(5) * 0.03**2)
            m = mapped(joint.mean[joint.entries[slot, :5]], joint.anchors[slot])
            k = write_rows(z, m, 0, joint, slot, k, rows)
        condition(joint, rows.first(k))
    np.testing.assert_allclose(joint.cov[:3, :3], prior, rtol=0.01, atol=1e-5)
