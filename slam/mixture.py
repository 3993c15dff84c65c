"""The mixture of all particles: moments of the pose, and where the robot is."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.extent import contains, probability_inside
from slam.grid import search
from slam.jit import Array, njit
from slam.maps import LAYERS, Maps, region_of


@njit
def sum_inside(particles: Array, table: Array, pool: Array, confirmed_after: int, total: Array) -> None:
    """Add up, by slot (S,), the weighted P(robot in region); tentative and outdone regions are left out."""
    for i in range(len(particles)):
        particle = particles[i]
        for slot in range(table.shape[1]):
            if table[i, slot] >= 0:
                m = pool[table[i, slot]]
                if m.rival < 0 and m.sightings >= confirmed_after:
                    total[slot] += np.exp(particle.log_weight) * probability_inside(
                        m, particle.expected, particle.spread
                    )


@njit
def weigh_inside(particles: Array, arrays: tuple[Any, ...], region_type: int, confirmed_after: int) -> float:
    """Return the weight of the particles that are in a credible region of a type (its number)."""
    maps, total = Maps(*arrays), 0.0
    for q in range(len(particles)):
        pose = particles[q].expected
        for slot in search(maps.slots, maps.buckets, maps.counts[LAYERS], pose[0], pose[1], 0.0):
            if maps.table[q, slot] < 0:
                continue
            region = region_of(maps, q, slot)
            credible = region.rival < 0 and region.sightings >= confirmed_after
            if credible and region.type == region_type and contains(region, pose[0], pose[1], 0.0):
                total += np.exp(particles[q].log_weight)
                break
    return total


@njit
def moments(particles: Array, mean: Array, cov: Array) -> Any:
    """Write mean and covariance of the mixture of the particles' proposals; return the index of the heaviest."""
    heaviest = 0
    x, y, c, s = 0.0, 0.0, 0.0, 0.0
    for i in range(len(particles)):
        if particles[i].log_weight > particles[heaviest].log_weight:
            heaviest = i
        w = np.exp(particles[i].log_weight)
        x += w * particles[i].expected[0]
        y += w * particles[i].expected[1]
        c += w * np.cos(particles[i].expected[2])
        s += w * np.sin(particles[i].expected[2])
    mean[0], mean[1], mean[2] = x, y, np.arctan2(s, c)
    cov[:] = 0.0
    offset = np.zeros(3)
    for i in range(len(particles)):
        w = np.exp(particles[i].log_weight)
        offset[0], offset[1] = particles[i].expected[0] - x, particles[i].expected[1] - y
        offset[2] = (particles[i].expected[2] - mean[2] + np.pi) % (2 * np.pi) - np.pi
        for a in range(3):
            for b in range(3):
                cov[a, b] += w * (particles[i].spread[a, b] + offset[a] * offset[b])
    return heaviest
