"""Finding oneself again: poses of matches, their votes, and hypotheses that further scans decide between."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from slam.matched_poses import MOST_POSES, are_near, count_votes, pose_of_match, support
from slam.measurement import RegionMeasurement
from slam.motion import MotionNoise, Odometry
from slam.region import EdgeState, Subrectangle
from slam.relocalisation import Search
from slam.se2 import between, compose
from tests.slam.drawn import P, mapped, maps, measured, particles, stored

OPEN = EdgeState.OPEN
POSE = np.array([3.0, -2.0, 0.7])
NO_VIEW = np.zeros((0, 2))
FLOOR = [(4.0, 3.0, 4.0, 3.0), (9.0, 3.0, 5.0, 3.5), (4.0, -5.0, 4.0, 3.0), (9.0, -5.5, 5.0, 4.5)]
"""Midpoints and sizes of the rooms of a floor, m; the first and the third are alike."""


def rooms() -> np.ndarray:
    """The map of the floor; every region is confirmed."""
    out = maps(*(mapped([0.0, -w / 2, w / 2, -h / 2, h / 2], (x, y), 0.002) for x, y, w, h in FLOOR))
    out["sightings"][0, :4] = 5
    return out


def sight(pose: np.ndarray, seen: range | list[int] = range(4)) -> np.ndarray:
    """A scan of rooms of the floor from a pose."""
    out = []
    for k in seen:
        x, y, w, h = FLOOR[k]
        local = between(pose, (x, y, 0.0))
        out.append(RegionMeasurement("office", *local[:2], w, h, float(local[2])))
    return measured(*out)


@pytest.mark.parametrize("turned", [0.0, np.pi])
def test_the_pose_of_a_match_is_the_pose_it_was_seen_from(turned: float) -> None:
    m = mapped([0.3, -2, 2, -1.5, 1.5, 5.0, -0.5, 1.0], (4.0, 1.0))
    main = compose((*m.anchor, m.state[0]), (0.0, 0.0, 0.0))
    x, y, phi = between(POSE, main)
    right = Subrectangle(3.0, 1.5, 0.25)
    z = RegionMeasurement("office", x, y, 4.0, 3.0, phi, right=right)
    if turned:
        z = dataclasses.replace(z, phi=phi + np.pi, left=dataclasses.replace(right, y=-0.25), right=None)
    pose, quarters = np.empty(3), 2 if turned else 0
    assert pose_of_match(measured(z)[0, quarters], m, 0, P.tolerance, pose)
    assert pose[:2] == pytest.approx(POSE[:2])
    assert np.angle(np.exp(1j * (pose[2] - POSE[2]))) == pytest.approx(0.0, abs=1e-9)


def test_a_match_needs_common_closed_edges_along_both_axes_that_agree() -> None:
    m, pose = mapped([0.0, -2, 2, -1.5, 1.5]), np.empty(3)
    open_ends = RegionMeasurement("office", 0, 0, 3.0, 3.0, l=OPEN, r=OPEN)
    assert not pose_of_match(measured(open_ends)[0, 0], m, 0, P.tolerance, pose)
    assert pose_of_match(measured(dataclasses.replace(open_ends, l=EdgeState.CLOSED))[0, 0], m, 0, P.tolerance, pose)
    assert not pose_of_match(measured(RegionMeasurement("office", 0, 0, 6.0, 3.0))[0, 0], m, 0, P.tolerance, pose)


def test_each_measurement_has_one_vote_for_a_place() -> None:
    poses = np.array([[0.0, 0, 0], [0.2, 0, 0], [0.1, 0.1, 0], [5.0, 0, 0], [0, 0, 1.0]])
    sources = np.array([0, 0, 1, 1, 2])
    assert count_votes(poses, sources, 3, 0.6).tolist() == [2, 2, 2, 1, 1]


def test_the_true_pose_has_the_most_votes() -> None:
    poses, count = support(sight(POSE), rooms()[0, :4], np.empty((MOST_POSES, 3)), 10, tuple(P))
    assert count == 10
    assert are_near(poses[0], POSE, 0.6)
    assert not any(are_near(a, b, 0.6) for k, a in enumerate(poses) for b in poses[:k])


def test_a_search_ends_only_where_scans_tell() -> None:
    """From the alike rooms alone the robot may be in either; the others settle it, and odometry carries it along."""
    noise, pose, drawn = MotionNoise(), POSE.copy(), stored(rooms())
    search = Search(particles((-20.0, 4.0, 0.0), 0.01), drawn.table[0], P)
    for _ in range(15):
        search.predict(Odometry(0.1), noise)
        pose = compose(pose, (0.1, 0.0, 0.0))
        search.update(drawn, sight(pose, [0]), NO_VIEW)
    assert search.found is None
    for _ in range(25):
        search.predict(Odometry(0.02), noise)
        pose = compose(pose, (0.02, 0.0, 0.0))
        search.update(drawn, sight(pose), NO_VIEW)
    assert search.found is not None
    assert search.found.pose == pytest.approx(pose, abs=0.1)


def test_a_scan_without_measurements_decides_nothing() -> None:
    drawn = stored(rooms())
    search = Search(particles(), drawn.table[0], P)
    search.update(drawn, measured(), NO_VIEW)
    assert len(search.hypotheses) == 1 and search.found is None
