import os
from pathlib import Path

import pytest

from regionslam_env.errors import WorldError
from regionslam_env.worlds.format import save_world
from regionslam_env.worlds.loading import builtin_names, load
from tests.floors import furnished_room, two_rooms

EXAMPLES = Path(__file__).parent / "importers" / "data"


def test_builtins_are_found_by_name():
    assert "institute" in builtin_names()
    assert load("institute").name == "institute"
    assert load("institute") is load("institute")


def test_a_world_is_handed_back():
    world = two_rooms()
    assert load(world) is world


def test_a_file_is_read_again_when_it_changes(tmp_path):
    path = tmp_path / "w.geojson"
    save_world(two_rooms(), path)
    assert load(path).name == load(str(path)).name == "two rooms"
    save_world(furnished_room(), path)
    os.utime(path, ns=(1, 1))
    assert load(path).name == "furnished room"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("institut", r"unknown world 'institut': did you mean 'institute'"),
        ("nowhere.geojson", r"nowhere\.geojson: no such file.*\.ifc, .*\.ifc\.gz, or a folder"),
        ("nowhere.ifc.gz", r"nowhere\.ifc\.gz: no such file"),
        ("some/where", "no such file"),
        ("x" * 5000, "unknown world"),
        ("", "unknown world"),
        (".", "unknown world"),
    ],
)
def test_what_is_not_there_is_named(name, message):
    with pytest.raises(WorldError, match=message):
        load(name)


def test_an_unknown_ending_is_named(tmp_path):
    path = tmp_path / "plan.dwg"
    path.write_bytes(b"AC1027")
    with pytest.raises(WorldError, match=r"ending '\.dwg', expected one of \.geojson"):
        load(path)


@pytest.mark.parametrize("name", ["home.json", "cottage.xml", "flat.yaml", "floor.yaml", "shop.building.yaml"])
def test_a_level_that_a_file_does_not_have_is_refused(name):
    path = EXAMPLES / name
    with pytest.raises(WorldError, match=rf"{name}: unknown level '7': .*'{load(path).level}'"):
        load(path, level="7")
    assert load(path, level=load(path).level).level == load(path).level


@pytest.mark.parametrize("world", ["institute", two_rooms()])
def test_a_level_that_a_world_does_not_have_is_refused(world):
    level = load(world).level
    with pytest.raises(WorldError, match=f"unknown level '7': expected one of '{level}'"):
        load(world, level="7")
    assert load(world, level=level) is load(world)
