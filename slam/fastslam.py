"""Region-based FastSLAM 2.0 (Oberländer et al. 2008, section III; Montemerlo et al. 2003)."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.belief import Belief
from slam.checkpoint import (
    generator_from_plain,
    generator_to_plain,
    load_checkpoint,
    save_checkpoint,
    settings_from_plain,
    settings_to_plain,
)
from slam.config import SlamConfig
from slam.joint import JointPosterior
from slam.maps import Maps
from slam.measurement import Scan
from slam.mixture import moments
from slam.motion import Odometry
from slam.particles import PARTICLE, ParticleSet, empty_maps
from slam.proposal import place, predict
from slam.resampling import SCHEMES
from slam.scan_update import look_up, resample, update_particles

NO_VIEW = np.zeros((0, 2))

STORED = {"particles": PARTICLE, **{name: array.dtype for name, array in empty_maps(1)._asdict().items()}}
"""Arrays of a stored filter."""


class RegionSLAM:
    """Simultaneous localization and mapping of regions with unknown correspondence.

    Parameters
    ----------
    config
        Settings; the defaults are those of the paper's experiment.
    seed
        Anything `numpy.random.default_rng` takes. The same seed and the same inputs give the same beliefs.

    Examples
    --------
    >>> from slam import Odometry, RegionMeasurement, RegionSLAM, Scan
    >>> slam = RegionSLAM(seed=0)
    >>> scan = Scan([RegionMeasurement("office", x=1.0, y=0.5, w=4.0, h=3.0)])
    >>> belief = slam.step(Odometry(distance=0.1, rotation=0.02), scan)
    >>> belief.pose_mean.shape
    (3,)
    """

    def __init__(self, config: SlamConfig | None = None, seed: int | np.random.Generator | None = None) -> None:
        self.config = config or SlamConfig()
        self._parameters = tuple(self.config.parameters())  # Numba unpacks a plain tuple five times faster
        self._rng = np.random.default_rng(seed)
        self.reset()

    def reset(self, pose: ArrayLike = (0.0, 0.0, 0.0)) -> Belief:
        """Forget the map and start at a pose (x, y, theta) that is certain; return the belief."""
        start, n = _checked_pose(pose), self.config.n_particles
        self._joint = JointPosterior.at(start, n) if self.config.posterior == "joint" else None
        self._set = ParticleSet.at(start, n) if self._joint is None else self._joint.cloud
        self._types: list[str] = []
        self._type_index: dict[str, int] = {}
        self._known_types: dict[tuple[str, ...], NDArray[np.int64]] = {}
        self._scan_number = 0
        self._ess = float(len(self._set.particles))
        return self.belief

    def step(self, odometry: Odometry, scan: Scan, pose: ArrayLike | None = None) -> Belief:
        """Predict with the odometry, update with the scan, and return the belief.

        With `pose` (x, y, theta) the filter takes that pose as certain and only maps.
        """
        self.predict(odometry)
        if pose is not None:
            checked = _checked_pose(pose)
            if self._joint is None:
                place(self._set.particles, checked)
            else:
                self._joint.place(checked)
        return self.update(scan)

    def predict(self, odometry: Odometry) -> None:
        """Move by odometry: p(x_t | x_{t-1}, u_t) of every particle, kept as a Gaussian until the next scan."""
        motion = (odometry.distance, odometry.lateral, odometry.rotation)
        if not math.isfinite(sum(motion)):
            raise ValueError(f"odometry is {odometry!r}, expected finite numbers")
        noise = self.config.motion_noise
        if self._joint is not None:
            self._joint.predict(motion, noise)
            return
        predict(self._set.particles, *motion, noise.distance, noise.heading_per_metre, noise.heading_per_radian)

    def update(self, scan: Scan) -> Belief:
        """Update poses and maps with a scan and return the belief."""
        if self._joint is None:
            self._resample()  # of the last scan: until now the belief was that of its weighted particles
        self._scan_number += 1
        cloud = self._set
        measured, relations, near, n_near, (records, links) = look_up(
            cloud.particles,
            tuple(cloud.maps),
            scan.records,
            self._type_numbers(scan.types),
            scan.links,
            float(self.config.sensor_range),
        )
        view = NO_VIEW if scan.view is None else scan.view
        if self._joint is not None:
            parameters = self.config.parameters()
            self._ess = self._joint.update(measured, relations, near, n_near, view, self._scan_number, parameters)
            return self.belief
        cloud.make_room(slots=len(scan), records=records, links=links)
        self._ess = update_particles(
            cloud.particles,
            tuple(cloud.maps),
            measured,
            relations,
            near,
            n_near,
            view,
            self._rng.standard_normal((len(cloud.particles), 3)),
            self._scan_number,
            self._parameters,
        )
        return self.belief

    @property
    def belief(self) -> Belief:
        """The present belief."""
        particles = self._set.particles
        mean, cov = np.empty(3), np.empty((3, 3))
        heaviest = moments(particles, mean, cov)
        return Belief(
            mean,
            cov,
            self._ess,
            particles["pose"][heaviest].copy(),
            heaviest,
            particles,
            self._set.maps,
            self._types,
            self.config.confirmed_after,
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the filter to a file, from which `load` makes one that goes on bit-identically.

        The file is complete or absent, holds no pickle and is versioned.
        """
        about = {
            "config": settings_to_plain(self.config),
            "generator": generator_to_plain(self._rng),
            "types": self._types,
            "scan_number": self._scan_number,
            "ess": self._ess,
        }
        gaussians = {} if self._joint is None else self._joint.to_arrays()
        arrays = {"particles": self._set.particles, **self._set.maps._asdict(), **gaussians}
        save_checkpoint(path, about, arrays)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> RegionSLAM:
        """Return the filter that `save` wrote.

        Raises
        ------
        MapError
            If the file is damaged, no filter's, or of another version; the message names it.
        """
        about, arrays = load_checkpoint(path, STORED)
        loaded = cls(settings_from_plain(about["config"]), generator_from_plain(about["generator"]))
        maps = Maps(**{name: arrays[name] for name in Maps._fields})
        loaded._set = ParticleSet(arrays["particles"], maps)
        if loaded._joint is not None:
            loaded._joint = JointPosterior.from_arrays(loaded._set, loaded.config.n_particles, arrays)
        loaded._types = about["types"]
        loaded._type_index = {name: index for index, name in enumerate(loaded._types)}
        loaded._scan_number, loaded._ess = about["scan_number"], about["ess"]
        return loaded

    def _type_numbers(self, types: Sequence[str]) -> NDArray[np.int64]:
        """Return the filter's numbers of a scan's types; an unknown type is a new type."""
        key = tuple(types)
        if key not in self._known_types:
            for name in key:
                if name not in self._type_index:
                    self._type_index[name] = len(self._types)
                    self._types.append(name)
            self._known_types[key] = np.array([self._type_index[name] for name in key], np.int64)
        return self._known_types[key]

    def _resample(self) -> None:
        """Draw ancestors when the effective sample size is low."""
        particles = self._set.particles
        if self._ess < self.config.resample_below * len(particles):
            uniforms = self._rng.random(len(particles))
            resample(particles, tuple(self._set.maps), SCHEMES.index(self.config.resampling), uniforms)


def _checked_pose(pose: ArrayLike) -> NDArray[np.float64]:
    """Return a pose as an array (x, y, theta), or refuse it."""
    try:
        checked = np.asarray(pose, dtype=np.float64)
    except (TypeError, ValueError):
        checked = np.empty(0)
    if checked.shape != (3,) or not np.all(np.isfinite(checked)):
        raise ValueError(f"pose is {pose!r}, expected three finite numbers (x, y, theta)")
    return checked
