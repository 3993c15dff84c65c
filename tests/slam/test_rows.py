"""Rows of rectangles: the paper's parameters, shapes and frames."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely import MultiPoint, Polygon, contains_xy, unary_union

from slam.rows import Row


def drawn() -> Row:
    """Three rectangles: 2 x 1 with y = 0.5, main 4 x 2, 3 x 1 with y = -0.5; along +y, main's midpoint at (10, 20)."""
    return Row.from_parameters(10, 20, 4, 2, math.pi / 2, left=(2, 1, 0.5), right=(3, 1, -0.5))


def union(row: Row) -> Polygon:
    return unary_union([Polygon(corners) for corners in row.rectangles()])


def test_edge_positions_of_parameters() -> None:
    row = drawn()
    np.testing.assert_allclose(row.u, [-4, -2, 2, 5])
    np.testing.assert_allclose(row.b, [0, -1, -1])
    np.testing.assert_allclose(row.t, [1, 1, 0])
    assert (row.n, row.main) == (3, 1)


@pytest.mark.parametrize("left", [None, (2.0, 1.0, 0.5)])
@pytest.mark.parametrize("right", [None, (3.0, 1.5, -0.5)])
def test_parameters_survive(left: tuple[float, float, float] | None, right: tuple[float, float, float] | None) -> None:
    parameters = {"x": 1.5, "y": -2.0, "w": 4.0, "h": 2.0, "phi": 0.7, "left": left, "right": right}
    read = Row.from_parameters(**parameters).parameters()
    assert set(read) == set(parameters)
    for name, value in parameters.items():
        assert read[name] == pytest.approx(value), name


def test_parameters_of_a_row_about_another_origin() -> None:
    row = Row(1, 1, math.pi / 2, [1, 3, 4], [0, 1], [2, 5], main=1)
    p = row.parameters()
    assert (p["x"], p["y"], p["w"], p["h"]) == pytest.approx((1 - 3, 1 + 3.5, 1, 4))
    assert p["left"] == pytest.approx((2, 2, -2)) and p["right"] is None
    np.testing.assert_allclose(Row.from_parameters(**p).rectangles(), row.rectangles(), atol=1e-12)


def test_rectangles_are_counter_clockwise_in_the_surrounding_frame() -> None:
    rectangles = drawn().rectangles()
    assert rectangles.shape == (3, 4, 2)
    np.testing.assert_allclose(rectangles[0], [(10, 16), (10, 18), (9, 18), (9, 16)], atol=1e-12)
    assert all(Polygon(corners).exterior.is_ccw for corners in rectangles)


def test_outline_is_the_union() -> None:
    row = drawn()
    assert row.outline().shape == (12, 2)
    outline = Polygon(row.outline())
    assert outline.exterior.is_ccw
    assert outline.symmetric_difference(union(row)).area == pytest.approx(0, abs=1e-12)


def test_area_and_centre() -> None:
    row = drawn()
    assert row.area == 2 + 8 + 3
    centroid = union(row).centroid
    assert row.centre == pytest.approx((centroid.x, centroid.y))


def test_contains_agrees_with_shapely() -> None:
    row, points = drawn(), np.random.default_rng(8).uniform((7, 14), (13, 27), (500, 2))
    inside = contains_xy(union(row), points)
    assert 50 < inside.sum() < 450
    np.testing.assert_array_equal(row.contains(points), inside)
    assert row.contains([(10, 20), (10.6, 17)]).tolist() == [True, False]


def test_frames_undo_each_other() -> None:
    row, points = drawn(), np.array([[0.0, 0.0], [1.0, 2.0]])
    np.testing.assert_allclose(row.to_world(points), [(10, 20), (8, 21)], atol=1e-12)
    np.testing.assert_allclose(row.to_local(row.to_world(points)), points, atol=1e-12)
    assert MultiPoint(row.to_world(points)).length == 0


def test_a_row_cannot_be_changed() -> None:
    u = np.array([0.0, 1.0])
    row = Row(0, 0, 0, u, [0], [1])
    u[0] = -5
    assert row.u[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        row.u[0] = 1


@pytest.mark.parametrize(
    ("u", "b", "t", "main", "message"),
    [
        ([0, 1, 2, 3, 4], [0] * 4, [1] * 4, 1, "1 to 3 rectangles"),
        ([0], [], [], 0, "1 to 3 rectangles"),
        ([0, 1, 2], [0], [1], 0, r"len\(u\)=3"),
        ([0, 1], [0], [1, 2], 0, r"len\(t\)=2"),
        ([0, 0], [0], [1], 0, "positive width and height"),
        ([0, 1], [1], [1], 0, "positive width and height"),
        ([0, math.nan], [0], [1], 0, "positive width and height"),
        ([0, 1], [0], [1], 1, "main rectangle of a row of 1 cannot be number 1"),
        ([0, 1, 2, 3], [0] * 3, [1] * 3, 0, "main rectangle of a row of 3 cannot be number 0"),
    ],
)
def test_impossible_rows_are_refused(u: list[float], b: list[float], t: list[float], main: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Row(0, 0, 0, np.array(u), np.array(b), np.array(t), main)


@pytest.mark.parametrize("main", [0, 1])
def test_of_two_rectangles_either_may_be_the_main_one(main: int) -> None:
    row = Row(0, 0, 0, [0, 1, 2], [0, 0], [1, 2], main)
    assert (row.parameters()["left"] is None) == (main == 0)
