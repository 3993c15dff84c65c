import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from regionslam_env.errors import ConfigError
from regionslam_env.worlds.generate.generator import generate
from regionslam_env.worlds.source import PER_SPLIT, SPLITS, WorldSource, world_seed
from tests.floors import two_rooms

numbers = st.integers(0, PER_SPLIT - 1)


@given(st.sampled_from(SPLITS), numbers, st.sampled_from(SPLITS), numbers)
def test_no_two_splits_share_a_seed(split, number, other_split, other_number):
    same = (split, number) == (other_split, other_number)
    assert (world_seed(split, number) == world_seed(other_split, other_number)) == same


def test_the_ends_of_the_splits_do_not_meet():
    ends = [(world_seed(split, 0), world_seed(split, PER_SPLIT - 1)) for split in SPLITS]
    assert all(before[1] < after[0] for before, after in itertools.pairwise(ends))


@pytest.mark.parametrize("number", [-1, PER_SPLIT, 1.0, True, "3"])
def test_a_number_out_of_range_is_refused(number):
    with pytest.raises(ConfigError, match=r"world_seed is .*, expected a whole number from 0 to 4294967295"):
        world_seed("train", number)


def test_an_unknown_split_is_refused():
    with pytest.raises(ConfigError, match="did you mean 'test'"):
        world_seed("tset", 0)


def test_a_kind_has_a_world_for_every_number_and_other_ones_in_other_splits():
    train, test = (WorldSource("office", {"size": 12}, split) for split in ("train", "test"))
    assert train.world(3) is train.world(3)
    assert np.array_equal(train.world(3).walls, generate("office", 3, {"size": 12}).walls)
    assert not np.array_equal(train.world(3).walls, test.world(3).walls)


def test_a_floor_is_always_the_same():
    floor = two_rooms()
    source = WorldSource(floor)
    assert source.kind is None and source.world(0) is source.world(5) is floor


def test_options_for_a_floor_are_refused():
    with pytest.raises(ConfigError, match=r"world_options is \{'size': 30\}, expected none for world 'institute'"):
        WorldSource("institute", {"size": 30})
