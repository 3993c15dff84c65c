import gzip
import json

import pytest

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.formats import FORMATS, detect, import_plan, plans_in
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.loading import load
from tests.worlds.importers.examples import DATA, EXAMPLES

READERS = {"azure": "imdf", "osm xml": "osm"}


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_format_is_known_by_its_content(name):
    assert detect(DATA / EXAMPLES[name])[0].name == READERS.get(name, name)


@pytest.mark.parametrize(
    ("file", "content", "message"),
    [
        ("a.json", '{"rooms": []}', r"tried our own .*IMDF.*OpenStreetMap.*ProcTHOR.*HouseExpo.*'verts'"),
        ("a.geojson", '{"features": [{"properties": {}}]}', "no feature with the tag 'indoor'"),
        ("a.yaml", "rooms: []", r"RMF building.yaml \(no 'levels'.*PyRoboSim.*ROS map"),
        ("a.yaml", "[" * 5000, "nested more than|expected YAML"),
        ("a.yaml", "a: &a [*a, *a]\nb: {<<: 3}", "expected YAML"),
        ("a.yaml", "desk: {footprint: {type: box, dims: [1, 1]}}", "import the world's own file"),
        ("a.xml", "<house/>", r"OpenStreetMap indoor \(root element is <house>.*Luperto XML"),
        ("a.ifc", "DXF", "does not begin with ISO-10303-21"),
        ("a.dwg", "AC1027", r"ending '\.dwg', expected one of \.geojson"),
        ("a.json", "[" * 100_000, "expected JSON"),
        ("a.yaml", b"\xff\xfe\x00", "not UTF-8"),
        ("a.ifc.gz", b"no gzip", "cannot be read"),
        ("a.ifc.gz", gzip.compress(b"x" * 1000)[:-9], "cannot be read"),
    ],
)
def test_what_no_importer_reads_is_refused_with_what_was_tried(tmp_path, file, content, message):
    path = tmp_path / file
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(WorldError, match=message) as caught:
        load(path)
    assert str(path) in str(caught.value)


def test_one_file_of_several_sends_to_their_folder():
    with pytest.raises(
        WorldError, match=r"opening\.geojson: one of several files of a building, expected their folder"
    ):
        load(DATA / "imdf" / "opening.geojson")
    with pytest.raises(WorldError, match=r"a folder that is no building.*no unit\.geojson"):
        load(DATA)


def test_a_file_of_gzip_is_unpacked(tmp_path):
    path = tmp_path / "cottage.xml.gz"
    path.write_bytes(gzip.compress((DATA / "cottage.xml").read_bytes()))
    assert {room.type for room in import_plan(path, ImportOptions()).report.rooms} >= {"office", "kitchen"}


def test_plans_of_a_folder_are_files_and_buildings_of_several_files():
    assert [path.relative_to(DATA).as_posix() for path in plans_in(DATA)][:3] == ["azure", "cottage.xml", "flat.yaml"]
    assert DATA / "imdf" in plans_in(DATA)
    assert not any(path.suffix == ".pgm" or path.name.endswith(".rooms.yaml") for path in plans_in(DATA))


def test_every_format_has_a_title_of_its_own():
    assert len({f.title for f in FORMATS}) == len(FORMATS)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda d: d["rooms"][0].pop("id"), r"rooms\[0\]: field 'id' is missing"),
        (
            lambda d: d["rooms"][1].update(floorPolygon=[{"x": 0, "z": 0}]),
            r"rooms\[1\]\.floorPolygon: .*at least 3 points",
        ),
        (lambda d: d["rooms"][1]["floorPolygon"][2].update(x="far"), r"Polygon\[2\]\.x: .*a number, got 'far'"),
        (lambda d: d["rooms"][1]["floorPolygon"][2].update(x=1e300), r"expected a number from -1e\+07 to 1e\+07"),
        (lambda d: d["doors"][0].update(wall0="wall|9"), r"doors\[0\]\.wall0: no wall 'wall\|9'"),
        (lambda d: d["rooms"][0]["floorPolygon"].extend([{"x": 5e4, "z": 0}]), r"across, expected at most 2000"),
    ],
)
def test_a_wrong_field_is_named_with_its_place(tmp_path, edit, message):
    data = json.loads((DATA / "house.json").read_text(encoding="utf-8"))
    edit(data)
    path = tmp_path / "house.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(WorldError, match=message) as caught:
        load(path)
    assert "house.json" in str(caught.value)


def test_what_is_too_small_or_drawn_twice_is_dropped(tmp_path):
    data = json.loads((DATA / "house.json").read_text(encoding="utf-8"))
    twin = {**data["rooms"][0], "id": "room|twin"}
    speck = {
        "id": "room|speck",
        "roomType": "Kitchen",
        "floorPolygon": [{"x": x, "z": z} for x, z in ((0, 9), (0.1, 9), (0, 9.1))],
    }
    data["rooms"] += [twin, speck]
    path = tmp_path / "house.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    report = import_plan(path, ImportOptions()).report
    assert len(report.rooms) == 4
    assert {("room 'room|twin'", "drawn in the place of room 'room|2'")} < set(report.dropped)
    assert any(why.startswith("area 0.0") for _, why in report.dropped)
