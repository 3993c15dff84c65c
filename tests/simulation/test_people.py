import numpy as np
import pytest

from regionslam_env.simulation.people import PRIVACY
from tests.floors import long_hallway, single_room, two_rooms
from tests.simulation.lively import lively, places, put_people

TOUCH = 0.2 + 0.25  # radii of robot and person


def test_people_walk_at_their_speed():
    simulation = lively(long_hallway(), (-10, 0, 0), people=1, walking_speed=0.5)
    put_people(simulation, (0, 0, 5, 0))
    for _ in range(40):
        simulation.step(0, 0)
    assert places(simulation) == pytest.approx(np.array([[2.0, 0.0]]), abs=0.01)


def test_they_get_through_the_door_into_the_other_room_and_back():
    simulation = lively(two_rooms(), (0.5, 0.5, 0), people=3, seed=2)
    clearance = simulation.movers.people._geodesic.clearance
    rooms = []
    for _ in range(3000):
        simulation.step(0, 0)
        now = places(simulation)
        assert min(clearance(x, y) for x, y in now) > -0.012
        rooms.append(now[:, 0] > 6)
    changes = np.abs(np.diff(np.array(rooms).astype(int), axis=0)).sum(axis=0)
    assert (changes >= 4).all()


def test_a_person_stops_for_a_robot_that_stands_in_its_way():
    simulation = lively(two_rooms(), (6, 2, 0), people=1)
    put_people(simulation, (2, 2, 10, 2))
    for _ in range(100):
        simulation.step(0, 0)
    (person,) = places(simulation)
    assert simulation.pose[:2] == pytest.approx([6, 2], abs=1e-9)
    assert TOUCH + 0.1 < np.hypot(*(simulation.pose[:2] - person)) < TOUCH + 1.0
    assert person[0] < 6


def test_a_person_walks_around_a_robot_where_there_is_room():
    simulation = lively(single_room(10, 6), (0, 0, 0), people=1)
    put_people(simulation, (-4, 0, 4, 0))
    gaps = []
    for _ in range(104):
        simulation.step(0, 0)
        gaps.append(np.hypot(*(places(simulation)[0] - simulation.pose[:2])) - TOUCH)
    assert places(simulation)[0, 0] > 3.5
    assert min(gaps) > 0


def test_a_robot_cannot_push_a_person():
    simulation = lively(long_hallway(), (-2, 0, 0), people=1)
    put_people(simulation, (0, 0, 5, 0))
    simulation.movers.people.records["rest"] = 10**6
    for _ in range(60):
        simulation.step(1, 0)
    assert simulation.collided
    assert simulation.pose[0] == pytest.approx(-TOUCH, abs=0.02)
    assert places(simulation)[0] == pytest.approx([0, 0], abs=0.02)


def test_who_does_not_get_on_goes_elsewhere():
    simulation = lively(long_hallway(), (0, 0, 0), people=1)
    put_people(simulation, (0.8, 0, -5, 0))
    simulation.movers.people.records["patience"] = 20
    for _ in range(150):
        simulation.step(0, 0)
    assert places(simulation)[0, 0] > -6
    assert simulation.movers.people.records["to_x"][0] != -5


def test_people_begin_apart_and_away_from_the_robot():
    simulation = lively(two_rooms(), (2, 2, 0), people=12)
    here = places(simulation)
    assert len(here) == 12
    assert np.hypot(*(here - (2, 2)).T).min() >= PRIVACY
    assert min(np.hypot(*(here[i] - here[j])) for i in range(12) for j in range(i)) > 0.5


def test_where_there_is_no_room_for_all_some_stay_away():
    simulation = lively(single_room(4, 4), (-1.5, -1.5, 0), people=50)
    assert 5 < len(places(simulation)) < 30
    for _ in range(200):
        simulation.step(0.3, 0.5)
    assert np.isfinite(places(simulation)).all()
