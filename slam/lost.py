"""Is the filter lost? Scans speak for and against it until the sum is sure (Page 1954, cumulative sum test).

On the map a region in view is measured, and a measurement is of some region. On a new floor the second does not hold,
and where regions are missed or misnamed the first fails now and then. Both fail scan after scan only where the robot is
not where it believes to be. Without a view the filter cannot tell.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.existence import is_expected, mark_explained
from slam.jit import Array, Record, lean
from slam.maps import region_of

FOUND = float(np.log(0.2 / 0.7))
"""Log-likelihood ratio, lost to not lost, of a region that was measured: by chance, or because it is there."""

MISSING = float(np.log(0.8 / 0.3))
"""Log-likelihood ratio of a region in view that was not measured."""

MOST = 4.0
"""Largest weight of one scan: what makes one region go unseen does so for its neighbours, too."""

LOST = 10.0
"""Sum of log-likelihood ratios from which the filter is lost."""


@lean
def contradiction(
    particles: Array,
    maps: Record,
    near: Array,
    n_near: Array,
    associations: Array,
    candidates: Array,
    n_candidates: Array,
    view: Array,
    p: Record,
) -> float:
    """Return the log-likelihood ratio, lost to not lost, of a scan for the particle that it contradicts least.

    A scan that measures nothing tells nothing; one that is explained for the most part is not looked at any further.
    """
    measurements = associations.shape[1]
    if len(view) == 0 or measurements == 0:
        return 0.0
    least = MOST
    for i in range(len(particles)):
        found = count_found(maps, i, associations, p)
        ratio = FOUND * found
        if 2 * found < measurements:
            missing = count_missing(
                particles[i], maps, i, near, n_near, associations, candidates[i, : n_candidates[i]], view, p
            )
            ratio += MISSING * missing
        least = min(least, ratio)
    return max(least, -MOST)


@lean
def count_found(maps: Record, particle: int, associations: Array, p: Record) -> Any:
    """Return how many confirmed regions the scan measures."""
    found = 0
    for z in range(associations.shape[1]):
        slot = associations[particle, z].slot
        found += slot >= 0 and region_of(maps, particle, slot).sightings >= p.confirmed_after
    return found


@lean
def count_missing(
    robot: Record,
    maps: Record,
    particle: int,
    near: Array,
    n_near: Array,
    associations: Array,
    candidates: Array,
    view: Array,
    p: Record,
) -> Any:
    """Return how many confirmed regions in view no measurement can be of."""
    explained, missing = maps.marks, 0
    mark_explained(explained, candidates, associations[particle])
    for j in range(n_near[particle]):
        slot = near[particle, j]
        m = region_of(maps, particle, slot)
        counts = explained[slot] < 0 and m.sightings >= p.confirmed_after and m.rival < 0
        missing += counts and is_expected(m, robot.pose, view, p)
        explained[slot] = -1
    return missing
