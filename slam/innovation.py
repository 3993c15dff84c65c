"""The innovation between a measured and a mapped region (Oberländer et al. 2008, eqs. 19–23), edge by edge.

Both are rows of lines. From pose (x, y, theta) a mapped edge at e along normal n, anchored at a, is expected at::

    rho = n . (a - p) + e        d rho / d p = -n     d rho / d theta = 0     d rho / d phi = lever

and the heading at phi - theta. The differences rho_z - rho are the d_x, d_y that the paper averages; kept apart, each
with its own variance, they use the correlations between edges, and (23) is the special case of equal weights. An edge
that is open in either region gives no row, for a zero would claim perfect agreement.

A row of the correspondence holds: index in z, index in m, residual, lever (d rho / d phi of m), and -d r / d (x, y).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.edge_form import state_size
from slam.jit import Array, Record, lean, njit
from slam.measurement import MEASUREMENT
from slam.region import MAX_STATE, REGION, b_index, u_index

DRIFT = 3.0
"""Distance, in tolerances, by which a place seen again may be displaced from its region."""

LOG_REFERENCE_HEADING = -np.log(2 * np.pi)
"""Log density of a heading that is not explained, per rad."""


WORKSPACE = np.dtype(
    (
        np.record,
        [
            ("residual", np.float64, (MAX_STATE,)),  # (rows,) becomes L^-1 r
            ("lever", np.float64, (MAX_STATE,)),  # (rows,) d rho / d phi
            ("normal", np.float64, (MAX_STATE, 3)),  # (rows, 3) d rho / d pose
            ("by_pose", np.float64, (MAX_STATE, 3)),  # (rows, 3) H P of the pose
            ("cov", np.float64, (MAX_STATE, MAX_STATE)),  # (rows, rows) innovation covariance, becomes its factor L
            ("inverse", np.float64, (MAX_STATE,)),  # (rows,) reciprocal pivots
            ("scale", np.float64, (MAX_STATE,)),  # (rows,) reciprocal diagonal of L
            ("gain", np.float64, (MAX_STATE, MAX_STATE)),  # (rows, states) H C, becomes L^-1 H C
            ("pose_cov", np.float64, (3, 3)),  # of the pose that a region is updated from; zero where that is certain
            ("tolerance", np.float64),  # how far a bound may be off, m
            ("figures", MEASUREMENT, (2,)),
            ("regions", REGION, (2,)),
            ("iz", np.uint8, (MAX_STATE,)),  # (rows,) index in z; being unsigned, it never counts from the end
            ("im", np.uint8, (MAX_STATE,)),  # (rows,) index in m
        ],
    )
)
"""Scratch of one comparison. One record costs a call one pointer, a tuple of arrays a hundred words and their count."""


@njit
def workspaces(tolerance: float) -> Array:
    """Return fresh scratch, shape (1,) of `WORKSPACE`, for a filter of that tolerance, m."""
    work = np.zeros(1, WORKSPACE)
    work[0].tolerance = tolerance
    return work


def workspace(tolerance: float = 0.1) -> Any:
    """Return one `WORKSPACE`; the tolerance, m, is by default that of the default settings."""
    work = np.zeros(1, WORKSPACE)
    work["tolerance"] = tolerance
    return work[0]


@lean
def wrap(angle: float) -> Any:
    """Return the angle in [-pi, pi)."""
    if -np.pi <= angle < np.pi:
        return angle
    return (angle + np.pi) % (2 * np.pi) - np.pi


@lean
def is_admissible(z: Record, m: Record, offset: int) -> Any:
    """Say whether rectangle j of z can be rectangle j + offset of m (section II-C).

    No closed end of one may meet a further rectangle of the other, and the union has at most three rectangles.
    """
    nz, nm = z.n, m.n
    if max(nz + offset, nm) - min(offset, 0) > 3:
        return False
    z_left, z_right = z.closed[u_index(0)], z.closed[u_index(nz)]
    m_left, m_right = m.closed[u_index(0)], m.closed[u_index(nm)]
    if (offset > 0 and z_left) or (offset < 0 and m_left):
        return False
    return not ((nz + offset < nm and z_right) or (nz + offset > nm and m_right))


@lean
def correspond(z: Record, m: Record, offset: int, pose: Array, slack: float, work: Record, early_exit: float) -> Any:
    """Fill the rows of all edges that are closed in both; return their number and the squared violation of bounds.

    `slack` is a variance (m²) granted to every edge on top of its own. `early_exit`: give up (-1 rows) once a single
    row alone exceeds this squared Mahalanobis distance.
    """
    c, s, pu, pv = frame_of(m, pose)
    return match_edges(z, m, offset, c, s, pu, pv, pose[2], slack, work, early_exit)


@lean
def frame_of(m: Record, pose: Array) -> Any:
    """Return cos and sin of a mapped row's heading, and its anchor as seen from a pose along its axes."""
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    dx, dy = m.anchor[0] - pose[0], m.anchor[1] - pose[1]
    return c, s, c * dx + s * dy, -s * dx + c * dy


@lean
def match_edges(
    z: Record,
    m: Record,
    offset: int,
    c: float,
    s: float,
    pu: float,
    pv: float,
    theta: float,
    slack: float,
    work: Record,
    early_exit: float,
) -> Any:
    """Do what `correspond` says, for a frame of `frame_of` and a heading of the robot."""
    work.iz[0] = work.im[0] = 0
    work.residual[0] = wrap(z.state[0] + theta - m.state[0])
    work.lever[0] = 0.0
    work.normal[0, 0], work.normal[0, 1], work.normal[0, 2] = 0.0, 0.0, -1.0
    rows, violation, drift = 1, 0.0, DRIFT * work.tolerance
    first, last = max(0, offset), min(m.n, z.n + offset)
    for k in range(first, last + 1):
        i, j = u_index(k - offset), u_index(k)
        r = z.state[i] - (pu + m.state[j])
        if z.closed[i] and m.closed[j]:
            if r * r > early_exit * (z.cov[i, i] + m.cov[j, j] + pv * pv * m.cov[0, 0] + slack):
                return -1, 0.0
            work.iz[rows], work.im[rows], work.residual[rows], work.lever[rows] = i, j, r, pv
            work.normal[rows, 0], work.normal[rows, 1], work.normal[rows, 2] = -c, -s, 0.0
            rows += 1
        else:
            # Only an outermost boundary can be open; which way is out follows from the row that has it open.
            outward = _outward(z, m, k, offset)
            violation += _beyond(z, m, i, j, r, outward, slack)
    for k in range(first, last):
        for top in range(2):
            i, j = b_index(k - offset) + top, b_index(k) + top
            r = z.state[i] - (pv + m.state[j])
            if z.closed[i] and m.closed[j]:
                if r * r > early_exit * (z.cov[i, i] + m.cov[j, j] + pu * pu * m.cov[0, 0] + slack):
                    return -1, 0.0
                work.iz[rows], work.im[rows], work.residual[rows], work.lever[rows] = i, j, r, -pu
                work.normal[rows, 0], work.normal[rows, 1], work.normal[rows, 2] = s, -c, 0.0
                rows += 1
            else:
                violation += _beyond(z, m, i, j, r, 2 * top - 1, slack)
        i, j = u_index(k - offset), u_index(k)
        violation += _apart(z, m, i, u_index(k - offset + 1), j, u_index(k + 1), pu, slack, drift)
        i, j = b_index(k - offset), b_index(k)
        violation += _apart(z, m, i, i + 1, j, j + 1, pv, slack, drift)
    return rows, violation


@lean
def _apart(z: Record, m: Record, i0: int, i1: int, j0: int, j1: int, shift: float, slack: float, drift: float) -> float:
    """Return what it costs that two rectangles hardly overlap along an axis: two glimpses in one line are two regions.

    A gap costs its squared, normalised width. Without a common closed edge to place them, half of the smaller extent
    must overlap (give or take `drift`), or offices side by side, each with its far walls unseen, would grow into one.
    """
    z0, z1 = z.state[i0], z.state[i1]
    m0, m1 = m.state[j0] + shift, m.state[j1] + shift
    overlap = min(z1, m1) - max(z0, m0)
    placed = (z.closed[i0] and m.closed[j0]) or (z.closed[i1] and m.closed[j1])
    if not placed and overlap < 0.5 * min(z1 - z0, m1 - m0) - drift:
        return np.inf
    return overlap * overlap / (2 * slack) if overlap < 0.0 else 0.0


@lean
def _outward(z: Record, m: Record, k: int, offset: int) -> Any:
    """Return the outward direction (-1 or 1) of a boundary that is open in z or m."""
    open_in_z = z.closed[u_index(k - offset)] == 0
    if open_in_z:
        return -1 if k - offset == 0 else 1
    return -1 if k == 0 else 1


@lean
def _beyond(z: Record, m: Record, i: int, j: int, r: float, outward: int, slack: float) -> Any:
    """Return the squared, normalised distance by which an open edge reaches beyond the other's closed one."""
    if z.closed[i] == m.closed[j]:
        return 0.0
    excess = outward * r if z.closed[i] == 0 else -outward * r
    if excess <= 0.0:
        return 0.0
    known = m.cov[j, j] if m.closed[j] else z.cov[i, i]
    bound = z.cov[i, i] if m.closed[j] else 0.0
    return excess * excess / (known + bound + slack)


@lean
def innovate(z: Record, m: Record, rows: int, pose_cov: Array, work: Record) -> Any:
    """Turn the rows into a whitened innovation: S = L L^T, y = L^-1 r; return (y . y, log det S)."""
    innovation_covariance(z, m, rows, pose_cov, work)
    distance, determinant = whiten(rows, work)
    return distance, np.log(determinant)


@lean
def innovation_covariance(z: Record, m: Record, rows: int, pose_cov: Array, work: Record) -> None:
    """Write the lower half of S = H_x P H_x^T + H_m C H_m^T + R, and on the way H_x P.

    With the joint covariances of pose, mapped region and measurement.
    """
    iz, im, levers, normal = work.iz, work.im, work.lever, work.normal
    for i in range(rows):
        n0, n1, n2 = normal[i, 0], normal[i, 1], normal[i, 2]
        t0 = n0 * pose_cov[0, 0] + n1 * pose_cov[1, 0] + n2 * pose_cov[2, 0]
        t1 = n0 * pose_cov[0, 1] + n1 * pose_cov[1, 1] + n2 * pose_cov[2, 1]
        t2 = n0 * pose_cov[0, 2] + n1 * pose_cov[1, 2] + n2 * pose_cov[2, 2]
        work.by_pose[i, 0], work.by_pose[i, 1], work.by_pose[i, 2] = t0, t1, t2
        lever, mi, zi = levers[i], im[i], iz[i]
        with_phi = m.cov[mi, 0] + lever * m.cov[0, 0]
        for j in range(i + 1):
            mj = im[j]
            known = m.cov[mi, mj] + lever * m.cov[0, mj] + levers[j] * with_phi
            seen_from = t0 * normal[j, 0] + t1 * normal[j, 1] + t2 * normal[j, 2]
            work.cov[i, j] = z.cov[zi, iz[j]] + known + seen_from


@lean
def whiten(rows: int, work: Record) -> Any:
    """Replace S by its Cholesky factor L and the residual r by y = L^-1 r; return (y . y, det S).

    By way of S = U D U^T with ones on the diagonal of U (its transpose is left above L): one division a row and no
    root is waited for.
    """
    cov, residual, inverse, scale = work.cov, work.residual, work.inverse, work.scale
    distance, determinant = 0.0, 1.0
    for i in range(rows):
        pivot, y = cov[i, i], residual[i]
        least = 1e-12 * pivot
        for j in range(i):
            total = cov[i, j]
            for k in range(j):
                total -= cov[i, k] * cov[k, j]
            unit = total * inverse[j]
            cov[i, j], cov[j, i] = total, unit
            pivot -= total * unit
            y -= unit * residual[j]
        pivot = max(pivot, least)
        cov[i, i], inverse[i], residual[i] = pivot, 1.0 / pivot, y
        determinant *= pivot
    for i in range(rows):
        scale[i] = np.sqrt(inverse[i])
        residual[i] *= scale[i]
        distance += residual[i] * residual[i]
        for j in range(i + 1):
            cov[i, j] *= scale[j]
    return distance, determinant


@lean
def condition(mean: Array, cov: Array, size: int, rows: int, work: Record) -> None:
    """Kalman update of a Gaussian in place, `work.gain[:rows, :size]` holding H C: eqs. (3)–(6) by Cholesky factors."""
    gain = work.gain
    for i in range(rows):
        scale, y = work.scale[i], work.residual[i]
        for a in range(size):
            total = gain[i, a]
            for k in range(i):
                total -= work.cov[i, k] * gain[k, a]
            gain[i, a] = total * scale
            mean[a] += gain[i, a] * y
    for a in range(size):
        for b in range(a + 1):
            total = cov[a, b]
            for i in range(rows):
                total -= gain[i, a] * gain[i, b]
            cov[a, b] = cov[b, a] = total


@lean
def n_closed(region: Record) -> Any:
    """Return the number of rows a region's measurement could give at most: its heading and closed edges."""
    total = 0
    for i in range(state_size(region.n)):
        total += region.closed[i]
    return total


@lean
def log_likelihood(distance: float, log_det: float, rows: int, log_reference: float) -> Any:
    """Return log N(r; 0, S) over the reference density of the same rows: the heading and `rows` - 1 edges.

    So hypotheses that explain more edges or fewer compare alike, in every unit of length, and 0 is to explain nothing.
    """
    density = -0.5 * (distance + log_det + rows * np.log(2 * np.pi))
    return density - LOG_REFERENCE_HEADING - (rows - 1) * log_reference


@lean
def midpoint_distance(z: Record, m: Record, offset: int, pose: Array) -> float:
    """Return the least distance (m) of the midpoints of two rectangles that correspond: the paper's own criterion.

    Row z is taken as turned about the robot into the axes of m, eq. (21).
    """
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    dx, dy = m.anchor[0] - pose[0], m.anchor[1] - pose[1]
    pu, pv = c * dx + s * dy, -s * dx + c * dy
    least = np.inf
    for k in range(max(0, offset), min(m.n, z.n + offset)):
        u0, u1, b = u_index(k - offset), u_index(k - offset + 1), b_index(k - offset)
        du = (z.state[u0] + z.state[u1] - m.state[u_index(k)] - m.state[u_index(k + 1)]) / 2 - pu
        dv = (z.state[b] + z.state[b + 1] - m.state[b_index(k)] - m.state[b_index(k) + 1]) / 2 - pv
        least = min(least, du * du + dv * dv)
    return np.sqrt(least)
