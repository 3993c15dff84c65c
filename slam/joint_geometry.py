"""Geometric update of one hypothesis: a scan as rows of its joint Gaussian, and records that are its marginals.

A record of `REGION` mirrors the marginal of a region's heading and closed edges, so that all that reads maps works on
it; its open edges are kept in the record alone, as bounds (`slam.geometric_update`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.association import NEW
from slam.comparison import CANDIDATE
from slam.duplicates import agree, inherit, join, outranks, supplant
from slam.edge_form import bounding_radius, state_size
from slam.geometric_update import begin, settle_open_edges
from slam.growth import LEAST_SIZE, forget_edge, grow, keep_order, take_row
from slam.innovation import frame_of, workspaces, wrap
from slam.jit import Array, Record, njit
from slam.joint_gaussian import FLAT, POSE, JointGaussian, follow_shift, follow_turn, marginalise, release
from slam.joint_rows import relative_covariance, write_rows, write_twin_rows
from slam.joint_update import Rows, condition
from slam.maps import Maps, cover, drop, own, region_of
from slam.particles import PARTICLE
from slam.region import MAX_STATE, REGION
from slam.turning import turn


@njit
def explain(
    joint: Record,
    maps: Record,
    particle: int,
    near: Array,
    n_near: Array,
    measured: Array,
    associations: Array,
    born: Array,
    scan_number: int,
    rows: Record,
    p: Record,
) -> Any:
    """Write the rows of all measurements that a hypothesis explains or begins a region with.

    Returns how many they are, and of how many measurements of known regions.

    Bounds are pushed, rectangles added and regions begun on the way, as `update_geometry` does for a certain pose. A
    new region's slot goes into `associations` (M,) and `near` (K + M,).
    """
    turned = np.zeros_like(measured[:1, 0])
    pose = joint.mean[:POSE].copy()
    n, known = 0, 0
    for j in range(len(measured)):
        a = associations[j]
        if a.slot >= 0:
            m = own(maps, particle, a.slot)
            describe_anew(joint, a.slot, m, a.turn_map, turned[0])
            z, slot = measured[j, a.turn], a.slot
            offset = widen(joint, slot, z, m, a.offset, pose, p.tolerance)
            known += 1
            m.sightings += 1
            m.last_seen = scan_number
        elif a.slot == NEW:
            z, offset = measured[j, 0], 0
            slot = begin(maps, particle, born, j, z, pose, scan_number, p)
            m = own(maps, particle, slot)
            joint.anchors[slot] = m.anchor
            a.slot = near[particle, n_near[particle]] = slot
            n_near[particle] += 1
        else:
            continue
        n = write_rows(z, m, offset, joint, slot, n, rows)
    return n, known


@njit
def describe_anew(joint: Record, slot: int, m: Record, quarters: int, turned: Record) -> None:
    """Turn the description of a region by quarters of a full turn."""
    if quarters:
        turn(m, quarters, turned)
        follow_turn(joint, slot, m, turned, quarters)
        take_row(turned, m)


@njit
def widen(joint: Record, slot: int, z: Record, m: Record, offset: int, pose: Array, tolerance: float) -> Any:
    """Give a region the rectangles and closed edges that only z has, and push its bounds; return the new offset.

    Edges that reopen leave the joint Gaussian.
    """
    for k in range(-offset):
        follow_shift(joint, slot, m.n + k)
    offset = grow(z, m, offset)
    _, _, pu, pv = frame_of(m, pose)
    settle_open_edges(z, m, offset, pu, pv, tolerance**2)
    for k in range(MAX_STATE):
        if joint.entries[slot, k] >= 0 and not m.closed[k]:
            release(joint, joint.entries[slot, k])
            joint.entries[slot, k] = -1
    return offset


@njit
def see_from_pose(joint: Record, maps: Record, particle: int, near: Array, n_near: int) -> None:
    """Write into the records of regions nearby what their covariances are as seen from the pose."""
    for k in range(n_near):
        relative_covariance(own(maps, particle, near[k]), joint, near[k])


@njit
def mirror(joint: Record, maps: Record, particle: int, tolerance: float) -> None:
    """Write the marginals of all regions into their records."""
    for slot in range(len(joint.entries)):
        if joint.entries[slot, 0] >= 0 and maps.table[particle, slot] >= 0:
            m = own(maps, particle, slot)
            write_marginal(joint, slot, m, tolerance)
            cover(maps, slot, m)


@njit
def write_marginal(joint: Record, slot: int, m: Record, tolerance: float) -> None:
    """Write the marginal of a region into its record."""
    entries = joint.entries[slot]
    size = state_size(m.n)
    for a in range(size):
        if entries[a] < 0:
            forget_edge(m, a, m.cov[a, a] if m.cov[a, a] > 0.0 else FLAT)
    for a in range(size):
        if entries[a] >= 0:
            m.state[a] = joint.mean[entries[a]]
            for b in range(a + 1):
                if entries[b] >= 0:
                    m.cov[a, b] = m.cov[b, a] = joint.cov[entries[a], entries[b]]
    m.state[0] = wrap(m.state[0])
    keep_order(m, LEAST_SIZE * tolerance)
    m.radius = bounding_radius(m)


@njit
def forget_absent(joint: Record, maps: Record, particle: int) -> None:
    """Marginalise the regions that the hypothesis has dropped."""
    for slot in range(len(joint.entries)):
        if joint.entries[slot, 0] >= 0 and maps.table[particle, slot] < 0:
            marginalise(joint, slot)


def merge_twins(joint: JointGaussian, maps: Maps, particle: int, younger: int, older: int, p: Any) -> None:
    """Make one region of two of a type, under the older identity: an update with the statement that they are one.

    If they contradict each other, the geometry with more edges and sightings is kept. The caller has made room.
    """
    rows = Rows.empty(MAX_STATE)
    count, offset = lay_over(joint, maps, particle, younger, older, p, rows)
    if count and condition(joint, rows.first(count), p.gate_associate)[0] < p.gate_associate:
        rows = Rows.empty(MAX_STATE)
        count = take_over(joint, maps, particle, younger, older, offset, p, rows)
        condition(joint, rows.first(count))
        join(maps.pool[maps.table[particle, younger]], maps.pool[maps.table[particle, older]])
    else:
        keep_better(joint, maps, particle, younger, older, p)
    leave(joint, maps, particle, younger, older, p.tolerance)


@njit
def lay_over(joint: Record, maps: Record, particle: int, younger: int, older: int, p: Record, rows: Record) -> Any:
    """Describe twins alike and write the rows of their common edges; return number (0: they disagree) and offset."""
    scratch, candidate, stand = np.zeros(5, REGION), np.zeros(1, CANDIDATE), np.zeros(1, PARTICLE)
    a, b = own(maps, particle, younger), own(maps, particle, older)
    if not agree(a, b, p, workspaces(p.tolerance), scratch, candidate[0], stand):
        return 0, 0
    chosen = candidate[0]
    describe_anew(joint, younger, a, chosen.turn, scratch[4])
    describe_anew(joint, older, b, chosen.turn_map, scratch[4])
    return write_twin_rows(a, b, chosen.offset, joint, younger, older, p.tolerance, rows), chosen.offset


@njit
def take_over(
    joint: Record, maps: Record, particle: int, younger: int, older: int, offset: int, p: Record, rows: Record
) -> int:
    """Give the older twin what only the younger has, and write the rows of their common edges anew."""
    a, b = own(maps, particle, younger), own(maps, particle, older)
    write_marginal(joint, younger, a, p.tolerance)
    write_marginal(joint, older, b, p.tolerance)
    pose = np.array([a.anchor[0], a.anchor[1], 0.0])
    offset = widen(joint, older, a, b, offset, pose, p.tolerance)
    return write_twin_rows(a, b, offset, joint, younger, older, p.tolerance, rows)


@njit
def keep_better(joint: Record, maps: Record, particle: int, younger: int, older: int, p: Record) -> None:
    """Let the older of two twins that contradict each other take the younger's geometry where it is the better one."""
    a, b = own(maps, particle, younger), own(maps, particle, older)
    if outranks(a, b, p):
        take_row(a, b)
        supplant(a, b)
        joint.anchors[older] = a.anchor
        marginalise(joint, older)
        joint.entries[older] = joint.entries[younger]
        joint.entries[younger] = -1


@njit
def leave(joint: Record, maps: Record, particle: int, younger: int, older: int, tolerance: float) -> None:
    """Drop the younger twin, after the older has inherited what is not geometry, and mirror the rest."""
    inherit(region_of(maps, particle, younger), own(maps, particle, older))
    drop(maps, particle, younger)
    marginalise(joint, younger)
    mirror(joint, maps, particle, tolerance)
