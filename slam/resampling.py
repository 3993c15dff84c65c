"""Resampling schemes: from weights to ancestors."""

from __future__ import annotations

import numpy as np

from slam.jit import Array, njit


@njit
def systematic(weights: Array, uniform: float) -> Array:
    """Return ancestors, shape (P,), by systematic resampling with one number drawn from [0, 1).

    Ancestor i appears floor(P w_i) or ceil(P w_i) times. A cumulative sum that rounding leaves below 1 is scaled to it.
    """
    n = len(weights)
    cumulative = np.cumsum(weights)
    ancestors = np.empty(n, np.int64)
    ancestor = 0
    for i in range(n):
        position = (i + uniform) / n * cumulative[-1]
        while ancestor < n - 1 and cumulative[ancestor] <= position:
            ancestor += 1
        ancestors[i] = ancestor
    return ancestors
