"""Overlap of rows: hand-drawn areas, and shapely's polygons as the slow twin."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely import Polygon, unary_union

from slam.overlap import covered, iou, overlap_area, row_area, row_contains, rows_overlap
from slam.rows import Row


def rectangle(x: float, y: float, w: float, h: float, phi: float = 0.0) -> Row:
    return Row.from_parameters(x, y, w, h, phi)


def naive_overlap(a: Row, b: Row) -> float:
    """The same area by shapely."""
    unions = [unary_union([Polygon(corners) for corners in row.rectangles()]) for row in (a, b)]
    return float(unions[0].intersection(unions[1]).area)


def random_row(rng: np.random.Generator) -> Row:
    n = int(rng.integers(1, 4))
    u = np.cumsum(rng.uniform(0.3, 4.0, n + 1)) - 4.0
    b = rng.uniform(-3.0, 1.0, n)
    x, y, phi = rng.uniform(-4.0, 4.0, 3)
    return Row(x, y, phi, u, b, b + rng.uniform(0.2, 4.0, n), main=n // 2)


@pytest.mark.parametrize(
    ("b", "area"),
    [
        (rectangle(0, 0, 4, 2), 8.0),  # itself
        (rectangle(1, 0, 4, 2), 6.0),
        (rectangle(3, 1.5, 4, 2), 0.5),  # one corner: 1 x 0.5
        (rectangle(4, 0, 4, 2), 0.0),  # shares an edge
        (rectangle(9, 0, 4, 2), 0.0),  # far away
        (rectangle(3.5, 1.7, 4, 2), 0.5 * 0.3),  # inside the circles, just overlapping
        (rectangle(3.9, 2.1, 4, 2), 0.0),  # circles meet, rectangles don't
        (rectangle(0, 0, 1, 1, 0.3), 1.0),  # inside
        (rectangle(0, 0, 2, 4), 4.0),  # a cross
        (rectangle(0, 0, 2, 4, math.pi / 2), 8.0),  # the same set under another description
        (rectangle(0, 0, 2, 2, math.pi / 4), 4 - 2 * (math.sqrt(2) - 1) ** 2),  # a diamond loses two tips
        (rectangle(2, 1, math.sqrt(8), math.sqrt(8), math.pi / 4), 2.0),  # a diamond about a corner covers a triangle
    ],
)
def test_overlap_of_hand_drawn_rectangles(b: Row, area: float) -> None:
    a = rectangle(0, 0, 4, 2)
    assert overlap_area(a, b) == pytest.approx(area, abs=1e-12)
    assert overlap_area(b, a) == pytest.approx(area, abs=1e-12)


def test_overlap_sums_the_rectangles_of_both_rows() -> None:
    wide_t = Row.from_parameters(0, 0, 2, 6, left=(3, 2, 0), right=(3, 2, 0))
    bar = rectangle(0, 2, 10, 2)  # [-5, 5] x [1, 3]
    assert overlap_area(wide_t, bar) == pytest.approx(4.0)
    assert overlap_area(wide_t, wide_t) == pytest.approx(wide_t.area)
    half_turn = Row(0, 0, math.pi, wide_t.u, wide_t.b, wide_t.t, main=1)
    assert overlap_area(wide_t, half_turn) == pytest.approx(24.0)


def test_overlap_agrees_with_shapely() -> None:
    rng = np.random.default_rng(1)
    overlapping = 0
    for _ in range(400):
        a, b = random_row(rng), random_row(rng)
        area = naive_overlap(a, b)
        overlapping += area > 0
        assert overlap_area(a, b) == pytest.approx(area, abs=1e-9)
    assert overlapping > 150


@pytest.mark.parametrize("angle", [1e-16, 1e-12, 1e-9, 1e-7, math.pi / 2 + 1e-12, math.pi - 1e-9])
def test_overlap_of_nearly_parallel_rectangles(angle: float) -> None:
    assert overlap_area(rectangle(0, 0, 4, 4), rectangle(1, 1, 4, 4, angle)) == pytest.approx(9.0, abs=1e-5)


def test_overlap_far_from_the_origin_keeps_its_digits() -> None:
    a, b = rectangle(1e5, -1e5, 0.9, 0.2, 0.7), rectangle(1e5, -1e5, 0.9, 0.2, 0.7 + math.pi / 2)
    assert overlap_area(a, b) == pytest.approx(0.04, abs=1e-9)


def test_overlap_reads_no_entry_beyond_the_count() -> None:
    u, b, t = np.array([0.0, 2.0, np.nan, np.nan]), np.array([0.0, np.nan, np.nan]), np.array([1.0, np.nan, np.nan])
    assert rows_overlap(0.0, 0.0, 0.0, u, b, t, 1, 1.0, 0.0, 0.0, u, b, t, 1) == pytest.approx(1.0)
    assert row_area(u, b, t, 1) == 2.0


def test_iou_and_covered() -> None:
    a, b = rectangle(0, 0, 4, 2), rectangle(1, 0, 2, 2)
    assert iou(a, b) == pytest.approx(0.5)
    assert covered(a, b) == pytest.approx(1.0)
    assert iou(a, rectangle(9, 0, 2, 2)) == 0.0


def test_row_contains_agrees_with_rows() -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        row, points = random_row(rng), rng.uniform(-6, 6, (50, 2))
        kernel = [row_contains(row.x, row.y, row.phi, row.u, row.b, row.t, row.n, *p) for p in points]
        np.testing.assert_array_equal(kernel, row.contains(points))
