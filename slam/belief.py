"""What the filter believes: the pose, and the region map of its heaviest particle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slam.maps import Maps
from slam.mixture import sum_inside, weigh_inside
from slam.paper_form import to_features
from slam.region_map import RegionMap
from slam.rows import Floats


@dataclass(eq=False)
class Belief:
    """The belief after a step. It reads the filter's arrays, so it is valid until the next step; `map` is a copy.

    Attributes
    ----------
    pose_mean, pose_cov
        Mean (x, y, theta), m and rad in the map frame, and covariance (3, 3) of the mixture of all particles: each
        one's own proposal covariance and the spread between them.
    ess
        Effective sample size, 1 to the number of particles.
    pose
        Pose (3,) of the heaviest particle: what its regions are relative to.
    heaviest
        Which particle that is.
    particles, maps
        All particles, and their maps.
    types
        What the type of a `REGION` indexes.
    lost
        Whether the filter doesn't know where on its map the robot is. The particles then are hypotheses about that, all
        with one map, to which nothing is written.
    """

    pose_mean: Floats
    pose_cov: Floats
    ess: float
    pose: Floats
    heaviest: int
    particles: NDArray[np.void]
    maps: Maps
    types: list[str]
    confirmed_after: int
    lost: bool = False

    @cached_property
    def map(self) -> RegionMap:
        """The confirmed regions, in the map frame."""
        return RegionMap(to_features(self.maps, self.heaviest, self.types, self.confirmed_after))

    @property
    def features(self) -> NDArray[np.void]:
        """The heaviest particle's regions in edge form, tentative ones included: an array of `REGION`, by slot."""
        return self.regions_of(self.heaviest)

    def regions_of(self, particle: int) -> NDArray[np.void]:
        """Return a copy of a particle's regions, an array of `REGION`, by slot."""
        records = self.maps.table[particle]
        return self.maps.pool[records[records >= 0]]

    def where(self) -> dict[int, float]:
        """Return P(robot in region) by region id over all particles, the semantic pose; below 0.001 it is left out."""
        total = np.zeros(len(self.maps.slots))
        sum_inside(self.particles, self.maps.table, self.maps.pool, self.confirmed_after, total)
        return {int(self.maps.slots[slot].id): float(total[slot]) for slot in np.flatnonzero(total >= 0.001)}

    def probability_in(self, region_type: str) -> float:
        """Return the probability of being in a region of a type, over the particles and their own maps.

        Only confirmed regions count, and of several types at one place only the most credible.
        """
        if region_type not in self.types:
            return 0.0
        index = self.types.index(region_type)
        return min(1.0, float(weigh_inside(self.particles, tuple(self.maps), index, self.confirmed_after)))
