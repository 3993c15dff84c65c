"""Data association with unknown correspondence (Montemerlo & Thrun 2003), per particle.

Every measurement is compared with every region nearby. Pairs below the gate are candidates: the most likely ones of
the same type are associated, each region and each measurement once. A measurement that fits nothing is new; one that
fits half is used for neither, so that it spoils no region and makes no duplicate. Candidates of any type are
*relevant* in the sense of eq. (8).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.edge_form import turn
from slam.extent import area
from slam.innovation import (
    SLACK,
    correspond,
    innovate,
    is_admissible,
    log_likelihood,
    n_closed,
    workspace,
)
from slam.jit import Array, Record, njit
from slam.maps import region_of
from slam.region import b_index, u_index

ASSOCIATION = np.dtype(
    (np.record, [("slot", np.int64), ("turn", np.int64), ("turn_map", np.int64), ("offset", np.int64)])
)
"""What a measurement is to a particle: a slot (or NEW, AMBIGUOUS), quarter turns of z and m, offset of their rows."""

NEW, AMBIGUOUS = -1, -2

CANDIDATE = np.dtype(
    (
        np.record,
        [
            ("z", np.int64),
            ("slot", np.int64),
            ("turn", np.int64),
            ("turn_map", np.int64),
            ("offset", np.int64),
            ("same_type", np.int64),
            ("distance", np.float64),
            ("log_likelihood", np.float64),
        ],
    )
)
"""A measurement and a region that could be the same place."""

CANDIDATES_PER_MEASUREMENT = 12

ALIKE = 2.5
"""Ratio of areas up to which a measurement of another type can be one of the same place."""

LARGE_AREA = 4.0
"""Area (m²) of a view that makes a region even where hardly an edge is seen."""

MARGIN = 1.0
"""Distance (m) beyond which regions that do not touch are not compared."""


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
    work = workspace()
    turned = np.zeros_like(measured[:1, 0])
    circles = bounding_circles(measured)
    areas = np.zeros(near.shape[1])
    for i in range(len(particles)):
        for j in range(n_near[i]):
            areas[j] = area(region_of(maps, i, near[i, j]))
        pose = particles[i].pose
        c, s = np.cos(pose[2]), np.sin(pose[2])
        margin = MARGIN + 5.0 * np.sqrt(particles[i].cov[0, 0] + particles[i].cov[1, 1])
        n = 0
        for z in range(len(measured)):
            x = pose[0] + c * circles[z, 0] - s * circles[z, 1]
            y = pose[1] + s * circles[z, 0] + c * circles[z, 1]
            for j in range(n_near[i]):
                m = region_of(maps, i, near[i, j])
                dx, dy = m.anchor[0] - x, m.anchor[1] - y
                reach = m.radius + circles[z, 2] + margin
                if dx * dx + dy * dy > reach * reach or n == candidates.shape[1]:
                    continue
                if measured[z, 0].type != m.type and not are_alike(circles[z, 3], areas[j]):
                    continue
                if compare(measured[z], m, particles[i], p, work, turned[0], candidates[i, n]):
                    candidates[i, n].z, candidates[i, n].slot = z, near[i, j]
                    n += 1
        n_candidates[i] = n
        assign(candidates[i, :n], associations[i], measured, maps.marks, p)


@njit
def can_be_born(z: Record) -> bool:
    """Say whether a measurement shows enough of a place to begin a region: two closed edges, or a large area."""
    return n_closed(z) >= 3 or area(z) >= LARGE_AREA


@njit
def bounding_circles(measured: Array) -> Any:
    """Return centre (robot frame, m), radius (m) and area (m²) of every measurement, shape (M, 4)."""
    circles = np.zeros((len(measured), 4))
    for i in range(len(measured)):
        z = measured[i, 0]
        u0, u1 = z.state[u_index(0)], z.state[u_index(z.n)]
        v0, v1 = z.state[b_index(0)], z.state[b_index(0) + 1]
        for k in range(1, z.n):
            v0, v1 = min(v0, z.state[b_index(k)]), max(v1, z.state[b_index(k) + 1])
        u, v = (u0 + u1) / 2, (v0 + v1) / 2
        c, s = np.cos(z.state[0]), np.sin(z.state[0])
        circles[i, 0], circles[i, 1] = c * u - s * v, s * u + c * v
        circles[i, 2] = np.sqrt((u1 - u0) ** 2 + (v1 - v0) ** 2) / 2
        circles[i, 3] = area(z)
    return circles


@njit
def are_alike(a: float, b: float) -> bool:
    """Say whether two areas are near enough for two types to be taken for one another."""
    return a < ALIKE * b and b < ALIKE * a


@njit
def compare(
    descriptions: Record, m: Record, particle: Record, p: Record, work: Record, turned: Record, out: Record
) -> bool:
    """Write the best equivalent and alignment of a measurement with a region; say whether it is in the gate.

    The likelihood of closed edges decides; midpoints never do, for a partial view moves them.
    """
    z0 = descriptions[0]
    misfit = m.state[0] - z0.state[0] - particle.pose[2]
    turn_map = 0
    if z0.n == 1:
        quarters = int(np.round(misfit / (np.pi / 2))) % 4
    else:
        quarters = 2 * (int(np.round(misfit / np.pi)) % 2)
        if m.n == 1 and np.cos(2 * misfit) < 0.0:
            # z runs along the other axis of a region that so far is a single rectangle: describe that one anew.
            turn_map = 1
    z = descriptions[quarters]
    target = m
    if turn_map:
        turn(m, 1, turned)
        target = turned
        quarters = 2 * (int(np.round((turned.state[0] - z0.state[0] - particle.pose[2]) / np.pi)) % 2)
        z = descriptions[quarters]
    slack = SLACK + particle.cov[0, 0] + particle.cov[1, 1]
    possible = n_closed(z)
    best = -np.inf
    for offset in range(1 - z.n, target.n):
        if not is_admissible(z, target, offset):
            continue
        rows, violation = correspond(z, target, offset, particle.pose, slack, work, p.gate_new)
        if rows < 0 or violation > p.gate_new:
            continue
        distance, log_det = innovate(z, target, rows, particle.cov, work)
        if distance + violation > p.gate_new:
            continue
        score = log_likelihood(distance + violation, log_det, rows, possible, p.log_reference)
        if score > best:
            best = score
            out.offset, out.distance, out.log_likelihood = offset, distance + violation, score
    out.turn, out.turn_map, out.same_type = quarters, turn_map, z0.type == m.type
    return best > -np.inf


@njit
def assign(candidates: Array, associations: Array, measured: Array, taken: Array, p: Record) -> None:
    """Give each measurement the region that explains it best, each region once, the most likely pairs first.

    `taken` is scratch, one number per slot, -1 before and after.
    """
    for z in range(len(measured)):
        associations[z].slot = NEW if can_be_born(measured[z, 0]) else AMBIGUOUS
    open_pairs = np.zeros(len(candidates), np.bool_)
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
        if doubt.same_type and associations[doubt.z].slot == NEW and taken[doubt.slot] < 0:
            associations[doubt.z].slot = AMBIGUOUS
    for c in range(len(candidates)):
        taken[candidates[c].slot] = -1
