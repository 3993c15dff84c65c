"""The innovation as the paper averages it (Oberländer et al. 2008, eqs. 19–23).

The rows of `slam.innovation` are its d_x and d_y, one for every edge that is closed in both regions. Averaged with
equal weights and turned into the robot's frame they are (23). Along an axis without a common closed edge there is no
difference: that component is left out, and what remains stays in the axes of z.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.innovation import innovate, innovation_covariance, whiten
from slam.jit import Array, Record, lean, njit
from slam.region import is_u


@lean
def innovate_as_set(z: Record, m: Record, rows: int, pose_cov: Array, work: Record, p: Record) -> Any:
    """Whiten the innovation of the chosen model; return its number of rows, y . y and log det S."""
    if p.paper_update:
        innovation_covariance(z, m, rows, pose_cov, work)
        rows = average(z, rows, work)
        distance, determinant = whiten(rows, work)
        log_det = np.log(determinant)
    else:
        distance, log_det = innovate(z, m, rows, pose_cov, work)
    return rows, distance, log_det


@njit
def average(z: Record, rows: int, work: Record) -> Any:
    """Replace the rows by (23) with its Jacobian and covariance; return their number.

    With A the averaging of the rows to (d_x, d_y, delta phi) and R the rotation by phi_z, the innovation is R A r. R
    itself depends on the measured heading: its derivative e = R' A r adds e q^T + q e^T + e e^T C_phi to R A S A^T R^T,
    q the covariance of the averaged rows with the measured phi.
    """
    weights = np.zeros((3, rows))
    n = 0
    for along in (True, False):
        count = 0
        for r in range(1, rows):
            if is_u(work.iz[r]) == along:
                weights[n, r] = 1.0
                count += 1
        if count > 0:
            weights[n] /= count
            n += 1
    bend = np.zeros(3)
    if n == 2:
        c, s = np.cos(z.state[0]), np.sin(z.state[0])
        for r in range(1, rows):
            dx, dy = weights[0, r], weights[1, r]
            weights[0, r], weights[1, r] = c * dx - s * dy, s * dx + c * dy
            bend[0] -= (s * dx + c * dy) * work.residual[r]
            bend[1] += (c * dx - s * dy) * work.residual[r]
    weights[n, 0] = 1.0
    n += 1
    _apply(z, weights, bend, n, rows, work)
    return n


@njit
def _apply(z: Record, weights: Array, bend: Array, n: int, rows: int, work: Record) -> None:
    """Replace residuals, Jacobian, its product with P, and covariance by those of `n` weighted sums of them."""
    cov, residual, with_phi = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    normal, by_pose = np.zeros((n, 3)), np.zeros((n, 3))
    for a in range(n):
        for r in range(rows):
            w = weights[a, r]
            residual[a] += w * work.residual[r]
            with_phi[a] += w * z.cov[0, work.iz[r]]
            for b in range(3):
                normal[a, b] += w * work.normal[r, b]
                by_pose[a, b] += w * work.by_pose[r, b]
            for b in range(a + 1):
                for q in range(rows):
                    cov[a, b] += w * weights[b, q] * work.cov[max(r, q), min(r, q)]
    for a in range(n):
        for b in range(a + 1):
            work.cov[a, b] = cov[a, b] + bend[a] * with_phi[b] + with_phi[a] * bend[b] + bend[a] * bend[b] * z.cov[0, 0]
        work.residual[a] = residual[a]
        for b in range(3):
            work.normal[a, b], work.by_pose[a, b] = normal[a, b], by_pose[a, b]
