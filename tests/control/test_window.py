from __future__ import annotations

import numpy as np
import pytest

from regionslam_env.control.window import ESCAPE_COST, UNKNOWN_COST, Window, driving_cost, obstacle_points
from tests.control.room import ANGLES, Floats

WINDOW = Window(half=20)
DIRECTIONS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)


def points_of(ranges: Floats, gap: float = 0.5) -> Floats:
    points = np.empty((1000, 2))
    return points[: obstacle_points(ranges, DIRECTIONS, 9.9, gap, 0.1, points)]


def cost_of(ranges: Floats) -> Floats:
    cost = np.empty((WINDOW.size, WINDOW.size), np.float32)
    ray, distance = WINDOW.polar()
    driving_cost(ranges, points_of(ranges), ray, distance, WINDOW.cell, 0.28, 0.75, cost)
    return cost


def test_rays_point_as_the_lidar_says() -> None:
    assert WINDOW.angles() == pytest.approx(ANGLES)
    ray, distance = WINDOW.polar()
    ahead, left = (20, 33), (33, 20)
    assert distance[ahead] == pytest.approx(1.3) and distance[left] == pytest.approx(1.3)
    assert ray[ahead] == 90 and ray[left] == 135
    assert distance.ravel()[WINDOW.centre] == 0


def test_only_rays_that_hit_become_points() -> None:
    ranges = np.full(180, 10.0)
    assert len(points_of(ranges)) == 0
    ranges[90] = 2.0
    assert points_of(ranges) == pytest.approx(np.array([[2.0, 0.0]]))


def test_ends_too_close_to_pass_between_are_joined() -> None:
    ranges = np.full(180, 10.0)
    ranges[90], ranges[91] = 2.0, 2.4
    joined = points_of(ranges)
    assert len(joined) == 6
    assert np.diff(joined[:, 0]) == pytest.approx(0.4 / 5, abs=1e-3)
    ranges[91] = 2.6
    assert len(points_of(ranges)) == 2


def test_points_beyond_the_capacity_are_dropped() -> None:
    points = np.empty((5, 2))
    assert obstacle_points(np.full(180, 2.0), DIRECTIONS, 9.9, 0.5, 0.1, points) == 5


def naive_cost(ranges: Floats, x: float, y: float) -> float:
    """Cost of the cell at a point, straight from its definition."""
    clearance = min(0.75, *np.hypot(*(points_of(ranges) - (x, y)).T))
    if clearance < 0.28:
        return np.inf
    k = int((np.arctan2(y, x) + np.pi) / (2 * np.pi) * 180) % 180
    hidden = np.hypot(x, y) > min(ranges[k], ranges[(k + 1) % 180])
    return 1 + 6 * ((0.75 - clearance) / 0.47) ** 2 + (UNKNOWN_COST if hidden else 0)


def test_cost_agrees_with_the_obvious_computation() -> None:
    rng = np.random.default_rng(0)
    ranges = np.repeat(rng.uniform(0.6, 3.0, 12), 15)
    cost = cost_of(ranges)
    along = (np.arange(WINDOW.size) - WINDOW.half) * WINDOW.cell
    expected = [[naive_cost(ranges, x, y) for x in along] for y in along]
    assert np.mean(np.isclose(cost, expected, rtol=1e-3)) > 0.99  # but for cells right on a ray or on a limit


def test_a_robot_that_stands_too_close_may_leave() -> None:
    ranges = np.full(180, 10.0)
    ranges[88:93] = 0.24
    cost = cost_of(ranges)
    assert ESCAPE_COST <= cost[20, 20] <= 2 * ESCAPE_COST
    assert cost[20, 20] < cost[20, 21]
