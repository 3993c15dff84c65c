"""The particle set: poses, weights, and one region map each.

Three record arrays hold everything: `particles` (P,), `regions` (P, slots) and `links` (P, link slots). A region
keeps its slot while it lives; `n == 0` marks a free slot. Links are singly linked lists that start at `regions[p,
slot].first_link`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.jit import Array, Record, njit
from slam.region import REGION

PARTICLE = np.dtype(
    (
        np.record,
        [
            ("pose", np.float64, (3,)),  # mean since the last draw; the drawn pose itself right after an update
            ("cov", np.float64, (3, 3)),  # of the motion since the last draw
            ("expected", np.float64, (3,)),  # of the last proposal, what the belief reports
            ("spread", np.float64, (3, 3)),  # covariance of the last proposal
            ("log_weight", np.float64),
            ("n_slots", np.int64),  # no slot from here on is in use
            ("n_links", np.int64),
        ],
    )
)

LINK_BELIEF = np.dtype(
    (
        np.record,
        [
            ("target", np.int64),  # slot
            ("target_id", np.int64),  # the link is stale once the slot holds another region
            ("next", np.int64),
            ("kind", np.int64),
            ("log_odds", np.float64),
        ],
    )
)
"""Belief in one directed link between two regions of a particle's map."""

ADJACENT, INSIDE = 0, 1
"""Kinds of links: m -> n of eq. (16), and m is a subregion of n of eq. (17)."""

SLOTS, LINK_SLOTS = 64, 512


@dataclass
class ParticleSet:
    """All particles of a filter; the arrays grow on demand."""

    particles: NDArray[np.void]
    regions: NDArray[np.void]
    links: NDArray[np.void]

    @classmethod
    def at(cls, pose: NDArray[np.float64], n_particles: int) -> ParticleSet:
        """Return particles with empty maps that all know their pose (x, y, theta)."""
        particles = np.zeros(n_particles, PARTICLE)
        particles["pose"] = particles["expected"] = pose
        particles["log_weight"] = -np.log(n_particles)
        regions = np.zeros((n_particles, SLOTS), REGION)
        return cls(particles, regions, np.zeros((n_particles, LINK_SLOTS), LINK_BELIEF))

    def make_room(self, regions: int, links: int) -> None:
        """Grow the arrays so that every particle can take so many more regions and links."""
        slots, link_slots = most_used(self.particles)
        if slots + regions > self.regions.shape[1]:
            self.regions = _grown(self.regions, slots + regions)
        if link_slots + links > self.links.shape[1]:
            self.links = _grown(self.links, link_slots + links)

    def gather(self, ancestors: NDArray[np.int64]) -> None:
        """Replace the particles by copies of their ancestors, shape (P,); no two share memory."""
        gather(self.particles, self.regions, self.links, ancestors)


def _grown(array: NDArray[np.void], needed: int) -> NDArray[np.void]:
    larger = np.zeros((array.shape[0], max(needed, 2 * array.shape[1])), array.dtype)
    larger[:, : array.shape[1]] = array
    return larger


@njit
def most_used(particles: Array) -> tuple[int, int]:
    """Return the largest number of slots and of link slots that any particle uses."""
    slots, links = 0, 0
    for i in range(len(particles)):
        slots, links = max(slots, particles[i].n_slots), max(links, particles[i].n_links)
    return slots, links


@njit
def gather(particles: Array, regions: Array, links: Array, ancestors: Array) -> None:
    """Copy every particle's ancestor into its place.

    A slot whose particle survives keeps its own state, so that nothing is overwritten before it is read: sources are
    exactly the survivors, and the others take copies.
    """
    n = len(particles)
    count = np.zeros(n, np.int64)
    for i in range(n):
        count[ancestors[i]] += 1
    target = 0
    for source in range(n):
        for _ in range(count[source] - 1):
            while count[target] > 0:
                target += 1
            count[target] = 1
            slots = max(particles[source].n_slots, particles[target].n_slots)
            used = particles[source].n_links
            particles[target] = particles[source]
            regions[target, :slots] = regions[source, :slots]
            links[target, :used] = links[source, :used]


@njit
def free_slot(particle: Record, regions: Array) -> Any:
    """Return the first free slot of a particle's map and count it in; the caller has made room."""
    for slot in range(particle.n_slots):
        if regions[slot].n == 0:
            return slot
    particle.n_slots += 1
    return particle.n_slots - 1
