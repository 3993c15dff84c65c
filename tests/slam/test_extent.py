from __future__ import annotations

import numpy as np
import pytest

from slam.edge_form import state_size
from slam.extent import area, contains, overlap, point_in_rectangle, probability_inside
from tests.slam import naive
from tests.slam.drawn import mapped, random_state


@pytest.mark.parametrize("n", [1, 2, 3])
def test_containment_area_and_corners_are_the_naive_ones(n: int) -> None:
    rng = np.random.default_rng(n)
    m = mapped(random_state(rng, n), (1.0, -1.0))
    state = m.state[: state_size(n)].copy()
    for x, y in rng.uniform(-5, 6, (200, 2)):
        for margin in (0.0, 0.4):
            assert contains(m, x, y, margin) == naive.contains(state, m.anchor, (x, y), margin)
    boxes = naive.corners(state, m.anchor)
    sides = np.linalg.norm(boxes[:, 1] - boxes[:, 0], axis=1), np.linalg.norm(boxes[:, 3] - boxes[:, 0], axis=1)
    assert area(m) == pytest.approx(np.sum(sides[0] * sides[1]))
    for i in range(n):
        for k, (along, across) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
            np.testing.assert_allclose(point_in_rectangle(m, i, along, across), boxes[i, k])


def test_probability_of_being_inside_is_that_of_sampling() -> None:
    """With axes of the row that are those of the covariance, the two are equal but for the sampling error."""
    phi = 0.6
    m = mapped([phi, -2, 0.5, -1, 1, 2, -1.5, 0.5], (1.0, 1.0))
    along, across = naive.axes(phi)
    cov = np.zeros((3, 3))
    cov[:2, :2] = 0.5 * np.outer(along, along) + 0.2 * np.outer(across, across)
    pose = np.array([*(np.array([1.0, 1.0]) + 1.2 * along + 0.7 * across), 0.0])
    samples = np.random.default_rng(0).multivariate_normal(pose[:2], cov[:2, :2], 20000)
    offset = samples - m.anchor
    u, v = offset @ along, offset @ across
    inside = ((u > -2) & (u < 0.5) & (abs(v) < 1)) | ((u > 0.5) & (u < 2) & (v > -1.5) & (v < 0.5))
    assert probability_inside(m, pose, cov) == pytest.approx(inside.mean(), abs=0.012)


def test_a_certain_robot_is_inside_or_not() -> None:
    m = mapped([0.3, -2, 2, -1, 1])
    assert probability_inside(m, np.zeros(3), np.zeros((3, 3))) == pytest.approx(1.0)
    assert probability_inside(m, np.array([4.0, 0, 0]), np.zeros((3, 3))) == pytest.approx(0.0)


def test_overlap_of_two_regions_by_hand() -> None:
    a = mapped([0, -2, 2, -1, 1], (1, 0))
    assert overlap(a, a) == pytest.approx(8.0)
    assert overlap(a, mapped([np.pi / 2, -2, 2, -1, 1], (1, 0))) == pytest.approx(4.0)  # a cross
    assert overlap(a, mapped([0, -2, 2, -1, 1], (4, 0.5))) == pytest.approx(1.0 * 1.5)
    assert overlap(a, mapped([0, -2, 0, -3, 0, 1, 0, 5], (3, 0))) == pytest.approx(2.0)
