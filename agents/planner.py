"""The semantic plan: which believed region to go to, or where to explore while none of the wanted type is known."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from agents.believed import BelievedRegion, View
from agents.frontiers import CLEARANCE, Frontier, find_frontiers
from agents.terrain import UNSEEN, Terrain
from slam.rows import Floats, Row

CREDIBLE = 0.5
"""Probability of type and of existence from which a region is worth going to."""
DEPTH = 0.6
"""How far inside a region to go (m), in small ones this much less than to their middle: `DEPTH_SHARE` of the extent."""
DEPTH_SHARE = 0.35
START = np.zeros(2)
"""Where the map was begun, map frame."""
BEFORE_A_DOOR = 0.6
"""Distance (m) from a shut door at which to wait until it opens."""
LOYALTY = 4.0
"""How much cheaper (m) another frontier has to be to turn away for it."""


@dataclass(frozen=True, eq=False)
class Target:
    """Where to go and why.

    Attributes
    ----------
    point
        Map frame, m.
    kind
        "goal": inside a region of the wanted type; "approach": towards one no way is known into; "explore": a frontier;
        "door": before a shut one.
    place
        In words.
    """

    point: Floats
    kind: Literal["goal", "approach", "explore", "door"]
    place: str


@dataclass
class Planner:
    """Chooses targets on the believed map.

    Parameters
    ----------
    terrain
        The floor seen so far.
    patience
        Decisions for which a target that could not be reached is left alone.
    leads_on
        Whether there is a frontier or a shut door, at the last decision, behind which unknown rooms may lie.
    """

    terrain: Terrain
    patience: int = 40
    _avoided: list[tuple[Floats, float, float]] = field(default_factory=list, repr=False)
    leads_on: bool = True
    _decisions: int = 0

    def reset(self) -> None:
        """Forget what could not be reached."""
        self._avoided.clear()
        self.leads_on, self._decisions = True, 0

    def avoid(self, target: Target, radius: float = 0.8, for_good: bool = False) -> None:
        """Leave a target alone, for a while or for good."""
        until = math.inf if for_good else self._decisions + self.patience
        self._avoided.append((target.point, radius, until))

    def decide(self, view: View, current: Target | None = None) -> Target | None:
        """Return where to go next; None where there is nothing left to try.

        A believed region of the wanted type comes first; then the cheapest frontier, the current one being favoured.
        """
        self._decisions += 1
        if view.returns:
            return Target(START, "goal", "the start")
        self._avoided = [entry for entry in self._avoided if entry[2] > self._decisions]
        goals = [r for r in view.regions if r.goal_p > CREDIBLE and r.existence > CREDIBLE]
        if goals:
            reach, clearance = self.terrain.distances(view.pose[:2])
            target = self._inside(goals, view, reach, clearance)
            if target is not None:
                return target
        frontiers = [f for f in find_frontiers(self.terrain, view) if not self._is_avoided(f.point)]
        if not frontiers:
            frontiers = [f for f in find_frontiers(self.terrain, view, CLEARANCE / 2) if not self._is_avoided(f.point)]
        self.leads_on = any(frontier.leads_on for frontier in frontiers)
        if not self.leads_on and (view.goal is None or not frontiers):
            door = self._shut_door(view)
            if door is not None:
                self.leads_on = True
                return door
        if not frontiers:
            return self._revisit(view)
        if goals:
            return self._towards(goals, frontiers, view)
        best = min(frontiers, key=lambda f: f.price - (LOYALTY if _same(current, f) else 0.0))
        return Target(best.point, "explore", best.place)

    def resolved(self, target: Target, view: View) -> bool:
        """Tell whether a frontier has been reached or seen through: no unseen floor is left around it."""
        if target.kind == "door":
            return False
        if np.hypot(*(target.point - view.pose[:2])) < 0.5:
            return True
        row, column = self.terrain.index(target.point)
        around = self.terrain.scores[max(0, row - 5) : row + 6, max(0, column - 5) : column + 6]
        return not np.any(around == UNSEEN)

    def _shut_door(self, view: View) -> Target | None:
        """Return the place before the nearest door that something closes, where the way ends there."""
        reach, _ = self.terrain.distances(view.pose[:2])
        best: tuple[float, Target] | None = None
        for door in view.regions:
            if door.type != "door" or door.existence < CREDIBLE or not self._is_shut(door):
                continue
            places = np.array(door.row.centre) + BEFORE_A_DOOR * np.array([[1.0], [-1.0]]) * _across(door.row)
            ways = [float(reach[self.terrain.index(place)]) for place in places]
            nearer = int(np.argmin(ways))
            if not math.isfinite(ways[nearer]) or math.isfinite(ways[1 - nearer]) or self._is_avoided(places[nearer]):
                continue
            if best is None or ways[nearer] < best[0]:
                best = ways[nearer], Target(places[nearer], "door", f"door {door.slot}")
        return None if best is None else best[1]

    def _is_shut(self, door: BelievedRegion) -> bool:
        """Tell whether something stands in the middle of a door, as last seen."""
        row, column = self.terrain.index(door.row.centre)
        return bool(np.any(self.terrain.scores[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2] > 0))

    def _is_avoided(self, point: Floats) -> bool:
        return any(np.hypot(*(point - centre)) < radius for centre, radius, _ in self._avoided)

    def _inside(
        self,
        goals: list[BelievedRegion],
        view: View,
        reach: NDArray[np.float32],
        clearance: NDArray[np.float32],
    ) -> Target | None:
        """Return the spot well inside one of the regions that is the cheapest to get to."""
        best: tuple[float, Target] | None = None
        for region in goals:
            cells = self._cells(region)
            points = self.terrain.points(cells)
            depth, way = region.depth(points), reach[cells[:, 0], cells[:, 1]].astype(np.float64)
            wanted = min(DEPTH, DEPTH_SHARE * region.extent)
            price = way + 10 * np.maximum(0, wanted - depth)
            price += 5 * np.maximum(0, 0.4 - clearance[cells[:, 0], cells[:, 1]])
            price += 10 * (1 - region.goal_p * region.existence)
            price[depth <= 0.05] = np.inf
            for centre, radius, _ in self._avoided:
                price[np.hypot(*(points - centre).T) < radius] = np.inf
            if len(price) and np.isfinite(price.min()) and (best is None or price.min() < best[0]):
                k = int(np.argmin(price))
                best = float(price[k]), Target(points[k], "goal", f"the {region.type}")
        return None if best is None else best[1]

    def _cells(self, region: BelievedRegion) -> NDArray[np.int64]:
        """Return the cells (row, column) in the bounding box of a region, shape (k, 2)."""
        outline = region.row.outline()
        (r0, c0), (r1, c1) = self.terrain.index(outline.min(axis=0)), self.terrain.index(outline.max(axis=0))
        rows, columns = np.meshgrid(np.arange(r0, r1 + 1), np.arange(c0, c1 + 1), indexing="ij")
        return np.stack([rows.ravel(), columns.ravel()], axis=1)

    def _towards(self, goals: list[BelievedRegion], frontiers: list[Frontier], view: View) -> Target:
        """Return the frontier from which one of the regions is the most likely to be entered."""

        def price(frontier: Frontier) -> float:
            return frontier.way + 2 * min(float(np.hypot(*(np.array(g.row.centre) - frontier.point))) for g in goals)

        best = min(frontiers, key=price)
        return Target(best.point, "approach", f"the {view.goal}")

    def _revisit(self, view: View) -> Target | None:
        """Return the middle of the nearest believed region that was never entered, once no frontier is left."""
        here = view.pose[:2]
        rooms = [(np.array(r.row.centre), r.type) for r in view.regions if not r.visited and r.type != "door"]
        rooms = [(centre, kind) for centre, kind in rooms if not self._is_avoided(centre)]
        if not rooms:
            self._avoided.clear()
            return None
        centre, kind = min(rooms, key=lambda room: float(np.hypot(*(room[0] - here))))
        return Target(centre, "explore", f"the {kind}")


def _across(row: Row) -> Floats:
    """Return the unit vector along the shorter side of a row: through a door."""
    turn = row.phi if row.u[-1] - row.u[0] < row.t.max() - row.b.min() else row.phi + math.pi / 2
    return np.array([math.cos(turn), math.sin(turn)])


def _same(current: Target | None, frontier: Frontier) -> bool:
    """Tell whether a frontier is what the current target has become."""
    return current is not None and current.kind == "explore" and bool(np.hypot(*(current.point - frontier.point)) < 2.0)
