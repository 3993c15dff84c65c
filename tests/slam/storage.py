"""What must hold of the maps' storage at any time: nothing leaks, nothing is shared by mistake."""

from __future__ import annotations

import numpy as np

from slam.grid import search
from slam.maps import FIRST_FREE_LINK, FREE_LINKS, FREE_RECORDS, FREE_SLOTS, LAYERS, USED_SLOTS, Maps


def check_storage(maps: Maps) -> None:
    """Count records, slots and links from scratch and compare."""
    known = maps.table >= 0
    records, holders = np.unique(maps.table[known], return_counts=True)
    free = maps.free_records[: maps.counts[FREE_RECORDS]]
    np.testing.assert_array_equal(maps.holders[records], holders)
    assert sorted([*records.tolist(), *free.tolist()]) == list(range(len(maps.pool)))
    used = int(maps.counts[USED_SLOTS])
    assert not known[:, used:].any()
    np.testing.assert_array_equal(maps.slots["holders"][:used], known[:, :used].sum(axis=0))
    free_slots = maps.free_slots[: maps.counts[FREE_SLOTS]].tolist()
    assert sorted(free_slots) == np.flatnonzero(maps.slots["holders"][:used] == 0).tolist()
    _check_links(maps, records)
    assert (maps.marks == -1).all()
    for slot in np.flatnonzero(known.any(axis=0)):
        for record in set(maps.table[known[:, slot], slot].tolist()):
            m = maps.pool[record]
            assert maps.slots[slot].id == m.id
            found = search(maps.slots, maps.buckets, maps.counts[LAYERS], *m.anchor, 0.0)
            assert slot in found


def _check_links(maps: Maps, records: np.ndarray) -> None:
    """Every link is in exactly one list: a record's or the free one."""
    seen = []
    for record in records:
        index, before = int(maps.pool[record].first_link), len(seen)
        while index >= 0:
            seen.append(index)
            index = int(maps.next_links[index])
        assert len(seen) - before == maps.pool[record].n_links
    index, before = int(maps.counts[FIRST_FREE_LINK]), len(seen)
    while index >= 0:
        seen.append(index)
        index = int(maps.next_links[index])
    assert len(seen) - before == maps.counts[FREE_LINKS]
    assert sorted(seen) == list(range(len(maps.links)))
