"""One step of many environments, each part of it in one compiled call."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env import tables
from regionslam_env.geometry import list_of
from regionslam_env.observations import write_senses
from regionslam_env.sensors.lidar import scan_ranges
from regionslam_env.sensors.odometry import measure_motion
from regionslam_env.sensors.partial_row import DRAWS
from regionslam_env.sensors.region_sensor import SOURCE, sense
from regionslam_env.simulation.driving import COLLIDED, THETA, drive
from regionslam_env.tasks.episode import STEPS, add_step, to_map
from regionslam_env.vector.addresses import Row, line, sheet
from regionslam_env.worlds.flooding import distance_at
from regionslam_env.worlds.world import TRUE_REGION
from slam.grid import SLOT
from slam.jit import njit
from slam.lost import LOST
from slam.maps import LINK_BELIEF
from slam.measurement import LINK, MEASUREMENT
from slam.mixture import moments
from slam.particles import PARTICLE
from slam.proposal import predict
from slam.region import REGION
from slam.scan_update import resample, update_particles

(
    STATE,
    VELOCITIES,
    ENGINE,
    CLEARANCE,
    FRAME,
    BOOK,
    ERRORS,
    SEGMENTS,
    NEAR_SEGMENTS,
    WALLS,
    NEAR_WALLS,
    ROWS,
    NEAR_ROWS,
    STARTS,
    NEIGHBOURS,
    VIEW_RANGES,
    SOURCES,
    SEEN_PLACES,
    NORMALS,
    SIGHTINGS,
    VIEW,
    RECORDS,
    LINKS,
    RANGES,
    TYPES,
    IDS,
    PLACES,
    COLUMNS,
    PARTICLES,
    MAPS,
    WAY,
) = (0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 15, 16, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 45)
"""Places of the arrays of a copy: of robot and world, episode, lidar, region sensor (lists of what is near are three
arrays), observation and filter (maps are ten), and way to the goal: its field (eight)."""

ARRAYS = WAY + 8

COPY = np.dtype(
    (
        np.record,
        [
            ("grid", np.float64, (3,)),  # corner (m) and step (m) of the grid of clearance
            ("before", np.float64, (3,)),  # true pose before the step, world frame
            ("pose", np.float64, (3,)),  # and after it
            ("true_pose", np.float64, (3,)),  # the same in the map frame
            ("odometry", np.float64, (3,)),  # distance, lateral (m), rotation (rad)
            ("mean", np.float64, (3,)),  # of the believed pose
            ("cov", np.float64, (3, 3)),
            ("ess", np.float64),  # effective sample size
            ("doubt", np.float64),  # how much scans have contradicted the map
            ("completed", np.float64),  # share of the instructions
            ("scan_number", np.int64),
            ("heaviest", np.int64),  # particle
            ("drawn", np.int64),  # normal numbers that the region sensor has used
            ("measurements", np.int64),
            ("links", np.int64),
            ("demand", np.int64, (2,)),  # records and links that an update may take
            ("goal", np.int64),  # column of its type, -1 for none
            ("kind", np.int64),  # of instruction: its column in `progress`
            ("stage", np.int64),
            ("way_grid", np.float64, (3,)),  # corner (m) and step (m) of the grid of the way to the goal
            ("way", np.float64),  # that is left, m
            ("steps", np.int64),  # of the episode
            ("collided", np.bool_),
        ],
    )
)
"""What is counted for a copy besides its arrays."""

STANDING, MOVED, SCANNED, UPDATED = range(4)
"""How far a copy has come in its step. One that stops before the end lacks room, which its owner has to make."""

Copies = NDArray[np.void]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@njit
def drive_all(
    which: Ints, copies: Copies, table: Row, commands: Floats, robot: tuple[float, ...], margin: float
) -> None:
    """Drive all robots by their commands (N, 2), m/s and rad/s; who needs Python for that stays at `STANDING`."""
    for i in which:
        copy, row = copies[i], table[i]
        state, grid = line(row, STATE, np.float64), copy.grid
        for k in range(THETA + 1):
            copy.before[k] = state[k]
        clearance = sheet(row, CLEARANCE, np.float64)
        has_driven = drive(
            state,
            robot,
            commands[i, 0],
            commands[i, 1],
            (grid[0], grid[1], grid[2], clearance),
            margin,
            line(row, ENGINE, np.int64),
            sheet(row, VELOCITIES, np.float64),
        )
        copy.stage = MOVED if has_driven else STANDING


@njit
def perceive_all(
    which: Ints,
    copies: Copies,
    table: Row,
    draws: tuple[Floats, Floats, Floats, Floats],
    odometry_variances: tuple[float, float, float],
    lidar: tuple[float, float, Floats],
    senses: tuple[Any, ...],
    motion_noise: tuple[float, float, float],
    resampling: tuple[float, int],
    parameters: tuple[Any, ...],
    priors: tuple[Any, ...],
) -> None:
    """Measure, take the scans through the filters, and write down how wrong they are.

    Parameters
    ----------
    which
        Copies.
    copies, table
        All copies, and their arrays.
    draws
        Normal numbers for odometry (N, 2), lidar (N, rays) and filter (N, P, 3), uniform ones for resampling (N, P).
    odometry_variances
        As `measure_motion` takes them.
    lidar
        Range (m), standard deviation (m) and directions of the rays.
    senses
        What all region sensors have in common, in the order of `RegionSensor`: directions, open rays, limits, told
        noise, gain, confidence of types and of links.
    motion_noise
        Told variances of the odometry.
    resampling
        Effective sample size below which to resample, and the scheme.
    parameters, priors
        Of the filters.
    """
    for i in which:
        copy, row = copies[i], table[i]
        if copy.stage == MOVED and measure(copy, row, draws[0][i], draws[1][i], odometry_variances, lidar, senses):
            particles, maps = line(row, PARTICLES, PARTICLE), maps_at(row)
            motion = copy.odometry
            predict(particles, motion[0], motion[1], motion[2], motion_noise[0], motion_noise[1], motion_noise[2])
            if copy.ess < resampling[0]:
                resample(particles, maps, resampling[1], draws[3][i])
            copy.scan_number += 1
            copy.stage = SCANNED
        if copy.stage == SCANNED and update(copy, row, draws[2][i], parameters, priors):
            copy.stage = UPDATED


@njit
def measure(
    copy: Any,
    row: Row,
    motion_normals: Floats,
    lidar_normals: Floats,
    variances: tuple[float, float, float],
    lidar: tuple[float, float, Floats],
    senses: tuple[Any, ...],
) -> bool:
    """Measure motion, ranges and regions; return False, with nothing changed, if the region sensor lacks numbers."""
    state, near_rows = line(row, STATE, np.float64), cells_at(row, NEAR_ROWS)
    x, y, theta = state[0], state[1], state[2]
    first, last = list_of(near_rows, x, y)
    nearby, normals = near_rows[2][first:last], line(row, NORMALS, np.float64)
    if copy.drawn + len(nearby) * DRAWS > len(normals):
        return False
    copy.collided = state[COLLIDED] != 0.0
    for k in range(THETA + 1):
        copy.pose[k] = state[k]
    distance, lateral, rotation = measure_motion(copy.before, copy.pose, motion_normals, variances)
    copy.odometry[0], copy.odometry[1], copy.odometry[2] = distance, lateral, rotation
    to_map(line(row, FRAME, np.float64), copy.pose, copy.true_pose)
    near_segments = cells_at(row, NEAR_SEGMENTS)
    first, last = list_of(near_segments, x, y)
    scan_ranges(
        x,
        y,
        theta,
        lidar[0],
        lidar[2],
        sheet(row, SEGMENTS, np.float64),
        near_segments[2][first:last],
        lidar_normals,
        lidar[1],
        line(row, RANGES, np.float64),
    )
    directions, open_rays, limits, told, gain, confidence, link_confidence = senses
    given = (
        sheet(row, WALLS, np.float64),
        line(row, ROWS, TRUE_REGION),
        directions,
        open_rays,
        limits,
        told,
        gain,
        confidence,
        line(row, STARTS, np.int64),
        line(row, NEIGHBOURS, np.int64),
        link_confidence,
    )
    room = line(row, VIEW_RANGES, np.float64), line(row, SOURCES, SOURCE), line(row, SEEN_PLACES, np.int64)
    near_walls = cells_at(row, NEAR_WALLS)
    first, last = list_of(near_walls, x, y)
    copy.measurements, copy.links = sense(
        x,
        y,
        theta,
        near_walls[2][first:last],
        nearby,
        given,
        room,
        normals[copy.drawn :],
        line(row, SIGHTINGS, np.int64),
        sheet(row, VIEW, np.float64),
        line(row, RECORDS, MEASUREMENT),
        line(row, LINKS, LINK),
    )
    copy.drawn += copy.measurements * DRAWS
    return True


@njit
def update(copy: Any, row: Row, normals: Floats, parameters: tuple[Any, ...], priors: tuple[Any, ...]) -> bool:
    """Take a scan through a filter; return False, with nothing changed, if its arrays lack room."""
    particles = line(row, PARTICLES, PARTICLE)
    ess, doubt, demand = update_particles(
        particles,
        maps_at(row),
        line(row, RECORDS, MEASUREMENT)[: copy.measurements],
        line(row, TYPES, np.int64),
        line(row, LINKS, LINK)[: copy.links],
        0,
        sheet(row, VIEW, np.float64),
        normals,
        copy.scan_number,
        True,
        parameters,
        priors,
    )
    copy.demand[0], copy.demand[1] = demand[0], demand[1]
    if ess == 0.0:
        return False
    copy.ess, copy.doubt = ess, max(copy.doubt + doubt, 0.0)
    if copy.doubt <= LOST:
        copy.heaviest = moments(particles, copy.mean, copy.cov)
        note(copy, row)
    return True


@njit
def note(copy: Any, row: Row) -> None:
    """Write a step down in the book of its episode."""
    book, errors = line(row, BOOK, np.float64), line(row, ERRORS, np.float64)
    add_step(book, errors, copy.odometry[0], copy.odometry[1], copy.collided, copy.true_pose, copy.mean, copy.cov)
    copy.steps = int(book[STEPS])


@njit
def look_ahead(which: Ints, copies: Copies, table: Row) -> None:
    """Write down how much of their ways is left to robots that go to one place."""
    for i in which:
        copy, row = copies[i], table[i]
        grid = copy.way_grid
        field = (
            (grid[0], grid[1], grid[2], sheet(row, WAY, np.float64)),
            sheet(row, WAY + 1, np.float64),
            line(row, WAY + 2, np.float64),
            sheet(row, WAY + 3, np.float64),
            line(row, WAY + 4, np.int64),
            line(row, WAY + 5, np.int64),
            line(row, WAY + 6, np.int64),
            line(row, WAY + 7, np.float64),
        )
        copy.way = distance_at(field, copy.pose[0], copy.pose[1])


@njit
def observe_all(
    which: Ints,
    copies: Copies,
    table: Row,
    declared: NDArray[np.bool_],
    senses: tuple[Any, ...],
    maps: tuple[Any, ...],
    limits: Floats,
    n_types: int,
    max_steps: int,
    confirmed_after: int,
) -> None:
    """Write all observations.

    Parameters
    ----------
    which
        Copies.
    copies, table
        All copies, and their arrays.
    declared
        Whether they have declared to be done, shape (N,).
    senses, maps
        Written: "pose", "pose_cov", "velocity", "lidar", "goal" and "progress", each of shape (N, its size); "regions"
        (N, S, columns), "regions_mask" (N, S), "links" (N, L, columns) and "links_mask" (N, L).
    limits
        As `write_senses` takes them.
    n_types, max_steps, confirmed_after
        Numbers of semantic types, of steps of an episode, and of sightings of a region that is confirmed.
    """
    poses, covariances, velocities, lidars, goals, progress = senses
    regions, regions_masks, links, links_masks = maps
    for i in which:
        copy, row = copies[i], table[i]
        for array in (goals, progress):
            array[i] = 0
        regions[i], links[i] = 0, 0
        regions_masks[i], links_masks[i] = 0, 0
        write_senses(
            poses[i],
            covariances[i],
            velocities[i],
            lidars[i],
            goals[i],
            progress[i],
            copy.mean,
            copy.cov,
            line(row, RANGES, np.float64),
            limits,
            copy.odometry[0],
            copy.odometry[2],
            copy.goal,
            copy.kind,
            line(row, BOOK, np.float64)[STEPS] / max_steps,
            copy.completed,
            declared[i],
        )
        particles = line(row, PARTICLES, PARTICLE)
        tables.write_map(
            regions[i],
            regions_masks[i],
            links[i],
            links_masks[i],
            line(row, IDS, np.int64),
            line(row, PLACES, np.int64),
            particles[copy.heaviest].pose,
            copy.heaviest,
            particles,
            maps_at(row),
            line(row, COLUMNS, np.int64),
            n_types,
            copy.goal,
            confirmed_after,
        )


@njit
def cells_at(row: Row, place: int) -> tuple[Floats, Ints, Ints]:
    """Return the lists of what is near (`NearbyIndex.cells`) from a place on."""
    return line(row, place, np.float64), line(row, place + 1, np.int64), line(row, place + 2, np.int64)


@njit
def maps_at(row: Row) -> Any:
    """Return the arrays of `Maps`."""
    return (
        sheet(row, MAPS, np.int32),
        line(row, MAPS + 1, REGION),
        line(row, MAPS + 2, np.int32),
        line(row, MAPS + 3, np.int32),
        line(row, MAPS + 4, LINK_BELIEF),
        line(row, MAPS + 5, SLOT),
        line(row, MAPS + 6, np.int32),
        line(row, MAPS + 7, np.int32),
        line(row, MAPS + 8, np.int64),
        line(row, MAPS + 9, np.int64),
    )
