import os

import pytest

from regionslam_env.errors import WorldError
from regionslam_env.worlds.format import save_world
from regionslam_env.worlds.loading import builtin_names, load
from tests.floors import furnished_room, two_rooms


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
        ("nowhere.geojson", r"nowhere\.geojson: no such file"),
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
