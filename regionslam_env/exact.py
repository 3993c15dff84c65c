"""Functions of Python's `math` that Numba lacks, or leaves to a C library that rounds otherwise; bit by bit."""

from __future__ import annotations

import math

import numpy as np

from slam.jit import njit

_TURN = 2 * math.pi
_SPLITTER = 2.0**27 + 1.0


@njit
def principal(angle: float) -> float:
    """Return the angle in [-pi, pi]: ``math.remainder(angle, 2 * math.pi)``, rad."""
    size = abs(angle)
    rest = np.fmod(size, _TURN)
    missing = _TURN - rest
    if rest > missing:
        rest = -missing
    elif rest == missing:
        rest -= 2.0 * np.fmod(0.5 * (size - rest), _TURN)
    return math.copysign(1.0, angle) * rest


@njit
def hypot(x: float, y: float) -> float:
    """Return ``math.hypot(x, y)`` of two finite numbers: a root of squares without loss, corrected once."""
    largest = max(abs(x), abs(y))
    if largest == 0.0:
        return 0.0
    scale = math.ldexp(1.0, -math.frexp(largest)[1])
    total, low, high = _add_square(1.0, 0.0, 0.0, 1.0, abs(x) * scale)
    total, low, high = _add_square(total, low, high, 1.0, abs(y) * scale)
    root = math.sqrt(total - 1.0 + (low + high))
    total, low, high = _add_square(total, low, high, -1.0, root)
    root += (total - 1.0 + (low + high)) / (2.0 * root)
    return root / scale


@njit
def _add_square(total: float, low: float, high: float, sign: float, x: float) -> tuple[float, float, float]:
    """Add or take away a square; `low` and `high` gather what products and sums lose (Dekker 1971)."""
    t = x * _SPLITTER
    head = t - (t - x)
    tail = x - head
    square, cross = head * head, head * tail * 2.0
    product = square + cross
    lost = square - product + cross + tail * tail
    product, lost = sign * product, sign * lost
    new = total + product
    return new, low + lost, high + (product - (new - total))
