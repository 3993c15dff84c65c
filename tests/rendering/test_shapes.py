from __future__ import annotations

import numpy as np
import pytest

from regionslam_env.rendering.shapes import Shape, shapes_of_map, shapes_of_world
from slam.region import EdgeState, RegionFeature, Subrectangle
from slam.region_map import RegionMap
from slam.rows import Row
from tests.rendering.scene import world


def lengths(shape: Shape, closed: bool) -> list[float]:
    segments, states = shape.edges
    ends = zip(segments, states, strict=True)
    return sorted(float(np.hypot(*(b - a))) for (a, b), state in ends if state == closed)


def test_edges_of_one_rectangle():
    shape = Shape(1, "office", "office", Row.from_parameters(0, 0, 4, 3), {"t": False})
    assert lengths(shape, closed=False) == pytest.approx([4])
    assert lengths(shape, closed=True) == pytest.approx([3, 3, 4])


def test_the_joint_of_two_rectangles_is_no_edge_but_its_steps_are():
    row = Row.from_parameters(0, 0, 10, 2, right=(3, 4, 1))  # the right part spans -1 .. 3, the main one -1 .. 1
    shape = Shape(1, "hallway", "", row, {"rr": False, "t": True})
    assert lengths(shape, closed=False) == pytest.approx([4])
    assert lengths(shape, closed=True) == pytest.approx([2, 2, 3, 3, 10, 10])  # the first 2 is the step, the other l


def test_features_of_a_map_with_links_and_containment():
    office = RegionFeature(
        1,
        "office",
        3,
        0,
        0,
        4,
        3,
        0,
        r=EdgeState.OPEN,
        neighbours={"t": {2: 2.0, 3: -2.0}},
        children={4: 1.0},
        existence=4,
    )
    desk = RegionFeature(4, "desk", 3, 1, 0, 1.6, 0.8, 0, existence=4)
    gone = RegionFeature(5, "desk", 3, 1, 0, 1.6, 0.8, 0, existence=4, credible=False)
    shapes = shapes_of_map([office, desk, gone])
    assert [s.id for s in shapes] == [1, 4]
    assert shapes[0].certainty == pytest.approx(1 / (1 + np.exp(-3)) / (1 + np.exp(-4)))
    assert shapes[0].neighbours == (2,) and shapes[1].parent == 1
    assert lengths(shapes[0], closed=False) == pytest.approx([3])


def test_regions_are_labelled_as_the_map_names_them():
    offices = [RegionFeature(k, "office", 3, 9.0 * k, 0, 4, 3, 0, existence=4) for k in (3, 8)]
    assert [s.label for s in shapes_of_map(RegionMap(offices))] == ["office 1", "office 2"]
    assert [s.label for s in shapes_of_map(offices)] == ["office", "office"]


def test_features_of_three_rectangles_keep_their_edges_apart():
    left, right = Subrectangle(2, 1, 0, t=EdgeState.OPEN), Subrectangle(1, 1, 0, end=EdgeState.OPEN)
    feature = RegionFeature(1, "hallway", 3, 0, 0, 5, 3, 0, left=left, right=right, existence=4)
    (shape,) = shapes_of_map([feature])
    assert lengths(shape, closed=False) == pytest.approx([1, 2])  # right end, top of the left part


def test_true_regions_carry_their_names():
    assert [(s.label, s.parent) for s in shapes_of_world(world())] == [
        ("office 1", None),
        ("the kitchen", None),
        ("door", None),
        ("desk", "office"),
    ]
