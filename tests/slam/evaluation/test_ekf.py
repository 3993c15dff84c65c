"""The EKF against its linear twin, the filter's motion model, and the truth."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numba
import numpy as np
import pytest

from regionslam_env.config import NoiseConfig, SensorConfig
from regionslam_env.sensors.odometry import OdometrySensor
from regionslam_env.sensors.region_sensor import RegionSensor
from slam.evaluation.consistency import nees, nees_band, pose_nees
from slam.evaluation.ekf import UNSEEN, EdgeEKF
from slam.evaluation.lines import IS_U, Lines, lines_of, residuals, state_of
from slam.evaluation.matching import moved
from slam.motion import MotionNoise, Odometry
from slam.proposal import predict
from slam.region import MAX_STATE
from slam.se2 import between, compose, inverse
from tests.floors import two_rooms
from tests.slam.drawn import particles

POSES = np.array(
    [(1, 1, 0), (2, 1.2, 0.3), (3, 2, 0.6), (4, 2.1, 0.1), (5, 2, -0.1), (7, 2, 0.2), (9, 2.5, 2), (8, 1, 3)]
)


def drive(seed, settings, poses=POSES, **config):
    """Odometry, lines and true poses (relative to the first one) of a drive through two rooms, and the world."""
    world = two_rooms()
    odometer = OdometrySensor(settings, np.random.default_rng(seed))
    sensor = RegionSensor(SensorConfig(**config), settings, world.arrays, np.random.default_rng((seed, 1)))
    moves, scans = [], []
    for before, after in pairwise(poses):
        moves.append(odometer.measure(before, after))
        records = sensor.measure(after).records
        scans.append(lines_of(records, sensor.sources))
    return moves, scans, between(poses[0], poses[1:]), world


def truth_about(world, start, anchors):
    """Heading and edges of every true region relative to its anchor, in the frame of the start pose."""
    rows = [moved(region.row, inverse(start)) for region in world.regions]
    return np.array([state_of(row, anchor) for row, anchor in zip(rows, anchors, strict=True)])


def test_prediction_is_that_of_the_filter():
    rng = np.random.default_rng(0)
    ekf = EdgeEKF(MotionNoise(0.01, 0.02, 0.03), 2, rng.normal(size=3))
    robot = particles(ekf.pose_mean)
    for distance, lateral, rotation in rng.normal(0, 0.5, (5, 3)):
        ekf.predict(Odometry(distance, lateral, rotation))
        predict(robot, distance, lateral, rotation, 0.01, 0.02, 0.03)
    assert np.allclose(ekf.pose_mean, robot[0].pose)
    assert np.allclose(ekf.pose_cov, robot[0].cov)


def test_it_is_the_kalman_filter_of_the_linear_problem():
    """With hardly any error all is linear: a filter that holds all edges from the start, flat, ends at the same."""
    settings = NoiseConfig(simulated_factor=1e-8, odometry_factor=1e-8)
    moves, scans, true, world = drive(3, settings, range=2.5)
    ekf = EdgeEKF(settings.odometry, 3)
    sizes = []
    for move, lines in zip(moves, scans, strict=True):
        ekf.predict(move)
        ekf.update(lines)
        sizes.append(len(ekf.mean))
    assert len(set(sizes)) == 4  # edges keep coming in
    mean, cov = _flat_twin(settings.odometry, moves, scans, true, truth_about(world, POSES[0], ekf.anchor), ekf.anchor)
    held = np.concatenate([[0, 1, 2], 3 + np.flatnonzero(ekf.place != UNSEEN)])
    order = np.concatenate([[0, 1, 2], ekf.place[ekf.place != UNSEEN]])
    assert len(held) == len(ekf.mean)
    assert np.allclose(ekf.mean[order], mean[held], rtol=0, atol=1e-8)
    assert np.allclose(ekf.cov[np.ix_(order, order)], cov[np.ix_(held, held)], rtol=0, atol=1e-6)
    assert np.array_equal(ekf.cov, ekf.cov.T)


def _flat_twin(noise, moves, scans, true, regions, anchors):
    """Linear Kalman filter on the deviation from the truth, Jacobians by finite differences."""
    base = np.concatenate([np.zeros(3), np.nan_to_num(regions).ravel()])
    deviation, cov = np.zeros(len(base)), np.diag([0.0] * 3 + [1e5] * (len(base) - 3))

    def moved(pose, move, errors):
        return compose(pose, (move.distance + errors[0], move.lateral, move.rotation + errors[1]))

    for move, pose, lines in zip(moves, true, scans, strict=True):
        before = base[:3].copy()
        f, g = np.eye(len(base)), np.zeros((len(base), 2))
        f[:3, :3] = _differences(lambda x, move=move: moved(x, move, (0, 0)), before)
        g[:3] = _differences(lambda e, move=move, before=before: moved(before, move, e), np.zeros(2))
        driven = np.hypot(move.distance, move.lateral)
        variances = [
            noise.distance * driven,
            noise.heading_per_metre * driven + noise.heading_per_radian * abs(move.rotation),
        ]
        offset = moved(before, move, (0, 0)) - pose
        cov = f @ cov @ f.T + g @ np.diag(variances) @ g.T
        deviation = f @ deviation
        deviation[:3] += offset
        base[:3] = pose

        def rows(state, lines=lines):
            table = state[3:].reshape(-1, MAX_STATE)
            own = lines.region[lines.owner]
            phi = table[lines.region, 0]
            return np.concatenate(residuals(lines, state[:3], phi, anchors[lines.region], table[own, lines.edge]))

        h, m = -_differences(rows, base), len(lines.region)
        r = np.zeros((len(h), len(h)))
        r[:m, :m], r[m:, m:] = np.diag(lines.var_phi), lines.covariance
        gain = cov @ h.T @ np.linalg.inv(h @ cov @ h.T + r)
        deviation = deviation + gain @ (rows(base) - h @ deviation)
        keep = np.eye(len(base)) - gain @ h
        cov = keep @ cov @ keep.T + gain @ r @ gain.T
    return base + deviation, cov


def _differences(function, at, step=1e-5):
    columns = [(function(at + d) - function(at - d)) / (2 * step) for d in step * np.eye(len(at))]
    return np.stack(columns, axis=1)


def test_measurements_never_tell_where_the_frame_lies():
    """Begun at an uncertain pose, the same drive gives the same map, as uncertain as before plus that of the frame."""
    settings = NoiseConfig()
    moves, scans, _, _ = drive(5, settings, range=2.5)
    frame = np.array([[0.04, 0.01, 0.002], [0.01, 0.09, -0.003], [0.002, -0.003, 0.01]])
    certain, uncertain = EdgeEKF(settings.odometry, 3), EdgeEKF(settings.odometry, 3)
    uncertain.cov[:] = frame
    for move, lines in zip(moves, scans, strict=True):
        for ekf in (certain, uncertain):
            ekf.predict(move)
            ekf.update(lines)
    assert np.allclose(uncertain.mean, certain.mean, atol=1e-7)
    motion = np.zeros((len(certain.mean), 3))  # what a motion of the frame, x, y and a turn about the start, changes
    motion[:3] = np.eye(3)
    motion[:2, 2] = -certain.mean[1], certain.mean[0]
    for number, known in enumerate(certain.place != UNSEEN):
        if known[0]:
            phi, anchor = certain.mean[certain.place[number, 0]], certain.anchor[number]
            c, s = np.cos(phi), np.sin(phi)
            motion[certain.place[number, 0], 2] = 1.0
            for edge in np.flatnonzero(known)[1:]:
                n = np.array([c, s] if IS_U[edge] else [-s, c])
                across = np.array([-n[1], n[0]])
                motion[certain.place[number, edge], :2] = n
                motion[certain.place[number, edge], 2] = -across @ anchor
    assert np.allclose(uncertain.cov, certain.cov + motion @ frame @ motion.T, atol=1e-7)


def test_a_scan_of_nothing_changes_nothing():
    settings = NoiseConfig()
    _, scans, *_ = drive(0, settings)
    empty = Lines(*(getattr(scans[0], field.name)[:0] for field in dataclasses.fields(Lines)))
    ekf = EdgeEKF(settings.odometry, 3)
    for lines in (empty, scans[0]):
        ekf.update(lines)
    before = ekf.mean.copy(), ekf.cov.copy()
    ekf.update(empty)
    assert np.array_equal(ekf.mean, before[0])
    assert np.array_equal(ekf.cov, before[1])


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="many scans")
def test_its_covariance_is_honest():
    """NEES of the last pose, and of all edges of a room seen in pieces, over 60 drives with told noise."""
    settings, count = NoiseConfig(simulated_factor=1.0), 60
    legs = [np.linspace(a, b, 8, endpoint=False) for a, b in pairwise(POSES)]
    pose_values, room_values = [], []
    for seed in range(count):
        moves, scans, true, world = drive(seed, settings, np.concatenate(legs), range=3.5, n_view_rays=90)
        ekf = EdgeEKF(settings.odometry, 3)
        for move, lines in zip(moves, scans, strict=True):
            ekf.predict(move)
            ekf.update(lines)
        pose_values.append(pose_nees(ekf.pose_mean, ekf.pose_cov, true[-1]))
        places = ekf.place[1][ekf.place[1] != UNSEEN]
        error = ekf.mean[places] - truth_about(world, legs[0][0], ekf.anchor)[1][ekf.place[1] != UNSEEN]
        assert len(places) == 5
        room_values.append(nees(error, ekf.cov[np.ix_(places, places)]))
    low, high = nees_band(count, 3, 0.999)
    assert low < np.mean(pose_values) < high
    low, high = nees_band(count, 5, 0.999)
    assert low < np.mean(room_values) < high
