"""Where on its map is a robot that was carried? Poses from single matches, those first that several matches support.

A measured row and a mapped one of the same type that have closed edges in common along both axes give a pose. Right
matches agree on it and wrong ones scatter, so poses are ranked by how many measurements vote for them. The best become
hypotheses, which move with the robot and are conditioned on every further scan, until one explains the scans far better
than any other. All of them share one map, and nothing is written to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.association import ASSOCIATION, CANDIDATES_PER_MEASUREMENT, associate
from slam.comparison import CANDIDATE
from slam.config import Parameters
from slam.innovation import is_admissible, wrap
from slam.jit import Array, Record, njit
from slam.lost import MISSING, count_found, count_missing
from slam.maps import Maps
from slam.motion import MotionNoise, Odometry
from slam.near import find_near
from slam.particles import PARTICLE
from slam.proposal import predict, propose
from slam.region import b_index, u_index

AGREEMENT = 9.0
"""Squared, normalised distance by which the edges of a match may contradict each other."""

NEAR, NEAR_HEADING = 6.0, 0.15
"""Poses no farther apart than this (tolerances, rad) are one."""

MOST_POSES = 2048
"""Poses looked at in one scan; further ones are left out."""

SPREAD, SPREAD_HEADING = 2.0, 0.05
"""Standard deviations (tolerances, rad) of a new hypothesis."""

MEMORY = 0.9
"""What a scan's weight is multiplied by with every further scan."""

HYPOTHESES, ADDED = 48, 8
"""Hypotheses at first and at most, and candidates that every further scan may add."""

LEAST_EXPLAINED = 0.6
"""Share of the measurements that the right hypothesis explains; averaged, so that it takes some scans."""

LEAST_LEAD = 20.0
"""Log-likelihood ratio to the next hypothesis from which the best one is right."""


class Search:
    """Hypotheses about the pose of a robot that knows its map, but not where on it it is.

    Parameters
    ----------
    known
        Particles whose poses are hypotheses, too: an alarm may be false.
    row
        The map: record of each slot's region, as in `Maps.table`, shape (S,).
    parameters
        Of the filter.

    Attributes
    ----------
    hypotheses
        (H,) of `PARTICLE`; their `log_weight` is a score that fades with time.
    """

    def __init__(self, known: NDArray[np.void], row: NDArray[np.int32], parameters: Parameters) -> None:
        self.row, self._parameters = row.copy(), tuple(parameters)
        self._near, spread = NEAR * parameters.tolerance, SPREAD * parameters.tolerance
        self._spread = np.diag([spread**2, spread**2, SPREAD_HEADING**2])
        self.hypotheses = known.copy()
        self.hypotheses["log_weight"] = 0.0
        self.hypotheses["cov"] += self._spread
        self._explained = np.zeros(len(known))
        self._begun = False

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what a search holds, by name."""
        return {
            "search_hypotheses": self.hypotheses,
            "search_row": self.row,
            "search_explained": self._explained,
            "search_begun": np.array(self._begun),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], parameters: Parameters) -> Search:
        """Return the search of which `to_arrays` gave the arrays."""
        hypotheses = arrays["search_hypotheses"].view(PARTICLE)
        search = cls(hypotheses, arrays["search_row"], parameters)
        search.hypotheses, search._explained = hypotheses.copy(), arrays["search_explained"].copy()
        search._begun = bool(arrays["search_begun"])
        return search

    def maps(self, maps: Maps) -> Maps:
        """Return the maps of all hypotheses: one and the same."""
        return maps._replace(table=np.repeat(self.row[None], len(self.hypotheses), axis=0))

    def predict(self, odometry: Odometry, noise: MotionNoise) -> None:
        """Move all hypotheses by odometry."""
        motion = (odometry.distance, odometry.lateral, odometry.rotation)
        predict(self.hypotheses, *motion, noise.distance, noise.heading_per_metre, noise.heading_per_radian)

    def update(self, maps: Maps, measured: NDArray[np.void], view: NDArray[np.float64]) -> None:
        """Add hypotheses from a scan and weigh all of them."""
        if len(measured) == 0:
            return
        regions = maps.pool[self.row[self.row >= 0]]
        wanted = ADDED if self._begun else HYPOTHESES
        poses, count = support(measured, regions, np.empty((MOST_POSES, 3)), wanted, self._parameters)
        self._begun = True
        self._add(poses[:count])
        weigh(self.hypotheses, tuple(self.maps(maps)), measured, view, self._parameters, self._explained)

    def _add(self, poses: NDArray[np.float64]) -> None:
        """Add poses that no hypothesis is near, in place of the worst where there are enough."""
        new = np.zeros(len(poses), PARTICLE)
        new["pose"] = new["expected"] = poses
        new["cov"] = new["spread"] = self._spread
        new = new[[not any(are_near(pose, h, self._near) for h in self.hypotheses["pose"]) for pose in poses]]
        kept = np.argsort(-self.hypotheses["log_weight"], kind="stable")[: HYPOTHESES - len(new)]
        self.hypotheses = np.concatenate([self.hypotheses[kept], new])
        self._explained = np.concatenate([self._explained[kept], np.zeros(len(new))])

    @property
    def found(self) -> np.record | None:
        """The hypothesis that explains the scans, and far better than any other; None as long as there is none."""
        score = self.hypotheses["log_weight"]
        best = int(np.argmax(score))
        leader = self.hypotheses[best]
        others = [
            s for s, h in zip(score, self.hypotheses, strict=True) if not are_near(h.pose, leader.pose, self._near)
        ]
        sure = self._explained[best] >= LEAST_EXPLAINED and score[best] >= max(others, default=-np.inf) + LEAST_LEAD
        return leader if sure else None


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
            if measured[j, 0].type != m.type:
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


@njit
def weigh(
    hypotheses: Array,
    arrays: tuple[Any, ...],
    measured: Array,
    view: Array,
    parameters: tuple[Any, ...],
    explained: Array,
) -> None:
    """Condition hypotheses, (K,) of `PARTICLE`, on a scan and weigh them anew.

    A hypothesis gains by every measurement that it explains over none at all, and loses by regions in view that were
    not measured. `explained` (K,), the share of the measurements that are of confirmed regions, is averaged like the
    weights are.
    """
    maps, p, n = Maps(*arrays), Parameters(*parameters), len(measured)
    near, n_near = find_near(hypotheses, maps, measured, p.sensor_range)
    associations = np.empty((len(hypotheses), n), ASSOCIATION)
    candidates = np.empty((len(hypotheses), n * CANDIDATES_PER_MEASUREMENT), CANDIDATE)
    n_candidates = np.zeros(len(hypotheses), np.int64)
    associate(hypotheses, maps, near, n_near, measured, p, associations, candidates, n_candidates)
    for i in range(len(hypotheses)):
        hypotheses[i].log_weight *= MEMORY
    propose(hypotheses, maps, measured, associations, p)
    for i in range(len(hypotheses)):
        missing = 0
        if len(view) > 0:
            missing = count_missing(
                hypotheses[i], maps, i, near, n_near, associations, candidates[i, : n_candidates[i]], view, p
            )
        hypotheses[i].log_weight -= MISSING * missing
        share = count_found(maps, i, associations, p) / n
        explained[i] = MEMORY * explained[i] + (1 - MEMORY) * share
