"""Files: complete or absent, the same after a round trip, and clear errors."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from slam.geojson import MapError
from slam.region import REGION
from slam.region_map import RegionMap
from slam.storage import load_arrays, load_map, replacing, save_arrays, save_map


def test_a_map_survives(drawn: RegionMap, tmp_path: Path) -> None:
    path = tmp_path / "new folder" / "map.geojson"
    save_map(drawn, path)
    read = load_map(path)
    assert read.to_geojson() == drawn.to_geojson()
    assert [r.id for r in read.regions] == [r.id for r in drawn.regions]
    assert [r.id for r in read.neighbours(10)] == [r.id for r in drawn.neighbours(10)]
    assert os.listdir(path.parent) == ["map.geojson"]


def test_the_file_is_plain_geojson(drawn: RegionMap, tmp_path: Path) -> None:
    save_map(drawn, tmp_path / "map.geojson")
    collection = json.loads((tmp_path / "map.geojson").read_text(encoding="utf-8"))
    assert collection["type"] == "FeatureCollection"
    assert len(collection["features"]) == 12


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "map.geojson"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="power cut"), replacing(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError("power cut")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["map.geojson"]


def test_a_result_is_as_readable_as_any_other_file(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    with replacing(tmp_path / "result") as temporary:
        temporary.write_text("")
    assert (tmp_path / "result").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize(
    "content", [b"", b"{", b"\xff\xfe\x00", b"[]", b'{"type": "FeatureCollection"}', b"[" * 100_000]
)
def test_a_broken_map_is_refused_by_name(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "broken.geojson"
    path.write_bytes(content)
    with pytest.raises(MapError, match=r"broken\.geojson: "):
        load_map(path)


def test_a_truncated_map_is_refused(drawn: RegionMap, tmp_path: Path) -> None:
    path = tmp_path / "map.geojson"
    save_map(drawn, path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(MapError, match=r"map\.geojson: "):
        load_map(path)


def test_a_repeated_id_is_refused(drawn: RegionMap, tmp_path: Path) -> None:
    collection = drawn.to_geojson()
    collection["features"].append(collection["features"][0])
    (tmp_path / "twice.geojson").write_text(json.dumps(collection))
    with pytest.raises(MapError, match=r"twice\.geojson: .*\[10\] come more than once"):
        load_map(tmp_path / "twice.geojson")


def test_arrays_survive_with_their_records(tmp_path: Path) -> None:
    regions = np.zeros((2, 3), REGION)
    regions["id"] = [[1, 2, 3], [4, 5, 6]]
    regions["anchor"][1, 2] = (0.1, -7.0)
    save_arrays(tmp_path / "state.npz", {"regions": regions, "log_weights": [0.5, -np.inf]})
    read = load_arrays(tmp_path / "state.npz", {"regions": REGION})
    assert read["regions"].dtype == REGION and read["regions"].shape == (2, 3)
    assert read["regions"][1, 2].id == 6  # records again
    np.testing.assert_array_equal(read["regions"], regions)
    np.testing.assert_array_equal(read["log_weights"], [0.5, -np.inf])
    read["regions"]["id"][0, 0] = 9  # and writeable


def test_arrays_of_another_kind_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    save_arrays(path, {"regions": np.zeros(3)})
    with pytest.raises(MapError, match=r"state\.npz: regions has dtype float64"):
        load_arrays(path, {"regions": REGION})
    with pytest.raises(MapError, match=r"state\.npz: links is missing"):
        load_arrays(path, {"links": REGION})
    with pytest.raises(MapError, match="objects"):
        save_arrays(path, {"anything": np.array([{}])})


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"hello"])
def test_a_broken_file_of_arrays_is_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "state.npz").write_bytes(content)
    with pytest.raises(MapError, match=r"state\.npz: not a file of arrays"):
        load_arrays(tmp_path / "state.npz")


def test_pickles_are_not_read(tmp_path: Path) -> None:
    np.savez(tmp_path / "state.npz", evil=np.array([{}], dtype=object))
    with pytest.raises(MapError, match="not a file of arrays"):
        load_arrays(tmp_path / "state.npz")


def test_a_file_that_cannot_be_made_is_named_as_it_was_given(tmp_path, monkeypatch):
    def refuse(**options):
        raise PermissionError(13, "Permission denied", str(tmp_path / ".map-1234"))

    monkeypatch.setattr("tempfile.mkstemp", refuse)
    with pytest.raises(PermissionError) as caught, replacing(tmp_path / "map.geojson"):
        pass
    assert caught.value.filename == str(tmp_path / "map.geojson")
