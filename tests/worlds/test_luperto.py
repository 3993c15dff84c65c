import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from regionslam_env.errors import WorldError
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.importers.luperto import load_luperto, plan_scale, type_of
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.reachability import unreachable
from tests.worlds.plans import LUPERTO, MISSING, compiled_only

ROOMS = {
    "c": ("CORRIDOR", [(0, 100), (300, 100), (300, 140), (0, 140)]),
    "a": ("OFFICE", [(0, 0), (100, 0), (100, 100), (0, 100)]),
    "b": ("BATHROOM", [(100, 0), (160, 0), (160, 100), (100, 100)]),
}
DOORS = [("a", "c", (50, 100)), ("b", "c", (101, 100))]


def xml(rooms=ROOMS, doors=DOORS, scale=(25, 90)):
    """Return a plan as text: y down, doors as segments of no length, one space that only refers to a group."""

    def points(*listed):
        return "".join(f'<point x="{x}" y="{y}"/>' for x, y in listed)

    def space(key):
        label, ring = rooms[key]
        mine = [(i, door) for i, door in enumerate(doors) if key in door[:2]]
        segments = "".join(f'<linesegment id="s{i}">{points(d[2], d[2])}</linesegment>' for i, d in mine)
        portals = "".join(
            f"<portal><linesegment>s{i}</linesegment><target><id>{d[0]}</id><id>{d[1]}</id></target></portal>"
            for i, d in mine
        )
        return (
            f'<space id="{key}"><labels><label>{label}</label></labels><bounding_polygon>{points(*ring)}'
            f"</bounding_polygon><space_representation>{segments}</space_representation><portals>{portals}</portals></space>"
        )

    drawn, real = scale or (0, 0)
    stated = (
        f"<scale><represented_distance><value>{drawn}</value></represented_distance>"
        f"<real_distance><value>{real}</value><um>cm</um></real_distance></scale>"
    )
    body = "".join(space(key) for key in rooms) + '<space id="group"/>'
    return f"<building>{stated if scale else ''}<floor><spaces>{body}</spaces></floor></building>"


def plan(tmp_path, text):
    path = tmp_path / "plan.xml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_rooms_get_our_types_and_metres_with_y_up(tmp_path):
    world = load_luperto(plan(tmp_path, xml()), scale=0.04)
    assert {r.id: r.type for r in world.regions if r.type != "door"} == {
        "hallway 1": "hallway",
        "office 1": "office",
        "toilet 1": "toilet",
    }
    assert world.region("office 1").row.centre == pytest.approx((2, -2))
    assert world.region("hallway 1").row.area == pytest.approx(12 * 1.6)
    assert world.region("toilet 1").name == "bathroom 1"


def test_doors_are_cut_and_linked_and_shifted_from_corners(tmp_path):
    world = load_luperto(plan(tmp_path, xml()), scale=0.04)
    assert len(world.doors) == 2
    office, toilet = world.doors
    assert sorted([office.x0, office.x1]) == pytest.approx([1.55, 2.45])
    assert min(toilet.x0, toilet.x1) >= 4.25 - 1e-9  # said to be 4 cm from the corner at x = 4
    assert {link.target for link in world.links_of(office.id)} == {"office 1", "hallway 1"}
    assert unreachable(world) == ()


def test_a_believable_scale_is_kept(tmp_path):
    assert plan_scale(plan(tmp_path, xml(scale=(25, 90)))) == pytest.approx(0.036)


def test_a_scale_that_makes_rooms_huge_is_overruled(tmp_path):
    scale = plan_scale(plan(tmp_path, xml(scale=(5, 90))))
    assert scale == pytest.approx(np.sqrt(np.sqrt(16 / 1e4 * 8 / 6e3)))  # office 100 x 100 and bathroom 60 x 100 pixels
    assert plan_scale(plan(tmp_path, xml(scale=None))) == pytest.approx(scale)


def test_labels_are_mapped_by_the_table():
    assert [type_of(label) for label in ("CORRIDOR", "washroom", "CONFERENCE ROOM", "LAB", "CUBICULE", "CLOSET")] == [
        "hallway",
        "toilet",
        "meeting room",
        "laboratory",
        "office",
        "storage",
    ]
    assert type_of("DUNGEON") == "other"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected XML"),
        (xml()[:300], "expected XML"),
        (b"\xff\xfe\x00<", "expected XML"),
        ('<?xml version="1.0" encoding="klingon"?><building/>', "expected XML"),
        ("<house/>", "root element is <house>, expected <building>"),
        ("<building/>", "no <space> with a <bounding_polygon>|<scale> is missing"),
        ('<!DOCTYPE x [<!ENTITY a "b">]><building/>', "document type declaration"),
        (xml(rooms={"a": ("OFFICE", [(0, 0), (1, 1)])}, doors=[]), "at least 3 different points, got 2"),
        (xml(rooms={"a": ("OFFICE", [(0, 0), (1, 1), (2, 2)])}, doors=[]), "an outline with an area"),
        (xml(rooms={"a": ("OFFICE", [(0, 0), ("x", 1), (2, 2)])}, doors=[]), "point x: expected a number, got 'x'"),
        (xml(rooms={"a": ("OFFICE", [(0, 0), ("nan", 1), (2, 2)])}, doors=[]), "expected a number, got 'nan'"),
        (xml(rooms={"": ("OFFICE", [(0, 0), (9, 0), (9, 9)])}, doors=[]), "expected an id that no other space has"),
        (xml(scale=(0, 90)), "scale: expected distances above 0"),
        (xml().replace("<um>cm</um>", "<um>ell</um>"), "expected cm, mm or m, got 'ell'"),
    ],
)
def test_broken_plans_are_named(tmp_path, text, message):
    with pytest.raises(WorldError, match=message) as caught:
        load(plan(tmp_path, text))
    assert "plan.xml" in str(caught.value)


@pytest.mark.parametrize("scale", [0, -1, float("nan")])
def test_a_bad_override_of_the_scale_is_named(tmp_path, scale):
    with pytest.raises(WorldError, match="metres per pixel above 0"):
        load_luperto(plan(tmp_path, xml()), scale=scale)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_damage_gives_a_world_or_an_error(tmp_path, data):
    content = xml().encode()
    begin = data.draw(st.integers(0, len(content)))
    end = data.draw(st.integers(begin, min(begin + 40, len(content))))
    path = plan(tmp_path, content[:begin] + data.draw(st.binary(max_size=6)) + content[end:])
    try:
        load_luperto(path)
    except WorldError as error:
        assert "plan.xml" in str(error) or "plan 'plan'" in str(error)


@pytest.mark.skipif(not LUPERTO, reason=MISSING)
@pytest.mark.parametrize("path", LUPERTO, ids=lambda path: path.stem)
@compiled_only
def test_real_buildings_can_be_driven_through(path):
    world = load(path)
    hallways = [region.id for region in world.regions_of_type("hallway")]
    assert hallways
    assert all(len(door.regions) == 2 for door in world.doors)
    out_of_reach = set(unreachable(world))
    without_a_door = {r.id for r in world.regions if r.parent is None} - {
        i for d in world.doors for i in (d.id, *d.regions)
    }
    assert out_of_reach == without_a_door
    assert len(out_of_reach) <= 1
    field = Geodesic(world).field(hallways)
    rng = np.random.default_rng(0)
    for _ in range(5):
        x, y = Geodesic(world).sample_free(rng, field, at_least=2.0)
        assert 2.0 <= field.at(x, y) < 100


@pytest.mark.skipif(not LUPERTO, reason=MISSING)
@pytest.mark.parametrize("path", LUPERTO, ids=lambda path: path.stem)
def test_real_rooms_have_believable_sizes(path):
    world = load(path)
    offices = [r.row.area for r in world.regions if r.type in ("office", "toilet", "classroom")]
    assert 4 < np.median(offices) < 90
    assert all(0.7 < np.hypot(d.x1 - d.x0, d.y1 - d.y0) <= 0.91 for d in world.doors)
