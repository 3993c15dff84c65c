import math
import pickle

import numba
import numpy as np
import pytest

from regionslam_env.worlds.loading import load
from regionslam_env.worlds.world import Region, World
from slam.region import EdgeState
from slam.rows import Row
from slam.view import is_in_view
from tests.floors import bent_hallway, box, furnished_room, long_hallway, single_room, two_rooms
from tests.sensors.reading import corners, edges, find, kinds, look, row_of, sensor, to_world

OPEN, CLOSED, SUBRECT = EdgeState.OPEN, EdgeState.CLOSED, EdgeState.SUBRECT


def parameters(record):
    return [record.x, record.y, record.w, record.h, record.phi]


def test_a_room_is_seen_whole_from_inside():
    scan = look(single_room(), (1, 0.5, 0))
    office = find(scan, "office")
    assert parameters(office) == pytest.approx([-1, -0.5, 6, 4, 0], abs=1e-12)
    assert edges(office) == {"t": CLOSED, "b": CLOSED, "l": CLOSED, "r": CLOSED}
    assert (office.n, office.main) == (1, 0)
    assert office.confidence == 0.9


def test_measurements_are_in_the_robots_frame():
    office = find(look(single_room(), (1, 0.5, math.pi / 6)), "office")
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    assert parameters(office) == pytest.approx([-c - s * 0.5, s - c * 0.5, 6, 4, -math.pi / 6])


def test_the_told_covariances():
    office = find(look(single_room(6, 0.8), (0, 0, 0)), "office")
    assert np.allclose(office.cov_xy, np.eye(2) * 0.1**2)
    assert np.allclose(office.cov_wh, np.diag([0.15**2, (0.15 * 0.8) ** 2]))  # below 1 m in proportion
    assert office.var_phi == pytest.approx(0.03**2)
    assert not office.sub_cov_wh.any()


@pytest.mark.parametrize("y", [0.0, 0.5])
def test_a_hallway_is_open_where_the_view_ends(y):
    hallway = find(look(long_hallway(), (0, y, 0)), "hallway")
    assert parameters(hallway) == pytest.approx([0, -y, 16, 2, 0], abs=1e-9)
    assert edges(hallway) == {"t": CLOSED, "b": CLOSED, "l": OPEN, "r": OPEN}


def test_a_shorter_range_sees_less():
    assert find(look(long_hallway(), (0, 0, 0), range=5.0), "hallway").w == pytest.approx(10)


def test_the_near_end_of_a_hallway_is_closed_and_the_far_one_open():
    hallway = find(look(long_hallway(), (10, 0, 0)), "hallway")
    assert parameters(hallway) == pytest.approx([-1.5, 0, 13, 2, 0], abs=1e-9)
    assert edges(hallway)["r"] == CLOSED
    assert edges(hallway)["l"] == OPEN


def test_open_ends_never_lie_beyond_the_view():
    for theta in np.linspace(0, math.pi, 50):
        hallway = find(look(long_hallway(), (0, 0, theta)), "hallway")
        assert 16 * math.cos(math.radians(0.5)) - 1e-9 <= hallway.w <= 16 + 1e-9


def test_a_room_is_seen_whole_through_a_door():
    scan = look(two_rooms(), (5, 2, 0))
    kitchen = find(scan, "kitchen")
    assert parameters(kitchen) == pytest.approx([4, 0, 6, 4, 0])
    assert set(edges(kitchen).values()) == {CLOSED}
    assert kinds(scan) == ["door", "kitchen", "office"]


def test_a_room_seen_in_part_through_a_door():
    scan = look(two_rooms(), (3, 2, 0))
    kitchen = find(scan, "kitchen")
    # The posts let rays of at most 9.46 degrees pass, and the rays are whole degrees; the view ends after 8 m.
    assert parameters(kitchen) == pytest.approx([5.5, 0, 5, 16 * math.sin(math.radians(9)), 0])
    assert edges(kitchen) == {"t": OPEN, "b": OPEN, "l": CLOSED, "r": OPEN}


def test_a_door_is_closed_all_around():
    door = find(look(two_rooms(), (3, 2, 0)), "door")
    assert parameters(door) == pytest.approx([3, 0, 1, 0.2, math.pi / 2])
    assert set(edges(door).values()) == {CLOSED}


def test_walls_hide_what_is_behind():
    rooms = two_rooms()
    shut = World("shut", rooms.regions[:2], np.array([*box(0, 0, 6, 4), *box(6, 0, 12, 4)]))
    for x, y in np.random.default_rng(8).uniform((0.1, 0.1), (5.9, 3.9), (50, 2)):
        assert kinds(look(shut, (x, y, 0))) == ["office"]
    assert kinds(look(shut, (5, 2, 0), occlusion=False)) == ["kitchen", "office"]
    assert kinds(look(single_room(), (0, 10, 0))) == []


def test_without_occlusion_all_in_range_is_measured():
    scan = look(two_rooms(), (5, 0.5, 1.0), occlusion=False)
    assert kinds(scan) == ["door", "kitchen", "office"]
    assert np.allclose(np.hypot(*scan.view.T), 8)
    kitchen = find(scan, "kitchen")
    assert sorted(parameters(kitchen)[2:4]) == pytest.approx([4, 6])
    assert set(edges(kitchen).values()) == {CLOSED}
    assert kinds(look(two_rooms(), (-3, 2, 0), occlusion=False)) == ["office"]


def test_furniture_does_not_hide_floors_and_is_measured_itself():
    scan = look(furnished_room(), (-2, 0, 0))
    assert parameters(find(scan, "desk")) == pytest.approx([3, 0, 1, 1, 0])
    assert parameters(find(scan, "office")) == pytest.approx([2, 0, 6, 4, 0])
    assert len(scan.links) == 0


def test_both_rectangles_of_an_l_from_its_corner():
    hallway = find(look(bent_hallway(), (7, 0, 0)), "hallway")
    assert (hallway.n, hallway.main) == (2, 0)
    assert parameters(hallway) == pytest.approx([-4, 0, 6, 2, 0], abs=1e-12)
    assert [hallway.sub_w[1], hallway.sub_h[1], hallway.sub_y[1]] == pytest.approx([2, 6, 2])
    assert edges(hallway) == {
        "t": CLOSED,
        "b": CLOSED,
        "l": CLOSED,
        "r": SUBRECT,
        "tr": CLOSED,
        "br": CLOSED,
        "rr": CLOSED,
    }
    assert hallway.sub_var_y[1] == pytest.approx(0.01)
    assert np.allclose(hallway.sub_cov_wh[1], np.eye(2) * 0.15**2)
    assert hallway.sub_w[0] == hallway.sub_h[0] == hallway.sub_y[0] == hallway.sub_var_y[0] == 0


def test_the_arm_of_an_l_is_open_where_a_corner_hides_it():
    hallway = find(look(bent_hallway(), (1, 0, 0)), "hallway")
    highest = 7 * math.tan(math.radians(11))  # the steepest ray of whole degrees that passes the corner at (6, 1)
    assert hallway.n == 2
    assert [hallway.w, hallway.h] == pytest.approx([6, 2])
    assert [hallway.sub_w[1], hallway.sub_h[1]] == pytest.approx([2, 1 + highest])
    assert hallway.sub_y[1] == pytest.approx((highest - 1) / 2)
    assert edges(hallway) == {
        "t": CLOSED,
        "b": CLOSED,
        "l": CLOSED,
        "r": SUBRECT,
        "tr": OPEN,
        "br": CLOSED,
        "rr": CLOSED,
    }


def test_a_rectangle_alone_is_open_where_its_row_goes_on():
    hallway = find(look(bent_hallway(), (6.3, 4.5, 0)), "hallway")
    assert (hallway.n, hallway.main) == (1, 0)
    assert parameters(hallway) == pytest.approx([0.7, -2.5, 2, 6, 0])
    assert edges(hallway) == {"t": CLOSED, "b": CLOSED, "l": OPEN, "r": CLOSED}


@pytest.mark.parametrize("main", [0, 1])
def test_every_heading_describes_the_same_place(main):
    world = bent_hallway(main)
    truth = corners(world.regions[0].row)
    for theta in np.linspace(-math.pi, math.pi, 41):
        pose = (7.0, 0.1, float(theta))
        hallway = find(look(world, pose), "hallway")
        assert -math.pi / 2 < hallway.phi <= math.pi / 2
        assert corners(row_of(hallway), pose) == pytest.approx(truth, abs=1e-6)
        turned = not -math.pi / 2 <= theta < math.pi / 2
        assert hallway.main == (1 - main if turned else main)
        assert (hallway.w, hallway.h) == pytest.approx((2, 6) if main else (6, 2))


def test_turning_the_row_takes_its_edges_along():
    pose = (1.0, 0.0, math.pi)  # looks away from the arm, whose top is hidden
    hallway = find(look(bent_hallway(), pose), "hallway")
    assert hallway.phi == pytest.approx(0, abs=1e-12)
    assert edges(hallway) == {
        "t": CLOSED,
        "b": CLOSED,
        "l": SUBRECT,
        "r": CLOSED,
        "tl": CLOSED,
        "bl": OPEN,
        "ll": CLOSED,
    }
    assert hallway.sub_y[0] == pytest.approx(-(7 * math.tan(math.radians(11)) - 1) / 2)


def test_a_right_angle_is_canonical():
    assert find(look(single_room(), (0, 0, math.pi / 2)), "office").phi == pytest.approx(math.pi / 2)
    assert find(look(single_room(), (0, 0, -math.pi / 2)), "office").phi == pytest.approx(math.pi / 2)


def test_links_lead_both_ways_between_measured_regions():
    scan = look(two_rooms(), (5, 2, 0))
    place = {scan.types[record.type]: k for k, record in enumerate(scan.records)}
    found = {(link.source, link.target) for link in scan.links}
    pairs = [("office", "door"), ("door", "kitchen")]
    assert found == {(place[a], place[b]) for a, b in pairs} | {(place[b], place[a]) for a, b in pairs}
    assert np.all(scan.links["confidence"] == 0.9)


def test_no_links_to_what_is_not_measured():
    scan = look(two_rooms(), (3, 2, 0), range=3.2)
    assert kinds(scan) == ["door", "office"]
    assert sorted((link.source, link.target) for link in scan.links) == [(0, 1), (1, 0)]


def test_the_view_is_the_visible_polygon():
    scan = look(two_rooms(), (5, 2, 0.3))
    assert scan.view.shape == (360, 2)
    x, y = scan.view.T
    area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2
    whole = look(single_room(6, 4), (0, 0, 0)).view
    assert 24 < area < 48
    assert np.abs(whole).max(axis=0) == pytest.approx([3, 2])
    ahead = to_world(scan.view, (5, 2, 0.3))
    assert ahead.min() >= -1e-9
    assert ahead.max(axis=0) == pytest.approx([12, 4])


def test_a_field_of_view_ahead():
    config = {"field_of_view": math.pi / 2}
    scan = look(two_rooms(), (5, 2, 0), **config)
    assert kinds(scan) == ["door", "kitchen", "office"]
    assert "kitchen" not in kinds(look(two_rooms(), (5, 2, math.pi), **config))
    office = find(look(single_room(), (0, 0, 0), **config), "office")
    assert parameters(office) == pytest.approx([1.5, 0, 3, 4, 0])
    assert edges(office) == {"t": CLOSED, "b": CLOSED, "l": OPEN, "r": CLOSED}
    assert not scan.view[0].any()
    angles = np.degrees(np.arctan2(scan.view[1:, 1], scan.view[1:, 0]))
    np.testing.assert_allclose(angles, np.arange(-45, 46), atol=1e-6)
    assert is_in_view(scan.view, 3.0, 0.5, 0.0) and not is_in_view(scan.view, 0.5, 3.0, 0.0)


@pytest.mark.parametrize(("range_", "state"), [(3.0005, OPEN), (3.1, CLOSED)])
def test_an_edge_is_closed_from_30_cm_on(range_, state):
    # Of the right edge, 3 m ahead, a range r sees 2 sqrt(r² - 9) m.
    office = find(look(single_room(), (0, 0, 0), range=range_, n_view_rays=3600), "office")
    assert edges(office)["r"] == state
    assert office.w / 2 == pytest.approx(3)


@pytest.mark.parametrize(("depth", "state"), [(0.14, OPEN), (0.16, CLOSED)])
def test_of_a_short_edge_half_is_enough(depth, state):
    shelf = Region("shelf", "shelf", "shelf", Row.from_parameters(2, 0, 0.3, 1))
    cover = [(1.85 + depth, 0.6, 1.85 + depth, 2.0), (1.85 + depth, -2.0, 1.85 + depth, -0.6)]
    wall = [(1.85 + depth, 0.05, 1.85 + depth, 0.5), (1.85 + depth, -0.5, 1.85 + depth, -0.05)]
    world = World("shelf", (shelf,), np.array([*cover, *wall]))
    found = find(look(world, (0, 0, 0), n_view_rays=3600, edge_tolerance=1e-6), "shelf")
    assert (edges(found)["t"], edges(found)["b"]) == (state, state)


@pytest.mark.parametrize(("offset", "state"), [(0.15, CLOSED), (0.25, OPEN)])
def test_a_wall_counts_as_the_edge_within_20_cm(offset, state):
    room = Region("room", "office", "room", Row.from_parameters(0, 0, 6, 4))
    world = World("inexact", (room,), np.array(box(-3 + offset, -2, 3, 2)))
    office = find(look(world, (0, 0, 0)), "office")
    assert edges(office) == {"t": CLOSED, "b": CLOSED, "l": state, "r": CLOSED}
    assert office.w == pytest.approx(6 if state == CLOSED else 6 - offset)


def test_only_the_longest_run_of_rectangles_counts():
    # Seen from outside through two windows, the middle rectangle of three stays hidden.
    row = Row(0, 0, 0, np.array([0, 4, 8, 12]), np.array([0, 0, 0]), np.array([3, 3, 3]), 1)
    walls = [*box(0, 0, 12, 3)[1:], (0, 0, 1, 0), (3, 0, 9, 0), (11, 0, 12, 0)]
    world = World("windows", (Region("hall", "hall", "hall", row),), np.array(walls))
    hall = find(look(world, (6, -2, 0)), "hall")
    assert hall.n == 1
    assert edges(hall)["r"] == OPEN


def test_the_middle_of_three_is_the_main_one():
    row = Row(0, 0, 0, np.array([0, 4, 6, 8]), np.array([0, -3, 0]), np.array([2, 4, 2]), 1)
    corners_of = row.outline()
    walls = np.concatenate([corners_of, np.roll(corners_of, -1, axis=0)], axis=1)
    world = World("cross", (Region("hall", "hall", "hall", row),), walls)
    hall = find(look(world, (5, 1, 0)), "hall")
    assert (hall.n, hall.main) == (3, 1)
    assert parameters(hall) == pytest.approx([0, -0.5, 2, 7, 0], abs=1e-12)
    assert hall.sub_w == pytest.approx([4, 2])
    assert hall.sub_h == pytest.approx([2, 2])
    assert hall.sub_y == pytest.approx([0.5, 0.5])


def test_scans_share_no_memory():
    eye = sensor(two_rooms())
    first = eye.measure(np.array([5.0, 2, 0]))
    before = first.records.copy(), first.view.copy(), first.links.copy()
    second = eye.measure(np.array([3.0, 1, 2]))
    assert not np.shares_memory(first.records, second.records)
    assert not np.shares_memory(first.view, second.view)
    for old, now in zip(before, (first.records, first.view, first.links), strict=True):
        assert np.array_equal(old, now)


def test_a_sensor_survives_pickling():
    eye = sensor(two_rooms())
    again = pickle.loads(pickle.dumps(eye))
    pose = np.array([5.0, 2, 0.7])
    for _ in range(3):
        assert np.array_equal(eye.measure(pose).records, again.measure(pose).records)


def test_a_world_without_walls_or_regions():
    world = single_room()
    bare = type(world)("bare", world.regions, np.empty((0, 4)))
    assert kinds(look(bare, (0, 0, 0))) == ["office"]
    empty = type(world)("empty", (), world.walls)
    assert len(look(empty, (0, 0, 0))) == 0


def test_what_is_measured_in_a_building_is_true():
    world = load("institute")
    eye, rng = sensor(world), np.random.default_rng(10)
    xmin, ymin, xmax, ymax = world.bounds
    measured = 0
    for _ in range(5 if numba.config.DISABLE_JIT else 100):
        pose = (*rng.uniform((xmin, ymin), (xmax, ymax)), rng.uniform(-3, 3))
        for z in eye.measure(np.array(pose)).records:
            measured += 1
            kind = world.arrays.types[z.type]
            seen = to_world(row_of(z).rectangles(), pose)
            fits = [r for r in world.regions_of_type(kind) if _holds(r.row, seen)]
            assert fits, f"{kind} at {pose} is nowhere on the floor"
    assert measured > 15


def _holds(row, seen):
    """Return whether each seen rectangle, shape (n, 4, 2), lies in one of the row's."""
    local = row.to_local(seen.reshape(-1, 2)).reshape(-1, 4, 2)
    for (u0, v0), (u1, v1) in zip(local.min(axis=1), local.max(axis=1), strict=True):
        inside = (row.u[:-1] <= u0 + 1e-6) & (u1 - 1e-6 <= row.u[1:]) & (row.b <= v0 + 1e-6) & (v1 - 1e-6 <= row.t)
        if not inside.any():
            return False
    return True
