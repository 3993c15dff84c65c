"""A building of one storey: corridors, the rooms along them, what stands at their ends, and places to wait."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from regionslam_env.worlds.generate.draft import Box, Draft, Gap, Room, Turn
from regionslam_env.worlds.generate.filling import Cell, RoomQueue, draw, shaped
from regionslam_env.worlds.generate.furniture import furnish
from regionslam_env.worlds.generate.hallways import Hallways, draw_hallways
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.generate.programs import Program, RoomPlan
from regionslam_env.worlds.generate.rooms import Beside, build_segment
from regionslam_env.worlds.generate.skeleton import Corridor, Skeleton, draw_skeleton

SHALLOW = 0.7
"""Share of the small rooms that neighbours reach around, where they can."""

END_ROOMS = 0.4
"""Share of the corridors' ends that have a room."""

ENTRANCE = 16
"""Width of a door that leads outside, dm."""

NICHE = (10, 16)
"""By how much a corridor is wider where people wait, dm."""


@dataclass(frozen=True)
class Building:
    """A drawn building; `entrances` are gaps of one room, not in the draft, that could lead outside: at least one."""

    draft: Draft
    entrances: list[Gap]


@dataclass
class _Band:
    """A segment of a band: which corridor and side, its cells, from x to x."""

    corridor: int
    north: bool
    cells: list[Cell]
    x0: int
    x1: int


def draw_building(program: Program, rooms: int, options: WorldOptions, rng: np.random.Generator) -> Building:
    """Return a building of about so many rooms along its corridors."""
    queue = RoomQueue(program, rooms, options.ambiguity, rng)
    skeleton = draw_skeleton(program, queue.length, 0.5 + 0.5 * options.ambiguity, rng)
    bands = _filled(skeleton, queue, rng)
    draft = Draft()
    hallways = draw_hallways(skeleton, draft, rng)
    for number in range(len(skeleton.corridors)):
        if rng.random() < program.niche:
            _add_niche(number, skeleton, hallways, bands, rng)
    for band in bands:
        _build_band(draft, band, skeleton, hallways, options.clutter, rng)
    often = END_ROOMS if rooms >= 4 else 0.0
    entrances = _build_ends(draft, program, skeleton, hallways, often, options.clutter, rng)
    return Building(draft, entrances)


def _filled(skeleton: Skeleton, queue: RoomQueue, rng: np.random.Generator) -> list[_Band]:
    """Return every segment of every band with its rooms."""
    bands = []
    for number, corridor in enumerate(skeleton.corridors):
        for north, depth in ((False, corridor.south), (True, corridor.north)):
            for x0, x1 in skeleton.segments(number, north):
                cells = shaped(queue.fill(x0, x1, depth), rng, SHALLOW)
                bands.append(_Band(number, north, cells, x0, x1))
    return bands


def _build_band(
    draft: Draft,
    band: _Band,
    skeleton: Skeleton,
    hallways: Hallways,
    clutter: float,
    rng: np.random.Generator,
) -> None:
    corridor = skeleton.corridors[band.corridor]
    gap = band.corridor if band.north else band.corridor - 1
    start = end = None
    for crossing, room in zip(skeleton.crossings, hallways.crossings, strict=True):
        if crossing.below == gap:
            start = room if crossing.x1 == band.x0 else start
            end = room if crossing.x0 == band.x1 else end
    turn = Turn(dy=corridor.y1) if band.north else Turn(flip_y=True, dy=corridor.y0)
    build_segment(draft, band.cells, turn, Beside(hallways.stretches[band.corridor], start, end), clutter, rng)


def _add_niche(
    number: int, skeleton: Skeleton, hallways: Hallways, bands: list[_Band], rng: np.random.Generator
) -> None:
    """Widen a straight hallway in front of one or two rooms, which become less deep."""
    straight = [(low, high, room) for low, high, room in hallways.stretches[number] if len(room.boxes) == 1]
    places = [
        (band, i, j)
        for band in bands
        if band.corridor == number
        for i in range(len(band.cells))
        for j in (i + 1, i + 2)
        if j <= len(band.cells)
        and all(_shallower(cell) for cell in band.cells[i:j])
        and 30 <= band.cells[j - 1].x1 - band.cells[i].x0 <= 90
        and any(low + 15 <= band.cells[i].x0 and band.cells[j - 1].x1 <= high - 15 for low, high, _ in straight)
    ]
    if not places:
        return
    band, i, j = places[int(rng.integers(len(places)))]
    x0, x1, deeper = band.cells[i].x0, band.cells[j - 1].x1, draw(rng, NICHE)
    room = hallways.at(number, x0, x1)
    low, y0, high, y1 = room.boxes[0]
    wider = (x0, y0, x1, y1 + deeper) if band.north else (x0, y0 - deeper, x1, y1)
    room.boxes = [(low, y0, x0, y1), wider, (x1, y0, high, y1)]
    band.cells[i:j] = [replace(cell, front=deeper, standard=None) for cell in band.cells[i:j]]


def _shallower(cell: Cell) -> bool:
    return cell.depth >= 46 and not cell.plan.bath and cell.plan.layout != "flat" and cell.plan.type != "stairs"


def _build_ends(
    draft: Draft,
    program: Program,
    skeleton: Skeleton,
    hallways: Hallways,
    often: float,
    clutter: float,
    rng: np.random.Generator,
) -> list[Gap]:
    """Add rooms at ends of corridors; return where doors could lead outside, one of them at the first corridor."""
    entrances: list[Gap] = []
    for number, corridor in enumerate(skeleton.corridors):
        for x, sign in ((0, -1), (corridor.length, 1)):
            stretch = hallways.stretches[number][0 if sign < 0 else -1][2]
            has_lobby = any(gap.rooms[0].type == "lobby" for gap in entrances)
            plans = [plan for plan in program.ends if not has_lobby or plan.type != "lobby"]
            if (number, sign) == (0, -1):
                plans = [plan for plan in plans if plan.type == "lobby"]
            if plans and rng.random() < often:
                plan = plans[int(rng.integers(len(plans)))]
                room = Room(plan.type, [_end_box(plan, x, sign, corridor, rng)], title=plan.title)
                outer = room.boxes[0][0 if sign < 0 else 2]
                part = Draft([room], [_centred(x, corridor, plan.door, (room, stretch))])
                way_out = _centred(outer, corridor, ENTRANCE, (room, room))
                furnish(part, room, plan.layout, clutter, rng, keep_free=(way_out,))
                draft.add(part)
                if plan.type == "lobby":
                    entrances.append(way_out)
            else:
                entrances.append(_centred(x, corridor, ENTRANCE, (stretch, stretch)))
    return entrances


def _centred(x: int, corridor: Corridor, width: int, rooms: tuple[Room, Room]) -> Gap:
    """Return a door in a wall across a corridor, in the corridor's middle."""
    width = min(width, corridor.y1 - corridor.y0 - 4)
    start = (corridor.y0 + corridor.y1 - width) // 2
    return Gap(1, x, start, start + width, rooms)


def _end_box(plan: RoomPlan, x: int, sign: int, corridor: Corridor, rng: np.random.Generator) -> Box:
    """Return the place of a room across a corridor's end: at least as wide as the corridor, within its bands."""
    across = corridor.y1 - corridor.y0
    wider = max(0, draw(rng, plan.width) - across)
    south = min(draw(rng, (0, wider)), corridor.south - 4)
    north = min(wider - south, corridor.north - 4)
    end = x + sign * draw(rng, (40, 60))
    return min(x, end), corridor.y0 - south, max(x, end), corridor.y1 + north
