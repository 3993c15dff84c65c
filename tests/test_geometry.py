import math

import numpy as np
import pytest

from regionslam_env.geometry import NearbyIndex, cast, ray_angles, ray_directions, ray_span, segment_boxes
from tests import naive


def ranges_from(pose, segments, n=180, reach=10.0, nearby=None):
    segments = np.asarray(segments, float).reshape(-1, 4)
    nearby = np.arange(len(segments)) if nearby is None else nearby
    ranges = np.empty(n)
    cast(*pose, reach, ray_directions(n), segments, nearby, ranges)
    return ranges


def test_the_first_ray_looks_back_and_the_middle_one_ahead():
    angles = ray_angles(180)
    assert angles[0] == -math.pi
    assert angles[90] == pytest.approx(0, abs=1e-15)
    assert np.all(np.diff(angles) > 0)


def test_distances_to_one_wall_are_exact():
    ranges = ranges_from((0, 0, 0), [(2, -1, 2, 1)], n=360)
    angles = ray_angles(360)
    seen = np.abs(angles) <= math.atan2(1, 2)
    assert ranges[seen] == pytest.approx(2 / np.cos(angles[seen]), rel=1e-12)
    assert np.all(ranges[~seen] == 10)


@pytest.mark.parametrize("theta", [0.0, 1.0, math.pi, -math.pi, 4.0])
def test_a_wall_behind_is_seen_across_the_seam(theta):
    c, s = math.cos(theta), math.sin(theta)
    wall = [-2 * c + s, -2 * s - c, -2 * c - s, -2 * s + c]
    ranges = ranges_from((0, 0, theta), [wall], n=180)
    assert ranges[0] == pytest.approx(2)
    assert np.count_nonzero(ranges < 10) == 27  # 26.57 degrees to either side, a ray every two


def test_the_nearest_of_several_walls_counts_whatever_their_order():
    walls = [(3, -1, 3, 1), (2, 1, 2, -1), (4, -1, 4, 1)]
    for order in ([0, 1, 2], [2, 1, 0], [1, 2, 0]):
        assert ranges_from((0, 0, 0), np.array(walls)[order])[90] == pytest.approx(2)


def test_no_ray_slips_through_a_corner():
    corner = (1.0, math.tan(math.radians(10)))  # exactly on a ray
    walls = [(1, -5, *corner), (*corner, -5, corner[1])]
    assert ranges_from((0, 0, 0), walls, n=36)[19] == pytest.approx(math.hypot(*corner))


def test_a_wall_seen_end_on_is_a_point():
    ranges = ranges_from((0, 0, 0), [(2, 0, 5, 0)])
    assert ranges[90] == pytest.approx(2)
    assert np.count_nonzero(ranges < 10) == 1


@pytest.mark.parametrize("n", [7, 60, 360, 3600])
def test_an_angle_lies_between_the_same_rays_as_by_arctangents(n):
    rng = np.random.default_rng(n)
    x0, y0, x1, y1 = rng.uniform(-5, 5, (4, 3000))
    on_a_ray = rng.integers(n, size=600)
    x0[:600], y0[:600] = 3 * ray_directions(n)[:, on_a_ray]
    x1[300:900], y1[300:900] = 2 * ray_directions(n)[:, rng.integers(n, size=600)]
    x0[900:950] = y0[950:1000] = x1[1000:1050] = 0.0
    for x, y, cross, dot in zip(x0, y0, abs(x0 * y1 - y0 * x1), x0 * x1 + y0 * y1, strict=True):
        start, end = ray_span(float(x), float(y), float(cross), float(dot), n)
        first = (math.atan2(y, x) + math.pi) * n / (2 * math.pi)
        last = first + math.atan2(cross, dot) * n / (2 * math.pi)
        assert (start, end) == pytest.approx((first, last), abs=3e-5 * n / (2 * math.pi))
        for ours, theirs in ((start, first), (end, last)):
            near_a_ray = abs(theirs - round(theirs)) < 1e-6 * n / (2 * math.pi)
            assert math.floor(ours) == math.floor(theirs) or abs(ours - theirs) < 1e-9 * n
            assert not near_a_ray or abs(ours - theirs) < 1e-9 * n


def test_what_lies_beyond_the_range_is_not_seen():
    assert np.all(ranges_from((0, 0, 0), [(10.1, -20, 10.1, 20), (-20, 11, 20, 11)]) == 10)


def test_nothing_is_seen_of_no_walls():
    assert np.all(ranges_from((1, 2, 3), np.empty((0, 4))) == 10)


def test_same_as_the_naive_caster():
    rng = np.random.default_rng(4)
    for _ in range(5):
        segments = rng.uniform(-8, 8, (25, 4))
        pose = rng.uniform(-4, 4, 3)
        expected = naive.cast(pose, ray_angles(60), 6.0, segments)
        assert ranges_from(pose, segments, n=60, reach=6.0) == pytest.approx(expected, rel=1e-9)


def test_nearby_lists_hold_all_that_is_in_reach():
    rng = np.random.default_rng(5)
    segments = rng.uniform(0, 60, (80, 4))
    segments[:, 2:] = segments[:, :2] + rng.uniform(-5, 5, (80, 2))
    index = NearbyIndex(segment_boxes(segments), 6.0)
    for x, y in rng.uniform(-15, 75, (100, 2)):
        all_ranges = ranges_from((x, y, 0), segments, n=40, reach=6.0)
        assert np.array_equal(ranges_from((x, y, 0), segments, n=40, reach=6.0, nearby=index.near(x, y)), all_ranges)


def test_nearby_lists_leave_out_what_is_far():
    index = NearbyIndex(segment_boxes(np.array([(0.0, 0, 1, 0), (50, 0, 51, 0)])), 6.0)
    assert index.near(0.5, 0).tolist() == [0]
    assert index.near(50.5, 0).tolist() == [1]
    assert index.near(25.0, 0).tolist() == []
    assert index.near(-100.0, 0).tolist() == [0, 1]  # outside of everything: no list, so all


def test_nearby_index_of_nothing():
    assert len(NearbyIndex(np.empty((0, 4)), 6.0).near(1.0, 2.0)) == 0
