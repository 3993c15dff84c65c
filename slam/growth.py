"""How a mapped region changes its shape: rectangles are added, edges forgotten, crossed edges put in order."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.edge_form import FLAT_VARIANCE
from slam.jit import Record, lean, njit
from slam.region import b_index, u_index

LEAST_SIZE = 0.1
"""Least width or height of a rectangle, in tolerances."""


@njit
def take_row(source: Record, m: Record) -> None:
    """Copy another description of the same place into a region."""
    m.n, m.main, m.radius = source.n, source.main, source.radius
    m.anchor[:] = source.anchor
    m.state[:] = source.state
    m.cov[:] = source.cov
    m.closed[:] = source.closed
    m.contrary[:] = source.contrary


@lean
def outward_of(m: Record, k: int) -> Any:
    """Return the outward direction (-1 or 1) of an outer edge by its place k in the state vector."""
    if k == u_index(m.n):
        return 1
    return 1 if k > 2 and k % 3 == 1 else -1


@lean
def grow(z: Record, m: Record, offset: int) -> Any:
    """Give m the rectangles that only z has; return the new offset. The middle one of three becomes the main one."""
    while offset < 0:
        shift_right(m)
        offset += 1
    while z.n + offset > m.n:
        m.n += 1
        bare_rectangle(m, m.n - 1, u_index(m.n), u_index(m.n - 1))
    if m.n == 3:
        m.main = 1
    return offset


@lean
def shift_right(m: Record) -> None:
    """Make room for a rectangle at the left end of a row: every edge moves up by one rectangle."""
    for k in range(m.n, -1, -1):
        move_state(m, u_index(k), u_index(k + 1))
    for i in range(m.n - 1, -1, -1):
        move_state(m, b_index(i) + 1, b_index(i + 1) + 1)
        move_state(m, b_index(i), b_index(i + 1))
    m.n += 1
    m.main += 1
    bare_rectangle(m, 0, u_index(0), u_index(1))


@lean
def bare_rectangle(m: Record, i: int, end: Record, joint: Record) -> None:
    """Make rectangle i one of which nothing is known but the joint: bounds that any view pushes out."""
    for k in (end, b_index(i), b_index(i) + 1):
        forget_edge(m, k, FLAT_VARIANCE * m.cov[joint, joint])
    m.state[end] = -np.inf if end > joint else np.inf
    m.state[b_index(i)], m.state[b_index(i) + 1] = np.inf, -np.inf


@lean
def move_state(m: Record, source: Record, target: int) -> None:
    """Move one entry of the state with its row and column of the covariance."""
    m.state[target], m.closed[target], m.contrary[target] = m.state[source], m.closed[source], m.contrary[source]
    size = len(m.state)
    variance = m.cov[source, source]
    for a in range(size):
        m.cov[target, a] = m.cov[source, a]
    for a in range(size):
        m.cov[a, target] = m.cov[target, a]
    m.cov[target, target] = variance


@lean
def forget_edge(m: Record, k: int, variance: float) -> None:
    """Make an edge open and independent of everything else, with a variance that should be flat."""
    m.closed[k] = m.contrary[k] = 0
    for a in range(len(m.state)):
        m.cov[k, a] = m.cov[a, k] = 0.0
    m.cov[k, k] = variance


@lean
def keep_order(m: Record, least: float) -> None:
    """Keep edges from crossing, `least` m apart: open ones give way, and closed ones, as noise can swap them."""
    for k in range(m.n):
        i, j = u_index(k), u_index(k + 1)
        if m.state[j] - m.state[i] < least:
            if not m.closed[j]:
                m.state[j] = m.state[i] + least
            elif not m.closed[i]:
                m.state[i] = m.state[j] - least
            else:
                m.state[j] = m.state[i] + least
    for k in range(m.n):
        i = b_index(k)
        if m.state[i + 1] - m.state[i] < least:
            if not m.closed[i + 1]:
                m.state[i + 1] = m.state[i] + least
            elif not m.closed[i]:
                m.state[i] = m.state[i + 1] - least
            else:
                middle = (m.state[i] + m.state[i + 1]) / 2
                m.state[i], m.state[i + 1] = middle - least / 2, middle + least / 2
