"""Regions, scans and particles drawn by hand or at random, as the filter's kernels take them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.association import ASSOCIATION, associate
from slam.comparison import CANDIDATE
from slam.config import Parameters, SlamConfig
from slam.edge_form import bounding_radius
from slam.maps import FREE_RECORDS, USED_SLOTS, Maps, cover
from slam.measurement import RegionMeasurement, Scan
from slam.particles import PARTICLE, empty_maps
from slam.region import REGION, EdgeState, Subrectangle
from slam.turning import observe
from tests.slam.naive import random_covariance

OPEN, CLOSED = EdgeState.OPEN, EdgeState.CLOSED
P, PRIORS = SlamConfig().parameters(), SlamConfig().priors()

Records = NDArray[np.void]


def measured(*measurements: RegionMeasurement, types: Sequence[str] = ("office",)) -> Records:
    """A scan in edge form, (M, 4), types numbered as in `types`."""
    scan = Scan(measurements)
    known = [*types, *(t for t in scan.types if t not in types)]
    out = np.zeros((len(scan), 4), REGION)
    observe(scan.records, np.array([known.index(t) for t in scan.types], np.int32), out)
    return out


def mapped(
    state: ArrayLike, anchor: ArrayLike = (0.0, 0.0), cov: ArrayLike | float = 0.01, open_edges: Sequence[int] = ()
) -> np.record:
    """A region of the map; `open_edges` are places in the state vector."""
    state = np.asarray(state, float)
    size = len(state)
    m = np.zeros(1, REGION)[0]
    m.n = (size - 2) // 3
    m.main = m.n // 2
    m.state[:size] = state
    m.anchor[:] = anchor
    m.cov[:size, :size] = np.asarray(cov) if np.ndim(cov) else np.eye(size) * cov
    m.closed[:size] = 1
    for k in open_edges:
        m.closed[k] = 0
        m.cov[k, :] = m.cov[:, k] = 0.0
        m.cov[k, k] = 1e4
    m.radius = bounding_radius(m)
    m.first_link = m.rival = -1
    m.sightings = 1
    return m


def maps(*regions: np.record, particles: int = 1, slots: int = 8) -> Records:
    """The maps (P, slots) of particles that all hold these regions."""
    out = np.zeros((particles, slots), REGION)
    for slot, m in enumerate(regions):
        out[:, slot] = m
        out["id"][:, slot] = m.id or 100 + slot
    return out


def stored(regions: Records) -> Maps:
    """The maps of `maps` as kernels take them: records and regions share their memory, a region of ``n == 0`` is none.

    A slot without regions is free, and so are the records behind it; new regions of one particle take them in order.
    """
    count, slots = regions.shape
    stored = empty_maps(count, slots=slots, records=regions.size, links=64)
    present = regions["n"] > 0
    used = int(np.flatnonzero(present.any(axis=0)).max(initial=-1)) + 1
    stored.table[:] = np.where(present, np.arange(regions.size).reshape(regions.shape), -1)
    stored.holders[:] = present.reshape(-1)
    free = np.flatnonzero(~present.reshape(-1))[::-1]
    stored.free_records[: len(free)] = free
    stored.counts[[USED_SLOTS, FREE_RECORDS]] = used, len(free)
    stored = stored._replace(pool=regions.reshape(-1))
    for slot in range(used):
        stored.slots[slot].id, stored.slots[slot].holders = regions["id"][:, slot].max(), present[:, slot].sum()
        stored.slots[slot].radius = -1.0
        for m in regions[present[:, slot], slot]:
            cover(stored, slot, m)
    return stored


def near(stored: Maps) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All regions of every particle, near or not, with room for eight more; and their numbers."""
    count, slots = stored.table.shape
    out, n = np.zeros((count, slots + 8), np.int64), np.zeros(count, np.int64)
    for i in range(count):
        known = np.flatnonzero(stored.table[i] >= 0)
        n[i] = len(known)
        out[i, : len(known)] = known
    return out, n


def forget_dropped(regions: Records, stored: Maps) -> None:
    """Give the regions that a kernel has dropped ``n == 0``."""
    regions["n"][stored.table < 0] = 0


def particles(pose: ArrayLike = (0.0, 0.0, 0.0), cov: ArrayLike | float = 0.0, count: int = 1) -> Records:
    """Particles at one pose."""
    out = np.zeros(count, PARTICLE)
    out["pose"] = out["expected"] = pose
    out["cov"] = np.asarray(cov) if np.ndim(cov) else np.eye(3) * cov
    return out


def associated(
    robots: Records, regions: Records, scan: Records, p: Parameters = P
) -> tuple[Records, Records, NDArray[np.int64]]:
    """Associations, candidates and their numbers."""
    associations = np.zeros((len(robots), len(scan)), ASSOCIATION)
    candidates = np.zeros((len(robots), 12 * len(scan)), CANDIDATE)
    n_candidates = np.zeros(len(robots), np.int64)
    drawn = stored(regions)
    associate(robots, drawn, *near(drawn), scan, p, associations, candidates, n_candidates)
    return associations, candidates, n_candidates


def links_to(*pairs: tuple[int, int, int, int]) -> Records:
    """Associations (1, M) of (slot, turn, turn_map, offset)."""
    return np.array([list(pairs)], ASSOCIATION)


def random_state(rng: np.random.Generator, n: int) -> NDArray[np.float64]:
    """A row of n rectangles of some metres about its anchor."""
    u = np.cumsum(rng.uniform(1.0, 3.0, n + 1)) - 2.0 * (n + 1) / 2
    b = rng.uniform(-2.0, -0.5, n)
    t = rng.uniform(0.5, 2.0, n)
    out = [rng.uniform(-3.0, 3.0), u[0], u[1], b[0], t[0]]
    for i in range(1, n):
        out += [u[i + 1], b[i], t[i]]
    return np.array(out)


def random_measurement(rng: np.random.Generator, n: int = 3, left: bool = True, **fields: object) -> RegionMeasurement:
    """A row in the robot's frame with covariances of every kind; n = 2 has its subrectangle left or right."""

    def sub() -> Subrectangle:
        w, h, y = rng.uniform(0.5, 3.0), rng.uniform(0.5, 3.0), rng.normal(0.0, 0.3)
        return Subrectangle(w, h, y, cov_wh=random_covariance(rng, 2, 0.1), var_y=rng.uniform(0.005, 0.02))

    x, y = rng.normal(0.0, 3.0, 2)
    w, h = rng.uniform(0.5, 4.0, 2)
    return RegionMeasurement(
        "office",
        x,
        y,
        w,
        h,
        rng.uniform(-1.5, 1.5),
        left=sub() if n == 3 or (n == 2 and left) else None,
        right=sub() if n == 3 or (n == 2 and not left) else None,
        cov_xy=random_covariance(rng, 2, 0.1),
        cov_wh=random_covariance(rng, 2, 0.15),
        var_phi=rng.uniform(0.0005, 0.002),
        **fields,  # type: ignore[arg-type]
    )


def sense(state: NDArray[np.float64], cov: NDArray[np.float64], closed: Sequence[int] | None = None) -> np.record:
    """A measured row given by its lines, as `naive.seen_from` returns them."""
    z = mapped(state)
    size = len(state)
    z.cov[:size, :size] = cov
    if closed is not None:
        z.closed[:size] = closed
    return z
