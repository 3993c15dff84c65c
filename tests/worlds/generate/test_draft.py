import numpy as np
import pytest

from regionslam_env.worlds.generate.draft import Draft, Gap, Item, Room, Turn, sides
from regionslam_env.worlds.generate.furniture import GAP, Floor
from regionslam_env.worlds.generate.raising import raise_world, walls_of


def two_rooms():
    """An office (0..60 x 0..40 dm) beside an L-shaped kitchen, with a door between them and an open passage up."""
    office = Room("office", [(0, 0, 60, 40)])
    kitchen = Room("kitchen", [(60, 0, 90, 40), (90, 0, 120, 20)])
    hallway = Room("hallway", [(0, 40, 90, 60)], title="way")
    gaps = [Gap(1, 60, 10, 20, (office, kitchen)), Gap(0, 40, 5, 35, (office, hallway), door=False)]
    return Draft([office, kitchen, hallway], gaps, [Item("desk", (0, 0, 15, 8), office)])


def test_sides_of_an_l_leave_the_joint_open():
    kitchen = two_rooms().rooms[1]
    length = sum(high - low for _, _, low, high in sides(kitchen))
    assert length == 30 + 30 + 40 + 30 + 30 + 20 + 20
    assert (1, 90, 20, 40) in set(sides(kitchen)) and (1, 90, 0, 40) not in set(sides(kitchen))


def test_shared_borders_are_one_wall_with_the_gaps_cut():
    walls = set(walls_of(two_rooms()))
    assert {(60, 0, 60, 10), (60, 20, 60, 40), (0, 40, 5, 40), (35, 40, 90, 40), (0, 0, 120, 0)} <= walls
    assert (60, 10, 60, 20) not in walls


def test_a_draft_becomes_a_world_in_metres():
    world = raise_world("rooms", two_rooms())
    assert [r.id for r in world.regions] == ["office 1", "kitchen 1", "hallway 1", "door 1", "desk 1"]
    assert world.region("hallway 1").name == "way" and world.region("desk 1").parent == "office 1"
    kitchen = world.region("kitchen 1").row
    assert kitchen.n == 2 and kitchen.area == pytest.approx(3 * 4 + 3 * 2)
    assert kitchen.contains([[11.9, 1.9], [11.9, 2.1], [6.1, 3.9]]).tolist() == [True, False, True]
    direct = [link for link in world.links if "door 1" not in (link.source, link.target)]
    assert [(k.source, k.target, k.source_edge, k.target_edge) for k in direct] == [("office 1", "hallway 1", "t", "b")]
    assert {link.target for link in world.links_of("door 1")} == {"office 1", "kitchen 1"}


@pytest.mark.parametrize("turn", [Turn(swap=True), Turn(flip_x=True), Turn(flip_y=True, swap=True, dx=5, dy=-7)])
def test_turning_a_draft_turns_the_world(turn):
    plain, turned = two_rooms(), two_rooms()
    turned.transform(turn)
    before, after = raise_world("rooms", plain), raise_world("rooms", turned)
    for one, other in zip(before.regions, after.regions, strict=True):
        assert (one.id, one.parent) == (other.id, other.parent) and one.row.area == pytest.approx(other.row.area)
        corners = np.array([turn.point(*p) for p in np.round(10 * one.row.outline()).astype(int)]) / 10
        assert other.row.contains(corners + 1e-9 * np.sign(np.array(other.row.centre) - corners)).all()
    assert len(before.walls) == len(after.walls)


def test_furniture_stands_flush_or_leaves_a_way():
    floor = Floor(Room("office", [(0, 0, 60, 50)]), [])
    assert floor.put((0, 0, 15, 8))
    assert floor.fits((15, 0, 25, 5))  # flush along the same wall
    assert not floor.fits((17, 0, 27, 5))  # a slit of 2 dm
    assert floor.fits((15 + GAP, 0, 35, 5))
    assert not floor.fits((0, 5, 8, 20)) and not floor.fits((0, 8, 8, 20))  # overlaps; in the corner behind it
    assert not floor.fits((3, 30, 10, 40)) and floor.fits((0, 30, 10, 40))  # off the wall, at the wall


def test_the_floor_before_doors_and_openings_stays_free():
    office, hallway = Room("office", [(0, 0, 60, 50)]), Room("hallway", [(0, -20, 60, 0)])
    floor = Floor(office, [Gap(0, 0, 20, 29, (office, hallway))])
    assert not floor.fits((25, 0, 40, 8)) and floor.fits((30, 0, 45, 8)) and floor.fits((10, 42, 40, 50))
    bent = Room("office", [(0, 0, 60, 50), (60, 10, 80, 40)])
    assert not Floor(bent, []).fits((52, 20, 60, 30)) and Floor(bent, []).fits((52, 0, 60, 10))
