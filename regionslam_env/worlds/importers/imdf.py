"""Indoor maps after Apple's IMDF and Azure Maps: units, openings and levels as GeoJSON, in one file or one file each.

Coordinates are longitude and latitude. IMDF names a feature's ``feature_type``, ``level_id`` and ``category``; Azure
Maps puts each kind into a file of its name and refers to a category by id. A border between two open areas is open
unless a structure stands on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import shapely

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor
from regionslam_env.worlds.importers.geodetic import LocalPlane, check_degrees, origin_of, polygons_of, projected
from regionslam_env.worlds.importers.levels import choose
from regionslam_env.worlds.importers.node import Node
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.source import Source
from regionslam_env.worlds.importers.vocabulary import vocabulary

SOLID = {
    "structure", "column", "brick", "concrete", "drywall", "glass", "wood", "opentobelow", "vegetation", "sand", "road",
    "unenclosedarea", "fieldofplay", "footbridge",
}  # fmt: skip
"""Categories of units that nobody can be inside of, or that are outdoors."""

KINDS = ("unit", "opening", "level", "verticalpenetration", "structure", "category", "fixture", "areaelement")
NO_NEED = ("facility", "zone", "lineelement", "pointelement", "directoryinfo", "venue", "building", "footprint")


@dataclass(frozen=True)
class _Feature:
    """A feature, its kind in lower case, id and level."""

    node: Node
    kind: str

    @property
    def properties(self) -> Node:
        return self.node["properties"]

    @property
    def id(self) -> str:
        return self.node.text_of("id") or self.properties.text_of("id") or self.node.place

    @property
    def level(self) -> str:
        return self.properties.text_of("level_id") or self.properties.text_of("levelId")

    @property
    def name(self) -> str:
        name = self.properties.get("name")
        if name is None:
            return ""
        if isinstance(name.value, dict):  # by language
            texts = dict(name.fields())
            chosen = texts.get("en") or next(iter(texts.values()), None)
            return "" if chosen is None or chosen.value is None else chosen.text()
        return name.text()


def is_dataset(folder: Path) -> bool:
    """Return whether a folder holds the units of one building."""
    return any((folder / f"unit{ending}").is_file() for ending in (".geojson", ".json"))


def refusal(source: Source) -> str | None:
    """Return why a file or folder is none of these, None where it is one."""
    if source.path.is_dir():
        return None if is_dataset(source.path) else "no unit.geojson"
    stem = source.path.stem.lower()
    if stem in (*KINDS, *NO_NEED) and is_dataset(source.path.parent):
        raise WorldError(
            f"{source.path}: one of several files of a building, expected their folder {source.path.parent}"
        )
    features = source.json.value.get("features") if isinstance(source.json.value, dict) else None
    if not isinstance(features, list):
        return "no list of features"
    for feature in features:
        properties = feature.get("properties") if isinstance(feature, dict) else None
        if isinstance(properties, dict) and (feature.get("feature_type") == "unit" or "levelId" in properties):
            return None
    return "no feature of feature_type 'unit'"


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of one level."""
    features = list(_features(source))
    by_kind: dict[str, list[_Feature]] = {kind: [] for kind in KINDS}
    for feature in features:
        by_kind.get(feature.kind, []).append(feature)
    categories = {f.id: f.name for f in by_kind["category"]}
    rooms = by_kind["unit"] + by_kind["verticalpenetration"]
    names = _level_names(by_kind["level"], rooms)
    ground = [names[f.id] for f in by_kind["level"] if f.properties.number_of("ordinal", 1) == 0]
    counted = [names[f.level] for f in rooms]
    level = choose(list(names.values()), counted, options.level, source.path, ground[0] if ground else None)
    shapes = {f.id: polygons_of(f.node["geometry"]) for f in rooms if f.node.get("geometry")}
    plane = origin_of([p for parts in shapes.values() for rings in parts for ring in rings for p in ring], source.path)
    drawing = Drawing(source.path.stem, level, tuple(names.values()))
    here = {kind: [f for f in found if names.get(f.level) == level] for kind, found in by_kind.items()}
    for feature in here["structure"]:
        drawing.walls += [projected(plane, rings) for rings in polygons_of(feature.node["geometry"])]
    for feature in here["unit"] + here["verticalpenetration"]:
        _add_room(drawing, feature, categories, plane, shapes.get(feature.id, []))
    for feature in here["opening"]:
        _add_door(drawing, feature, plane)
    for feature in here["fixture"] + here["areaelement"]:
        if feature.kind == "fixture" or feature.properties.value.get("isObstruction"):
            for rings in polygons_of(feature.node["geometry"]):
                label = _category(feature, categories) or "fixture"
                drawing.add_item(label, feature.name or None, projected(plane, rings))
    return drawing


def _features(source: Source) -> Iterator[_Feature]:
    """Yield the features of a file, or of every file of a folder that matters."""
    files = sorted(source.path.iterdir()) if source.path.is_dir() else [source.path]
    for path in files:
        default = path.stem.lower() if source.path.is_dir() else "unit"
        if path.suffix.lower() not in (".geojson", ".json") or (source.path.is_dir() and default not in KINDS):
            continue
        for node in Source(path).json["features"].items():
            kind = node.text_of("feature_type") or node.text_of("featureType") or default
            yield _Feature(node, kind.lower().replace("_", ""))


def _level_names(levels: list[_Feature], rooms: list[_Feature]) -> dict[str, str]:
    """Return the name of every level by its id, lowest first."""
    ordered = sorted(levels, key=lambda f: f.properties.number_of("ordinal", 0))
    names: dict[str, str] = {}
    for feature in ordered:
        name = feature.name or str(feature.properties.text_of("ordinal")) or feature.id
        names[feature.id] = name if name not in names.values() else f"{name} ({feature.id})"
    for room in rooms:
        names.setdefault(room.level, room.level or "0")
    return names


def _category(feature: _Feature, categories: dict[str, str]) -> str:
    """Return a feature's category, of "room.office" just "office"."""
    properties = feature.properties
    text = properties.text_of("category") or categories.get(properties.text_of("categoryId"), "")
    return text.rsplit(".", 1)[-1]


def _add_room(
    drawing: Drawing,
    feature: _Feature,
    categories: dict[str, str],
    plane: LocalPlane,
    parts: list[list[list[tuple[float, float]]]],
) -> None:
    category = _category(feature, categories)
    what = f"unit {feature.name or feature.id!r}"
    if category.lower() in SOLID:
        drawing.drop(what, f"category {category}: no room")
        return
    if not parts:
        drawing.drop(what, "no outline")
        return
    shape = shapely.union_all([projected(plane, rings) for rings in parts])
    kind = vocabulary("imdf").type_of(category, feature.name)
    unwalled = bool(feature.properties.value.get("isOpenArea")) or (kind == "hallway" and bool(drawing.walls))
    drawing.add_room(feature.id, category, feature.name or None, shape, unwalled)


def _add_door(drawing: Drawing, feature: _Feature, plane: LocalPlane) -> None:
    geometry = feature.node["geometry"]
    if geometry.text_of("type") != "LineString":
        drawing.drop(f"opening {feature.id!r}", "no LineString")
        return
    coordinates = geometry["coordinates"]
    points = plane.metres([check_degrees(coordinates, p) for p in coordinates.points(2)])
    drawing.doors.append(DrawnDoor.between(points[0], points[-1], what="opening"))
