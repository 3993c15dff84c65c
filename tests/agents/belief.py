"""Hand-made observations: a belief of a few regions, seen from a pose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.believed import View
from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.observations import RegionColumn
from slam.region import EDGE_NAMES
from slam.rows import Row

SLOTS = 6


class Room(NamedTuple):
    """A believed region in the map frame."""

    type: str
    row: Row
    open_edges: tuple[str, ...] = ()
    existence: float = 0.99
    type_p: float = 0.99
    visited: bool = False
    contains_me: float = 0.0


def observe(
    pose: tuple[float, float, float],
    rooms: Sequence[Room],
    goal: str,
    lidar: NDArray[np.float64] | None = None,
    sigma: float = 0.05,
) -> dict[str, NDArray[Any]]:
    """Return an observation with the rooms in the first slots."""
    n_types, column = len(SEMANTIC_TYPES), RegionColumn
    table, mask = np.zeros((SLOTS, column.TYPES + n_types)), np.zeros(SLOTS, np.int8)
    mask[: len(rooms)] = 1
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for line, room in zip(table, rooms, strict=False):
        parameters = room.row.parameters()
        dx, dy = parameters["x"] - pose[0], parameters["y"] - pose[1]
        turn = parameters["phi"] - pose[2]
        line[:6] = c * dx + s * dy, c * dy - s * dx, np.cos(turn), np.sin(turn), parameters["w"], parameters["h"]
        line[6:9], line[9:12] = parameters["left"] or (0, 0, 0), parameters["right"] or (0, 0, 0)
        for name in room.open_edges:
            line[column.OPEN_T + EDGE_NAMES.index(name)] = 1
        line[column.EXISTENCE : column.TYPES] = room.existence, room.type_p, room.visited, room.contains_me
        line[column.TYPES :] = (1 - room.type_p) / (n_types - 1)
        line[column.TYPES + SEMANTIC_TYPES.index(room.type)] = room.type_p
    return {
        "pose": np.array([pose[0], pose[1], c, s], np.float32),
        "pose_cov": (np.eye(3) * sigma**2).ravel().astype(np.float32),
        "velocity": np.zeros(2, np.float32),
        "regions": table.ravel().astype(np.float32),
        "regions_mask": mask,
        "links": np.zeros(16 * SLOTS, np.float32),
        "links_mask": np.zeros(4 * SLOTS, np.int8),
        "lidar": (np.full(180, 10.0) if lidar is None else lidar).astype(np.float32),
        "goal": (np.array(SEMANTIC_TYPES) == goal).astype(np.float32),
        "progress": np.array([0, 0, 0, 1, 0, 0], np.float32),
    }


def view(pose: tuple[float, float, float], rooms: Sequence[Room], goal: str) -> View:
    """Return the agent's view of such an observation."""
    return View(observe(pose, rooms, goal), SEMANTIC_TYPES)
