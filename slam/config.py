"""Settings of the filter."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from slam.measurement import MeasurementNoise
from slam.motion import MotionNoise
from slam.resampling import SCHEMES

GEOMETRIC_UPDATES = ("edges", "paper")
CORRESPONDENCES = ("edges", "paper")

POSTERIORS = ("fastslam2", "joint")


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
    resample_below
        Resample when the effective sample size falls below this share of the particles.
    resampling
        Scheme, one of ``"systematic"``, ``"stratified"`` and ``"residual"``.
    prior_type, prior_link, prior_child
        Prior probabilities p(m), p(m -> n) and p(m < n) of Oberländer et al. 2008, eqs. (7), (16), (17).
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
    gate_associate: float = 50.0
    gate_new: float = 200.0
    resample_below: float = 0.5
    resampling: str = "systematic"
    prior_type: float = 0.5
    prior_link: float = 0.2
    prior_child: float = 0.1
    link_unseen: float = 0.1
    existence_seen: float = 0.7
    existence_missed: float = 0.4
    existence_floor: float = -1.0
    existence_ceiling: float = 6.0
    confirmed_after: int = 3
    geometric_update: str = "edges"
    relocalise: bool = True

    def __post_init__(self) -> None:
        if not (isinstance(self.n_particles, int) and self.n_particles >= 1):
            raise ValueError(f"n_particles is {self.n_particles!r}, expected an integer of at least 1")
        if self.posterior not in POSTERIORS:
            raise ValueError(f"posterior is {self.posterior!r}, expected one of {', '.join(map(repr, POSTERIORS))}")
        for name in ("resample_below", "prior_type", "prior_link", "prior_child", "link_unseen"):
            value = getattr(self, name)
            if not 0 < value <= 1 or (value == 1 and name != "resample_below"):
                raise ValueError(f"{name} is {value!r}, expected a probability between 0 and 1")
        if self.resampling not in SCHEMES:
            raise ValueError(f"resampling is {self.resampling!r}, expected one of {', '.join(SCHEMES)}")
        if not 0 < self.gate_associate <= self.gate_new:
            raise ValueError(
                f"gate_associate is {self.gate_associate!r} and gate_new {self.gate_new!r}, "
                "expected 0 < gate_associate <= gate_new"
            )
        if self.geometric_update not in GEOMETRIC_UPDATES:
            known = " or ".join(map(repr, GEOMETRIC_UPDATES))
            raise ValueError(f"geometric_update is {self.geometric_update!r}, expected {known}")
        if self.posterior == "joint" and self.geometric_update == "paper":
            raise ValueError("geometric_update is 'paper', expected 'edges' with posterior 'joint'")
        if not (np.isfinite(self.sensor_range) and self.sensor_range > 0):
            raise ValueError(f"sensor_range is {self.sensor_range!r}, expected a length above 0 m")
        if not (np.isfinite(self._tolerance) and self._tolerance > 0):
            raise ValueError(
                f"tolerance is {self.tolerance!r}, expected a length above 0 m (or None, with a "
                f"measurement_noise.sigma_xy above 0; it is {self.measurement_noise.sigma_xy!r})"
            )
        if self.correspondence not in CORRESPONDENCES:
            raise ValueError(f"correspondence is {self.correspondence!r}, expected one of {CORRESPONDENCES}")

    @property
    def _tolerance(self) -> float:
        return self.measurement_noise.sigma_xy if self.tolerance is None else self.tolerance

    def parameters(self) -> Parameters:
        """Return the numbers that the kernels need."""

        def logit(p: float) -> float:
            return float(np.log(p / (1 - p)))

        return Parameters(
            self.sensor_range,
            -float(np.log(self.sensor_range)),
            self._tolerance,
            self.correspondence == "paper",
            self.gate_associate,
            self.gate_new,
            logit(self.prior_type),
            logit(self.prior_link),
            logit(self.prior_child),
            logit(self.link_unseen),
            self.existence_seen,
            self.existence_missed,
            self.existence_floor,
            self.existence_ceiling,
            self.confirmed_after,
            self.geometric_update == "paper",
        )


class Parameters(NamedTuple):
    """The kernels' share of a `SlamConfig`; probabilities as log-odds."""

    sensor_range: float
    log_reference: float  # log density of an edge that is not explained, 1 / sensor range
    tolerance: float
    by_midpoints: bool
    gate_associate: float
    gate_new: float
    prior_type: float
    prior_link: float
    prior_child: float
    link_unseen: float
    existence_seen: float
    existence_missed: float
    existence_floor: float
    existence_ceiling: float
    confirmed_after: int
    paper_update: bool
