import numpy as np
import pytest

from tests.floors import two_rooms
from tests.simulation.lively import lively, places, put_people


def shut(simulation, closed=True):
    """Close the only door at once, or open it, and leave it so."""
    doors = simulation.movers.doors
    doors.closed[:] = closed
    doors._due[:] = np.iinfo(np.int64).max
    simulation.movers.moved()
    simulation.reset(*simulation.pose)


def test_doors_close_and_always_open_again():
    simulation = lively(two_rooms(), (1, 1, 0), closing_doors=1.0, time_open=3.0, time_closed=2.0)
    closed = []
    for _ in range(3000):
        simulation.step(0, 0)
        closed.append(bool(simulation.movers.doors.closed[0]))
    changes = np.flatnonzero(np.diff(closed))
    assert len(changes) > 80
    assert np.diff(changes).max() <= 45  # 1.5 times the longer mean
    assert np.mean(closed) == pytest.approx(2 / 5, abs=0.08)


def test_a_closed_door_holds_the_robot_and_an_open_one_does_not():
    for closed, expected in ((True, 6 - 0.25), (False, 9.0)):
        simulation = lively(two_rooms(), (4, 2, 0), closing_doors=1.0)
        shut(simulation, closed)
        for _ in range(60):
            simulation.step(1, 0)
        assert simulation.collided is closed
        assert simulation.pose[0] == pytest.approx(expected, abs=0.02 if closed else 1.0)


@pytest.mark.parametrize("who", ["robot", "person", "furniture"])
def test_a_door_never_closes_on_anybody(who):
    start = (6.3, 2, 0) if who == "robot" else (1, 1, 0)
    simulation = lively(two_rooms(), start, closing_doors=1.0, people=1, time_open=1.0, time_closed=1.0)
    put_people(simulation, (6.3, 2, 6.3, 2) if who == "person" else (10, 1, 10, 1))
    simulation.movers.people.records["rest"] = 10**6
    if who == "furniture":
        simulation.movers._is_free = lambda door, robot: False
    for _ in range(300):
        simulation.step(0, 0)
        assert not simulation.movers.doors.closed.any()


def test_people_stop_before_a_closed_door():
    simulation = lively(two_rooms(), (1, 1, 0), people=1, closing_doors=1.0)
    put_people(simulation, (3, 2, 9, 2))
    shut(simulation)
    for _ in range(80):
        simulation.step(0, 0)
    x, _ = places(simulation)[0]
    assert 5.2 < x < 6 - 0.25 - 0.05


def test_only_a_share_of_the_doors_closes():
    simulation = lively(two_rooms(), (1, 1, 0), closing_doors=0.4, time_open=1.0)
    for _ in range(200):
        simulation.step(0, 0)
        assert not simulation.movers.doors.closed.any()
