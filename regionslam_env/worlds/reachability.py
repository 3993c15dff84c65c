"""Which places of a world no robot can get to."""

from __future__ import annotations

import numpy as np

from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import World


def unreachable(world: World, radius: float = 0.2) -> tuple[str, ...]:
    """Return the ids of regions that a disc cannot get into from the largest connected part of the floor.

    Furniture (a region with a parent) is left out: it is an obstacle, and nobody gets into it.

    Parameters
    ----------
    world
        The truth.
    radius
        Radius of the disc, m.
    """
    geodesic = Geodesic(world, radius)
    rooms = [i for i, region in enumerate(world.regions) if region.parent is None]
    floors = {i: geodesic.floor([i]) for i in rooms}
    parts = []
    rest = {i for i in rooms if floors[i].any()}
    while rest:
        start = max(rest, key=lambda i: (np.count_nonzero(floors[i]), -i))
        reached = np.isfinite(geodesic.field([start]).nodes)
        members = {i for i in rest if (floors[i] & reached).any()} | {start}
        parts.append((np.count_nonzero(reached), members))
        rest -= members
    home = max(parts, key=lambda part: part[0])[1] if parts else set()
    return tuple(world.regions[i].id for i in rooms if i not in home)
