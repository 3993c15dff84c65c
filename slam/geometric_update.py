"""Geometric update of the mapped regions from drawn poses (Oberländer et al. 2008, section II-C.1, in edge form).

Closed edges of the measurement observe closed edges of the region directly: one joint Kalman update of phi and all
edges. An open edge of the region is a bound. Any edge of the measurement beyond it pushes it outwards, the paper's
expansion (1)–(2), but only by a lower confidence bound, or noise would push it for ever. The first closed observation
sets it from a flat prior. An edge that is open in the measurement says nothing about a closed one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.association import NEW
from slam.edge_form import FLAT_VARIANCE, bounding_radius, state_size
from slam.innovation import condition, correspond, innovate, workspace
from slam.jit import Array, Record, njit
from slam.maps import add, cover, new_slot, own
from slam.measurement import MAX_MEASUREMENTS
from slam.region import b_index, u_index
from slam.turning import turn

START_SIGMAS = 1.0
"""An open edge is first put at the measured edge minus this many standard deviations."""

PUSH_SIGMAS = 3.0
"""An open edge is pushed to the measured edge minus this many standard deviations.

The greatest of 1,000 normal errors is 3.2 standard deviations: standing still moves no edge beyond the end of the view.
"""

LEAST_SIZE = 0.1
"""Least width or height of a rectangle, in tolerances."""


@njit
def update_geometry(
    particles: Array,
    maps: Record,
    near: Array,
    n_near: Array,
    measured: Array,
    associations: Array,
    scan_number: int,
    p: Record,
) -> None:
    """Update every associated region and add the new ones; a new region's slot goes into `associations` and `near`."""
    work = workspace(p.tolerance)
    turned = np.zeros_like(measured[:1, 0])
    born = np.full(len(measured), -1, np.int64)  # the slot of a new region is the same for all particles
    for i in range(len(particles)):
        particle = particles[i]
        for j in range(len(measured)):
            a = associations[i, j]
            if a.slot >= 0:
                m = own(maps, i, a.slot)
                if a.turn_map:
                    turn(m, 1, turned[0])
                    take_row(turned[0], m)
                fuse(measured[j, a.turn], m, a.offset, particle.pose, work)
                m.sightings += 1
                m.last_seen = scan_number
                cover(maps, a.slot, m)
        # New regions come last: a region born in this scan explains no other measurement of it.
        for j in range(len(measured)):
            if associations[i, j].slot == NEW:
                region_id = scan_number * MAX_MEASUREMENTS + j
                if born[j] < 0:
                    born[j] = new_slot(maps, region_id)
                m = add(maps, i, born[j])
                start(measured[j, 0], particle.pose, m, p)
                m.id, m.last_seen = region_id, scan_number
                cover(maps, born[j], m)
                associations[i, j].slot = near[i, n_near[i]] = born[j]
                n_near[i] += 1


@njit
def take_row(source: Record, m: Record) -> None:
    """Copy another description of the same place into a region."""
    m.n, m.main, m.radius = source.n, source.main, source.radius
    m.anchor[:] = source.anchor
    m.state[:] = source.state
    m.cov[:] = source.cov
    m.closed[:] = source.closed


@njit
def start(z: Record, pose: Array, m: Record, p: Record) -> None:
    """Begin a region at a measurement: anchor at the middle of the main rectangle, edges relative to it."""
    take_row(z, m)
    k, i = u_index(z.main), b_index(z.main)
    mid_u = (z.state[k] + z.state[u_index(z.main + 1)]) / 2
    mid_v = (z.state[i] + z.state[i + 1]) / 2
    c, s = np.cos(z.state[0] + pose[2]), np.sin(z.state[0] + pose[2])
    m.anchor[0], m.anchor[1] = pose[0] + c * mid_u - s * mid_v, pose[1] + s * mid_u + c * mid_v
    m.state[0] = (z.state[0] + pose[2] + np.pi) % (2 * np.pi) - np.pi
    size = state_size(z.n)
    lever = np.zeros(size)
    for k in range(z.n + 1):
        lever[u_index(k)] = mid_v
        m.state[u_index(k)] -= mid_u
    for i in range(z.n):
        for k in range(b_index(i), b_index(i) + 2):
            lever[k] = -mid_u
            m.state[k] -= mid_v
    # e = rho - lever-free part: moving the anchor to the midpoint takes the lever of phi out of every edge.
    for a in range(size):
        for b in range(size):
            m.cov[a, b] = (
                z.cov[a, b] - lever[a] * z.cov[0, b] - lever[b] * z.cov[a, 0] + lever[a] * lever[b] * z.cov[0, 0]
            )
    for k in range(1, size):
        if not m.closed[k]:
            m.state[k] -= outward_of(m, k) * START_SIGMAS * np.sqrt(m.cov[k, k])
            forget_edge(m, k, FLAT_VARIANCE * m.cov[k, k])
    keep_order(m, LEAST_SIZE * p.tolerance)
    m.radius = bounding_radius(m)
    m.type, m.type_log_odds = z.type, p.prior_type + z.confidence - 0.5
    m.existence, m.sightings, m.visited = 0.0, 1, 0
    m.rival = -1


@njit
def outward_of(m: Record, k: int) -> Any:
    """Return the outward direction (-1 or 1) of an outer edge by its place k in the state vector."""
    if k == u_index(m.n):
        return 1
    return 1 if k > 2 and k % 3 == 1 else -1


@njit
def fuse(z: Record, m: Record, offset: int, pose: Array, work: Record) -> None:
    """Update region m with row z, seen from a certain pose with rectangle j of z being rectangle j + offset of m."""
    offset = grow(z, m, offset)
    settle_open_edges(z, m, offset, pose)
    rows, _ = correspond(z, m, offset, pose, work.tolerance**2, work, np.inf)
    innovate(z, m, rows, work.certain, work)
    size = state_size(m.n)
    for r in range(rows):
        for b in range(size):
            work.gain[r, b] = m.cov[work.im[r], b] + work.lever[r] * m.cov[0, b]
    condition(m.state, m.cov, size, rows, work)
    m.state[0] = (m.state[0] + np.pi) % (2 * np.pi) - np.pi
    keep_order(m, LEAST_SIZE * work.tolerance)
    m.radius = bounding_radius(m)


@njit
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


@njit
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


@njit
def bare_rectangle(m: Record, i: int, end: Record, joint: Record) -> None:
    """Make rectangle i one of which nothing is known but the joint: bounds that any view pushes out."""
    for k in (end, b_index(i), b_index(i) + 1):
        forget_edge(m, k, FLAT_VARIANCE * m.cov[joint, joint])
    m.state[end] = -np.inf if end > joint else np.inf
    m.state[b_index(i)], m.state[b_index(i) + 1] = np.inf, -np.inf


@njit
def move_state(m: Record, source: Record, target: int) -> None:
    """Move one entry of the state with its row and column of the covariance."""
    m.state[target], m.closed[target] = m.state[source], m.closed[source]
    size = len(m.state)
    variance = m.cov[source, source]
    for a in range(size):
        m.cov[target, a] = m.cov[source, a]
    for a in range(size):
        m.cov[a, target] = m.cov[target, a]
    m.cov[target, target] = variance


@njit
def forget_edge(m: Record, k: int, variance: float) -> None:
    """Make an edge open and independent of everything else, with a variance that should be flat."""
    m.closed[k] = 0
    for a in range(len(m.state)):
        m.cov[k, a] = m.cov[a, k] = 0.0
    m.cov[k, k] = variance


@njit
def settle_open_edges(z: Record, m: Record, offset: int, pose: Array) -> None:
    """Push the open edges of m out to z, and open a flat prior for those that z has closed."""
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    dx, dy = m.anchor[0] - pose[0], m.anchor[1] - pose[1]
    pu, pv = c * dx + s * dy, -s * dx + c * dy
    for k in range(max(0, offset), min(m.n, z.n + offset) + 1):
        outward = 1 if k == m.n else -1
        settle(z, m, u_index(k - offset), u_index(k), pu, outward)
    for k in range(max(0, offset), min(m.n, z.n + offset)):
        for top in range(2):
            settle(z, m, b_index(k - offset) + top, b_index(k) + top, pv, 2 * top - 1)


@njit
def settle(z: Record, m: Record, i: int, j: int, shift: float, outward: int) -> None:
    """Settle one edge: j of m, i of z."""
    if m.closed[j]:
        return
    measured = z.state[i] - shift
    if z.closed[i]:
        forget_edge(m, j, FLAT_VARIANCE * z.cov[i, i])
        m.closed[j] = 1
        m.state[j] = measured
    else:
        sigmas = START_SIGMAS if np.isinf(m.state[j]) else PUSH_SIGMAS
        bound = measured - outward * sigmas * np.sqrt(z.cov[i, i])
        if outward * (bound - m.state[j]) > 0.0:
            m.state[j] = bound
            forget_edge(m, j, FLAT_VARIANCE * z.cov[i, i] if z.cov[i, i] > 0.0 else m.cov[j, j])


@njit
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
