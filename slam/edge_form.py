"""From the paper's parameters (Fig. 1) to edge positions.

With c, s = cos phi, sin phi of a measurement in the robot's frame, its edges are lines at signed distances from the
robot::

    u = x c + y s -+ w / 2        v = -x s + y c -+ h / 2

Rotating about the robot moves u by the v coordinate of the midpoint and v by minus its u coordinate: these levers make
phi and the edges correlated, and the joint covariance G Q G^T keeps it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.jit import Array, Record, lean, njit
from slam.region import MAX_STATE, REGION, b_index, u_index

FLAT_VARIANCE = 1e6
"""Variance of an edge about which nothing is known but a bound, in variances with which it is measured."""


@lean
def state_size(n: int) -> Any:
    """Return the length of the state vector of n rectangles."""
    return 2 + 3 * n


@njit
def to_edge_form(z: Record, out: Record) -> None:
    """Write a `MEASUREMENT` into a `REGION` in edge form, anchored at the robot."""
    write_edge_form(z, out, np.empty((MAX_STATE + 1, MAX_STATE)))


@lean
def write_edge_form(z: Record, out: Record, jacobian: Array) -> None:
    """Do what `to_edge_form` says.

    The columns of `jacobian` are x, y, w, h, phi, then w, h, y of each subrectangle; its last row is scratch.
    """
    c, s = np.cos(z.phi), np.sin(z.phi)
    mid_u, mid_v = z.x * c + z.y * s, -z.x * s + z.y * c
    n, main = z.n, z.main
    size = state_size(n)
    out.n, out.main, out.type, out.confidence = n, main, z.type, z.confidence
    out.anchor[0] = out.anchor[1] = 0.0
    mean, closed = out.state, out.closed
    for i in range(size):
        for k in range(size):
            jacobian[i, k] = 0.0
    mean[0], closed[0], jacobian[0, 4] = z.phi, 1, 1.0
    for side in range(2):
        k = u_index(main + side)
        sign = side - 0.5
        mean[k] = mid_u + sign * z.w
        jacobian[k, 0], jacobian[k, 1], jacobian[k, 2], jacobian[k, 4] = c, s, sign, mid_v
        closed[k] = z.edges[2 + side] != 0
        k = b_index(main) + side
        mean[k] = mid_v + sign * z.h
        jacobian[k, 0], jacobian[k, 1], jacobian[k, 3], jacobian[k, 4] = -s, c, sign, -mid_u
        closed[k] = z.edges[1 - side] != 0
    column = 5
    for side in range(2):
        sub = main - 1 if side == 0 else main + 1
        if sub < 0 or sub >= n:
            continue
        inner = u_index(main + side)
        k = u_index(sub + side)
        outward = 2.0 * side - 1.0
        mean[k] = mean[inner] + outward * z.sub_w[side]
        for i in range(5):
            jacobian[k, i] = jacobian[inner, i]
        jacobian[k, column] = outward
        closed[k] = z.edges[6 + 3 * side] != 0
        for top in range(2):
            sign = top - 0.5
            k = b_index(sub) + top
            mean[k] = mid_v + z.sub_y[side] + sign * z.sub_h[side]
            jacobian[k, 0], jacobian[k, 1], jacobian[k, 4] = -s, c, -mid_u
            jacobian[k, column + 1], jacobian[k, column + 2] = sign, 1.0
            closed[k] = z.edges[5 + 3 * side - top] != 0
        column += 3
    _covariance(z, jacobian, size, out.cov)
    out.radius = bounding_radius(out)


@lean
def _covariance(z: Record, jacobian: Array, size: int, cov: Array) -> None:
    """Write G Q G^T, with Q the block-diagonal covariance of the paper's parameters."""
    product = MAX_STATE  # row i of G Q
    for i in range(size):
        jacobian[product, 0] = jacobian[i, 0] * z.cov_xy[0, 0] + jacobian[i, 1] * z.cov_xy[1, 0]
        jacobian[product, 1] = jacobian[i, 0] * z.cov_xy[0, 1] + jacobian[i, 1] * z.cov_xy[1, 1]
        jacobian[product, 2] = jacobian[i, 2] * z.cov_wh[0, 0] + jacobian[i, 3] * z.cov_wh[1, 0]
        jacobian[product, 3] = jacobian[i, 2] * z.cov_wh[0, 1] + jacobian[i, 3] * z.cov_wh[1, 1]
        jacobian[product, 4] = jacobian[i, 4] * z.var_phi
        column = 5
        for side in range(2):
            if (side == 0 and z.main == 0) or (side == 1 and z.main + 1 >= z.n):
                continue
            w, h, y = jacobian[i, column], jacobian[i, column + 1], jacobian[i, column + 2]
            jacobian[product, column] = w * z.sub_cov_wh[side, 0, 0] + h * z.sub_cov_wh[side, 1, 0]
            jacobian[product, column + 1] = w * z.sub_cov_wh[side, 0, 1] + h * z.sub_cov_wh[side, 1, 1]
            jacobian[product, column + 2] = y * z.sub_var_y[side]
            column += 3
        for j in range(i + 1):
            total = 0.0
            for k in range(size):
                total += jacobian[product, k] * jacobian[j, k]
            cov[i, j] = cov[j, i] = total


@lean
def bounding_radius(region: Record) -> Any:
    """Return the radius (m) of a circle about the anchor that holds the whole row."""
    along = max(abs(region.state[u_index(0)]), abs(region.state[u_index(region.n)]))
    across = 0.0
    for i in range(region.n):
        k = b_index(i)
        across = max(across, abs(region.state[k]), abs(region.state[k + 1]))
    return np.sqrt(along * along + across * across)


def edge_form(record: np.record) -> np.record:
    """Return a `MEASUREMENT` in edge form, a `REGION` anchored at the robot."""
    out = np.zeros(1, REGION)
    to_edge_form(record, out[0])
    return out[0]
