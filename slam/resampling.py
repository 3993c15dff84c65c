"""Resampling schemes: from weights and pre-drawn uniform numbers to ancestors.

Douc, Cappé and Moulines 2005, "Comparison of resampling schemes for particle filtering". In each of them ancestor i is
expected P w_i times; they differ in how much the numbers scatter about that.
"""

from __future__ import annotations

import numpy as np

from slam.jit import Array, njit

SCHEMES = ("systematic", "stratified", "residual")


@njit
def ancestors_of(weights: Array, scheme: int, uniforms: Array) -> Array:
    """Return ancestors, shape (P,), ascending: weights (P,), a scheme of `SCHEMES`, numbers (P,) in [0, 1)."""
    if scheme == 0:
        return systematic(weights, uniforms[0])
    if scheme == 1:
        return stratified(weights, uniforms)
    return residual(weights, uniforms)


@njit
def systematic(weights: Array, uniform: float) -> Array:
    """Return ancestors by one number for all equal strata: ancestor i appears floor(P w_i) or ceil(P w_i) times."""
    n = len(weights)
    return at_positions(weights, (np.arange(n) + uniform) / n)


@njit
def stratified(weights: Array, uniforms: Array) -> Array:
    """Return ancestors by one number for each of P equal strata."""
    n = len(weights)
    return at_positions(weights, (np.arange(n) + uniforms) / n)


@njit
def residual(weights: Array, uniforms: Array) -> Array:
    """Return floor(P w_i) copies of each ancestor, and the rest drawn from what is left of the weights."""
    n = len(weights)
    shares = weights * (n / np.sum(weights))
    ancestors = np.empty(n, np.int64)
    filled = 0
    for i in range(n):
        # Rounding must not cost a copy that is due.
        copies = min(int(np.floor(shares[i] + 1e-9)), n - filled)
        ancestors[filled : filled + copies] = i
        filled += copies
        shares[i] = max(shares[i] - copies, 0.0)
    if filled < n:
        ancestors[filled:] = at_positions(shares, np.sort(uniforms[filled:]))
    return np.sort(ancestors)


@njit
def at_positions(weights: Array, positions: Array) -> Array:
    """Return for each position in [0, 1), ascending, the entry of the normalised cumulative weights it falls into.

    A cumulative sum that rounding leaves below 1 is scaled to it.
    """
    cumulative = np.cumsum(weights)
    found = np.empty(len(positions), np.int64)
    i = 0
    for k in range(len(positions)):
        while i < len(weights) - 1 and cumulative[i] <= positions[k] * cumulative[-1]:
            i += 1
        found[k] = i
    return found
