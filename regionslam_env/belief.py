"""The environment's one door to the filter, and the ladder of how well the robot knows its pose."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from slam.belief import Belief
from slam.config import SlamConfig
from slam.fastslam import DOUBT, RegionSLAM
from slam.lost import LOST
from slam.measurement import Scan
from slam.motion import Odometry
from slam.particles import ParticleSet
from slam.proposal import predict

Localization = Literal["slam", "oracle", "odometry"]

LOCALIZATIONS: tuple[Localization, ...] = ("slam", "oracle", "odometry")
"""Where the pose comes from: the filter, the truth, or dead reckoning. The map is made from it in each case."""

Floats = NDArray[np.float64]


class Localizer:
    """Belief about pose and map, in the map frame: the pose at the reset is its origin.

    Parameters
    ----------
    localization
        One of `LOCALIZATIONS`.
    config
        Of the filter; it keeps one particle where the pose is given to it.
    """

    def __init__(self, localization: Localization, config: SlamConfig) -> None:
        self.localization, self._config = localization, config
        self.reset(np.random.default_rng(0))

    def reset(self, rng: np.random.Generator) -> None:
        """Forget everything; `rng` is the filter's own generator."""
        self._filter = RegionSLAM(self._config, rng)
        self._reckoning = ParticleSet.at(np.zeros(3), 1).particles
        self._belief: Belief | None = None

    @property
    def filter(self) -> RegionSLAM:
        """The filter that maps."""
        return self._filter

    @property
    def belief(self) -> Belief:
        """The present belief."""
        if self._belief is None:
            self._belief = self._filter.belief
        return self._belief

    def forget_belief(self) -> None:
        """Say that the filter has gone on by other means than `step`: the belief is that of its particles now."""
        self._belief = None

    def notice_loss(self) -> bool:
        """Let the filter look for itself on its map if the last scan, taken by a kernel, has shown that it is lost."""
        lost = bool(self._filter.progress[DOUBT] > LOST)
        if lost:
            self._belief = self._filter.relocalise()
        return lost

    def carry(self) -> None:
        """Keep the map, but take the pose as unknown: the robot has been put elsewhere.

        The oracle learns its pose with the next step; dead reckoning never does.
        """
        if self.localization == "slam":
            self._belief = self._filter.relocalise()

    def step(self, odometry: Odometry, scan: Scan, true_pose: Floats) -> Belief:
        """Take in what was measured and return the belief.

        Parameters
        ----------
        odometry, scan
            Of this step.
        true_pose
            In the map frame, shape (3,); only the oracle looks at it.
        """
        if self.localization == "slam":
            belief = self._filter.step(odometry, scan)
        elif self.localization == "oracle":
            belief = self._filter.step(odometry, scan, true_pose)
        else:
            belief = self._reckon(odometry, scan)
        self._belief = belief
        return belief

    def _reckon(self, odometry: Odometry, scan: Scan) -> Belief:
        """Map from the pose that odometry alone gives; the belief tells how uncertain that is."""
        noise, reckoning = self._config.motion_noise, self._reckoning
        motion = (odometry.distance, odometry.lateral, odometry.rotation)
        predict(reckoning, *motion, noise.distance, noise.heading_per_metre, noise.heading_per_radian)
        belief = self._filter.step(odometry, scan, reckoning["pose"][0])
        belief.pose_cov[:] = reckoning["cov"][0]
        belief.particles["spread"][:] = reckoning["cov"][0]
        return belief
