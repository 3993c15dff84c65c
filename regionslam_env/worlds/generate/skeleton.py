"""The corridors of a building: parallel main corridors with a band of rooms on either side, and crossings between them.

Main corridors run along x. Two crossings between the same two corridors close a loop; one makes a branch.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from regionslam_env.worlds.generate.filling import draw
from regionslam_env.worlds.generate.programs import Program

SHORTEST = 52
"""Shortest stretch of band between two crossings, or beside one, dm."""

BETWEEN = (160, 320)
"""Usual distance of crossings in large buildings, dm."""


@dataclass
class Crossing:
    """A corridor from x0 to x1 that joins main corridor `below` with the next one."""

    below: int
    x0: int
    x1: int


@dataclass
class Corridor:
    """A main corridor with its bands: y0 to y1 across, from x = 0 to `length`; band depths south and north, dm."""

    y0: int
    y1: int
    length: int
    south: int
    north: int


@dataclass
class Skeleton:
    """All corridors; crossings in order of their place."""

    corridors: list[Corridor]
    crossings: list[Crossing] = field(default_factory=list)

    def segments(self, number: int, north: bool) -> list[tuple[int, int]]:
        """Return the stretches (dm) of a corridor's band that no crossing cuts."""
        cuts = [(c.x0, c.x1) for c in self.crossings if c.below == (number if north else number - 1)]
        free, x = [], 0
        for x0, x1 in sorted(cuts):
            free.append((x, x0))
            x = x1
        free.append((x, self.corridors[number].length))
        return [(low, high) for low, high in free if high > low]


def draw_skeleton(program: Program, wished: int, regular: float, rng: np.random.Generator) -> Skeleton:
    """Return corridors whose bands offer about a wished length.

    Parameters
    ----------
    program
        Of the building.
    wished
        Length of corridor side for all rooms, dm.
    regular
        Probability that bands have the building's usual depth.
    rng
        The layout's generator.
    """
    width, depth = draw(rng, program.corridor), draw(rng, program.band)
    count = _number_of_corridors(wished, width, depth, rng)
    length = wished // (2 * count)
    length += (count - 1) * max(2, round(length / sum(BETWEEN) * 2)) * width // count  # what crossings take up
    places = [_places(length, width, rng) for _ in range(count - 1)]
    y, corridors = 0, []
    for number in range(count):
        south, north = (depth if rng.random() < regular else draw(rng, program.band) for _ in range(2))
        if number and length > 150 and rng.random() < program.courtyards:
            y += draw(rng, program.courtyard)
        corridors.append(Corridor(y + south, y + south + width, max(length, 40), south, north))
        y += south + width + north
    crossings = [Crossing(below, x0, x1) for below, gap in enumerate(places) for x0, x1 in gap]
    _vary_ends(corridors, crossings, rng)
    return Skeleton(corridors, crossings)


def _number_of_corridors(wished: int, width: int, depth: int, rng: np.random.Generator) -> int:
    """Return how many corridors give a building neither a needle nor a square block, and crossings that fit."""
    across = width + 2 * depth
    fitting = []
    for count in range(1, 80):
        length = wished / (2 * count)
        if count > 1 and length < 2 * width + SHORTEST:
            break
        if 0.4 <= length / (count * across) <= 4.2:
            fitting.append(count)
    if not fitting:
        return 1
    weights = np.array([0.4 if count == 1 else 1.0 for count in fitting])
    return int(rng.choice(fitting, p=weights / weights.sum()))


def _places(length: int, width: int, rng: np.random.Generator) -> list[tuple[int, int]]:
    """Return where crossings stand along corridors of a length, dm."""
    loop = length >= 2 * width + SHORTEST and rng.random() < 0.85
    count = max(2, round(length / draw(rng, BETWEEN))) if loop else 1
    slots = np.linspace(0, length - width, count) if count > 1 else [rng.choice([0, (length - width) / 2])]
    inset = rng.random() < 0.5
    places: list[tuple[int, int]] = []
    for i, slot in enumerate(slots):
        x = int(slot)
        if 0 < i < len(slots) - 1 or count == 1:
            x += draw(rng, (-20, 20))
        elif inset and length > 2 * (SHORTEST + width) + SHORTEST:
            x += draw(rng, (SHORTEST, SHORTEST + 20)) * (1 if i == 0 else -1)
        x = min(max(x, 0), length - width)
        x = 0 if x < SHORTEST else x
        x = length - width if length - width - x < SHORTEST else x
        if not places or x >= places[-1][1] + SHORTEST:
            places.append((x, x + width))
    return places


def _vary_ends(corridors: list[Corridor], crossings: list[Crossing], rng: np.random.Generator) -> None:
    """Make some corridors a little shorter, others longer by as much, where no crossing stands at their end."""
    for one, other in zip(range(0, len(corridors) - 1, 2), range(1, len(corridors), 2), strict=False):
        reach = [
            max((c.x1 for c in crossings if c.below in (number, number - 1)), default=0) for number in (one, other)
        ]
        change = draw(rng, (-60, 60))
        if all(
            corridors[k].length + sign * change >= reached + SHORTEST
            for k, sign, reached in ((one, 1, reach[0]), (other, -1, reach[1]))
        ):
            corridors[one].length += change
            corridors[other].length -= change
