from __future__ import annotations

import numpy as np
import pytest

from slam.growth import shift_right
from slam.joint_gaussian import (
    JointGaussian,
    allocate,
    follow_shift,
    follow_turn,
    marginalise,
    move,
    place_pose,
)
from slam.joint_geometry import write_marginal
from slam.region import REGION
from slam.turning import turn
from tests.slam import naive
from tests.slam.drawn import mapped, random_state
from tests.slam.joint import joint_of

NOISE = (0.0009, 0.0001, 0.0009)


def test_entries_are_used_again_and_room_keeps_what_is_there() -> None:
    joint = JointGaussian.at(np.array([1.0, 2.0, 3.0])).with_room(200, 40)
    places = [allocate(joint, float(k), 1.0) for k in range(5)]
    joint.cov[:8, :8] += 0.5
    joint.entries[30, :3] = places[:3]
    before = joint.cov[places[3:], :][:, places[3:]].copy()
    marginalise(joint, 30)
    assert not joint.cov[places[:3]].any() and not joint.cov[:, places[:3]].any()
    np.testing.assert_array_equal(joint.cov[np.ix_(places[3:], places[3:])], before)
    assert sorted(allocate(joint, 7.0, 2.0) for _ in range(3)) == places[:3]
    assert joint.used == 8
    assert joint.cov[places[0], places[0]] == 2.0
    larger = joint.with_room(1000, 100)
    np.testing.assert_array_equal(larger.cov[:8, :8], joint.cov[:8, :8])
    assert (larger.entries[40:] == -1).all()
    assert len(larger.mean) >= 1008


def test_copies_share_nothing() -> None:
    joint = JointGaussian.at(np.zeros(3))
    other = joint.copy()
    assert not any(np.shares_memory(a, b) for a, b in zip(joint, other, strict=True))


@pytest.mark.parametrize("odometry", [(0.1, 0.0, 0.02), (-0.3, 0.1, -0.5), (0.0, 0.0, 0.4), (0.0, 0.0, 0.0)])
def test_motion_is_that_of_the_textbook_ekf(odometry: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(1)
    joint = joint_of(rng, random_state(rng, 2))
    n = joint.used
    mean, cov = joint.mean[:n].copy(), joint.cov[:n, :n].copy()
    move(joint, odometry, NOISE)
    pose, own = naive.predict(mean[:3], cov[:3, :3], np.array(odometry), np.array(NOISE))
    by_pose = naive.derivative(
        lambda x: naive.predict(x, cov[:3, :3], np.array(odometry), np.array(NOISE))[0], mean[:3]
    )
    np.testing.assert_allclose(joint.mean[:3], pose, atol=1e-9)
    np.testing.assert_allclose(joint.cov[:3, :3], own, atol=1e-9)
    np.testing.assert_allclose(joint.cov[:3, 3:n], by_pose @ cov[:3, 3:], atol=1e-8)
    np.testing.assert_array_equal(joint.cov[3:n, 3:n], cov[3:, 3:])
    np.testing.assert_allclose(joint.cov, joint.cov.T, atol=1e-15)


@pytest.mark.parametrize(("n", "quarters"), [(1, 0), (1, 1), (1, 2), (1, 3), (2, 2), (3, 2)])
def test_a_turned_description_has_the_turned_marginal(n: int, quarters: int) -> None:
    rng = np.random.default_rng(n)
    state = random_state(rng, n)
    joint = joint_of(rng, state, open_edges=[3])
    m = mapped(state, open_edges=[3])
    write_marginal(joint, 0, m, 0.1)
    both = np.zeros(2, REGION)
    turn(m, quarters, both[0])
    both[1] = both[0]
    expected, found = both
    found.cov[:] = found.state[:] = 0.0
    follow_turn(joint, 0, m, expected, quarters)
    open_edge = int(np.flatnonzero(expected.closed[: 2 + 3 * n] == 0)[0])
    found.state[open_edge], found.cov[open_edge, open_edge] = expected.state[open_edge], 1e4
    write_marginal(joint, 0, found, 0.1)
    np.testing.assert_allclose(found.cov, expected.cov, atol=1e-12)
    np.testing.assert_allclose(found.state[1:], expected.state[1:], atol=1e-12)
    assert np.cos(found.state[0] - expected.state[0]) == pytest.approx(1.0)


def test_a_line_that_becomes_two_edges_is_in_both() -> None:
    """A rectangle described as two in a row, a quarter turn away: both share what was its left and right edge."""
    rng = np.random.default_rng(9)
    joint = joint_of(rng, np.array([0.3, -2.0, 2.0, -1.0, 1.0]))
    n = joint.used
    old = mapped([0.3, -2.0, 2.0, -1.0, 1.0])
    new = mapped([0.3 + np.pi / 2, -1.0, 0.2, -2.0, 2.0, 1.0, -2.0, 2.0], open_edges=[2])
    left, right, cov = joint.entries[0, 1], joint.entries[0, 2], joint.cov[:n, :n].copy()
    follow_turn(joint, 0, old, new, 1)
    entries = joint.entries[0]
    assert joint.used == n + 2
    assert (entries[2], entries[3], entries[4]) == (-1, right, left)
    np.testing.assert_allclose(joint.mean[entries[[1, 3, 4, 5, 6, 7]]], [-1, -2, 2, 1, -2, 2])
    assert joint.cov[entries[6], entries[3]] == cov[right, right]
    assert cov[right, right] < joint.cov[entries[6], entries[6]] < 1.1 * cov[right, right]
    np.testing.assert_allclose(joint.cov[entries[6], :3], joint.cov[entries[3], :3])
    np.testing.assert_allclose(joint.cov[entries[4], :3], -cov[left, :3])
    assert np.linalg.eigvalsh(joint.cov[: n + 2, : n + 2]).min() > 0.0


@pytest.mark.parametrize("n", [1, 2])
def test_a_row_that_grows_to_the_left_keeps_its_marginal(n: int) -> None:
    rng = np.random.default_rng(n)
    state = random_state(rng, n)
    joint = joint_of(rng, state)
    m = mapped(state)
    write_marginal(joint, 0, m, 0.1)
    old = m.cov.copy()
    follow_shift(joint, 0, n)
    shift_right(m)
    known = np.flatnonzero(m.closed)
    assert np.array_equal(np.flatnonzero(joint.entries[0] >= 0), known)
    places = joint.entries[0][known]
    np.testing.assert_array_equal(m.cov[np.ix_(known, known)], joint.cov[np.ix_(places, places)])
    assert sorted(np.diag(old)[: 2 + 3 * n]) == sorted(np.diag(m.cov)[known])


def test_a_certain_pose_leaves_the_map_as_it_is() -> None:
    rng = np.random.default_rng(3)
    joint = joint_of(rng, random_state(rng, 1))
    cov = joint.cov[3:, 3:].copy()
    place_pose(joint, np.array([1.0, 2.0, 0.5]))
    assert joint.mean[:3].tolist() == [1.0, 2.0, 0.5]
    assert not joint.cov[:3].any() and not joint.cov[:, :3].any()
    np.testing.assert_array_equal(joint.cov[3:, 3:], cov)
