"""Errors of an estimated trajectory: absolute (APE) and relative (RPE) pose error.

After Sturm et al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems". Trajectories are arrays of poses
(x, y, theta), shape (k, 3), m and rad, one row per moment, in one frame. Without alignment the frames must agree; with
it the best rigid motion is taken out first, which forgives a filter a wrong frame that it never revised.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from slam.rows import Floats
from slam.se2 import between, compose, wrap_angles


@dataclass(frozen=True)
class ErrorStatistics:
    """Root mean square, largest, mean and last of a series of errors, m or rad."""

    rmse: float
    max: float
    mean: float
    end: float

    @classmethod
    def of(cls, errors: ArrayLike) -> ErrorStatistics:
        """Summarize non-negative errors, shape (k,), k > 0."""
        errors = np.asarray(errors, dtype=np.float64)
        return cls(
            rmse=float(np.sqrt(np.mean(errors**2))),
            max=float(np.max(errors)),
            mean=float(np.mean(errors)),
            end=float(errors[-1]),
        )


@dataclass(frozen=True)
class TrajectoryError:
    """Errors of position (m) and heading (rad)."""

    position: ErrorStatistics
    heading: ErrorStatistics


def ape(estimated: ArrayLike, true: ArrayLike, align: bool = False) -> TrajectoryError:
    """Return the absolute pose error: how far each estimated pose is from the true one.

    Parameters
    ----------
    estimated, true
        Poses of the same moments, shape (k, 3).
    align
        Move the estimate by the rigid motion that fits its positions best (`alignment`).

    Raises
    ------
    ValueError
        If the shapes differ, there is no pose, or a value isn't finite.
    """
    estimated, true = _trajectories(estimated, true)
    if align:
        estimated = compose(alignment(estimated, true), estimated)
    return _statistics(position_errors(estimated, true), heading_errors(estimated, true))


def rpe(estimated: ArrayLike, true: ArrayLike, delta: int = 1) -> TrajectoryError:
    """Return the relative pose error: how far the motion over `delta` steps is from the true one, at every step.

    No alignment is needed, for it doesn't change motions.
    """
    estimated, true = _trajectories(estimated, true)
    if not 1 <= delta < len(true):
        raise ValueError(
            f"delta is {delta!r}, expected a number of steps from 1 to {len(true) - 1} for {len(true)} poses"
        )
    motion, true_motion = between(estimated[:-delta], estimated[delta:]), between(true[:-delta], true[delta:])
    error = between(true_motion, motion)
    return _statistics(np.hypot(error[:, 0], error[:, 1]), np.abs(error[:, 2]))


def position_errors(estimated: ArrayLike, true: ArrayLike) -> Floats:
    """Return the distance between estimated and true position at every step, shape (k,), m."""
    difference = np.asarray(estimated)[..., :2] - np.asarray(true)[..., :2]
    return np.asarray(np.hypot(difference[..., 0], difference[..., 1]))


def heading_errors(estimated: ArrayLike, true: ArrayLike) -> Floats:
    """Return the absolute difference of estimated and true heading at every step, shape (k,), rad."""
    return np.abs(wrap_angles(np.asarray(estimated)[..., 2] - np.asarray(true)[..., 2]))


def alignment(estimated: ArrayLike, true: ArrayLike) -> Floats:
    """Return the pose true_T_estimated whose motion brings estimated positions closest to true ones, in least squares.

    Umeyama 1991 in the plane, without scale. Without extent of the trajectory the rotation is 0.
    """
    estimated, true = _trajectories(estimated, true)
    source, target = estimated[:, :2], true[:, :2]
    source_mean, target_mean = source.mean(axis=0), target.mean(axis=0)
    (a, b), (c, d) = (source - source_mean).T @ (target - target_mean)
    theta = np.arctan2(b - c, a + d)
    turned = compose((0.0, 0.0, theta), (*source_mean, 0.0))
    return np.array([target_mean[0] - turned[0], target_mean[1] - turned[1], theta])


def _statistics(positions: Floats, headings: Floats) -> TrajectoryError:
    return TrajectoryError(ErrorStatistics.of(positions), ErrorStatistics.of(headings))


def _trajectories(estimated: ArrayLike, true: ArrayLike) -> tuple[Floats, Floats]:
    estimated, true = np.asarray(estimated, dtype=np.float64), np.asarray(true, dtype=np.float64)
    for name, poses in (("estimated", estimated), ("true", true)):
        if poses.ndim != 2 or poses.shape[1] != 3 or len(poses) == 0:
            raise ValueError(f"the {name} trajectory has shape {poses.shape}, expected (k, 3) with k > 0")
        if not np.all(np.isfinite(poses)):
            raise ValueError(
                f"the {name} trajectory isn't finite at step {int(np.argwhere(~np.isfinite(poses))[0, 0])}"
            )
    if len(estimated) != len(true):
        raise ValueError(f"{len(estimated)} estimated poses cannot be compared with {len(true)} true ones")
    return estimated, true
