"""Edges of rows, against hand-drawn points and shapely's distances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely import Point, Polygon, unary_union

from slam.edges import Edge, distance_to, edges_of
from slam.region import EdgeState, RegionFeature, Subrectangle
from slam.rows import Row


def by_name(feature: RegionFeature) -> dict[str, Edge]:
    return {edge.name: edge for edge in edges_of(feature)}


def test_edges_of_a_rectangle_run_counter_clockwise() -> None:
    edges = by_name(RegionFeature(1, "office", 0.0, 1.0, 2.0, 4.0, 2.0, 0.0, t=EdgeState.OPEN))
    assert list(edges) == ["t", "b", "l", "r"]
    assert (edges["b"].start, edges["b"].end) == ((-1, 1), (3, 1))
    assert (edges["r"].start, edges["r"].end) == ((3, 1), (3, 3))
    assert (edges["t"].start, edges["t"].end) == ((3, 3), (-1, 3))
    assert (edges["l"].start, edges["l"].end) == ((-1, 3), (-1, 1))
    assert [edges[name].normal for name in "tblr"] == [(0, 1), (0, -1), (-1, 0), (1, 0)]
    assert edges["t"].state is EdgeState.OPEN and edges["b"].state is EdgeState.CLOSED
    assert edges["b"].length == 4 and edges["b"].middle == (1, 1)


def test_edges_of_a_row_of_three_turned_by_a_right_angle() -> None:
    left, right = Subrectangle(2.0, 1.0, 0.5), Subrectangle(3.0, 1.0, -0.5, end=EdgeState.OPEN)
    sub = EdgeState.SUBRECT
    edges = by_name(RegionFeature(1, "hallway", 0.0, 0, 0, 4, 2, math.pi / 2, l=sub, r=sub, left=left, right=right))
    assert list(edges) == ["t", "b", "l", "r", "tl", "bl", "ll", "tr", "br", "rr"]
    # Along is +y, across is -x: the left subrectangle spans y in [-4, -2] and x in [-1, 0].
    np.testing.assert_allclose(edges["ll"].start, (-1, -4), atol=1e-12)
    np.testing.assert_allclose(edges["ll"].end, (0, -4), atol=1e-12)
    np.testing.assert_allclose(edges["tr"].middle, (0, 3.5), atol=1e-12)
    np.testing.assert_allclose(edges["br"].normal, (1, 0), atol=1e-12)
    assert edges["rr"].state is EdgeState.OPEN and edges["l"].state is sub
    for edge in edges.values():
        along = np.subtract(edge.end, edge.start) / edge.length
        np.testing.assert_allclose(edge.normal, (along[1], -along[0]), atol=1e-12)


def test_places_along_and_outside_of_an_edge() -> None:
    edge = by_name(RegionFeature(1, "office", 0.0, 0, 0, 4, 2, 0.0))["t"]  # from (2, 1) to (-2, 1)
    assert edge.height((0, 3)) == 2 and edge.height((0, 0)) == -1
    assert edge.along((1, 9)) == 1
    assert edge.beside((0, 9)) == 0 and edge.beside((5, 0)) == 3 and edge.beside((-2.5, 0)) == 0.5
    assert edge.distance((5, 5)) == 5


def test_distance_to_a_row_agrees_with_shapely() -> None:
    rng = np.random.default_rng(3)
    row = Row(1.0, -2.0, 0.7, [-4, -1, 2, 3], [-1, -3, 0], [1, 2, 4], main=1)
    union = unary_union([Polygon(corners) for corners in row.rectangles()])
    for point in rng.uniform(-8, 8, (100, 2)):
        assert distance_to(row, (point[0], point[1])) == pytest.approx(union.distance(Point(point)), abs=1e-9)
