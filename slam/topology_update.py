"""Topological and hierarchical updates (Oberländer et al. 2008, eqs. 14–18)."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.jit import Array, Record, njit
from slam.maps import ADJACENT, INSIDE, add_link, drop_stale_links, own
from slam.overlap import rows_overlap
from slam.region import b_index, u_index
from slam.semantic_update import LIMIT

LEAST = 0.01
"""Probabilities are clamped to [LEAST, 1 - LEAST] before log-odds are taken."""


@njit
def logit(probability: float) -> Any:
    """Return the log-odds of a clamped probability."""
    clamped = min(max(probability, LEAST), 1 - LEAST)
    return np.log(clamped / (1 - clamped))


@njit
def measured_relations(measured: Array, links: Array, evidence: Array) -> None:
    """Fill `evidence` (M, M, 2) with the log-odds of measured links and of containment.

    They are p(z_m -> z_n) and, where z_m overlaps z_n, eq. (18); zero means nothing was measured. Two linked
    measurements are neighbours, so neither is the other's child.
    """
    n = len(measured)
    evidence[:] = 0.0
    for k in range(len(links)):
        # A confidence of exactly one half is a measured link too, so it must not be 0.
        evidence[links[k].source, links[k].target, ADJACENT] = logit(links[k].confidence) + 1e-12
    u, b, t = np.zeros((n, 4)), np.zeros((n, 3)), np.zeros((n, 3))
    area = np.zeros(n)
    for i in range(n):
        z = measured[i, 0]
        for k in range(z.n + 1):
            u[i, k] = z.state[u_index(k)]
        for k in range(z.n):
            b[i, k], t[i, k] = z.state[b_index(k)], z.state[b_index(k) + 1]
            area[i] += (u[i, k + 1] - u[i, k]) * (t[i, k] - b[i, k])
    for i in range(n):
        for j in range(n):
            # (18) is above one half only for the smaller of two.
            if (
                i == j
                or area[i] > area[j]
                or evidence[i, j, ADJACENT] != 0.0
                or measured[i, 0].type == measured[j, 0].type
            ):
                continue
            zi, zj = measured[i, 0], measured[j, 0]
            shared = rows_overlap(
                0.0, 0.0, zi.state[0], u[i], b[i], t[i], zi.n, 0.0, 0.0, zj.state[0], u[j], b[j], t[j], zj.n
            )
            if shared > 0.0:
                evidence[i, j, INSIDE] = logit(shared / area[i] * min((area[j] / area[i]) ** 2, 1.0))


@njit
def update_topology(maps: Record, associations: Array, evidence: Array, p: Record) -> None:
    """Update the beliefs in links between all regions of which the scan measured both, eqs. (16) and (17).

    A link is remembered from its first measurement on. Where either region was not measured nothing changes, eq. (15).
    """
    n = associations.shape[1]
    measured_as = maps.marks
    known = np.zeros((n, 2), np.bool_)
    for i in range(len(associations)):
        for z in range(n):
            if associations[i, z].slot >= 0:
                measured_as[associations[i, z].slot] = z
        for z in range(n):
            slot = associations[i, z].slot
            if slot >= 0:
                m = own(maps, i, slot)
                known[:] = False
                revise(maps, i, m, z, measured_as, evidence, known, p)
                for other in range(n):
                    target = associations[i, other].slot
                    for kind in range(2):
                        if (
                            target >= 0
                            and target != slot
                            and evidence[z, other, kind] != 0.0
                            and not known[other, kind]
                        ):
                            remember(maps, m, target, kind, evidence[z, other, kind], p)
        for z in range(n):
            if associations[i, z].slot >= 0:
                measured_as[associations[i, z].slot] = -1


@njit
def revise(
    maps: Record, particle: int, m: Record, z: int, measured_as: Array, evidence: Array, known: Array, p: Record
) -> None:
    """Update the links that a region already has; mark in `known` those to regions of this scan."""
    drop_stale_links(maps, particle, m)
    index = m.first_link
    while index >= 0:
        link = maps.links[index]
        other = measured_as[link.target]
        if other >= 0:
            known[other, link.kind] = True
            value = evidence[z, other, link.kind]
            if link.kind == ADJACENT:
                gain = (value if value != 0.0 else p.link_unseen) - p.prior_link
            else:
                gain = value if value != 0.0 else logit(0.0)
            link.log_odds = min(max(link.log_odds + gain, -LIMIT), LIMIT)
        index = link.next


@njit
def remember(maps: Record, m: Record, target: int, kind: int, evidence: float, p: Record) -> None:
    """Add a link with its first evidence to the prior."""
    link = add_link(maps, m)
    link.target, link.target_id, link.kind = target, maps.slots[target].id, kind
    link.log_odds = evidence if kind == ADJACENT else p.prior_child + evidence
