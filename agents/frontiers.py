"""Frontiers: where the seen floor ends, at open edges of regions and behind doors never passed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from agents.believed import PASSAGES, BelievedRegion, View
from agents.terrain import UNSEEN, Terrain
from slam.jit import njit
from slam.rows import Floats

CLEARANCE = 0.3
"""Distance (m) from obstacles below which the end of the seen floor is a crack, not a frontier."""
DOORWAY = 8
"""Cells of a frontier that is long enough to hide a door."""
SMALLEST = 3
"""Cells of the smallest frontier."""
MOST = 256
ROOM = 15.0
"""Worth (m) of a frontier that only leads to the rest of a room with an open edge."""


@dataclass(frozen=True, eq=False)
class Frontier:
    """One connected end of the seen floor.

    Attributes
    ----------
    point
        Where to go to look beyond, map frame, m.
    way
        Cost of the way there, m.
    size
        Its length in cells.
    place
        What it is, in words.
    worth
        Price (m) of what probably lies behind it: low where unknown rooms are to be expected.
    leads_on
        Whether unknown rooms may lie behind it, also behind a door in the unseen rest of a room with an open edge.
    """

    point: Floats
    way: float
    size: int
    place: str
    worth: float
    leads_on: bool

    @property
    def price(self) -> float:
        """What it costs to go there, the lower the better."""
        return self.way + self.worth


def find_frontiers(terrain: Terrain, view: View, clearance: float = CLEARANCE) -> list[Frontier]:
    """Return every frontier that can be reached over seen floor, as the believed regions value it.

    The terrain keeps the regions as labels of its cells, so that those evicted from the observation are remembered.
    """
    label_regions(terrain, view)
    reach, clearances = terrain.distances(view.pose[:2])
    cells, sizes = cluster(terrain.scores, clearances, reach, clearance)
    doors = [(np.array(r.row.centre), r) for r in view.regions if r.type == "door"]
    found = []
    for point, (row, column), size in zip(terrain.points(cells), cells, sizes, strict=True):
        if size >= SMALLEST:
            label = _label_around(terrain, row, column)
            place, worth = _appraise(label, _nearest_door(doors, point), view)
            worth += 6.0 if size < 6 else 0.0
            leads_on = worth < ROOM or (label % 2 == 1 and (size >= DOORWAY or _never_entered(label, view)))
            found.append(Frontier(point, float(reach[row, column]), int(size), place, worth, leads_on))
    return found


def label_regions(terrain: Terrain, view: View) -> None:
    """Label the floor with the types of the believed rooms: twice the type's number, one less where an edge is open."""
    for region in view.rooms:
        terrain.paint(region.row, 2 * (view.types.index(region.type) + 1) - bool(region.open_edges))


def _label_around(terrain: Terrain, row: int, column: int) -> int:
    """Return the most frequent label around a cell, 0 where hardly any of it is labelled."""
    around = terrain.labels[max(0, row - 3) : row + 4, max(0, column - 3) : column + 4]
    counts = np.bincount(around.ravel())
    labelled = int(np.sum(counts[1:]))
    return 1 + int(np.argmax(counts[1:])) if labelled * 4 > around.size else 0


def _nearest_door(doors: list[tuple[Floats, BelievedRegion]], point: Floats) -> BelievedRegion | None:
    """Return the door whose middle is within a metre of a point, if any."""
    near = [(math.dist(middle, point), door.slot, door) for middle, door in doors]
    distance, _, door = min(near, default=(np.inf, 0, None))
    return door if distance < 1.0 else None


def _appraise(label: int, door: BelievedRegion | None, view: View) -> tuple[str, float]:
    """Return a frontier's name and the price of what is expected behind it."""
    if label == 0:
        return (f"door {door.slot}" if door is not None else "the unknown"), 0.0
    kind, is_open = view.types[(label + 1) // 2 - 1], label % 2 == 1
    if kind == view.goal:
        return f"the rest of the {kind}", -5.0
    if kind in PASSAGES:
        return f"the end of the {kind}", 0.0
    if door is not None:
        return f"door {door.slot} of the {kind}", 8.0
    return f"the rest of the {kind}", ROOM if is_open else 30.0


def _never_entered(label: int, view: View) -> bool:
    """Return whether a label is that of rooms with an open edge one of which was never entered."""
    kind = view.types[(label + 1) // 2 - 1]
    return any(room.type == kind and room.open_edges and not room.visited for room in view.rooms)


@njit
def cluster(
    scores: NDArray[np.int8], clearances: NDArray[np.float32], reach: NDArray[np.float32], clearance: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return a cell (row, column) of every connected frontier, shape (k, 2), and how many cells it has, shape (k,).

    A frontier's cells are free, reachable (`reach` finite), at least `clearance` (m) from obstacles and border on an
    unseen one. The cell returned is the one nearest to the middle of the frontier.
    """
    rows, columns = scores.shape
    pending = np.zeros((rows, columns), np.bool_)
    for r in range(1, rows - 1):
        for c in range(1, columns - 1):
            if scores[r, c] > 0 or scores[r, c] == UNSEEN or clearances[r, c] < clearance or math.isinf(reach[r, c]):
                continue
            pending[r, c] = (
                scores[r - 1, c] == UNSEEN
                or scores[r + 1, c] == UNSEEN
                or scores[r, c - 1] == UNSEEN
                or scores[r, c + 1] == UNSEEN
            )
    found, sizes = np.zeros((MOST, 2), np.int64), np.zeros(MOST, np.int64)
    queue = np.empty((rows * columns, 2), np.int64)
    count = 0
    for r0 in range(1, rows - 1):
        for c0 in range(1, columns - 1):
            if not pending[r0, c0] or count == MOST:
                continue
            queue[0, 0], queue[0, 1] = r0, c0
            pending[r0, c0] = False
            size, head = 1, 0
            while head < size:
                r, c = queue[head, 0], queue[head, 1]
                head += 1
                for nr in range(r - 1, r + 2):
                    for nc in range(c - 1, c + 2):
                        if pending[nr, nc]:
                            pending[nr, nc] = False
                            queue[size, 0], queue[size, 1] = nr, nc
                            size += 1
            middle_r, middle_c, best = 0.0, 0.0, 0
            for k in range(size):
                middle_r, middle_c = middle_r + queue[k, 0] / size, middle_c + queue[k, 1] / size
            for k in range(size):
                if math.hypot(queue[k, 0] - middle_r, queue[k, 1] - middle_c) < math.hypot(
                    queue[best, 0] - middle_r, queue[best, 1] - middle_c
                ):
                    best = k
            found[count, 0], found[count, 1], sizes[count] = queue[best, 0], queue[best, 1], size
            count += 1
    return found[:count], sizes[:count]
