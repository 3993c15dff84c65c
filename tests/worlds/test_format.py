import copy
import json
import math
import os

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from regionslam_env.errors import WorldError
from regionslam_env.worlds.format import load_world, save_world
from regionslam_env.worlds.world import World
from tests.floors import bent_hallway, furnished_room, long_hallway, two_rooms

WORLDS = (two_rooms, bent_hallway, furnished_room, long_hallway)


def written(tmp_path, world):
    path = tmp_path / "world.geojson"
    save_world(world, path)
    return path


def feature(kind, geometry, **properties):
    return {"type": "Feature", "properties": {"kind": kind, **properties}, "geometry": geometry}


def polygon(*points):
    return {"type": "Polygon", "coordinates": [[*map(list, points), list(points[0])]]}


def line(*points):
    return {"type": "LineString", "coordinates": [list(p) for p in points]}


ROOM = feature("region", polygon((0, 0), (4, 0), (4, 3), (0, 3)), id="room", type="office")


def loaded(tmp_path, *features, **head):
    path = tmp_path / "w.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": list(features), **head}), encoding="utf-8")
    return load_world(path)


@pytest.mark.parametrize("draw", WORLDS)
def test_a_world_is_read_as_it_was_written(tmp_path, draw):
    world = draw()
    again = load_world(written(tmp_path, world))
    assert [(r.id, r.type, r.name, r.parent) for r in again.regions] == [
        (r.id, r.type, r.name, r.parent) for r in world.regions
    ]
    for before, after in zip(world.regions, again.regions, strict=True):
        assert after.row.parameters() == before.row.parameters()
    assert (again.doors, again.links, again.level, again.name) == (world.doors, world.links, world.level, world.name)
    assert again.walls.tolist() == world.walls.tolist()
    assert [o.tolist() for o in again.obstacles] == [o.tolist() for o in world.obstacles]


def test_writing_twice_gives_the_same_bytes(tmp_path):
    path = written(tmp_path, furnished_room())
    first = path.read_bytes()
    save_world(load_world(path), path)
    assert path.read_bytes() == first


def test_spawn_and_names_beyond_ascii_are_kept(tmp_path):
    world = two_rooms()
    world = World("Büro → 室", world.regions, world.walls, world.doors, links=world.links, spawn=(1.0, 2.0, 0.5))
    again = load_world(written(tmp_path, world))
    assert (again.name, again.spawn) == ("Büro → 室", (1.0, 2.0, 0.5))


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = written(tmp_path, two_rooms())
    before = path.read_bytes()

    def broken(source, target):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", broken)
    with pytest.raises(OSError, match="disk full"):
        save_world(furnished_room(), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["world.geojson"]


def test_a_region_without_a_row_is_annotated(tmp_path):
    bent = polygon((0, 0), (10, 0), (10, 2), (2, 2), (2, 8), (0, 8))
    world = loaded(tmp_path, feature("region", bent, id="h", type="hallway"))
    assert world.regions[0].row.n == 2
    assert world.regions[0].row.area == pytest.approx(32)
    assert world.regions[0].name == "h"


def test_a_line_of_many_points_is_many_walls(tmp_path):
    world = loaded(tmp_path, ROOM, feature("wall", line((0, 0), (4, 0), (4, 3))))
    assert world.walls.tolist() == [[0, 0, 4, 0], [4, 0, 4, 3]]


def test_one_level_is_read_of_several(tmp_path):
    upper = copy.deepcopy(ROOM)
    upper["properties"].update(id="attic", level="1")
    assert [r.id for r in loaded(tmp_path, ROOM, upper).regions] == ["room"]
    assert [r.id for r in loaded(tmp_path, ROOM, upper, level="1").regions] == ["attic"]
    assert [r.id for r in load_world(tmp_path / "w.geojson", level="0").regions] == ["room"]
    with pytest.raises(WorldError, match="unknown level '7'"):
        load_world(tmp_path / "w.geojson", level="7")


def test_a_byte_order_mark_is_no_error(tmp_path):
    path = written(tmp_path, two_rooms())
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_world(path).name == "two rooms"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b"  \n", "is empty"),
        (b"{", "line 1, column 2"),
        (b"\xff\xfe\x00{", "byte 0 is not UTF-8"),
        ('{"name": "Büro"}'.encode("latin-1"), "byte 11 is not UTF-8"),
        (b"[1, 2]", "type is 'list', expected 'FeatureCollection'"),
        (b'{"type": "Feature"}', "type is 'Feature', expected 'FeatureCollection'"),
        (b'{"type": "FeatureCollection"}', "features: expected a list"),
        (b'{"type": "FeatureCollection", "features": []}', "features: expected a list of at least one"),
        (b"[" * 200000, "expected"),
        (b'{"type": "FeatureCollection", "features": [' + b"9" * 5000 + b"]}", "expected"),
    ],
)
def test_files_that_hold_no_world_are_named(tmp_path, data, message):
    path = tmp_path / "broken.geojson"
    path.write_bytes(data)
    with pytest.raises(WorldError, match=message) as caught:
        load_world(path)
    assert "broken.geojson" in str(caught.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(WorldError, match="cannot be read"):
        load_world(tmp_path / "none.geojson")


def region(geometry=ROOM["geometry"], **properties):
    return feature("region", geometry, **{"id": "room", "type": "office", **properties})


SQUARE = {"x": 2, "y": 1.5, "w": 4, "h": 3}


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (7, r"features\[1\]: expected an object of type 'Feature', got 7"),
        ({"type": "Feature", "properties": None, "geometry": None}, r"features\[1\]: properties: expected an object"),
        (feature("regoin", None), r"properties.kind: unknown kind 'regoin': did you mean 'region'"),
        (feature(["region"], None), r"properties.kind: unknown kind"),
        (region(id="room"), "region id 'room' is used twice"),
        (region(id=""), "properties.id: expected a string that is not empty"),
        (region(id=5), "properties.id: expected a string"),
        (region(id="b", type=None), r"\(region 'b'\): properties.type: expected a string"),
        (region(id="b", parent="rom"), "unknown parent 'rom': did you mean 'room'"),
        (
            region(polygon((0, 0), (2, 2), (2, 0), (0, 2)), id="b"),
            "Self-intersection.*|expected a ring that does not cross",
        ),
        (region(polygon((0, 0), (1, 1), (2, 2)), id="b"), "geometry.coordinates: expected"),
        (region(polygon((0, 0), (1, 0), (1, 1e-5), (0, 1e-5)), id="b"), "a width above 0.001 m"),
        (region(polygon((0, 0), (math.nan, 0), (1, 1)), id="b"), r"coordinates\[1\]: expected a finite number"),
        (region(polygon((0, 0), (1e9, 0), (1, 1)), id="b"), "expected a finite number of at most 100000"),
        (region(polygon((0, 0), (10**400, 0), (1, 1)), id="b"), "expected a finite number of at most 100000"),
        (region(polygon((0, 0), ("1", 0), (1, 1)), id="b"), "expected a number, got 1"),
        (region(polygon((0, 0), (True, 0), (1, 1)), id="b"), "expected a number, got True"),
        (
            region({"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1]]]}, id="b"),
            "whose last is its first",
        ),
        (region({"type": "Polygon", "coordinates": [[0, 1, 2]]}, id="b"), "expected a point"),
        (region({"type": "Polygon", "coordinates": [[], []]}, id="b"), "one ring: holes are not supported"),
        (region({"type": "Polygon"}, id="b"), "geometry.coordinates: expected the coordinates of a Polygon"),
        (region(line((0, 0), (1, 1)), id="b"), "geometry.type: expected 'Polygon', got LineString"),
        (region(None, id="b"), "geometry.type: expected 'Polygon', got None"),
        (region(id="b", row={**SQUARE, "w": -1}), "properties.row.w: expected a size of at least 0.001 m, got -1"),
        (region(id="b", row={**SQUARE, "h": None}), "properties.row.h: expected a number, got None"),
        (region(id="b", row={**SQUARE, "width": 2}), "unknown field 'width'"),
        (region(id="b", row={**SQUARE, "left": [1, 2]}), "properties.row.left: expected .width, height, displacement."),
        (region(id="b", row=[1]), "properties.row: expected an object"),
        (region(id="b", row={**SQUARE, "x": 3}), r"properties.row: expected the place of the polygon .* got IoU 0.60"),
        (feature("wall", line((0, 0))), "at least two points"),
        (feature("wall", line((0, 0), (0, 0))), "neighbours apart"),
        (
            feature("door", line((0, 0), (1, 0), (2, 0)), id="d", regions=[]),
            "two points, the ends of the opening, got 3",
        ),
        (feature("door", line((0, 0), (1, 0)), id="d", regions=["room"]), "door 'd': unknown region 'd'"),
        (feature("door", line((0, 0), (1, 0)), id="room", regions=["romo"]), "did you mean 'room'"),
        (
            feature("door", line((0, 0), (1, 0)), id="room", regions="room"),
            "properties.regions: expected a list of str",
        ),
        (feature("obstacle", polygon((0, 0), (4, 0), (4, 4), (2, 1), (0, 4))), "a convex polygon"),
        (feature("link", None, source="room"), "properties.target: expected a string"),
        (feature("link", None, source="room", target="b", source_edge="t", target_edge="t"), "unknown region 'b'"),
        (feature("link", None, source="room", target="room", source_edge="x", target_edge="t"), "unknown edge 'x'"),
    ],
)
def test_bad_features_are_named_with_field_and_expectation(tmp_path, bad, message):
    with pytest.raises(WorldError, match=message) as caught:
        loaded(tmp_path, ROOM, bad)
    assert "w.geojson" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_world_of_walls_alone_is_refused(tmp_path):
    with pytest.raises(WorldError, match="no feature of kind 'region'"):
        loaded(tmp_path, feature("wall", line((0, 0), (1, 0))))


@pytest.mark.parametrize("spawn", [[1, 2], "here", [1, 2, math.nan], [True, 1, 2], {}])
def test_a_bad_spawn_is_named(tmp_path, spawn):
    with pytest.raises(WorldError, match="spawn: expected"):
        loaded(tmp_path, ROOM, spawn=spawn)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


def places(value, path=()):
    """Yield the path of every value inside a JSON value."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_value_replaced_by_any_other_gives_a_world_or_an_error(tmp_path, data):
    path = written(tmp_path, furnished_room())
    document = json.loads(path.read_text())
    place = data.draw(st.sampled_from(list(places(document))[1:]))
    inner = document
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = data.draw(JSON)
    path.write_text(json.dumps(document))
    try:
        load_world(path)
    except WorldError as error:
        assert "world.geojson" in str(error)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_damage_to_the_bytes_gives_a_world_or_an_error(tmp_path, data):
    content = written(tmp_path, two_rooms()).read_bytes()
    begin = data.draw(st.integers(0, len(content)))
    end = data.draw(st.integers(begin, len(content)))
    path = tmp_path / "damaged.geojson"
    path.write_bytes(content[:begin] + data.draw(st.binary(max_size=8)) + content[end:])
    try:
        load_world(path)
    except WorldError as error:
        assert "damaged.geojson" in str(error)
