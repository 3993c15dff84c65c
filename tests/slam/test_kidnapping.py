"""A robot carried from one end of its map to the other: the filter notices, writes nothing, and finds itself."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from slam.belief import Belief
from slam.config import SlamConfig
from slam.fastslam import RegionSLAM
from slam.measurement import RegionMeasurement, Scan
from slam.motion import Odometry
from slam.se2 import between

pytestmark = pytest.mark.compiled

ROOMS = [(0.0, 3.5, 4.0, 3.0), (4.0, 3.5, 3.5, 3.0), (0.0, -3.0, 5.0, 2.0), (4.5, -3.0, 3.0, 2.5)]
FAR = 40.0
FLOOR = [*ROOMS, *((FAR + y, x, h + 0.7, w) for x, y, w, h in ROOMS)]
"""Midpoints and sizes of rooms at two places 40 m apart."""

VIEW = 8 * np.array([(np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 60, endpoint=False)])


def scan(pose: np.ndarray, noise: np.random.Generator) -> Scan:
    seen = []
    for x, y, w, h in FLOOR:
        px, py, phi = between(pose, (x, y, 0.0))
        if np.hypot(px, py) < 7:
            dx, dy = 0.05 * noise.standard_normal(2)
            seen.append(RegionMeasurement("office", px + dx, py + dy, w, h, phi))
    return Scan(seen, VIEW)


def drive(slam: RegionSLAM) -> Iterator[tuple[np.ndarray, Belief]]:
    """To the other end and back by hand: true poses with beliefs."""
    noise = np.random.default_rng(0)
    ahead = [(0.02 * k, 0.0, 0.0) for k in range(15)]
    way = [(2.0 * k, 0.0, 0.0) for k in range(1, 20)]
    there = [(FAR + 0.02 * k, 0.0, 0.0) for k in range(15)]
    carried = [(0.5 + 0.02 * k, 0.3, 2.0) for k in range(45)]
    poses = np.array([*ahead, *way, *there, *carried])
    for k, pose in enumerate(poses):
        before = poses[k - 1] if k and k != len(poses) - len(carried) else pose
        yield pose, slam.step(Odometry(*between(before, pose)), scan(pose, noise))


CARRIED_AT = 15 + 19 + 15


@pytest.fixture(scope="module")
def run() -> list[tuple[np.ndarray, np.ndarray, bool, bytes, int]]:
    """Of each step: true pose, believed pose, whether lost, all written records, number of regions."""
    slam = RegionSLAM(SlamConfig(n_particles=3), seed=0)
    return [
        (pose, belief.pose_mean.copy(), belief.lost, belief.maps.pool.tobytes(), len(belief.map.hypotheses))
        for pose, belief in drive(slam)
    ]


def test_it_is_lost_soon_and_not_before(run: list) -> None:
    lost = [step[2] for step in run]
    assert not any(lost[: CARRIED_AT + 1])
    assert any(lost[CARRIED_AT : CARRIED_AT + 8])


def test_it_finds_itself_and_stays(run: list) -> None:
    lost = [step[2] for step in run]
    found = CARRIED_AT + 8 + lost[CARRIED_AT + 8 :].index(False)
    assert found < CARRIED_AT + 30
    assert not any(lost[found:])
    for true, believed, *_ in run[found:]:
        assert believed == pytest.approx(true, abs=0.2)


def test_meanwhile_nothing_is_written_to_the_map(run: list) -> None:
    written = {step[3] for step in run[CARRIED_AT:] if step[2]}
    assert len(written) == 1
    assert {step[4] for step in run[CARRIED_AT:]} == {len(FLOOR)}


def test_without_relocalisation_it_never_is() -> None:
    slam = RegionSLAM(SlamConfig(n_particles=3, relocalise=False), seed=0)
    assert not any(belief.lost for _, belief in drive(slam))


def test_it_can_be_told() -> None:
    """A robot that was switched off: it is lost by its word, and knows itself again without having been carried."""
    slam = RegionSLAM(SlamConfig(n_particles=3), seed=0)
    noise, pose = np.random.default_rng(0), np.zeros(3)
    for _ in range(5):
        slam.step(Odometry(0.0), scan(pose, noise))
    assert slam.relocalise().lost
    beliefs = [slam.step(Odometry(0.0), scan(pose, noise)) for _ in range(25)]
    assert beliefs[0].lost and not beliefs[-1].lost
    assert beliefs[-1].pose_mean == pytest.approx(pose, abs=0.1)


def test_a_given_pose_ends_the_search() -> None:
    slam = RegionSLAM(SlamConfig(n_particles=3), seed=0)
    noise, pose = np.random.default_rng(0), np.array([0.5, 0.2, 0.1])
    slam.step(Odometry(0.0), scan(pose, noise), pose)
    slam.relocalise()
    belief = slam.step(Odometry(0.0), scan(pose, noise), pose)
    assert not belief.lost
    assert belief.pose_mean == pytest.approx(pose)


def test_a_lost_filter_goes_on_after_saving(tmp_path: Path) -> None:
    slam = RegionSLAM(SlamConfig(n_particles=3), seed=0)
    noise, pose = np.random.default_rng(0), np.zeros(3)
    for _ in range(5):
        slam.step(Odometry(0.0), scan(pose, noise))
    slam.relocalise()
    slam.step(Odometry(0.0), scan(pose, noise))
    slam.save(tmp_path / "lost.npz")
    loaded = RegionSLAM.load(tmp_path / "lost.npz")
    assert loaded.belief.lost
    for _ in range(25):
        seen = scan(pose, noise)
        a, b = slam.step(Odometry(0.01), seen), loaded.step(Odometry(0.01), seen)
        assert a.lost == b.lost
        np.testing.assert_array_equal(a.pose_mean, b.pose_mean)
    assert not b.lost
