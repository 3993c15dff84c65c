"""One drive to a believed region, step by step: through the doors on the way, and whether it is over."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.control.controller import LocalController
from regionslam_env.control.route import route
from regionslam_env.observations import LinkColumn, LinkKind, Observation, RegionColumn, link_table, region_table

PASSAGE = 2.0
"""Regions on the way that are at most this long are driven through by their centres, m; others are left to sight."""

NEAR = 0.3
"""A centre this near is reached, m."""

BESIDE = 0.7
"""A thing is reached at this distance from its edge, m."""

STANDING_ROOM = 0.45
"""Aim at this distance from a thing, m."""

PATIENCE = 30
"""Steps in which at least `NEAR` must be driven."""

Floats = NDArray[np.float64]


class RegionDrive:
    """A drive to the region that holds a slot now, whichever slot it gets to hold later.

    Should the region vanish from the observation, the drive goes on to where it was last.

    Parameters
    ----------
    controller
        Drives from point to point.
    observation, slot_ids
        Of the moment in which the drive begins.
    slot
        Of the region.
    arrived_after
        Steps to be in the region (or at its centre) before the drive is over.
    point
        Where in the region to go, map frame, m; None for its middle, or just into it.
    """

    def __init__(
        self,
        controller: LocalController,
        observation: Observation,
        slot_ids: NDArray[np.int64],
        slot: int,
        arrived_after: int,
        point: Floats | None = None,
    ) -> None:
        self.controller, self._arrived_after = controller, arrived_after
        self._point = point
        self._inwards = point is not None or bool(region_table(observation)[slot, RegionColumn.CONTAINS_ME] > 0.5)
        self._is_thing = not self._inwards and _is_thing(observation, slot)
        self._way = [int(slot_ids[s]) for s in _way(observation, slot)]
        self._points: dict[int, Floats] = {}
        self._locate(observation, slot_ids)
        self._there, self._track = 0, [observation["pose"][:2].astype(np.float64)]

    def act(self, observation: Observation) -> Floats:
        """Return the next action, forward and turning speed in [-1, 1]."""
        points = [_to_robot(observation["pose"], self._points[region]) for region in self._way]
        while len(points) > 1 and np.hypot(*points[0]) < NEAR:
            del points[0], self._way[0]
        return self.controller.drive(points[0], observation["lidar"], final=len(points) == 1)

    def judge(self, observation: Observation, slot_ids: NDArray[np.int64]) -> str:
        """Return the outcome after an action, by the observation that came of it: "arrived", "blocked" or ""."""
        row = self._locate(observation, slot_ids)
        there = bool(np.hypot(*_to_robot(observation["pose"], self._points[self._way[-1]])) < NEAR)
        beside = self._point is None and row is not None and float(np.hypot(*_nearest(row))) < BESIDE
        if row is not None and not self._inwards:
            there |= bool(row[RegionColumn.CONTAINS_ME] > 0.5)
        there |= beside and self._is_thing
        self._there = self._there + 1 if there else 0
        self._track = [*self._track[-PATIENCE:], observation["pose"][:2].astype(np.float64)]
        if self._there >= self._arrived_after:
            return "arrived"
        stands = len(self._track) > PATIENCE and bool(np.hypot(*(self._track[0] - self._track[-1])) < NEAR)
        if stands and not there:
            return "arrived" if beside else "blocked"
        return ""

    def _locate(self, observation: Observation, slot_ids: NDArray[np.int64]) -> NDArray[np.float32] | None:
        """Take note of where the regions on the way are now; return the row of the last one, None if it has none."""
        table, last = region_table(observation), None
        for slot in np.flatnonzero(observation["regions_mask"]).tolist():
            region = int(slot_ids[slot])
            if region in self._way:
                centre = table[slot, [RegionColumn.X, RegionColumn.Y]].astype(np.float64)
                self._points[region] = _to_map(observation["pose"], centre)
            if region == self._way[-1]:
                last = table[slot]
                if self._is_thing:
                    self._points[region] = _to_map(observation["pose"], _in_front(last))
        if self._point is not None:
            self._points[self._way[-1]] = self._point
        return last


def _way(observation: Observation, slot: int) -> list[int]:
    """Return the slots of the passages on the way to a slot, and itself."""
    table = region_table(observation)
    known = observation["regions_mask"] > 0
    centres = table[:, [RegionColumn.X, RegionColumn.Y]].astype(np.float64)
    links = link_table(observation)[observation["links_mask"] > 0]
    links = links[links[:, LinkColumn.PROBABILITY] > 0.5][:, [LinkColumn.FIRST, LinkColumn.SECOND]].astype(np.int64)
    starts = np.flatnonzero(known & (table[:, RegionColumn.CONTAINS_ME] > 0.5)).tolist()
    if not starts:
        starts = [min(np.flatnonzero(known).tolist(), key=lambda s: np.hypot(*_nearest(table[s])))]
    way = route(starts, slot, centres, [(int(a), int(b)) for a, b in links])
    size = table[:, [RegionColumn.W, RegionColumn.H]].max(axis=1)
    return [s for s in way[:-1] if size[s] <= PASSAGE] + [slot]


def slot_at(observation: Observation, point: Floats) -> int:
    """Return the slot of the region that a point (map frame, m) is in, or nearest to; at least one slot holds one."""
    x, y = _to_robot(observation["pose"], point)
    table = region_table(observation).astype(np.float64)
    table[:, [RegionColumn.X, RegionColumn.Y]] -= (x, y)
    return min(np.flatnonzero(observation["regions_mask"]).tolist(), key=lambda s: float(np.hypot(*_nearest(table[s]))))


def _is_thing(observation: Observation, slot: int) -> bool:
    """Return whether a region is furniture, driven to and not into: inside another, or small and linked to nothing."""
    links = link_table(observation)[observation["links_mask"] > 0]
    links = links[links[:, LinkColumn.PROBABILITY] > 0.5]
    contains = links[:, LinkColumn.KIND] == LinkKind.CONTAINMENT
    if (links[contains, LinkColumn.SECOND] == slot).any():
        return True
    linked = bool((links[~contains][:, [LinkColumn.FIRST, LinkColumn.SECOND]] == slot).any())
    size = region_table(observation)[slot, [RegionColumn.W, RegionColumn.H]]
    return not linked and bool(size.max() <= PASSAGE)


def _nearest(row: NDArray[Any]) -> Floats:
    """Return the point of the main rectangle of a region's row that is the nearest to the robot, in its frame, m."""
    x, y, c, s, w, h = (float(v) for v in row[: RegionColumn.LEFT_W])
    along, across = -(c * x + s * y), s * x - c * y
    along, across = float(np.clip(along, -w / 2, w / 2)), float(np.clip(across, -h / 2, h / 2))
    return np.array([x + c * along - s * across, y + s * along + c * across])


def _in_front(row: NDArray[Any]) -> Floats:
    """Return the point before a thing, on the way from the robot to what is nearest of it, in the robot's frame, m."""
    nearest = _nearest(row)
    distance = float(np.hypot(*nearest))
    return nearest * max(0.0, 1 - STANDING_ROOM / max(distance, 1e-6))


def _to_map(pose: NDArray[np.float32], point: Floats) -> Floats:
    """Return a point of the robot's frame in the map frame; the pose is x, y, cos, sin."""
    x, y, c, s = pose.astype(np.float64)
    return np.array([x + c * point[0] - s * point[1], y + s * point[0] + c * point[1]])


def _to_robot(pose: NDArray[np.float32], point: Floats) -> Floats:
    """Return a point of the map frame in the robot's frame; the pose is x, y, cos, sin."""
    x, y, c, s = pose.astype(np.float64)
    return np.array([c * (point[0] - x) + s * (point[1] - y), c * (point[1] - y) - s * (point[0] - x)])
