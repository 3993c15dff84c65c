import pickle

import numpy as np
import pytest

from regionslam_env.simulation.chipmunk import fast_read, plain_crowd_push, plain_read
from regionslam_env.simulation.physics import Simulation
from regionslam_env.worlds.loading import load
from tests.floors import bent_hallway, furnished_room
from tests.simulation.lively import lively, places

pytestmark = pytest.mark.compiled

ALL = {"people": 4, "closing_doors": 1.0, "movable_furniture": 1.0, "time_open": 3.0, "time_closed": 2.0}


def commands(count=200):
    return np.repeat(np.random.default_rng(7).uniform([-0.3, -2], [1, 2], (count // 10, 2)), 10, axis=0).tolist()


def state(simulation):
    movers = simulation.movers
    return np.concatenate([simulation.pose, places(simulation).ravel(), movers.poses.ravel(), movers.doors.closed])


def crowded(seed=0):
    return lively(load("institute"), (30, 8, 0.0), seed=seed, **ALL)


def test_the_same_seed_gives_the_same_and_another_one_does_not():
    first, second, other = crowded(), crowded(), crowded(seed=1)
    for command in commands():
        for simulation in (first, second, other):
            simulation.step(*command)
        assert np.array_equal(state(first), state(second))
    assert not np.array_equal(state(first), state(other))


def test_a_pickled_one_goes_on_identically():
    first = lively(furnished_room(), (-1, 0.2, 0.0), people=2, movable_furniture=1.0)
    for command in commands(60):
        first.step(*command)
    second = pickle.loads(pickle.dumps(first))
    for command in commands():
        first.step(*command)
        second.step(*command)
        assert np.array_equal(state(first), state(second))
        assert first.collided == second.collided
    assert first.movers.poses[0] != pytest.approx([1, 0, 0], abs=0.01)


def test_an_episode_does_not_depend_on_the_one_before():
    used, fresh = crowded(), crowded()
    for command in commands():
        used.step(*command)
    for simulation in (used, fresh):
        simulation.movers.draw(np.random.default_rng(3), (30, 8))
        simulation.reset(30, 8, 0)
    for command in commands():
        used.step(*command)
        fresh.step(*command)
        assert np.array_equal(state(used), state(fresh))


def test_where_nothing_is_near_the_robot_drives_as_in_a_still_world():
    still, moving = Simulation(bent_hallway()), lively(bent_hallway(), (1, 0, 0.4), movable_furniture=1.0)
    still.reset(1, 0, 0.4)
    for command in commands():
        still.step(*command)
        moving.step(*command)
        assert np.array_equal(still.pose, moving.pose)
        assert np.array_equal(still.twist, moving.twist)
        assert (still.collided, still.path_length) == (moving.collided, moving.path_length)


def test_the_short_way_into_the_engine_gives_the_same_as_the_public_one():
    short, public = crowded(), crowded()
    public._push = plain_crowd_push(public._space, public._body, public._crowd, public._forces)
    public._read = plain_read(public._bodies)
    for command in commands(100):
        short.step(*command)
        public.step(*command)
        assert np.array_equal(state(short), state(public))
    assert fast_read(short._bodies)() == plain_read(short._bodies)()


def test_what_stands_in_the_scene_is_what_is_there():
    simulation = crowded()
    for command in commands():
        simulation.step(*command)
    movers = simulation.movers
    scene, truth = movers.scene, movers.truth
    assert np.array_equal(scene.people[:, :2], places(simulation))
    assert len(scene.door_segments) == len(scene.closed_doors) == movers.doors.closed.sum() > 0
    assert len(scene.furniture) == len(truth["furniture"]) == len(movers.pieces)
    assert truth["closed_doors"] == scene.closed_doors
    truth["people"][:] = 0
    assert np.array_equal(movers.scene.people[:, :2], places(simulation))
