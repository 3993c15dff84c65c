import numpy as np
import pytest

from regionslam_env.geometry import ray_directions
from regionslam_env.sensors.sight import SIGHT, look, out_of_view, turn_rays
from regionslam_env.worlds.world import TRUE_REGION
from tests import naive

RAYS = 60


def see(bounds, ranges, angle=0.0, reach=6.0, tolerance=0.2):
    seen = np.empty(SIGHT)
    axis = (float(np.cos(angle)), float(np.sin(angle)))
    ends = np.empty((2, len(ranges)))
    turn_rays(axis, ray_directions(len(ranges)), ranges, ends)
    look(bounds, axis, ends, ranges, reach, tolerance, seen)
    return seen


def turned(ranges, angle):
    """Return the ends of the rays in axes turned by an angle."""
    x, y = ray_directions(len(ranges)) * ranges
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x + s * y, c * y - s * x], axis=1)


def random_case(rng):
    left, bottom = rng.uniform(-4, 3, 2)
    bounds = (left, left + rng.uniform(0.2, 4), bottom, bottom + rng.uniform(0.2, 4))
    ranges = np.repeat(rng.choice([1.0, 2.5, 4.0, 6.0], 12), RAYS // 12)  # walls and openings, not single rays
    return (
        tuple(map(float, bounds)),
        np.where(ranges < 6, ranges + rng.uniform(-0.2, 0.2, RAYS), 6.0),
        rng.uniform(-3, 3),
    )


def test_same_as_the_naive_twin():
    rng = np.random.default_rng(9)
    compared = 0
    for _ in range(60):
        bounds, ranges, angle = random_case(rng)
        rays = turned(ranges, angle)
        inside = bounds[0] <= 0 <= bounds[1] and bounds[2] <= 0 <= bounds[3]
        entering = 3 if inside else naive.rays_into(bounds, rays)
        seen = see(bounds, ranges, angle)
        if entering >= 3:
            assert seen == pytest.approx(naive.sight(bounds, rays, 6.0, 0.2), abs=1e-6)
            compared += 1
        elif entering == 0:
            assert seen[4] > seen[5] or seen[5] - seen[4] < 1e-6 or seen[7] - seen[6] < 1e-6
    assert compared > 25


def test_what_is_out_of_view_has_no_visible_part():
    rng = np.random.default_rng(10)
    left_out = 0
    for _ in range(200):
        bounds, ranges, angle = random_case(rng)
        row, ends = np.zeros(1, TRUE_REGION), np.empty((2, RAYS))
        row["n"], row["u"][0, :2], row["b"][0, 0], row["t"][0, 0] = 1, bounds[:2], bounds[2], bounds[3]
        axis = (float(np.cos(angle)), float(np.sin(angle)))
        box = turn_rays(axis, ray_directions(RAYS), ranges / 2, ends)
        if out_of_view(row[0], 0.0, 0.0, box):
            assert naive.rays_into(bounds, turned(ranges / 2, angle)) == 0
            assert see(bounds, ranges / 2, angle)[4] == np.inf
            left_out += 1
    assert 20 < left_out < 180


def test_all_of_a_rectangle_in_the_open():
    seen = see((1.0, 3.0, -1.0, 2.0), np.full(360, 6.0))
    assert seen == pytest.approx([2, 2, 3, 3, 1, 3, -1, 2])


def test_nothing_of_what_is_behind_a_wall():
    seen = see((1.0, 3.0, -1.0, 2.0), np.full(360, 0.9), tolerance=0.05)
    assert np.all(seen[:4] == 0)
    assert seen[4] > seen[5]


def test_a_beam_needs_both_its_rays():
    ranges = np.full(36, 6.0)
    ranges[::2] = 0.5
    assert np.all(see((1.0, 3.0, -1.0, 2.0), ranges)[:4] == 0)


def test_an_edge_under_the_sensor_is_not_seen():
    seen = see((-1.0, 1.0, 0.0, 2.0), np.full(360, 6.0))
    assert seen[:4] == pytest.approx([2, 0, 2, 2], abs=0.05)
