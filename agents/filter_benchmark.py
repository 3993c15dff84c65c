"""Speed of the filter alone: over particles, measurements and the size of the map, part by part, and its memory.

The floor is a lattice of rooms. One particle maps it from known poses; every filter that is timed starts from that map,
which its particles share until they write to it. They then stand in the middle and measure the nearest rooms.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

from agents.benchmark import timed
from agents.recording import record
from slam import Odometry, RegionMeasurement, RegionSLAM, Scan, SlamConfig
from slam.association import ASSOCIATION, CANDIDATES_PER_MEASUREMENT, associate
from slam.comparison import CANDIDATE
from slam.duplicates import resolve_duplicates
from slam.existence import update_existence
from slam.fastslam import NO_VIEW
from slam.geometric_update import update_geometry
from slam.jit import Array, Record, njit
from slam.maps import FREE_RECORDS
from slam.particles import ParticleSet
from slam.proposal import draw, propose
from slam.scan_update import Seen, look_up
from slam.semantic_update import update_semantics
from slam.topology_update import update_topology

PARTICLES = (1, 4, 16, 100, 1000)
MEASUREMENTS = (1, 12, 30)
REGIONS = (30, 1000, 10_000)

WIDE, DEEP = 6.0, 5.0
"""Distances of the rooms, m."""
TYPES = 5
SIGHTINGS = 4
STILL = Odometry(0.0)


class Floor:
    """Rooms of 5.5 x 4.5 m in a lattice about the origin; the type of each is one of `TYPES`.

    Parameters
    ----------
    regions
        Number of rooms: those nearest to the origin.
    """

    def __init__(self, regions: int) -> None:
        half = int(np.ceil(np.sqrt(regions))) + 1
        columns, rows = np.meshgrid(np.arange(-half, half + 1), np.arange(-half, half + 1))
        places = np.stack([1.0 + WIDE * columns.ravel(), 0.7 + DEEP * rows.ravel()], axis=1)
        nearest = np.argsort(np.hypot(*places.T), kind="stable")[:regions]
        self.places, self._cells = places[nearest], (columns.ravel() + 3 * rows.ravel())[nearest] % TYPES

    def scan(self, rooms: np.ndarray, x: float = 0.0, y: float = 0.0) -> Scan:
        """Return what an exact sensor at (x, y), heading along x, measures of some rooms."""
        return Scan(
            [
                RegionMeasurement(f"type {self._cells[k]}", self.places[k, 0] - x, self.places[k, 1] - y, 5.5, 4.5)
                for k in rooms
            ]
        )

    def seen_from(self, x: float, y: float, count: int) -> np.ndarray:
        """Return the numbers of the rooms nearest to (x, y)."""
        return np.argsort(np.hypot(self.places[:, 0] - x, self.places[:, 1] - y), kind="stable")[:count]


@cache
def mapped(regions: int) -> tuple[Floor, RegionSLAM]:
    """Return a floor, and a filter of one particle that has mapped all of it."""
    floor = Floor(regions)
    slam = RegionSLAM(SlamConfig(n_particles=1), seed=0)
    order = np.lexsort((floor.places[:, 0], np.floor(floor.places[:, 1] / (4 * DEEP))))  # strips of the floor
    for rooms in np.array_split(order, int(np.ceil(regions / 24))):
        x, y = floor.places[rooms].mean(axis=0)
        for _ in range(SIGHTINGS):
            slam.step(STILL, floor.scan(rooms, x, y), pose=(x, y, 0.0))
    slam.step(STILL, Scan(), pose=(0.0, 0.0, 0.0))
    return floor, slam


def standing(particles: int, regions: int) -> tuple[Floor, RegionSLAM]:
    """Return a floor, and a filter of so many particles that knows it and stands in its middle."""
    floor, mapper = mapped(regions)
    slam = RegionSLAM(SlamConfig(n_particles=particles), seed=0)
    slam.take_map(mapper)
    return floor, slam


def stepping(particles: int, measurements: int, regions: int) -> Callable[[int], None]:
    """Return a function that takes a number of scans of the nearest rooms through a filter."""
    floor, slam = standing(particles, regions)
    scan = floor.scan(floor.seen_from(0.0, 0.0, measurements))

    def run(steps: int) -> None:
        for _ in range(steps):
            slam.step(STILL, scan)

    run(3)  # records are the particles' own from now on
    return run


def time_steps(particles: int, measurements: int, regions: int, repeats: int = 8, seconds: float = 0.08) -> float:
    """Return the time of one step, µs: the median of the repeats on a quiet machine."""
    run = stepping(particles, measurements, regions)
    count = _steps_for(run, seconds)
    durations, quiet = timed(lambda: run(count), repeats)
    return 1e6 * float(np.median(durations[quiet])) / count


def map_size_ratio(measurements: int = 12, particles: int = 4, repeats: int = 24) -> float:
    """Return the time of a step on the largest map over that on the smallest, same view, turn by turn in one run."""
    runs = [stepping(particles, measurements, regions) for regions in (REGIONS[0], REGIONS[-1])]
    count = _steps_for(runs[0], 0.05)
    times = np.empty((repeats, 2))
    for k in range(repeats):
        for j in (0, 1) if k % 2 else (1, 0):
            start = time.perf_counter()
            runs[j](count)
            times[k, j] = time.perf_counter() - start
    return float(np.median(times[:, 1] / times[:, 0]))


def _steps_for(run: Callable[[int], None], seconds: float) -> int:
    start = time.perf_counter()
    run(2)
    return max(2, int(2 * seconds / (time.perf_counter() - start)))


def memory(particles: int = PARTICLES[-1], regions: int = REGIONS[-1], steps: int = 120) -> dict[str, float]:
    """Drive with noise across the largest map with the most particles; return what their maps then take, MB.

    `megabytes` is all arrays, free room included, `used_megabytes` the records in use, and `unshared_megabytes` what
    maps of their own would take.
    """
    floor, slam = standing(particles, regions)
    rng = np.random.default_rng(0)
    distance = 0.5
    for k in range(1, steps + 1):
        x = k * distance
        rooms = floor.seen_from(x, 0.0, 12)
        noisy = floor.scan(rooms, x + rng.normal(0.0, 0.03), rng.normal(0.0, 0.03))
        slam.step(Odometry(distance + rng.normal(0.0, 0.02), 0.0, rng.normal(0.0, 0.005)), noisy)
    maps = slam.belief.maps
    used = len(maps.pool) - int(maps.counts[FREE_RECORDS])
    return {
        "megabytes": sum(array.nbytes for array in maps) / 1e6,
        "used_megabytes": used * maps.pool.itemsize / 1e6,
        "unshared_megabytes": float(np.count_nonzero(maps.table >= 0)) * maps.pool.itemsize / 1e6,
        "records": used,
        "driven": steps * distance,
    }


def by_part(particles: int = 4, measurements: int = 12, regions: int = 30, steps: int = 300) -> dict[str, float]:
    """Return the time of each part of an update, µs, called one by one; the cost of a call from Python is taken out."""
    floor, slam = standing(particles, regions)
    scan = floor.scan(floor.seen_from(0.0, 0.0, measurements))
    slam.step(STILL, scan)
    cloud, p, priors = slam.posterior.cloud, slam.config.parameters(), slam.config.priors()
    types = np.array([slam.belief.types.index(name) for name in scan.types], np.int64)
    spent: dict[str, list[float]] = {}
    for number in range(10_000, 10_000 + steps):
        arrays = tuple(cloud.maps)
        seen = Seen(*_timed(spent, "look up", look_up, cloud.particles, arrays, scan.records, types, scan.links, 0, p))
        cloud.make_room(slots=measurements, records=seen.demand[0], links=seen.demand[1])
        for name, part, arguments in _parts(cloud, seen, number, p, priors):
            _timed(spent, name, part, *arguments)
        _timed(spent, "a call", weigh_nothing, cloud.particles, cloud.maps, seen.near, seen.n_near, seen.measured, p)
    times = {name: 1e6 * float(np.median(values)) for name, values in spent.items()}
    call = times.pop("a call")
    return {name: max(0.0, value - call) for name, value in times.items()}


def _timed(spent: dict[str, list[float]], name: str, part: Callable[..., Any], *arguments: Any) -> Any:
    start = time.perf_counter()
    result = part(*arguments)
    spent.setdefault(name, []).append(time.perf_counter() - start)
    return result


def _parts(
    cloud: ParticleSet, seen: Seen, number: int, p: Any, priors: Any
) -> Iterator[tuple[str, Any, tuple[Any, ...]]]:
    """Yield the parts of `scan_update.update_particles` in order, with their arguments."""
    particles, maps = cloud.particles, cloud.maps
    near, n_near, measured = seen.near, seen.n_near, seen.measured
    n, m = len(particles), len(measured)
    links = np.empty((n, m), ASSOCIATION)
    candidates, counts = np.empty((n, m * CANDIDATES_PER_MEASUREMENT), CANDIDATE), np.zeros(n, np.int64)
    yield "association", associate, (particles, maps, near, n_near, measured, p, links, candidates, counts)
    yield "proposal", propose, (particles, maps, measured, links, p)
    yield "draw", draw, (particles, np.zeros((n, 3)), p.drawn_share)
    yield "semantics", update_semantics, (particles, maps, near, n_near, measured, candidates, counts, p, priors)
    yield "geometry", update_geometry, (particles, maps, near, n_near, measured, links, number, p)
    yield "topology", update_topology, (particles, maps, links, seen.relations, p, priors)
    yield "existence", update_existence, (particles, maps, near, n_near, links, candidates, counts, NO_VIEW, p)
    yield "duplicates", resolve_duplicates, (maps, near, n_near, links, number, p)


@njit
def weigh_nothing(particles: Array, maps: Record, near: Array, n_near: Array, measured: Array, p: Record) -> int:
    """Do nothing with the arguments of a part: what is left is the cost of the call."""
    return len(particles)


def benchmark_filter(tell: Callable[[str], None] = lambda line: None) -> dict[str, Any]:
    """Return all figures; `tell` hears a line for each as they come.

    Returns
    -------
    dict
        ``update_us`` (4 particles, 12 measurements, 30 regions), ``map_size_ratio``, ``particles_1000_hz`` (updates per
        second of 1,000 particles, 12 measurements, 30 regions), ``parts_us``, ``table`` (rows of particles,
        measurements, regions, microseconds), ``memory``, and ``tour_us`` on real scans.
    """
    table = []
    for particles in PARTICLES:
        for regions in REGIONS:
            for measurements in MEASUREMENTS:
                spent = time_steps(particles, measurements, regions)
                table.append({"particles": particles, "measurements": measurements, "regions": regions, "us": spent})
                tell(f"{particles:>5} particles {measurements:>3} measurements {regions:>6} regions {spent:>10.1f} µs")
    at = {(row["particles"], row["measurements"], row["regions"]): row["us"] for row in table}
    return {
        "update_us": at[4, 12, 30],
        "map_size_ratio": map_size_ratio(),
        "particles_1000_hz": 1e6 / at[1000, 12, 30],
        "parts_us": by_part(),
        "memory": memory(),
        **on_the_tour(),
        "table": table,
    }


def on_the_tour(particles: int = 4, steps: int = 600) -> dict[str, float]:
    """Return the mean time of a step on the first scans of the institute's tour, µs, and their number of regions."""
    tour = record(0, steps=steps)
    first = RegionSLAM(SlamConfig(n_particles=particles), seed=0)
    for odometry, scan in zip(tour.moves[:200], tour.scans[:200], strict=True):
        first.step(odometry, scan)  # compiles what the lattice of rooms has not
    slam = RegionSLAM(SlamConfig(n_particles=particles), seed=0)
    start = time.perf_counter()
    for odometry, scan in zip(tour.moves, tour.scans, strict=True):
        slam.step(odometry, scan)
    seconds = time.perf_counter() - start
    return {"tour_us": 1e6 * seconds / steps, "tour_measurements": float(np.mean([len(scan) for scan in tour.scans]))}
