"""Corridors cut into hallways: each a row of at most three boxes, joined by fire doors or open passages."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from regionslam_env.worlds.generate.draft import Box, Draft, Gap, Room
from regionslam_env.worlds.generate.filling import draw
from regionslam_env.worlds.generate.skeleton import Crossing, Skeleton

LONGEST = (220, 380)
"""Hallways longer than a number drawn from here are cut in two, dm."""

FIRE_DOORS = 0.6
"""Share of the joints of hallways that have a door."""


@dataclass
class Hallways:
    """The hallways of a building.

    Parameters
    ----------
    stretches
        For each main corridor its hallways in order: from x, to x (dm), room.
    crossings
        The room of each crossing; often that of a main corridor's stretch, which then is an L, a T or a U.
    """

    stretches: list[list[tuple[int, int, Room]]] = field(default_factory=list)
    crossings: list[Room] = field(default_factory=list)

    def at(self, corridor: int, x0: int, x1: int) -> Room:
        """Return the hallway of a main corridor that has all of x0 to x1 (dm)."""
        return next(room for low, high, room in self.stretches[corridor] if low <= x0 and x1 <= high)


def draw_hallways(skeleton: Skeleton, draft: Draft, rng: np.random.Generator) -> Hallways:
    """Add the hallways of a skeleton and the gaps between them to a draft."""
    hallways = Hallways()
    owners = [int(rng.integers(-1, 2)) for _ in skeleton.crossings]  # 0: the corridor below, 1: above, -1: nobody
    own: dict[int, Room] = {}
    for number, corridor in enumerate(skeleton.corridors):
        near = [c for c in skeleton.crossings if c.below in (number, number - 1)]
        mine = [i for i, c in enumerate(skeleton.crossings) if owners[i] >= 0 and c.below + owners[i] == number]
        row = []
        for low, high, members in _stretches(corridor.length, _columns(skeleton, mine), near, rng):
            columns = [(skeleton.crossings[i].x0, skeleton.crossings[i].x1, _climb(skeleton, i)) for i in members]
            room = Room("hallway", _boxes(low, high, corridor.y0, corridor.y1, columns))
            draft.rooms.append(room)
            row.append((low, high, room))
            own.update(dict.fromkeys(members, room))
        hallways.stretches.append(row)
        for (_, cut, one), (_, _, other) in itertools.pairwise(row):
            draft.gaps.append(joint(1, cut, corridor.y0, corridor.y1, (one, other), rng))
    for i, crossing in enumerate(skeleton.crossings):
        low, high = _climb(skeleton, i)
        if i not in own:
            own[i] = Room("hallway", [(crossing.x0, low, crossing.x1, high)], axis=1)
            draft.rooms.append(own[i])
        hallways.crossings.append(own[i])
        for number, at in ((crossing.below, low), (crossing.below + 1, high)):
            main = hallways.at(number, crossing.x0, crossing.x1)
            if main is not own[i]:
                draft.gaps.append(joint(0, at, crossing.x0, crossing.x1, (main, own[i]), rng))
    return hallways


def joint(axis: int, at: int, low: int, high: int, rooms: tuple[Room, Room], rng: np.random.Generator) -> Gap:
    """Return the way from one hallway to the next: a fire door, or nothing between them."""
    if rng.random() >= FIRE_DOORS:
        return Gap(axis, at, low, high, rooms, door=False)
    width = min(high - low - 4, 18)
    middle = (low + high - width) // 2
    return Gap(axis, at, middle, middle + width, rooms)


def _climb(skeleton: Skeleton, crossing: int) -> tuple[int, int]:
    """Return from where to where across the building a crossing goes, dm."""
    below = skeleton.crossings[crossing].below
    return skeleton.corridors[below].y1, skeleton.corridors[below + 1].y0


def _columns(skeleton: Skeleton, members: list[int]) -> list[tuple[int, int, list[int]]]:
    """Return (x0, x1, crossings) of the crossings that may belong to one corridor: those in one line, no two aslant."""
    columns: list[tuple[int, int, list[int]]] = []
    for i in sorted(members, key=lambda i: (skeleton.crossings[i].x0, i)):
        crossing = skeleton.crossings[i]
        if columns and columns[-1][:2] == (crossing.x0, crossing.x1):
            columns[-1][2].append(i)
        elif not columns or crossing.x0 >= columns[-1][1]:
            columns.append((crossing.x0, crossing.x1, [i]))
    return columns


def _stretches(
    length: int, columns: list[tuple[int, int, list[int]]], near: list[Crossing], rng: np.random.Generator
) -> list[tuple[int, int, list[int]]]:
    """Return (from, to, crossings) of a corridor's hallways: with its crossings, each is at most three boxes."""
    longest = draw(rng, LONGEST)
    result: list[tuple[int, int, list[int]]] = []
    start, end, boxes = 0, 0, 0
    members: list[int] = []
    for x0, x1, held in columns:
        if members and (boxes + (x0 > end) + 1 + (x1 < length) > 3 or x1 - start > longest):
            if _blocked(end, near):
                continue
            result.append((start, end, members))
            start, members, boxes = end, [], 0
        boxes += (x0 > end) + 1
        members, end = [*members, *held], x1
    result.append((start, length, members))
    return [part for whole in result for part in _shortened(whole, longest, near)]


def _shortened(
    stretch: tuple[int, int, list[int]], longest: int, near: list[Crossing]
) -> list[tuple[int, int, list[int]]]:
    """Return a stretch cut into shorter ones, where it is longer than allowed and none of its crossings is cut off."""
    low, high, members = stretch
    parts: list[tuple[int, int, list[int]]] = []
    while not members and high - low > longest:
        places = [x for x in range(low + longest // 2, high - 30, 5) if not _blocked(x, near)]
        if not places:
            break
        middle = min(places, key=lambda x: abs(x - low - longest * 3 // 4))
        parts.append((low, middle, []))
        low = middle
    return [*parts, (low, high, members)]


def _blocked(x: int, near: list[Crossing]) -> bool:
    """Return whether a crossing stands so that no joint of two hallways can be there."""
    return any(crossing.x0 < x < crossing.x1 for crossing in near)


def _boxes(low: int, high: int, y0: int, y1: int, columns: list[tuple[int, int, tuple[int, int]]]) -> list[Box]:
    """Return a corridor from low to high and y0 to y1 as boxes in a row, with crossings going up or down from it."""
    merged: dict[tuple[int, int], tuple[int, int]] = {}
    for x0, x1, (bottom, top) in columns:
        b, t = merged.get((x0, x1), (y0, y1))
        merged[x0, x1] = (min(b, bottom), max(t, top))
    boxes, x = [], low
    for (x0, x1), (b, t) in sorted(merged.items()):
        if x0 > x:
            boxes.append((x, y0, x0, y1))
        boxes.append((x0, b, x1, t))
        x = x1
    if high > x:
        boxes.append((x, y0, high, y1))
    return boxes
