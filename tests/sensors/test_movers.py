import numpy as np
import pytest

from regionslam_env.config import NOISE_SETS, SensorConfig
from regionslam_env.sensors.lidar import Lidar
from regionslam_env.sensors.region_sensor import RegionSensor
from tests.floors import furnished_room, two_rooms
from tests.sensors.reading import find, kinds
from tests.simulation.lively import lively, put_people

EXACT, RNG = NOISE_SETS["none"], np.random.default_rng(0)


def sensors(simulation):
    movers = simulation.movers
    return (
        Lidar(SensorConfig(), EXACT, movers.fixed, RNG, movers),
        RegionSensor(SensorConfig(), EXACT, movers.fixed, RNG, movers),
    )


def test_the_lidar_sees_people_where_they_are():
    simulation = lively(two_rooms(), (1, 2, 0), people=1)
    lidar, _ = sensors(simulation)
    for x in (3.0, 4.5):
        put_people(simulation, (x, 2, x, 2))
        assert lidar.measure(simulation.pose)[90] == pytest.approx(x - 1 - 0.25, abs=0.02)


def test_who_stays_away_is_not_seen():
    simulation = lively(two_rooms(), (1, 2, 0), people=2)
    lidar, _ = sensors(simulation)
    put_people(simulation)
    assert lidar.measure(simulation.pose)[90] == 10.0


def test_a_closed_door_blocks_the_lidar_and_hides_the_room_behind():
    simulation = lively(two_rooms(), (4, 2, 0), closing_doors=1.0)
    lidar, regions = sensors(simulation)
    assert lidar.measure(simulation.pose)[90] == pytest.approx(8)
    assert kinds(regions.measure(simulation.pose)) == ["door", "kitchen", "office"]
    simulation.movers.doors.closed[:] = True
    assert lidar.measure(simulation.pose)[90] == pytest.approx(2)
    assert kinds(regions.measure(simulation.pose)) == ["door", "office"]
    simulation.movers.doors.closed[:] = False
    assert kinds(regions.measure(simulation.pose)) == ["door", "kitchen", "office"]


def test_without_occlusion_a_closed_door_hides_nothing():
    simulation = lively(two_rooms(), (4, 2, 0), closing_doors=1.0)
    simulation.movers.doors.closed[:] = True
    movers = simulation.movers
    sensor = RegionSensor(SensorConfig(occlusion=False), EXACT, movers.fixed, RNG, movers)
    assert kinds(sensor.measure(simulation.pose)) == ["door", "kitchen", "office"]


def test_pushed_furniture_is_measured_where_it_stands_now():
    simulation = lively(furnished_room(), (-2, 0, 0), movable_furniture=1.0)
    lidar, regions = sensors(simulation)
    assert lidar.measure(simulation.pose)[90] == pytest.approx(2.5)
    desk = find(regions.measure(simulation.pose), "desk")
    assert (desk.x, desk.y) == pytest.approx((3, 0))
    simulation.movers.poses[0] = (1.5, 1.0, 0.3)
    simulation.movers.moved()
    assert lidar.measure(simulation.pose)[90] == pytest.approx(5)
    desk = find(regions.measure(simulation.pose), "desk")
    assert (desk.x, desk.y, desk.phi) == pytest.approx((3.5, 1.0, 0.3))


def test_where_nothing_has_moved_they_measure_as_in_the_still_world():
    world = furnished_room()
    simulation = lively(world, (-2, 0.4, 0.2), movable_furniture=1.0, people=1)
    put_people(simulation)
    lidar, regions = sensors(simulation)
    still_lidar = Lidar(SensorConfig(), EXACT, world.arrays, RNG)
    still_regions = RegionSensor(SensorConfig(), EXACT, world.arrays, RNG)
    assert lidar.measure(simulation.pose) == pytest.approx(still_lidar.measure(simulation.pose), abs=1e-12)
    scan, still = regions.measure(simulation.pose), still_regions.measure(simulation.pose)
    assert scan.records["x"] == pytest.approx(still.records["x"], abs=1e-12)
