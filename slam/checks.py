"""What no sensor can mean: lengths that are no numbers, sizes of nothing, covariances that are none, loose links."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.region import EDGE_NAMES, EdgeState

LARGEST = 1e6
"""Largest length, m: squares and products of what is smaller stay numbers."""

VARIANCES = (1e-18, LARGEST**2)
"""Least and largest variance, m² or rad²."""

Mask = NDArray[np.bool_]


class _Demands:
    """Raises at the first measurement that does not meet a demand."""

    def __init__(self, records: NDArray[np.void], types: Sequence[str]) -> None:
        self._records, self._types = records, types

    def hold(self, met: Mask, name: str, values: NDArray[Any], expected: str) -> None:
        """Check one demand on all measurements, shape (M,)."""
        if not met.all():
            i = int(np.argmin(met))
            value = values[i].tolist() if isinstance(values[i], np.ndarray | np.generic) else values[i]
            self.refuse(i, name, value, expected)

    def refuse(self, i: int, name: str, value: object, expected: str) -> None:
        """Name measurement, field, value and what was expected."""
        number = int(self._records["type"][i])
        kind = repr(self._types[number]) if 0 <= number < len(self._types) else f"type number {number}"
        raise ValueError(f"measurement {i} ({kind}): {name} is {value!r}, expected {expected}")


def check_records(records: NDArray[np.void], links: NDArray[np.void], types: Sequence[str]) -> None:
    """Raise a ValueError for the first `MEASUREMENT` or `LINK` that no sensor can mean.

    Parameters
    ----------
    records, links
        Of one scan, (M,) of `MEASUREMENT` and (L,) of `LINK`.
    types
        What `records["type"]` indexes.
    """
    demands = _Demands(records, types)
    number, n, main = records["type"], records["n"], records["main"]
    demands.hold((number >= 0) & (number < len(types)), "type", number, f"the number of one of {len(types)} types")
    demands.hold((n >= 1) & (n <= 3), "n", n, "1 to 3 rectangles")
    demands.hold((main >= 0) & (main < n) & ((n < 3) | (main == 1)), "main", main, "the middle one of three rectangles")
    everyone = np.ones(len(records), bool)
    for name in ("x", "y", "w", "h", "phi", "confidence"):
        demands.hold(np.isfinite(records[name]), name, records[name], "a finite number")
    _check_lengths(demands, everyone, {name: records[name] for name in ("w", "h")}, {n: records[n] for n in ("x", "y")})
    confidence = records["confidence"]
    demands.hold((confidence >= 0) & (confidence <= 1), "confidence", confidence, "a probability in [0, 1]")
    _check_covariances(
        demands,
        everyone,
        {"cov_xy": records["cov_xy"], "cov_wh": records["cov_wh"]},
        {"var_phi": records["var_phi"]},
    )
    subs = (main > 0, main + 1 < n)
    for side, (label, exists) in enumerate(zip(("left", "right"), subs, strict=True)):
        sizes = {f"{label}.{name}": records[f"sub_{name}"][:, side] for name in ("w", "h")}
        _check_lengths(demands, exists, sizes, {f"{label}.y": records["sub_y"][:, side]})
        _check_covariances(
            demands,
            exists,
            {f"{label}.cov_wh": records["sub_cov_wh"][:, side]},
            {f"{label}.var_y": records["sub_var_y"][:, side]},
        )
    _check_edges(demands, records["edges"], subs)
    _check_links(demands, links, len(records))


def _check_lengths(
    demands: _Demands, exists: Mask, sizes: dict[str, NDArray[Any]], positions: dict[str, NDArray[Any]]
) -> None:
    for name, values in sizes.items():
        demands.hold(~exists | (values > 0), name, values, "a size above 0")
    for name, values in positions.items():
        demands.hold(~exists | np.isfinite(values), name, values, "a finite number")
    for name, values in (sizes | positions).items():
        demands.hold(~exists | (np.abs(values) <= LARGEST), name, values, f"a length of at most {LARGEST:g} m")


def _check_covariances(
    demands: _Demands, exists: Mask, matrices: dict[str, NDArray[Any]], variances: dict[str, NDArray[Any]]
) -> None:
    least, largest = VARIANCES
    for name, cov in matrices.items():
        finite = np.isfinite(cov).all(axis=(1, 2))
        a, b, c, d = (np.where(finite, cov[:, i, j], 0.0) for i in range(2) for j in range(2))
        scale = np.sqrt(np.abs(a * d))
        definite = finite & (a > 0) & (d > 0) & (np.abs(b - c) <= 1e-8 * scale) & (a * d - b * c > 0)
        demands.hold(~exists | definite, name, cov, "a symmetric positive definite 2 x 2 matrix")
        within = (np.minimum(a, d) >= least) & (np.maximum(a, d) <= largest)
        demands.hold(~exists | within, name, cov, f"variances from {least:g} to {largest:g} m²")
    for name, variance in variances.items():
        demands.hold(~exists | (np.isfinite(variance) & (variance > 0)), name, variance, "a variance above 0")
        within = (variance >= least) & (variance <= largest)
        demands.hold(~exists | within, name, variance, f"a variance from {least:g} to {largest:g}")


def _check_edges(demands: _Demands, edges: NDArray[Any], subs: tuple[Mask, Mask]) -> None:
    joint, all_exist = EdgeState.SUBRECT, np.ones(len(edges), bool)
    exists = [all_exist] * 4 + [subs[0]] * 3 + [subs[1]] * 3
    for k, name in enumerate(EDGE_NAMES):
        states = edges[:, k]
        shown = np.array([EdgeState(s).name if s in (0, 1, 2) else str(s) for s in states.tolist()], object)
        if name in ("l", "r"):
            has_sub = subs[k - 2]
            right = np.where(has_sub, states == joint, (states == 0) | (states == 1))
            demands.hold(right, name, shown, "SUBRECT where a subrectangle is, else OPEN or CLOSED")
        else:
            right = ~exists[k] | (states == 0) | (states == 1)
            demands.hold(right, name, shown, "OPEN or CLOSED: subrectangles lie left and right")


def _check_links(demands: _Demands, links: NDArray[np.void], count: int) -> None:
    for source, target, confidence in links.tolist():
        if not 0 <= source < count:
            raise ValueError(f"a link's source is {source!r}, expected the index of one of {count} measurements")
        if not 0 <= target < count or target == source:
            demands.refuse(source, "links", target, f"the index of another of the scan's {count} measurements")
        if not 0 <= confidence <= 1:
            demands.refuse(source, f"links[{target}]", confidence, "a probability in [0, 1]")
