"""Kalman update of the joint Gaussian (Oberländer et al. 2008, eqs. 3–6, for pose and all regions together).

No measurement tells where the whole scene, robot and map, is and how it is turned. A plain EKF learns it all the same,
because it linearises at estimates that change from scan to scan (Huang, Mourikis and Roumeliotis 2010), and grows
overconfident. So what the covariance says of rigid motions of the scene is carried along when an update moves the
estimate from x to x', as the invariant EKF does (Barrau and Bonnabel 2015). With M(x) the derivative of the state by a
shift and a turn of the scene, about the robot's place before the update::

    P <- A P A^T        A = I + (M(x') - M(x)) E^T        E^T x = pose

    M: p: I, J (p - c)    theta, phi: 0, 1    e along n: n^T, n . J (a - c)        J = [0 -1; 1 0]

Without noise the rows of all later scans then stay blind to such motions: H(x') M(x') = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from slam.innovation import wrap
from slam.jit import Array, Record, njit
from slam.joint_gaussian import POSE, USED, JointGaussian
from slam.region import is_u

TERMS = 6
"""Most entries of the state that a row depends on."""


class Rows(NamedTuple):
    """Rows of an update: residual = sum_t coefficient_t (x - mean)[places_t] + noise."""

    places: np.ndarray  # (R, TERMS) entries of the joint state
    coefficient: np.ndarray  # (R, TERMS)
    residual: np.ndarray  # (R,)
    noise: np.ndarray  # (R, R) covariance
    fresh: np.ndarray  # (R,) whether the row only settles an entry that was flat before

    @classmethod
    def empty(cls, count: int) -> Rows:
        """Return room for so many rows."""
        return cls(
            np.zeros((count, TERMS), np.int64),
            np.zeros((count, TERMS)),
            np.zeros(count),
            np.zeros((count, count)),
            np.zeros(count, np.bool_),
        )

    def first(self, count: int) -> Rows:
        """Return the first `count` rows, those that settle something new last."""
        order = np.argsort(self.fresh[:count], kind="stable")
        return Rows(
            self.places[order],
            self.coefficient[order],
            self.residual[order],
            self.noise[np.ix_(order, order)],
            self.fresh[order],
        )


def condition(joint: JointGaussian, rows: Rows, gate: float = np.inf) -> tuple[float, float, int]:
    """Update the Gaussian with rows, those of known entries before the fresh ones.

    Returns
    -------
    distance, log_det, count
        Squared norm of the whitened innovation of the rows of known entries, log det of its covariance, and their
        number: what their likelihood is made of. Beyond the gate nothing is updated.
    """
    used, known = joint.used, int(np.count_nonzero(~rows.fresh))
    gain, innovation = np.empty((len(rows.residual), used)), rows.noise.copy()
    project(joint.cov, rows.places, rows.coefficient, gain, innovation)
    factor = np.linalg.cholesky(innovation)
    whitener = np.linalg.inv(factor)
    gain, whitened = whitener @ gain, whitener @ rows.residual
    distance = float(whitened[:known] @ whitened[:known])
    log_det = 2 * float(np.sum(np.log(np.diag(factor)[:known])))
    if distance < gate:
        apply(joint, whitened @ gain, gain.T @ gain)
    return distance, log_det, known


@njit
def project(cov: Array, places: Array, coefficient: Array, gain: Array, innovation: Array) -> None:
    """Write H P, shape (R, used), and add H P H^T to `innovation`, shape (R, R)."""
    count, size = gain.shape
    for r in range(count):
        gain[r] = 0.0
        for t in range(places.shape[1]):
            factor, source = coefficient[r, t], cov[places[r, t]]
            if factor != 0.0:
                for a in range(size):
                    gain[r, a] += factor * source[a]
    for r in range(count):
        for q in range(r + 1):
            total = 0.0
            for t in range(places.shape[1]):
                total += coefficient[q, t] * gain[r, places[q, t]]
            innovation[r, q] += total
            if q < r:
                innovation[q, r] += total


@njit
def apply(joint: Record, change: Array, loss: Array) -> None:
    """Add a change to the mean, take a loss from the covariance, and carry the scene's motions along (see above)."""
    used, cov = joint.counts[USED], joint.cov
    centre = joint.mean[:2].copy()
    before, after = np.zeros((POSE, used)), np.zeros((POSE, used))
    scene_motions(joint, centre, before)
    for a in range(used):
        joint.mean[a] += change[a]
    joint.mean[2] = wrap(joint.mean[2])
    scene_motions(joint, centre, after)
    step, of_pose = after - before, cov[:POSE, :used] - loss[:POSE]
    # P + V B + (V B)^T with B = E^T P + (E^T P E) V^T / 2 for V = step
    crossed = of_pose.copy()
    for i in range(POSE):
        for j in range(POSE):
            for a in range(used):
                crossed[i, a] += of_pose[i, j] * step[j, a] / 2
    for a in range(used):
        for b in range(a + 1):
            value = cov[a, b] - loss[a, b]
            for i in range(POSE):
                value += step[i, a] * crossed[i, b] + crossed[i, a] * step[i, b]
            cov[a, b] = cov[b, a] = value


@njit
def scene_motions(joint: Record, centre: Array, out: Array) -> None:
    """Write M(x)^T, shape (3, used): pose and map shifted along x and y, and turned about a centre."""
    out[0, 0] = out[1, 1] = out[2, 2] = 1.0
    out[2, 0], out[2, 1] = centre[1] - joint.mean[1], joint.mean[0] - centre[0]
    for slot in range(len(joint.entries)):
        entries = joint.entries[slot]
        if entries[0] < 0:
            continue
        phi = joint.mean[entries[0]]
        c, s = np.cos(phi), np.sin(phi)
        x, y = joint.anchors[slot, 0] - centre[0], joint.anchors[slot, 1] - centre[1]
        out[2, entries[0]] = 1.0
        for k in range(1, len(entries)):
            if entries[k] >= 0:
                nx, ny = (c, s) if is_u(k) else (-s, c)
                out[0, entries[k]], out[1, entries[k]] = nx, ny
                out[2, entries[k]] = ny * x - nx * y
