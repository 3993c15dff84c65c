"""The whole filter with a joint posterior."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from slam.belief import Belief
from slam.config import SlamConfig
from slam.fastslam import RegionSLAM
from slam.measurement import MeasurementNoise, RegionMeasurement, Scan
from slam.motion import MotionNoise, Odometry
from slam.region import EdgeState
from slam.se2 import compose, inverse

OPEN = EdgeState.OPEN
NOISE = MeasurementNoise()
STANDING = Odometry(0.0)
ROOMS = [
    RegionMeasurement("office", 2.0, 1.0, 4.0, 3.0, 0.1),
    RegionMeasurement("kitchen", 7.0, 1.5, 4.0, 3.0, 0.1),
    RegionMeasurement("storage", 4.0, -3.0, 2.0, 2.0, 0.1),
]


def joint(n: int = 1, **settings: object) -> RegionSLAM:
    return RegionSLAM(SlamConfig(n, posterior="joint", **settings), seed=0)  # type: ignore[arg-type]


def seen(pose: np.ndarray, *regions: RegionMeasurement, rng: np.random.Generator | None = None) -> Scan:
    """What a sensor at a true pose measures of regions; exactly without a generator."""
    out = []
    for z in regions:
        x, y, phi = compose(inverse(pose), (z.x, z.y, z.phi))
        noise = np.zeros(5) if rng is None else rng.standard_normal(5)
        w = z.w + NOISE.sigma_wh * min(z.w, 1.0) * noise[2]
        h = z.h + NOISE.sigma_wh * min(z.h, 1.0) * noise[3]
        x, y, phi = x + NOISE.sigma_xy * noise[0], y + NOISE.sigma_xy * noise[1], phi + NOISE.sigma_phi * noise[4]
        cov_wh = np.diag([NOISE.variance_of_size(z.w), NOISE.variance_of_size(z.h)])
        out.append(RegionMeasurement(z.type, x, y, w, h, phi, t=z.t, b=z.b, l=z.l, r=z.r, cov_wh=cov_wh))
    return Scan(out)


def region(belief: Belief, type: str) -> np.record:
    return next(m for m in belief.features if belief.types[m.type] == type)


def test_scans_from_a_certain_pose_average_out() -> None:
    slam = joint()
    for _ in range(25):
        belief = slam.step(STANDING, seen(np.zeros(3), ROOMS[0]), pose=(0, 0, 0))
    m = region(belief, "office")
    edge = NOISE.sigma_xy**2 + NOISE.sigma_wh**2 / 4
    np.testing.assert_allclose(np.diag(m.cov)[1:5], edge / 25, rtol=1e-3)
    assert m.cov[0, 0] == pytest.approx(NOISE.sigma_phi**2 / 25, rel=1e-3)
    assert not belief.pose_cov.any()
    (office,) = belief.map.regions
    assert (office.x, office.y, office.w, office.h, office.phi) == pytest.approx((2, 1, 4, 3, 0.1), abs=1e-9)


def test_a_region_out_of_sight_learns_from_one_that_closes_the_loop() -> None:
    slam = joint(motion_noise=MotionNoise(0.01, 0.001, 0.001))
    pose = np.zeros(3)
    for _ in range(5):
        slam.step(STANDING, seen(pose, ROOMS[0]))
    for _ in range(20):
        pose = compose(pose, (0.2, 0.0, 0.05))
        slam.predict(Odometry(0.2, 0.0, 0.05))
    for _ in range(5):
        belief = slam.step(STANDING, seen(pose, ROOMS[1]))
    before = region(belief, "kitchen").cov[1, 1]
    belief = slam.step(STANDING, seen(pose, ROOMS[0]))
    assert region(belief, "kitchen").cov[1, 1] < 0.7 * before
    assert region(belief, "kitchen").last_seen < slam.progress[0]


def drive(slam: RegionSLAM, steps: int, seed: int, start: np.ndarray) -> tuple[Belief, np.ndarray]:
    """Drive in a circle from a true pose; every room is in view. Returns the belief and the true pose."""
    rng, pose = np.random.default_rng(seed), start
    noise = slam.config.motion_noise
    for _ in range(steps):
        pose = compose(pose, (0.2, 0.0, 0.1))
        variance = noise.heading_per_metre * 0.2 + noise.heading_per_radian * 0.1
        odometry = Odometry(
            0.2 + np.sqrt(noise.distance * 0.2) * rng.normal(), 0.0, 0.1 + np.sqrt(variance) * rng.normal()
        )
        belief = slam.step(odometry, seen(pose, *ROOMS, rng=rng))
    return belief, pose


def test_errors_are_as_large_as_stated() -> None:
    errors, covariances = [], []
    for seed in range(6):
        belief, pose = drive(joint(), 12, seed, np.zeros(3))
        error = belief.pose_mean - pose
        error[2] = (error[2] + np.pi) % (2 * np.pi) - np.pi
        errors.append(error)
        covariances.append(belief.pose_cov)
        assert sorted(r.type for r in belief.map.regions) == ["kitchen", "office", "storage"]
    nees = [e @ np.linalg.solve(c, e) for e, c in zip(errors, covariances, strict=True)]
    assert 8.2 < np.sum(nees) < 31.5  # 95 % band of a chi-square variable with 18 degrees of freedom


def test_results_do_not_depend_on_where_the_map_frame_lies() -> None:
    start = np.array([120.0, -70.0, 2.0])
    here, there = joint(), joint()
    there.reset(start)
    a, _ = drive(here, 10, 3, np.zeros(3))
    b, _ = drive(there, 10, 3, np.zeros(3))
    np.testing.assert_allclose(compose(start, a.pose_mean), b.pose_mean, atol=1e-6)
    c, s = np.cos(start[2]), np.sin(start[2])
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(rotation @ a.pose_cov @ rotation.T, b.pose_cov, atol=1e-8)
    for m, n in zip(a.features, b.features, strict=True):
        np.testing.assert_allclose(m.state[1:5], n.state[1:5], atol=1e-6)


DOORS = [RegionMeasurement("door", 4.0, y, 0.9, 0.2, np.pi / 2) for y in (-1.2, 0.0)]


def test_hypotheses_branch_where_a_scan_is_ambiguous_and_the_wrong_one_is_pruned() -> None:
    slam = joint(4, motion_noise=MotionNoise(0.02, 0.004, 0.0))
    pose = np.zeros(3)
    for _ in range(8):
        slam.step(STANDING, seen(pose, *DOORS))
    slam.predict(Odometry(5.0))
    slam.predict(Odometry(-5.0))  # where it was, as far as it knows, give or take half a metre
    between = np.array([0.0, -0.55, 0.0])
    belief = slam.step(STANDING, seen(between, DOORS[0]))
    assert len(belief.particles) == 2
    lateral = sorted(belief.particles["pose"][:, 1])
    assert lateral[1] - lateral[0] > 0.4
    first, second = slam._posterior.gaussians  # type: ignore[union-attr]
    assert not any(np.shares_memory(a, b) for a, b in zip(first, second, strict=True))
    assert slam._posterior.cloud.maps.holders.max() == 1
    for _ in range(6):
        belief = slam.step(STANDING, seen(between, *DOORS))
    assert len(belief.particles) == 1
    assert belief.pose_mean[1] == pytest.approx(-0.55, abs=0.2)


def test_a_region_seen_from_both_sides_becomes_one() -> None:
    """Of a long hall both ends are seen, each alone; then its middle closes the gap, and one region is left."""
    slam = joint()
    west = RegionMeasurement("hallway", -4.0, 0.0, 4.0, 2.0, r=OPEN)
    east = RegionMeasurement("hallway", 5.0, 0.0, 4.0, 2.0, l=OPEN)
    for _ in range(4):
        belief = slam.step(STANDING, seen(np.zeros(3), west, east))
    assert len(belief.features) == 2
    for x in np.linspace(-3, 4, 15):
        middle = RegionMeasurement("hallway", x, 0.0, 4.0, 2.0, l=OPEN, r=OPEN)
        belief = slam.step(STANDING, seen(np.zeros(3), middle))
    (hall,) = belief.features
    assert hall.closed[:5].all()
    feature = belief.map.regions[0]
    assert (feature.x, feature.w, feature.h) == pytest.approx((0.5, 13.0, 2.0), abs=0.1)
    assert (slam._posterior.gaussians[0].entries[:, 0] >= 0).sum() == 1  # type: ignore[union-attr]


def test_a_stored_filter_goes_on_bit_identically(tmp_path: Path) -> None:
    slam = joint(4)
    drive(slam, 4, 7, np.zeros(3))
    slam.save(tmp_path / "filter.npz")
    loaded = RegionSLAM.load(tmp_path / "filter.npz")
    (a, _), (b, _) = (drive(copy, 3, 8, np.zeros(3)) for copy in (slam, loaded))
    assert a.pose_mean.tobytes() == b.pose_mean.tobytes()
    assert a.features.tobytes() == b.features.tobytes()


def test_what_the_joint_posterior_cannot_do_is_refused() -> None:
    with pytest.raises(ValueError, match="posterior is 'joint', expected 'fastslam2'"):
        joint().relocalise()
    with pytest.raises(ValueError, match="geometric_update is 'paper', expected 'edges'"):
        SlamConfig(posterior="joint", geometric_update="paper")


def test_an_unknown_posterior_is_refused() -> None:
    with pytest.raises(ValueError, match="posterior is 'ekf', expected one of 'fastslam2', 'joint'"):
        SlamConfig(posterior="ekf")
