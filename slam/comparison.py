"""How well a measurement fits a region: the best of its equivalent descriptions and of the alignments of two rows.

Section II-C of Oberländer et al. 2008: rectangle j of z is rectangle j + offset of m. The paper takes the offset with
the least distance of two midpoints. A partial view moves midpoints, so by default the likelihood of closed edges and
joints decides.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.innovation import (
    DRIFT,
    correspond,
    frame_of,
    innovate,
    is_admissible,
    log_likelihood,
    match_edges,
    midpoint_distance,
)
from slam.jit import Array, Record, lean
from slam.region import b_index, u_index
from slam.turning import turn

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

ALMOST = 1e-9
"""Log likelihoods that differ by less are equal but for rounding."""

NONE = -9
"""No offset."""


@lean
def compare(
    descriptions: Record, m: Record, particle: Record, p: Record, work: Record, turned: Record, out: Record
) -> bool:
    """Write the best equivalent and alignment of a measurement with a region; say whether it is in the gate."""
    return compare_in(frame_of(m, particle.pose), descriptions, m, particle, p, work, turned, out)


@lean
def compare_in(
    frame: Any,
    descriptions: Record,
    m: Record,
    particle: Record,
    p: Record,
    work: Record,
    turned: Record,
    out: Record,
) -> bool:
    """Do what `compare` says; `frame` is `frame_of` the region and the particle's pose."""
    z0 = descriptions[0]
    quarters = int(np.floor((m.state[0] - z0.state[0] - particle.pose[2]) / (np.pi / 2) + 0.5)) & 3
    out.same_type = z0.type == m.type
    if z0.n == 1 and m.n == 1:  # most pairs, and most of them fail at their first edges
        slack = p.tolerance**2 + particle.cov[0, 0] + particle.cov[1, 1]
        z, (c, s, pu, pv) = descriptions[quarters], frame
        rows, violation = match_edges(z, m, 0, c, s, pu, pv, particle.pose[2], slack, work, p.gate_new)
        if rows < 0 or violation > p.gate_new:
            return False
        out.turn, out.turn_map, out.offset = quarters, 0, 0
        out.log_likelihood, out.distance = score(z, m, rows, violation, particle.cov, p, work)
        return out.distance <= p.gate_new
    return compare_rows(descriptions, m, quarters, particle, p, work, turned, out)


@lean
def compare_rows(
    descriptions: Record,
    m: Record,
    quarters: int,
    particle: Record,
    p: Record,
    work: Record,
    turned: Record,
    out: Record,
) -> bool:
    """Compare where either has several rectangles; `quarters` turns bring z along m.

    Of the descriptions of z the one along the axis of m is tried, and, if that does not fit, the one along the other
    axis, with m described anew as well. A row measured across a single rectangle, which is exact in every description,
    is first tried as it is.
    """
    z0 = descriptions[0]
    turns_first = quarters % 2 == 1 and z0.n > 1 and m.n == 1
    best, out.distance = -np.inf, np.inf
    for attempt in range(2):
        turn_map = int((attempt == 0) == turns_first)
        target = m
        if turn_map == 1:
            if not share_centre(z0, m, particle, p):
                continue
            turn(m, 1, turned)
            target = turned
        turns = (quarters + turn_map) % 4
        best = align(descriptions[turns], target, turns, turn_map, particle, p, work, best, out)
        if out.distance < p.gate_associate:
            break
    return best > -np.inf


@lean
def share_centre(z: Record, m: Record, particle: Record, p: Record) -> bool:
    """Say whether the centre of the box around z or m lies in the box around the other, give or take where z is."""
    margin = DRIFT * np.sqrt(p.tolerance**2 + particle.cov[0, 0] + particle.cov[1, 1])
    zu0, zu1, zv0, zv1 = box(z)
    mu0, mu1, mv0, mv1 = box(m)
    turn = m.state[0] - z.state[0] - particle.pose[2]
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    dx, dy = m.anchor[0] - particle.pose[0], m.anchor[1] - particle.pose[1]
    pu, pv = c * dx + s * dy, -s * dx + c * dy
    c, s = np.cos(turn), np.sin(turn)
    u, v = (zu0 + zu1) / 2, (zv0 + zv1) / 2
    u, v = c * u + s * v - pu, -s * u + c * v - pv
    if mu0 - margin < u < mu1 + margin and mv0 - margin < v < mv1 + margin:
        return True
    u, v = (mu0 + mu1) / 2 + pu, (mv0 + mv1) / 2 + pv
    u, v = c * u - s * v, s * u + c * v
    return zu0 - margin < u < zu1 + margin and zv0 - margin < v < zv1 + margin


@lean
def box(region: Record) -> Any:
    """Return the box around a row in its own axes: the least and greatest u, the least and greatest v, m."""
    v0, v1 = region.state[b_index(0)], region.state[b_index(0) + 1]
    for k in range(1, region.n):
        v0, v1 = min(v0, region.state[b_index(k)]), max(v1, region.state[b_index(k) + 1])
    return region.state[u_index(0)], region.state[u_index(region.n)], v0, v1


@lean
def align(
    z: Record,
    m: Record,
    quarters: int,
    turn_map: int,
    particle: Record,
    p: Record,
    work: Record,
    best: float,
    out: Record,
) -> float:
    """Write the alignment of two rows that is more likely than `best` into `out`; return the greater likelihood.

    Closed edges and joints decide. Midpoints do only between alignments that are just as likely, for a partial view
    moves them; or always, with the paper's rule.
    """
    if z.n == 0 or m.n == 0:
        return best
    slack = p.tolerance**2 + particle.cov[0, 0] + particle.cov[1, 1]
    only = nearest_alignment(z, m, particle.pose) if p.by_midpoints else NONE
    nearest = -np.inf
    for offset in range(1 - z.n, m.n):
        if not is_admissible(z, m, offset) or (p.by_midpoints and offset != only):
            continue
        rows, violation = correspond(z, m, offset, particle.pose, slack, work, p.gate_new)
        if rows < 0 or violation > p.gate_new:
            continue
        likelihood, distance = score(z, m, rows, violation, particle.cov, p, work)
        if distance > p.gate_new:
            continue
        apart = midpoint_distance(z, m, offset, particle.pose)
        if likelihood > best + ALMOST or (likelihood > best - ALMOST and apart < nearest):
            best, nearest = likelihood, apart
            out.turn, out.turn_map, out.offset = quarters, turn_map, offset
            out.distance, out.log_likelihood = distance, likelihood
    return best


@lean
def score(z: Record, m: Record, rows: int, violation: float, pose_cov: Array, p: Record, work: Record) -> Any:
    """Return the log likelihood of an alignment and its squared distance, the violation of bounds included."""
    distance, log_det = innovate(z, m, rows, pose_cov, work)
    distance += violation
    return log_likelihood(distance, log_det, rows, p.log_reference), distance


@lean
def nearest_alignment(z: Record, m: Record, pose: Array) -> int:
    """Return the admissible offset with the least distance of two midpoints, section II-C of the paper."""
    chosen, nearest = NONE, np.inf
    for offset in range(1 - z.n, m.n):
        if is_admissible(z, m, offset):
            apart = midpoint_distance(z, m, offset, pose)
            if apart < nearest:
                chosen, nearest = offset, apart
    return chosen
