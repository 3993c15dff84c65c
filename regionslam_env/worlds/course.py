"""Courses: true paths through a world, for judging the filter without a robot or an agent."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import World
from slam.rows import Floats
from slam.se2 import wrap

INSTITUTE_TOUR = (
    *("lobby", "office 2", "laboratory 1", "kitchen", "hallway 4", "office 18", "laboratory 4", "office 15"),
    *("hallway 3", "laboratory 3", "office 12", "stairs 1", "lobby", "hallway 1", "office 5", "hallway 2"),
    *("meeting room", "hallway 4", "stairs 2", "classroom 2", "office 10", "hallway 3", "service room", "classroom 1"),
    *("hallway 3", "lobby", "office 16", "storage 4", "office 1", "hallway 2", "office 7", "lobby"),
)
"""Regions of the institute in the order in which its tour enters them: about 300 m with two rounds of the loop."""


def course(
    world: World,
    stops: Sequence[str],
    step: float = 0.1,
    turn: float = 0.2,
    radius: float = 0.3,
) -> Floats:
    """Return the poses, shape (T, 3), of a disc that drives the shortest way from region to region.

    Parameters
    ----------
    world
        Where to drive.
    stops
        Ids of regions; the course starts in the middle of the first and goes on as soon as it enters the next.
    step, turn
        Largest displacement (m) and turn (rad) from pose to pose; the disc turns on the spot.
    radius
        Of the disc, m.
    """
    geodesic = Geodesic(world, radius)
    position = np.array(world.regions[world.region_index[stops[0]]].row.centre)
    corners = [position]
    for stop in stops[1:]:
        path = geodesic.field([stop]).path(*position)
        corners.extend(path[1:])
        position = np.asarray(path[-1])
    return _drive(np.array(corners), step, turn)


def _drive(corners: Floats, step: float, turn: float) -> Floats:
    """Return poses along a polyline."""
    heading = float(np.arctan2(*(corners[1] - corners[0])[::-1]))
    poses = [np.array([*corners[0], heading])]
    for start, end in pairwise(corners):
        way = end - start
        length = float(np.hypot(*way))
        if length < 1e-9:
            continue
        rotation = wrap(float(np.arctan2(way[1], way[0])) - heading)
        for k in range(1, int(np.ceil(abs(rotation) / turn)) + 1):
            part = min(k * turn / abs(rotation), 1.0)
            poses.append(np.array([*start, wrap(heading + part * rotation)]))
        heading = float(np.arctan2(way[1], way[0]))
        poses.extend(
            np.array([*(start + way * min(k * step / length, 1.0)), heading])
            for k in range(1, int(np.ceil(length / step)) + 1)
        )
    return np.array(poses)
