"""Building models as IFC (extra ``ifc``): every IfcSpace is a room, every IfcDoor stands where its opening is.

Lengths are converted from the model's unit. A footprint is the shadow that a shape throws on the floor.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import shapely

from regionslam_env.errors import WorldError, hint
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor, largest
from regionslam_env.worlds.importers.levels import choose
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.source import Source
from slam.rows import Floats

STRING = re.compile(r"'(?:[^']|'')*'")
DEFINED = re.compile(r"(#\d+)\s*=")
REFERENCE = re.compile(r"#\d+")


def refusal(source: Source) -> str | None:
    """Return why a file is no model, None where it is one."""
    return None if source.data.lstrip()[:13] == b"ISO-10303-21;" else "does not begin with ISO-10303-21;"


def read(source: Source, options: ImportOptions) -> Drawing:
    """Return the drawing of one storey."""
    model = _open(source)
    try:
        _check_entities(source, model)
        return _drawing(source, model, options)
    except WorldError:
        raise
    except (RuntimeError, AttributeError, TypeError, ValueError, LookupError) as error:  # what a damaged model raises
        reason = " ".join(str(error).split())[:200]
        raise WorldError(f"{source.path}: {type(error).__name__} ({reason}), expected an undamaged IFC model") from None


def _drawing(source: Source, model: Any, options: ImportOptions) -> Drawing:
    spaces = [(space, _storey(space)) for space in model.by_type("IfcSpace")]
    if not spaces:
        raise WorldError(f"{source.path}: no IfcSpace, expected rooms: export the model with its rooms or spaces")
    used = {storey for _, storey in spaces}
    storeys = [storey for storey in model.by_type("IfcBuildingStorey") if storey.id() in used]
    storeys.sort(key=lambda s: (float(s.Elevation or 0), s.id()))
    names = _unique({storey.id(): str(storey.Name or storey.id()) for storey in storeys})
    level = choose(list(names.values()), [names.get(s or -1, "") for _, s in spaces], options.level, source.path)
    drawing = Drawing(source.path.name.split(".")[0], level, tuple(names.values()))
    shapes = _Shapes()
    for space, storey in spaces:
        if names.get(storey or -1) != level:
            continue
        label = str(space.LongName or space.ObjectType or "")
        name = " ".join(part for part in (label, str(space.Name or "")) if part)
        corners = shapes.triangles(space)
        if corners is None:
            drawing.drop(f"space {name!r}", "no geometry")
        else:
            drawing.add_room(str(space.id()), label or name, name or None, _shadow(corners))
    for door in model.by_type("IfcDoor"):
        if names.get(_storey(door) or -1) == level:
            _add_door(drawing, door, shapes)
    for item in model.by_type("IfcFurnishingElement"):
        corners = shapes.triangles(item) if names.get(_storey(item) or -1) == level else None
        if corners is not None:
            label = re.split(r"[:\d]", str(item.Name or item.is_a()))[0].strip() or "furniture"
            drawing.add_item(label, None, shapely.minimum_rotated_rectangle(_shadow(corners)))
    return drawing


def _open(source: Source) -> Any:
    try:
        import ifcopenshell
    except ImportError:
        raise WorldError(hint(f"{source.path}: IFC needs the extra ifc", "ifc")) from None
    text = source.text
    _check_references(source, text)
    try:
        return ifcopenshell.file.from_string(text)
    except Exception as error:  # the parser has a dozen exceptions of its own
        raise WorldError(f"{source.path}: {' '.join(str(error).split())[:200]}, expected an IFC model") from None


def _check_references(source: Source, text: str) -> None:
    """Refuse a model that refers to what it does not define, or defines twice: the geometry kernel dies of some."""
    text = STRING.sub("", text)
    defined = Counter(DEFINED.findall(text))
    twice = next((name for name, count in defined.items() if count > 1), None)
    if twice is not None:
        raise WorldError(f"{source.path}: {twice} is defined {defined[twice]} times, expected once")
    missing = next((name for name in REFERENCE.findall(text) if name not in defined), None)
    if missing is not None:
        raise WorldError(f"{source.path}: {missing} is not defined, expected an IFC model without gaps")


def _check_entities(source: Source, model: Any) -> None:
    """Refuse a model in which something refers to an entity of the wrong kind: the geometry kernel dies of some."""
    import ifcopenshell

    schema = ifcopenshell.schema_by_name(model.schema_identifier)
    wanted: dict[str, list[tuple[int, str, str]]] = {}
    for instance in model:
        kind = instance.is_a()
        if kind not in wanted:
            attributes = enumerate(schema.declaration_by_name(kind).as_entity().all_attributes())
            named = [(i, a.name(), _entity_of(a.type_of_attribute())) for i, a in attributes]
            wanted[kind] = [(i, name, entity) for i, name, entity in named if entity is not None]
        for i, name, entity in wanted[kind]:
            for value in _flat(instance[i]):
                if not value.is_a(entity):
                    what = f"#{instance.id()} ({kind}): {name}"
                    raise WorldError(f"{source.path}: {what}: expected {entity}, got {value.is_a()} #{value.id()}")


def _entity_of(kind: Any) -> str | None:
    """Return the entity that an attribute, or each item of it, refers to; None for what is no entity."""
    while kind.as_aggregation_type() is not None:
        kind = kind.as_aggregation_type().type_of_element()
    named = kind.as_named_type()
    entity = None if named is None else named.declared_type().as_entity()
    return None if entity is None else str(entity.name())


def _flat(value: Any) -> Iterator[Any]:
    """Yield an instance, or those in lists of them."""
    if isinstance(value, tuple):
        for item in value:
            yield from _flat(item)
    elif value is not None:
        yield value


def _storey(element: Any) -> int | None:
    """Return the id of the storey that an element belongs to."""
    for _ in range(8):
        if element is None:
            return None
        if element.is_a("IfcBuildingStorey"):
            return int(element.id())
        relations: Iterable[Any] = (*getattr(element, "ContainedInStructure", ()), *getattr(element, "Decomposes", ()))
        parents = [getattr(r, "RelatingStructure", None) or getattr(r, "RelatingObject", None) for r in relations]
        element = parents[0] if parents else None
    return None


def _unique(names: dict[int, str]) -> dict[int, str]:
    """Return names of which no two are equal."""
    seen: set[str] = set()
    result = {}
    for key, name in names.items():
        result[key] = name if name not in seen else f"{name} (#{key})"
        seen.add(name)
    return result


class _Shapes:
    """Triangles of elements in metres of the model's frame."""

    def __init__(self) -> None:
        import ifcopenshell.geom

        self._geom = ifcopenshell.geom
        self._settings = ifcopenshell.geom.settings()
        self._settings.set("use-world-coords", True)

    def triangles(self, element: Any) -> Floats | None:
        """Return an element's triangles, (k, 3, 3), m, None where it has none."""
        try:
            geometry = self._geom.create_shape(self._settings, element).geometry
        except RuntimeError:
            return None
        points = np.array(geometry.verts, dtype=np.float64).reshape(-1, 3)
        faces = np.array(geometry.faces, dtype=np.int64).reshape(-1, 3)
        return points[faces] if len(faces) and np.isfinite(points).all() else None


def _shadow(triangles: Floats) -> shapely.Polygon:
    """Return the outline of triangles (k, 3, 3) seen from above."""
    flat = shapely.polygons(triangles[:, :, :2])
    return largest(shapely.union_all(flat[shapely.area(flat) > 1e-6], grid_size=1e-4))


def _add_door(drawing: Drawing, door: Any, shapes: _Shapes) -> None:
    """Add a door: as wide as it says, along its own x axis, in the middle of its opening."""
    openings = [r.RelatingOpeningElement for r in getattr(door, "FillsVoids", ())]
    corners = shapes.triangles(openings[0] if openings else door)
    what = f"door {door.Name or door.id()!r}"
    if corners is None:
        drawing.drop(what, "no geometry")
        return
    box = shapely.minimum_rotated_rectangle(shapely.MultiPoint(corners[:, :, :2].reshape(-1, 2)))
    ring = shapely.get_coordinates(box)
    if len(ring) < 5:
        drawing.drop(what, "no width")
        return
    sides = ring[1:3] - ring[0:2]
    along = max(sides, key=lambda s: float(np.hypot(*s)))
    axis = _axis(door)
    if axis is not None:
        along = max(sides, key=lambda s: abs(float(s @ axis)))
    middle = np.array(box.centroid.coords[0])
    drawing.doors.append(DrawnDoor.between(middle - along / 2, middle + along / 2))


def _axis(door: Any) -> Floats | None:
    """Return the direction of a door's x axis in its opening's or the model's frame, None where it is not told."""
    import ifcopenshell.util.placement

    try:
        matrix = ifcopenshell.util.placement.get_local_placement(door.ObjectPlacement)
    except Exception:  # a damaged chain of placements
        return None
    axis = np.asarray(matrix, dtype=np.float64)[:2, 0]
    return axis if np.isfinite(axis).all() and np.hypot(*axis) > 0.5 else None
