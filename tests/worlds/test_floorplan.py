import numpy as np
import pytest

from regionslam_env.worlds.floorplan import Opening, assemble, distance_to_edges
from regionslam_env.worlds.world import Link, Region
from slam.rows import Row


def rectangle(name, x0, y0, x1, y1, phi=0.0, kind="office", parent=None):
    w, h = (x1 - x0, y1 - y0) if phi == 0 else (y1 - y0, x1 - x0)
    return Region(name, kind, name, Row.from_parameters((x0 + x1) / 2, (y0 + y1) / 2, w, h, phi), parent)


def test_two_rooms_share_one_wall_with_a_gap():
    rooms = [rectangle("a", 0, 0, 4, 3), rectangle("b", 4, 0, 8, 3)]
    world = assemble("w", rooms, [Opening("door", ("a", "b"), 4, 1, 4, 2)])
    on_border = [sorted(wall[1::2]) for wall in world.walls if wall[0] == wall[2] == 4]
    assert sorted(on_border) == [pytest.approx([0, 1]), pytest.approx([2, 3])]
    assert len(world.walls) == 6


def test_a_door_becomes_a_region_with_a_link_to_either_room():
    rooms = [rectangle("a", 0, 0, 4, 3), rectangle("b", 4, 0, 8, 3)]
    world = assemble("w", rooms, [Opening("door", ("a", "b"), 4, 1, 4, 2)])
    door = world.region("door")
    assert door.type == "door"
    assert door.row.parameters() == {"x": 4, "y": 1.5, "w": 1, "h": 0.2, "phi": np.pi / 2, "left": None, "right": None}
    assert set(world.links) == {Link("door", "a", "t", "r"), Link("door", "b", "b", "l")}


def test_furniture_is_an_obstacle_and_a_subregion():
    desk = rectangle("desk", 1, 1, 2, 2, kind="desk", parent="a")
    world = assemble("w", [rectangle("a", 0, 0, 4, 3)], [], [desk])
    assert world.obstacles[0].tolist() == [[1, 1], [2, 1], [2, 2], [1, 2]]
    assert world.parent("desk").id == "a"


@pytest.mark.parametrize(
    ("main", "point", "name"),
    [
        (0, (3, -1.1), "b"),
        (0, (-0.1, 0), "l"),
        (0, (3, 1.1), "t"),
        (0, (5.9, 3), "r"),  # what the second rectangle shows of the joint
        (0, (7, 5.1), "tr"),
        (0, (8.1, 2), "rr"),
        (1, (-0.1, 0), "ll"),
        (1, (3, 1.1), "tl"),
        (1, (7, 5.1), "t"),
        (1, (8.1, 2), "r"),
        (1, (5.9, 3), "l"),
    ],
)
def test_edges_are_named_after_the_main_rectangle(main, point, name):
    row = Row(0, 0, 0, np.array([0, 6, 8]), np.array([-1, -1]), np.array([1, 5]), main)
    assert distance_to_edges(row, *point)[0] == name


def test_the_distance_to_an_edge_is_that_to_its_segment():
    row = Row.from_parameters(0, 0, 2, 2, phi=0.7)
    x, y = row.to_world([[4, 5]])[0]
    assert distance_to_edges(row, x, y)[1] == pytest.approx(5)
