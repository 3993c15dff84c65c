"""Existence of regions: evidence for those measured, and against those in view that were not."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.extent import contains, point_in_rectangle
from slam.jit import Array, Record, lean
from slam.maps import drop, own, region_of
from slam.semantic_update import SAME_PLACE
from slam.view import is_in_view

LEAST_SHARE = 0.6
"""A region counts as in view when this share of its sample points is."""

SAMPLES = 5
"""Sample points of each rectangle."""

LEAST_ANGLE = 0.2
"""Regions that fill a smaller angle (rad) may well be missed."""

REFUTED = -3.0
"""Log-odds of its type, beside the prior, below which a hypothesis is dropped."""

VIEW_MARGIN = 3.0
"""Points nearer to the end of the view, in tolerances, do not count as seen."""


@lean
def update_existence(
    particles: Array,
    maps: Record,
    near: Array,
    n_near: Array,
    associations: Array,
    candidates: Array,
    n_candidates: Array,
    view: Array,
    p: Record,
) -> None:
    """Update the existence of every region nearby, drop those that ceased to be credible, and note those visited.

    Only a place seen empty counts against a region: not one where a measurement may be of it (`mark_explained`), and
    none where the scan explains no region at all, which tells of the sensor or the pose rather than of the regions.
    """
    explained = maps.marks
    for i in range(len(particles)):
        particle = particles[i]
        mark_explained(explained, candidates[i, : n_candidates[i]], associations[i])
        in_order = False
        for z in range(associations.shape[1]):
            slot = associations[i, z].slot
            if slot >= 0:
                m = own(maps, i, slot)
                in_order |= m.sightings > 1
                m.existence = min(m.existence + p.existence_seen, p.existence_ceiling)
        for j in range(n_near[i]):
            slot = near[i, j]
            m = region_of(maps, i, slot)
            dx, dy = particle.pose[0] - m.anchor[0], particle.pose[1] - m.anchor[1]
            inside = dx * dx + dy * dy < (m.radius + p.tolerance) ** 2
            if inside and not m.visited and contains(m, particle.pose[0], particle.pose[1], p.tolerance):
                m = own(maps, i, slot)
                m.visited = 1
            missing = in_order and explained[slot] < 0 and len(view) > 0
            if missing and is_expected(m, particle.pose, view, p):
                m = own(maps, i, slot)
                m.existence -= p.existence_missed
            explained[slot] = -1
            if m.existence < p.existence_floor or m.type_log_odds - m.type_prior < REFUTED:
                drop(maps, i, slot)


@lean
def mark_explained(explained: Array, candidates: Array, associations: Array) -> None:
    """Set `explained` (S,) to 1 for every region of a particle that a measurement is of, or may be of.

    A measurement of one region may still be of a rival at the same place; one of none, of all that it could be of.
    """
    for z in range(len(associations)):
        if associations[z].slot >= 0:
            explained[associations[z].slot] = 1
    for c in range(len(candidates)):
        pair = candidates[c]
        if associations[pair.z].slot < 0 or (not pair.same_type and pair.distance < SAME_PLACE):
            explained[pair.slot] = 1


@lean
def is_expected(m: Record, pose: Array, view: Array, p: Record) -> bool:
    """Say whether a sensor at `pose` with this view should have measured the region."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    seen, total, margin = 0, 0, VIEW_MARGIN * p.tolerance
    for i in range(m.n):
        for k in range(SAMPLES):
            dx, dy = sample(m, i, k, pose)
            if dx * dx + dy * dy > (0.8 * p.sensor_range) ** 2:
                return False
            total += 1
            if is_in_view(view, c * dx + s * dy, -s * dx + c * dy, margin):
                seen += 1
            elif total - seen > (1 - LEAST_SHARE) * SAMPLES * m.n:
                return False
    return seen >= LEAST_SHARE * total and angle_filled(m, pose, c, s) > LEAST_ANGLE


@lean
def angle_filled(m: Record, pose: Array, c: float, s: float) -> float:
    """Return the angle (rad) that the sample points of a region fill, seen from a pose of heading (c, s)."""
    first, least, most = 0.0, 0.0, 0.0
    for i in range(m.n):
        for k in range(SAMPLES):
            dx, dy = sample(m, i, k, pose)
            angle = np.arctan2(-s * dx + c * dy, c * dx + s * dy)
            if i == 0 and k == 0:
                first = angle
            # From the first point, so that a small region behind the robot doesn't span a full turn.
            angle = (angle - first + np.pi) % (2 * np.pi) - np.pi
            least, most = min(least, angle), max(most, angle)
    return most - least


@lean
def sample(m: Record, i: int, k: int, pose: Array) -> Any:
    """Return the way from a pose to sample point k of rectangle i, its centre or one near a corner, map frame."""
    along = 0.5 if k == 0 else 0.2 + 0.6 * (k % 2)
    across = 0.5 if k == 0 else 0.2 + 0.6 * (k // 3)
    x, y = point_in_rectangle(m, i, along, across)
    return x - pose[0], y - pose[1]
