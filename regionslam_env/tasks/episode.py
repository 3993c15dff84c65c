"""The book of one episode: where its map frame lies, what was driven, and how wrong the belief has been."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from regionslam_env.tasks.metrics import EpisodeFacts, Floats, PoseErrors, episode_metrics
from regionslam_env.tasks.task import DrawnMission
from slam.motion import Odometry


class Episode:
    """Everything that the metrics need to know about a running episode.

    Parameters
    ----------
    mission
        What is to be done.
    origin
        Pose (x, y, theta) of the map frame in the world frame, m and rad: where the map was begun.

    Attributes
    ----------
    steps
        Steps so far.
    """

    def __init__(self, mission: DrawnMission, origin: tuple[float, float, float]) -> None:
        self.mission = mission
        self.steps = 0
        self._pose_errors = PoseErrors()
        self._odometry_path = 0.0
        self._collisions = 0
        self._collided = False
        x, y, theta = origin
        self._frame = (x, y, theta, math.cos(theta), math.sin(theta))

    def in_map(self, pose: Floats) -> Floats:
        """Return a pose of the world frame, shape (3,), in the map frame."""
        x, y, theta = pose.tolist()
        x0, y0, theta0, c, s = self._frame
        dx, dy = x - x0, y - y0
        return np.array((c * dx + s * dy, c * dy - s * dx, math.remainder(theta - theta0, 2 * math.pi)))

    def add(self, odometry: Odometry, collided: bool, true_pose: Floats, mean: Floats, covariance: Floats) -> None:
        """Write down a step; poses and covariance in the map frame, shapes (3,), (3,) and (3, 3)."""
        self.steps += 1
        self._odometry_path += math.hypot(odometry.distance, odometry.lateral)
        if collided and not self._collided:
            self._collisions += 1
        self._collided = collided
        self._pose_errors.add(true_pose, mean, covariance)

    def metrics(
        self,
        success: bool,
        declared: bool | None,
        believed: float | None,
        remaining: float | None,
        path_length: float,
        map_quality: Mapping[str, float | None],
    ) -> dict[str, Any]:
        """Return every metric of `METRICS`; for the arguments see `EpisodeFacts`."""
        facts = EpisodeFacts(
            success=success,
            declared=declared,
            believed=believed,
            shortest=self.mission.shortest,
            remaining=remaining,
            path_length=path_length,
            believed_path_length=self._odometry_path,
            collisions=self._collisions,
        )
        return episode_metrics(facts, self._pose_errors, map_quality)
