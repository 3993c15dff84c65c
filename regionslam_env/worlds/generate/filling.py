"""Which rooms stand along a stretch of corridor, and how wide they are."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from regionslam_env.worlds.generate.programs import Program, Range, RoomPlan

LOOK_AHEAD = 10
"""How many of the next rooms are tried for the rest of a segment."""

TOO_DEEP = 30
"""A small room that would be deeper than it needs by this much (dm) leaves a niche in the facade or a light shaft."""


def draw(rng: np.random.Generator, limits: Range) -> int:
    """Return a whole number between two limits, both included."""
    return int(rng.integers(limits[0], limits[1] + 1))


@dataclass(frozen=True)
class Standard:
    """The standard room of a plan: width (dm), where along it the door is (share), and the seed of its furniture."""

    width: int
    door: float
    seed: int


Wish = tuple[RoomPlan, int, Standard | None]
"""A room that waits for its place: its plan, the width it would like (dm), and the standard room that it copies."""


@dataclass(frozen=True)
class Cell:
    """A room's place in a band: from x0 to x1 along the corridor, from `front` (dm off the corridor) to `depth`."""

    plan: RoomPlan
    x0: int
    x1: int
    depth: int
    front: int = 0
    standard: Standard | None = None

    @property
    def width(self) -> int:
        """Extent along the corridor, dm."""
        return self.x1 - self.x0


class RoomQueue:
    """The rooms of a building in the order in which they are placed, and the standard one of each plan.

    Parameters
    ----------
    program
        Of the building.
    count
        Number of rooms.
    ambiguity
        Probability that a room is a copy of its plan's standard room.
    rng
        The layout's generator.
    """

    def __init__(self, program: Program, count: int, ambiguity: float, rng: np.random.Generator) -> None:
        self._usual = program.rooms[0]
        self._ambiguity, self._rng = ambiguity, rng
        self._standards: dict[RoomPlan, Standard] = {}
        plans = _mixed(program, count, rng)
        if count < 4:
            plans = [replace(plan, bath=False) for plan in plans]
        self._wished = deque(self._wish(plan) for plan in plans)

    @property
    def length(self) -> int:
        """Length of corridor side that the waiting rooms would like, dm."""
        return sum(width for _, width, _ in self._wished)

    def fill(self, start: int, end: int, depth: int) -> list[Cell]:
        """Return rooms side by side from start to end (dm), taken off the queue; new ones where it runs out."""
        length = end - start
        taken: list[Wish] = []
        while True:
            left = length - sum(_least(*wish) for wish in taken)
            if sum(_most(*wish) for wish in taken) >= length:
                following = self._wished[0][1] if self._wished else length
                if sum(width for _, width, _ in taken) + following / 2 >= length:
                    break
            place = next((i for i, wish in enumerate(self._peek()) if _least(*wish) <= left), None)
            if place is None:
                break
            taken.append(self._take(place))
        if not taken:
            taken = [(self._usual, length, None)]
        cells, x = [], start
        for (plan, _, standard), width in zip(taken, _stretched(taken, length), strict=True):
            same = standard if standard is not None and width == standard.width else None
            cells.append(Cell(plan, x, x + width, depth, standard=same))
            x += width
        return cells

    def _peek(self) -> list[Wish]:
        if not self._wished:
            self._wished.append(self._wish(self._usual))
        return [self._wished[i] for i in range(min(LOOK_AHEAD, len(self._wished)))]

    def _take(self, place: int) -> Wish:
        wish = self._wished[place]
        del self._wished[place]
        return wish

    def _wish(self, plan: RoomPlan) -> Wish:
        if self._rng.random() >= self._ambiguity:
            return plan, draw(self._rng, plan.width), None
        if plan not in self._standards:
            low, high = plan.width
            middle = draw(self._rng, ((3 * low + high) // 4, (low + 3 * high) // 4))
            self._standards[plan] = Standard(middle, float(self._rng.random()), int(self._rng.integers(2**31)))
        return plan, self._standards[plan].width, self._standards[plan]


def _least(plan: RoomPlan, width: int, standard: Standard | None) -> int:
    return width if standard is not None else plan.width[0]


def _most(plan: RoomPlan, width: int, standard: Standard | None) -> int:
    return width if standard is not None else plan.width[1]


def _stretched(wishes: Sequence[Wish], length: int) -> list[int]:
    """Return widths (dm) that fill a length: standard rooms as they are where others can give way."""
    widths = [width for _, width, _ in wishes]
    for limited, who in (
        (True, [i for i, wish in enumerate(wishes) if wish[2] is None]),
        (True, [len(wishes) - 1]),
        (False, list(range(len(wishes)))),
    ):
        slack, before = length - sum(widths), None
        while slack and who and slack != before:
            before = slack
            share = -(-abs(slack) // len(who)) * (1 if slack > 0 else -1)
            for i in who:
                low, high = wishes[i][0].width if limited else (wishes[i][0].width[0], length)
                change = max(-abs(slack), min(abs(slack), share))
                change = min(max(widths[i] + change, low), high) - widths[i]
                if change * slack > 0:
                    widths[i] += change
                    slack -= change
        if not slack:
            return widths
    widths[widths.index(max(widths))] += length - sum(widths)
    return widths


def _mixed(program: Program, count: int, rng: np.random.Generator) -> list[RoomPlan]:
    """Return the rooms of a building: what it needs for its size, service rooms together, the others drawn by share."""
    wanted = [
        plan for plan in program.rooms if plan.every for _ in range(int(count / plan.every + 0.999 * rng.random()))
    ]
    wanted = [wanted[i] for i in rng.permutation(len(wanted))[:count]]
    core = sorted((plan for plan in wanted if plan.depth or plan.type == "stairs"), key=lambda plan: plan.type)
    shares = np.array([plan.share for plan in program.rooms])
    drawn = rng.choice(len(shares), max(0, count - len(wanted)), p=shares / shares.sum())
    rooms = [[plan] for plan in wanted if plan not in core] + [[program.rooms[i]] for i in drawn]
    order = rng.permutation(len(core)) if len(core) > 3 else range(len(core))
    mixed = [core[i] for i in order]
    rooms += [mixed[i : i + 3] for i in range(0, len(mixed), 3)]
    return [plan for i in rng.permutation(len(rooms)) for plan in rooms[i]]


def shaped(cells: list[Cell], rng: np.random.Generator, often: float) -> list[Cell]:
    """Return the cells with some of their own lesser depth, where a neighbour reaches around or they were too deep."""
    result = list(cells)
    for i, cell in enumerate(cells):
        own = cell.plan.depth
        around = [k for k in (i - 1, i + 1) if 0 <= k < len(cells) and _reaches(cells[k])]
        spare = cell.depth - own
        if own and (spare >= TOO_DEEP or (around and spare >= 18 and rng.random() < often)):
            result[i] = replace(cell, depth=own)
    return result


def _reaches(cell: Cell) -> bool:
    return cell.plan.wraps and cell.standard is None
