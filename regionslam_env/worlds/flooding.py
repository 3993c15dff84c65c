"""Kernels of the distance field: every grid node learns the root of the last straight piece of its way to the goal."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.worlds.clearance import Grid, rolls_straight
from regionslam_env.worlds.heap import drop_first, lower
from slam.jit import Array, lean, njit
from slam.rows import Floats


class Roots(NamedTuple):
    """Everything a query needs: roots 0 .. V-1 are corners, V .. V+G-1 rectangles of the goal."""

    grid: Grid
    points: Floats  # (V, 2) corners
    distance: Floats  # (V,) from the corner to the goal
    goals: Floats  # (G, 8) rectangles: x, y, cos, sin of the row's frame, then u0, u1, b, t
    first: NDArray[np.int64]  # (V + 2,) corners whose next is corner k are behind[first[k + 1] : first[k + 2]]
    behind: NDArray[np.int64]  # (V,) corners by their next one; first those that see the goal (k = -1)
    root: NDArray[np.int64]  # (nx * ny,) of each grid node, -1 where the goal cannot be reached
    value: Floats  # (nx * ny,) distance at the node, m


@lean
def foot(goal: Array, x: float, y: float) -> tuple[float, float, float]:
    """Return the point of a rectangle nearest to (x, y), and its distance."""
    along = goal[2] * (x - goal[0]) + goal[3] * (y - goal[1])
    across = -goal[3] * (x - goal[0]) + goal[2] * (y - goal[1])
    u, v = min(max(along, goal[4]), goal[5]), min(max(across, goal[6]), goal[7])
    fx, fy = goal[0] + goal[2] * u - goal[3] * v, goal[1] + goal[3] * u + goal[2] * v
    return fx, fy, np.hypot(along - u, across - v)


@lean
def see_goals(grid: Grid, points: Array, goals: Array, distance: Array) -> None:
    """Lower the distance of every corner that sees its nearest point of a goal rectangle."""
    for v in range(len(points)):
        for g in range(len(goals)):
            fx, fy, straight = foot(goals[g], points[v, 0], points[v, 1])
            if straight < distance[v] and rolls_straight(grid, points[v, 0], points[v, 1], fx, fy):
                distance[v] = straight


@lean
def see_points(grid: Grid, corners: Array, points: Array, offsets: Array, distance: Array, towards: Array) -> None:
    """Lower the distance of every corner that sees one of some points; `towards` gets the point's number behind all."""
    for v in range(len(corners)):
        for p in range(len(points)):
            x, y = points[p, 0], points[p, 1]
            through = offsets[p] + np.hypot(x - corners[v, 0], y - corners[v, 1])
            if through < distance[v] and rolls_straight(grid, corners[v, 0], corners[v, 1], x, y):
                distance[v], towards[v] = through, len(corners) + p


@njit
def mark_leaving(roots: Roots, part: Array, leaving: Array) -> None:
    """Mark the nodes of a part of the floor at which a way leaves it, or ends in it.

    Every other node of the part lies on a way to one of those, so none is needed to find the shortest.

    Parameters
    ----------
    part
        Which nodes belong to it, (nx * ny,).
    leaving
        The same of those that are marked; filled with False before.
    """
    grid = roots.grid
    ny = grid.clearance.shape[1]
    for node in np.flatnonzero(part):
        i, j = node // ny, node % ny
        root = int(roots.root[node])
        if root < 0:
            continue
        x, y = grid.x0 + i * grid.step, grid.y0 + j * grid.step
        value, px, py = through_root(roots, root, x, y)
        straight = np.hypot(px - x, py - y)
        if straight >= grid.step and value > 0:
            ahead = (i + round((px - x) / straight)) * ny + j + round((py - y) / straight)
            leaving[node] = not part[ahead]
            continue
        for beside in (node - ny, node + ny, node - 1, node + 1):  # where it ends, the rim will do
            leaving[node] |= not part[beside] or roots.value[beside] > 0


@lean
def through_root(roots: Roots, root: int, x: float, y: float) -> tuple[float, float, float]:
    """Return the distance from (x, y) to the goal through a root, and the end of the straight piece."""
    corners = len(roots.points)
    if root < corners:
        px, py = roots.points[root, 0], roots.points[root, 1]
        return roots.distance[root] + np.hypot(x - px, y - py), px, py
    fx, fy, straight = foot(roots.goals[root - corners], x, y)
    return straight, fx, fy


@lean
def improve(roots: Roots, node: int, root: int, failed: Array, stack: Array) -> bool:
    """Give a node this root, or one behind it, if that is shorter and its straight piece free; returns whether it was.

    A node that cannot see the root stands in the shadow of a corner whose own way leads through that root; often the
    shadow is thinner than the grid and nobody else would hand the corner on.
    """
    grid, corners = roots.grid, len(roots.points)
    i, j = node // grid.clearance.shape[1], node % grid.clearance.shape[1]
    if grid.clearance[i, j] < 0 or failed[node] == root:
        return False
    x, y = grid.x0 + i * grid.step, grid.y0 + j * grid.step
    improved, size = False, 1
    stack[0] = root
    while size > 0:
        size -= 1
        tried = stack[size]
        value, px, py = through_root(roots, tried, x, y)
        if value > roots.value[node] - 1e-9:
            continue
        if rolls_straight(grid, x, y, px, py):
            roots.value[node] = value
            roots.root[node] = tried
            improved = True
            continue
        failed[node] = tried
        parent = tried if tried < corners else -1
        for c in range(roots.first[parent + 1], roots.first[parent + 2]):
            child = roots.behind[c]
            detour = through_root(roots, child, x, y)[0] - value
            if detour < 2 * grid.step and size < len(stack):
                stack[size] = child
                size += 1
    return improved


@lean
def flood(roots: Roots, heap: Array, place: Array, failed: Array, stack: Array) -> None:
    """Fill `root` and `value` outwards from the goals and the corners, nearest nodes first.

    Parameters
    ----------
    heap, place, failed
        Room for every node; `place` and `failed` filled with -1.
    stack
        Room for the roots still to be tried at a node.
    """
    grid, corners = roots.grid, len(roots.points)
    nx, ny = grid.clearance.shape
    size = 0
    for root in range(corners + len(roots.goals)):
        if root < corners and roots.distance[root] == np.inf:
            continue
        lx, ly, hx, hy = extent(roots, root)
        for i in range(max(0, int((lx - grid.x0) / grid.step)), min(nx, int((hx - grid.x0) / grid.step) + 2)):
            for j in range(max(0, int((ly - grid.y0) / grid.step)), min(ny, int((hy - grid.y0) / grid.step) + 2)):
                if improve(roots, i * ny + j, root, failed, stack):
                    size = lower(heap, place, roots.value, size, i * ny + j)
    while size > 0:
        node = heap[0]
        size = drop_first(heap, place, roots.value, size)
        for k in range(4):
            i, j = node // ny + (k == 0) - (k == 1), node % ny + (k == 2) - (k == 3)
            if 0 <= i < nx and 0 <= j < ny and improve(roots, i * ny + j, int(roots.root[node]), failed, stack):
                size = lower(heap, place, roots.value, size, i * ny + j)


@lean
def extent(roots: Roots, root: int) -> tuple[float, float, float, float]:
    """Return the box (lowest x, y, highest x, y) of a root: a point, or a rectangle of the goal."""
    corners = len(roots.points)
    if root < corners:
        x, y = roots.points[root, 0], roots.points[root, 1]
        return x, y, x, y
    g = roots.goals[root - corners]
    u, v, half_u, half_v = (g[4] + g[5]) / 2, (g[6] + g[7]) / 2, (g[5] - g[4]) / 2, (g[7] - g[6]) / 2
    x, y = g[0] + g[2] * u - g[3] * v, g[1] + g[3] * u + g[2] * v
    half_x, half_y = abs(g[2]) * half_u + abs(g[3]) * half_v, abs(g[3]) * half_u + abs(g[2]) * half_v
    return x - half_x, y - half_y, x + half_x, y + half_y


@lean
def query(roots: Roots, x: float, y: float) -> tuple[float, int]:
    """Return the distance from a point to the goal and its root (-1 if unreachable).

    The point takes the best root of the nodes around it. Where all of them are blocked (it touches a wall), the nearest
    ring of nodes with a root helps out, at most four nodes away.
    """
    grid = roots.grid
    nx, ny = grid.clearance.shape
    best, best_root = np.inf, -1
    i0, j0 = int(np.floor((x - grid.x0) / grid.step)), int(np.floor((y - grid.y0) / grid.step))
    for ring in range(5):
        for i in range(max(0, i0 - ring), min(nx, i0 + ring + 2)):
            for j in range(max(0, j0 - ring), min(ny, j0 + ring + 2)):
                root = int(roots.root[i * ny + j])
                if root >= 0:
                    value = through_root(roots, root, x, y)[0]
                    if value < best:
                        best, best_root = value, root
        if best_root >= 0:
            break
    return best, best_root


@lean
def distance_at(roots: Any, x: float, y: float) -> float:
    """Return the distance from a point to the goal, 0 inside; `roots` holds the parts of `Roots` and of its grid."""
    named = Roots(Grid(*roots[0]), *roots[1:])
    for g in range(len(named.goals)):
        if foot(named.goals[g], x, y)[2] == 0:
            return 0.0
    return query(named, x, y)[0]
