"""What the filter believes: the pose, and the region map of its heaviest particle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.extent import probabilities_inside
from slam.jit import Array, njit
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
    features
        Its regions in edge form, an array of `REGION`; slots with ``n == 0`` are free.
    types
        What `features["type"]` indexes.
    """

    pose_mean: Floats
    pose_cov: Floats
    ess: float
    pose: Floats
    features: NDArray[np.void]
    links: NDArray[np.void]
    types: list[str]
    particles: NDArray[np.void]
    regions: NDArray[np.void]
    confirmed_after: int

    @cached_property
    def map(self) -> RegionMap:
        """The confirmed regions, in the map frame."""
        return RegionMap(to_features(self.features, self.links, self.types, self.confirmed_after))

    def where(self) -> dict[int, float]:
        """Return P(robot in region) by region id over all particles, the semantic pose; below 0.001 it is left out."""
        total: dict[int, float] = {}
        for particle, regions in zip(self.particles, self.regions, strict=True):
            inside = np.empty(int(particle.n_slots))
            probabilities_inside(
                regions[: particle.n_slots], particle.expected, particle.spread, self.confirmed_after, inside
            )
            for slot in np.flatnonzero(inside > 0):
                region = int(regions[slot].id)
                total[region] = total.get(region, 0.0) + float(np.exp(particle.log_weight) * inside[slot])
        return {region: p for region, p in total.items() if p >= 0.001}


@njit
def moments(particles: Array, mean: Array, cov: Array) -> Any:
    """Write mean and covariance of the mixture of the particles' proposals; return the index of the heaviest."""
    heaviest = 0
    x, y, c, s = 0.0, 0.0, 0.0, 0.0
    for i in range(len(particles)):
        if particles[i].log_weight > particles[heaviest].log_weight:
            heaviest = i
        w = np.exp(particles[i].log_weight)
        x += w * particles[i].expected[0]
        y += w * particles[i].expected[1]
        c += w * np.cos(particles[i].expected[2])
        s += w * np.sin(particles[i].expected[2])
    mean[0], mean[1], mean[2] = x, y, np.arctan2(s, c)
    cov[:] = 0.0
    offset = np.zeros(3)
    for i in range(len(particles)):
        w = np.exp(particles[i].log_weight)
        offset[0], offset[1] = particles[i].expected[0] - x, particles[i].expected[1] - y
        offset[2] = (particles[i].expected[2] - mean[2] + np.pi) % (2 * np.pi) - np.pi
        for a in range(3):
            for b in range(3):
                cov[a, b] += w * (particles[i].spread[a, b] + offset[a] * offset[b])
    return heaviest
