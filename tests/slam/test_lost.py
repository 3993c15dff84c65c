"""Is the filter lost? Only where regions in view are missing and measurements are of none."""

from __future__ import annotations

import numpy as np
import pytest

from slam.association import NEW
from slam.lost import FOUND, MISSING, MOST, contradiction
from slam.measurement import RegionMeasurement
from tests.slam.drawn import P, associated, links_to, mapped, maps, measured, near, particles, stored

ROOM = [0.0, -2, 2, -1.5, 1.5]
PLACES = [(3.0, 3.0), (3.0, -3.0), (-3.0, 3.0), (-3.0, -3.0)]
VIEW = np.array([[7.0, -7], [7, 7], [-7, 7], [-7, -7]])
NOWHERE = np.zeros((0, 2))


def floor(sightings: int = 3) -> np.ndarray:
    """Four confirmed rooms around the robot."""
    rooms = maps(*(mapped(ROOM, place) for place in PLACES))
    rooms["sightings"][0, :4] = sightings
    return rooms


def ratio(rooms: np.ndarray, places: list[tuple[float, float]], view: np.ndarray = VIEW) -> float:
    """The contradiction of a scan that measures rooms at these places."""
    scan = measured(*(RegionMeasurement("office", x, y, 4, 3) for x, y in places))
    robots, drawn = particles(), stored(rooms)
    associations, candidates, n = associated(robots, rooms, scan)
    return contradiction(robots, drawn, *near(drawn), associations, candidates, n, view, P)


def test_a_scan_of_the_map_speaks_against_being_lost() -> None:
    assert ratio(floor(), PLACES) == pytest.approx(max(4 * FOUND, -MOST))


def test_missing_regions_speak_for_it_up_to_a_limit() -> None:
    """Two rooms elsewhere and none where the map has four."""
    elsewhere = [(0.0, 8.0), (0.0, -8.0)]
    assert ratio(floor(), elsewhere) == pytest.approx(min(4 * MISSING, MOST))


def test_on_a_new_floor_nothing_is_missing() -> None:
    assert ratio(floor(), [*PLACES, (0.0, 8.0), (0.0, -8.0), (12.0, 0.0), (-12.0, 0.0), (12.0, 9.0)]) < 0
    assert ratio(maps(), [(0.0, 8.0), (0.0, -8.0)]) == 0.0


def test_tentative_regions_and_places_out_of_view_do_not_count() -> None:
    elsewhere = [(0.0, 8.0), (0.0, -8.0)]
    assert ratio(floor(sightings=2), elsewhere) == 0.0
    assert ratio(floor(), elsewhere, 0.2 * VIEW) == 0.0


def test_without_a_view_or_a_measurement_nothing_is_known() -> None:
    assert ratio(floor(), [(0.0, 8.0)], NOWHERE) == 0.0
    assert ratio(floor(), []) == 0.0


def test_the_particle_that_is_contradicted_least_counts() -> None:
    rooms, robots = np.repeat(floor(), 2, axis=0), particles(count=2)
    drawn = stored(rooms)
    seen = [(k, 0, 0, 0) for k in range(4)]
    associations = np.concatenate([links_to(*((NEW, 0, 0, 0) for _ in seen)), links_to(*seen)]).reshape(2, 4)
    _, candidates, n = associated(robots, rooms, measured())
    assert contradiction(robots, drawn, *near(drawn), associations, candidates, n, VIEW, P) < 0
