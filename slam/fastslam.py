"""Region-based FastSLAM 2.0 (Oberländer et al. 2008, section III; Montemerlo et al. 2003)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.association import ASSOCIATION, CANDIDATE, CANDIDATES_PER_MEASUREMENT, associate
from slam.belief import Belief, moments
from slam.config import Parameters, SlamConfig
from slam.duplicates import resolve_duplicates
from slam.edge_form import observe
from slam.existence import update_existence
from slam.geometric_update import update_geometry
from slam.jit import Array, njit
from slam.maps import Maps, gather
from slam.measurement import Scan
from slam.motion import Odometry
from slam.near import demand, find_near
from slam.particles import ParticleSet
from slam.proposal import draw, place, predict, propose
from slam.region import REGION
from slam.resampling import systematic
from slam.semantic_update import update_semantics
from slam.topology_update import measured_relations, update_topology
from slam.weights import normalise, weights

NO_VIEW = np.zeros((0, 2))


@njit
def look_up(
    particles: Array, arrays: tuple[Any, ...], records: Array, type_numbers: Array, measured_links: Array
) -> Any:
    """Return what is measured, in edge form, and which regions of each map it can be of; and the room this may need."""
    n, maps = len(records), Maps(*arrays)
    measured = np.zeros((n, 4), REGION)
    relations = np.empty((n, n, 2))

    observe(records, type_numbers, measured)
    measured_relations(measured, measured_links, relations)
    near, n_near = find_near(particles, maps, measured)
    return measured, relations, near, n_near, demand(maps, near, n_near, relations)


@njit
def update_particles(
    particles: Array,
    arrays: tuple[Any, ...],
    measured: Array,
    relations: Array,
    near: Array,
    n_near: Array,
    view: Array,
    normals: Array,
    scan_number: int,
    parameters: tuple[Any, ...],
) -> float:
    """Take one scan through the filter, section III of the paper; return the effective sample size."""
    n, maps, p = len(measured), Maps(*arrays), Parameters(*parameters)
    associations = np.empty((len(particles), n), ASSOCIATION)
    candidates = np.empty((len(particles), n * CANDIDATES_PER_MEASUREMENT), CANDIDATE)
    n_candidates = np.zeros(len(particles), np.int64)

    associate(particles, maps, near, n_near, measured, p, associations, candidates, n_candidates)
    propose(particles, maps, measured, associations, p)
    draw(particles, normals)
    update_semantics(particles, maps, near, n_near, measured, candidates, n_candidates, p)
    update_geometry(particles, maps, near, n_near, measured, associations, scan_number, p)
    update_topology(maps, associations, relations, p)
    update_existence(particles, maps, near, n_near, associations, candidates, n_candidates, view, p)
    resolve_duplicates(maps, near, n_near, associations, scan_number, p)
    return normalise(particles)


@njit
def resample(particles: Array, arrays: tuple[Any, ...], uniform: float) -> None:
    """Replace the particles by copies of drawn ancestors, all of one weight; `uniform` is drawn from [0, 1)."""
    gather(particles, Maps(*arrays), systematic(weights(particles["log_weight"].copy()), uniform))
    for i in range(len(particles)):
        particles[i].log_weight = -np.log(len(particles))


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
        self._set = ParticleSet.at(_checked_pose(pose), self.config.n_particles)
        self._types: list[str] = []
        self._type_index: dict[str, int] = {}
        self._known_types: dict[tuple[str, ...], NDArray[np.int64]] = {}
        self._scan_number = 0
        self._ess = float(self.config.n_particles)
        return self.belief

    def step(self, odometry: Odometry, scan: Scan, pose: ArrayLike | None = None) -> Belief:
        """Predict with the odometry, update with the scan, and return the belief.

        With `pose` (x, y, theta) the filter takes that pose as certain and only maps.
        """
        self.predict(odometry)
        if pose is not None:
            place(self._set.particles, _checked_pose(pose))
        return self.update(scan)

    def predict(self, odometry: Odometry) -> None:
        """Move by odometry: p(x_t | x_{t-1}, u_t) of every particle, kept as a Gaussian until the next scan."""
        motion = (odometry.distance, odometry.lateral, odometry.rotation)
        if not math.isfinite(sum(motion)):
            raise ValueError(f"odometry is {odometry!r}, expected finite numbers")
        noise = self.config.motion_noise
        predict(self._set.particles, *motion, noise.distance, noise.heading_per_metre, noise.heading_per_radian)

    def update(self, scan: Scan) -> Belief:
        """Update poses and maps with a scan and return the belief."""
        self._resample()  # of the last scan: until now the belief was that of its weighted particles
        self._scan_number += 1
        cloud = self._set
        measured, relations, near, n_near, (records, links) = look_up(
            cloud.particles, tuple(cloud.maps), scan.records, self._type_numbers(scan.types), scan.links
        )
        cloud.make_room(slots=len(scan), records=records, links=links)
        self._ess = update_particles(
            cloud.particles,
            tuple(cloud.maps),
            measured,
            relations,
            near,
            n_near,
            NO_VIEW if scan.view is None else scan.view,
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
            resample(particles, tuple(self._set.maps), self._rng.random())


def _checked_pose(pose: ArrayLike) -> NDArray[np.float64]:
    """Return a pose as an array (x, y, theta), or refuse it."""
    try:
        checked = np.asarray(pose, dtype=np.float64)
    except (TypeError, ValueError):
        checked = np.empty(0)
    if checked.shape != (3,) or not np.all(np.isfinite(checked)):
        raise ValueError(f"pose is {pose!r}, expected three finite numbers (x, y, theta)")
    return checked
