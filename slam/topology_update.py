"""Topological and hierarchical updates (Oberländer et al. 2008, eqs. 14–18)."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.association import bounding_circles
from slam.contact import contact, nearest_edge
from slam.extent import area
from slam.jit import Array, Record, lean, njit
from slam.maps import ADJACENT, INSIDE, add_link, drop_stale_links, own, region_of
from slam.overlap import rows_overlap
from slam.region import b_index, u_index
from slam.semantic_update import LIMIT

SAME_CONTACT = 5.0
"""Contacts nearer than this, in tolerances, are one, whichever edge is the nearest: neighbours may lie in a corner."""

ONE_PLACE = 0.5
"""Measurements that share more than this part of the larger one take the same place."""

LEAST = 0.01
"""Probabilities are clamped to [LEAST, 1 - LEAST] before log-odds are taken."""


@lean
def logit(probability: float) -> Any:
    """Return the log-odds of a clamped probability."""
    clamped = min(max(probability, LEAST), 1 - LEAST)
    return np.log(clamped / (1 - clamped))


@njit
def measured_relations(measured: Array, links: Array, tolerance: float, relations: Array) -> None:
    """Fill `relations` (M, M, 4) with the log-odds of measured links and of containment, and where links are.

    The entries `ADJACENT` and `INSIDE` are p(z_m -> z_n) and eq. (18) as log-odds, zero where nothing is known; the
    last two the contact on z_m, m in the robot's frame. Linked measurements are neighbours, so neither contains the
    other. Of two that take one place, or are of one type, (18) says nothing: they are hypotheses, or a view too small
    to tell.
    """
    n = len(measured)
    relations[:] = 0.0
    for k in range(len(links)):
        i, j = links[k].source, links[k].target
        relations[i, j, ADJACENT] = known_log_odds(links[k].confidence)
        relations[i, j, 2], relations[i, j, 3] = contact(measured[i, 0], measured[j, 0], tolerance)
    shared, size = shared_areas(measured)
    outside = known_log_odds(0.0)
    for i in range(n):
        for j in range(n):
            apart = measured[i, 0].type != measured[j, 0].type and shared[i, j] <= ONE_PLACE * max(size[i], size[j])
            if i != j and apart:
                linked = relations[i, j, ADJACENT] != 0.0 or relations[j, i, ADJACENT] != 0.0
                inside = 0.0 if linked else shared[i, j] / size[i] * min((size[j] / size[i]) ** 2, 1.0)
                relations[i, j, INSIDE] = known_log_odds(inside) if inside > 0.0 else outside


@njit
def shared_areas(measured: Array) -> Any:
    """Return what every two measurements have in common, shape (M, M), and the area of each, (M,); m²."""
    n = len(measured)
    u, b, t = np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 3))
    shared, size = np.zeros((n, n)), np.empty(n)
    share(measured, bounding_circles(measured), u, b, t, shared, size)
    return shared, size


@lean
def share(measured: Array, circles: Array, u: Array, b: Array, t: Array, shared: Array, size: Array) -> None:
    """Write what `shared_areas` returns; `u` (M, 4), `b` and `t` (M, 3) are scratch."""
    for i in range(len(measured)):
        z = measured[i, 0]
        for k in range(z.n + 1):
            u[i, k] = z.state[u_index(k)]
        for k in range(z.n):
            b[i, k], t[i, k] = z.state[b_index(k)], z.state[b_index(k) + 1]
        size[i] = area(z)
        for j in range(i):
            other = measured[j, 0]
            dx, dy, reach = circles[i, 0] - circles[j, 0], circles[i, 1] - circles[j, 1], circles[i, 2] + circles[j, 2]
            if dx * dx + dy * dy > reach * reach:
                continue
            phi, phi_j = z.state[0], other.state[0]
            shared[i, j] = shared[j, i] = rows_overlap(
                0.0, 0.0, phi, u[i], b[i], t[i], z.n, 0.0, 0.0, phi_j, u[j], b[j], t[j], other.n
            )


@lean
def known_log_odds(probability: float) -> Any:
    """Return log-odds that are not mistaken for nothing: one half is evidence, too."""
    log_odds = logit(probability)
    return log_odds if log_odds != 0.0 else 1e-12


@lean
def gain(kind: int, evidence: float, first_type: int, second_type: int, priors: Record) -> Any:
    """Return what a scan that measured both regions adds to the log-odds of a link, eqs. (14), (16), (17).

    Not to see a link never speaks for it. (18) knows no prior, so that is not subtracted unless (17) is read literally.
    """
    prior = prior_of(kind, first_type, second_type, priors)
    if kind == ADJACENT:
        return (evidence if evidence != 0.0 else min(priors.link_unseen, prior)) - prior
    if evidence == 0.0:
        return 0.0
    return evidence - prior if priors.literal else evidence


@lean
def prior_of(kind: int, first_type: int, second_type: int, priors: Record) -> Any:
    """Return the prior log-odds of a link between regions of two types, p(m -> n) or p(m < n)."""
    table = priors.links if kind == ADJACENT else priors.children
    last = len(table) - 1
    return table[min(first_type, last), min(second_type, last)]


@njit
def update_topology(
    particles: Array, maps: Record, associations: Array, relations: Array, p: Record, priors: Record
) -> None:
    """Update the beliefs in links between all regions of which the scan measured both, eqs. (16) and (17).

    A link is remembered from its first measurement on, at every edge of its region by itself, a containment from the
    first time that it is more likely than not. Where either region was not measured nothing changes, eq. (15).
    """
    n = associations.shape[1]
    known, places = np.empty((n, 2), np.bool_), np.empty((n, 2))
    news, ends = beginnings(relations)
    update_links(particles, maps, associations, relations, news, ends, known, places, p, priors)


@lean
def update_links(
    particles: Array,
    maps: Record,
    associations: Array,
    relations: Array,
    news: Array,
    ends: Array,
    known: Array,
    places: Array,
    p: Record,
    priors: Record,
) -> None:
    """Do what `update_topology` says; `news` and `ends` are `beginnings`, `known` and `places` (M, 2) scratch."""
    n, measured_as = associations.shape[1], maps.marks
    for i in range(len(associations)):
        pose = particles[i].pose
        c, s = np.cos(pose[2]), np.sin(pose[2])
        for z in range(n):
            if associations[i, z].slot >= 0:
                measured_as[associations[i, z].slot] = z
        for z in range(n):
            slot, first = associations[i, z].slot, ends[z - 1] if z > 0 else 0
            if slot >= 0 and (ends[z] > first or region_of(maps, i, slot).first_link >= 0):
                m = own(maps, i, slot)
                known[:] = False
                locate(relations[z], pose[0], pose[1], c, s, places)
                drop_stale_links(maps, i, m)
                revise(maps, i, m, relations[z], places, measured_as, known, p, priors)
                for k in range(first, ends[z]):
                    other, kind = news[k, 0], news[k, 1]
                    target = associations[i, other].slot
                    if target >= 0 and target != slot and not known[other, kind]:
                        second_type = maps.pool[maps.table[i, target]].type
                        value = relations[z, other, kind]
                        remember(maps, m, target, second_type, kind, value, places[other], priors)
        for z in range(n):
            if associations[i, z].slot >= 0:
                measured_as[associations[i, z].slot] = -1


@njit
def beginnings(relations: Array) -> Any:
    """Return what can begin links: other measurement and kind, (k, 2), and (M,) where those of each measurement end."""
    n, count = len(relations), 0
    news, ends = np.empty((2 * n * n, 2), np.int64), np.empty(n, np.int64)
    for z in range(n):
        for other in range(n):
            for kind in range(2):
                if begins_link(relations[z, other, kind], kind):
                    news[count, 0], news[count, 1] = other, kind
                    count += 1
        ends[z] = count
    return news, ends


@lean
def begins_link(evidence: float, kind: int) -> bool:
    """Say whether what was measured of two regions is enough to remember a link: a containment must be likely."""
    return evidence > 0.0 or (kind == ADJACENT and evidence != 0.0)


@lean
def locate(relations: Array, x0: float, y0: float, c: float, s: float, places: Array) -> None:
    """Write the contacts of one measurement's links in the map frame, from (x0, y0) and heading (c, s).

    Of `places` (M, 2) only the rows of what is adjacent are written.
    """
    for i in range(len(relations)):
        if relations[i, ADJACENT] != 0.0:
            x, y = relations[i, 2], relations[i, 3]
            places[i, 0], places[i, 1] = x0 + c * x - s * y, y0 + s * x + c * y


@lean
def revise(
    maps: Record,
    particle: int,
    m: Record,
    relations: Array,
    places: Array,
    measured_as: Array,
    known: Array,
    p: Record,
    priors: Record,
) -> None:
    """Update the links that a region already has; mark in `known` (M, 2) those that the scan measured."""
    index = m.first_link
    while index >= 0:
        link = maps.links[index]
        other = measured_as[link.target]
        if other >= 0:
            value = relations[other, link.kind]
            if link.kind == ADJACENT and value != 0.0:
                if is_at(m, link.place, places[other], SAME_CONTACT * p.tolerance):
                    link.place[0], link.place[1] = places[other, 0], places[other, 1]
                else:
                    value = 0.0  # it was measured at another edge
            if value != 0.0:
                known[other, link.kind] = True
            change = gain(link.kind, value, m.type, maps.pool[maps.table[particle, link.target]].type, priors)
            link.log_odds = min(max(link.log_odds + change, -LIMIT), LIMIT)
        index = maps.next_links[index]


@lean
def is_at(m: Record, place: Array, other: Array, nearness: float) -> bool:
    """Say whether two contacts are the same or lie at one edge of a region."""
    if (place[0] - other[0]) ** 2 + (place[1] - other[1]) ** 2 < nearness**2:
        return True
    return nearest_edge(m, place[0], place[1])[0] == nearest_edge(m, other[0], other[1])[0]


@lean
def remember(
    maps: Record, m: Record, target: int, second_type: int, kind: int, evidence: float, place: Array, priors: Record
) -> None:
    """Add a link: its prior and its first evidence."""
    link = add_link(maps, m)
    link.target, link.target_id, link.kind = target, maps.slots[target].id, kind
    if kind == ADJACENT:
        link.place[0], link.place[1] = place[0], place[1]
    else:
        link.place[0] = link.place[1] = 0.0
    first = prior_of(kind, m.type, second_type, priors) + gain(kind, evidence, m.type, second_type, priors)
    link.log_odds = min(max(first, -LIMIT), LIMIT)
