"""The optimum of recorded data with known correspondence: online by an EKF, and smoothed over the whole tour."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from agents.recording import Recording
from slam.evaluation.consistency import nees
from slam.evaluation.ekf import UNSEEN, EdgeEKF
from slam.evaluation.lines import Lines, lines_of, state_of
from slam.evaluation.matching import moved
from slam.rows import Floats
from slam.se2 import inverse


def lines(recording: Recording) -> list[Lines]:
    """Return the closed edges of every scan."""
    return [lines_of(scan.records, sources) for scan, sources in zip(recording.scans, recording.sources, strict=True)]


def online(recording: Recording) -> tuple[EdgeEKF, Floats, Floats]:
    """Run the EKF along a recording; return it with poses (T, 3) and their covariances (T, 3, 3)."""
    ekf = EdgeEKF(recording.noise.odometry, len(recording.world.regions))
    poses, covariances = np.empty((len(recording.moves), 3)), np.empty((len(recording.moves), 3, 3))
    for k, (move, scan) in enumerate(zip(recording.moves, lines(recording), strict=True)):
        ekf.predict(move)
        ekf.update(scan)
        poses[k], covariances[k] = ekf.pose_mean, ekf.pose_cov
    return ekf, poses, covariances


def ekf_region_nees(ekf: EdgeEKF, recording: Recording) -> Iterator[tuple[float, int]]:
    """Yield for every region of the EKF the NEES of its heading and closed edges, and how many they are."""
    for number, region in enumerate(recording.world.regions):
        known = ekf.place[number] != UNSEEN
        if known.any():
            places = ekf.place[number, known]
            truth = state_of(moved(region.row, inverse(recording.start)), ekf.anchor[number])[known]
            error = ekf.mean[places] - truth
            error[0] = np.remainder(error[0] + np.pi, 2 * np.pi) - np.pi
            yield float(nees(error, ekf.cov[np.ix_(places, places)])), len(places)
