"""The belief that an observation holds, in words and map coordinates: where the robot is and what regions there are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from regionslam_env.observations import ProgressColumn, RegionColumn, region_table
from slam.region import EDGE_NAMES
from slam.rows import Floats, Row

FURNITURE = frozenset({"desk", "cupboard", "table"})
PASSAGES = frozenset({"hallway", "lobby", "entrance", "stairs", "door", "other"})
"""Types of regions that lead on to others."""


@dataclass(frozen=True, eq=False)
class BelievedRegion:
    """One region of the belief.

    Attributes
    ----------
    slot
        Row in the observation; stable while the region is remembered there.
    row
        Geometry in the map frame.
    type, type_p
        Most probable type and its probability.
    goal_p
        Probability that it is of the wanted type.
    existence
        Probability that it exists.
    visited
        Whether the robot has been inside.
    contains_me
        Probability that the robot is inside.
    open_edges
        Edges not yet seen, in the names of `EDGE_NAMES`.
    """

    slot: int
    row: Row
    type: str
    type_p: float
    goal_p: float
    existence: float
    visited: bool
    contains_me: float
    open_edges: tuple[str, ...]

    def depth(self, points: ArrayLike) -> Floats:
        """Return how far inside points (map frame, shape (k, 2)) are, m: the distance to the nearest outer edge.

        Minus infinity or negative outside. A joint is no edge where both of its rectangles go on.
        """
        row = self.row
        local = row.to_local(points)
        along, across = local[:, 0], local[:, 1]
        depth = np.full(len(local), -np.inf)
        for i in range(row.n):
            sides = np.minimum(across - row.b[i], row.t[i] - across)
            left, right = along - row.u[i], row.u[i + 1] - along
            inside = np.minimum(left, right) >= 0
            if i > 0:
                left = np.maximum(left, np.minimum(across - row.b[i - 1], row.t[i - 1] - across))
            if i + 1 < row.n:
                right = np.maximum(right, np.minimum(across - row.b[i + 1], row.t[i + 1] - across))
            depth = np.maximum(depth, np.where(inside, np.minimum(sides, np.minimum(left, right)), -np.inf))
        return depth

    @property
    def extent(self) -> float:
        """Smaller side of the largest rectangle, m."""
        widths, heights = np.diff(self.row.u), self.row.t - self.row.b
        largest = int(np.argmax(widths * heights))
        return float(min(widths[largest], heights[largest]))


class View:
    """A moment as the agent believes it, read from an observation.

    Parameters
    ----------
    observation
        As the environment gives it.
    types
        Semantic types in the order of its columns.

    Attributes
    ----------
    pose
        Mean (x, y, theta) in the map frame.
    position_sigma
        Standard deviation of the position along its worst direction, m.
    goal
        Wanted type; None where there is none.
    returns
        Whether it has to go back to the start.
    completed
        Share of the instructions that are done.
    types
        All semantic types.
    """

    def __init__(self, observation: Mapping[str, NDArray[Any]], types: Sequence[str]) -> None:
        x, y, c, s = (float(v) for v in observation["pose"])
        self.pose: Floats = np.array([x, y, np.arctan2(s, c)])
        xx, xy, _, _, yy = np.asarray(observation["pose_cov"], dtype=np.float64).ravel()[:5]
        self.position_sigma = float(np.sqrt(max(0.0, (xx + yy) / 2 + np.hypot((xx - yy) / 2, xy))))
        self._goal = int(np.argmax(observation["goal"])) if np.any(observation["goal"]) else None
        self.goal = None if self._goal is None else types[self._goal]
        self.types = tuple(types)
        progress = observation["progress"]
        self.completed = float(progress[ProgressColumn.COMPLETED])
        self.returns = bool(progress[ProgressColumn.RETURN])
        self._observation = observation

    @cached_property
    def regions(self) -> tuple[BelievedRegion, ...]:
        """All believed regions."""
        table = region_table(self._observation).astype(np.float64)
        slots = np.flatnonzero(self._observation["regions_mask"])
        regions = (_region(int(slot), table[slot], self.pose, self.types, self._goal) for slot in slots)
        return tuple(r for r in regions if r is not None)

    def goal_regions(self) -> tuple[BelievedRegion, ...]:
        """Return the regions of the wanted type that probably contain the robot."""
        if self._goal is None:
            return ()
        table = region_table(self._observation)
        goal_p = table[:, RegionColumn.TYPES + self._goal]
        near = (goal_p > 0.5) & (table[:, RegionColumn.CONTAINS_ME] > 0.5) & (self._observation["regions_mask"] > 0)
        if not near.any():
            return ()
        slots = set(np.flatnonzero(near).tolist())
        return tuple(r for r in self.regions if r.slot in slots)

    @property
    def rooms(self) -> list[BelievedRegion]:
        """Believed regions to be in, the largest first: furniture and doors are left out."""
        rooms = (r for r in self.regions if r.type not in FURNITURE and r.type != "door")
        return sorted(rooms, key=lambda r: -r.row.area)

    def to_robot(self, point: ArrayLike) -> Floats:
        """Return a map-frame point in the robot's frame."""
        x, y = np.asarray(point, dtype=np.float64) - self.pose[:2]
        c, s = np.cos(self.pose[2]), np.sin(self.pose[2])
        return np.array([c * x + s * y, c * y - s * x])


def _region(slot: int, row: Floats, pose: Floats, types: Sequence[str], goal: int | None) -> BelievedRegion | None:
    """Turn a row of the table into a region in the map frame; None where it has no extent."""
    column = RegionColumn
    sides = []
    for first in (column.LEFT_W, column.RIGHT_W):
        w, h, y = (float(v) for v in row[first : first + 3])
        sides.append((w, h, y) if w > 0 and h > 0 else None)
    if not (row[column.W] > 0 and row[column.H] > 0):
        return None
    c, s = np.cos(pose[2]), np.sin(pose[2])
    geometry = Row.from_parameters(
        float(pose[0] + c * row[column.X] - s * row[column.Y]),
        float(pose[1] + s * row[column.X] + c * row[column.Y]),
        float(row[column.W]),
        float(row[column.H]),
        float(pose[2] + np.arctan2(row[column.SIN], row[column.COS])),
        sides[0],
        sides[1],
    )
    probabilities = row[column.TYPES :]
    best = int(np.argmax(probabilities))
    return BelievedRegion(
        slot=slot,
        row=geometry,
        type=types[best],
        type_p=float(probabilities[best]),
        goal_p=0.0 if goal is None else float(probabilities[goal]),
        existence=float(row[column.EXISTENCE]),
        visited=bool(row[column.VISITED] > 0.5),
        contains_me=float(row[column.CONTAINS_ME]),
        open_edges=tuple(name for k, name in enumerate(EDGE_NAMES) if row[column.OPEN_T + k] > 0.5),
    )
