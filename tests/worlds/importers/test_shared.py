"""What all importers share: vocabulary, projection, cutting, borders, refinement, report."""

import json

import numpy as np
import pytest
import shapely

from regionslam_env.errors import WorldError
from regionslam_env.worlds.annotate import annotate
from regionslam_env.worlds.borders import components, missing_doors, open_borders
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor
from regionslam_env.worlds.importers.geodetic import LocalPlane
from regionslam_env.worlds.importers.osm import levels_of
from regionslam_env.worlds.importers.realise import ImportOptions, realise
from regionslam_env.worlds.importers.rooms import closings, cut_at_gaps, enclosed
from regionslam_env.worlds.importers.split import split
from regionslam_env.worlds.importers.vocabulary import vocabulary
from regionslam_env.worlds.plan import Space, lay_out
from regionslam_env.worlds.refine import refine

BOX = shapely.box


def space(key, shape, kind="office"):
    return Space(key, kind, key, shape)


@pytest.mark.parametrize(
    ("format_name", "label", "kind"),
    [
        ("imdf", "walkway", "hallway"),
        ("osm", "CORRIDOR", "hallway"),
        ("rmf", "main_corridor", "hallway"),
        ("ifc", "Executive Office 2.13", "office"),
        ("ifc", "office kitchen", "kitchen"),  # the last word says what it is
        ("procthor", "LivingRoom", "living room"),
        ("pyrobosim", "meeting room 3", "meeting room"),
        ("rmf", "officer", "other"),
        ("rmf", "", "other"),
    ],
)
def test_labels_become_types(format_name, label, kind):
    assert vocabulary(format_name).type_of(label) == kind


def test_a_table_of_ones_own_comes_first(tmp_path):
    table = tmp_path / "t.json"
    table.write_text(json.dumps({"labels": {"Walkway": "street", "mill": ["factory", 200]}}), encoding="utf-8")
    words = vocabulary("imdf", table)
    assert [words.type_of(label) for label in ("walkway", "old mill", "office")] == ["street", "factory", "office"]
    assert words.area_of("mill") == 200
    table.write_text(json.dumps({"labels": {"mill": [1]}}), encoding="utf-8")
    with pytest.raises(WorldError, match=r"t\.json: labels\.mill: expected a type"):
        vocabulary("imdf", table)


def test_degrees_become_metres():
    """A degree of latitude at 45 N is 111,131.8 m on WGS 84, one of longitude 78,846.8 m."""
    plane = LocalPlane(7.0, 45.0)
    assert plane.metres([[7.001, 45.0], [7.0, 45.001]]) == pytest.approx(
        np.array([[78.8468, 0.0], [0.0, 111.1318]]), abs=2e-3
    )


@pytest.mark.parametrize(
    ("text", "levels"),
    [
        ("0", ["0"]),
        ("-1;0", ["-1", "0"]),
        ("0-2", ["0", "1", "2"]),
        ("-2--1", ["-2", "-1"]),
        ("0.5", ["0.5"]),
        ("roof", ["0"]),
        ("0-999", [str(k) for k in range(60)]),
    ],
)
def test_levels_of_a_tag(text, levels):
    assert levels_of(text) == levels


def test_free_space_is_cut_at_its_narrow_gaps():
    free = shapely.union_all([BOX(0, 0, 4, 3), BOX(4.2, 0, 8, 3), BOX(4, 1, 4.2, 1.9)])
    rooms, gaps = cut_at_gaps(free)
    assert sorted(room.area for room in rooms) == pytest.approx([11.4, 12.0], abs=0.01)
    assert len(gaps) == 1 and sorted(gaps[0].rooms) == [0, 1]
    assert sorted([gaps[0].y0, gaps[0].y1]) == pytest.approx([1.0, 1.9], abs=0.02)
    assert (gaps[0].x0, gaps[0].x1) == pytest.approx((4.1, 4.1), abs=0.02)


def test_a_narrow_corridor_is_a_room_and_a_wide_gap_is_none():
    corridor = shapely.union_all([BOX(0, 0, 4, 3), BOX(4, 1, 10, 2), BOX(10, 0, 14, 3)])
    rooms, gaps = cut_at_gaps(corridor)
    assert sorted(room.area for room in rooms) == pytest.approx([6, 12, 12], abs=0.05) and len(gaps) == 2
    assert len(cut_at_gaps(shapely.union_all([BOX(0, 0, 4, 3), BOX(4, 0.5, 8, 2.5)]))[0]) == 1


def test_walls_enclose_rooms_and_a_gap_between_wall_ends_is_closed():
    lines = [
        ((0, 0), (8, 0)),
        ((8, 0), (8, 3)),
        ((8, 3), (0, 3)),
        ((0, 3), (0, 0)),
        ((4, 0), (4, 1)),
        ((4.05, 2), (4.05, 3)),
    ]
    walls = [shapely.LineString(line) for line in lines]
    assert len(enclosed(walls)) == 1
    (gap,) = closings(walls)
    assert gap.length == pytest.approx(1.0, abs=0.06)
    assert sorted(p.area for p in enclosed([*walls, gap])) == pytest.approx([12, 12], abs=0.3)


def test_a_ring_of_corridors_is_cut_into_rows():
    ring = BOX(0, 0, 20, 12).difference(BOX(2, 2, 18, 10))
    pieces = split(ring)
    assert 2 <= len(pieces) <= 4 and sum(p.area for p in pieces) == pytest.approx(ring.area)
    assert all(annotate(piece)[1] > 0.95 for piece in pieces)
    assert split(BOX(0, 0, 4, 3)) == [BOX(0, 0, 4, 3)]


def test_pieces_of_a_room_stand_open_to_each_other_and_keep_their_doors():
    drawing = Drawing("w")
    drawing.add_room("ring", "corridor", "Ring", BOX(0, 0, 20, 12).difference(BOX(2, 2, 18, 10)))
    drawing.add_room("core", "office", "Core", BOX(2, 2, 18, 10))
    drawing.doors.append(DrawnDoor.between((9.5, 2), (10.4, 2), ("ring", "core")))
    world, report = realise(drawing, vocabulary("osm"), ImportOptions())
    assert report.components == 1 and report.assumed == 0 and report.passages >= 2
    (door,) = world.doors
    assert "office 1" in door.regions and any(region.startswith("hallway") for region in door.regions)


@pytest.mark.parametrize("slant", [1.0, 2.0, 3.0])
def test_slanted_walls_fit_better_off_the_corners(slant):
    room = shapely.Polygon([(0, 0), (8, 0), (8 - slant, 6), (slant, 6)])
    row, iou = refine(room, 0.0)
    own = shapely.union_all(shapely.polygons(row.rectangles()))
    assert own.intersection(room).area / own.union(room).area == pytest.approx(iou, abs=1e-6)
    assert iou > annotate(room)[1] + 0.005 and iou > 0.9


def test_open_borders_spare_what_a_wall_covers_and_never_cut_an_outer_wall():
    layout = lay_out("w", [space("a", BOX(0, 0, 4, 6)), space("b", BOX(4, 0, 8, 6)), space("c", BOX(8, 2, 12, 4))])
    (whole,) = open_borders(layout, [("a", "b")])
    assert abs(whole.y1 - whole.y0) == pytest.approx(6.0, abs=0.21) and not whole.door
    (left,) = open_borders(layout, [("a", "b")], BOX(3.9, 0, 4.1, 4))
    assert sorted([left.y0, left.y1]) == pytest.approx([4.0, 6.0], abs=0.21)
    assert open_borders(layout, [("a", "c")]) == []


def test_missing_doors_lead_to_a_hallway_in_the_longest_border():
    rooms = [space("h", BOX(0, 0, 10, 2), "hallway"), space("a", BOX(0, 2, 6, 5)), space("b", BOX(6, 2, 10, 5))]
    layout = lay_out("w", rooms)
    portals = missing_doors(layout, [], ["h"])
    assert {frozenset(portal.spaces) for portal in portals} == {frozenset("ha"), frozenset("hb")}
    assert {(round(p.x, 3), round(p.y, 3)) for p in portals} == {(3.0, 2.0), (8.0, 2.0)}
    island = lay_out("w", [space("h", BOX(0, 0, 10, 8), "hallway"), space("i", BOX(4, 3, 7, 5))])
    assert [set(portal.spaces) for portal in missing_doors(island, [], ["h"])] == [{"h", "i"}]


def test_components_are_what_openings_join():
    groups = components("abcd", [("a", "b"), ("b", "c")])
    assert groups["a"] == groups["b"] == groups["c"] != groups["d"]


def test_a_report_flags_what_three_rectangles_cannot_describe():
    drawing = Drawing("w")
    drawing.add_room("t", "office", "Tent", [(0, 0), (9, 0), (4.5, 7)])
    drawing.add_room("r", "office", "Room", BOX(0, -4, 9, 0))
    report = realise(drawing, vocabulary("osm"), ImportOptions(split=False), "f.json", "made up").report
    assert [room.name for room in report.poor] == ["Tent"] and report.good_share == 0.5
    assert "flag: office 1 (Tent): IoU 0.8" in "\n".join(report.lines())
    assert json.loads(json.dumps(report.as_dict()))["flagged"] == ["office 1"]


def test_a_ros_map_without_annotations_is_cut_at_its_gaps(tmp_path):
    from regionslam_env.worlds.importers.formats import import_plan
    from tests.worlds.importers.examples import DATA

    for name in ("floor.yaml", "floor.pgm"):
        (tmp_path / name).write_bytes((DATA / name).read_bytes())
    report = import_plan(tmp_path / "floor.yaml", ImportOptions()).report
    assert (len(report.rooms), report.doors, report.components) == (4, 3, 1)
    assert any("no floor.rooms.yaml beside the map" in note for note in report.notes)
    (tmp_path / "floor.pgm").unlink()
    with pytest.raises(WorldError, match=r"floor\.yaml: image 'floor\.pgm': cannot be read"):
        import_plan(tmp_path / "floor.yaml", ImportOptions())
