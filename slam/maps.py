"""The region maps of all particles: records shared until written, one slot per region for all particles.

A region born from one measurement has the same *slot* in every particle's map. `table[i, slot]` says which record of
`pool` describes it for particle i, -1 where that particle does not know it. After resampling, particles share their
records; whoever writes to a region first takes a copy of its own (`own`). A region's links hang on its record and are
copied and freed with it. Everything frees up when the last holder lets go.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from slam.grid import enter, leave
from slam.jit import Array, Record, lean, njit

LINK_BELIEF = np.dtype(
    (
        np.record,
        [
            ("target", np.int64),  # slot
            ("target_id", np.int64),  # the link is stale once the slot holds another region
            ("kind", np.int64),
            ("log_odds", np.float64),
            ("place", np.float64, (2,)),  # of an adjacency: where it touches its region, map frame, m
        ],
    )
)
"""Belief in one directed link between two regions of a particle's map."""

ADJACENT, INSIDE = 0, 1
"""Kinds of links: m -> n of eq. (16), and m is a subregion of n of eq. (17)."""

USED_SLOTS, FREE_SLOTS, FREE_RECORDS, FIRST_FREE_LINK, FREE_LINKS, LAYERS = range(6)
"""What `Maps.counts` counts: slots up to the last one ever used, what is free of each kind, layers of the grid."""


class Maps(NamedTuple):
    """The arrays of all maps, as kernels take them: P particles, S slots, R records, L links."""

    table: np.ndarray  # (P, S) int32: record of a particle's region, -1 for none
    pool: np.ndarray  # (R,) REGION
    holders: np.ndarray  # (R,) int32: particles that share a record
    free_records: np.ndarray  # (R,) int32: a stack
    links: np.ndarray  # (L,) LINK_BELIEF: lists that start at `pool[r].first_link`; the free ones are a list, too
    next_links: np.ndarray  # (L,) int32: the link after each in its list, -1 at the end
    slots: np.ndarray  # (S,) SLOT
    free_slots: np.ndarray  # (S,) int32: a stack
    buckets: np.ndarray  # (B,) int32: the grid over the slots
    marks: np.ndarray  # (S,) int64: scratch, -1 between any two uses
    counts: np.ndarray  # (6,) int64


@lean
def has_room(maps: Record, slots: int, records: int, links: int) -> bool:
    """Say whether so many more slots, records and links are free."""
    counts = maps.counts
    if counts[FREE_RECORDS] < records or counts[FREE_LINKS] < links:
        return False
    return len(maps.slots) - counts[USED_SLOTS] + counts[FREE_SLOTS] >= slots


@lean
def region_of(maps: Record, particle: int, slot: int) -> Any:
    """Return the record of a region that a particle knows, for reading."""
    return maps.pool[maps.table[particle, slot]]


@lean
def own(maps: Record, particle: int, slot: int) -> Any:
    """Return the record of a region that a particle knows, for writing: its own, copied if it was shared."""
    if maps.holders[maps.table[particle, slot]] > 1:
        _part(maps, particle, slot)
    return maps.pool[maps.table[particle, slot]]


@lean
def add(maps: Record, particle: int, slot: int) -> Any:
    """Return a new record, to be filled, for a region that a particle has not known."""
    record = _new_record(maps)
    maps.table[particle, slot] = record
    maps.slots[slot].holders += 1
    maps.pool[record].first_link = -1
    return maps.pool[record]


@lean
def drop(maps: Record, particle: int, slot: int) -> None:
    """Let a particle forget a region."""
    record = maps.table[particle, slot]
    maps.table[particle, slot] = -1
    maps.holders[record] -= 1
    if maps.holders[record] == 0:
        _free_links(maps, record)
        maps.free_records[maps.counts[FREE_RECORDS]] = record
        maps.counts[FREE_RECORDS] += 1
    maps.slots[slot].holders -= 1
    if maps.slots[slot].holders == 0:
        leave(maps.slots, maps.buckets, slot)
        maps.free_slots[maps.counts[FREE_SLOTS]] = slot
        maps.counts[FREE_SLOTS] += 1


@lean
def new_slot(maps: Record, region_id: int) -> Any:
    """Return a free slot, now that of a region that no particle holds yet; the caller has made room."""
    if maps.counts[FREE_SLOTS] > 0:
        maps.counts[FREE_SLOTS] -= 1
        slot = maps.free_slots[maps.counts[FREE_SLOTS]]
    else:
        slot = maps.counts[USED_SLOTS]
        maps.counts[USED_SLOTS] += 1
    maps.slots[slot].id, maps.slots[slot].holders, maps.slots[slot].radius = region_id, 0, -1.0
    return slot


@lean
def cover(maps: Record, slot: int, m: Record) -> None:
    """See to it that the slot's circle in the grid covers a particle's region."""
    place = maps.slots[slot]
    dx, dy = m.anchor[0] - place.x, m.anchor[1] - place.y
    if place.radius < np.sqrt(dx * dx + dy * dy) + m.radius:
        widen(maps, slot, m)


@lean
def widen(maps: Record, slot: int, m: Record) -> None:
    """Let a slot's circle grow to cover a region; the first one makes it."""
    place = maps.slots[slot]
    if place.radius < 0.0:
        place.x, place.y, place.radius = m.anchor[0], m.anchor[1], m.radius
    else:
        leave(maps.slots, maps.buckets, slot)
        dx, dy = m.anchor[0] - place.x, m.anchor[1] - place.y
        place.radius = np.sqrt(dx * dx + dy * dy) + m.radius
    enter(maps.slots, maps.buckets, slot, maps.counts[LAYERS:])


@lean
def add_link(maps: Record, m: Record) -> Any:
    """Return a new link of a region that the caller owns, to be filled, at the head of its list."""
    index = maps.counts[FIRST_FREE_LINK]
    link = maps.links[index]
    maps.counts[FIRST_FREE_LINK] = maps.next_links[index]
    maps.counts[FREE_LINKS] -= 1
    maps.next_links[index] = m.first_link
    m.first_link = index
    m.n_links += 1
    return link


@lean
def is_current(maps: Record, particle: int, link: Record) -> bool:
    """Say whether a link leads to a region that the particle still knows."""
    return maps.table[particle, link.target] >= 0 and maps.slots[link.target].id == link.target_id


@lean
def drop_stale_links(maps: Record, particle: int, m: Record) -> None:
    """Free the links of a region, owned by the particle, that lead nowhere any more."""
    previous, index = -1, m.first_link
    while index >= 0:
        following = maps.next_links[index]
        if is_current(maps, particle, maps.links[index]):
            previous = index
        else:
            if previous < 0:
                m.first_link = following
            else:
                maps.next_links[previous] = following
            _free_link(maps, index)
            m.n_links -= 1
        index = following


@lean
def _part(maps: Record, particle: int, slot: int) -> None:
    """Give a particle a copy of a record that it shares."""
    record = maps.table[particle, slot]
    maps.holders[record] -= 1
    copy = _new_record(maps)
    maps.pool[copy] = maps.pool[record]
    maps.pool[copy].first_link = _copy_links(maps, maps.pool[record].first_link)
    maps.table[particle, slot] = copy


@lean
def _new_record(maps: Record) -> Any:
    maps.counts[FREE_RECORDS] -= 1
    record = maps.free_records[maps.counts[FREE_RECORDS]]
    maps.holders[record] = 1
    maps.pool[record].n_links = 0
    return record


@lean
def _copy_links(maps: Record, source: int) -> Any:
    """Copy a list of links, in order; return its head."""
    head, tail = -1, -1
    while source >= 0:
        index = maps.counts[FIRST_FREE_LINK]
        maps.counts[FIRST_FREE_LINK] = maps.next_links[index]
        maps.counts[FREE_LINKS] -= 1
        maps.links[index] = maps.links[source]
        maps.next_links[index] = -1
        if tail < 0:
            head = index
        else:
            maps.next_links[tail] = index
        tail = index
        source = maps.next_links[source]
    return head


@lean
def _free_links(maps: Record, record: int) -> None:
    index = maps.pool[record].first_link
    while index >= 0:
        following = maps.next_links[index]
        _free_link(maps, index)
        index = following


@lean
def _free_link(maps: Record, index: int) -> None:
    maps.next_links[index] = maps.counts[FIRST_FREE_LINK]
    maps.counts[FIRST_FREE_LINK] = index
    maps.counts[FREE_LINKS] += 1


@njit
def gather(particles: Array, maps: Record, ancestors: Array) -> None:
    """Make every particle a copy of its ancestor, whose records it shares until either writes.

    A particle that is among the ancestors keeps its own place, so that nothing is overwritten before it is read.
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
            particles[target] = particles[source]
            _share(maps, source, target)


@lean
def _share(maps: Record, source: int, target: int) -> None:
    """Give one particle's map to another, which forgets its own."""
    for slot in range(maps.counts[USED_SLOTS]):
        record, old = maps.table[source, slot], maps.table[target, slot]
        if record == old:
            continue
        if record >= 0:
            # First the new holder, then the old record: the slot must not become free in between.
            maps.holders[record] += 1
            maps.slots[slot].holders += 1
        if old >= 0:
            drop(maps, target, slot)
        maps.table[target, slot] = record
