import numpy as np
import pytest
import shapely

from regionslam_env.errors import WorldError
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.plan import Portal, Space, build, joined, wall_outline
from slam.rows import Row


def space(name, *corners, kind="office"):
    return Space(name, kind, name, shapely.Polygon(corners))


def test_hand_drawn_rooms_share_a_straight_wall():
    rooms = [
        space("a", (0, 0), (4.02, 0), (4.1, 3), (0, 3)),
        space("b", (4.1, 0.03), (8, 0), (8, 3), (4.15, 3.02)),
    ]
    world = build("w", rooms, [Portal(4.08, 1.5, ("a", "b"))])
    a, b = (world.region(name).row for name in "ab")
    assert a.rectangles()[..., 0].max() == pytest.approx(b.rectangles()[..., 0].min())
    assert len(world.walls) == 6 or len(world.walls) == 7
    assert Geodesic(world).distance((1, 1), ["b"]) == pytest.approx(np.hypot(3.1, 0.35), rel=0.05)


def test_walls_follow_the_polygon_where_no_row_can():
    corner = [(0, 0), (6, 0), (6, 2), (4, 4), (0, 4)]
    row = Row.from_parameters(3, 2, 6, 4)
    outline = shapely.Polygon(wall_outline(row, shapely.Polygon(corner)))
    assert outline.symmetric_difference(shapely.Polygon(corner)).area < 0.05
    nearly = [(0, 0), (6, 0), (6, 3.8), (5.8, 4), (0, 4)]
    assert shapely.Polygon(wall_outline(row, shapely.Polygon(nearly))).equals(shapely.box(0, 0, 6, 4))


def test_a_smaller_room_is_taken_out_of_a_larger_one():
    lobby = space("lobby", (0, 0), (6, 0), (6, 4), (0, 4))
    lift = space("lift", (4, 2), (6, 2), (6, 4), (4, 4), kind="elevator")
    world = build("w", [lobby, lift], [])
    assert world.region("lobby").row.area == pytest.approx(20)


def test_rectangles_that_alignment_made_equal_are_one():
    row = Row(0, 0, 0, np.array([0, 3, 5]), np.array([0, 0.02]), np.array([2, 2.01]))
    assert joined(row).parameters() == pytest.approx(Row.from_parameters(2.5, 1, 5, 2).parameters(), abs=1e-9)
    step = Row(0, 0, 0, np.array([0, 3, 5]), np.array([0, 0.5]), np.array([2, 2.0]))
    assert joined(step) is step


def test_two_portals_in_one_place_are_one_door():
    rooms = [space("a", (0, 0), (4, 0), (4, 3), (0, 3)), space("b", (4, 0), (8, 0), (8, 3), (4, 3))]
    portals = [Portal(4, 1.5, ("a", "b")), Portal(4, 1.7, ("b", "a"))]
    assert len(build("w", rooms, portals).doors) == 1
    far = build(
        "w",
        [space("a", (0, 0), (4, 0), (4, 9), (0, 9)), space("b", (4, 0), (8, 0), (8, 9), (4, 9))],
        [Portal(4, 1.5, ("a", "b")), Portal(4, 7, ("b", "a"))],
    )
    assert len(far.doors) == 2


def test_a_turned_building_keeps_its_direction():
    turn = np.radians(20)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    rooms = [
        Space(name, "office", name, shapely.Polygon(np.array(corners) @ rotation))
        for name, corners in (("a", [(0, 0), (4, 0), (4, 3), (0, 3)]), ("b", [(4.1, 0), (8, 0), (8, 3), (4.1, 3)]))
    ]
    x, y = np.array([4.05, 1.5]) @ rotation
    world = build("w", rooms, [Portal(x, y, ("a", "b"))])
    assert world.region("a").row.phi == pytest.approx(turn)
    assert np.isfinite(Geodesic(world).distance(tuple(np.array([1, 1]) @ rotation), ["b"]))


def test_a_plan_without_rooms_or_with_unknown_rooms_is_refused():
    with pytest.raises(WorldError, match="no space with an outline"):
        build("w", [], [])
    with pytest.raises(WorldError, match="unknown space 'office'"):
        build("w", [space("a", (0, 0), (4, 0), (4, 3))], [Portal(0, 0, ("a", "office"))])
