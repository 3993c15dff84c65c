"""Poses from single matches of a scan with a map, those first that several measurements support.

A measured row and a mapped one of the same type that have closed edges in common along both axes give a pose. Right
matches agree on it and wrong ones scatter, so poses are ranked by how many measurements vote for them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.config import Parameters
from slam.innovation import is_admissible, wrap
from slam.jit import Array, Record, njit
from slam.region import b_index, u_index

AGREEMENT = 9.0
"""Squared, normalised distance by which the edges of a match may contradict each other."""

NEAR, NEAR_HEADING = 6.0, 0.15
"""Poses no farther apart than this (tolerances, rad) are one."""

MOST_POSES = 2048
"""Poses looked at in one scan; further ones are left out."""


@njit
def support(measured: Array, regions: Array, poses: Array, n_wanted: int, parameters: tuple[Any, ...]) -> Any:
    """Return the poses (n_wanted, 3) that most measurements of a scan vote for, best first, and their number.

    Parameters
    ----------
    measured
        The scan in edge form with its equivalent descriptions, (M, 4) of `REGION`.
    regions
        The map, (R,) of `REGION`.
    poses
        Scratch, (MOST_POSES, 3).
    """
    p = Parameters(*parameters)
    sources, near = np.zeros(len(poses), np.int64), NEAR * p.tolerance
    count = matched_poses(measured, regions, p.tolerance, poses, sources)
    votes = count_votes(poses[:count], sources, len(measured), near)
    best, n = np.empty((n_wanted, 3)), 0
    while n < n_wanted:
        leader = -1
        for k in range(count):
            if votes[k] > 0 and (leader < 0 or votes[k] > votes[leader]):
                leader = k
        if leader < 0:
            break
        best[n] = poses[leader]
        for k in range(count):
            if are_near(poses[k], best[n], near):
                votes[k] = 0
        n += 1
    return best, n


@njit
def matched_poses(measured: Array, regions: Array, tolerance: float, poses: Array, sources: Array) -> Any:
    """Write the poses of all matches of a scan with a map, and of which measurement each is; return their number."""
    count = 0
    for j in range(len(measured)):
        for k in range(len(regions)):
            m = regions[k]
            if measured[j, 0].type != m.type or measured[j, 0].level != m.level:
                continue
            for quarters in range(4):
                z = measured[j, quarters]
                for offset in range(1 - z.n, m.n if z.n > 0 else 0):
                    if count == len(poses):
                        return count
                    if is_admissible(z, m, offset) and pose_of_match(z, m, offset, tolerance, poses[count]):
                        sources[count] = j
                        count += 1
    return count


@njit
def pose_of_match(z: Record, m: Record, offset: int, tolerance: float, pose: Array) -> bool:
    """Write the pose (3,) from which m looks like z, rectangle j of z being j + offset of m; say whether there is one.

    A common closed edge gives n . p = n . a + e - rho (see `slam.innovation`), several their weighted mean.
    """
    along, fits_along = _position(z, m, offset, 0, tolerance)
    across, fits_across = _position(z, m, offset, 1, tolerance)
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    pose[0] = m.anchor[0] + c * along - s * across
    pose[1] = m.anchor[1] + s * along + c * across
    pose[2] = wrap(m.state[0] - z.state[0])
    return fits_along and fits_across


@njit
def _position(z: Record, m: Record, offset: int, axis: int, tolerance: float) -> Any:
    """Return the position along an axis of m, relative to its anchor, and whether edges tell it with one voice."""
    weight, total, squares = 0.0, 0.0, 0.0
    for k in range(max(0, offset), min(m.n, z.n + offset) + 1 - axis):
        for top in range(1 + axis):
            i, j = u_index(k - offset), u_index(k)
            if axis == 1:
                i, j = b_index(k - offset) + top, b_index(k) + top
            if z.closed[i] and m.closed[j]:
                precision = 1.0 / (z.cov[i, i] + m.cov[j, j] + tolerance**2)
                difference = m.state[j] - z.state[i]
                weight += precision
                total += precision * difference
                squares += precision * difference * difference
    if weight == 0.0:
        return 0.0, False
    return total / weight, squares - total * total / weight < AGREEMENT


@njit
def count_votes(poses: Array, sources: Array, n_measurements: int, near: float) -> Any:
    """Return for each pose how many measurements have a match near it, (H,)."""
    votes = np.zeros(len(poses), np.int64)
    voted = np.full(n_measurements, -1, np.int64)
    for a in range(len(poses)):
        for b in range(len(poses)):
            if voted[sources[b]] != a and are_near(poses[a], poses[b], near):
                voted[sources[b]] = a
                votes[a] += 1
    return votes


@njit
def are_near(a: Array, b: Array, near: float) -> bool:
    """Say whether two poses, less than `near` (m) apart, are one as far as matches can tell."""
    dx, dy = a[0] - b[0], a[1] - b[1]
    return dx * dx + dy * dy < near * near and abs(wrap(a[2] - b[2])) < NEAR_HEADING
