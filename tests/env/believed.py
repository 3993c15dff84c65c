"""Hand-made beliefs for exact assertions: particle sets with maps of plain rectangles."""

from __future__ import annotations

import numpy as np

from slam.particles import ParticleSet
from slam.region import b_index, u_index


def logit(p):
    return float(np.log(p / (1 - p)))


class Believed:
    """A particle set that is built region by region; all particles share what is put, unless told otherwise."""

    def __init__(self, types=("office", "hallway"), n_particles=1, pose=(0.0, 0.0, 0.0)):
        self.set = ParticleSet.at(np.array(pose, dtype=float), n_particles)
        self.types = list(types)

    def put(self, place, id, type="office", at=(0.0, 0.0), u=(-1.0, 1.0), b=(-1.0,), t=(1.0,), main=0, phi=0.0,
            closed=True, p=0.9, existence=0.8, visited=0, rival=-1, particles=None, sightings=9):  # fmt: skip
        for q in range(len(self.set.particles)) if particles is None else particles:
            region = self.set.regions[q, place]
            region.id, region.type, region.n, region.main = id, self.types.index(type), len(b), main
            region.anchor[:] = at
            region.state[0] = phi
            for k, value in enumerate(u):
                region.state[u_index(k)] = value
            for i in range(len(b)):
                region.state[b_index(i)], region.state[b_index(i) + 1] = b[i], t[i]
            region.closed[:] = closed
            region.type_log_odds, region.existence = logit(p), logit(existence)
            region.visited, region.rival, region.first_link, region.sightings = visited, rival, -1, sightings
            region.radius = 1e3
            self.set.particles[q].n_slots = max(self.set.particles[q].n_slots, place + 1)
        return self

    def remove(self, place):
        self.set.regions[:, place]["n"] = 0
        return self

    def link(self, source, target, kind=0, p=0.9, target_id=None):
        for q, particle in enumerate(self.set.particles):
            region, link = self.set.regions[q, source], self.set.links[q, particle.n_links]
            link.target, link.kind, link.log_odds, link.next = target, kind, logit(p), region.first_link
            link.target_id = self.set.regions[q, target].id if target_id is None else target_id
            region.first_link = particle.n_links
            particle.n_links += 1
        return self
