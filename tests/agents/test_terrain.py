from __future__ import annotations

import numpy as np
import pytest

from agents.terrain import UNSEEN, Terrain, clearances, draw_scan, driving_costs, paint_row
from slam.rows import Row
from tests.control.room import box, scan

ROOM = np.array([*box(-3, -2, 3, 2), (0, -2, 0, 1)], float)  # a wall in the middle leaves 1 m open at the top
POSE = np.array([-1.5, 0.0, 0.0])


def terrain_of(*poses: tuple[float, float, float]) -> Terrain:
    terrain = Terrain(180, 10.0, 7.0, 0.25)
    for pose in poses:
        terrain.insert(np.array(pose), scan(np.array(pose), ROOM))
    return terrain


def test_seen_floor_is_free_walls_are_occupied_the_rest_unseen() -> None:
    terrain = terrain_of((-1.5, 0, 0))
    assert terrain.scores[terrain.index((-2.5, 1.0))] <= 0
    assert terrain.scores[terrain.index((-3.0, 0.5))] > 0
    assert terrain.scores[terrain.index((0.0, -0.5))] > 0
    assert not terrain.seen((1.5, -1.0))  # behind the wall
    assert terrain.seen((1.0, 1.8)) and terrain.scores[terrain.index((1.0, 1.8))] <= 0  # through the opening


def test_points_are_the_centres_of_cells() -> None:
    terrain = terrain_of((-1.5, 0, 0))
    (point,) = terrain.points(np.array([terrain.index((0.52, -1.18))]))
    assert point == pytest.approx((0.5, -1.2))


def test_floor_beyond_sight_is_unseen() -> None:
    terrain = Terrain(180, 10.0, 4.0, 0.25)
    terrain.insert(np.zeros(3), np.full(180, 10.0))
    assert terrain.seen((3.8, 0)) and not terrain.seen((4.3, 0))
    assert not np.any(terrain.scores > 0)


def test_a_grazed_wall_stays() -> None:
    walls = np.array([(-9, 1, 9, 1), (-9, -1, 9, -1)], float)
    terrain = Terrain(180, 10.0, 7.0, 0.25)
    rng = np.random.default_rng(0)
    for x in np.arange(-6, 6, 0.1):
        pose = np.array([x, 0.0, 0.0])
        terrain.insert(pose, scan(pose, walls, rng.normal(0, 0.02, 180)))
    along = np.arange(-6, 6, 0.1)
    near_wall = [terrain.scores[terrain.index((x, 1 + d))] > 0 for x in along for d in (-0.1, 0, 0.1)]
    assert np.reshape(near_wall, (-1, 3)).any(axis=1).mean() > 0.97


def test_newer_scans_win() -> None:
    terrain = terrain_of((-1.5, 0, 0))
    for _ in range(14):
        terrain.insert(POSE, np.full(180, 10.0))
    assert np.sum(terrain.scores > 0) < 0.05 * np.sum(terrain_of((-1.5, 0, 0)).scores > 0)


def test_route_leads_around_the_wall() -> None:
    terrain = terrain_of(*[(-1.5, 0, 0), (0, 1.5, 0), (1.5, 0.0, 0)] * 2)
    route = terrain.route((-1.5, -1), (1.5, -1))
    assert route[0] == pytest.approx((-1.5, -1.0)) and route[-1] == pytest.approx((1.5, -1.0))
    crossing = route[np.argmin(np.abs(route[:, 0]))]
    assert 1.25 < crossing[1] < 1.75
    length = np.sum(np.hypot(*np.diff(route, axis=0).T))
    assert length == pytest.approx(2 * np.hypot(1.5, 2.4), rel=0.15)
    reach, _ = terrain.distances((-1.5, -1))
    assert reach[terrain.index((1.5, -1))] >= length
    assert np.isinf(reach[terrain.index((2.9, 1.95))])  # no room for the robot


def test_route_to_a_place_never_seen_ends_beside_it() -> None:
    terrain = terrain_of((-1.5, 0, 0))
    route = terrain.route((-1.5, 0), (-5.0, 0.0))
    assert route[-1] == pytest.approx((-2.7, 0.0), abs=0.15)


def test_grows_without_moving_what_is_known() -> None:
    terrain = terrain_of((-1.5, 0, 0))
    wall, label = terrain.index((-3.0, 0.5)), Row.from_parameters(-1.5, 0, 2, 2)
    terrain.paint(label, 7)
    assert terrain.scores[wall] > 0
    for x in (0.0, 20.0, -20.0):
        terrain.insert(np.array([x, 30.0, 0.0]), np.full(180, 10.0))
    assert terrain.scores[terrain.index((-3.0, 0.5))] > 0
    assert terrain.labels[terrain.index((-1.5, 0.0))] == 7
    assert terrain.seen((-20.0, 30.0)) and not terrain.seen((-20.0, 0.0))


def test_reset_forgets() -> None:
    terrain = terrain_of((-1.5, 0, 0))
    terrain.reset()
    terrain.insert(np.array([5.0, 0, 0]), np.full(180, 1.0))
    assert not terrain.seen((-1.5, 0))


def naive_clearances(scores: np.ndarray) -> np.ndarray:
    occupied = np.argwhere(scores > 0)
    cells = np.argwhere(np.ones_like(scores, bool))
    nearest = np.sqrt(((cells[:, None] - occupied[None]) ** 2).sum(-1)).min(axis=1)
    return nearest.reshape(scores.shape)


def test_clearances_agree_with_the_obvious_computation() -> None:
    rng = np.random.default_rng(1)
    scores = np.where(rng.random((30, 41)) < 0.01, 4, 0).astype(np.int8)
    scores[3, 5] = 1
    assert clearances(scores) == pytest.approx(naive_clearances(scores), rel=0.045, abs=0.05)


def test_driving_cost_is_1_in_the_open_and_inf_where_the_robot_cannot_be() -> None:
    scores = np.zeros((21, 21), np.int8)
    scores[10, 10], scores[0, 0] = 6, UNSEEN
    cost, clearance = driving_costs(scores, 0.1, 0.2, 0.65)
    assert cost[10, 20] == 1.0 and np.isinf(cost[10, 11]) and np.isinf(cost[0, 0])
    assert 1 < cost[10, 14] < cost[10, 13] < 5
    assert clearance[10, 13] == pytest.approx(0.29, abs=0.01)


def test_smaller_rows_keep_their_floor() -> None:
    terrain = terrain_of((-1.5, 0, 0))
    terrain.paint(Row.from_parameters(0, 0, 1, 2, 0.5), 4)
    terrain.paint(Row.from_parameters(0, 0, 4, 4), 6)
    assert terrain.labels[terrain.index((0, 0))] == 4
    assert terrain.labels[terrain.index((1.5, 1.5))] == 6
    terrain.paint(Row.from_parameters(0, 0, 1.1, 2, 0.5), 3)  # the same type, wider by now
    assert terrain.labels[terrain.index((0, 0))] == 3


def test_painted_cells_are_those_in_the_row() -> None:
    row = Row(0.3, -0.2, 0.7, np.array([-1.5, 0.0, 1.0]), np.array([-0.5, -0.2]), np.array([0.5, 1.0]))
    labels, areas = np.zeros((60, 60), np.int16), np.zeros((60, 60), np.float32)
    paint_row(labels, areas, np.array([-3.0, -3.0]), 0.1, row.x, row.y, row.phi, row.u, row.b, row.t, 5, row.area)
    x, y = np.meshgrid(np.arange(60) * 0.1 - 3, np.arange(60) * 0.1 - 3)
    expected = row.contains(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(60, 60)
    assert np.array_equal(labels == 5, expected)


def test_a_ray_into_the_distance_frees_what_it_passed() -> None:
    scores = np.full((41, 41), UNSEEN, np.int8)
    angles, ranges = np.arange(8) * np.pi / 4, np.full(8, 10.0)
    ranges[0] = 1.5
    draw_scan(scores, np.array([-2.0, -2.0]), 0.1, np.zeros(3), angles, ranges, 1.0, 9.9)
    assert np.all(scores[20, 20:30] <= 0) and np.all(scores[20, 20:30] > UNSEEN)
    assert scores[20, 35] == 4 and scores[20, 33] == UNSEEN
