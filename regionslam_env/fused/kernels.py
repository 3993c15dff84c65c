"""One step of one or many environments in one compiled call, all parts of it one after the other."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env import tables
from regionslam_env.fused.addresses import Row, line, sheet
from regionslam_env.geometry import list_of
from regionslam_env.observations import write_senses
from regionslam_env.sensors.lidar import scan_ranges
from regionslam_env.sensors.odometry import DRAWS as OF_MOTION
from regionslam_env.sensors.odometry import measure_motion
from regionslam_env.sensors.partial_row import DRAWS
from regionslam_env.sensors.region_sensor import SOURCE, outline, sense
from regionslam_env.simulation.driving import COLLIDED, THETA, drive
from regionslam_env.tasks.approach import STAYED, TO_STAY, advance
from regionslam_env.tasks.episode import STEPS, add_step, to_map
from regionslam_env.worlds.flooding import distance_at
from regionslam_env.worlds.world import TRUE_REGION
from slam.fastslam import DOUBT, SCANS
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
    CLEARANCE_FRAME,
    FRAME,
    BOOK,
    ERRORS,
    MOTION_NORMALS,
    MOTION_USED,
    LIDAR_NORMALS,
    LIDAR_USED,
    REGION_NORMALS,
    REGION_USED,
    POSE_NORMALS,
    UNIFORMS,
    SEGMENTS,
    NEAR_SEGMENTS,
    RANGES,
    WALLS,
    NEAR_WALLS,
    ROWS,
    NEAR_ROWS,
    STARTS,
    NEIGHBOURS,
    RAYS,
    SOURCES,
    PLACES,
    SIGHTINGS,
    RECORDS,
    LINKS,
    COUNTS,
    TYPES,
    PARTICLES,
    MAPS,
    PROGRESS,
    SAMPLE_SIZE,
    IDS,
    SLOTS,
    COLUMNS,
    WAY,
    PLACE,
    APPROACH,
    POSE,
    POSE_COV,
    VELOCITY,
    LIDAR,
    GOAL,
    ADVANCE,
    REGIONS,
    REGIONS_MASK,
    LINK_ROWS,
    LINKS_MASK,
) = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    9,
    10,
    11,
    12,
    13,
    14,
    15,
    16,
    17,
    20,
    21,
    22,
    25,
    26,
    29,
    30,
    31,
    32,
    33,
    34,
    35,
    36,
    37,
    38,
    39,
    40,
    51,
    52,
    53,
    54,
    55,
    56,
    65,
    74,
    75,
    76,
    77,
    78,
    79,
    80,
    81,
    82,
    83,
    84,
)
"""Places of the arrays of a copy: of robot and world, episode, noise to come, lidar, region sensor, filter, rows of the
observation, the way that is left and the place to be next, and the observation itself.

Several arrays each: lists of what is near (three), maps (eleven), fields of distances (nine)."""

ARRAYS = 85

COPY = np.dtype(
    (
        np.record,
        [
            ("command", np.float64, (2,)),  # speed (m/s) and turn rate (rad/s)
            ("declared", np.bool_),
            ("goal", np.int64),  # column of its type, -1 for none
            ("kind", np.int64),  # of instruction: its column in `progress`
            ("completed", np.float64),  # share of the instructions
            ("approaches", np.bool_),  # whether the present instruction is a place to be
            ("is_last", np.bool_),  # and none follows
            ("stage", np.int64),
            ("before", np.float64, (3,)),  # true pose before the step, world frame
            ("pose", np.float64, (3,)),  # and after it
            ("true_pose", np.float64, (3,)),  # the same in the map frame
            ("odometry", np.float64, (3,)),  # distance, lateral (m), rotation (rad)
            ("collided", np.bool_),
            ("mean", np.float64, (3,)),  # of the believed pose
            ("cov", np.float64, (3, 3)),
            ("heaviest", np.int64),  # particle
            ("demand", np.int64, (2,)),  # records and links that an update may take
            ("progress", np.float64),  # m
        ],
    )
)
"""What is said of a copy before a step, and what its step brings, besides its arrays."""

STANDING, MOVED, SCANNED, UPDATED, JUDGED, OBSERVED = range(6)
"""How far a copy has come in its step.

One that stops before the end needs its owner: who drives where there is no engine (STANDING), draws more noise (MOVED),
makes room in the filter (SCANNED), and judges what is out of the ordinary (UPDATED)."""

Copies = NDArray[np.void]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@njit
def step_all(
    which: Ints,
    copies: Copies,
    table: Row,
    robot: tuple[Any, ...],
    odometry_variances: tuple[float, float, float],
    lidar: tuple[float, float, Floats],
    senses: tuple[Any, ...],
    filters: tuple[Any, ...],
    observer: tuple[Any, ...],
    max_steps: int,
) -> None:
    """Take copies through their steps, each from the stage it is at to the end, or to where it needs its owner.

    Parameters
    ----------
    which
        Copies.
    copies, table
        All copies, and their arrays.
    robot
        The parts of `Drive`, and the clearance (m) from which on nothing can be touched.
    odometry_variances
        As `measure_motion` takes them.
    lidar
        `Lidar.settings`.
    senses
        `RegionSensor.settings`.
    filters
        Told variances of the odometry; effective sample size below which to resample, and the scheme; whether to notice
        that the filter is lost; parameters and priors.
    observer
        Limits as `write_senses` takes them, numbers of semantic types, and of sightings of a region that is confirmed.
    max_steps
        Of an episode.
    """
    motion_noise, resampling, watchful, parameters, priors = filters
    directions = senses[0]
    view = np.empty(directions.T.shape)
    # Stage by stage, not copy by copy: the code of all stages does not stay in a processor's caches, that of one does.
    for i in which:
        copy, row = copies[i], table[i]
        if copy.stage == STANDING and move(copy, row, robot):
            copy.stage = MOVED
    for i in which:
        copy, row = copies[i], table[i]
        if copy.stage == MOVED and measure(copy, row, odometry_variances, lidar, senses):
            predict_all(copy, row, motion_noise, resampling)
            copy.stage = SCANNED
    for i in which:
        copy, row = copies[i], table[i]
        if copy.stage == SCANNED and update(copy, row, directions, view, watchful, parameters, priors):
            copy.stage = UPDATED
            if line(row, PROGRESS, np.float64)[DOUBT] <= LOST:
                copy.heaviest = moments(line(row, PARTICLES, PARTICLE), copy.mean, copy.cov)
                note(copy, row)
                if judge(copy, row, max_steps):
                    copy.stage = JUDGED
    for i in which:
        copy, row = copies[i], table[i]
        if copy.stage == JUDGED:
            observe(copy, row, observer, max_steps)
            copy.stage = OBSERVED


@njit
def move(copy: Any, row: Row, robot: tuple[Any, ...]) -> bool:
    """Drive by the command; return False where that needs an engine that kernels cannot call."""
    state, frame = line(row, STATE, np.float64), line(row, CLEARANCE_FRAME, np.float64)
    for k in range(THETA + 1):
        copy.before[k] = state[k]
    return drive(
        state,
        robot[0],
        copy.command[0],
        copy.command[1],
        (frame[0], frame[1], frame[2], sheet(row, CLEARANCE, np.float64)),
        robot[1],
        line(row, ENGINE, np.int64),
        sheet(row, VELOCITIES, np.float64),
    )


@njit
def measure(
    copy: Any,
    row: Row,
    variances: tuple[float, float, float],
    lidar: tuple[float, float, Floats],
    senses: tuple[Any, ...],
) -> bool:
    """Measure motion, ranges and regions; return False, with nothing changed, if there is too little noise drawn."""
    state, near_rows, ranges = line(row, STATE, np.float64), cells_at(row, NEAR_ROWS), line(row, RANGES, np.float64)
    x, y, theta = state[0], state[1], state[2]
    first, last = list_of(near_rows, x, y)
    nearby = near_rows[2][first:last]
    of_motion, motion_used = line(row, MOTION_NORMALS, np.float64), line(row, MOTION_USED, np.int64)
    of_lidar, lidar_used = line(row, LIDAR_NORMALS, np.float64), line(row, LIDAR_USED, np.int64)
    of_regions, regions_used = line(row, REGION_NORMALS, np.float64), line(row, REGION_USED, np.int64)
    if (
        motion_used[0] + OF_MOTION > len(of_motion)
        or lidar_used[0] + len(ranges) > len(of_lidar)
        or regions_used[0] + len(nearby) * DRAWS > len(of_regions)
    ):
        return False
    copy.collided = state[COLLIDED] != 0.0
    for k in range(THETA + 1):
        copy.pose[k] = state[k]
    distance, lateral, rotation = measure_motion(copy.before, copy.pose, of_motion[motion_used[0] :], variances)
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
        of_lidar[lidar_used[0] :],
        lidar[1],
        ranges,
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
    room = line(row, RAYS, np.float64), line(row, SOURCES, SOURCE), line(row, PLACES, np.int64)
    near_walls, counts = cells_at(row, NEAR_WALLS), line(row, COUNTS, np.int64)
    first, last = list_of(near_walls, x, y)
    counts[0], counts[1] = sense(
        x,
        y,
        theta,
        near_walls[2][first:last],
        nearby,
        given,
        room,
        of_regions[regions_used[0] :],
        line(row, SIGHTINGS, np.int64),
        line(row, RECORDS, MEASUREMENT),
        line(row, LINKS, LINK),
    )
    motion_used[0] += OF_MOTION
    lidar_used[0] += len(ranges)
    regions_used[0] += counts[0] * DRAWS
    return True


@njit
def predict_all(copy: Any, row: Row, noise: tuple[float, float, float], resampling: tuple[float, int]) -> None:
    """Move the particles by odometry, and draw their ancestors where the effective sample size is low."""
    particles, motion = line(row, PARTICLES, PARTICLE), copy.odometry
    predict(particles, motion[0], motion[1], motion[2], noise[0], noise[1], noise[2])
    if line(row, SAMPLE_SIZE, np.float64)[0] < resampling[0]:
        resample(particles, maps_at(row), resampling[1], line(row, UNIFORMS, np.float64))
    line(row, PROGRESS, np.float64)[SCANS] += 1


@njit
def update(
    copy: Any,
    row: Row,
    directions: Floats,
    view: Floats,
    watchful: bool,
    parameters: tuple[Any, ...],
    priors: tuple[Any, ...],
) -> bool:
    """Take a scan through a filter; return False, with nothing changed, if its arrays lack room.

    `view` is scratch for where the rays of these directions end.
    """
    outline(directions, line(row, RAYS, np.float64), view)
    counts, progress = line(row, COUNTS, np.int64), line(row, PROGRESS, np.float64)
    ess, doubt, demand = update_particles(
        line(row, PARTICLES, PARTICLE),
        maps_at(row),
        line(row, RECORDS, MEASUREMENT)[: counts[0]],
        line(row, TYPES, np.int64),
        line(row, LINKS, LINK)[: counts[1]],
        0,
        view,
        sheet(row, POSE_NORMALS, np.float64),
        int(progress[SCANS]),
        watchful,
        parameters,
        priors,
    )
    copy.demand[0], copy.demand[1] = demand[0], demand[1]
    if ess == 0.0:
        return False
    line(row, SAMPLE_SIZE, np.float64)[0] = ess
    progress[DOUBT] = max(progress[DOUBT] + doubt, 0.0)
    return True


@njit
def note(copy: Any, row: Row) -> None:
    """Write a step down in the book of its episode."""
    book, errors = line(row, BOOK, np.float64), line(row, ERRORS, np.float64)
    add_step(book, errors, copy.odometry[0], copy.odometry[1], copy.collided, copy.true_pose, copy.mean, copy.cov)


@njit
def judge(copy: Any, row: Row, max_steps: int) -> bool:
    """Judge a step of a robot that goes to a place, if nothing ends with it; return whether that is so."""
    last = line(row, BOOK, np.float64)[STEPS] >= max_steps
    if copy.declared or last or not copy.approaches:
        return False
    state, x, y = line(row, APPROACH, np.float64), copy.pose[0], copy.pose[1]
    distance = distance_at(field_at(row, PLACE), x, y)
    inside = distance <= 0
    if inside and (not copy.is_last or state[STAYED] + 1 >= state[TO_STAY]):
        return False
    remaining = max(0.0, distance) if copy.is_last else distance_at(field_at(row, WAY), x, y)
    copy.progress = advance(state, remaining, inside)
    return True


@njit
def observe(copy: Any, row: Row, observer: tuple[Any, ...], max_steps: int) -> None:
    """Write the observation."""
    limits, n_types, confirmed_after = observer
    goal, progress = line(row, GOAL, np.float32), line(row, ADVANCE, np.float32)
    regions, links = sheet(row, REGIONS, np.float32), sheet(row, LINK_ROWS, np.float32)
    regions_mask, links_mask = line(row, REGIONS_MASK, np.int8), line(row, LINKS_MASK, np.int8)
    goal[:], progress[:], regions[:], links[:], regions_mask[:], links_mask[:] = 0, 0, 0, 0, 0, 0
    write_senses(
        line(row, POSE, np.float32),
        line(row, POSE_COV, np.float32),
        line(row, VELOCITY, np.float32),
        line(row, LIDAR, np.float32),
        goal,
        progress,
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
        copy.declared,
    )
    particles = line(row, PARTICLES, PARTICLE)
    tables.write_map(
        regions,
        regions_mask,
        links,
        links_mask,
        line(row, IDS, np.int64),
        line(row, SLOTS, np.int64),
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
def field_at(row: Row, place: int) -> Any:
    """Return what `distance_at` takes, of `Field.arrays` from a place on."""
    frame = line(row, place, np.float64)
    return (
        (frame[0], frame[1], frame[2], sheet(row, place + 1, np.float64)),
        sheet(row, place + 2, np.float64),
        line(row, place + 3, np.float64),
        sheet(row, place + 4, np.float64),
        line(row, place + 5, np.int64),
        line(row, place + 6, np.int64),
        line(row, place + 7, np.int64),
        line(row, place + 8, np.float64),
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
        line(row, MAPS + 5, np.int32),
        line(row, MAPS + 6, SLOT),
        line(row, MAPS + 7, np.int32),
        line(row, MAPS + 8, np.int32),
        line(row, MAPS + 9, np.int64),
        line(row, MAPS + 10, np.int64),
    )
