"""EKF-SLAM with known correspondence: the online optimum that a particle filter is measured against.

The same model as the filter's, without its approximations: one joint Gaussian over the pose and over heading and closed
edges of every region seen so far. Slow (quadratic in the size of the map), and told which region each measurement
shows. Open edges carry nothing.

No measurement tells where the frame of the map lies: only the certain start does. A plain EKF comes to believe
otherwise, for its Jacobians of different times disagree about what a motion of the whole frame is, and turns the map by
several standard deviations (Huang, Mourikis and Roumeliotis 2010). Here the error is measured in entries of which such
a motion changes the pose alone, whatever the estimate (an invariant EKF: Barrau and Bonnabel 2015).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.evaluation.lines import IS_U, Ints, Lines, jacobians, residuals
from slam.motion import MotionNoise, Odometry
from slam.region import MAX_STATE
from slam.rows import Floats
from slam.se2 import transform, wrap_angles

UNSEEN = -1


class EdgeEKF:
    """Extended Kalman filter over pose and regions in edge form.

    Parameters
    ----------
    noise
        Of the odometry.
    n_regions
        Number of true regions.
    pose
        Where the robot starts, known for certain.

    Attributes
    ----------
    mean
        Pose (x, y, theta), then headings and edges in the order in which they were first seen, shape (N,), m and rad;
        angles count full turns.
    place
        Where heading and edges of every region are in `mean`, shape (n_regions, MAX_STATE); UNSEEN if nowhere.
    anchor
        Anchors of the regions, shape (n_regions, 2), m: the middle of the first measurement, fixed from then on.
    """

    def __init__(self, noise: MotionNoise, n_regions: int, pose: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        self._noise = noise
        self.mean = np.array(pose, dtype=np.float64)
        self.place = np.full((n_regions, MAX_STATE), UNSEEN, np.int64)
        self.anchor = np.zeros((n_regions, 2))
        self._room = np.zeros((64, 64))

    @property
    def cov(self) -> Floats:
        """Covariance of `mean`, shape (N, N): a view, valid until the next step."""
        return self._room[: len(self.mean), : len(self.mean)]

    @property
    def pose_mean(self) -> Floats:
        """Pose (x, y, theta), theta in (-pi, pi]."""
        return np.array([self.mean[0], self.mean[1], wrap_angles(self.mean[2])])

    @property
    def pose_cov(self) -> Floats:
        """Covariance of the pose, shape (3, 3)."""
        return self._room[:3, :3].copy()

    def predict(self, odometry: Odometry) -> None:
        """Move by odometry, with the motion model of `slam.proposal.predict`."""
        noise, c, s = self._noise, np.cos(self.mean[2]), np.sin(self.mean[2])
        dx, dy = c * odometry.distance - s * odometry.lateral, s * odometry.distance + c * odometry.lateral
        driven = np.hypot(odometry.distance, odometry.lateral)
        by_pose = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
        along = np.array([c, s, 0.0])
        cov = self.cov
        cov[:3, 3:] = by_pose @ cov[:3, 3:]
        cov[3:, :3] = cov[:3, 3:].T
        own = by_pose @ cov[:3, :3] @ by_pose.T
        cov[:3, :3] = (own + own.T) / 2
        cov[:3, :3] += noise.distance * driven * np.outer(along, along)
        cov[2, 2] += noise.heading_per_metre * driven + noise.heading_per_radian * abs(odometry.rotation)
        self.mean[:3] += dx, dy, odometry.rotation

    def update(self, lines: Lines) -> None:
        """Take in a scan: first what it says of known headings and edges, then what it shows for the first time."""
        new = self.place[lines.region, 0] == UNSEEN
        new_edges = self.place[lines.region[lines.owner], lines.edge] == UNSEEN
        if not new.all():
            self._condition(lines, ~np.concatenate([new, new_edges]))
        if new.any():
            self._add_regions(lines, new)
        if new_edges.any():
            self._add_edges(lines, new_edges)

    def _condition(self, lines: Lines, rows: NDArray[np.bool_]) -> None:
        """Update with the given rows of headings and edges."""
        m, cov, before = len(lines.region), self.cov, self.mean
        noise = np.zeros((len(rows), len(rows)))
        noise[:m, :m], noise[m:, m:] = np.diag(lines.var_phi), lines.covariance
        places, values = (part[rows] for part in self._jacobian(lines))
        crossed = values[:, :3] @ cov[:3]  # H P
        crossed += values[:, 3:4] * cov[places[:, 3]]
        crossed += values[:, 4:] * cov[places[:, 4]]
        innovation = np.einsum("ra,jra->jr", values, crossed[:, places]) + noise[np.ix_(rows, rows)]
        whitener = np.linalg.inv(np.linalg.cholesky((innovation + innovation.T) / 2))
        gain = whitener @ crossed
        self.mean = before + gain.T @ (whitener @ np.concatenate(self._residuals(lines))[rows])
        cov -= gain.T @ gain
        self._carry_over(before)

    def _carry_over(self, before: Floats) -> None:
        """Restate the covariance of the error about the mean `before` as that of the error about the new mean.

        What stays are the errors of all headings, of the position less what the robot's heading error turns it about
        the origin, and of each edge's distance n . (a - p) + e from the robot.
        """
        region, edge = np.nonzero(self.place[:, 1:] != UNSEEN)
        e, phi = self.place[region, edge + 1], self.place[region, 0]
        old_normal, old_lever = self._normals(before, region, edge + 1)
        normal, lever = self._normals(self.mean, region, edge + 1)
        dx, dy = self.mean[:2] - before[:2]
        moved = np.array([-dy, dx])  # of the position per rad of heading
        turned, by_heading, by_robot = normal - old_normal, (old_lever - lever)[:, None], (normal @ moved)[:, None]
        cov = self.cov
        for half in (cov, cov.T):  # M C, then (M (M C)^T)^T
            half[e] += by_heading * half[phi] + turned @ half[:2] + by_robot * half[2]
            half[:2] += np.outer(moved, half[2])
        cov[:] = (cov + cov.T) / 2

    def _normals(self, mean: Floats, region: Ints, edge: Ints) -> tuple[Floats, Floats]:
        """Return the normals n of edges, shape (E, 2), and the derivative of n . (a - p) by their heading, (E,)."""
        phi, along = mean[self.place[region, 0]], IS_U[edge]
        c, s = np.cos(phi), np.sin(phi)
        dx, dy = (self.anchor[region] - mean[:2]).T
        normal = np.stack([np.where(along, c, -s), np.where(along, s, c)], axis=1)
        return normal, np.where(along, c * dy - s * dx, -c * dx - s * dy)

    def _add_regions(self, lines: Lines, new: NDArray[np.bool_]) -> None:
        """Begin regions: phi = theta + phi_z, and an anchor."""
        count = int(new.sum())
        c, s = np.cos(lines.phi[new]), np.sin(lines.phi[new])
        u, v = lines.middle[new].T
        self.anchor[lines.region[new]] = transform(self.mean[:3], np.stack([c * u - s * v, s * u + c * v], axis=1))
        by_state = np.zeros((count, len(self.mean)))
        by_state[:, 2] = 1.0
        self.place[lines.region[new], 0] = self._append(
            self.mean[2] + lines.phi[new], by_state, np.diag(lines.var_phi[new])
        )

    def _add_edges(self, lines: Lines, new: NDArray[np.bool_]) -> None:
        """Begin edges: e solves its row, given what the known edges' rows say of the noise that it shares with them."""
        old = ~new
        noise = lines.covariance
        shared = np.linalg.solve(noise[np.ix_(old, old)], noise[np.ix_(old, new)]).T
        places, values = self._jacobian(lines)
        places, values = places[len(lines.region) :], values[len(lines.region) :]
        by_state = np.zeros((len(new), len(self.mean)))
        np.add.at(by_state, (np.arange(len(new))[:, None], places), values)
        _, residual = self._residuals(lines)
        added = self._append(
            residual[new] - shared @ residual[old],
            shared @ by_state[old] - by_state[new],
            noise[np.ix_(new, new)] - shared @ noise[np.ix_(old, new)],
        )
        self.place[lines.region[lines.owner[new]], lines.edge[new]] = added

    def _append(self, mean: Floats, by_state: Floats, noise: Floats) -> Ints:
        """Add variables that are linear in the state, shape (n, N), up to a noise (n, n); return their places."""
        size, total = len(self.mean), len(self.mean) + len(mean)
        if total > len(self._room):
            room = np.zeros((2 * total, 2 * total))
            room[:size, :size] = self.cov
            self._room = room
        crossed = by_state @ self._room[:size, :size]
        self._room[size:total, :size], self._room[:size, size:total] = crossed, crossed.T
        own = crossed @ by_state.T + noise
        self._room[size:total, size:total] = (own + own.T) / 2
        self.mean = np.concatenate([self.mean, mean])
        return np.arange(size, total)

    def _residuals(self, lines: Lines) -> tuple[Floats, Floats]:
        """Return all rows; those of edges that aren't known yet as if they were at 0."""
        places = self.place[lines.region[lines.owner], lines.edge]
        edges = np.where(places == UNSEEN, 0.0, self.mean[places])
        return residuals(lines, self.mean[:3], self._headings(lines), self.anchor[lines.region], edges)

    def _jacobian(self, lines: Lines) -> tuple[Ints, Floats]:
        """Return where in the state the entries of all rows are, and -dr/d(x, y, theta, phi, e), shapes (M + K, 5)."""
        m, k = len(lines.region), len(lines.owner)
        edge_places = self.place[lines.region[lines.owner], lines.edge]
        places, values = np.zeros((m + k, 5), np.int64), np.zeros((m + k, 5))
        places[:, 1:3] = 1, 2
        places[:m, 3], places[m:, 3] = self.place[lines.region, 0], self.place[lines.region[lines.owner], 0]
        places[m:, 4] = np.maximum(edge_places, 0)
        values[:m, 2], values[:m, 3] = -1.0, 1.0
        values[m:, :3], values[m:, 3] = jacobians(
            lines, self.mean[:3], self._headings(lines), self.anchor[lines.region]
        )
        values[m:, 4] = edge_places != UNSEEN
        return places, values

    def _headings(self, lines: Lines) -> Floats:
        """Return the heading of every measurement's region; a new one's is as good as any."""
        return self.mean[self.place[lines.region, 0]]
