"""The particle set: poses, weights, and the region maps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.grid import SLOT, enter
from slam.jit import Record, njit
from slam.maps import (
    FIRST_FREE_LINK,
    FREE_LINKS,
    FREE_RECORDS,
    FREE_SLOTS,
    LAYERS,
    LINK_BELIEF,
    USED_SLOTS,
    Maps,
    drop,
    gather,
)
from slam.region import REGION

PARTICLE = np.dtype(
    (
        np.record,
        [
            ("pose", np.float64, (3,)),  # mean; what is drawn moves it
            ("cov", np.float64, (3, 3)),  # of what was not drawn yet, and of the motion since
            ("expected", np.float64, (3,)),  # of the last proposal, what the belief reports
            ("spread", np.float64, (3, 3)),  # covariance of the last proposal
            ("log_weight", np.float64),
        ],
    )
)

SLOTS, RECORDS, LINKS = 64, 256, 1024
"""Room at first."""

BUCKETS_PER_SLOT = 4


@dataclass
class ParticleSet:
    """All particles of a filter and their maps; the arrays grow on demand."""

    particles: NDArray[np.void]
    maps: Maps

    @classmethod
    def at(cls, pose: NDArray[np.float64], n_particles: int) -> ParticleSet:
        """Return particles with empty maps that all know their pose (x, y, theta)."""
        particles = np.zeros(n_particles, PARTICLE)
        particles["pose"] = particles["expected"] = pose
        particles["log_weight"] = -np.log(n_particles)
        return cls(particles, empty_maps(n_particles))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return all arrays by name."""
        return {"particles": self.particles, **self.maps._asdict()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> ParticleSet:
        """Return the set of which `to_arrays` gave the arrays."""
        return cls(arrays["particles"], Maps(*(arrays[name] for name in Maps._fields)))

    def repeated(self, particle: int, count: int) -> ParticleSet:
        """Return `count` particles at the place of one, that share its map until they write to it."""
        maps = Maps(*(array.copy() for array in self.maps))
        keep_one_map(maps, particle)
        known = maps.table[particle] >= 0
        maps.holders[maps.table[particle, known]] = count
        maps.slots["holders"][known] = count
        particles = np.repeat(self.particles[particle : particle + 1], count)
        particles["log_weight"] = -np.log(count)
        return ParticleSet(
            particles, maps._replace(table=np.repeat(maps.table[particle : particle + 1], count, axis=0))
        )

    def make_room(self, slots: int, records: int, links: int) -> None:
        """Grow the arrays so that there is room for so many more slots, records and links."""
        counts = self.maps.counts
        if counts[FREE_RECORDS] < records:
            self.maps = with_more_records(self.maps, records)
        if counts[FREE_LINKS] < links:
            self.maps = with_more_links(self.maps, links)
        if len(self.maps.slots) - counts[USED_SLOTS] + counts[FREE_SLOTS] < slots:
            self.maps = with_more_slots(self.maps, slots)

    def gather(self, ancestors: NDArray[np.int64]) -> None:
        """Replace the particles by copies of their ancestors, shape (P,)."""
        gather(self.particles, self.maps, ancestors)


def empty_maps(n_particles: int, slots: int = SLOTS, records: int = RECORDS, links: int = LINKS) -> Maps:
    """Return maps without regions, with room for so many."""
    counts = np.zeros(LAYERS + 1, np.int64)
    counts[FIRST_FREE_LINK] = -1
    nothing = Maps(
        table=np.zeros((n_particles, 0), np.int32),
        pool=np.zeros(0, REGION),
        holders=np.zeros(0, np.int32),
        free_records=np.zeros(0, np.int32),
        links=np.zeros(0, LINK_BELIEF),
        next_links=np.zeros(0, np.int32),
        slots=np.zeros(0, SLOT),
        free_slots=np.zeros(0, np.int32),
        buckets=np.zeros(0, np.int32),
        marks=np.zeros(0, np.int64),
        counts=counts,
    )
    return with_more_slots(with_more_links(with_more_records(nothing, records), links), slots)


def with_more_records(maps: Maps, needed: int) -> Maps:
    """Return maps with at least so many free records."""
    old, free = len(maps.pool), int(maps.counts[FREE_RECORDS])
    size = max(old - free + needed, old + old // 2)
    free_records = _grown(maps.free_records, size, 0)
    free_records[free : free + size - old] = np.arange(size - 1, old - 1, -1)
    maps.counts[FREE_RECORDS] += size - old
    return maps._replace(
        pool=_grown(maps.pool, size, None), holders=_grown(maps.holders, size, 0), free_records=free_records
    )


def with_more_links(maps: Maps, needed: int) -> Maps:
    """Return maps with at least so many free links."""
    old, free = len(maps.links), int(maps.counts[FREE_LINKS])
    size = max(old - free + needed, old + old // 2)
    next_links = _grown(maps.next_links, size, 0)
    next_links[old:] = np.arange(old + 1, size + 1)
    next_links[-1] = maps.counts[FIRST_FREE_LINK]
    maps.counts[FIRST_FREE_LINK] = old
    maps.counts[FREE_LINKS] += size - old
    return maps._replace(links=_grown(maps.links, size, None), next_links=next_links)


def with_more_slots(maps: Maps, needed: int) -> Maps:
    """Return maps with room for at least so many more slots, and a grid as fine as they need."""
    old, used, free = len(maps.slots), int(maps.counts[USED_SLOTS]), int(maps.counts[FREE_SLOTS])
    size = max(used - free + needed, old + old // 2)
    table = np.full((len(maps.table), size), -1, np.int32)
    table[:, :old] = maps.table
    n_buckets = 1 << int(np.ceil(np.log2(BUCKETS_PER_SLOT * size)))
    grown = maps._replace(
        table=table,
        slots=_grown(maps.slots, size, None),
        free_slots=_grown(maps.free_slots, size, 0),
        buckets=np.full(n_buckets, -1, np.int32),
        marks=np.full(size, -1),
    )
    enter_all(grown.slots, grown.buckets, used, grown.counts[LAYERS:])
    return grown


@njit
def keep_one_map(maps: Record, particle: int) -> None:
    """Let all particles but one forget everything."""
    for i in range(len(maps.table)):
        for slot in range(maps.counts[USED_SLOTS] if i != particle else 0):
            if maps.table[i, slot] >= 0:
                drop(maps, i, slot)


@njit
def enter_all(slots: NDArray[np.void], buckets: NDArray[np.int32], used: int, n_layers: NDArray[np.int64]) -> None:
    """Put all slots in use into an empty grid."""
    for slot in range(used):
        if slots[slot].holders > 0:
            enter(slots, buckets, slot, n_layers)


def _grown(array: NDArray, size: int, fill: int | None) -> NDArray:  # type: ignore[type-arg]
    larger = np.zeros(size, array.dtype) if fill is None else np.full(size, fill, array.dtype)
    larger[: len(array)] = array
    return larger
