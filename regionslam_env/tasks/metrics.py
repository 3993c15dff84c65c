"""Metrics of one episode, each defined for every case; None (null in JSON), never NaN, where one has no meaning.

Distances are geodesic, for a disc of the robot's radius, until its centre is inside the *nearest* region of the goal
type; in a mission of several instructions they are lengths of the shortest way that leads through all places in their
order. Where something has to be mapped, these are None, and so is the robot's own verdict if that comes last. Pose
errors are taken in the map frame against the true pose relative to the start, without any alignment.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slam.jit import njit
from slam.se2 import wrap

Floats = NDArray[np.float64]

MAP_METRICS = ("region_precision", "region_recall", "region_iou", "type_accuracy", "link_f1")
"""Metrics of the believed map, computed by `slam.evaluation.map_quality` at the end of an episode."""

TASK_METRICS = ("completed", "explored", "closed_edges")
"""Metrics of the task: shares of the instructions that are done, and, where the floor has to be mapped, of the
reachable regions that are mapped and of their edges that are closed."""

SHARE, AT_LEAST_0 = (0.0, 1.0), (0.0, math.inf)

RANGES: Mapping[str, tuple[float, float]] = {
    "success": SHARE,
    "spl": SHARE,
    "soft_spl": SHARE,
    "distance_to_goal": AT_LEAST_0,
    "path_length": AT_LEAST_0,
    "collisions": AT_LEAST_0,
    "false_arrival": SHARE,
    "belief_success": SHARE,
    "belief_spl": SHARE,
    "ape_rmse": AT_LEAST_0,
    "ape_max": AT_LEAST_0,
    "ape_end": AT_LEAST_0,
    "pose_nees": AT_LEAST_0,
    **dict.fromkeys((*MAP_METRICS, *TASK_METRICS), SHARE),
}
"""Least and largest value of every metric, both possible where finite; verdicts count as 0 and 1."""

METRICS = tuple(RANGES)
"""Every key that the last `info` of an episode holds."""

ALWAYS = ("success", "path_length", "collisions", "ape_rmse", "ape_max", "ape_end")
"""Metrics that are never None once a step was made."""


def spl(success: bool, shortest: float, path: float) -> float:
    """Success weighted by path length, ``success * shortest / max(path, shortest)`` (Anderson et al. 2018).

    Parameters
    ----------
    success
        Whether the episode succeeded.
    shortest
        Geodesic distance from the start to the goal, m; 0 for a start inside the goal.
    path
        Length of the path driven, m.

    Returns
    -------
    float
        In [0, 1]. The ratio 0 / 0 (a start in the goal, nothing driven) counts as 1: no path is shorter.

    Raises
    ------
    ValueError
        Where a length is negative or not finite: an unreachable goal has no SPL.
    """
    return efficiency(shortest, path) if success else 0.0


def soft_spl(shortest: float, remaining: float, path: float) -> float:
    """Progress weighted by path length: ``max(0, 1 - remaining / shortest) * shortest / max(path, shortest)``.

    The graded success of Datta et al. 2020 (arXiv:2009.03231). From a start inside the goal all of the (empty) way is
    done if the robot is still inside, and none of it if not.

    Parameters
    ----------
    shortest, remaining
        Geodesic distance to the goal at the start and at the end, m.
    path
        Length of the path driven, m.
    """
    _check_length("remaining", remaining)
    if shortest > 0:
        progress = max(0.0, 1.0 - remaining / shortest)
    else:
        progress = 1.0 if remaining == 0 else 0.0
    return progress * efficiency(shortest, path)


def efficiency(shortest: float, path: float) -> float:
    """Return ``shortest / max(path, shortest)``, 1 for an empty path where none was needed."""
    _check_length("shortest", shortest)
    _check_length("path", path)
    longest = max(path, shortest)
    return shortest / longest if longest > 0 else 1.0


def _check_length(name: str, value: float) -> None:
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{name} is {value} m, expected a finite length of at least 0: has the goal been reachable?")


@dataclass(frozen=True)
class EpisodeFacts:
    """What is known about an ended episode, true and believed.

    Parameters
    ----------
    success
        The mission was done, judged on the truth.
    over
        The episode ended before its time, by success or by a wrong declaration.
    declared
        The robot declared its arrival in the last step; None where there is nothing to declare (``arrival="stay"``).
    believed
        Probability, on the believed pose and map, that the mission is done at the end; None where the robot can't tell.
    shortest, remaining
        Length of the true shortest way at the start and at the end, m; None where no place has to be gone to.
    path_length, believed_path_length
        Length driven in truth and by odometry, m.
    collisions
        Number of times the robot ran into something.
    """

    success: bool
    over: bool
    declared: bool | None
    believed: float | None
    shortest: float | None
    remaining: float | None
    path_length: float
    believed_path_length: float
    collisions: int


def episode_metrics(
    facts: EpisodeFacts, pose_errors: PoseErrors, map_quality: Mapping[str, float | None]
) -> dict[str, float | int | bool | None]:
    """Return every metric of `METRICS`.

    ``belief_success`` is the robot's own verdict: it believes (P > 0.5) that it is in a region of the goal type, all
    earlier instructions being done, and has declared so where declarations exist. ``belief_spl`` weights that verdict
    by the path odometry tells instead of the true one; the shortest path stays the true one, which is how hard the
    mission was.
    """
    path, shortest, remaining = facts.path_length, facts.shortest, facts.remaining
    belief_success = None if facts.believed is None else facts.believed > 0.5 and facts.declared is not False
    metrics: dict[str, float | int | bool | None] = dict.fromkeys(METRICS)
    if shortest is not None and remaining is not None:
        metrics["spl"] = spl(facts.success, shortest, path)
        metrics["soft_spl"] = soft_spl(shortest, remaining, path)
        metrics["distance_to_goal"] = remaining
        if belief_success is not None:
            metrics["belief_spl"] = spl(belief_success, shortest, facts.believed_path_length)
    metrics |= {
        "success": facts.success,
        "path_length": facts.path_length,
        "collisions": facts.collisions,
        "false_arrival": None if facts.declared is None else facts.over and not facts.success,
        "belief_success": belief_success,
        **pose_errors.metrics(),
    }
    return metrics | {name: _finite(map_quality.get(name)) for name in (*MAP_METRICS, *TASK_METRICS)}


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


class PoseErrors:
    """Errors of the believed pose, accumulated over the steps of an episode in `sums` (`accumulate_error`)."""

    def __init__(self) -> None:
        self.sums = np.zeros(6)

    def add(self, true_pose: Floats, mean: Floats, covariance: Floats) -> None:
        """Take in one step: true pose and believed mean, shape (3,), and covariance, shape (3, 3), in the map frame."""
        accumulate_error(self.sums, true_pose, mean, covariance)

    def metrics(self) -> dict[str, float | None]:
        """Return ``ape_rmse``, ``ape_max``, ``ape_end`` (m) and ``pose_nees``; None before the first step.

        ``pose_nees`` is the mean of ``e' C^-1 e`` over the steps whose covariance is positive definite, e in x, y and
        heading: 3 for a calibrated belief, None where the pose was never uncertain.
        """
        steps, squares, largest, last, nees, uncertain = self.sums.tolist()
        return {
            "ape_rmse": math.sqrt(squares / steps) if steps else None,
            "ape_max": largest if steps else None,
            "ape_end": last if steps else None,
            "pose_nees": nees / uncertain if uncertain else None,
        }


@njit
def accumulate_error(sums: Floats, true_pose: Floats, mean: Floats, covariance: Floats) -> None:
    """Add one step to `sums`: steps, squared errors, largest and last error, sum of NEES, steps with a NEES."""
    ex, ey = true_pose[0] - mean[0], true_pose[1] - mean[1]
    et = wrap(true_pose[2] - mean[2])
    square = ex * ex + ey * ey
    sums[0] += 1
    sums[1] += square
    sums[2] = max(sums[2], math.sqrt(square))
    sums[3] = math.sqrt(square)
    nees = normalised_square(ex, ey, et, covariance)
    if nees >= 0:
        sums[4] += nees
        sums[5] += 1


@njit
def normalised_square(ex: float, ey: float, et: float, covariance: Floats) -> float:
    """Return ``e' C^-1 e`` by a Cholesky decomposition, or -1 where C is not positive definite."""
    tiny = 1e-10  # (0.01 mm)²: below it a covariance is rounding, not knowledge
    if covariance[0, 0] <= tiny:
        return -1.0
    l00 = math.sqrt(covariance[0, 0])
    l10, l20 = covariance[1, 0] / l00, covariance[2, 0] / l00
    d1 = covariance[1, 1] - l10 * l10
    if d1 <= tiny:
        return -1.0
    l11 = math.sqrt(d1)
    l21 = (covariance[2, 1] - l20 * l10) / l11
    d2 = covariance[2, 2] - l20 * l20 - l21 * l21
    if d2 <= tiny:
        return -1.0
    z0 = ex / l00
    z1 = (ey - l10 * z0) / l11
    z2 = (et - l20 * z0 - l21 * z1) / math.sqrt(d2)
    return z0 * z0 + z1 * z1 + z2 * z2
