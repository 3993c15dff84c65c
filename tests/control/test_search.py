from __future__ import annotations

import heapq

import numpy as np
import pytest

from regionslam_env.control.search import DIAGONAL, search, trace


def run(cost: np.ndarray, start: tuple[int, int], goal: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the path as (row, column) and the costs of all cells reached; `goal` is (row, column)."""
    reach, parent = np.empty(cost.shape, np.float32), np.empty(cost.shape, np.int32)
    end = search(cost.astype(np.float32), start[0] * cost.shape[1] + start[1], goal[1], goal[0], reach, parent)
    return trace(parent, end), reach


def naive_distances(cost: np.ndarray, start: tuple[int, int]) -> np.ndarray:
    """Dijkstra with a heap from the library."""
    reach = np.full(cost.shape, np.inf)
    reach[start] = 0
    queue = [(0.0, start)]
    while queue:
        so_far, (r, c) = heapq.heappop(queue)
        here = cost[r, c] if np.isfinite(cost[r, c]) else 1.0
        for dr in (-1, 0, 1):
            for dc in (-1, 0, 1):
                n = r + dr, c + dc
                if (dr, dc) == (0, 0) or not (0 <= n[0] < cost.shape[0] and 0 <= n[1] < cost.shape[1]):
                    continue
                total = so_far + np.hypot(dr, dc) * (here + cost[n]) / 2
                if total < reach[n] - 1e-9:
                    reach[n] = total
                    heapq.heappush(queue, (total, n))
    return reach


def random_costs(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    cost = 1 + 4 * rng.random((25, 31))
    cost[rng.random(cost.shape) < 0.3] = np.inf
    cost[12, 15] = 1
    return cost


@pytest.mark.parametrize("seed", range(5))
def test_distances_agree_with_the_obvious_computation(seed: int) -> None:
    cost = random_costs(seed)
    _, reach = run(cost, (12, 15), (np.nan, np.nan))
    assert reach == pytest.approx(naive_distances(cost, (12, 15)), rel=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_path_to_a_goal_is_the_cheapest(seed: int) -> None:
    cost = random_costs(seed)
    expected = naive_distances(cost, (12, 15))
    goals = np.argwhere(np.isfinite(expected))
    goal = tuple(goals[7 * seed])
    path, reach = run(cost, (12, 15), goal)
    assert tuple(path[0]) == (12, 15) and tuple(path[-1]) == goal
    assert np.abs(np.diff(path, axis=0)).max() == 1
    assert reach[goal] == pytest.approx(expected[goal], rel=1e-4)


def test_straight_line_in_the_open() -> None:
    path, reach = run(np.ones((9, 9)), (4, 0), (4, 8))
    assert path.tolist() == [[4, c] for c in range(9)]
    assert reach[4, 8] == pytest.approx(8)
    assert run(np.ones((9, 9)), (0, 0), (8, 8))[1][8, 8] == pytest.approx(8 * DIAGONAL)


def test_unreachable_goal_ends_at_the_nearest_reachable_cell() -> None:
    cost = np.ones((9, 9))
    cost[:, 5] = np.inf
    path, _ = run(cost, (4, 0), (2, 8))
    assert tuple(path[-1]) == (2, 4)


def test_goal_outside_ends_at_the_border_on_the_way() -> None:
    path, _ = run(np.ones((9, 9)), (4, 4), (4, 30))
    assert tuple(path[-1]) == (4, 8)


def test_enclosed_start_stays() -> None:
    cost = np.full((5, 5), np.inf)
    path, _ = run(cost, (2, 2), (0, 0))
    assert path.tolist() == [[2, 2]]
