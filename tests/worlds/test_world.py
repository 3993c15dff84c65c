import pickle

import numpy as np
import pytest

from regionslam_env.errors import WorldError
from regionslam_env.worlds.world import Door, Link, Region, World
from slam.rows import Row
from tests.floors import bent_hallway, furnished_room, two_rooms


def office(name="office", **fields):
    return Region(name, "office", name, Row.from_parameters(0, 0, 2, 2), **fields)


def test_the_innermost_region_contains_a_point():
    world = furnished_room()
    assert world.region_at(1.2, 0.3).id == "desk"
    assert world.region_at(-1, 0).id == "office"
    assert world.region_at(9, 9) is None


def test_a_door_region_is_inside_where_rooms_meet():
    assert two_rooms().region_at(6.05, 2.2).id == "door"


def test_links_are_seen_from_either_end():
    world = two_rooms()
    assert world.links_of("kitchen") == (Link("kitchen", "door", "l", "b"),)
    assert [link.target for link in world.links_of("door")] == ["kitchen", "office"]
    assert world.links_of("nowhere") == ()


def test_parents_and_children():
    world = furnished_room()
    assert world.parent("desk").id == "office"
    assert world.parent("office") is None
    assert [child.id for child in world.children("office")] == ["desk"]


def test_arrays_hold_rows_links_and_segments():
    world = two_rooms()
    arrays = world.arrays
    assert arrays.types == ("door", "kitchen", "office")
    assert [arrays.types[r.type] for r in arrays.rows] == ["office", "kitchen", "door"]
    assert arrays.links.tolist() == [[0, 2], [2, 1]]
    kitchen = arrays.rows[1]
    assert (kitchen.x, kitchen.y, kitchen.n, kitchen.main) == (9, 2, 1, 0)
    assert kitchen.u.tolist() == [-3, 3, 0, 0]
    assert (kitchen.b[0], kitchen.t[0]) == (-2, 2)
    assert kitchen.radius == pytest.approx(np.hypot(3, 2))
    assert furnished_room().arrays.obstacles.tolist()[0] == [0.5, -0.5, 1.5, -0.5]


def test_the_circle_of_an_array_row_covers_every_rectangle():
    record, row = bent_hallway().arrays.rows[0], bent_hallway().regions[0].row
    corners = row.rectangles().reshape(-1, 2)
    assert np.hypot(corners[:, 0] - record.cx, corners[:, 1] - record.cy).max() <= record.radius


def test_bounds_cover_walls_and_regions():
    assert two_rooms().bounds == (0, 0, 12, 4)


def test_a_world_survives_pickling_with_equal_arrays():
    world = furnished_room()
    world.arrays  # noqa: B018 - fills the cache
    again = pickle.loads(pickle.dumps(world))
    assert again.arrays.rows.tobytes() == world.arrays.rows.tobytes()
    assert again.obstacle_segments.tolist() == world.obstacle_segments.tolist()
    assert not again.walls.flags.writeable


def test_nobody_can_change_a_world():
    world = furnished_room()
    for array in (world.walls, world.obstacles[0], world.arrays.rows, world.arrays.links):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"regions": (office(), office())}, "region id 'office' is used twice"),
        ({"regions": (office(parent="offise"),)}, "region 'office': unknown parent 'offise': did you mean 'office'"),
        ({"regions": (office("a", parent="b"), office("b", parent="a"))}, "'a' is its own ancestor"),
        ({"regions": (office(),), "doors": (Door("door", 0, 0, 1, 0, ()),)}, "door 'door': unknown region 'door'"),
        ({"regions": (office(),), "links": (Link("office", "ofice", "t", "b"),)}, "did you mean 'office'"),
        ({"regions": (office(),), "links": (Link("office", "office", "q", "b"),)}, "unknown edge 'q'"),
    ],
)
def test_contradictions_are_named(fields, message):
    with pytest.raises(WorldError, match=message):
        World("w", walls=np.empty((0, 4)), **fields)


def test_an_unknown_region_names_the_nearest():
    with pytest.raises(WorldError, match="did you mean 'kitchen'"):
        two_rooms().region("kitchn")
