"""Which places of a world no robot can get to."""

from __future__ import annotations

import numpy as np

from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import World
from slam.jit import Array, njit


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
    home = set(largest_part(Geodesic(world, radius)))
    return tuple(r.id for i, r in enumerate(world.regions) if r.parent is None and i not in home)


def largest_part(geodesic: Geodesic) -> tuple[int, ...]:
    """Return the indices of the regions, without furniture, of the largest connected part of the floor."""
    rooms = [i for i, region in enumerate(geodesic.world.regions) if region.parent is None]
    floors = {i: geodesic.floor([i]) for i in rooms}
    parts = []
    rest = {i for i in rooms if floors[i].any()}
    while rest:
        start = max(rest, key=lambda i: (np.count_nonzero(floors[i]), -i))
        reached = np.isfinite(geodesic.field([start]).nodes)
        members = {i for i in rest if (floors[i] & reached).any()} | {start}
        parts.append((np.count_nonzero(reached), members))
        rest -= members
    return tuple(sorted(max(parts, key=lambda part: part[0])[1])) if parts else ()


def cut_off(world: World, radius: float = 0.2) -> tuple[str, ...]:
    """Return the same by steps from grid node to grid node: quick on floors of any size.

    A way that is free over less than the distance of two nodes may count as none.
    """
    geodesic = Geodesic(world, radius)
    part = np.full(geodesic.grid.clearance.shape, -1)
    count = label_parts(geodesic.grid.clearance, part, np.empty(part.size, np.int64))
    rooms = [i for i, region in enumerate(world.regions) if region.parent is None]
    found = {i: np.unique(part[geodesic.floor([i])]) for i in rooms}
    sizes = np.bincount(np.concatenate(list(found.values())), minlength=count) if rooms else np.zeros(1)
    home = int(np.argmax(sizes))
    return tuple(world.regions[i].id for i in rooms if home not in found[i])


@njit
def label_parts(clearance: Array, part: Array, stack: Array) -> int:
    """Give numbers to the connected parts of the free floor.

    Parameters
    ----------
    clearance
        On grid nodes, (nx, ny), m.
    part
        Number of each free node's part, (nx, ny); filled with -1 before, and still -1 afterwards where nothing fits.
    stack
        Room for every node.

    Returns
    -------
    int
        How many parts there are.
    """
    nx, ny = clearance.shape
    count = 0
    for node in range(nx * ny):
        if clearance[node // ny, node % ny] < 0 or part[node // ny, node % ny] >= 0:
            continue
        part[node // ny, node % ny] = count
        stack[0], size = node, 1
        while size > 0:
            size -= 1
            at = stack[size]
            for k in range(4):
                i, j = at // ny + (k == 0) - (k == 1), at % ny + (k == 2) - (k == 3)
                if 0 <= i < nx and 0 <= j < ny and clearance[i, j] >= 0 and part[i, j] < 0:
                    part[i, j] = count
                    stack[size] = i * ny + j
                    size += 1
        count += 1
    return count
