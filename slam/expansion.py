"""Expansion of one region by another (Oberländer et al. 2008, section II-C.1, eqs. (1) and (2), Figs. 3 and 4).

Read edge by edge, (1) and (2) are one formula for every edge of every rectangle: the midpoint of the edge, projected
onto the other region's axis, against that region's own edge. Moving an edge moves midpoint and size with it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.growth import shift_right
from slam.jit import Array, Record, njit
from slam.region import b_index, u_index


@njit
def expand(a: Record, b: Record, offset: int, exact: bool, pushed: Array) -> None:
    """Push the open edges of region a out to region b, rectangle i of a being rectangle i + offset of b.

    For the main rectangles d_t and d_r are eqs. (1) and (2): with the midpoint of b's edge at (x, y) + h/2 n_v(phi_b),
    its projection onto n_v(phi_a) is n_v(phi_a) . (x, y) + h/2 cos(phi_b - phi_a). `exact`: where both edges of b along
    an axis are known, a takes them over, inwards as well (Fig. 4). `pushed`: by place in b, written.
    """
    for i in range(max(0, -offset), min(a.n, b.n - offset)):
        for axis in range(2):
            complete = b.closed[place(i + offset, axis, 0)] and b.closed[place(i + offset, axis, 1)]
            for side in range(2):
                k, j = place(i, axis, side), place(i + offset, axis, side)
                if a.closed[k]:
                    continue
                d = edge_of(b, i + offset, axis, side, a) - a.state[k]
                if (exact and complete) or (2 * side - 1) * d > 0.0:
                    a.state[k] += d
                    pushed[j] = True


@njit
def place(i: int, axis: int, side: int) -> Any:
    """Return the place in the state vector of an edge of rectangle i: left, right (axis 0), bottom or top (axis 1)."""
    return u_index(i + side) if axis == 0 else b_index(i) + side


@njit
def edge_of(b: Record, i: int, axis: int, side: int, a: Record) -> Any:
    """Return where the midpoint of an edge of b lies along the axis of a, m from a's anchor."""
    u = b.state[u_index(i + side)] if axis == 0 else (b.state[u_index(i)] + b.state[u_index(i + 1)]) / 2
    v = b.state[b_index(i) + side] if axis == 1 else (b.state[b_index(i)] + b.state[b_index(i) + 1]) / 2
    c, s = np.cos(b.state[0]), np.sin(b.state[0])
    x, y = b.anchor[0] + c * u - s * v - a.anchor[0], b.anchor[1] + s * u + c * v - a.anchor[1]
    c, s = np.cos(a.state[0]), np.sin(a.state[0])
    return c * x + s * y if axis == 0 else -s * x + c * y


@njit
def close_edges(z: Record, m: Record, offset: int) -> None:
    """Close the edges of m that z has closed."""
    for i in range(max(0, offset), min(m.n, z.n + offset)):
        for axis in range(2):
            for side in range(2):
                k = place(i, axis, side)
                m.closed[k] = max(m.closed[k], z.closed[place(i - offset, axis, side)])


@njit
def add_rectangles(z: Record, m: Record, offset: int) -> Any:
    """Give m the rectangles that only z has, where z has them; return the new offset."""
    old_first, old_n = 0, m.n
    while offset < 0:
        shift_right(m)
        offset += 1
        old_first += 1
    m.n = max(m.n, z.n + offset)
    if m.n == 3:
        m.main = 1
    for i in range(offset, z.n + offset):
        if old_first <= i < old_first + old_n:
            continue
        end = 0 if i < old_first else 1
        m.state[u_index(i + end)] = edge_of(z, i - offset, 0, end, m)
        m.closed[u_index(i + end)] = z.closed[u_index(i - offset + end)]
        for top in range(2):
            m.state[b_index(i) + top] = edge_of(z, i - offset, 1, top, m)
            m.closed[b_index(i) + top] = z.closed[b_index(i - offset) + top]
    return offset
