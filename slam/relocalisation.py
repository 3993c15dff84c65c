"""The search of a robot that was carried, on its map.

The poses that most measurements of a scan support (`slam.matched_poses`) become hypotheses. They move with the robot
and are conditioned on every further scan, until one explains the scans far better than any other. All of them share
one map, and nothing is written to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.association import ASSOCIATION, CANDIDATES_PER_MEASUREMENT, associate
from slam.comparison import CANDIDATE
from slam.config import Parameters
from slam.jit import Array, njit
from slam.lost import MISSING, count_found, count_missing
from slam.maps import Maps
from slam.matched_poses import MOST_POSES, NEAR, are_near, support
from slam.motion import MotionNoise, Odometry
from slam.near import find_near
from slam.particles import PARTICLE
from slam.proposal import predict, propose

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
    near, n_near = find_near(hypotheses, maps, measured, measured[0, 0].level, p.sensor_range)
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
