"""Angles, poses and frames."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slam.se2 import between, compose, inverse, to_local, to_world, transform, wrap, wrap_angles

ANGLES = [
    (0.0, 0.0),
    (math.pi, math.pi),
    (-math.pi, math.pi),
    (1.5 * math.pi, -0.5 * math.pi),
    (-7.0, 2 * math.pi - 7.0),
]


@pytest.mark.parametrize(("angle", "wrapped"), [*ANGLES, (201 * math.pi, math.pi), (-3.0, -3.0)])
def test_wrap(angle: float, wrapped: float) -> None:
    assert wrap(angle) == pytest.approx(wrapped, abs=1e-12)
    assert wrap_angles([[angle]])[0, 0] == pytest.approx(wrapped, abs=1e-12)


def test_wrap_stays_in_its_interval() -> None:
    for angle in np.concatenate(
        [np.linspace(-20, 20, 201), np.nextafter(math.pi, [0, 9]), np.nextafter(-math.pi, [0, -9])]
    ):
        assert -math.pi < wrap(angle) <= math.pi


def test_compose_turns_then_moves() -> None:
    np.testing.assert_allclose(compose((1, 2, math.pi / 2), (3, 1, math.pi)), (0, 5, -math.pi / 2), atol=1e-12)


def test_inverse_undoes() -> None:
    pose = np.array([[1.0, -2.0, 2.5], [0.0, 3.0, -3.0]])
    np.testing.assert_allclose(compose(pose, inverse(pose)), np.zeros((2, 3)), atol=1e-12)
    np.testing.assert_allclose(inverse((1.0, 2.0, math.pi / 2)), (-2, 1, -math.pi / 2), atol=1e-12)


def test_between_is_the_second_pose_seen_from_the_first() -> None:
    np.testing.assert_allclose(between((1, 1, math.pi / 2), (1, 4, math.pi)), (3, 0, math.pi / 2), atol=1e-12)
    a, b = np.array([2.0, -1.0, 3.0]), np.array([-4.0, 0.5, -3.0])
    np.testing.assert_allclose(compose(a, between(a, b)), b, atol=1e-12)


def test_poses_are_stacked_by_broadcasting() -> None:
    poses = np.zeros((5, 3))
    poses[:, 0] = range(5)
    np.testing.assert_allclose(compose((0, 0, math.pi / 2), poses)[:, 1], range(5), atol=1e-12)


def test_transform_and_kernels_agree() -> None:
    pose, point = (1.0, 2.0, math.pi / 2), (3.0, 0.5)
    np.testing.assert_allclose(transform(pose, [point, (0, 0)]), [(0.5, 5), (1, 2)], atol=1e-12)
    np.testing.assert_allclose(transform(pose, point), to_world(*pose, *point))
    np.testing.assert_allclose(to_local(*pose, *to_world(*pose, *point)), point)


def test_a_pose_has_three_entries() -> None:
    with pytest.raises(ValueError, match=r"shape \(\.\.\., 3\); got shape \(2,\)"):
        compose((1, 2), (0, 0, 0))
