"""One scan through the filter (Oberländer et al. 2008, section III; Montemerlo et al. 2003), for all particles."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from slam.association import ASSOCIATION, CANDIDATES_PER_MEASUREMENT, associate
from slam.comparison import CANDIDATE
from slam.config import Parameters
from slam.duplicates import resolve_duplicates
from slam.existence import update_existence
from slam.geometric_update import update_geometry
from slam.jit import Array, njit
from slam.lost import contradiction
from slam.maps import Maps, gather, has_room
from slam.near import demand, find_near
from slam.priors import Priors
from slam.proposal import draw, propose
from slam.region import REGION
from slam.resampling import ancestors_of
from slam.semantic_update import begin_types, update_semantics
from slam.topology_update import measured_relations, update_topology
from slam.turning import observe
from slam.weights import normalise, weights


class Seen(NamedTuple):
    """A scan as all particles see it: what was measured, and the regions of each map that it can be of."""

    measured: np.ndarray  # (M, 4) of REGION: every measurement in its equivalent descriptions
    relations: np.ndarray  # (M, M, 4): log-odds of measured links and of containment, and where links are
    near: np.ndarray  # (P, ...): slots
    n_near: np.ndarray  # (P,)
    demand: tuple[int, int]  # records and links that an update takes at most


@njit
def look_up(
    particles: Array,
    arrays: tuple[Any, ...],
    records: Array,
    type_numbers: Array,
    measured_links: Array,
    level: int,
    parameters: tuple[Any, ...],
) -> Any:
    """Return what `Seen` holds."""
    n, maps, p = len(records), Maps(*arrays), Parameters(*parameters)
    measured = np.zeros((n, 4), REGION)
    relations = np.empty((n, n, 4))

    observe(records, type_numbers, measured)
    measured["level"][:] = level
    measured_relations(measured, measured_links, p.tolerance, relations)
    near, n_near = find_near(particles, maps, measured, level, p.sensor_range)
    return measured, relations, near, n_near, demand(maps, near, n_near, relations)


@njit
def update_particles(
    particles: Array,
    arrays: tuple[Any, ...],
    records: Array,
    type_numbers: Array,
    measured_links: Array,
    level: int,
    view: Array,
    normals: Array,
    scan_number: int,
    watchful: bool,
    parameters: tuple[Any, ...],
    prior_arrays: tuple[Any, ...],
) -> tuple[float, float, tuple[int, int]]:
    """Take one scan through the filter, section III of the paper.

    Where the filter is `watchful`, a scan that contradicts the map is not written to it. Where the arrays have no room
    for all that the scan may add, nothing is changed.

    Returns
    -------
    tuple
        The effective sample size, 0 where there was no room; the `contradiction`; `Seen.demand`.
    """
    measured, relations, near, n_near, room = look_up(
        particles, arrays, records, type_numbers, measured_links, level, parameters
    )
    n, maps, p, priors = len(records), Maps(*arrays), Parameters(*parameters), Priors(*prior_arrays)
    if not has_room(maps, n, room[0], room[1]):
        return 0.0, 0.0, room
    associations = np.empty((len(particles), n), ASSOCIATION)
    candidates = np.empty((len(particles), n * CANDIDATES_PER_MEASUREMENT), CANDIDATE)
    n_candidates = np.zeros(len(particles), np.int64)

    associate(particles, maps, near, n_near, measured, p, associations, candidates, n_candidates)
    propose(particles, maps, measured, associations, p)
    draw(particles, normals, p.drawn_share)
    doubt = 0.0
    if watchful:
        doubt = contradiction(particles, maps, near, n_near, associations, candidates, n_candidates, view, p)
    if doubt > 0.0:
        return normalise(particles), doubt, room
    update_semantics(particles, maps, near, n_near, measured, candidates, n_candidates, p, priors)
    update_geometry(particles, maps, near, n_near, measured, associations, scan_number, p)
    begin_types(maps, measured, associations, priors)
    update_topology(particles, maps, associations, relations, p, priors)
    update_existence(particles, maps, near, n_near, associations, candidates, n_candidates, view, p)
    resolve_duplicates(maps, near, n_near, associations, scan_number, p)
    return normalise(particles), doubt, room


@njit
def resample(particles: Array, arrays: tuple[Any, ...], scheme: int, uniforms: Array) -> None:
    """Replace the particles by copies of drawn ancestors, all of one weight; `uniforms` (P,) are drawn from [0, 1)."""
    gather(particles, Maps(*arrays), ancestors_of(weights(particles["log_weight"].copy()), scheme, uniforms))
    for i in range(len(particles)):
        particles[i].log_weight = -np.log(len(particles))
