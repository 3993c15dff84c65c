"""From a drawing to a world and a report: types, ids, doors between the right rooms, furniture in its room."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely

from regionslam_env.worlds.annotate import annotate
from regionslam_env.worlds.borders import adjacent, components, missing_doors, open_borders
from regionslam_env.worlds.floorplan import Opening
from regionslam_env.worlds.importers.drawing import Drawing, DrawnDoor
from regionslam_env.worlds.importers.report import ImportReport, RoomReport
from regionslam_env.worlds.importers.split import split_rooms
from regionslam_env.worlds.importers.vocabulary import OTHER, Vocabulary
from regionslam_env.worlds.plan import Layout, Portal, Space, close, lay_out, place
from regionslam_env.worlds.world import Region, World

CIRCULATION = ("hallway", "lobby", "entrance")
"""Types of rooms that others may be assumed to have a door to."""

DOOR_WIDTHS = (0.75, 2.5)
"""Doors are made no narrower and no wider than this, m."""

BESIDE = (0.05, 0.15, 0.3, 0.5, 0.8)
"""How far from a door (m) its rooms are looked for."""


@dataclass(frozen=True)
class ImportOptions:
    """How to import a file.

    Parameters
    ----------
    level
        Which level; default: the one with the most rooms.
    scale
        Metres per unit of the file, where its own scale is missing or wrong.
    types
        A table of the user's own, see `vocabulary`.
    assume_doors
        Whether rooms that the file leaves without a way in get a door from the hallway beside them.
    door_width
        Width (m) of doors that the file gives none for.
    split
        Whether rooms that fit badly are cut into several regions.
    """

    level: str | None = None
    scale: float | None = None
    types: Path | None = None
    assume_doors: bool = True
    door_width: float = 0.9
    split: bool = True


class Imported(NamedTuple):
    """A world and how it came about."""

    world: World
    report: ImportReport


def realise(
    drawing: Drawing, words: Vocabulary, options: ImportOptions, file: str = "", format_name: str = ""
) -> Imported:
    """Return the world of a drawing, and the report."""
    drawing.check()
    if options.split:
        split_rooms(drawing)
    spaces, ids = _spaces(drawing, words)
    layout = lay_out(drawing.name, spaces)
    openings, assumed = _openings(drawing, layout, ids, options)
    furniture = _furniture(drawing, layout, words)
    world = close(layout, openings, furniture, drawing.level)
    groups = components([room.id for room in layout.rooms], [o.regions for o in openings])
    rooms = tuple(
        RoomReport(region.id, region.name, room.label, region.type, space.polygon.area, layout.fits[i], layout.iou(i))
        for i, (room, region, space) in enumerate(zip(drawing.rooms, layout.rooms, layout.spaces, strict=True))
    )
    report = ImportReport(
        file=file,
        format=format_name,
        name=drawing.name,
        level=drawing.level,
        levels=tuple(drawing.levels),
        scale=drawing.scale,
        rooms=rooms,
        doors=len(world.doors),
        assumed=assumed,
        passages=len(openings) - len(world.doors),
        furniture=len(furniture),
        components=len(set(groups.values())),
        dropped=tuple(drawing.dropped),
        notes=tuple(drawing.notes),
    )
    return Imported(world, report)


def _spaces(drawing: Drawing, words: Vocabulary) -> tuple[list[Space], dict[str, str]]:
    """Return the rooms with our types and ids ("office 3"), and the id of each key."""
    counts: Counter[str] = Counter()
    ids: dict[str, str] = {}
    spaces = []
    kinds = [words.type_of(room.label, room.name or "") for room in drawing.rooms]
    if set(kinds) == {OTHER}:
        kinds = _guessed(drawing)
    for room, kind in zip(drawing.rooms, kinds, strict=True):
        counts[kind] += 1
        ids[room.key] = f"{kind} {counts[kind]}"
        label = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", room.label).lower()
        name = room.name or f"{label or kind} {counts[kind]}"
        spaces.append(Space(ids[room.key], kind, name, room.polygon))
    return spaces, ids


def _guessed(drawing: Drawing) -> list[str]:
    """Return types where no label means anything: offices, and a hallway where most doors lead to."""
    labels = sorted({room.label for room in drawing.rooms if room.label})[:3]
    drawing.notes.append(
        f"no label says what a room is for ({', '.join(labels) or 'none given'}): the one with most doors is taken for "
        "a hallway, the others for offices; a table of types says better (--types)"
    )
    doors = shapely.MultiPoint([door.middle for door in drawing.doors])
    counts = [len(shapely.get_parts(doors.intersection(room.polygon.buffer(0.4)))) for room in drawing.rooms]
    areas = [room.polygon.area for room in drawing.rooms]
    hallway = max(range(len(counts)), key=lambda i: (counts[i], areas[i]))
    return ["hallway" if i == hallway else "office" for i in range(len(counts))]


def _openings(
    drawing: Drawing, layout: Layout, ids: dict[str, str], options: ImportOptions
) -> tuple[list[Opening], int]:
    """Return the doors and open borders of a level, and how many of the doors were assumed."""
    portals = []
    for door in drawing.doors:
        x, y = door.middle
        rooms = _named(door, drawing, layout, ids) if door.rooms else _beside(door, layout)
        if len(set(rooms)) != 2:
            drawing.drop(f"{door.what} at ({x:.1f}, {y:.1f})", "leads to one room only" if rooms else "is at no room")
            continue
        width = None if door.width is None else float(np.clip(door.width, *DOOR_WIDTHS))
        portals.append(Portal(x, y, (rooms[0], rooms[1]), width, door.direction))
    openings, failed = place(layout, portals, options.door_width)
    for portal in failed:
        first, second = portal.spaces
        drawing.drop(f"door at ({portal.x:.1f}, {portal.y:.1f})", f"no room for it between {first} and {second}")
    walls = shapely.union_all(drawing.walls).buffer(0.05) if drawing.walls else None
    openings += open_borders(layout, _passages(drawing, layout, ids), walls)
    assumed: list[Opening] = []
    if options.assume_doors:
        halls = [room.id for room in layout.rooms if room.type in CIRCULATION]
        missing = missing_doors(layout, openings, halls)
        assumed, _ = place(layout, missing, options.door_width, 1 + sum(o.door for o in openings))
    return openings + assumed, len(assumed)


def _passages(drawing: Drawing, layout: Layout, ids: dict[str, str]) -> list[tuple[str, str]]:
    """Return the pairs of rooms that stand open to each other: named by the file, or both without walls."""
    named = [(ids[a], ids[b]) for a, b in drawing.passages if a in ids and b in ids]
    unwalled = {ids[room.key] for room in drawing.rooms if room.open}
    both = [pair for pair in adjacent(layout) if unwalled.issuperset(pair)] if unwalled else []
    return list(dict.fromkeys([*named, *both]))


def _named(door: DrawnDoor, drawing: Drawing, layout: Layout, ids: dict[str, str]) -> tuple[str, ...]:
    """Return the rooms that a door names, of one that was cut the piece nearest to the door."""
    shapes = {space.id: space.polygon for space in layout.spaces}
    point = shapely.Point(door.middle)
    found = []
    for key in door.rooms:
        pieces = [ids[piece] for piece in drawing.pieces.get(key, (key,)) if piece in ids]
        if pieces:
            found.append(min(pieces, key=lambda name: round(shapes[name].distance(point), 6)))
    return tuple(found)


def _beside(door: DrawnDoor, layout: Layout) -> tuple[str, ...]:
    """Return the rooms on both sides of a door, for one drawn as a point the nearest two."""
    shapes = {space.id: space.polygon for space in layout.spaces}
    x, y = door.middle
    if door.direction is None:
        distances = {name: shape.distance(shapely.Point(x, y)) for name, shape in shapes.items()}
        near = sorted(shapes, key=lambda name: (round(distances[name], 3), name))[:2]
        return tuple(name for name in near if distances[name] <= BESIDE[-1])
    across = np.array([-np.sin(door.direction), np.cos(door.direction)])
    found = []
    for side in (1.0, -1.0):
        for step in BESIDE:
            point = shapely.Point(np.array([x, y]) + side * step * across)
            inside = [name for name, shape in shapes.items() if shape.contains(point)]
            if inside:
                found.append(min(inside, key=lambda name: shapes[name].area))
                break
    return tuple(dict.fromkeys(found))


def _furniture(drawing: Drawing, layout: Layout, words: Vocabulary) -> list[Region]:
    """Return the furniture as regions inside the room that holds most of each."""
    counts: Counter[str] = Counter()
    taken = {room.id for room in layout.rooms}
    found = []
    for item in drawing.furniture:
        shares = {
            i: space.polygon.intersection(item.polygon).area
            for i, space in enumerate(layout.spaces)
            if space.polygon.intersects(item.polygon)
        }
        if not shares or max(shares.values()) < 0.5 * item.polygon.area:
            drawing.drop(f"{item.label} {item.name or ''}".strip(), "stands in no room")
            continue
        room = layout.rooms[max(shares, key=lambda i: shares[i])]
        row, _ = annotate(item.polygon)
        kind = words.type_of(item.label, item.name or "")
        counts[kind] += 1
        region = Region(
            f"{kind} {counts[kind]}", kind, item.name or f"{item.label.lower()} {counts[kind]}", row, room.id
        )
        while region.id in taken:
            counts[kind] += 1
            region = replace(region, id=f"{kind} {counts[kind]}")
        taken.add(region.id)
        found.append(region)
    return found
