"""The region sensor: the regions in view, as far as they are in view, with noise on every parameter.

It reports the rows that the floor is annotated with, cut to what is visible: an edge is closed if enough of it is seen,
else it lies where the view ends and is open. The noise is drawn on the parameters of Fig. 1 in Oberländer et al. 2008.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import NoiseConfig, SensorConfig
from regionslam_env.geometry import NearbyIndex, cast, ray_angles, ray_directions, segment_boxes
from regionslam_env.sensors.distortion import distort
from regionslam_env.sensors.normals import Normals
from regionslam_env.sensors.partial_row import DRAWS, cut_row, turn_part, visible_run, write_part
from regionslam_env.sensors.sight import SIGHT, look, out_of_view, turn_rays
from regionslam_env.simulation.movers import Movers
from regionslam_env.worlds.world import WorldArrays
from slam.jit import lean, njit
from slam.measurement import LINK, MEASUREMENT, Scan
from slam.rows import MAX_RECTANGLES

_BLOCK = 4096  # normal numbers drawn at a time

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SOURCE = np.dtype((np.record, [("region", np.int64), ("first", np.int64), ("turned", np.int64)]))
"""Where a measurement comes from: index of the true region, of its rectangle that the measurement begins with (in the
order of the true row), and whether it describes them turned by pi. An invented measurement has region -1."""

ROBOT = np.zeros((1, 2))
"""First corner of a view that is narrower than a full turn."""


class RegionSensor:
    """Measures regions within its range, in the robot's frame.

    Parameters
    ----------
    config
        Range, field of view, occlusion, what counts as seen.
    noise
        Told standard deviations, and by what factor the simulated variances differ.
    arrays
        Of the world.
    rng
        The sensor's own generator.
    movers
        What moves: closed doors hide regions as walls do, and furniture is measured where it stands now.

    Attributes
    ----------
    sightings
        How often each true region has been in view since the reset, shape (R,); for metrics alone.
    sources
        Where the measurements of the last scan come from, an array of `SOURCE`; for metrics alone.
    normals
        The noise to come.
    """

    def __init__(
        self,
        config: SensorConfig,
        noise: NoiseConfig,
        arrays: WorldArrays,
        rng: np.random.Generator,
        movers: Movers | None = None,
    ) -> None:
        self._noise, self._confidence, self._movers = noise, config.confidence, movers
        self._rows, self._types = np.asarray(arrays.rows).view(np.ndarray), arrays.types
        self._walls = arrays.walls if config.occlusion else np.zeros((0, 4))
        near_walls, self._near_rows, starts, neighbours = _near_lists(arrays, config.range)
        self._near_walls = near_walls if config.occlusion else NearbyIndex(self._walls, config.range)
        self._fixed_walls, self._occlusion = len(self._walls), config.occlusion
        if movers is not None:
            self._rows = _frozen(self._rows.copy())
            self._walls = _frozen(np.concatenate([self._walls, movers.doors.segments]))
        self._most_links = int(np.diff(starts).max(initial=0))
        self._n_rays = config.n_view_rays
        in_view = np.abs(ray_angles(self._n_rays)) <= config.field_of_view / 2 + 1e-9
        # Only with the robot itself, then the rays in sight, are the corners of a narrower view in order of angle.
        self._sighted = None if in_view.all() else np.flatnonzero(in_view)
        self._given = (
            self._walls,
            self._rows,
            ray_directions(self._n_rays),
            in_view.astype(np.float64),
            (config.range, config.edge_tolerance, config.closed_length),
            (noise.regions.sigma_xy, noise.regions.sigma_wh, noise.regions.sigma_phi, noise.regions.full_size),
            math.sqrt(noise.simulated_factor),
            config.confidence,
            starts,
            neighbours,
            config.link_confidence,
        )
        size = len(self._rows)
        self._room = np.zeros(self._n_rays), np.zeros(size, SOURCE), np.full(size, -1, np.int64)
        self._records, self._links = np.zeros(size, MEASUREMENT), np.zeros(size * self._most_links, LINK)
        self._counts = np.zeros(2, np.int64)
        self._distorted: tuple[Scan, Ints] | None = None
        self.normals = Normals(max(_BLOCK, DRAWS * size))
        self.reset(rng)

    def reset(self, rng: np.random.Generator, keep_sightings: bool = False) -> None:
        """Start a new episode with a generator of its own, and count the sightings anew unless they are kept."""
        self._rng = rng
        self.normals.begin(rng)
        if not keep_sightings:
            self.sightings = np.zeros(len(self._rows), np.int64)
        self._counts[:], self._distorted = 0, None

    @property
    def sources(self) -> NDArray[np.void]:
        """Where the measurements of the last scan come from, shape (M,), a copy."""
        numbers = np.arange(self._counts[0]) if self._distorted is None else self._distorted[1]
        found = self._room[1][numbers]
        found["region"][numbers < 0] = -1
        return found

    @property
    def scan(self) -> Scan:
        """The last scan; a copy, but for one with mistakes in it."""
        return self._exact_scan() if self._distorted is None else self._distorted[0]

    def _exact_scan(self) -> Scan:
        """Return the last scan before anything is missed or invented."""
        count, links = self._counts.tolist()
        view = np.empty((self._n_rays, 2))
        outline(self._given[2], self._room[0], view)
        if self._sighted is not None:
            view = np.concatenate((ROBOT, view[self._sighted]))
        return Scan.from_records(self._records[:count].copy(), self._types, self._links[:links].copy(), view)

    def measure(self, pose: NDArray[np.float64]) -> Scan:
        """Return what is seen from a true pose x (m), y (m), theta (rad), shape (3,)."""
        x, y, theta = pose.tolist()
        near_walls, nearby = self._near(x, y)
        self._counts[:] = sense(
            x,
            y,
            theta,
            near_walls,
            nearby,
            self._given,
            self._room,
            self.normals.ahead(len(nearby) * DRAWS),
            self.sightings,
            self._records,
            self._links,
        )
        self.normals.used[0] += self._counts[0] * DRAWS
        if not self.is_exact:
            self._distorted = distort(self._exact_scan(), self._noise, self._confidence, self._rng)
        return self.scan

    @property
    def is_exact(self) -> bool:
        """Whether every region in view is measured, with its own type, and nothing else."""
        noise = self._noise
        return not (noise.misclassification or noise.misses or noise.false_positives)

    @property
    def sees_all_around(self) -> bool:
        """Whether the field of view is a full turn."""
        return self._sighted is None

    @property
    def measured(self) -> int:
        """How many regions the last measurement holds."""
        return int(self._counts[0])

    @property
    def types(self) -> tuple[str, ...]:
        """What the type of a measurement indexes."""
        return self._types

    @property
    def settings(self) -> tuple[Any, ...]:
        """What all sensors of this configuration have in common, as kernels take it.

        Directions of the rays and which are open, limits, told noise, gain, confidence of types and of links.
        """
        return (*self._given[2:8], self._given[10])

    @property
    def surroundings(self) -> tuple[NDArray[Any], ...]:
        """Walls and regions of the world, each with the lists of those that are near, and who is whose neighbour."""
        near = (*self._near_walls.cells, self._rows, *self._near_rows.cells)
        return (self._walls, *near, *self._given[8:10])

    @property
    def room(self) -> tuple[NDArray[Any], ...]:
        """What a measurement writes: rays, sources, scratch for places, sightings, records, links, and their counts."""
        return (*self._room, self.sightings, self._records, self._links, self._counts)

    def _near(self, x: float, y: float) -> tuple[Ints, Ints]:
        """Return the indices of walls and regions that may be within range, after a look at what has moved."""
        near_walls, nearby, movers = self._near_walls.near(x, y), self._near_rows.near(x, y), self._movers
        if movers is None:
            return near_walls, nearby
        if self._occlusion:
            near_walls = np.concatenate((near_walls, self._fixed_walls + np.flatnonzero(movers.doors.closed)))
        if len(movers.regions):
            self._rows.flags.writeable = True
            self._rows[movers.regions] = movers.rows
            _frozen(self._rows)
            nearby = np.union1d(nearby, movers.regions)
        return near_walls, nearby


@njit
def sense(
    x: float,
    y: float,
    theta: float,
    near_walls: Ints,
    nearby: Ints,
    given: Any,
    room: tuple[Floats, NDArray[np.void], Ints],
    normals: Floats,
    sightings: Ints,
    records: NDArray[np.void],
    links: NDArray[np.void],
) -> tuple[int, int]:
    """Write rays, measurements and links, and count the sightings; return how many measurements and links there are.

    `given` is what the sensor and its world are, and `room` holds the lengths of its rays, 0 outside the field of view,
    the measurements' sources and their places; for each of these, and the other arguments, see `cast`, `scan_regions`
    and `write_links`.
    """
    walls, rows, directions, open_rays, limits, told, gain, confidence, starts, neighbours, link_confidence = given
    ranges, sources, slots = room
    cast(x, y, theta, limits[0], directions, walls, near_walls, ranges)
    for k in range(len(ranges)):
        ranges[k] *= open_rays[k]
    scratch = (
        np.empty((2, len(ranges))),
        np.empty((MAX_RECTANGLES, SIGHT)),
        np.empty(MAX_RECTANGLES + 1),
        np.empty(MAX_RECTANGLES),
        np.empty(MAX_RECTANGLES),
        np.empty(2 + 2 * MAX_RECTANGLES, np.int64),
    )
    count = scan_regions(
        x,
        y,
        theta,
        rows,
        nearby,
        directions,
        ranges,
        limits,
        told,
        gain,
        confidence,
        normals,
        scratch,
        sources,
        records,
    )
    for k in range(count):
        sightings[sources[k].region] += 1
    return count, write_links(sources, count, starts, neighbours, link_confidence, slots, links)


@lean
def outline(directions: Floats, ranges: Floats, view: Floats) -> None:
    """Write where rays in these directions (2, n) and of these lengths end, shape (n, 2)."""
    for k in range(ranges.shape[0]):
        view[k, 0], view[k, 1] = directions[0, k] * ranges[k], directions[1, k] * ranges[k]


@lean
def scan_regions(
    x: float,
    y: float,
    theta: float,
    rows: NDArray[np.void],
    nearby: Ints,
    directions: Floats,
    ranges: Floats,
    limits: tuple[float, float, float],
    told: tuple[float, float, float, float],
    gain: float,
    confidence: float,
    normals: Floats,
    scratch: tuple[Any, ...],
    sources: NDArray[np.void],
    records: NDArray[np.void],
) -> int:
    """Write a measurement of every region in view; return how many.

    Parameters
    ----------
    x, y, theta
        Pose of the sensor (m, rad).
    rows, nearby
        Regions of the world, TRUE_REGION, and the indices of those to look at.
    directions, ranges
        Rays in the sensor's frame and how far they see, shapes (2, n) and (n,), m.
    limits
        Range of the sensor, tolerance between wall and edge, and length of an edge that is enough, m.
    told, gain
        Told standard deviations of position, size and heading, and from which size on; simulated over told ones.
    confidence
        Stated probability of the type.
    normals
        Standard normal numbers, DRAWS for each measurement.
    scratch
        Where the rays end (2, n), what is seen of each rectangle, and a part of a row with the states of its edges.
    sources, records
        Written: where each measurement comes from, `SOURCE`, and the measurement.
    """
    reach, tolerance, closed_length = limits
    ends, sights, u, b, t, states = scratch
    heading, c, s, axis, box = math.nan, 0.0, 0.0, (0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    count = 0
    for j in nearby:
        row = rows[j]
        if (row.cx - x) ** 2 + (row.cy - y) ** 2 > (reach + row.radius) ** 2:
            continue
        if row.phi != heading:  # many rows have the same one
            heading = row.phi
            c, s = math.cos(heading), math.sin(heading)
            axis = (math.cos(heading - theta), math.sin(heading - theta))
            box = turn_rays(axis, directions, ranges, ends)
        at_u, at_v = c * (x - row.x) + s * (y - row.y), c * (y - row.y) - s * (x - row.x)
        if out_of_view(row, at_u, at_v, box):
            continue
        for i in range(row.n):
            bounds = (row.u[i] - at_u, row.u[i + 1] - at_u, row.b[i] - at_v, row.t[i] - at_v)
            look(bounds, axis, ends, ranges, reach, tolerance, sights[i])
        first, length = visible_run(row, sights, closed_length)
        if length == 0:
            continue
        cut_row(row, at_u, at_v, first, length, sights, closed_length, u, b, t, states)
        main = 1 if length == MAX_RECTANGLES else min(max(row.main - first, 0), length - 1)
        if length == 2 and row.n == MAX_RECTANGLES:
            main = row.main - first
        source = sources[count]
        source.region, source.first, source.turned = j, first, 0
        draws = normals[count * DRAWS : (count + 1) * DRAWS]
        phi, first_axis = heading - theta + gain * told[2] * draws[4], axis
        phi -= 2 * math.pi * math.floor((phi + math.pi) / (2 * math.pi))
        if not -math.pi / 2 < phi <= math.pi / 2:
            phi += -math.pi if phi > 0 else math.pi
            turn_part(length, u, b, t, states)
            source.turned = 1
            first_axis, main = (-axis[0], -axis[1]), length - 1 - main
        record = records[count]
        record.type, record.confidence, record.phi = row.type, confidence, phi
        write_part(record, length, main, u, b, t, states, first_axis, told, gain, draws)
        count += 1
    return count


@lean
def write_links(
    sources: NDArray[np.void],
    count: int,
    starts: Ints,
    neighbours: Ints,
    confidence: float,
    slots: Ints,
    links: NDArray[np.void],
) -> int:
    """Write the links between measured regions, both ways; return how many.

    `starts` and `neighbours` list the regions linked to each one; `slots` holds -1 for every region, before and after.
    """
    for k in range(count):
        slots[sources[k].region] = k
    written = 0
    for k in range(count):
        region = sources[k].region
        for place in range(starts[region], starts[region + 1]):
            target = slots[neighbours[place]]
            if target >= 0:
                links[written].source, links[written].target = k, target
                links[written].confidence = confidence
                written += 1
    for k in range(count):
        slots[sources[k].region] = -1
    return written


@lru_cache(maxsize=8)
def _near_lists(arrays: WorldArrays, reach: float) -> tuple[NearbyIndex, NearbyIndex, Ints, Ints]:
    """Return which walls and regions are near where, and `_adjacency`; all sensors in a world share them."""
    rows = np.asarray(arrays.rows).view(np.ndarray)
    near_walls = NearbyIndex(segment_boxes(arrays.walls), reach)
    return near_walls, NearbyIndex(_circle_boxes(rows), reach), *_adjacency(arrays.links, len(rows))


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array that nobody can write to, as those of a world are: kernels compile once for either."""
    array.flags.writeable = False
    return array


def _adjacency(pairs: Ints, count: int) -> tuple[Ints, Ints]:
    """Return for each of `count` regions where its neighbours start, shape (count + 1,), and all neighbours."""
    both = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0)
    return np.searchsorted(both[:, 0], np.arange(count + 1)), np.ascontiguousarray(both[:, 1])


def _circle_boxes(rows: NDArray[np.void]) -> Floats:
    """Return the boxes around the regions' circles, shape (R, 4)."""
    x, y, radius = rows["cx"], rows["cy"], rows["radius"]
    return np.stack([x - radius, y - radius, x + radius, y + radius], axis=1)
