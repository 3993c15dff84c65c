"""The filter on the institute's tour: what the product promises of it."""

from __future__ import annotations

import numpy as np
import pytest

from agents.accuracy import tour
from regionslam_env.worlds.course import INSTITUTE_TOUR, course
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.loading import load


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_tour_stays_below_a_metre_and_maps_every_place_once(seed: int) -> None:
    result = tour(seed)
    assert result["ape_max"] < 1.0
    assert (result["duplicates"], result["spurious"], result["missed"]) == (0, 0, 0)
    assert result["type_accuracy"] == 1.0


@pytest.mark.slow
def test_course_is_long_free_and_smooth() -> None:
    world = load("institute")
    poses = course(world, INSTITUTE_TOUR)
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert 300 < steps.sum() < 340
    assert steps.max() <= 0.1 + 1e-9
    geodesic = Geodesic(world, 0.2)
    assert all(geodesic.free(x, y) for x, y in poses[::5, :2])
