from __future__ import annotations

import numpy as np
import pytest

from regionslam_env.control.pursuit import look_ahead, pursue

NOTHING = np.zeros((0, 2))


def steer(x: float, y: float, points: np.ndarray = NOTHING, remaining: float = np.inf) -> tuple[float, float]:
    return pursue(x, y, remaining, points, 0.25, 1.0, 2.0, 2.0)


def test_straight_ahead_at_full_speed() -> None:
    assert steer(1.0, 0.0) == pytest.approx((1.0, 0.0))


def test_turns_towards_the_point_and_on_the_spot_where_it_lies_aside() -> None:
    speed, turn = steer(1.0, 0.2)
    assert 0.8 < speed < 1.0 and turn == pytest.approx(4 * np.arctan2(0.2, 1.0))
    assert steer(0.0, -1.0) == (0.0, -2.0)
    assert steer(-1.0, 0.1) == (0.0, 2.0)


def test_brakes_before_the_end() -> None:
    speeds = [steer(0.5, 0.0, remaining=r)[0] for r in (2.0, 0.5, 0.1, 0.02)]
    assert speeds[0] == 1.0
    assert speeds == sorted(speeds, reverse=True) and speeds[-1] < 0.25


def test_slows_down_beside_obstacles_and_stops_before_one() -> None:
    assert steer(1.0, 0.0, np.array([[0.0, 0.4]]))[0] < 0.7
    assert steer(1.0, 0.0, np.array([[0.9, 0.0]]))[0] < 1.0
    assert steer(1.0, 0.0, np.array([[0.26, 0.0]]))[0] == 0.0


def test_gets_away_from_what_it_touches() -> None:
    assert steer(1.0, 0.0, np.array([[-0.22, 0.0]]))[0] > 0.2


def test_looks_as_far_ahead_as_the_line_is_as_good_as_the_path() -> None:
    cost = np.ones((21, 21), np.float32)
    cost[:10, 10] = np.inf  # a wall up to row 9
    around = np.array([(c, 5 + c // 2) for c in range(5, 11)] + [(c, 15 - c // 2) for c in range(11, 18)], float)
    path = np.concatenate([[[5.0, 5.0]], around])
    best = look_ahead(cost, path, 30.0)
    assert 4 <= best < len(path) - 1
    assert look_ahead(np.ones((21, 21), np.float32), path, 30.0) == len(path) - 1
    assert np.hypot(*(path[look_ahead(np.ones((21, 21), np.float32), path, 4.0)] - path[0])) <= 4.0
