"""Region features as GeoJSON: valid outlines, every field kept, errors that say where."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Any

import numpy as np
import pytest
from shapely.geometry import shape

from slam.geojson import MapError, feature_to_geojson, features_from_geojson, features_to_geojson, row_geometry
from slam.region import EdgeState, RegionFeature, Subrectangle
from slam.rows import Row

OPEN, CLOSED, SUBRECT = EdgeState


def full_feature() -> RegionFeature:
    """Every field unlike its default, and unlike every other."""
    left = Subrectangle(1.5, 0.1 + 0.2, -0.25, OPEN, CLOSED, OPEN, np.array([[1.1, 0.2], [0.2, 1.3]]), 1.4)
    right = Subrectangle(2.5, 3.5, 0.75, CLOSED, OPEN, CLOSED, np.array([[2.1, 0.3], [0.3, 2.3]]), 2.4)
    return RegionFeature(
        id=2**40 + 7,
        type="Büro №5",
        type_log_odds=1 / 3,
        x=-12.345678901234567,
        y=1e-17,
        w=math.pi,
        h=math.e,
        phi=-0.7,
        t=OPEN,
        b=CLOSED,
        l=SUBRECT,
        r=SUBRECT,
        left=left,
        right=right,
        cov_xy=np.array([[0.01, 0.002], [0.002, 0.03]]),
        cov_wh=np.array([[0.04, -0.001], [-0.001, 0.05]]),
        var_phi=1e-6,
        neighbours={"t": {3: 0.5, 4: -2.0}, "ll": {2**41: 9.5}},
        children={11: -0.125},
        existence=-0.75,
        sightings=12,
        visited=True,
        credible=False,
        level=-2,
        name="B 4.12",
    )


def assert_same(a: Any, b: Any) -> None:
    """Compare dataclasses field by field, exactly, types included."""
    assert type(a) is type(b)
    if dataclasses.is_dataclass(a):
        for field in dataclasses.fields(a):
            assert_same(getattr(a, field.name), getattr(b, field.name))
    elif isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b)
    else:
        assert a == b


def through_json(feature: RegionFeature) -> RegionFeature:
    (read,) = features_from_geojson(json.loads(json.dumps(features_to_geojson([feature]), allow_nan=False)))
    return read


def test_every_field_survives() -> None:
    feature = full_feature()
    defaults = RegionFeature(0, "", 0.0, 0.0, 0.0, 1.0, 1.0, 0.0)
    same = {
        f.name
        for f in dataclasses.fields(feature)
        if np.array_equal(getattr(feature, f.name), getattr(defaults, f.name))
    }
    assert same == {"b"}, "the example must not hide a field behind its default"
    assert_same(through_json(feature), feature)


def test_a_plain_feature_survives() -> None:
    feature = RegionFeature(1, "office", 0.0, 1.0, 2.0, 3.0, 4.0, 0.5, l=OPEN)
    assert_same(through_json(feature), feature)


def test_what_is_not_finite_survives_as_text() -> None:
    feature = dataclasses.replace(full_feature(), var_phi=math.inf, children={3: -math.inf})
    assert_same(through_json(feature), feature)


def test_the_outline_is_a_valid_ring() -> None:
    feature = full_feature()
    polygon = shape(feature_to_geojson(feature)["geometry"])
    assert polygon.is_valid
    assert polygon.area == pytest.approx(feature.row.area)
    assert polygon.exterior.is_ccw


def test_flush_rectangles_make_a_plain_rectangle() -> None:
    geometry = row_geometry(Row(0, 0, 0, [0, 1, 2, 5], [0, 0, 0], [2, 2, 2], main=1))
    assert geometry == {"type": "Polygon", "coordinates": [[[0, 0], [5, 0], [5, 2], [0, 2], [0, 0]]]}


def test_rectangles_apart_make_several_polygons() -> None:
    geometry = row_geometry(Row(0, 0, 0, [0, 1, 2], [0, 3], [1, 4]))
    assert geometry["type"] == "MultiPolygon"
    assert shape(geometry).is_valid and shape(geometry).area == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("x", "far", "feature 0: x is 'far', expected a number"),
        ("x", None, "feature 0: x is None, expected a number"),
        ("x", "nan", "must be finite"),
        ("w", -1, "positive width and height"),
        ("t", "ajar", "feature 0: t is 'ajar', expected open, closed or subrect"),
        ("l", "closed", "feature 0: l is closed, expected subrect exactly where"),
        ("cov_xy", [[1, 2]], r"feature 0: cov_xy is \[\[1, 2\]\], expected a 2 x 2 matrix"),
        ("left", {"w": 1}, "feature 0: left is {'w': 1}, expected a subrectangle or null"),
        ("neighbours", {"top": {}}, "feature 0: neighbours is .*, expected links by edge name"),
        ("children", [1], "feature 0: children is .*, expected log-odds by region id"),
        ("visited", 1, "feature 0: visited is 1, expected true or false"),
        ("id", 1.5, "feature 0: id is 1.5, expected an integer"),
        ("type", 5, "feature 0: type is 5, expected a text"),
        ("level", "first", "feature 0: level is 'first', expected an integer"),
        ("name", None, "feature 0: name is None, expected a text"),
    ],
)
def test_errors_name_feature_field_and_value(name: str, value: object, message: str) -> None:
    collection = features_to_geojson([full_feature()])
    collection["features"][0]["properties"][name] = value
    with pytest.raises(MapError, match=message):
        features_from_geojson(collection)


def test_a_missing_field_is_named() -> None:
    collection = features_to_geojson([full_feature()])
    del collection["features"][0]["properties"]["phi"]
    with pytest.raises(MapError, match="feature 0: phi is missing"):
        features_from_geojson(collection)


@pytest.mark.parametrize(
    "collection", [None, [], {}, {"type": "Feature"}, {"type": "FeatureCollection", "features": {}}]
)
def test_what_is_no_collection_is_refused(collection: object) -> None:
    with pytest.raises(MapError, match="expected"):
        features_from_geojson(collection)


def test_features_of_another_kind_are_skipped() -> None:
    collection = features_to_geojson([full_feature()])
    collection["features"].insert(0, {"type": "Feature", "geometry": None, "properties": {"kind": "wall"}})
    assert len(features_from_geojson(collection)) == 1


def test_files_of_version_1_have_one_level_and_no_names() -> None:
    collection = features_to_geojson([dataclasses.replace(full_feature(), level=0, name="")])
    collection["version"] = 1
    for name in ("level", "name"):
        del collection["features"][0]["properties"][name]
    (read,) = features_from_geojson(collection)
    assert_same(read, dataclasses.replace(full_feature(), level=0, name=""))
    with pytest.raises(MapError, match="feature 0: level is missing"):
        features_from_geojson({**collection, "version": 2} | {"features": [drop(collection, "level")]})


def drop(collection: dict[str, Any], name: str) -> dict[str, Any]:
    feature = collection["features"][0]
    properties = {"name": "", "level": 0, **feature["properties"]}
    return {**feature, "properties": {key: value for key, value in properties.items() if key != name}}


@pytest.mark.parametrize("version", [0, 3, "2", None])
def test_other_versions_are_refused(version: object) -> None:
    with pytest.raises(MapError, match=r"version is .*, expected 1 to 2"):
        features_from_geojson({**features_to_geojson([]), "version": version})
