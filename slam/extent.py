"""Where a region in edge form lies: containment, area, centre."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from slam.jit import Array, Record, lean, njit
from slam.overlap import rows_overlap
from slam.region import b_index, u_index
from slam.rows import MAX_RECTANGLES


@lean
def to_row(region: Record, x: float, y: float) -> Any:
    """Return a point of the map frame in the row's frame."""
    c, s = np.cos(region.state[0]), np.sin(region.state[0])
    dx, dy = x - region.anchor[0], y - region.anchor[1]
    return c * dx + s * dy, -s * dx + c * dy


@lean
def contains(region: Record, x: float, y: float, margin: float) -> bool:
    """Say whether a point of the map frame lies in the row grown by `margin` m."""
    u, v = to_row(region, x, y)
    for i in range(region.n):
        k = b_index(i)
        if (
            region.state[u_index(i)] - margin <= u <= region.state[u_index(i + 1)] + margin
            and region.state[k] - margin <= v <= region.state[k + 1] + margin
        ):
            return True
    return False


@lean
def area(region: Record) -> Any:
    """Return the area, m²."""
    total = 0.0
    for i in range(region.n):
        k = b_index(i)
        total += (region.state[u_index(i + 1)] - region.state[u_index(i)]) * (region.state[k + 1] - region.state[k])
    return total


@njit
def overlap(a: Record, b: Record) -> float:
    """Return the area that two regions have in common, m²."""
    ua, ba, ta = edges_of(a)
    ub, bb, tb = edges_of(b)
    return rows_overlap(
        a.anchor[0], a.anchor[1], a.state[0], ua, ba, ta, a.n, b.anchor[0], b.anchor[1], b.state[0], ub, bb, tb, b.n
    )


@njit
def edges_of(region: Record) -> Any:
    """Return the boundaries (4,), bottoms (3,) and tops (3,) of a row."""
    u, b, t = np.zeros(MAX_RECTANGLES + 1), np.zeros(MAX_RECTANGLES), np.zeros(MAX_RECTANGLES)
    for k in range(region.n + 1):
        u[k] = region.state[u_index(k)]
    for i in range(region.n):
        b[i], t[i] = region.state[b_index(i)], region.state[b_index(i) + 1]
    return u, b, t


@lean
def point_in_rectangle(region: Record, i: int, along: float, across: float) -> Any:
    """Return the point of the map frame at shares (along, across) in [0, 1] of rectangle i."""
    k = b_index(i)
    u = region.state[u_index(i)] * (1 - along) + region.state[u_index(i + 1)] * along
    v = region.state[k] * (1 - across) + region.state[k + 1] * across
    c, s = np.cos(region.state[0]), np.sin(region.state[0])
    return region.anchor[0] + c * u - s * v, region.anchor[1] + s * u + c * v


@lean
def probability_inside(region: Record, pose: Array, cov: Array) -> Any:
    """Return P(robot in region) for a Gaussian pose with mean (3,) and covariance (3, 3), edges taken at their means.

    Along each axis of the row the position is normal; the axes are taken as independent.
    """
    u, v = to_row(region, pose[0], pose[1])
    c, s = np.cos(region.state[0]), np.sin(region.state[0])
    var_u = c * c * cov[0, 0] + 2 * c * s * cov[0, 1] + s * s * cov[1, 1]
    var_v = s * s * cov[0, 0] - 2 * c * s * cov[0, 1] + c * c * cov[1, 1]
    least = 1e-12 * region.radius**2
    scale_u, scale_v = math.sqrt(2 * var_u + least), math.sqrt(2 * var_v + least)
    total = 0.0
    for i in range(region.n):
        k = b_index(i)
        along = math.erf((region.state[u_index(i + 1)] - u) / scale_u) - math.erf(
            (region.state[u_index(i)] - u) / scale_u
        )
        across = math.erf((region.state[k + 1] - v) / scale_v) - math.erf((region.state[k] - v) / scale_v)
        total += along * across / 4
    return min(total, 1.0)
