"""Region-based FastSLAM 2.0 (Oberländer et al. 2008, section III; Montemerlo et al. 2003), and its joint relative."""

from __future__ import annotations

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
from slam.lost import LOST
from slam.measurement import Scan
from slam.mixture import moments
from slam.motion import Odometry
from slam.particles import ParticleSet
from slam.region import REGION
from slam.relocalisation import Search
from slam.rows import Floats
from slam.sampled import SampledPosterior
from slam.turning import observe
from slam.weights import normalise

NO_VIEW = np.zeros((0, 2))

SCANS, DOUBT = range(2)
"""Places in `RegionSLAM.progress`."""

STORED = {name: array.dtype for name, array in ParticleSet.at(np.zeros(3), 1).to_arrays().items()}
"""Arrays of a stored filter."""


class RegionSLAM:
    """Simultaneous localization and mapping of regions with unknown correspondence.

    Parameters
    ----------
    config
        Settings; the defaults are those of the paper's experiment.
    seed
        Anything `numpy.random.default_rng` takes. The same seed and the same inputs give the same beliefs.

    Attributes
    ----------
    progress
        How many scans the filter has taken, and how much they contradict its map (`slam.lost`), by the places `SCANS`
        and `DOUBT`. A kernel that takes scans through the arrays of the posterior writes here, too.

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
        self._rng = np.random.default_rng(seed)
        self.reset()

    def reset(self, pose: ArrayLike = (0.0, 0.0, 0.0)) -> Belief:
        """Forget the map and start at a pose (x, y, theta) that is certain; return the belief."""
        start = _checked_pose(pose)
        self._posterior: SampledPosterior | JointPosterior = (
            JointPosterior.at(start, self.config)
            if self.config.posterior == "joint"
            else SampledPosterior.at(start, self.config, self._rng)
        )
        self._types = list(self.config.named_types)
        self._type_index = {name: i for i, name in enumerate(self._types)}
        self._known_types: dict[tuple[str, ...], NDArray[np.int64]] = {}
        self.progress = np.zeros(2)
        self._search: Search | None = None
        return self.belief

    def take_map(self, other: RegionSLAM) -> Belief:
        """Start over on the map and at the pose of another filter's heaviest particle; return the belief.

        Raises
        ------
        ValueError
            If either posterior is the joint one, whose map cannot be parted from its pose.
        """
        theirs = other._posterior
        if not isinstance(self._posterior, SampledPosterior) or not isinstance(theirs, SampledPosterior):
            raise ValueError("posterior is 'joint', expected 'fastslam2' for both filters")
        self.reset()
        heaviest = int(np.argmax(theirs.cloud.particles["log_weight"]))
        cloud = theirs.cloud.repeated(heaviest, self.config.n_particles)
        self._posterior = SampledPosterior(cloud, self.config, self._rng)
        numbers = self.type_numbers(other._types)
        if len(numbers) > 0:
            cloud.maps.pool["type"] = numbers[cloud.maps.pool["type"]]
        self.progress[SCANS] = other.progress[SCANS]
        return self.belief

    def step(self, odometry: Odometry, scan: Scan, pose: ArrayLike | None = None) -> Belief:
        """Predict with the odometry, update with the scan, and return the belief.

        With `pose` (x, y, theta) the filter takes that pose as certain and only maps.
        """
        self.predict(odometry)
        if pose is None:
            return self.update(scan)
        self._posterior.place(_checked_pose(pose))
        self._search = None
        return self._update(scan, watchful=False)

    def predict(self, odometry: Odometry) -> None:
        """Move by odometry: p(x_t | x_{t-1}, u_t), kept as a Gaussian until the next scan."""
        motion = (odometry.distance, odometry.lateral, odometry.rotation)
        self._posterior.predict(motion, self.config.motion_noise)
        if self._search is not None:
            self._search.predict(odometry, self.config.motion_noise)

    def update(self, scan: Scan) -> Belief:
        """Update poses and maps with a scan and return the belief."""
        if self._search is not None and isinstance(self._posterior, SampledPosterior):
            return self._look_around(self._posterior, self._search, scan)
        return self._update(scan, watchful=self.config.relocalise)

    def relocalise(self) -> Belief:
        """Take the pose as unknown: from now on the filter is lost, until scans tell where on its map the robot is.

        The map is kept, and nothing is written to it meanwhile. With `SlamConfig(relocalise=True)`, the default, the
        filter does so itself once scans contradict its map (`slam.lost`).

        Raises
        ------
        ValueError
            With the joint posterior, which cannot.
        """
        if isinstance(self._posterior, JointPosterior):
            raise ValueError("posterior is 'joint', expected 'fastslam2': a joint posterior cannot relocalise")
        cloud = self._posterior.cloud
        heaviest = int(np.argmax(cloud.particles["log_weight"]))
        self._search = Search(cloud.particles, cloud.maps.table[heaviest], self.config.parameters())
        return self.belief

    def _look_around(self, posterior: SampledPosterior, search: Search, scan: Scan) -> Belief:
        """Weigh where the robot may be; go on from there once that is clear."""
        self.progress[SCANS] += 1
        measured = np.zeros((len(scan), 4), REGION)
        observe(scan.records, self.type_numbers(scan.types), measured)
        measured["level"] = scan.level
        search.update(posterior.cloud.maps, measured, _view_of(scan))
        found = search.found
        if found is not None:
            posterior.restart(found)
            self.progress[DOUBT], self._search = 0.0, None
        return self.belief

    def _update(self, scan: Scan, watchful: bool) -> Belief:
        posterior = self._posterior
        posterior.resample()  # of the last scan: until now the belief was that of its weighted particles
        progress = self.progress
        progress[SCANS] += 1
        doubt = posterior.update(scan, self.type_numbers(scan.types), _view_of(scan), int(progress[SCANS]), watchful)
        progress[DOUBT] = max(progress[DOUBT] + doubt, 0.0)
        return self.relocalise() if progress[DOUBT] > LOST else self.belief

    @property
    def lost(self) -> bool:
        """Whether the filter doesn't know where on its map the robot is."""
        return self._search is not None

    @property
    def rng(self) -> np.random.Generator:
        """Where poses and ancestors are drawn from."""
        return self._rng

    @property
    def posterior(self) -> SampledPosterior | JointPosterior:
        """What the belief is made of: the particles and their maps."""
        return self._posterior

    @property
    def belief(self) -> Belief:
        """The present belief."""
        posterior = self._posterior
        particles, maps, ess = posterior.cloud.particles, posterior.cloud.maps, posterior.ess
        if self._search is not None:
            particles, maps = self._search.hypotheses.copy(), self._search.maps(maps)
            ess = normalise(particles)
        mean, cov = np.empty(3), np.empty((3, 3))
        heaviest = moments(particles, mean, cov)
        return Belief(
            mean,
            cov,
            ess,
            particles["pose"][heaviest].copy(),
            heaviest,
            particles,
            maps,
            self._types,
            self.config.confirmed_after,
            lost=self._search is not None,
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the filter to a file, from which `load` makes one that goes on bit-identically.

        The file is complete or absent, holds no pickle and is versioned.
        """
        about = {
            "config": settings_to_plain(self.config),
            "generator": generator_to_plain(self._rng),
            "types": self._types,
            "scan_number": int(self.progress[SCANS]),
            "ess": self._posterior.ess,
            "doubt": float(self.progress[DOUBT]),
            "lost": self._search is not None,
        }
        search = {} if self._search is None else self._search.to_arrays()
        save_checkpoint(path, about, {**self._posterior.to_arrays(), **search})

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
        loaded._posterior = (
            JointPosterior.from_arrays(arrays, loaded.config)
            if loaded.config.posterior == "joint"
            else SampledPosterior.from_arrays(arrays, loaded.config, loaded._rng)
        )
        loaded._posterior.ess = about["ess"]
        loaded._types = about["types"]
        loaded._type_index = {name: index for index, name in enumerate(loaded._types)}
        loaded.progress[:] = about["scan_number"], about["doubt"]
        if about["lost"]:
            loaded._search = Search.from_arrays(arrays, loaded.config.parameters())
        return loaded

    def type_numbers(self, types: Sequence[str]) -> NDArray[np.int64]:
        """Return the filter's numbers of a scan's types; an unknown type is a new type."""
        key = tuple(types)
        if key not in self._known_types:
            for name in key:
                if name not in self._type_index:
                    self._type_index[name] = len(self._types)
                    self._types.append(name)
            self._known_types[key] = np.array([self._type_index[name] for name in key], np.int64)
        return self._known_types[key]


def _view_of(scan: Scan) -> Floats:
    return NO_VIEW if scan.view is None else scan.view


def _checked_pose(pose: ArrayLike) -> NDArray[np.float64]:
    """Return a pose as an array (x, y, theta), or refuse it."""
    try:
        checked = np.asarray(pose, dtype=np.float64)
    except (TypeError, ValueError):
        checked = np.empty(0)
    if checked.shape != (3,) or not np.all(np.isfinite(checked)):
        raise ValueError(f"pose is {pose!r}, expected three finite numbers (x, y, theta)")
    return checked
