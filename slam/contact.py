"""Where two regions touch: links belong to the edge of a region at which its neighbour lies (Fig. 1).

A contact is kept as a point. Edges are renamed when a region grows by a rectangle or is described anew, points stay.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.extent import point_in_rectangle, to_row
from slam.jit import Record, lean
from slam.region import b_index, u_index

REACH = 3.0
"""Regions nearer than this touch, in tolerances of the filter: walls are as thick, and measurements as noisy."""


@lean
def contact(a: Record, b: Record, tolerance: float) -> Any:
    """Return the point (x, y) on the outer edges of row a at which it touches row b, both in edge form in one frame.

    It is the middle of the longest part of an edge within `REACH` of b, or else the point nearest to the middle of b.
    """
    # A point (u, v) of a's axes lies at origin + turn (u, v) in b's axes.
    c, s = np.cos(a.state[0] - b.state[0]), np.sin(a.state[0] - b.state[0])
    origin_u, origin_v = to_row(b, a.anchor[0], a.anchor[1])
    longest, u, v = 0.0, 0.0, 0.0
    for i in range(a.n):
        for side in range(4):
            if not is_outer(a, i, side):
                continue
            u0, v0, u1, v1 = ends(a, i, side)
            bu, bv = origin_u + c * u0 - s * v0, origin_v + s * u0 + c * v0
            du, dv = c * (u1 - u0) - s * (v1 - v0), s * (u1 - u0) + c * (v1 - v0)
            for j in range(b.n):
                first, last = clip(b, j, REACH * tolerance, bu, bv, du, dv)
                length = (last - first) * (u1 - u0 + v1 - v0)
                if length > longest + 1e-9:
                    middle = (first + last) / 2
                    longest, u, v = length, u0 + middle * (u1 - u0), v0 + middle * (v1 - v0)
    if longest == 0.0:
        x, y = point_in_rectangle(b, b.main, 0.5, 0.5)
        u, v = to_row(a, x, y)
        _, u, v = nearest_side(a, u, v)
    return from_row(a, u, v)


@lean
def clip(b: Record, j: int, reach: float, u: float, v: float, du: float, dv: float) -> Any:
    """Return the shares [first, last] of a segment from (u, v), in b's axes, within `reach` (m) of its rectangle j."""
    k = b_index(j)
    first, last = 0.0, 1.0
    for axis in range(2):
        if axis == 0:
            start, step, low, high = u, du, b.state[u_index(j)] - reach, b.state[u_index(j + 1)] + reach
        else:
            start, step, low, high = v, dv, b.state[k] - reach, b.state[k + 1] + reach
        end = start + step
        if max(start, end) < low or min(start, end) > high:
            return 0.0, 0.0
        if (low <= min(start, end) and max(start, end) <= high) or abs(step) < 1e-12:
            continue
        at_low, at_high = (low - start) / step, (high - start) / step
        first, last = max(first, min(at_low, at_high)), min(last, max(at_low, at_high))
    return (first, last) if last > first else (0.0, 0.0)


@lean
def nearest_edge(m: Record, x: float, y: float) -> Any:
    """Return the outer edge nearest to a point of the map frame, by its place in the state vector, and where (x, y)."""
    u, v = to_row(m, x, y)
    found, u, v = nearest_side(m, u, v)
    at_x, at_y = from_row(m, u, v)
    return found, at_x, at_y


@lean
def nearest_side(m: Record, u: float, v: float) -> Any:
    """Return the outer edge nearest to a point in the row's axes, and where in these axes."""
    best, found, at_u, at_v = np.inf, 0, u, v
    for i in range(m.n):
        for side in range(4):
            if is_outer(m, i, side):
                u0, v0, u1, v1 = ends(m, i, side)
                near_u, near_v = min(max(u, u0), u1), min(max(v, v0), v1)
                distance = (near_u - u) ** 2 + (near_v - v) ** 2
                if distance < best - 1e-12:
                    best, at_u, at_v = distance, near_u, near_v
                    found = b_index(i) + side if side < 2 else u_index(i + side - 2)
    return found, at_u, at_v


@lean
def is_outer(m: Record, i: int, side: int) -> bool:
    """Say whether a side of rectangle i (0 bottom, 1 top, 2 left, 3 right) is no joint with another rectangle."""
    return side < 2 or (side == 2 and i == 0) or (side == 3 and i == m.n - 1)


@lean
def ends(m: Record, i: int, side: int) -> Any:
    """Return the ends (u0, v0, u1, v1) of a side of rectangle i in the row's axes, both ascending."""
    k = b_index(i)
    u0, u1, v0, v1 = m.state[u_index(i)], m.state[u_index(i + 1)], m.state[k], m.state[k + 1]
    if side < 2:
        v = v0 if side == 0 else v1
        return u0, v, u1, v
    u = u0 if side == 2 else u1
    return u, v0, u, v1


@lean
def from_row(m: Record, u: float, v: float) -> Any:
    """Return a point of the row's axes in the map frame."""
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    return m.anchor[0] + c * u - s * v, m.anchor[1] + s * u + c * v
