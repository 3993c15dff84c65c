"""SPL as the environment reports it: start in the goal, unreachable goal, zero path, several goals."""

from dataclasses import replace

import numpy as np
import pytest

from regionslam_env.envs import GoToEnv
from regionslam_env.errors import ConfigError
from regionslam_env.worlds.world import Region, World
from slam.rows import Row
from tests.floors import box, two_rooms

STANDING, AHEAD = np.zeros(2), np.array([1.0, 0.0])


def kitchen_on_either_side() -> World:
    """Return an office (0..6 x 0..4 m) with a kitchen on its left (-6..0) and one on its right (6..12)."""
    regions = [
        Region(name, kind, name, Row.from_parameters(x, 2, 6, 4))
        for name, kind, x in (("office", "office", 3), ("left", "kitchen", -3), ("right", "kitchen", 9))
    ]
    sides = [wall for x in (0, 6) for wall in ((x, 0, x, 1.5), (x, 2.5, x, 4))]
    return World("three rooms", tuple(regions), np.array([*box(-6, 0, 12, 4), *sides], dtype=float))


def drive(env, action, **options):
    """Begin an episode and do the same until it ends; return the last info."""
    env.reset(seed=0, options=options)
    while True:
        *_, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            return info


def test_who_starts_in_the_goal_and_stays_has_gone_the_shortest_way():
    info = drive(GoToEnv(world=two_rooms()), STANDING, goal="kitchen", start=(9.0, 2.0, 0.0))
    assert (info["success"], info["spl"], info["soft_spl"], info["path_length"]) == (True, 1.0, 1.0, 0.0)


def test_who_never_moves_gets_nothing():
    info = drive(GoToEnv(world=two_rooms(), max_steps=20), STANDING, goal="kitchen", start=(3.0, 2.0, 0.0))
    assert (info["success"], info["spl"], info["soft_spl"], info["path_length"]) == (False, 0.0, 0.0, 0.0)
    assert info["distance_to_goal"] == pytest.approx(3.0, abs=0.05)


def test_of_several_goals_the_nearest_counts_whichever_is_reached():
    info = drive(GoToEnv(world=kitchen_on_either_side()), AHEAD, goal="kitchen", start=(2.0, 2.0, 0.0))
    assert info["success"] and info["distance_to_goal"] == 0
    assert 4.5 < info["path_length"] < 5.5  # into the kitchen on the right, and on for a second
    assert info["spl"] == pytest.approx(2.0 / info["path_length"], rel=0.02)  # the one on the left is 2 m away


def test_a_goal_that_cannot_be_reached_is_refused():
    world = two_rooms()
    closed = replace(world, walls=np.concatenate([world.walls, [[6, 1, 6, 3]]]), doors=(), links=())
    env = GoToEnv(world=closed)
    with pytest.raises(ConfigError, match=r"no way from .* to any 'kitchen'"):
        env.reset(options={"goal": "kitchen", "start": (3.0, 2.0, 0.0)})
