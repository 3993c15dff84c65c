"""Importance weights on log scale."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.jit import Array, lean, njit


@lean
def normalise(particles: Array) -> Any:
    """Normalise the log weights in place and return the effective sample size 1 / sum(w²)."""
    largest = -np.inf
    for p in particles:
        largest = max(largest, p.log_weight)
    total = 0.0
    for p in particles:
        total += np.exp(p.log_weight - largest)
    shift = largest + np.log(total)
    squares = 0.0
    for i in range(len(particles)):
        particles[i].log_weight -= shift
        squares += np.exp(2 * particles[i].log_weight)
    return 1.0 / squares


@njit
def weights(log_weights: Array) -> Array:
    """Return normalised weights, shape (P,), from log weights."""
    w = np.exp(log_weights - np.max(log_weights))
    return w / np.sum(w)
