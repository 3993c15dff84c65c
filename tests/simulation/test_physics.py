import math
import pickle

import numpy as np
import pytest

from regionslam_env.config import RobotConfig
from regionslam_env.simulation.chipmunk import fast_push, plain_push
from regionslam_env.simulation.driving import IN_ENGINE
from regionslam_env.simulation.engine import NO_ENGINE
from regionslam_env.simulation.physics import Simulation
from regionslam_env.worlds.clearance import exact_clearance, shapes_of
from tests.floors import bent_hallway, furnished_room, long_hallway, single_room, two_rooms

CLEARANCE = 0.25  # robot's radius and half a wall
DEPTH = 0.011  # of a contact: what is driven in one substep at full speed, and the slop


def driven(world, start, *commands):
    simulation = Simulation(world)
    simulation.reset(*start)
    for speed, turn_rate, steps in commands:
        for _ in range(steps):
            simulation.step(speed, turn_rate)
    return simulation


def test_at_1_m_per_s_two_seconds_are_two_metres():
    simulation = driven(long_hallway(), (-10, 0, 0), (1, 0, 10))
    before = simulation.pose
    for _ in range(20):
        simulation.step(1, 0)
    assert simulation.pose - before == pytest.approx([2, 0, 0], abs=1e-9)
    assert simulation.twist == pytest.approx([1, 0, 0], abs=1e-9)
    assert not simulation.collided


def test_the_robot_accelerates_at_2_m_per_s2():
    simulation = driven(long_hallway(), (-10, 0, 0), (1, 0, 3))
    assert simulation.twist[0] == pytest.approx(0.6)
    assert simulation.pose[0] == pytest.approx(-10 + sum(0.02 * k * 0.01 for k in range(30)))


def test_it_brakes_as_fast_as_it_accelerates():
    simulation = driven(long_hallway(), (-10, 0, 0), (1, 0, 10), (0, 0, 5))
    assert simulation.twist[0] == pytest.approx(0, abs=1e-12)
    simulation.step(0, 0)
    resting = simulation.pose
    simulation.step(0, 0)
    assert np.array_equal(simulation.pose, resting)


def test_turning_in_place_turns_and_stays():
    simulation = driven(single_room(), (1, 0.5, 0.3), (0, 2, 10))
    before = simulation.pose
    simulation.step(0, 2)
    assert simulation.pose - before == pytest.approx([0, 0, 0.2], abs=1e-9)
    assert simulation.pose[:2] == pytest.approx([1, 0.5], abs=1e-9)
    assert simulation.path_length == pytest.approx(0, abs=1e-9)


def test_a_steady_command_drives_a_circle():
    simulation = driven(single_room(), (0, -1, 0), (0.5, 0.5, 10))
    x, y, theta = simulation.pose
    for _ in range(30):
        simulation.step(0.5, 0.5)
    turned = theta + 0.5 * 3.0
    expected = x + math.sin(turned) - math.sin(theta), y + math.cos(theta) - math.cos(turned), turned
    assert simulation.pose == pytest.approx(expected, abs=1e-4)


def test_headings_wrap():
    simulation = driven(single_room(), (0, 0, 3.0), (0, 2, 20))
    assert -math.pi <= simulation.pose[2] <= math.pi


def test_too_fast_a_command_keeps_its_curve():
    simulation = driven(single_room(), (0, 0, 0), (1, 2, 20))
    forward, _, turn_rate = simulation.twist
    assert turn_rate / forward == pytest.approx(2)
    assert simulation.wheel_speeds[1] == pytest.approx(1.0)


def test_commands_beyond_the_limits_are_cut():
    assert driven(long_hallway(), (0, 0, 0), (9, 0, 20)).twist[0] == pytest.approx(1)
    assert driven(single_room(), (0, 0, 0), (0, -9, 20)).twist[2] == pytest.approx(-2)


@pytest.mark.parametrize("command", [(math.nan, 0), (0, math.inf)])
def test_a_command_that_is_no_number_is_refused(command):
    with pytest.raises(ValueError, match="finite"):
        Simulation(single_room()).step(*command)


def test_a_place_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="finite"):
        Simulation(single_room()).reset(0, math.nan, 0)


def test_a_wall_holds_for_as_long_as_the_robot_pushes():
    simulation = driven(single_room(), (0, 0, 0), (1, 0, 50))
    for _ in range(100):
        simulation.step(1, 0)
        assert simulation.collided
        assert simulation.pose[0] <= 3 - CLEARANCE + DEPTH
    assert simulation.pose == pytest.approx([3 - CLEARANCE, 0, 0], abs=DEPTH)
    assert simulation.twist[0] == pytest.approx(0, abs=1e-3)


def test_the_robot_backs_off_a_wall():
    simulation = driven(single_room(), (0, 0, 0), (1, 0, 50), (-1, 0, 20))
    assert not simulation.collided
    assert simulation.pose[0] < 1.6


def test_the_robot_slides_along_a_wall():
    simulation = driven(long_hallway(), (0, 0, 0.3), (1, 0, 60))
    assert simulation.collided
    assert simulation.pose[1] == pytest.approx(1 - CLEARANCE, abs=DEPTH)
    assert simulation.pose[0] > 4


def test_an_obstacle_holds():
    simulation = driven(furnished_room(), (-1, 0, 0), (1, 0, 40))
    assert simulation.collided
    assert simulation.pose[0] == pytest.approx(0.5 - 0.2, abs=DEPTH)


def test_a_door_lets_the_robot_through_and_its_posts_do_not():
    assert driven(two_rooms(), (4, 2, 0), (1, 0, 60)).pose[0] > 9
    assert driven(two_rooms(), (4, 1.4, 0), (1, 0, 60)).pose[0] < 6


def test_a_command_for_full_speed_never_breaks_through():
    world, rng = bent_hallway(), np.random.default_rng(6)
    simulation = Simulation(world)
    simulation.reset(7, 0, 0)
    corner, touched = np.array([6.0, 1.0]), 0
    for _ in range(1000):  # of 1 s
        speed, turn_rate = rng.choice([-1.0, 1.0]), rng.uniform(-2, 2)
        for _ in range(10):
            simulation.step(speed, turn_rate)
            touched += simulation.collided
            x, y, _ = simulation.pose
            gap = CLEARANCE - DEPTH
            assert gap <= x <= 8 - gap
            assert -1 + gap <= y <= 5 - gap
            assert x >= 6 + gap or y <= 1 - gap or np.hypot(*(corner - (x, y))) >= gap
    assert touched > 1000


def test_path_length_counts_metres_driven():
    simulation = driven(long_hallway(), (-10, 0, 0), (1, 0, 10), (-1, 0, 20))
    forward = driven(long_hallway(), (-10, 0, 0), (1, 0, 10)).pose[0] + 10
    assert simulation.path_length > 2 * forward
    simulation.reset(0, 0, 0)
    assert simulation.path_length == 0


def commands(count=150):
    return np.random.default_rng(7).uniform([-0.5, -2], [1, 2], (count, 2)).tolist()


def test_a_pickled_simulation_goes_on_identically():
    for start in ((7, 0, 0), (7.7, 0, 0.0)):
        first = driven(bent_hallway(), start, (1, 0, 20))
        second = pickle.loads(pickle.dumps(first))
        for speed, turn_rate in commands():
            first.step(speed, turn_rate)
            second.step(speed, turn_rate)
            assert np.array_equal(first.pose, second.pose)
            assert first.collided == second.collided


def test_an_episode_does_not_depend_on_the_one_before():
    fresh, used = Simulation(bent_hallway()), driven(bent_hallway(), (7, 0, 0), (1, 0, 30))
    for simulation in (fresh, used):
        simulation.reset(7.75, 0, 0)
    assert np.array_equal(used.twist, [0, 0, 0])
    for speed, turn_rate in commands():
        fresh.step(speed, turn_rate)
        used.step(speed, turn_rate)
        assert np.array_equal(fresh.pose, used.pose)


def test_every_way_into_the_engine_gives_the_same():
    compiled, short, public = (Simulation(bent_hallway()) for _ in range(3))
    short._engine = public._engine = NO_ENGINE
    short._push = fast_push(short._space, short._body)
    public._push = plain_push(public._space, public._body)
    for simulation in (compiled, short, public):
        simulation.reset(7, 0, 0.4)
    touched = 0
    for speed, turn_rate in commands():
        for simulation in (compiled, short, public):
            simulation.step(speed, turn_rate)
        assert np.array_equal(short.state, public.state)
        assert np.array_equal(short.state, compiled.state)
        touched += compiled.collided
    assert touched > 10


@pytest.mark.parametrize("start", [(1, 0, 0.4), (7, 0, 0.4), (7, 4, -1.6)])
def test_coasting_gives_the_same_as_the_engine_alone(start):
    coasting, engine = Simulation(bent_hallway()), Simulation(bent_hallway())
    engine._margin = math.inf
    free = touched = 0
    for simulation in (coasting, engine):
        simulation.reset(*start)
    for speed, turn_rate in np.repeat(commands(), 5, axis=0).tolist():
        coasting.step(speed, turn_rate)
        engine.step(speed, turn_rate)
        assert np.array_equal(coasting.pose, engine.pose)
        assert np.array_equal(coasting.twist, engine.twist)
        assert (coasting.collided, coasting.path_length) == (engine.collided, engine.path_length)
        free, touched = free + (not coasting.state[IN_ENGINE]), touched + engine.collided
    assert free > 100
    assert touched > 50


def test_coasting_never_starts_near_anything():
    simulation = Simulation(furnished_room())
    for x in np.linspace(-3, 3, 61):
        simulation.reset(x, 0, 0)
        simulation.step(1, 0)
        assert simulation.state[IN_ENGINE] or exact_clearance(x, 0.0, shapes_of(furnished_room()), 0.2) > 0.14


def test_a_slower_robot_and_a_longer_step():
    config = RobotConfig(max_speed=0.5, step=0.2, substeps=4)
    simulation = Simulation(long_hallway(), config)
    simulation.reset(0, 0, 0)
    for _ in range(5):
        simulation.step(1, 0)
    before = simulation.pose
    simulation.step(1, 0)
    assert simulation.pose[0] - before[0] == pytest.approx(0.1)
