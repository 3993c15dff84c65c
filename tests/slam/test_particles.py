from __future__ import annotations

import numpy as np
import pytest

from slam.maps import FREE_LINKS, FREE_RECORDS, USED_SLOTS, Maps, add, add_link, cover, drop, new_slot, own
from slam.particles import LINKS, RECORDS, SLOTS, ParticleSet
from tests.slam.storage import check_storage


def region(maps: Maps, particle: int, slot: int) -> np.record:
    """A region of a particle; kernels called from Python hand out copies of records."""
    return maps.pool[maps.table[particle, slot]]


def put(maps: Maps, particle: int, slot: int, mark: float = 0.0) -> None:
    """A region of a particle that carries a mark, with a link to itself of the same mark."""
    add(maps, particle, slot)
    m = region(maps, particle, slot)
    m.id, m.n, m.radius = maps.slots[slot].id, 1, 1.0
    m.anchor[:] = 10.0 * slot, 0.0
    m.state[:] = mark
    cover(maps, slot, m)
    add_link(maps, m)
    link = maps.links[m.first_link]
    link.target, link.target_id, link.log_odds = slot, m.id, mark


def marked(count: int = 4) -> ParticleSet:
    """Particles whose pose, regions and links all carry their own number; particle i knows the slots 0 .. i + 1."""
    the_set = ParticleSet.at(np.zeros(3), count)
    slots = [new_slot(the_set.maps, 100 + k) for k in range(count + 1)]
    for i in range(count):
        the_set.particles["pose"][i] = i
        for slot in slots[: i + 2]:
            put(the_set.maps, i, slot, i)
    check_storage(the_set.maps)
    return the_set


@pytest.mark.parametrize(
    "ancestors", [[0, 1, 2, 3], [2, 2, 2, 2], [3, 2, 1, 0], [1, 1, 3, 3], [3, 0, 0, 3], [0, 0, 0, 1]]
)
def test_every_ancestor_is_copied_whole_as_often_as_it_is_named(ancestors: list[int]) -> None:
    the_set = marked()
    the_set.gather(np.array(ancestors))
    check_storage(the_set.maps)
    found = []
    for i in range(4):
        ancestor = int(the_set.particles[i].pose[0])
        found.append(ancestor)
        known = np.flatnonzero(the_set.maps.table[i] >= 0)
        assert known.tolist() == list(range(ancestor + 2))
        for slot in known:
            m = region(the_set.maps, i, slot)
            assert np.all(m.state == ancestor)
            assert the_set.maps.links[m.first_link].log_odds == ancestor
    assert sorted(found) == sorted(ancestors)


def test_a_survivor_stays_where_it_is() -> None:
    the_set = marked()
    the_set.gather(np.array([3, 1, 1, 3]))
    assert (the_set.particles["pose"][1, 0], the_set.particles["pose"][3, 0]) == (1, 3)


def test_records_are_shared_until_written() -> None:
    the_set = marked()
    the_set.gather(np.array([2, 2, 2, 2]))
    maps = the_set.maps
    assert len(set(maps.table[:, 0].tolist())) == 1
    own(maps, 0, 0)
    region(maps, 0, 0).state[:] = -1.0
    maps.links[region(maps, 0, 0).first_link].log_odds = -1.0
    for i in range(1, 4):
        assert np.all(region(maps, i, 0).state == 2)
        assert maps.links[region(maps, i, 0).first_link].log_odds == 2
        assert maps.table[i, 0] != maps.table[0, 0]
    check_storage(maps)
    record = maps.table[0, 0]
    own(maps, 0, 0)  # it is the particle's own by now
    assert maps.table[0, 0] == record


def test_what_the_last_holder_drops_is_free() -> None:
    the_set = marked(2)
    maps, room = the_set.maps, len(the_set.maps.pool)
    drop(maps, 0, 0)
    check_storage(maps)
    assert maps.slots[0].holders == 1
    drop(maps, 1, 0)
    check_storage(maps)
    assert maps.counts[FREE_RECORDS] == room - 3
    assert maps.counts[FREE_LINKS] == len(maps.links) - 3
    assert new_slot(maps, 777) == 0  # the free slot comes first
    assert maps.counts[USED_SLOTS] == 3


def test_arrays_grow_without_losing_anything() -> None:
    the_set = marked()
    before = the_set.maps
    the_set.make_room(slots=3, records=1, links=1)
    assert the_set.maps is before
    the_set.make_room(slots=3 * SLOTS, records=2 * RECORDS, links=2 * LINKS)
    after = the_set.maps
    check_storage(after)
    assert len(after.slots) >= 5 + 3 * SLOTS
    assert after.counts[FREE_RECORDS] >= 2 * RECORDS
    assert after.counts[FREE_LINKS] >= 2 * LINKS
    np.testing.assert_array_equal(after.table[:, :SLOTS], before.table)
    np.testing.assert_array_equal(after.pool[:RECORDS], before.pool)
