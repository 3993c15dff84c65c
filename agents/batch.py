"""The smoothed optimum of recorded data: Gauss-Newton over all poses and edges with known correspondence.

The rows are linearised here, all at once; GTSAM (extra `ref`) eliminates the sparse linear problem of every iteration.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from regionslam_env.errors import hint
from slam.evaluation.ekf import UNSEEN, EdgeEKF
from slam.evaluation.lines import Ints, Lines, jacobians, residuals, stack
from slam.motion import MotionNoise, Odometry
from slam.region import MAX_STATE
from slam.rows import Floats
from slam.se2 import wrap_angles

AVAILABLE = find_spec("gtsam") is not None

MISSING = hint("the batch needs GTSAM", "ref")


class Batch:
    """All data of a drive as one least-squares problem.

    Parameters
    ----------
    noise
        Of the odometry.
    moves, scans
        The T steps of the drive.
    ekf, poses
        Where to begin: the EKF at the end of the drive, and its poses on the way, shape (T, 3). The regions keep its
        anchors.
    start
        Pose before the first step, known for certain.

    Attributes
    ----------
    poses
        Shape (T, 3); angles count full turns.
    state
        Headings and edges, in the places of the EKF's state vector.
    """

    def __init__(
        self,
        noise: MotionNoise,
        moves: Sequence[Odometry],
        scans: Sequence[Lines],
        ekf: EdgeEKF,
        poses: Floats,
        start: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        if not AVAILABLE:
            raise ModuleNotFoundError(MISSING)
        self.poses, self.state = poses.copy(), ekf.mean.copy()
        self._start, self._place, self._anchor = np.asarray(start, float), ekf.place, ekf.anchor
        self._moves = np.array([(move.distance, move.lateral, move.rotation) for move in moves])
        driven, turned = np.hypot(self._moves[:, 0], self._moves[:, 1]), np.abs(self._moves[:, 2])
        variances = np.zeros_like(self._moves)
        variances[:, 0] = noise.distance * driven
        variances[:, 2] = noise.heading_per_metre * driven + noise.heading_per_radian * turned
        self._motion_sigma = np.sqrt(variances)  # 0 is a constraint: the odometry's model knows no slip sideways
        self._lines = stack(scans)
        self._time = np.repeat(np.arange(len(scans)), [len(scan.region) for scan in scans])
        self._row, self._whitener = _whitener(self._lines)

    def solve(self, tolerance: float = 1e-6, iterations: int = 20) -> Floats:
        """Iterate until no entry moves by more than `tolerance` (m, rad); return the poses, shape (T, 3)."""
        for _ in range(iterations):
            if self._step() < tolerance:
                break
        return np.column_stack([self.poses[:, :2], wrap_angles(self.poses[:, 2])])

    def _step(self) -> float:
        """Take one Gauss-Newton step; return its largest entry."""
        import gtsam

        graph = gtsam.GaussianFactorGraph()
        units = [gtsam.noiseModel.Unit.Create(n) for n in range(MAX_STATE + 1)]
        self._add_motions(graph)
        self._add_measurements(graph, units)
        change, count = graph.optimize(), len(self.poses)
        steps = np.array([change.at(k) for k in range(count)])
        self.poses += steps
        largest = float(np.abs(steps).max())
        for number in np.flatnonzero(self._place[:, 0] != UNSEEN).tolist():
            step = change.at(count + number)
            self.state[self._places(number)] += step
            largest = max(largest, float(np.abs(step).max()))
        return largest

    def _add_motions(self, graph: Any) -> None:
        """Add a factor for every step: the motion between two poses, in the frame of the first."""
        import gtsam

        before, after = np.vstack([self._start, self.poses[:-1]]), self.poses
        c, s = np.cos(before[:, 2]), np.sin(before[:, 2])
        dx, dy = (after - before)[:, :2].T
        ahead, aside = c * dx + s * dy, c * dy - s * dx
        turned = wrap_angles(self._moves[:, 2] - (after - before)[:, 2])
        residual = np.column_stack([self._moves[:, 0] - ahead, self._moves[:, 1] - aside, turned])
        by_after = np.zeros((len(after), 3, 3))
        by_after[:, 0, 0] = by_after[:, 1, 1] = c
        by_after[:, 0, 1], by_after[:, 1, 0], by_after[:, 2, 2] = s, -s, 1.0
        by_before = -by_after
        by_before[:, 0, 2], by_before[:, 1, 2] = aside, -ahead
        noise = [gtsam.noiseModel.Constrained.MixedSigmas(1e3, sigma) for sigma in self._motion_sigma]
        graph.add(gtsam.JacobianFactor(0, by_after[0], residual[0], noise[0]))
        for k in range(1, len(after)):
            graph.add(gtsam.JacobianFactor(k - 1, by_before[k], k, by_after[k], residual[k], noise[k]))

    def _add_measurements(self, graph: Any, units: list[Any]) -> None:
        """Add a factor for every measurement: the rows of its heading and its closed edges, whitened."""
        import gtsam

        lines, count = self._lines, len(self.poses)
        owner, poses = lines.owner, self.poses[self._time]
        phi, anchor = self.state[self._place[lines.region, 0]], self._anchor[lines.region]
        edges = self.state[self._place[lines.region[owner], lines.edge]]
        dense = np.zeros((len(lines.region), MAX_STATE, 5))  # by x, y, theta, phi, and the residual
        dense[:, 0, 2], dense[:, 0, 3] = -1.0, 1.0
        dense[:, 0, 4], dense[owner, self._row, 4] = residuals(lines, poses, phi, anchor, edges)
        dense[owner, self._row, :3], dense[owner, self._row, 3] = jacobians(lines, poses, phi, anchor)
        dense = self._whitener @ dense
        first = np.searchsorted(owner, np.arange(len(lines.region) + 1))
        column = _columns(self._place)
        for j, number in enumerate(lines.region.tolist()):
            seen = lines.edge[first[j] : first[j + 1]]
            rows = 1 + len(seen)
            by_region = np.zeros((rows, column[number].max() + 1))
            by_region[:, 0] = dense[j, :rows, 3]
            by_region[:, column[number, seen]] = self._whitener[j, :rows, 1:rows]
            rest = dense[j, :rows]
            graph.add(
                gtsam.JacobianFactor(
                    int(self._time[j]), rest[:, :3], count + number, by_region, rest[:, 4].copy(), units[rows]
                )
            )

    def _places(self, number: int) -> Ints:
        """Return where heading and edges of a region are in the state."""
        places = self._place[number]
        return places[places != UNSEEN]


def _columns(place: Ints) -> Ints:
    """Return the column of every heading and edge within the variable of its region, -1 for those unseen."""
    return np.where(place == UNSEEN, -1, np.cumsum(place != UNSEEN, axis=1) - 1)


def _whitener(lines: Lines) -> tuple[Ints, Floats]:
    """Return the row of every edge in its measurement's factor, and W with W^T W = R^-1, (M, MAX_STATE, MAX_STATE)."""
    first = np.searchsorted(lines.owner, lines.owner)
    row = np.arange(len(lines.owner)) - first + 1
    count = np.bincount(lines.owner, minlength=len(lines.region)) + 1
    whitener = np.zeros((len(lines.region), MAX_STATE, MAX_STATE))
    for rows in np.unique(count):
        chosen = np.flatnonzero(count == rows)
        at = lines.at[np.isin(lines.owner, chosen)].reshape(len(chosen), rows - 1)
        covariance = np.zeros((len(chosen), rows, rows))
        covariance[:, 0, 0] = lines.var_phi[chosen]
        covariance[:, 1:, 1:] = lines.noise[chosen[:, None, None], at[:, :, None], at[:, None]]
        whitener[chosen, :rows, :rows] = np.linalg.inv(np.linalg.cholesky(covariance))
    return row, whitener
