from __future__ import annotations

import numpy as np
import pytest

from slam.particles import LINK_SLOTS, SLOTS, ParticleSet, free_slot


def marked(count: int = 4) -> ParticleSet:
    """Particles whose pose, regions and links all carry their own number."""
    the_set = ParticleSet.at(np.zeros(3), count)
    for i in range(count):
        the_set.particles["pose"][i] = i
        the_set.particles["n_slots"][i] = 2 + i
        the_set.particles["n_links"][i] = 1 + i
        the_set.regions["id"][i, : 2 + i] = 100 * (i + 1)
        the_set.regions["n"][i, : 2 + i] = 1
        the_set.regions["state"][i, : 2 + i] = i
        the_set.links["target_id"][i, : 1 + i] = 100 * (i + 1)
    return the_set


@pytest.mark.parametrize(
    "ancestors", [[0, 1, 2, 3], [2, 2, 2, 2], [3, 2, 1, 0], [1, 1, 3, 3], [3, 0, 0, 3], [0, 0, 0, 1]]
)
def test_every_ancestor_is_copied_whole_as_often_as_it_is_named(ancestors: list[int]) -> None:
    the_set = marked()
    the_set.gather(np.array(ancestors))
    found = []
    for i in range(4):
        ancestor = int(the_set.particles[i].pose[0])
        found.append(ancestor)
        assert the_set.particles[i].n_slots == 2 + ancestor
        assert the_set.particles[i].n_links == 1 + ancestor
        used = the_set.regions[i][: 2 + ancestor]
        assert set(used["id"].tolist()) == {100 * (ancestor + 1)}
        assert np.all(used["state"] == ancestor)
        assert not the_set.regions["n"][i, 2 + ancestor :].any()
        assert set(the_set.links["target_id"][i, : 1 + ancestor].tolist()) == {100 * (ancestor + 1)}
    assert sorted(found) == sorted(ancestors)


def test_a_survivor_stays_where_it_is() -> None:
    the_set = marked()
    the_set.gather(np.array([3, 1, 1, 3]))
    assert (the_set.particles["pose"][1, 0], the_set.particles["pose"][3, 0]) == (1, 3)


def test_gathered_particles_share_no_memory() -> None:
    the_set = marked()
    the_set.gather(np.array([2, 2, 2, 2]))
    the_set.regions["state"][0] = -1.0
    the_set.links["log_odds"][0] = -1.0
    the_set.particles["pose"][0] = -1.0
    for i in range(1, 4):
        assert np.all(the_set.regions["state"][i, :4] == 2)
        assert not the_set.links["log_odds"][i].any()
        assert the_set.particles["pose"][i, 0] == 2
        assert not np.shares_memory(the_set.regions[i], the_set.regions[0])


def test_arrays_grow_without_losing_anything() -> None:
    the_set = marked()
    before = the_set.regions.copy()
    the_set.make_room(regions=3, links=1)
    assert the_set.regions.shape == (4, SLOTS)
    the_set.make_room(regions=SLOTS, links=LINK_SLOTS)
    assert the_set.regions.shape[1] >= 5 + SLOTS
    assert the_set.links.shape[1] >= 4 + LINK_SLOTS
    np.testing.assert_array_equal(the_set.regions[:, :SLOTS], before)
    assert not the_set.regions["n"][:, SLOTS:].any()


def test_the_first_free_slot_is_taken() -> None:
    the_set = marked()
    the_set.regions["n"][1, 1] = 0
    assert free_slot(the_set.particles[1], the_set.regions[1]) == 1
    assert the_set.particles[1].n_slots == 3
    assert free_slot(the_set.particles[0], the_set.regions[0]) == 2
    assert the_set.particles[0].n_slots == 3
