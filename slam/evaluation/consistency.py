"""Does a filter know how wrong it is? Normalised errors (NEES, NIS) and their chi-square bands.

After Bar-Shalom, Li and Kirubarajan 2001, section 5.4: if errors have the covariance that the filter states, their
squared Mahalanobis norm is chi-square distributed with as many degrees of freedom as the error has entries.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from slam.rows import Floats
from slam.se2 import wrap_angles


class Consistency(NamedTuple):
    """A pooled normalised error: 1 is ideal, above `high` the filter is overconfident, below `low` it is too modest."""

    ratio: float
    low: float
    high: float
    freedom: int


def pooled(values: ArrayLike, freedoms: ArrayLike, confidence: float = 0.95) -> Consistency:
    """Pool NEES or NIS values of different dimensions: their sum over the sum of their degrees of freedom.

    Parameters
    ----------
    values
        Independent NEES or NIS values, shape (k,). Values of one run that share errors widen the true band.
    freedoms
        Degrees of freedom of each, shape (k,); a value without any must be 0.
    confidence
        Probability of the band, both tails equal.
    """
    values, freedoms = np.asarray(values, dtype=np.float64), np.asarray(freedoms)
    freedom = int(np.sum(freedoms))
    if values.shape != freedoms.shape or freedom < 1:
        raise ValueError(
            f"values of shape {values.shape} with freedoms of shape {freedoms.shape} and sum {freedom}: "
            "expected one shape, and at least one degree of freedom"
        )
    tail = (1 - confidence) / 2
    low, high = (chi_square_quantile(p, freedom) / freedom for p in (tail, 1 - tail))
    return Consistency(float(np.sum(values)) / freedom, low, high, freedom)


def nees(errors: ArrayLike, covariances: ArrayLike) -> Floats:
    """Return the normalised estimation error squared ``e' C^-1 e``, shape (...).

    Parameters
    ----------
    errors
        Estimate minus truth, shape (..., n); angles wrapped.
    covariances
        What the filter states, shape (..., n, n). Where a covariance isn't positive definite, the result is 0 for an
        error of 0, and infinite for any other: the filter was certain and wrong.
    """
    errors, covariances = np.asarray(errors, dtype=np.float64), np.asarray(covariances, dtype=np.float64)
    n = errors.shape[-1]
    if covariances.shape != (*errors.shape, n):
        raise ValueError(
            f"errors of shape {errors.shape} need covariances of shape {(*errors.shape, n)}, got {covariances.shape}"
        )
    flat_errors, flat_covariances = errors.reshape(-1, n), covariances.reshape(-1, n, n)
    result = np.where(np.any(flat_errors != 0, axis=-1), np.inf, 0.0)
    for i, (error, covariance) in enumerate(zip(flat_errors, flat_covariances, strict=True)):
        try:
            whitened = np.linalg.solve(np.linalg.cholesky(covariance), error)
        except np.linalg.LinAlgError:
            continue
        result[i] = whitened @ whitened
    return np.asarray(result.reshape(errors.shape[:-1]))


def nis(innovations: ArrayLike, covariances: ArrayLike) -> Floats:
    """Return the normalised innovation squared ``y' S^-1 y``, shape (...), of innovations (..., n), S (..., n, n).

    It needs no truth: of a consistent filter it is chi-square too.
    """
    return nees(innovations, covariances)


def pose_nees(estimated: ArrayLike, covariances: ArrayLike, true: ArrayLike) -> Floats:
    """Return the NEES of poses (x, y, theta), shape (..., 3), with covariances (..., 3, 3); 3 in the mean is ideal."""
    errors = np.asarray(estimated, dtype=np.float64) - np.asarray(true, dtype=np.float64)
    errors[..., 2] = wrap_angles(errors[..., 2])
    return nees(errors, covariances)


def nees_band(count: int, dimension: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the band in which the mean of `count` independent NEES values of a consistent filter lies.

    Parameters
    ----------
    count
        Number of values averaged.
    dimension
        Entries of each error.
    confidence
        Probability of the band, both tails equal.
    """
    if count < 1 or dimension < 1:
        raise ValueError(f"count and dimension are {count!r} and {dimension!r}, expected at least 1")
    tail = (1 - confidence) / 2
    freedom = count * dimension
    return chi_square_quantile(tail, freedom) / count, chi_square_quantile(1 - tail, freedom) / count


def chi_square_cdf(x: float, freedom: float) -> float:
    """Return P(X <= x) of a chi-square variable with `freedom` degrees of freedom."""
    return _lower_gamma(freedom / 2, x / 2) if x > 0 else 0.0


def chi_square_quantile(probability: float, freedom: float) -> float:
    """Return x with P(X <= x) = `probability` for a chi-square variable with `freedom` degrees of freedom.

    Wilson and Hilferty 1931 give the start, safeguarded Newton steps on the incomplete gamma function the digits.
    """
    if not (0 < probability < 1 and freedom > 0):
        raise ValueError(
            f"probability and freedom are {probability!r} and {freedom!r}, expected a number in (0, 1) and one above 0"
        )
    spread = 2 / (9 * freedom)
    x = max(freedom * (1 - spread + _normal_quantile(probability) * math.sqrt(spread)) ** 3, 1e-300)
    low, high = 0.0, math.inf
    half = freedom / 2
    for _ in range(200):
        error = chi_square_cdf(x, freedom) - probability
        if error > 0:
            high = x
        else:
            low = x
        log_density = (half - 1) * math.log(x / 2) - x / 2 - math.lgamma(half) - math.log(2)
        step = error * math.exp(-log_density) if log_density > -700 else math.inf
        following = x - step
        if not low < following < high:
            following = (low + high) / 2 if math.isfinite(high) else 2 * x
        if abs(following - x) <= 1e-13 * x:
            return following
        x = following
    return x


def _lower_gamma(a: float, x: float) -> float:
    """Return the regularised lower incomplete gamma function P(a, x): series below a + 1, continued fraction above."""
    log_scale = a * math.log(x) - x - math.lgamma(a)
    limit = 1000 + int(20 * math.sqrt(a))
    if x < a + 1:
        term = total = 1 / a
        for k in range(1, limit):
            term *= x / (a + k)
            total += term
            if term < 1e-17 * total:
                break
        return min(1.0, total * math.exp(log_scale))
    # Lentz's method on the fraction for the upper function.
    b = x + 1 - a
    d = 1 / b
    c, fraction = math.inf, d
    for k in range(1, limit):
        numerator = -k * (k - a)
        b += 2
        d = 1 / (numerator * d + b)
        c = b + numerator / c
        fraction *= c * d
        if abs(c * d - 1) < 1e-16:
            break
    return max(0.0, 1 - fraction * math.exp(log_scale))


def _normal_quantile(probability: float) -> float:
    """Return the standard normal quantile, to four digits or better (Abramowitz and Stegun 26.2.23)."""
    tail = min(probability, 1 - probability)
    t = math.sqrt(-2 * math.log(tail))
    value = t - (2.515517 + 0.802853 * t + 0.010328 * t * t) / (1 + 1.432788 * t + 0.189269 * t * t + 0.001308 * t**3)
    return value if probability > 0.5 else -value
