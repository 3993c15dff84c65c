"""Resampling schemes: from weights to ancestors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def systematic(weights: NDArray[np.float64], uniform: float) -> NDArray[np.int64]:
    """Return ancestors, shape (P,), by systematic resampling with one number drawn from [0, 1).

    Ancestor i appears floor(P w_i) or ceil(P w_i) times. A cumulative sum that rounding leaves below 1 is scaled to it.
    """
    cumulative = np.cumsum(weights)
    positions = (np.arange(len(weights)) + uniform) / len(weights) * cumulative[-1]
    return np.minimum(np.searchsorted(cumulative, positions, side="right"), len(weights) - 1)
