"""Hand-made beliefs for exact assertions: particle sets with maps of plain rectangles."""

from __future__ import annotations

import numpy as np

from slam.maps import FREE_SLOTS, USED_SLOTS, add, add_link, cover, drop
from slam.particles import ParticleSet
from slam.region import b_index, u_index


def logit(p):
    return float(np.log(p / (1 - p)))


class Believed:
    """A particle set that is built region by region; all particles share what is put, unless told otherwise."""

    def __init__(self, types=("office", "hallway"), n_particles=1, pose=(0.0, 0.0, 0.0)):
        self.set = ParticleSet.at(np.array(pose, dtype=float), n_particles)
        self.types = list(types)

    @property
    def maps(self):
        return self.set.maps

    def region(self, place, particle=0):
        return self.maps.pool[self.maps.table[particle, place]]

    def put(self, place, id, type="office", at=(0.0, 0.0), u=(-1.0, 1.0), b=(-1.0,), t=(1.0,), main=0, phi=0.0,
            closed=True, p=0.9, existence=0.8, visited=0, rival=-1, particles=None, sightings=9):  # fmt: skip
        maps = self.maps
        maps.counts[USED_SLOTS] = max(maps.counts[USED_SLOTS], place + 1)
        if maps.slots[place].holders == 0:
            maps.slots[place].radius = -1.0
        maps.slots[place].id = id
        for q in range(len(self.set.particles)) if particles is None else particles:
            if maps.table[q, place] < 0:
                add(maps, q, place)
            region = self.region(place, q)
            region.id, region.type, region.n, region.main = id, self.types.index(type), len(b), main
            region.anchor[:] = at
            region.state[0] = phi
            for k, value in enumerate(u):
                region.state[u_index(k)] = value
            for i in range(len(b)):
                region.state[b_index(i)], region.state[b_index(i) + 1] = b[i], t[i]
            region.closed[:] = closed
            region.type_log_odds, region.existence = logit(p), logit(existence)
            region.visited, region.rival, region.sightings = visited, rival, sightings
            region.radius = 1e3
            cover(maps, place, region)
        return self

    def remove(self, place, particles=None):
        for q in range(len(self.set.particles)) if particles is None else particles:
            drop(self.maps, q, place)
        self.maps.counts[FREE_SLOTS] = 0  # the places are chosen by hand
        return self

    def link(self, source, target, kind=0, p=0.9, target_id=None):
        for q in range(len(self.set.particles)):
            add_link(self.maps, self.region(source, q))
            link = self.maps.links[self.region(source, q).first_link]
            link.target, link.kind, link.log_odds = target, kind, logit(p)
            link.target_id = self.maps.slots[target].id if target_id is None else target_id
        return self
