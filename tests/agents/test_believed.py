from __future__ import annotations

import numpy as np
import pytest

from agents.believed import View
from regionslam_env.config import SEMANTIC_TYPES
from slam.rows import Row
from tests.agents.belief import Room, observe, view

L_SHAPE = Row.from_parameters(4.0, 1.0, 4.0, 2.0, 0.3, right=(2.0, 6.0, 2.0))
POSE = (1.0, -2.0, 2.2)


def test_regions_come_back_in_the_map_frame() -> None:
    room = Room("kitchen", L_SHAPE, ("t", "rr"), 0.8, 0.7, True, 0.25)
    kitchen, door = view(POSE, [room, Room("door", Row.from_parameters(0, 0, 1, 0.2))], "kitchen").regions
    assert kitchen.row.outline() == pytest.approx(L_SHAPE.outline(), abs=1e-5)
    assert (kitchen.type, kitchen.slot, kitchen.open_edges, kitchen.visited) == ("kitchen", 0, ("t", "rr"), True)
    assert (kitchen.existence, kitchen.type_p, kitchen.contains_me) == pytest.approx((0.8, 0.7, 0.25))
    assert kitchen.goal_p == pytest.approx(0.7)
    assert door.type == "door" and door.row.n == 1 and door.goal_p < 0.01


def test_pose_and_its_uncertainty() -> None:
    observation = observe(POSE, [], "office")
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = [[0.05, 0.03], [0.03, 0.02]]
    observation["pose_cov"] = covariance.ravel().astype(np.float32)
    seen = View(observation, SEMANTIC_TYPES)
    assert seen.pose == pytest.approx(POSE)
    assert seen.position_sigma == pytest.approx(np.sqrt(np.linalg.eigvalsh(covariance).max()))
    assert seen.goal == "office" and seen.regions == ()


def test_to_robot() -> None:
    assert view((1.0, 1.0, np.pi / 2), [], "office").to_robot((1.0, 3.0)) == pytest.approx((2.0, 0.0), abs=1e-6)


def test_depth_is_the_distance_to_the_outer_edges() -> None:
    # 4 x 2 around the origin, and to its right 2 x 6 whose bottom is on a line with the first's
    row = Row.from_parameters(0, 0, 4, 2, right=(2.0, 6.0, 2.0))
    (region,) = view((0, 0, 0), [Room("office", row)], "office").regions
    points = [(0, 0), (-1.5, 0), (1.9, 0), (1.9, 0.8), (2.1, 0.0), (3.0, 3.0), (2.1, 3.0), (0, 1.5), (7, 0)]
    expected = [1.0, 0.5, 1.0, 0.2, 1.0, 1.0, 0.1]
    depth = region.depth(points)
    assert depth[:7] == pytest.approx(expected, abs=1e-5)
    assert np.all(depth[7:] < 0)


def test_goal_regions_are_those_around_the_robot() -> None:
    square = Row.from_parameters(0, 0, 2, 2)
    rooms = [
        Room("office", square, contains_me=0.9),
        Room("kitchen", square, contains_me=0.9),
        Room("office", square, contains_me=0.1),
        Room("office", square, contains_me=0.9, type_p=0.4),
    ]
    assert [r.slot for r in view((0, 0, 0), rooms, "office").goal_regions()] == [0]


def test_rooms_leave_out_doors_and_furniture() -> None:
    rooms = [
        Room("desk", Row.from_parameters(0, 0, 1, 1)),
        Room("office", Row.from_parameters(0, 0, 3, 3)),
        Room("door", Row.from_parameters(0, 0, 1, 0.2)),
        Room("hallway", Row.from_parameters(0, 0, 9, 2)),
    ]
    assert [r.type for r in view((0, 0, 0), rooms, "office").rooms] == ["hallway", "office"]


def test_without_a_goal_no_region_is_wanted() -> None:
    aimless = view((0, 0, 0), [Room(SEMANTIC_TYPES[0], Row.from_parameters(0, 0, 2, 2), contains_me=0.9)], "")
    assert aimless.goal is None and aimless.goal_regions() == ()
    assert [region.goal_p for region in aimless.regions] == [0.0]
