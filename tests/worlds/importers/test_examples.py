"""Every importer on its example: exact rooms, types, doors and what was dropped."""

import importlib.util

import numpy as np
import pytest
import shapely

from regionslam_env.errors import WorldError
from regionslam_env.worlds.format import load_world, save_world
from regionslam_env.worlds.importers.formats import import_plan
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.reachability import unreachable
from tests.worlds.importers.examples import DATA, EXAMPLES, HOUSE, ROOMS, imported

IFC = pytest.mark.skipif(importlib.util.find_spec("ifcopenshell") is None, reason="needs the extra ifc")
NAMES = [pytest.param(name, marks=IFC if name == "ifc" else ()) for name in EXAMPLES]

THROUGH_ALL = {frozenset(pair) for pair in (("office", "hallway"), ("kitchen", "hallway"), ("storage", "kitchen"))}
DOORS = dict.fromkeys(EXAMPLES, THROUGH_ALL) | {
    "azure": {frozenset(("office", "hallway"))},
    "procthor": {frozenset(("bedroom", "living room")), frozenset(("kitchen", "living room"))},
    "pyrobosim": THROUGH_ALL | {frozenset(("hallway", "hallway 2")), frozenset(("hallway 2", "laboratory"))},
}
OPEN = {name: set() for name in EXAMPLES} | {
    "azure": {frozenset(("kitchen", "storage")), frozenset(("kitchen", "hallway"))},
    "procthor": {frozenset(("kitchen", "toilet"))},
}
DROPPED = {name: set() for name in EXAMPLES} | {
    "imdf": {"category opentobelow: no room", "leads to one room only"},
    "osm": {"its outline is not closed"},
    "procthor": {"leads outside"},
    "rmf": {"leads to one room only"},
    "pyrobosim": {"no footprint of its category in metadata.locations"},
    "rosmap": {"no free space at (20, 20)"},
}
TURNED = ("imdf", "azure", "osm", "osm xml")


def kind(region_id):
    """ "office 1" is the office; a second one keeps its number."""
    return region_id.removesuffix(" 1")


@pytest.mark.parametrize("name", NAMES)
def test_rooms_have_their_types_places_and_sizes(name):
    world, report = imported(name)
    rooms = {kind(r.id): r for r in world.regions if r.type != "door" and r.parent is None}
    expected = HOUSE if name == "procthor" else ROOMS
    extra = {"hallway 2", "laboratory"} if name == "pyrobosim" else set()
    assert set(rooms) == set(expected) | extra
    assert all(room.iou > 0.98 for room in report.rooms)
    turn = np.radians(20) if name in TURNED else 0.0
    c, s = np.cos(turn), np.sin(turn)
    origin = np.array(rooms[next(iter(expected))].row.centre) @ np.array([[c, -s], [s, c]]) - (5, 1)
    for key, (x0, y0, x1, y1) in expected.items():
        centre = np.array(rooms[key].row.centre) @ np.array([[c, -s], [s, c]]) - origin
        assert centre == pytest.approx(((x0 + x1) / 2, (y0 + y1) / 2), abs=0.06)
        assert rooms[key].row.area == pytest.approx((x1 - x0) * (y1 - y0), rel=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_doors_join_the_right_rooms_and_nothing_is_invented(name):
    world, report = imported(name)
    joined = [frozenset(map(kind, door.regions)) for door in world.doors]
    assert set(joined) == DOORS[name] and len(joined) == len(DOORS[name])
    ids = {region.id for region in world.regions if region.type != "door"}
    assert {frozenset(map(kind, (k.source, k.target))) for k in world.links if {k.source, k.target} <= ids} == OPEN[
        name
    ]
    assert (report.assumed, report.components, report.passages) == (0, 1, len(OPEN[name]))
    assert {why for _, why in report.dropped} == DROPPED[name]


@pytest.mark.parametrize("name", NAMES)
def test_walls_leave_the_doors_open(name):
    world, _ = imported(name)
    walls = shapely.MultiLineString([wall.reshape(2, 2) for wall in world.walls])
    for door in world.doors:
        width = np.hypot(door.x1 - door.x0, door.y1 - door.y0)
        assert 0.75 <= width <= 1.21
        middle = shapely.LineString([(door.x0, door.y0), (door.x1, door.y1)]).interpolate(0.5, normalized=True)
        assert middle.distance(walls) == pytest.approx(width / 2, abs=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_a_written_import_is_read_again(tmp_path, name):
    world, _ = imported(name)
    save_world(world, tmp_path / "w.geojson")
    again = load_world(tmp_path / "w.geojson")
    assert [(r.id, r.type, r.name) for r in again.regions] == [(r.id, r.type, r.name) for r in world.regions]
    assert again.level == world.level
    assert {r.id for r in load(DATA / EXAMPLES[name]).regions} == {r.id for r in world.regions}


@pytest.mark.parametrize(
    ("name", "level", "others", "types"),
    [
        ("imdf", "Upper floor", ("Ground floor", "Upper floor"), {"storage"}),
        ("osm", "1", ("0", "1"), {"kitchen"}),
        ("rmf", "L2", ("L1", "L2"), {"other", "elevator"}),
    ],
)
def test_levels_are_chosen(name, level, others, types):
    world, report = imported(name, level=level)
    assert (world.level, report.level, report.levels) == (level, level, others)
    assert {r.type for r in world.regions} - {"door"} == types
    with pytest.raises(WorldError, match=r"unknown level '9'.*expected one of"):
        imported(name, level="9")


def test_a_lift_is_a_room_with_its_own_door():
    world, _ = imported("rmf", level="L2")
    lift = world.region("elevator 1")
    assert lift.row.centre == pytest.approx((14.2, -5.8)) and lift.row.area == pytest.approx(1.6**2)
    assert [set(door.regions) for door in world.doors] == [{"elevator 1", "other 1"}]


@pytest.mark.parametrize("name", ["imdf", "pyrobosim", pytest.param("ifc", marks=IFC)])
def test_furniture_stands_in_its_room(name):
    world, report = imported(name)
    (desk,) = [region for region in world.regions if region.parent is not None]
    assert (desk.type, desk.parent, report.furniture) == ("desk", "office 1", 1)
    assert desk.row.area == pytest.approx(1.6 * 0.8, rel=1e-3)
    assert len(world.obstacles) == 1


def test_a_scale_of_ones_own_overrules_the_file():
    world, report = imported("rmf", scale=0.1)
    assert report.scale == 0.1
    assert world.region("office 1").row.area == pytest.approx(4 * 12, rel=0.05)


def test_without_assumed_doors_the_file_alone_counts(tmp_path):
    text = (DATA / "floor.osm.geojson").read_text(encoding="utf-8").replace('"door": "hinged"', '"barrier": "no"')
    path = tmp_path / "f.geojson"
    path.write_text(text, encoding="utf-8")
    bare = import_plan(path, ImportOptions(assume_doors=False)).report
    assert (bare.doors, bare.components) == (0, 4)
    assumed = import_plan(path, ImportOptions()).report
    assert (assumed.doors, assumed.assumed, assumed.components) == (3, 3, 1)


def test_where_no_label_means_anything_the_room_with_most_doors_is_a_hallway(tmp_path):
    text = (DATA / "home.json").read_text(encoding="utf-8")
    path = tmp_path / "home.json"
    path.write_text(text.replace('"room_category"', '"ignored"'), encoding="utf-8")
    world, report = import_plan(path, ImportOptions())
    assert sorted(r.type for r in world.regions if r.type != "door") == ["hallway", "office", "office", "office"]
    assert any("no label says" in note for note in report.notes)


@pytest.mark.compiled
@pytest.mark.parametrize("name", NAMES)
def test_a_robot_can_drive_in_every_import(name):
    import gymnasium

    env = gymnasium.make("RegionSLAM/GoTo-v0", world=str(DATA / EXAMPLES[name]))
    env.reset(seed=1)
    for _ in range(3):
        env.step(env.action_space.sample())
    assert unreachable(env.unwrapped.world) == ()
    env.close()


def changed_flat(folder, old, new):
    """Return the example of PyRoboSim with a part of its text replaced."""
    text = (DATA / "flat.yaml").read_text()
    assert old in text
    (folder / "flat.yaml").write_text(text.replace(old, new))
    return folder / "flat.yaml"


def test_what_has_neither_name_nor_category_is_dropped_by_number(tmp_path):
    file = changed_flat(tmp_path, "name: bin0, category: trash_can, parent: kitchen, ", "")
    _, report = import_plan(file, ImportOptions())
    assert any(what == "location 2" for what, _ in report.dropped)
    assert any("location 2" in line for line in report.lines())


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_corners_that_are_off_by_nothing_are_where_they_seem(tmp_path):
    world, _ = import_plan(changed_flat(tmp_path, "[0, 5]]", "[1.0e-300, 5]]"), ImportOptions())
    exact, _ = import_plan(DATA / "flat.yaml", ImportOptions())
    assert [r.row.area for r in world.regions if not r.parent] == [r.row.area for r in exact.regions if not r.parent]
