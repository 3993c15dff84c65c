"""The book of one episode: where its map frame lies, what was driven, and how wrong the belief has been."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from regionslam_env.exact import hypot, principal
from regionslam_env.tasks.metrics import EpisodeFacts, Floats, PoseErrors, accumulate_error, episode_metrics
from regionslam_env.tasks.task import DrawnMission
from slam.jit import njit
from slam.motion import Odometry

STEPS, WAY, COLLISIONS, COLLIDED = range(4)
"""Places in an episode's book: steps, metres driven by odometry, times that a collision began, whether one goes on."""


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
    frame
        Of the map: x, y (m), heading (rad), its cosine and sine, shape (5,).
    book
        What was counted, by the places `STEPS`, `WAY`, `COLLISIONS` and `COLLIDED`.
    pose_errors
        Of the believed pose.
    """

    def __init__(self, mission: DrawnMission, origin: tuple[float, float, float]) -> None:
        self.mission = mission
        self.pose_errors = PoseErrors()
        self.book = np.zeros(4)
        x, y, theta = origin
        self.frame = np.array((x, y, theta, math.cos(theta), math.sin(theta)))

    @property
    def steps(self) -> int:
        """Steps so far."""
        return int(self.book[STEPS])

    def in_map(self, pose: Floats) -> Floats:
        """Return a pose of the world frame, shape (3,), in the map frame."""
        found = np.empty(3)
        to_map(self.frame, pose, found)
        return found

    def add(self, odometry: Odometry, collided: bool, true_pose: Floats, mean: Floats, covariance: Floats) -> None:
        """Write down a step; poses and covariance in the map frame, shapes (3,), (3,) and (3, 3)."""
        errors = self.pose_errors.sums
        add_step(self.book, errors, odometry.distance, odometry.lateral, collided, true_pose, mean, covariance)

    def metrics(
        self,
        success: bool,
        over: bool,
        declared: bool | None,
        believed: float | None,
        remaining: float | None,
        path_length: float,
        map_quality: Mapping[str, float | None],
    ) -> dict[str, Any]:
        """Return every metric of `METRICS`; for the arguments see `EpisodeFacts`."""
        facts = EpisodeFacts(
            success=success,
            over=over,
            declared=declared,
            believed=believed,
            shortest=self.mission.shortest,
            remaining=remaining,
            path_length=path_length,
            believed_path_length=float(self.book[WAY]),
            collisions=int(self.book[COLLISIONS]),
        )
        return episode_metrics(facts, self.pose_errors, map_quality)


@njit
def to_map(frame: Floats, pose: Floats, out: Floats) -> None:
    """Write a pose of the world frame in the frame of the map (`Episode.frame`)."""
    dx, dy = pose[0] - frame[0], pose[1] - frame[1]
    out[0], out[1] = frame[3] * dx + frame[4] * dy, frame[3] * dy - frame[4] * dx
    out[2] = principal(pose[2] - frame[2])


@njit
def add_step(
    book: Floats,
    errors: Floats,
    distance: float,
    lateral: float,
    collided: bool,
    true_pose: Floats,
    mean: Floats,
    covariance: Floats,
) -> None:
    """Count a step with this odometry (m) in `book`, and the error of the believed pose in `errors`."""
    book[STEPS] += 1
    book[WAY] += hypot(distance, lateral)
    book[COLLISIONS] += collided and book[COLLIDED] == 0
    book[COLLIDED] = collided
    accumulate_error(errors, true_pose, mean, covariance)
