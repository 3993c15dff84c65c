"""Which believed region stands in which row of an observation (kernels).

A region keeps its slot for as long as it is in the map, whichever particle is the heaviest, until it is evicted for a
nearer or more relevant one. `ids` (S,) holds the region of each slot, -1 for none, and `places` (S,) its slot in the
filter's maps, -1 where the heaviest particle lacks it; both are carried from step to step.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.extent import to_row
from slam.jit import njit
from slam.maps import INSIDE, USED_SLOTS, region_of
from slam.region import b_index, u_index

_STAYS = 0.8  # a region is evicted only for one that is clearly more wanted, or two would take turns


@njit
def assign(
    ids: NDArray[np.int64],
    places: NDArray[np.int64],
    maps: Any,
    heaviest: int,
    pose: NDArray[np.float64],
    types: NDArray[np.int64],
    goal: int,
    confirmed_after: int,
) -> None:
    """Update `ids` and `places`: find what is there, take in what is new, evict what is most dispensable.

    A region that is missing in this map keeps its slot, empty, until somebody needs it: another particle may know it.
    """
    x, y = pose[0], pose[1]
    used = maps.counts[USED_SLOTS]
    taken = np.zeros(used, np.bool_)
    for slot in range(len(ids)):
        if ids[slot] >= 0:
            places[slot] = place_of(maps, heaviest, ids[slot], places[slot], confirmed_after)
            if places[slot] >= 0:
                taken[places[slot]] = True
    costs = np.zeros(len(ids))  # 0: not known yet
    for place in range(used):
        if taken[place] or not shown(maps, heaviest, place, confirmed_after):
            continue
        region = region_of(maps, heaviest, place)
        slot = free_slot(ids, places)
        if slot < 0:
            for other in range(len(ids)):
                if costs[other] == 0:
                    held = region_of(maps, heaviest, places[other])
                    costs[other] = cost(held, maps, x, y, types[held.type] == goal)
            slot = 0
            for other in range(len(ids)):
                if costs[other] > costs[slot]:
                    slot = other
            if cost(region, maps, x, y, types[region.type] == goal) > _STAYS * costs[slot]:
                continue
        ids[slot], places[slot], costs[slot] = region.id, place, 0.0


@njit
def free_slot(ids: NDArray[np.int64], places: NDArray[np.int64]) -> int:
    """Return the first unused slot, else one kept for a region that is not in this map, else -1."""
    kept = -1
    for slot in range(len(ids)):
        if ids[slot] < 0:
            return slot
        if places[slot] < 0 and kept < 0:
            kept = slot
    return kept


@njit
def place_of(maps: Any, particle: int, region_id: int, hint: int, confirmed_after: int) -> int:
    """Return the filter's slot of a region that a particle shows, -1 if it shows none; the hint is tried first."""
    if hint >= 0 and maps.slots[hint].id == region_id and shown(maps, particle, hint, confirmed_after):
        return hint
    for place in range(maps.counts[USED_SLOTS]):
        if maps.slots[place].id == region_id and shown(maps, particle, place, confirmed_after):
            return place
    return -1


@njit
def shown(maps: Any, particle: int, place: int, confirmed_after: int) -> bool:
    """Return whether a region is to be observed: known to a particle, seen often enough, and not outdone there."""
    if maps.table[particle, place] < 0:
        return False
    region = region_of(maps, particle, place)
    return region.rival < 0 and region.sightings >= confirmed_after


@njit
def cost(region: Any, maps: Any, x: float, y: float, is_goal: bool) -> float:
    """Return how dispensable a region is: its distance, a quarter of it for the goal's type, more in doubt."""
    result = (1.0 + distance(region, x, y)) * (2.0 - sigmoid(region.existence))
    if is_goal:
        return 0.25 * result
    k = region.first_link
    while k >= 0:
        if maps.links[k].kind == INSIDE and maps.links[k].log_odds > 0:
            return 3.0 * result
        k = maps.next_links[k]
    return result


@njit
def distance(region: Any, x: float, y: float) -> float:
    """Return the distance from a point of the map to the nearest rectangle of a region, m."""
    along, across = to_row(region, x, y)
    nearest = math.inf
    for i in range(region.n):
        left, right, bottom = u_index(i), u_index(i + 1), b_index(i)
        du = max(region["state"][left] - along, 0.0, along - region["state"][right])
        dv = max(region["state"][bottom] - across, 0.0, across - region["state"][bottom + 1])
        nearest = min(nearest, math.hypot(du, dv))
    return nearest


@njit
def sigmoid(log_odds: float) -> float:
    """Return the probability that has these log-odds."""
    return 1.0 / (1.0 + math.exp(-log_odds))
