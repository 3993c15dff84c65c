"""From edge positions back to the paper's parameters (Fig. 1): means, edge states and marginal covariances.

The way there is `slam.edge_form.to_edge_form`. Means and edge states are exact both ways; Fig. 1 holds the covariances
of (x, y), (w, h), phi, (w_l, h_l), y_l, ... alone, so those of the edges come back as marginals.
"""

from __future__ import annotations

import numpy as np

from slam.jit import Array, Record, njit
from slam.region import MAX_STATE, b_index, u_index

SUBRECT = 2
"""`EdgeState.SUBRECT`, as kernels know it."""


@njit
def to_parameters(m: Record, out: Record) -> None:
    """Write a `REGION` as a `MEASUREMENT`, in the frame of its anchor."""
    main, mean = m.main, m.state
    k, k1, i = u_index(main), u_index(main + 1), b_index(main)
    along, across = (mean[k] + mean[k1]) / 2, (mean[i] + mean[i + 1]) / 2
    c, s = np.cos(mean[0]), np.sin(mean[0])
    out.n, out.main = m.n, main
    out.x, out.y = m.anchor[0] + c * along - s * across, m.anchor[1] + s * along + c * across
    out.w, out.h, out.phi = mean[k1] - mean[k], mean[i + 1] - mean[i], mean[0]
    jacobian = np.zeros((MAX_STATE, MAX_STATE))  # rows as the columns of `to_edge_form`
    jacobian[0, 0], jacobian[1, 0] = -s * along - c * across, c * along - s * across
    for side in range(2):
        jacobian[0, u_index(main + side)], jacobian[1, u_index(main + side)] = c / 2, s / 2
        jacobian[0, i + side], jacobian[1, i + side] = -s / 2, c / 2
        jacobian[2, u_index(main + side)] = jacobian[3, i + side] = 2.0 * side - 1.0
        out.edges[2 + side] = m.closed[u_index(main + side)]
        out.edges[1 - side] = m.closed[i + side]
    jacobian[4, 0] = 1.0
    row = 5
    for side in range(2):
        sub = main - 1 + 2 * side
        if 0 <= sub < m.n:
            _subrectangle(m, sub, side, row, jacobian, out)
            row += 3
    _blocks(m, jacobian, row, out)


@njit
def _subrectangle(m: Record, sub: int, side: int, row: int, jacobian: Array, out: Record) -> None:
    """Write mean, edge states and Jacobian of w, h and y of the left (0) or right (1) subrectangle."""
    k, k1, j, i = u_index(sub), u_index(sub + 1), b_index(sub), b_index(m.main)
    out.sub_w[side] = m.state[k1] - m.state[k]
    out.sub_h[side] = m.state[j + 1] - m.state[j]
    out.sub_y[side] = (m.state[j] + m.state[j + 1] - m.state[i] - m.state[i + 1]) / 2
    jacobian[row, k1], jacobian[row, k] = 1.0, -1.0
    jacobian[row + 1, j + 1], jacobian[row + 1, j] = 1.0, -1.0
    for top in range(2):
        jacobian[row + 2, j + top], jacobian[row + 2, i + top] = 0.5, -0.5
        out.edges[5 + 3 * side - top] = m.closed[j + top]
    out.edges[2 + side] = SUBRECT
    out.edges[6 + 3 * side] = m.closed[u_index(sub + side)]


@njit
def _blocks(m: Record, jacobian: Array, size: int, out: Record) -> None:
    """Write the blocks that Fig. 1 holds of J C J^T."""
    cov = np.zeros((MAX_STATE, MAX_STATE))
    product = np.zeros(MAX_STATE)
    states = 2 + 3 * m.n
    for a in range(size):
        for q in range(states):
            total = 0.0
            for r in range(states):
                if jacobian[a, r] != 0.0:
                    total += jacobian[a, r] * m.cov[r, q]
            product[q] = total
        for b in range(size):
            total = 0.0
            for q in range(states):
                total += product[q] * jacobian[b, q]
            cov[a, b] = total
    for a in range(2):
        for b in range(2):
            out.cov_xy[a, b], out.cov_wh[a, b] = cov[a, b], cov[2 + a, 2 + b]
    out.var_phi = cov[4, 4]
    row = 5
    for side in range(2):
        if 0 <= m.main - 1 + 2 * side < m.n:
            for a in range(2):
                for b in range(2):
                    out.sub_cov_wh[side, a, b] = cov[row + a, row + b]
            out.sub_var_y[side] = cov[row + 2, row + 2]
            row += 3
