"""Association hypotheses: where a scan is ambiguous they branch, and the unlikely ones are pruned (Reid 1979)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slam.association import ASSOCIATION, assign
from slam.jit import Array, Record, njit
from slam.maps import USED_SLOTS, drop, gather
from slam.particles import ParticleSet

DOUBT = 4.0
"""Log likelihood that an alternative association may lack of the best one to be followed up."""

FORCED = 1e6
"""Log likelihood that puts a pair before all others."""

NEGLIGIBLE = 7.0
"""Log weight that a hypothesis may lack of the heaviest one before it is dropped."""


@njit
def alternatives(
    candidates: Array, associations: Array, measured: Array, marks: Array, limit: int, p: Record
) -> tuple[Array, Array]:
    """Return other associations of a scan that are nearly as likely, and the log likelihoods that they lack.

    Each follows from the best one, `associations` (M,), by giving a measurement another region of its type and the rest
    what is likely then. Shapes (k, M) and (k,), k <= `limit`, the most likely first; `marks` is scratch of `assign`.
    """
    lack = np.full(len(candidates), np.inf)
    for c in range(len(candidates)):
        pair = candidates[c]
        chosen = associations[pair.z].slot
        if pair.same_type and pair.distance < p.gate_associate and chosen >= 0 and chosen != pair.slot:
            for other in candidates:
                if other.z == pair.z and other.slot == chosen:
                    lack[c] = other.log_likelihood - pair.log_likelihood
    found = np.empty((min(limit, len(candidates)), len(associations)), ASSOCIATION)
    lacking, open_pairs = np.empty(len(found)), np.empty(len(candidates), np.bool_)
    n = 0
    for c in np.argsort(lack):
        if n == len(found) or lack[c] > DOUBT:
            break
        candidates[c].log_likelihood += FORCED
        assign(candidates, open_pairs, found[n], measured, marks, p)
        candidates[c].log_likelihood -= FORCED
        lacking[n] = lack[c]
        if is_new(found, n):
            n += 1
    return found[:n], lacking[:n]


@njit
def is_new(found: Array, n: int) -> bool:
    """Say whether associations number n, shape (n + 1, M), differ from all before."""
    for k in range(n):
        same = True
        for z in range(found.shape[1]):
            same = same and found[k, z].slot == found[n, z].slot
        if same:
            return False
    return True


def copy_hypotheses(cloud: ParticleSet, parents: NDArray[np.int64]) -> None:
    """Append copies of hypotheses, given in ascending order; their records are shared until either writes.

    The table of the maps has rows for them, still empty.
    """
    n = len(cloud.particles)
    cloud.particles = np.concatenate((cloud.particles, cloud.particles[parents]))
    gather(cloud.particles, cloud.maps, np.concatenate((np.arange(n), parents)))


def keep_hypotheses(cloud: ParticleSet, kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """Keep the hypotheses of these indices, ascending, and forget the others; return which one is now at each place."""
    n, total = len(kept), len(cloud.particles)
    moved = kept[kept >= n]
    places = np.arange(n)
    places[np.setdiff1d(places, kept)] = moved
    surplus = np.full(total - n - len(moved), kept[-1])
    gather(cloud.particles, cloud.maps, np.sort(np.concatenate((kept, moved, surplus))))
    forget(cloud.maps, n, total)
    cloud.particles = cloud.particles[:n].copy()
    return places


@njit
def forget(maps: Record, first: int, last: int) -> None:
    """Empty the maps of particles `first` to `last` - 1."""
    for particle in range(first, last):
        for slot in range(maps.counts[USED_SLOTS]):
            if maps.table[particle, slot] >= 0:
                drop(maps, particle, slot)
