"""Settings of the filter."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from slam.measurement import MeasurementNoise
from slam.motion import MotionNoise
from slam.priors import (
    PriorByPair,
    PriorByType,
    Priors,
    by_pair,
    by_type,
    checked_by_pair,
    checked_by_type,
    log_odds,
    names,
)
from slam.resampling import SCHEMES

GEOMETRIC_UPDATES = ("edges", "paper")
CHOICES = {
    "posterior": ("fastslam2", "joint"),
    "correspondence": ("edges", "paper"),
    "resampling": SCHEMES,
    "semantics": ("completed", "paper"),
    "geometric_update": GEOMETRIC_UPDATES,
}
"""Settings that are one of several words."""

PRIOR_TYPE, PRIOR_LINK, PRIOR_CHILD = 0.5, 0.2, 0.1
DRAWN_SHARE = 0.01


@dataclass(frozen=True)
class SlamConfig:
    """Settings of `RegionSLAM`.

    Parameters
    ----------
    n_particles
        Number of particles; with ``posterior="joint"`` of association hypotheses at most.
    posterior
        "fastslam2": particles are drawn trajectories, each with independent regions (section III of the paper).
        "joint": particles are association hypotheses, each with one Gaussian over pose and regions: slower, calibrated.
    motion_noise, measurement_noise
        What the filter believes of odometry, and of measurements that do not tell their own noise.
    sensor_range
        Range of the region sensor, m. Its inverse is the reference density of an edge that a hypothesis does not
        explain.
    tolerance
        Distance (m) by which the end of a view and an annotated edge may be off without being wrong; None: the standard
        deviation of measured positions. All other lengths that the filter judges by are multiples of it or shares of
        the sensor's range, so that results do not depend on the unit of length.
    correspondence
        How the rectangles of a measured row find those of a mapped one: ``"edges"``, by the likelihood of closed edges
        and joints, or ``"paper"``, by the least distance of two midpoints (Oberländer et al. 2008, section II-C).
    gate_associate, gate_new
        Squared Mahalanobis distances: below the first a measurement may be associated, above the second it is a new
        region, in between it is used for neither (Montemerlo & Thrun 2003). Wide, because particles are overconfident.
    drawn_share
        Share of the proposal's covariance that is drawn at each scan; the rest stays a Gaussian around the particle, so
        that many scans share in what the paper draws at once. 1: FastSLAM 2.0 to the letter. In the end all particles
        descend from one, and what it has drawn stays as error of the map. None: 0.01, and 1 with the paper's update.
    resample_below
        Resample when the effective sample size falls below this share of the particles.
    resampling
        Scheme, one of ``"systematic"``, ``"stratified"`` and ``"residual"``.
    prior_type
        Prior probability p(m) of Oberländer et al. 2008, eq. (7), or a mapping from type to probability or `TypePrior`
        (by dimensions). The key `priors.ANY` ("*") stands for every type not named; without it that is the default.
    prior_link, prior_child
        Prior probabilities p(m -> n) and p(m < n), "m is a subregion of n", of eqs. (16) and (17), or a mapping from
        (type of m, type of n), "*" for any; links are mutual, so either order will do.
    semantics
        "completed": priors enter once. "paper": (13) and (17) literally, which subtract their prior at every scan and
        so are meant for priors of 0.5.
    link_unseen
        Probability of a link that was not measured although both its regions were, eq. (14).
    existence_seen, existence_missed, existence_floor, existence_ceiling
        Log-odds a region gains when measured, loses when in view and not measured, is dropped below and cannot exceed.
    confirmed_after
        Number of sightings after which a region is no longer tentative.
    geometric_update
        How a region learns from a measurement: "edges", one joint Gaussian of all edge positions, or "paper", the
        expansion and the independent blocks of Oberländer et al. 2008, section II-C.1, with their innovation (23).
    relocalise
        Whether the filter notices when scans contradict its map, and then searches the robot on it (`slam.lost`).
    """

    n_particles: int = 4
    posterior: str = "fastslam2"
    motion_noise: MotionNoise = field(default_factory=MotionNoise)
    measurement_noise: MeasurementNoise = field(default_factory=MeasurementNoise)
    sensor_range: float = 8.0
    tolerance: float | None = None
    correspondence: Literal["edges", "paper"] = "edges"
    gate_associate: float = 30.0
    gate_new: float = 100.0
    drawn_share: float | None = None
    resample_below: float = 0.5
    resampling: str = "systematic"
    prior_type: PriorByType = PRIOR_TYPE
    prior_link: PriorByPair = PRIOR_LINK
    prior_child: PriorByPair = PRIOR_CHILD
    semantics: str = "completed"
    link_unseen: float = 0.1
    existence_seen: float = 0.7
    existence_missed: float = 0.4
    existence_floor: float = -1.0
    existence_ceiling: float = 6.0
    confirmed_after: int = 3
    geometric_update: str = "edges"
    relocalise: bool = True

    def __post_init__(self) -> None:
        for name, known in CHOICES.items():
            if getattr(self, name) not in known:
                raise ValueError(f"{name} is {getattr(self, name)!r}, expected one of {', '.join(map(repr, known))}")
        for name in ("n_particles", "confirmed_after"):
            value = getattr(self, name)
            if not (isinstance(value, int | np.integer) and not isinstance(value, bool) and value >= 1):
                raise ValueError(f"{name} is {value!r}, expected an integer of at least 1")
        if not 0 <= self._drawn_share <= 1:
            raise ValueError(f"drawn_share is {self.drawn_share!r}, expected a share from 0 to 1")
        if self.geometric_update == "paper" and self._drawn_share != 1:
            raise ValueError(f"drawn_share is {self.drawn_share!r}, expected 1 with geometric_update 'paper'")
        if not 0 < self.resample_below <= 1:
            raise ValueError(f"resample_below is {self.resample_below!r}, expected a share above 0, at most 1")
        object.__setattr__(self, "prior_type", checked_by_type("prior_type", self.prior_type))
        for name in ("prior_link", "prior_child"):
            object.__setattr__(self, name, checked_by_pair(name, getattr(self, name)))
        if not 0 < self.link_unseen < 1:
            raise ValueError(f"link_unseen is {self.link_unseen!r}, expected a probability between 0 and 1")
        self._check_existence()
        if not 0 < self.gate_associate <= self.gate_new:
            raise ValueError(
                f"gate_associate is {self.gate_associate!r} and gate_new {self.gate_new!r}, "
                "expected 0 < gate_associate <= gate_new"
            )
        if self.posterior == "joint" and self.geometric_update == "paper":
            raise ValueError("geometric_update is 'paper', expected 'edges' with posterior 'joint'")
        if not (np.isfinite(self.sensor_range) and self.sensor_range > 0):
            raise ValueError(f"sensor_range is {self.sensor_range!r}, expected a length above 0 m")
        if not (np.isfinite(self._tolerance) and self._tolerance > 0):
            raise ValueError(
                f"tolerance is {self.tolerance!r}, expected a length above 0 m (or None, with a "
                f"measurement_noise.sigma_xy above 0; it is {self.measurement_noise.sigma_xy!r})"
            )

    @property
    def _tolerance(self) -> float:
        return self.measurement_noise.sigma_xy if self.tolerance is None else self.tolerance

    @property
    def _drawn_share(self) -> float:
        if self.drawn_share is None:
            return 1.0 if self.geometric_update == "paper" else DRAWN_SHARE
        return self.drawn_share

    def _check_existence(self) -> None:
        for name in ("existence_seen", "existence_missed"):
            value = getattr(self, name)
            if not 0 <= value < np.inf:
                raise ValueError(f"{name} is {value!r}, expected finite log-odds of at least 0")
        if not -np.inf < self.existence_floor < self.existence_ceiling < np.inf:
            raise ValueError(
                f"existence_floor is {self.existence_floor!r} and existence_ceiling {self.existence_ceiling!r}, "
                "expected finite log-odds, the floor below the ceiling"
            )

    @property
    def named_types(self) -> tuple[str, ...]:
        """The types that the priors name: the filter numbers them first."""
        return names((self.prior_type, self.prior_link, self.prior_child))

    def parameters(self) -> Parameters:
        """Return the numbers that the kernels need."""
        return Parameters(
            self.sensor_range,
            -float(np.log(self.sensor_range)),
            self._tolerance,
            self.correspondence == "paper",
            self.gate_associate,
            self.gate_new,
            self.existence_seen,
            self.existence_missed,
            self.existence_floor,
            self.existence_ceiling,
            self.confirmed_after,
            self.geometric_update == "paper",
            self._drawn_share,
        )

    def priors(self) -> Priors:
        """Return what the semantic and topological kernels need."""
        types = self.named_types
        return Priors(
            by_type(self.prior_type, types, PRIOR_TYPE),
            by_pair(self.prior_link, types, PRIOR_LINK, mutual=True),
            by_pair(self.prior_child, types, PRIOR_CHILD, mutual=False),
            log_odds(self.link_unseen),
            self.semantics == "paper",
        )


class Parameters(NamedTuple):
    """The numbers of a `SlamConfig` that kernels need, but for `Priors`."""

    sensor_range: float
    log_reference: float  # log density of an edge that is not explained, 1 / sensor range
    tolerance: float
    by_midpoints: bool
    gate_associate: float
    gate_new: float
    existence_seen: float
    existence_missed: float
    existence_floor: float
    existence_ceiling: float
    confirmed_after: int
    paper_update: bool
    drawn_share: float
