"""Cheapest paths over a grid of costs (Dijkstra and A* on eight neighbours)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slam.jit import njit

DIAGONAL = 1.4142135623730951


@njit
def search(
    cost: NDArray[np.float32],
    start: int,
    goal_x: float,
    goal_y: float,
    reach: NDArray[np.float32],
    parent: NDArray[np.int32],
) -> int:
    """Search from a cell towards a point and return the cell where the path ends.

    A step from one cell to the next costs its length (in cells) times the mean cost of the two. Follow `parent` from
    the returned cell back to `start`.

    Parameters
    ----------
    cost
        Cost per cell length, >= 1; inf where no path may go. Shape (rows, columns).
    start
        Flat index of the first cell (its own cost does not matter).
    goal_x, goal_y
        The point in cells (column, row). If it lies outside the grid, the path ends at the border cell that is best on
        the way to it. NaN: no goal, all reachable cells are settled (Dijkstra) and `start` is returned.
    reach
        Written: cost of the cheapest path to each cell that was reached, inf elsewhere. Same shape as `cost`.
    parent
        Written: flat index of the cell before, -1 elsewhere. Same shape as `cost`.

    Returns
    -------
    int
        The goal's cell; where it cannot be reached, the reachable cell next to it (straight-line distance).
    """
    rows, columns = cost.shape
    everywhere = math.isnan(goal_x)
    goal_column, goal_row = -1, -1
    if not everywhere:
        goal_column, goal_row = math.floor(goal_x + 0.5), math.floor(goal_y + 0.5)
    outside = goal_column < 0 or goal_column >= columns or goal_row < 0 or goal_row >= rows
    flat_cost, flat_reach, flat_parent = cost.ravel(), reach.ravel(), parent.ravel()
    for cell in range(rows * columns):
        flat_reach[cell], flat_parent[cell] = math.inf, -1
    keys = np.empty(8 * rows * columns, np.float32)  # every cell is put in by each of its neighbours at most
    cells = np.empty(8 * rows * columns, np.int32)
    flat_reach[start] = 0.0
    keys[0], cells[0] = 0.0, start
    size = 1
    nearest, nearest_distance = start, math.inf
    while size > 0:
        key, cell = keys[0], cells[0]
        size = _sift_down(keys, cells, size)
        row, column = cell // columns, cell % columns
        remaining = 0.0 if everywhere else math.hypot(goal_x - column, goal_y - row)
        if key > flat_reach[cell] + remaining + 1e-3:
            continue  # reached more cheaply in the meantime
        if not everywhere:
            if remaining < nearest_distance - 1e-6:
                nearest, nearest_distance = cell, remaining
            border = row == 0 or column == 0 or row == rows - 1 or column == columns - 1
            if (row == goal_row and column == goal_column) or (outside and border):
                return cell
        here = flat_cost[cell] if flat_cost[cell] < math.inf else 1.0
        for k in range(8):
            dr, dc = _STEPS[k, 0], _STEPS[k, 1]
            r, c = row + dr, column + dc
            if r < 0 or c < 0 or r >= rows or c >= columns:
                continue
            there = r * columns + c
            if not flat_cost[there] < math.inf:
                continue
            length = DIAGONAL if dr != 0 and dc != 0 else 1.0
            total = np.float32(flat_reach[cell] + length * 0.5 * (here + flat_cost[there]))
            if total < flat_reach[there] and size < len(keys):
                flat_reach[there] = total
                flat_parent[there] = cell
                ahead = 0.0 if everywhere else math.hypot(goal_x - c, goal_y - r)
                size = _sift_up(keys, cells, size, float(total + ahead), there)
    return nearest


_STEPS = np.array([(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)], np.int64)


@njit
def _sift_up(keys: NDArray[np.float32], cells: NDArray[np.int32], size: int, key: float, cell: int) -> int:
    """Put an entry into the binary heap and return its new size."""
    i = size
    while i > 0:
        up = (i - 1) // 2
        if keys[up] <= key:
            break
        keys[i], cells[i] = keys[up], cells[up]
        i = up
    keys[i], cells[i] = key, cell
    return size + 1


@njit
def _sift_down(keys: NDArray[np.float32], cells: NDArray[np.int32], size: int) -> int:
    """Take the first entry out of the binary heap and return its new size."""
    size -= 1
    key, cell = keys[size], cells[size]
    i = 0
    while True:
        down = 2 * i + 1
        if down >= size:
            break
        if down + 1 < size and keys[down + 1] < keys[down]:
            down += 1
        if keys[down] >= key:
            break
        keys[i], cells[i] = keys[down], cells[down]
        i = down
    keys[i], cells[i] = key, cell
    return size


def trace(parent: NDArray[np.int32], end: int) -> NDArray[np.int64]:
    """Return the path that `search` found as (row, column) of every cell from its start to `end`, shape (k, 2)."""
    columns, before = parent.shape[1], parent.ravel()
    path = [end]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    cells = np.array(path[::-1])
    return np.stack([cells // columns, cells % columns], axis=1)
