"""Rows of a joint update: closed edges of a measurement against those of a region, with pose and region unknown.

A measurement is a midpoint, sizes and a heading phi_z with independent noise. Its edges, as distances from the robot,
take their direction from phi_z; with the expected heading phi - theta instead, they do not carry its noise::

    r_0 = phi_z - (phi - theta)        r_k = rho_k(phi - theta) - (n . (a - p) + e_k)

    d r_0 = d theta - d phi
    d r_u = n_u . d p - d e - v d theta - (lever_u - v) d phi
    d r_v = n_v . d p - d e + u d theta - (lever_v + u) d phi

with (u, v) the measured midpoint along the region's axes, and the levers of `slam.innovation`: (a - p) . n_v for an
edge along n_u, -(a - p) . n_u for one along n_v. To first order these are the innovations of eqs. (19)–(23). What they
lack is a term of second order in the noise of phi_z, which is the same at every sighting and never averages out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.innovation import wrap
from slam.jit import Array, Record, njit
from slam.joint_gaussian import FLAT, POSE, allocate
from slam.region import MAX_STATE, b_index, is_u, u_index

SAME_EDGE, SAME_HEADING = 0.1, 0.001
"""Standard deviations, in tolerances and rad, with which twins agree on a line: what linearisation costs."""


@njit
def match_edges(z: Record, m: Record, offset: int, in_z: Array, in_m: Array) -> int:
    """Write the places of heading and of all edges closed in both, shapes (MAX_STATE,); return their number."""
    in_z[0] = in_m[0] = 0
    n = 1
    low, high = max(0, offset), min(m.n, z.n + offset)
    for k in range(low, high + 1):
        i, j = u_index(k - offset), u_index(k)
        if z.closed[i] and m.closed[j]:
            in_z[n], in_m[n] = i, j
            n += 1
    for k in range(low, high):
        for top in range(2):
            i, j = b_index(k - offset) + top, b_index(k) + top
            if z.closed[i] and m.closed[j]:
                in_z[n], in_m[n] = i, j
                n += 1
    return n


@njit
def write_rows(z: Record, m: Record, offset: int, joint: Record, slot: int, first: int, rows: Record) -> Any:
    """Write the rows of a measurement of a region from number `first` on; return the number of the next one.

    A closed edge of m that has no entry yet gets one, so that its row is met exactly. The caller has made room.
    """
    in_z, in_m = np.zeros(MAX_STATE, np.int64), np.zeros(MAX_STATE, np.int64)
    n = match_edges(z, m, offset, in_z, in_m)
    pose, entries = joint.mean, joint.entries[slot]
    phi = _value(joint, entries, m, 0)
    c, s = np.cos(phi), np.sin(phi)
    dx, dy = m.anchor[0] - pose[0], m.anchor[1] - pose[1]
    pu, pv = c * dx + s * dy, -s * dx + c * dy
    turned = wrap(phi - pose[2] - z.state[0])
    mid_u, mid_v = midpoint(z)
    u = np.cos(turned) * mid_u + np.sin(turned) * mid_v
    v = np.cos(turned) * mid_v - np.sin(turned) * mid_u
    write_noise(z, in_z[:n], mid_u, mid_v, first, rows.noise)
    for k in range(n):
        i, j, row = in_z[k], in_m[k], first + k
        value = _value(joint, entries, m, j)
        if k == 0:
            r, coefficients = -turned, (0.0, 0.0, -1.0, 1.0, 0.0)
        elif is_u(j):
            r, coefficients = z.state[i] + (u - mid_u) - pu - value, (-c, -s, v, pv - v, 1.0)
        else:
            r, coefficients = z.state[i] + (v - mid_v) - pv - value, (s, -c, -u, u - pu, 1.0)
        rows.fresh[row] = entries[j] < 0
        if entries[j] < 0:
            entries[j] = allocate(joint, value + r, FLAT * rows.noise[row, row])
            r = 0.0
        rows.residual[row] = r
        rows.places[row, 0], rows.places[row, 1], rows.places[row, 2] = 0, 1, 2
        rows.places[row, 3], rows.places[row, 4] = entries[0], entries[j]
        for t in range(5):
            rows.coefficient[row, t] = coefficients[t]
    return first + n


@njit
def write_noise(z: Record, in_z: Array, mid_u: float, mid_v: float, first: int, noise: Array) -> None:
    """Write the covariance of heading and edges of a measurement, the edges' without what they owe to the heading."""
    n = len(in_z)
    lever = np.zeros(n)
    for k in range(1, n):
        lever[k] = mid_v if is_u(in_z[k]) else -mid_u
    for k in range(n):
        a = in_z[k]
        for q in range(n):
            b = in_z[q]
            noise[first + k, first + q] = (
                z.cov[a, b] - lever[k] * z.cov[0, b] - lever[q] * z.cov[a, 0] + lever[k] * lever[q] * z.cov[0, 0]
            )


@njit
def write_twin_rows(
    twin: Record, m: Record, offset: int, joint: Record, twin_slot: int, slot: int, tolerance: float, rows: Record
) -> int:
    """Write the rows that say that two regions are one; return their number.

    The rows are those of `slam.innovation.correspond`, of the twin's edges as seen from its anchor. The terms in the
    pose vanish once both headings agree; until then they keep the rows blind to rigid motions of the scene.
    """
    in_z, in_m = np.zeros(MAX_STATE, np.int64), np.zeros(MAX_STATE, np.int64)
    n = match_edges(twin, m, offset, in_z, in_m)
    entries, twin_entries = joint.entries[slot], joint.entries[twin_slot]
    phi = _value(joint, entries, m, 0)
    c, s = np.cos(phi), np.sin(phi)
    dx, dy = m.anchor[0] - twin.anchor[0], m.anchor[1] - twin.anchor[1]
    pu, pv = c * dx + s * dy, -s * dx + c * dy
    tilt = wrap(joint.mean[twin_entries[0]] - phi)
    du, dv = np.cos(tilt) - 1.0, np.sin(tilt)  # of the twin's first axis, along both of m
    ax, ay = twin.anchor[0] - joint.mean[0], twin.anchor[1] - joint.mean[1]
    for k in range(n):
        i, j = in_z[k], in_m[k]
        if k == 0:
            r, lever, nx, ny = tilt, 0.0, 0.0, 0.0
        elif is_u(j):
            r, lever = joint.mean[twin_entries[i]] - pu - _value(joint, entries, m, j), pv
            nx, ny = c * du - s * dv, s * du + c * dv
        else:
            r, lever = joint.mean[twin_entries[i]] - pv - _value(joint, entries, m, j), -pu
            nx, ny = -s * du - c * dv, c * du - s * dv
        rows.fresh[k] = entries[j] < 0
        if entries[j] < 0:
            variance = joint.cov[twin_entries[i], twin_entries[i]]
            entries[j] = allocate(joint, _value(joint, entries, m, j) + r, FLAT * variance)
            r = 0.0
        rows.residual[k] = r
        rows.places[k, 0], rows.coefficient[k, 0] = entries[0], lever
        rows.places[k, 1], rows.coefficient[k, 1] = entries[j], 1.0
        rows.places[k, 2], rows.coefficient[k, 2] = twin_entries[i], -1.0
        for t in range(POSE):
            rows.places[k, 3 + t] = t
        rows.coefficient[k, 3], rows.coefficient[k, 4], rows.coefficient[k, 5] = nx, ny, ny * ax - nx * ay
        rows.noise[k, k] = (SAME_EDGE * tolerance) ** 2 if k > 0 else SAME_HEADING**2
    return n


@njit
def _value(joint: Record, entries: Array, m: Record, k: int) -> Any:
    """Return the mean of an entry of a region's state vector; that of the record where it is in no entry yet."""
    return joint.mean[entries[k]] if entries[k] >= 0 else m.state[k]


@njit
def midpoint(z: Record) -> Any:
    """Return the midpoint (u, v) of the main rectangle along the row's own axes, m."""
    i = b_index(z.main)
    u = (z.state[u_index(z.main)] + z.state[u_index(z.main + 1)]) / 2
    return u, (z.state[i] + z.state[i + 1]) / 2


@njit
def relative_covariance(m: Record, joint: Record, slot: int) -> None:
    """Write into a region's record the covariance of its state as seen from the pose, for data association.

    Of phi - theta and e - n . p + lever theta: with them and a pose that is certain, `slam.innovation.innovate` finds
    the covariance that the rows have in the joint Gaussian. Entries that are not in it keep theirs.
    """
    cov, entries, pose = joint.cov, joint.entries[slot], joint.mean
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    dx, dy = m.anchor[0] - pose[0], m.anchor[1] - pose[1]
    pu, pv = c * dx + s * dy, -s * dx + c * dy
    by_pose = np.zeros((MAX_STATE, POSE))
    by_pose[0, 2] = -1.0
    for k in range(1, MAX_STATE):
        along_u = is_u(k)
        by_pose[k, 0], by_pose[k, 1], by_pose[k, 2] = (-c, -s, pv) if along_u else (s, -c, -pu)
    for a in range(MAX_STATE):
        if entries[a] < 0:
            continue
        for b in range(a + 1):
            if entries[b] < 0:
                continue
            total = cov[entries[a], entries[b]]
            for i in range(POSE):
                total += by_pose[a, i] * cov[i, entries[b]] + by_pose[b, i] * cov[i, entries[a]]
                for j in range(POSE):
                    total += by_pose[a, i] * by_pose[b, j] * cov[i, j]
            m.cov[a, b] = m.cov[b, a] = total
