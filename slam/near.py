"""Which regions a scan can touch, for every particle, and how much room an update of them needs at most."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.grid import search
from slam.jit import Array, Record, lean, njit
from slam.maps import ADJACENT, INSIDE, LAYERS

LEEWAY = 1 / 4
"""Regions this far beyond the farthest measurement, in ranges of the sensor, are near, too."""


@njit
def find_near(particles: Array, maps: Record, measured: Array, level: int, sensor_range: float) -> Any:
    """List, for every particle, the slots of its regions of a level that the scan can touch.

    Returns the slots (P, K + M), ascending, with room for as many new regions as there are measurements, and their
    numbers (P,).
    """
    n, m = len(particles), len(measured)
    leeway = LEEWAY * sensor_range
    reach = leeway
    for z in range(m):
        reach = max(reach, leeway + measured[z, 0].radius)
    x, y = 0.0, 0.0
    for i in range(n):
        x, y = x + particles[i].pose[0] / n, y + particles[i].pose[1] / n
    widest = 0.0
    for i in range(n):
        dx, dy = particles[i].pose[0] - x, particles[i].pose[1] - y
        widest = max(widest, np.sqrt(dx * dx + dy * dy) + reach + uncertainty(particles[i]))
    around = search(maps.slots, maps.buckets, maps.counts[LAYERS], x, y, widest)
    near, n_near = np.empty((n, len(around) + m), np.int64), np.zeros(n, np.int64)
    for i in range(n):
        pose, own_reach = particles[i].pose, reach + uncertainty(particles[i])
        for slot in around:
            record = maps.table[i, slot]
            if record >= 0:
                region = maps.pool[record]
                dx, dy, limit = region.anchor[0] - pose[0], region.anchor[1] - pose[1], own_reach + region.radius
                if region.level == level and dx * dx + dy * dy < limit * limit:
                    near[i, n_near[i]] = slot
                    n_near[i] += 1
    return near, n_near


@lean
def uncertainty(particle: Record) -> float:
    """Return five standard deviations of a particle's position, m."""
    return 5.0 * np.sqrt(particle.cov[0, 0] + particle.cov[1, 1])


@lean
def count_links(relations: Array) -> int:
    """Return how many links a scan can begin (`topology_update.update_topology`)."""
    count = 0
    for z in range(len(relations)):
        for other in range(len(relations)):
            count += relations[z, other, ADJACENT] != 0.0
            count += relations[z, other, INSIDE] > 0.0
    return count


@lean
def demand(maps: Record, near: Array, n_near: Array, relations: Array) -> Any:
    """Return how many records and links an update can take at most: copies of what is shared, and all that is new."""
    n, new_links = len(relations), count_links(relations)
    records, links = len(near) * n, len(near) * new_links
    for i in range(len(near)):
        for k in range(n_near[i]):
            record = maps.table[i, near[i, k]]
            if maps.holders[record] > 1:
                records += 1
                links += maps.pool[record].n_links
    return records, links
