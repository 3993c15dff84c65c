import numpy as np
import pytest

from regionslam_env.simulation.furniture import PLAY, moved_polygons, moved_row, pieces_of, without
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.world import Region, World
from slam.rows import Row
from tests.floors import box, furnished_room, two_rooms
from tests.simulation.lively import lively


def square(x, y, side=1.0):
    h = side / 2
    return np.array([(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h)])


def room_with(*obstacles, regions=()):
    office = Region("office", "office", "office", Row.from_parameters(0, 0, 6, 4))
    return World("room", (office, *regions), np.array(box(-3, -2, 3, 2)), obstacles=tuple(obstacles))


def desk(x, y, name="desk"):
    return Region(name, "desk", name, Row.from_parameters(x, y, 1, 1), parent="office")


def test_obstacles_in_a_region_of_furniture_are_one_piece():
    halves = square(0.75, 0, 0.5), square(1.25, 0, 0.5)
    (piece,) = pieces_of(room_with(*halves, regions=(desk(1, 0),)))
    assert piece.region == 1
    assert piece.obstacles == (0, 1)
    assert piece.centre == pytest.approx((1, 0))


def test_pillars_and_what_reaches_into_a_wall_or_another_piece_are_fixed():
    assert pieces_of(room_with(square(1, 0))) == ()
    assert pieces_of(room_with(square(2.9, 0), regions=(desk(2.9, 0),))) == ()
    overlapping = room_with(square(1, 0), square(1.7, 0), regions=(desk(1, 0, "a"), desk(1.7, 0, "b")))
    assert pieces_of(overlapping) == ()


def test_furniture_flush_with_a_wall_or_another_piece_can_move():
    beside = room_with(square(2.5, 0), square(1.5, 0), regions=(desk(2.5, 0, "a"), desk(1.5, 0, "b")))
    assert len(pieces_of(beside)) == 2
    institute = load("institute")
    assert len(pieces_of(institute)) == len(institute.obstacles)


def test_a_world_without_its_furniture():
    world = furnished_room()
    bare = without(world, pieces_of(world))
    assert [region.id for region in bare.regions] == ["office"]
    assert bare.obstacles == ()


def test_row_and_polygons_move_together():
    world = furnished_room()
    (piece,) = pieces_of(world)
    pose = np.array([0.4, -0.7, 0.6])
    row, (polygon,) = moved_row(world.regions[1].row, piece, pose), moved_polygons(piece, pose)
    assert row.centre == pytest.approx((0.4, -0.7))
    assert sorted(map(tuple, row.outline().round(9))) == sorted(map(tuple, polygon.round(9)))


@pytest.mark.parametrize(("mass", "share"), [(20.0, 1 / 2), (60.0, 1 / 4), (5.0, 4 / 5)])
def test_a_push_goes_on_as_slowly_as_the_piece_is_heavy(mass, share):
    simulation = lively(furnished_room(), (0.2, 0, 0), movable_furniture=1.0, furniture_mass=mass)
    for _ in range(20):
        simulation.step(0.4, 0)
    before = simulation.movers.poses[0, 0]
    for _ in range(10):
        simulation.step(0.4, 0)
    assert simulation.collided
    assert simulation.movers.poses[0, 0] - before == pytest.approx(0.4 * share, rel=0.05)
    assert simulation.pose[0] == pytest.approx(simulation.movers.poses[0, 0] - (0.5 - PLAY) - 0.2, abs=0.005)


def test_a_piece_stops_at_a_wall():
    simulation = lively(furnished_room(), (0.2, 0, 0), movable_furniture=1.0)
    for _ in range(100):
        simulation.step(1, 0)
    assert simulation.movers.poses[0] == pytest.approx([2.5, 0, 0], abs=0.02)
    assert simulation.pose[0] == pytest.approx(2 - 0.2, abs=0.03)


def test_a_piece_rests_where_nobody_pushes_it_any_more():
    simulation = lively(furnished_room(), (0.2, 0, 0), movable_furniture=1.0)
    for _ in range(15):
        simulation.step(0.5, 0)
    for _ in range(10):
        simulation.step(-0.5, 0)
    resting = simulation.movers.poses.copy()
    assert 1.1 < resting[0, 0] < 2
    for _ in range(20):
        simulation.step(0, 0.3)
    assert np.array_equal(simulation.movers.poses, resting)


def test_a_push_beside_the_middle_turns_it():
    simulation = lively(furnished_room(), (0.2, 0.4, 0), movable_furniture=1.0)
    for _ in range(20):
        simulation.step(0.5, 0)
    assert simulation.movers.poses[0, 2] < -0.1


def test_what_is_not_drawn_as_movable_holds():
    simulation = lively(furnished_room(), (0.2, 0, 0), movable_furniture=0.4)
    for _ in range(30):
        simulation.step(1, 0)
    assert simulation.movers.poses[0] == pytest.approx([1, 0, 0], abs=1e-12)
    assert simulation.pose[0] == pytest.approx(0.3, abs=0.02)


def test_a_piece_in_a_door_keeps_it_open():
    world = two_rooms()
    regions = (*world.regions, Region("box", "table", "box", Row.from_parameters(4, 2, 0.6, 0.6), parent="office"))
    furnished = World("box", regions, world.walls, world.doors, (square(4, 2, 0.6),), world.links)
    simulation = lively(furnished, (3, 2, 0), movable_furniture=1.0, closing_doors=1.0, time_open=1.0, time_closed=1.0)
    movers = simulation.movers
    here = (1.0, 1.0, 0.2)
    assert movers._is_free(0, here)
    movers.poses[0, 0] = 6.1
    assert not movers._is_free(0, here)
