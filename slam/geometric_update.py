"""Geometric update of the mapped regions (Oberländer et al. 2008, section II-C.1, in edge form).

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
from slam.growth import LEAST_SIZE, forget_edge, grow, keep_order, outward_of, take_row
from slam.innovation import condition, frame_of, innovation_covariance, match_edges, whiten, workspaces, wrap
from slam.jit import Array, Record, lean, njit
from slam.maps import add, cover, new_slot, own
from slam.measurement import MAX_MEASUREMENTS
from slam.paper_update import fuse_parameters
from slam.region import b_index, is_u, u_index
from slam.turning import turn

START_SIGMAS = 1.0
"""An open edge is first put at the measured edge minus this many standard deviations."""

PUSH_SIGMAS = 4.0
"""An open edge is pushed to the measured edge minus this many standard deviations.

The greatest of 1,000 normal errors is 3.2 standard deviations, and 3.6 told ones where the noise is a fifth above what
is told: standing still moves no edge beyond the end of the view.
"""

CONTRARY_SIGMAS = 3.0
"""A view that ends this many standard deviations beyond a closed edge speaks against the edge."""

REOPEN_AFTER = 4
"""A closed edge reopens when so many more views end beyond it than do not."""


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
    work, turned, born = workspaces(p.tolerance), np.zeros_like(measured[:1, 0]), np.full(len(measured), -1, np.int64)
    update_regions(particles, maps, near, n_near, measured, associations, scan_number, p, work[0], turned[0], born)


@lean
def update_regions(
    particles: Array,
    maps: Record,
    near: Array,
    n_near: Array,
    measured: Array,
    associations: Array,
    scan_number: int,
    p: Record,
    work: Record,
    turned: Record,
    born: Array,
) -> None:
    """Do what `update_geometry` says; `work` and `turned`, a `WORKSPACE` and a `REGION`, are scratch.

    `born` (M,) begins as -1: the slot of the region that a measurement begins is the same for all particles.
    """
    for i in range(len(particles)):
        particle = particles[i]
        for a in range(3):
            for b in range(3):
                work.pose_cov[a, b] = particle.cov[a, b]
        for j in range(len(measured)):
            a = associations[i, j]
            if a.slot >= 0:
                m = own(maps, i, a.slot)
                if a.turn_map:
                    turn(m, 1, turned)
                    take_row(turned, m)
                fuse_as_set(measured[j, a.turn], m, a.offset, particle.pose, work, p)
                m.sightings += 1
                m.last_seen = scan_number
                cover(maps, a.slot, m)
        # New regions come last: a region born in this scan explains no other measurement of it.
        for j in range(len(measured)):
            if associations[i, j].slot == NEW:
                slot = begin(maps, i, born, j, measured[j, 0], particle.pose, scan_number, p)
                doubt_pose(own(maps, i, slot), particle.pose, particle.cov)
                associations[i, j].slot = near[i, n_near[i]] = slot
                n_near[i] += 1


@lean
def begin(maps: Record, i: int, born: Array, j: int, z: Record, pose: Array, scan_number: int, p: Record) -> int:
    """Add the region that measurement j of this scan begins to the map of particle i; return its slot.

    `born` (M,) holds the slots of the scan's new regions, -1 where no particle has begun it yet.
    """
    region_id = scan_number * MAX_MEASUREMENTS + j
    if born[j] < 0:
        born[j] = new_slot(maps, region_id)
    m = add(maps, i, born[j])
    start(z, pose, m, p)
    m.id, m.last_seen = region_id, scan_number
    cover(maps, born[j], m)
    return born[j]


@njit
def start(z: Record, pose: Array, m: Record, p: Record) -> None:
    """Begin a region at a measurement: anchor at the middle of the main rectangle, edges relative to it."""
    take_row(z, m)
    k, i = u_index(z.main), b_index(z.main)
    mid_u = (z.state[k] + z.state[u_index(z.main + 1)]) / 2
    mid_v = (z.state[i] + z.state[i + 1]) / 2
    c, s = np.cos(z.state[0] + pose[2]), np.sin(z.state[0] + pose[2])
    m.anchor[0], m.anchor[1] = pose[0] + c * mid_u - s * mid_v, pose[1] + s * mid_u + c * mid_v
    m.state[0] = wrap(z.state[0] + pose[2])
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
        if not m.closed[k] and not p.paper_update:
            m.state[k] -= outward_of(m, k) * START_SIGMAS * np.sqrt(m.cov[k, k])
            forget_edge(m, k, FLAT_VARIANCE * m.cov[k, k])
    keep_order(m, LEAST_SIZE * p.tolerance)
    m.radius = bounding_radius(m)
    m.level, m.type = z.level, z.type
    m.existence, m.sightings, m.visited = 0.0, 1, 0
    m.rival = -1


@lean
def doubt_pose(m: Record, pose: Array, pose_cov: Array) -> None:
    """Add to the covariance of a new region that of the pose (3, 3) from which it was seen."""
    size = state_size(m.n)
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    dx, dy = m.anchor[0] - pose[0], m.anchor[1] - pose[1]
    for a in range(size):
        xa, ya, ta = by_pose(a, c, s, dx, dy)
        x = xa * pose_cov[0, 0] + ya * pose_cov[1, 0] + ta * pose_cov[2, 0]
        y = xa * pose_cov[0, 1] + ya * pose_cov[1, 1] + ta * pose_cov[2, 1]
        t = xa * pose_cov[0, 2] + ya * pose_cov[1, 2] + ta * pose_cov[2, 2]
        for b in range(size):
            xb, yb, tb = by_pose(b, c, s, dx, dy)
            m.cov[a, b] += x * xb + y * yb + t * tb


@lean
def by_pose(k: int, c: float, s: float, dx: float, dy: float) -> Any:
    """Return the derivative of a new region's state k by the pose (x, y, theta).

    (c, s): cosine and sine of phi; (dx, dy): from the robot to the anchor, m.
    """
    if k == 0:
        return 0.0, 0.0, 1.0
    if is_u(k):
        return c, s, s * dx - c * dy
    return -s, c, c * dx + s * dy


@lean
def fuse_as_set(z: Record, m: Record, offset: int, pose: Array, work: Record, p: Record) -> None:
    """Update region m with row z by the chosen model; the arguments are those of `fuse`."""
    if p.paper_update:
        fuse_parameters(z, m, offset, pose, work)
    else:
        fuse(z, m, offset, pose, work)


@lean
def fuse(z: Record, m: Record, offset: int, pose: Array, work: Record) -> None:
    """Update region m with row z, seen from a pose, with rectangle j of z being rectangle j + offset of m.

    The pose's covariance, `work.pose_cov`, adds to the measurement's: regions stay independent of the pose.
    """
    offset = grow(z, m, offset)
    slack, (c, s, pu, pv) = work.tolerance**2, frame_of(m, pose)
    settle_open_edges(z, m, offset, pu, pv, slack)
    rows, _ = match_edges(z, m, offset, c, s, pu, pv, pose[2], slack, work, np.inf)
    straighten(z, rows, work)
    innovation_covariance(z, m, rows, work.pose_cov, work)
    whiten(rows, work)
    size = state_size(m.n)
    for r in range(rows):
        for b in range(size):
            work.gain[r, b] = m.cov[work.im[r], b] + work.lever[r] * m.cov[0, b]
    condition(m.state, m.cov, size, rows, work)
    m.state[0] = wrap(m.state[0])
    keep_order(m, LEAST_SIZE * work.tolerance)
    m.radius = bounding_radius(m)


@lean
def straighten(z: Record, rows: int, work: Record) -> None:
    """Take the curvature out of the residuals: what the lever of phi leaves of a turn about the robot.

    The lines of z lie along its own noisy heading. Turning them by -r, to the heading of m, moves those along u by
    ``mid_u (cos r - 1) - mid_v sin r``; linear in r is the second term alone. The rest is ``-mid_u r² / 2``, the same
    way at every scan: left out, it lengthens each region by some millimetres, more than thousands of scans leave open.
    """
    k, i = u_index(z.main), b_index(z.main)
    mid_u = (z.state[k] + z.state[u_index(z.main + 1)]) / 2
    mid_v = (z.state[i] + z.state[i + 1]) / 2
    turn_by = work.residual[0]
    bend, twist = np.cos(turn_by) - 1.0, np.sin(turn_by) - turn_by
    for r in range(1, rows):
        if is_u(work.iz[r]):
            work.residual[r] += mid_u * bend - mid_v * twist
        else:
            work.residual[r] += mid_v * bend + mid_u * twist


@lean
def settle_open_edges(z: Record, m: Record, offset: int, pu: float, pv: float, slack: float) -> None:
    """Push the open edges of m out to z, and open a flat prior for those that z has closed.

    (pu, pv) is the anchor as seen from the pose (`frame_of`), `slack` a variance (m²) granted to the ends of views.
    """
    for k in range(max(0, offset), min(m.n, z.n + offset) + 1):
        if 0 < k < m.n and m.closed[u_index(k)]:
            continue  # a joint, known to be one
        outward = 1 if k == m.n else -1
        settle(z, m, u_index(k - offset), u_index(k), pu, outward, slack)
    for k in range(max(0, offset), min(m.n, z.n + offset)):
        for top in range(2):
            settle(z, m, b_index(k - offset) + top, b_index(k) + top, pv, 2 * top - 1, slack)


@lean
def settle(z: Record, m: Record, i: int, j: int, shift: float, outward: int, slack: float) -> None:
    """Settle one edge: j of m, i of z."""
    measured = z.state[i] - shift
    if m.closed[j]:
        is_beyond = False
        if not z.closed[i]:
            limit = CONTRARY_SIGMAS * np.sqrt(z.cov[i, i] + m.cov[j, j] + slack)
            is_beyond = outward * (measured - m.state[j]) > limit
        m.contrary[j] = m.contrary[j] + 1 if is_beyond else max(m.contrary[j] - 1, 0)
        if m.contrary[j] < REOPEN_AFTER:
            return
        m.closed[j] = 0
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
