from __future__ import annotations

import numpy as np
import pytest

from slam.view import diamond, is_in_view
from tests.slam import naive


def star(rng: np.random.Generator, count: int = 40) -> np.ndarray:
    angles = np.sort(rng.uniform(-np.pi, np.pi, count))
    angles = np.linspace(-np.pi, np.pi, count, endpoint=False) + 0.3 * angles / count
    return rng.uniform(1.0, 8.0, count)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@pytest.mark.parametrize("seed", range(4))
def test_a_star_polygon_holds_what_the_naive_rule_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    view = np.roll(star(rng), int(rng.integers(40)), axis=0)
    inside = 0
    for x, y in rng.uniform(-7, 7, (300, 2)):
        expected = naive.in_polygon(view, x, y)
        assert is_in_view(view, x, y, 0.0) == expected, (x, y)
        inside += expected
    assert 30 < inside < 270


def test_the_margin_is_measured_along_the_ray() -> None:
    square = np.array([[2.0, -2], [2, 2], [-2, 2], [-2, -2]])
    assert is_in_view(square, 1.69, 0.0, 0.3)
    assert not is_in_view(square, 1.71, 0.0, 0.3)
    assert is_in_view(square, 0.0, 0.0, 0.3)
    assert is_in_view(square, -1.6, -1.6, 0.3)
    assert not is_in_view(square, -1.9, -1.9, 0.3)


def test_nothing_is_seen_outside_a_limited_field_of_view() -> None:
    """The robot itself comes first: a quarter circle ahead."""
    angles = np.linspace(-np.pi / 4, np.pi / 4, 9)
    wedge = np.vstack([[0.0, 0.0], 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)])
    for angle, seen in ((0.0, True), (0.7, True), (-0.7, True), (0.9, False), (-0.9, False), (3.0, False)):
        assert is_in_view(wedge, 3 * np.cos(angle), 3 * np.sin(angle), 0.0) == seen
    assert not is_in_view(wedge, 5.1, 0.0, 0.0)


def test_a_shadow_behind_an_edge_is_not_seen() -> None:
    """Two vertices on one ray, 2 m and 6 m away."""
    view = np.array([[6.0, 0], [6, 6], [2, 2], [-6, 6], [-6, -6], [6, -6]])
    assert is_in_view(view, 3.0, 2.9, 0.0)
    assert not is_in_view(view, 2.9, 3.0, 0.0)


def test_diamond_grows_with_the_angle() -> None:
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    values = [diamond(np.cos(a), np.sin(a)) for a in angles]
    assert np.all(np.diff(values) > 0)
    assert [diamond(1, 0), diamond(0, 1), diamond(-1, 0), diamond(0, -1)] == [0, 1, 2, 3]
