"""The posterior of FastSLAM 2.0: particles are drawn trajectories, each with a map of independent regions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.config import SlamConfig
from slam.jit import Array
from slam.measurement import Scan
from slam.motion import MotionNoise
from slam.particles import ParticleSet
from slam.proposal import place, predict
from slam.resampling import SCHEMES
from slam.rows import Floats
from slam.scan_update import resample, update_particles


class SampledPosterior:
    """Weighted particles with drawn poses (Oberländer et al. 2008, section III; Montemerlo et al. 2003).

    Parameters
    ----------
    cloud
        The particles.
    config
        Settings.
    rng
        Where poses and ancestors are drawn from.

    Attributes
    ----------
    sample_size
        The effective one, shape (1,): kernels write it, too.
    """

    def __init__(self, cloud: ParticleSet, config: SlamConfig, rng: np.random.Generator) -> None:
        self.cloud, self._rng = cloud, rng
        self.sample_size = np.array([float(len(cloud.particles))])
        self._resample_below, self._scheme = config.resample_below, SCHEMES.index(config.resampling)
        self._parameters = tuple(config.parameters())  # Numba unpacks a plain tuple five times faster
        self._priors = tuple(config.priors())

    @property
    def ess(self) -> float:
        """Effective sample size."""
        return float(self.sample_size[0])

    @ess.setter
    def ess(self, ess: float) -> None:
        self.sample_size[0] = ess

    @classmethod
    def at(cls, pose: Floats, config: SlamConfig, rng: np.random.Generator) -> SampledPosterior:
        """Return particles with empty maps, at a pose (x, y, theta) known for certain."""
        return cls(ParticleSet.at(pose, config.n_particles), config, rng)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all arrays by name."""
        return self.cloud.to_arrays()

    @classmethod
    def from_arrays(
        cls, arrays: Mapping[str, NDArray[Any]], config: SlamConfig, rng: np.random.Generator
    ) -> SampledPosterior:
        """Return the posterior of which `to_arrays` gave the arrays."""
        return cls(ParticleSet.from_arrays(arrays), config, rng)

    def resample(self) -> None:
        """Draw ancestors where the effective sample size is low."""
        particles = self.cloud.particles
        if self.ess < self._resample_below * len(particles):
            resample(particles, tuple(self.cloud.maps), self._scheme, self._rng.random(len(particles)))

    def predict(self, motion: tuple[float, float, float], noise: MotionNoise) -> None:
        """Move by odometry: distance, lateral (m), rotation (rad); Gaussian until the next scan."""
        particles = self.cloud.particles
        predict(particles, *motion, noise.distance, noise.heading_per_metre, noise.heading_per_radian)

    def place(self, pose: Floats) -> None:
        """Put every particle at a pose (x, y, theta) known for certain."""
        place(self.cloud.particles, pose)

    def update(self, scan: Scan, types: Array, view: Array, scan_number: int, watchful: bool) -> float:
        """Take one scan, its types numbered, through all particles; return how much it contradicts their maps."""
        cloud = self.cloud
        normals = self._rng.standard_normal((len(cloud.particles), 3))
        self.ess = 0.0
        while self.ess == 0.0:
            self.ess, doubt, (records, links) = update_particles(
                cloud.particles,
                tuple(cloud.maps),
                scan.records,
                types,
                scan.links,
                scan.level,
                view,
                normals,
                scan_number,
                watchful,
                self._parameters,
                self._priors,
            )
            if self.ess == 0.0:
                cloud.make_room(slots=len(scan), records=records, links=links)
        return doubt

    def restart(self, found: np.record) -> None:
        """Go on from one pose, a `PARTICLE`, with the heaviest particle's map."""
        particles = self.cloud.particles
        self.cloud.gather(np.full(len(particles), np.argmax(particles["log_weight"])))
        for name in ("pose", "cov", "expected", "spread"):
            particles[name] = found[name]
        particles["log_weight"] = -np.log(len(particles))
        self.ess = float(len(particles))
