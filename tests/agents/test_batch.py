"""The smoothed optimum: at the last pose it is the online one, wherever the iteration begins."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from agents import batch
from agents.batch import Batch
from regionslam_env.config import NoiseConfig
from slam.evaluation.ekf import EdgeEKF
from slam.motion import MotionNoise
from tests.slam.evaluation.test_ekf import POSES, drive

PATH = np.concatenate([np.linspace(a, b, 8, endpoint=False) for a, b in pairwise(POSES)])


def filtered(moves, scans, settings):
    """An EKF at the end of a drive, and its poses on the way."""
    ekf, poses = EdgeEKF(settings.odometry, 3), []
    for move, lines in zip(moves, scans, strict=True):
        ekf.predict(move)
        ekf.update(lines)
        poses.append(ekf.pose_mean)
    return ekf, np.array(poses)


@pytest.mark.parametrize("seed", [0, 1])
def test_with_little_noise_the_ekf_ends_where_the_batch_does(seed):
    pytest.importorskip("gtsam")
    settings = NoiseConfig(simulated_factor=1e-6, odometry_factor=1e-6)
    moves, scans, true, _ = drive(seed, settings, PATH, range=3.5)
    ekf, poses = filtered(moves, scans, settings)
    problem = Batch(settings.odometry, moves, scans, ekf, poses)
    smoothed = problem.solve()
    scale = 1e-3 * np.sqrt(np.diag(ekf.pose_cov))
    assert np.abs((ekf.pose_mean - smoothed[-1]) / scale).max() < 0.01
    assert np.abs((ekf.mean - problem.state)[3:]).max() < 1e-5
    assert np.abs((poses - smoothed) / scale).max() > 0.1  # on the way they differ
    assert np.abs((ekf.pose_mean - true[-1]) / scale).max() > 0.1


def test_it_does_not_depend_on_where_it_begins():
    pytest.importorskip("gtsam")
    settings = NoiseConfig()
    moves, scans, _, _ = drive(0, settings, PATH, range=3.5)
    ekf, poses = filtered(moves, scans, settings)
    smoothed = Batch(settings.odometry, moves, scans, ekf, poses).solve()
    elsewhere = poses + np.random.default_rng(0).normal(0, 0.05, poses.shape)
    assert np.abs(Batch(settings.odometry, moves, scans, ekf, elsewhere).solve() - smoothed).max() < 1e-5
    assert 0.001 < np.abs(poses - smoothed).max() < 0.5


def test_without_gtsam_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(batch, "AVAILABLE", False)
    with pytest.raises(ModuleNotFoundError, match=r'pip install -e "\.\[ref\]"'):
        Batch(MotionNoise(), [], [], EdgeEKF(MotionNoise(), 1), np.zeros((0, 3)))
