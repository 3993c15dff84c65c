"""Reads scans back into the world for comparison with the truth."""

from __future__ import annotations

import numpy as np

from regionslam_env.config import NOISE_SETS, NoiseConfig, SensorConfig
from regionslam_env.sensors.region_sensor import RegionSensor
from regionslam_env.worlds.world import World
from slam.measurement import Scan
from slam.region import EDGE_NAMES, EdgeState
from slam.rows import Row


def sensor(world: World, noise: NoiseConfig | None = None, seed: int = 0, **config: object) -> RegionSensor:
    """Return a region sensor, exact unless told otherwise."""
    settings = SensorConfig(**config)  # type: ignore[arg-type]
    return RegionSensor(settings, noise or NOISE_SETS["none"], world.arrays, np.random.default_rng(seed))


def look(world: World, pose: tuple[float, float, float], **config: object) -> Scan:
    """Return an exact scan."""
    return sensor(world, **config).measure(np.array(pose))


def find(scan: Scan, kind: str) -> np.record:
    """Return the one measurement of a type."""
    (found,) = [record for record in scan.records if scan.types[record.type] == kind]
    return found


def kinds(scan: Scan) -> list[str]:
    """Return the types of all measurements, sorted."""
    return sorted(scan.types[record.type] for record in scan.records)


def row_of(record: np.record) -> Row:
    """Return a measurement's geometry in the robot's frame."""
    sides = [(record.sub_w[k], record.sub_h[k], record.sub_y[k]) for k in range(2)]
    left = sides[0] if record.edges[2] == EdgeState.SUBRECT else None
    right = sides[1] if record.edges[3] == EdgeState.SUBRECT else None
    return Row.from_parameters(record.x, record.y, record.w, record.h, record.phi, left, right)


def to_world(points: np.ndarray, pose: tuple[float, float, float]) -> np.ndarray:
    """Move points of the robot's frame to the world."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return points @ np.array([[c, s], [-s, c]]) + np.array(pose[:2])


def corners(row: Row, pose: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    """Return the corners of all rectangles in the world, sorted, shape (4 n, 2)."""
    points = to_world(row.rectangles().reshape(-1, 2), pose).round(9) + 0.0
    return points[np.lexsort(points.T)]


def edges(record: np.record) -> dict[str, EdgeState]:
    """Return the states of the edges that the measurement has, by name."""
    present = {"t", "b", "l", "r"}
    present |= {"tl", "bl", "ll"} if record.edges[2] == EdgeState.SUBRECT else set()
    present |= {"tr", "br", "rr"} if record.edges[3] == EdgeState.SUBRECT else set()
    return {name: EdgeState(state) for name, state in zip(EDGE_NAMES, record.edges, strict=True) if name in present}
