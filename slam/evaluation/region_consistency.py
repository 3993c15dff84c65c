"""Does a filter know how wrong its regions are? The normalised error of a mapped region's edges.

Of a region in edge form the closed edges and the heading have a joint covariance. The true row, written about the same
anchor, has edges in the same places of the state vector, so their differences are the error. A true row can be written
in several ways (a rectangle from any of its sides, an L along either arm): the one nearest to what was mapped counts.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from slam.equivalents import equivalents
from slam.evaluation.consistency import nees
from slam.evaluation.matching import moved
from slam.region import EDGE_NAMES, MAX_STATE, EdgeState, b_index, u_index
from slam.rows import Floats, Row
from slam.se2 import inverse, wrap_angles


def region_nees(record: np.record, true_row: Row, truth_T_map: ArrayLike = (0.0, 0.0, 0.0)) -> tuple[float, int]:
    """Return the NEES of a mapped region's heading and closed edges, and its degrees of freedom.

    Parameters
    ----------
    record
        A region of the map, a `REGION`.
    true_row
        Its true geometry, in the frame of the truth.
    truth_T_map
        Pose (x, y, theta) of the map's frame in the frame of the truth.

    Returns
    -------
    nees, dof
        ``e' C^-1 e`` with the marginal covariance C of heading and closed edges, and the number of entries of e; its
        mean over consistent maps is `dof`. (0.0, 0) if no description of the true row can be what was mapped: then
        the error isn't one of positions, and such regions are to be counted instead.
    """
    truth = moved(true_row, inverse(truth_T_map))
    size = 2 + 3 * int(record.n)
    closed = np.flatnonzero(record.closed[:size])
    weight = np.ones(size)
    weight[0] = max(float(record.radius), 1.0)  # a wrong heading shows at the far edges
    errors = [record.state[:size] - true for true in _states(record, truth)]
    for error in errors:
        error[0] = wrap_angles(error[0])
    if not errors:
        return 0.0, 0
    error = min(errors, key=lambda e: float(np.sum((weight * e)[closed] ** 2)))
    return float(nees(error[closed], np.array(record.cov)[np.ix_(closed, closed)])), len(closed)


def _states(record: np.record, truth: Row) -> Iterator[Floats]:
    """Yield the state vectors that the record would have without error, one for each way to see the truth in it."""
    n = int(record.n)
    for row, _ in equivalents(truth, dict.fromkeys(EDGE_NAMES, EdgeState.CLOSED)):
        boundaries, bottoms, tops = _about(row, record.anchor)
        for offset in range(row.n - n + 1):
            # A closed end is an end of the true row; an open one may leave further rectangles unseen.
            left_fits = offset == 0 or not record.closed[u_index(0)]
            right_fits = offset + n == row.n or not record.closed[u_index(n)]
            if left_fits and right_fits:
                state = np.zeros(MAX_STATE)
                state[0] = row.phi
                for k in range(n + 1):
                    state[u_index(k)] = boundaries[offset + k]
                for i in range(n):
                    state[b_index(i)], state[b_index(i) + 1] = bottoms[offset + i], tops[offset + i]
                yield state[: 2 + 3 * n]


def _about(row: Row, anchor: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Return boundaries, bottoms and tops of a row as distances from an anchor along the row's own axes, m."""
    u, v = row.to_local([np.asarray(anchor, float)])[0]
    return row.u - u, row.b - v, row.t - v
