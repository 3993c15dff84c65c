"""Regions that explain one place: twins of one type are merged, hypotheses of several types are ranked."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.comparison import CANDIDATE, compare
from slam.extent import area, contains, overlap, point_in_rectangle
from slam.geometric_update import fuse_as_set
from slam.growth import take_row
from slam.innovation import n_closed, workspaces
from slam.jit import Array, Record, lean, njit
from slam.maps import cover, drop, own, region_of
from slam.particles import PARTICLE
from slam.region import MAX_STATE, REGION
from slam.turning import turn

MARGIN, LARGEST_MARGIN = 3.0, 1 / 25
"""Centres within this distance (tolerances, but at most that share of the sensor's range) of the other region make two
regions candidates for one place. The noisiest sensor does not move desks that stand back to back on either side of a
wall into each other."""

TWIN_OVERLAP = 0.5
"""Share of the smaller of two regions of one type from which they cannot both be there."""


@njit
def resolve_duplicates(
    maps: Record, near: Array, n_near: Array, associations: Array, scan_number: int, p: Record
) -> None:
    """Compare regions just measured with their neighbours; merge twins and rank rivals."""
    for i in range(len(associations)):
        for z in range(associations.shape[1]):
            if is_due(maps, i, associations, z, scan_number, p):
                twins = find_twins(maps, i, associations[i, z].slot, near, n_near, scan_number, p)
                if len(twins) > 0:
                    merge_twins(maps, i, twins, p)
        settle_rivals(maps, i, near, n_near, p)


@lean
def is_due(maps: Record, i: int, associations: Array, z: int, scan_number: int, p: Record) -> Any:
    """Say whether this scan compares the region that measurement z is of with its neighbours.

    Each scan looks at one of its regions in turn, for duplicates need no answer within a tenth of a second, and at
    those that it confirms, for the robot may leave before it is their turn.
    """
    slot = associations[i, z].slot
    if slot < 0 or maps.table[i, slot] < 0:
        return False
    return z == scan_number % associations.shape[1] or region_of(maps, i, slot).sightings == p.confirmed_after


@njit
def merge_twins(maps: Record, i: int, twins: Array, p: Record) -> None:
    """Make one region of each pair of twins, (younger, older) slots (k, 2), in the map of particle i."""
    work, scratch = workspaces(p.tolerance), np.zeros(5, REGION)
    candidate, stand = np.zeros(1, CANDIDATE), np.zeros(1, PARTICLE)
    for younger, older in twins:
        kept = own(maps, i, older)
        merge(region_of(maps, i, younger), kept, p, work, scratch, candidate[0], stand)
        cover(maps, older, kept)
        drop(maps, i, younger)


@njit
def find_twins(maps: Record, i: int, slot: int, near: Array, n_near: Array, scan_number: int, p: Record) -> Any:
    """Compare a region just measured with its neighbours; rank rivals, return twins, (younger, older) slots (k, 2)."""
    twins, n, margin = np.empty((n_near[i], 2), np.int64), 0, margin_of(p)
    for j in range(n_near[i]):
        other = near[i, j]
        if other == slot or maps.table[i, other] < 0:
            continue
        a, b = region_of(maps, i, slot), region_of(maps, i, other)
        if not share_place(a, b, margin):
            continue
        if a.type != b.type:
            if are_rivals(a, b, margin):
                rank(maps, i, slot, other, p)
        elif b.last_seen != scan_number and are_twins(a, b, margin):
            # Two regions of one scan are two regions, so only an unseen one can be the twin.
            twins[n] = (other, slot) if a.id < b.id else (slot, other)
            n += 1
            if b.id < a.id:
                break
    return twins[:n]


@lean
def settle_rivals(maps: Record, particle: int, near: Array, n_near: Array, p: Record) -> None:
    """Settle the rivalries of all regions nearby."""
    for j in range(n_near[particle]):
        slot = near[particle, j]
        if maps.table[particle, slot] >= 0 and region_of(maps, particle, slot).rival >= 0:
            settle_rivalry(maps, particle, slot, p)


@lean
def settle_rivalry(maps: Record, particle: int, slot: int, p: Record) -> None:
    """Free a hypothesis whose rival is gone or has lost its lead."""
    m = region_of(maps, particle, slot)
    # The slot of the rival may be free or hold another region by now.
    gone = maps.table[particle, m.rival] < 0
    if not gone:
        rival = region_of(maps, particle, m.rival)
        gone = not are_rivals(m, rival, margin_of(p)) or leads(m, rival, p)
    if gone:
        own(maps, particle, slot).rival = -1


@lean
def margin_of(p: Record) -> float:
    """Return how far apart two estimates of one place may be beyond its bounds, m."""
    return min(MARGIN * p.tolerance, LARGEST_MARGIN * p.sensor_range)


@lean
def share_place(a: Record, b: Record, margin: float) -> Any:
    """Say whether the centre of either main rectangle lies in the other region, give or take `margin` m."""
    dx, dy = a.anchor[0] - b.anchor[0], a.anchor[1] - b.anchor[1]
    reach = a.radius + b.radius
    if dx * dx + dy * dy > reach * reach:
        return False
    x, y = point_in_rectangle(a, a.main, 0.5, 0.5)
    if contains(b, x, y, margin):
        return True
    x, y = point_in_rectangle(b, b.main, 0.5, 0.5)
    return contains(a, x, y, margin)


@lean
def are_rivals(a: Record, b: Record, margin: float) -> bool:
    """Say whether two regions are hypotheses for one place: two types, alike in size, around each other."""
    return a.type != b.type and coincide(a, b, margin)


@lean
def coincide(a: Record, b: Record, margin: float) -> bool:
    """Say whether two regions are alike in size, each around the other's centre."""
    size_a, size_b = area(a), area(b)
    if min(size_a, size_b) < 0.5 * max(size_a, size_b):
        return False
    xa, ya = point_in_rectangle(a, a.main, 0.5, 0.5)
    xb, yb = point_in_rectangle(b, b.main, 0.5, 0.5)
    return contains(b, xa, ya, margin) and contains(a, xb, yb, margin)


@lean
def leads(a: Record, b: Record, p: Record) -> bool:
    """Say whether a is more credible than b: confirmed before tentative, then by log-odds, then by sightings."""
    a_confirmed, b_confirmed = a.sightings >= p.confirmed_after, b.sightings >= p.confirmed_after
    if a_confirmed != b_confirmed:
        return a_confirmed
    if a.type_log_odds != b.type_log_odds:
        return a.type_log_odds > b.type_log_odds
    return a.sightings > b.sightings


@lean
def rank(maps: Record, particle: int, first: int, second: int, p: Record) -> None:
    """Mark the less credible of two hypotheses for one place as outdone by the other."""
    ahead = leads(region_of(maps, particle, first), region_of(maps, particle, second), p)
    better, worse = (first, second) if ahead else (second, first)
    if region_of(maps, particle, worse).rival != better:
        own(maps, particle, worse).rival = better
    if region_of(maps, particle, better).rival == worse:
        own(maps, particle, better).rival = -1


@lean
def are_twins(a: Record, b: Record, margin: float) -> bool:
    """Say whether two regions of one type take the same place, which no two real ones do.

    It is a question of metres, not of covariances: those leave out how far the particle drifted between its visits.
    """
    return coincide(a, b, margin) or overlap(a, b) > TWIN_OVERLAP * min(area(a), area(b))


@lean
def merge(
    younger: Record, older: Record, p: Record, work: Array, descriptions: Array, candidate: Record, stand: Array
) -> None:
    """Make one region of two of a type, under the older identity.

    Given the trajectory the two estimates are independent, so the younger one is taken as a measurement made from its
    anchor. If they contradict each other, only one of them is there, and it alone counts.
    """
    if agree(younger, older, p, work, descriptions, candidate, stand):
        if candidate.turn_map:
            turn(older, 1, descriptions[4])
            take_row(descriptions[4], older)
        fuse_as_set(descriptions[candidate.turn], older, candidate.offset, stand[0].pose, work[0], p)
        join(younger, older)
    elif outranks(younger, older, p):
        take_row(younger, older)
        supplant(younger, older)
    inherit(younger, older)


@lean
def agree(
    younger: Record, older: Record, p: Record, work: Array, descriptions: Array, candidate: Record, stand: Array
) -> bool:
    """Write how the younger of two twins, measured from its anchor, describes the older; say whether they agree.

    `work`, `descriptions` and `stand` are scratch: one `WORKSPACE`, five of `REGION` and one `PARTICLE`.
    """
    stand[0].pose[0], stand[0].pose[1], stand[0].pose[2] = younger.anchor[0], younger.anchor[1], 0.0
    for quarters in range(4):
        turn(younger, quarters, descriptions[quarters])
        for k in range(1, MAX_STATE):
            if descriptions[quarters].closed[k] == 0 and not p.paper_update:
                descriptions[quarters].cov[k, k] = 0.0
    alike = compare(descriptions, older, stand[0], p, work[0], descriptions[4], candidate)
    return alike and candidate.distance < p.gate_associate


@lean
def inherit(younger: Record, older: Record) -> None:
    """Give the older of two twins what is true of the younger in any case."""
    older.last_seen = max(older.last_seen, younger.last_seen)
    older.visited = max(older.visited, younger.visited)


@lean
def join(younger: Record, older: Record) -> None:
    """Count the sightings and the evidence of two twins that agree together."""
    older.sightings += younger.sightings
    older.existence = max(older.existence, younger.existence)
    if younger.type_log_odds > older.type_log_odds:
        older.type_log_odds, older.type_prior = younger.type_log_odds, younger.type_prior


@lean
def supplant(younger: Record, older: Record) -> None:
    """Let only the sightings and the evidence of the younger count."""
    older.sightings, older.existence = younger.sightings, younger.existence
    older.type_log_odds, older.type_prior = younger.type_log_odds, younger.type_prior


@lean
def outranks(a: Record, b: Record, p: Record) -> bool:
    """Say whether a, and not b, is there: it is confirmed, has more edges, was seen more often or, if neither, last."""
    if min(a.sightings, b.sightings) < p.confirmed_after:
        return (a.sightings, a.last_seen, n_closed(a)) > (b.sightings, b.last_seen, n_closed(b))
    return (n_closed(a), a.sightings) > (n_closed(b), b.sightings)
