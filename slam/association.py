"""Data association with unknown correspondence (Montemerlo & Thrun 2003), per particle.

Every measurement is compared with every region nearby. Pairs below the gate are candidates: the most likely ones of
the same type are associated, each region and each measurement once. A measurement that fits nothing is new; one that
fits half is used for neither, so that it spoils no region and makes no duplicate. Candidates of any type are
*relevant* in the sense of eq. (8).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.comparison import CANDIDATE, box, compare, compare_in
from slam.edge_form import state_size
from slam.extent import area
from slam.innovation import frame_of, n_closed, workspaces
from slam.jit import Array, Record, lean, njit
from slam.maps import region_of
from slam.semantic_update import SAME_PLACE

ASSOCIATION = np.dtype(
    (np.record, [("slot", np.int64), ("turn", np.int64), ("turn_map", np.int64), ("offset", np.int64)])
)
"""What a measurement is to a particle: a slot (or NEW, AMBIGUOUS), quarter turns of z and m, offset of their rows.

Quarter turns are the equivalent descriptions of `slam.turning`: those of a longer row lie along its other axis.
"""

NEIGHBOUR = np.dtype(
    (
        np.record,
        [
            ("record", np.int64),
            ("type", np.int64),
            ("area", np.float64),  # m²
            ("x", np.float64),  # anchor, map frame, m
            ("y", np.float64),
            ("radius", np.float64),  # m
            ("c", np.float64),  # `innovation.frame_of`
            ("s", np.float64),
            ("u", np.float64),
            ("v", np.float64),
        ],
    )
)
"""What a region near a particle is to all measurements: a few numbers side by side."""

NEW, AMBIGUOUS = -1, -2

CANDIDATES_PER_MEASUREMENT = 12
"""The most likely ones of each measurement are looked at."""

ALIKE = 2.5
"""Ratio of areas up to which a measurement of another type can be one of the same place."""

LARGE_VIEW = 1 / 4
"""Side of a square, in ranges of the sensor, that makes a region even where hardly an edge is seen."""

MARGIN = 1 / 8
"""Distance, in ranges of the sensor, beyond which regions that do not touch are not compared."""

SETTLED = 1.5
"""Log-odds, beside the prior, from which a region's type is settled: other types measured at its place are mistakes."""


@njit
def associate(
    particles: Array,
    maps: Record,
    near: Array,
    n_near: Array,
    measured: Array,
    p: Record,
    associations: Array,
    candidates: Array,
    n_candidates: Array,
) -> None:
    """Associate all measurements for every particle.

    `measured` (M, 4) holds the equivalent descriptions, `associations` (P, M) and `candidates` (P, ...) are written.
    """
    work = workspaces(p.tolerance)
    turned, found = np.zeros_like(measured[:1, 0]), np.zeros(1, CANDIDATE)
    circles, around = bounding_circles(measured), np.empty(near.shape[1], NEIGHBOUR)
    open_pairs = np.empty(candidates.shape[1], np.bool_)
    for i in range(len(particles)):
        n_candidates[i] = associate_one(
            particles[i],
            maps,
            i,
            near[i, : n_near[i]],
            measured,
            circles,
            p,
            work[0],
            turned[0],
            found[0],
            around,
            open_pairs,
            associations[i],
            candidates[i],
        )


@lean
def associate_one(
    particle: Record,
    maps: Record,
    i: int,
    near: Array,
    measured: Array,
    circles: Array,
    p: Record,
    work: Record,
    turned: Record,
    found: Record,
    around: Array,
    open_pairs: Array,
    associations: Array,
    candidates: Array,
) -> int:
    """Associate all measurements for particle i; return how many candidates there are.

    `circles` are `bounding_circles`. Scratch: a `WORKSPACE`, a `REGION`, a `CANDIDATE`, a `NEIGHBOUR` for each region
    nearby, and a flag for each candidate.
    """
    look_around(maps, i, near, particle.pose, around)
    n = find_candidates(
        particle, maps.pool, near, around[: len(near)], measured, circles, p, work, turned, found, candidates
    )
    assign(candidates[:n], open_pairs, associations, measured, maps.marks, p)
    doubt_misnamed(particle, maps, i, near, measured, p, work, turned, found, associations)
    return n


@lean
def find_candidates(
    particle: Record,
    pool: Array,
    slots: Array,
    around: Array,
    measured: Array,
    circles: Array,
    p: Record,
    work: Record,
    turned: Record,
    found: Record,
    candidates: Array,
) -> int:
    """Write the candidates of all measurements, one measurement after the other; return how many there are.

    `around` holds the regions nearby, `NEIGHBOUR`, and `slots` their slots; for `circles` see `bounding_circles`.
    """
    pose, cov, n = particle.pose, particle.cov, 0
    c, s = np.cos(pose[2]), np.sin(pose[2])
    margin = MARGIN * p.sensor_range + 5.0 * np.sqrt(cov[0, 0] + cov[1, 1])
    for z in range(len(measured)):
        first, descriptions, type_number = n, measured[z], measured[z, 0].type
        x = pose[0] + c * circles[z, 0] - s * circles[z, 1]
        y = pose[1] + s * circles[z, 0] + c * circles[z, 1]
        widest, size = circles[z, 2] + margin, circles[z, 3]
        for j in range(len(around)):
            other = around[j]
            dx, dy, reach = other.x - x, other.y - y, other.radius + widest
            if dx * dx + dy * dy > reach * reach or (type_number != other.type and not are_alike(size, other.area)):
                continue
            frame, m = (other.c, other.s, other.u, other.v), pool[other.record]
            if compare_in(frame, descriptions, m, particle, p, work, turned, found):
                found.z, found.slot = z, slots[j]
                n = keep(candidates, first, n, found)
    return n


@lean
def doubt_misnamed(
    particle: Record,
    maps: Record,
    i: int,
    near: Array,
    measured: Array,
    p: Record,
    work: Record,
    turned: Record,
    found: Record,
    associations: Array,
) -> None:
    """Make ambiguous what would be new, but shows a region of particle i whose other type is settled."""
    for z in range(len(measured)):
        for j in range(len(near) if associations[z].slot == NEW else 0):
            m = region_of(maps, i, near[j])
            if is_misnamed(measured[z], m, particle, p, work, turned, found):
                associations[z].slot = AMBIGUOUS
                break


@lean
def look_around(maps: Record, particle: int, near: Array, pose: Array, around: Array) -> None:
    """Write what data association asks of the regions nearby again and again into `around`, an array of `NEIGHBOUR`."""
    for j in range(len(near)):
        record, out = maps.table[particle, near[j]], around[j]
        m = maps.pool[record]
        out.record, out.type, out.area = record, m.type, area(m)
        out.x, out.y, out.radius = m.anchor[0], m.anchor[1], m.radius
        out.c, out.s, out.u, out.v = frame_of(m, pose)


@lean
def keep(candidates: Array, first: int, n: int, candidate: Record) -> Any:
    """Add a candidate to those of its measurement, `candidates[first:n]`; return their new end.

    Where there are enough of them, it takes the place of the least likely one if it is more likely.
    """
    if n - first < CANDIDATES_PER_MEASUREMENT:
        candidates[n] = candidate
        return n + 1
    least = first
    for c in range(first, n):
        if candidates[c].log_likelihood < candidates[least].log_likelihood:
            least = c
    if candidate.log_likelihood > candidates[least].log_likelihood:
        candidates[least] = candidate
    return n


@lean
def can_be_born(z: Record, p: Record) -> bool:
    """Say whether a measurement shows enough of a place to begin a region: two closed edges, or a large area."""
    return n_closed(z) >= 3 or area(z) >= (LARGE_VIEW * p.sensor_range) ** 2


@lean
def is_misnamed(
    descriptions: Record, m: Record, particle: Record, p: Record, work: Record, turned: Record, candidate: Record
) -> bool:
    """Say whether a measurement that fits no region of its type shows a region whose other type is settled.

    While no type is settled, every one that was measured makes a hypothesis of its own (section II-A).
    """
    z = descriptions[0]
    if z.type == m.type or m.type_log_odds - m.type_prior < SETTLED or z.n > m.n:
        return False
    size, other = area(z), area(m)
    # The area of what has open edges is but the least it can be.
    if (size > ALIKE * other and is_closed(m)) or (other > ALIKE * size and is_closed(z)):
        return False
    dx, dy = m.anchor[0] - particle.pose[0], m.anchor[1] - particle.pose[1]
    if dx * dx + dy * dy > (m.radius + z.radius + MARGIN * p.sensor_range) ** 2:
        return False
    return compare(descriptions, m, particle, p, work, turned, candidate) and candidate.distance < SAME_PLACE


@lean
def is_closed(region: Record) -> bool:
    """Say whether all edges of a region were seen."""
    return n_closed(region) == state_size(region.n)


@njit
def bounding_circles(measured: Array) -> Any:
    """Return centre (robot frame, m), radius (m) and area (m²) of every measurement, shape (M, 4)."""
    circles = np.zeros((len(measured), 4))
    for i in range(len(measured)):
        z = measured[i, 0]
        u0, u1, v0, v1 = box(z)
        u, v = (u0 + u1) / 2, (v0 + v1) / 2
        c, s = np.cos(z.state[0]), np.sin(z.state[0])
        circles[i, 0], circles[i, 1] = c * u - s * v, s * u + c * v
        circles[i, 2] = np.sqrt((u1 - u0) ** 2 + (v1 - v0) ** 2) / 2
        circles[i, 3] = area(z)
    return circles


@lean
def are_alike(a: float, b: float) -> bool:
    """Say whether two areas are near enough for two types to be taken for one another."""
    return a < ALIKE * b and b < ALIKE * a


@lean
def assign(candidates: Array, open_pairs: Array, associations: Array, measured: Array, taken: Array, p: Record) -> None:
    """Give each measurement the region that explains it best, each region once, the most likely pairs first.

    Scratch: `open_pairs`, a flag for each candidate, and `taken`, one number per slot, -1 before and after.
    """
    for z in range(len(measured)):
        associations[z].slot = NEW if can_be_born(measured[z, 0], p) else AMBIGUOUS
    for c in range(len(candidates)):
        open_pairs[c] = candidates[c].same_type and candidates[c].distance < p.gate_associate
    while True:
        best = -1
        for c in range(len(candidates)):
            if open_pairs[c] and (best < 0 or candidates[c].log_likelihood > candidates[best].log_likelihood):
                best = c
        if best < 0:
            break
        chosen = candidates[best]
        a = associations[chosen.z]
        a.slot, a.turn, a.turn_map, a.offset = chosen.slot, chosen.turn, chosen.turn_map, chosen.offset
        taken[chosen.slot] = chosen.z
        for c in range(len(candidates)):
            if candidates[c].z == chosen.z or candidates[c].slot == chosen.slot:
                open_pairs[c] = False
    for c in range(len(candidates)):
        doubt = candidates[c]
        # What fits a region that another measurement of the scan fits even better may be a second view of it.
        in_doubt = taken[doubt.slot] < 0 or doubt.distance < p.gate_associate
        if doubt.same_type and associations[doubt.z].slot == NEW and in_doubt:
            associations[doubt.z].slot = AMBIGUOUS
    for c in range(len(candidates)):
        taken[candidates[c].slot] = -1
