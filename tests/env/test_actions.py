import numpy as np
import pytest

from regionslam_env.actions import Action, action_space, read_action


@pytest.mark.parametrize(("arrival", "size"), [("stay", 2), ("declare", 3)])
def test_the_third_component_exists_where_arrival_is_declared(arrival, size):
    space = action_space(arrival)
    assert space.shape == (size,)
    assert space.low.tolist() == [-1.0] * size and space.high.tolist() == [1.0] * size
    assert space.dtype == np.float32


def test_an_action_is_read_in_parts():
    assert read_action(np.array([0.5, -0.25], np.float32), 2) == Action(0.5, -0.25, False)
    assert read_action([0.5, -0.25, 1.0], 3) == Action(0.5, -0.25, True)


def test_only_a_positive_third_component_declares():
    assert not read_action([0, 0, 0.0], 3).declare
    assert not read_action([0, 0, -1.0], 3).declare
    assert read_action([0, 0, 1e-6], 3).declare


def test_speeds_beyond_the_space_are_clipped():
    assert read_action([7.0, -7.0], 2) == Action(1.0, -1.0, False)


@pytest.mark.parametrize("action", [[0.0], [0.0, 0.0, 0.0], 0.5, [np.nan, 0.0], [0.0, np.inf], [[0.0, 0.0]]])
def test_what_is_no_action_is_refused(action):
    with pytest.raises(ValueError, match="expected 2 finite numbers"):
        read_action(action, 2)
