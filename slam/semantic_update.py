"""Semantic update: how credible a region's type is (Oberländer et al. 2008, eqs. 7–13)."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.edge_form import state_size
from slam.extent import area
from slam.innovation import n_closed
from slam.jit import Array, Record, lean, njit
from slam.maps import own, region_of
from slam.region import b_index, u_index
from slam.turning import turn

LIMIT = 10.0
"""Log-odds are clamped to ±LIMIT, so that a belief can always be revised."""

SAME_PLACE = 25.0
"""Squared Mahalanobis distance below which a measurement of another type can be of the same place."""

OPPOSING_COVER = 0.5
"""Share of a region that a measurement of another type must cover to be one of the same place."""


@njit
def update_semantics(
    particles: Array,
    maps: Record,
    near: Array,
    n_near: Array,
    measured: Array,
    candidates: Array,
    n_candidates: Array,
    p: Record,
    priors: Record,
) -> None:
    """Sum the evidence for and against every region's type and apply eq. (13).

    The relevant measurements of a region, eq. (8), are those that could be measurements of the same place if type were
    ignored: the candidates of data association that overlap it. To oppose it, one must also cover most of it within a
    narrow gate: neither is a desk evidence against the office around it, nor a glimpse of the office against the desk.
    The prior enters once, when the region is born, so (13) is applied to an inverse model completed with it.
    """
    turned, evidence = np.zeros_like(measured[:1, 0]), np.empty((near.shape[1], 4))
    weigh_evidence(particles, maps, near, n_near, measured, candidates, n_candidates, turned[0], evidence, p, priors)


@lean
def weigh_evidence(
    particles: Array,
    maps: Record,
    near: Array,
    n_near: Array,
    measured: Array,
    candidates: Array,
    n_candidates: Array,
    turned: Record,
    evidence: Array,
    p: Record,
    priors: Record,
) -> None:
    """Do what `update_semantics` says.

    Scratch: `turned`, a `REGION`, and `evidence`, for each region nearby the sum and number of what supports it and of
    what opposes it, shape (K, 4).
    """
    place = maps.marks
    for i in range(len(particles)):
        for j in range(n_near[i]):
            place[near[i, j]] = j
            evidence[j] = 0.0
        for c in range(n_candidates[i]):
            pair = candidates[i, c]
            if pair.distance < p.gate_associate:
                m, z = region_of(maps, i, pair.slot), measured[pair.z, pair.turn]
                if pair.turn_map:
                    turn(m, 1, turned)
                    m = turned
                column = 0 if pair.same_type else 2
                share, covered = covered_share(z, m, pair.offset, particles[i].pose)
                opposes = pair.distance < SAME_PLACE and covered > OPPOSING_COVER * area(m)
                if share > 0.0 and (pair.same_type or opposes):
                    evidence[place[pair.slot], column] += z.confidence * share
                    evidence[place[pair.slot], column + 1] += 1
        for j in range(n_near[i]):
            slot = near[i, j]
            place[slot] = -1
            supporting, n_supporting, opposing, n_opposing = evidence[j]
            if n_supporting + n_opposing > 0:
                p_supp = supporting / n_supporting if n_supporting > 0 else 0.5  # eq. (9)
                p_opp = opposing / n_opposing if n_opposing > 0 else 0.5  # eq. (10)
                believe(own(maps, i, slot), p_supp, p_opp, priors)


@lean
def believe(m: Record, p_supp: float, p_opp: float, priors: Record) -> None:
    """Apply eq. (13) to a region.

    The prior p(m) is part of the log-odds from birth on; if the region has grown into another one, that replaces it.
    Read literally, the prior is subtracted at every scan, and hypotheses run off to either limit unless it is 0.5.
    """
    prior = prior_log_odds(m, priors)
    gain = p_supp - p_opp + prior - m.type_prior
    if priors.literal:
        gain -= prior
    m.type_log_odds = min(max(m.type_log_odds + gain, -LIMIT), LIMIT)
    m.type_prior = prior


@lean
def begin_types(maps: Record, measured: Array, associations: Array, priors: Record) -> None:
    """Begin the belief in the types of all regions that this scan has begun."""
    for i in range(len(associations)):
        for z in range(len(measured)):
            slot = associations[i, z].slot
            if slot >= 0 and region_of(maps, i, slot).sightings == 1:
                be_born(own(maps, i, slot), measured[z, 0].confidence, priors)


@lean
def be_born(m: Record, confidence: float, priors: Record) -> None:
    """Give a new region its prior and the support of its first measurement, which it covers."""
    m.type_log_odds = m.type_prior = prior_log_odds(m, priors)
    believe(m, confidence, 0.5, priors)


@lean
def prior_log_odds(m: Record, priors: Record) -> Any:
    """Return the log-odds of p(m), the prior of a region of this type and these dimensions."""
    types = priors.types
    k = min(m.type, len(types) - 1)
    inside, outside = types[k, 0], types[k, 3]
    if inside != outside:
        size, least, largest = area(m), types[k, 1], types[k, 2]
        if size > largest or (size < least and is_whole(m)):
            return outside
    return inside


@lean
def is_whole(m: Record) -> bool:
    """Say whether all edges of a region were seen."""
    return n_closed(m) == state_size(m.n)


@lean
def covered_share(z: Record, m: Record, offset: int, pose: Array) -> Any:
    """Return overlap(z, m), eq. (11): the share of z's area inside m, along m's axes; and that area, m².

    m is taken with the measurement's own uncertainty (two standard deviations), or thin regions would be refuted by
    supporting scans, and without limit where its edges are open.
    """
    c, s = np.cos(m.state[0]), np.sin(m.state[0])
    dx, dy = m.anchor[0] - pose[0], m.anchor[1] - pose[1]
    pu, pv = c * dx + s * dy, -s * dx + c * dy
    z_area, covered = 0.0, 0.0
    for j in range(z.n):
        left, right = u_index(j), u_index(j + 1)
        bottom = b_index(j)
        z_left, z_right = z.state[left] - pu, z.state[right] - pu
        z_bottom, z_top = z.state[bottom] - pv, z.state[bottom + 1] - pv
        z_area += (z_right - z_left) * (z_top - z_bottom)
        k = j + offset
        if k < 0 or k >= m.n:
            continue
        m_bottom = b_index(k)
        width = min(z_right, _limit(z, m, right, u_index(k + 1), 1)) - max(z_left, _limit(z, m, left, u_index(k), -1))
        height = min(z_top, _limit(z, m, bottom + 1, m_bottom + 1, 1)) - max(
            z_bottom, _limit(z, m, bottom, m_bottom, -1)
        )
        covered += max(width, 0.0) * max(height, 0.0)
    return (min(covered / z_area, 1.0) if z_area > 0.0 else 0.0), covered


@lean
def _limit(z: Record, m: Record, i: int, j: int, outward: int) -> Any:
    """Return how far m may reach at its edge j when edge i of z is as uncertain as it says."""
    if not m.closed[j]:
        return outward * np.inf
    return m.state[j] + outward * 2 * np.sqrt(z.cov[i, i] + m.cov[j, j])
