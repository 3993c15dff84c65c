"""What an observation says of the believed map: the rows of its regions and links (kernels)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.slots import assign, place_of, sigmoid
from slam.extent import probability_inside
from slam.jit import njit
from slam.maps import INSIDE, USED_SLOTS, Maps, is_current, region_of
from slam.region import b_index, u_index

LENGTH_LIMIT = 1000.0
"""Positions and sizes in an observation are clipped to this many metres."""

OPEN, EXISTENCE, TYPE_P, VISITED, CONTAINS_ME, TYPES = 12, 22, 23, 24, 25, 26
"""First columns of the parts of a region's row; see `regionslam_env.observations.RegionColumn`."""

_FAR = 12.0  # standard deviations beyond which the robot is surely not there
_WEAKEST_LINK = 0.1  # probability below which a link is not worth a row

Floats = NDArray[np.float32]
Records = NDArray[np.void]


@njit
def write_map(
    regions: Floats,
    regions_mask: NDArray[np.int8],
    links: Floats,
    links_mask: NDArray[np.int8],
    ids: NDArray[np.int64],
    places: NDArray[np.int64],
    pose: NDArray[np.float64],
    heaviest: int,
    particles: Records,
    arrays: tuple[Any, ...],
    types: NDArray[np.int64],
    n_types: int,
    goal: int,
    confirmed_after: int,
) -> None:
    """Write the heaviest particle's map into an observation's tables, zeros so far, after updating the slots.

    `regions` has shape (S, TYPES + n_types), `links` (L, 4), the masks (S,) and (L,).

    `pose` is the heaviest particle's, `arrays` are those of the filter's `Maps`; `types` maps its types to columns.
    """
    maps = Maps(*arrays)
    assign(ids, places, maps, heaviest, pose, types, goal, confirmed_after)
    slots = np.full(maps.counts[USED_SLOTS], -1)
    for slot in range(len(ids)):
        if places[slot] >= 0:
            slots[places[slot]] = slot
            regions_mask[slot] = 1
            write_region(regions[slot], region_of(maps, heaviest, places[slot]), pose)
    write_types(regions, slots, maps, heaviest, types, n_types)
    write_contains_me(regions, ids, places, particles, maps, confirmed_after)
    write_links(links, links_mask, places, slots, maps, heaviest)


@njit
def write_region(row: Floats, region: Any, pose: NDArray[np.float64]) -> None:
    """Write geometry, open edges and probabilities of a region, in the frame of `pose`, into its row."""
    state, main = region.state, region.main
    left, right, bottom = state[u_index(main)], state[u_index(main + 1)], state[b_index(main)]
    along, across = (left + right) / 2, (bottom + state[b_index(main) + 1]) / 2
    c, s = math.cos(state[0]), math.sin(state[0])
    dx = region.anchor[0] + c * along - s * across - pose[0]
    dy = region.anchor[1] + s * along + c * across - pose[1]
    c, s = math.cos(pose[2]), math.sin(pose[2])
    row[0] = clip(c * dx + s * dy, LENGTH_LIMIT)
    row[1] = clip(c * dy - s * dx, LENGTH_LIMIT)
    row[2], row[3] = math.cos(state[0] - pose[2]), math.sin(state[0] - pose[2])
    row[4], row[5] = size(right - left), size(state[b_index(main) + 1] - bottom)
    closed = region.closed
    row[OPEN] = closed[b_index(main) + 1] == 0
    row[OPEN + 1] = closed[b_index(main)] == 0
    row[OPEN + 2] = main == 0 and closed[u_index(0)] == 0
    row[OPEN + 3] = main == region.n - 1 and closed[u_index(region.n)] == 0
    for side in range(2):
        i = main - 1 + 2 * side
        if 0 <= i < region.n:
            b = b_index(i)
            end = u_index(0) if side == 0 else u_index(region.n)
            row[6 + 3 * side] = size(state[u_index(i + 1)] - state[u_index(i)])
            row[7 + 3 * side] = size(state[b + 1] - state[b])
            row[8 + 3 * side] = clip((state[b] + state[b + 1]) / 2 - across, LENGTH_LIMIT)
            row[OPEN + 4 + 3 * side] = closed[b + 1] == 0
            row[OPEN + 5 + 3 * side] = closed[b] == 0
            row[OPEN + 6 + 3 * side] = closed[end] == 0
    row[EXISTENCE] = sigmoid(region.existence)
    row[TYPE_P] = sigmoid(region.type_log_odds)
    row[VISITED] = region.visited != 0


@njit
def write_types(
    rows: Floats, slots: NDArray[np.int64], maps: Any, heaviest: int, types: NDArray[np.int64], n_types: int
) -> None:
    """Write the type probabilities of every slot: its own, those of its rivals, the rest evenly on all others."""
    for place in range(len(slots)):
        if maps.table[heaviest, place] >= 0:
            region = region_of(maps, heaviest, place)
            slot = slots[place if region.rival < 0 else region.rival]
            if slot >= 0:
                rows[slot, TYPES + types[region.type]] += sigmoid(region.type_log_odds)
    for place in range(len(slots)):
        slot = slots[place]
        if slot < 0:
            continue
        named, total = 0, 0.0
        for column in range(TYPES, TYPES + n_types):
            if rows[slot, column] > 0:
                named += 1
                total += rows[slot, column]
        if named == 0:
            continue
        rest = (1.0 - total) / (n_types - named) if named < n_types and total < 1 else 0.0
        scale = 1.0 if rest > 0 else 1.0 / total
        for column in range(TYPES, TYPES + n_types):
            value = rows[slot, column]
            rows[slot, column] = value * scale if value > 0 else rest


@njit
def write_contains_me(
    rows: Floats,
    ids: NDArray[np.int64],
    places: NDArray[np.int64],
    particles: Records,
    maps: Any,
    confirmed_after: int,
) -> None:
    """Write the probability, over the particles and their own maps, that the robot is inside each slot's region."""
    for q in range(len(particles)):
        particle = particles[q]
        weight, x, y = math.exp(particle.log_weight), particle["expected"][0], particle["expected"][1]
        doubt = _FAR * math.sqrt(particle["spread"][0, 0] + particle["spread"][1, 1])
        for slot in range(len(ids)):
            # A slot is kept for a while for a region that the heaviest particle lacks; its row is masked.
            if ids[slot] >= 0 and places[slot] >= 0:
                place = place_of(maps, q, ids[slot], places[slot], confirmed_after)
                if place < 0:
                    continue
                region = region_of(maps, q, place)
                if math.hypot(x - region.anchor[0], y - region.anchor[1]) > 1.01 * region.radius + doubt:
                    continue  # so far that the probability is 0 to the last digit
                p = probability_inside(region, particle["expected"], particle["spread"])
                rows[slot, CONTAINS_ME] = min(1.0, rows[slot, CONTAINS_ME] + weight * p)


@njit
def write_links(
    rows: Floats,
    mask: NDArray[np.int8],
    places: NDArray[np.int64],
    slots: NDArray[np.int64],
    maps: Any,
    heaviest: int,
) -> None:
    """Write the links between slots, strongest first: first and second slot, probability, kind.

    An adjacency stands once with its lower slot first, as probable as the more probable of its two directions; of a
    containment the second is inside the first.
    """
    n = len(places)
    probabilities = np.zeros((2, n, n), np.float32)
    found = np.empty((2 * n * n, 3), np.int64)
    n_found = 0
    for slot in range(n):
        if places[slot] < 0:
            continue
        k = region_of(maps, heaviest, places[slot]).first_link
        while k >= 0:
            link = maps.links[k]
            k = maps.next_links[k]
            if not is_current(maps, heaviest, link):
                continue
            other = slots[link.target]
            if other < 0 or other == slot:
                continue
            first, second = (other, slot) if link.kind == INSIDE or other < slot else (slot, other)
            kind = 1 if link.kind == INSIDE else 0
            p = sigmoid(link.log_odds)
            if p < _WEAKEST_LINK:
                continue
            if probabilities[kind, first, second] == 0:
                found[n_found, 0], found[n_found, 1], found[n_found, 2] = kind, first, second
                n_found += 1
            probabilities[kind, first, second] = max(probabilities[kind, first, second], p)
    count = 0
    for i in range(n_found):
        kind, first, second = found[i, 0], found[i, 1], found[i, 2]
        count = insert_link(rows, count, first, second, probabilities[kind, first, second], kind)
    for row in range(count):
        mask[row] = 1


@njit
def insert_link(rows: Floats, count: int, first: int, second: int, p: float, kind: int) -> int:
    """Insert a link behind all that are at least as probable; return how many rows are used now."""
    k, probability = count, np.float32(p)
    if k == len(rows):
        if probability <= rows[k - 1, 2]:
            return count
        k -= 1
    while k > 0 and rows[k - 1, 2] < probability:
        for column in range(4):
            rows[k, column] = rows[k - 1, column]
        k -= 1
    rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3] = first, second, probability, kind
    return min(count + 1, len(rows))


@njit
def clip(value: float, limit: float) -> float:
    """Return the value, at most `limit` away from 0."""
    return min(limit, max(-limit, value))


@njit
def size(value: float) -> float:
    """Return a size within the observation's bounds."""
    return min(LENGTH_LIMIT, max(0.0, value))
