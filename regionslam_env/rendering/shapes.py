"""Regions as they are drawn, true ones and those of a `RegionMap`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from regionslam_env.worlds.world import Region, World
from slam.region import EdgeState, RegionFeature
from slam.rows import Floats, Row

CREDIBLE_EXISTENCE = 0.5
"""Regions that exist with less than this probability are not drawn."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One region ready to be drawn.

    Parameters
    ----------
    id
        What `neighbours` and `parent` refer to.
    type, label
        Semantic type (its colour) and text.
    row
        Geometry in the frame of the map or world.
    closed
        For each edge name of Fig. 1 whether that edge has been seen; edges not named are closed.
    certainty
        In [0, 1]; uncertain regions are drawn paler.
    neighbours, parent
        Ids of the regions it is linked to and of the one it lies in.
    """

    id: int | str
    type: str
    label: str
    row: Row
    closed: Mapping[str, bool] = field(default_factory=dict)
    certainty: float = 1.0
    neighbours: tuple[int | str, ...] = ()
    parent: int | str | None = None

    @cached_property
    def rectangles(self) -> Floats:
        """Corners of every rectangle, shape (n, 4, 2), m."""
        return self.row.rectangles()

    @cached_property
    def area(self) -> float:
        """Area, m²."""
        return self.row.area

    @cached_property
    def centre(self) -> tuple[float, float]:
        """Centre of area, m."""
        return self.row.centre

    @cached_property
    def extent(self) -> tuple[float, float, float, float]:
        """Smallest x and y, largest x and y, m."""
        (x0, y0), (x1, y1) = self.rectangles.min(axis=(0, 1)), self.rectangles.max(axis=(0, 1))
        return float(x0), float(y0), float(x1), float(y1)

    @cached_property
    def edges(self) -> tuple[Floats, tuple[bool, ...]]:
        """The outline as segments, shape (k, 2, 2) in m, and for each whether it is closed."""
        row = self.row
        points: list[tuple[float, float]] = []
        closed: list[bool] = []

        def add(u0: float, v0: float, u1: float, v1: float, state: bool) -> None:
            points.extend(((u0, v0), (u1, v1)))
            closed.append(state)

        for i, (top, bottom) in enumerate(_rectangle_names(row)):
            add(row.u[i], row.b[i], row.u[i + 1], row.b[i], self.closed.get(bottom, True))
            add(row.u[i], row.t[i], row.u[i + 1], row.t[i], self.closed.get(top, True))
        left, right = "ll" if row.main > 0 else "l", "rr" if row.main < row.n - 1 else "r"
        add(row.u[0], row.b[0], row.u[0], row.t[0], self.closed.get(left, True))
        add(row.u[-1], row.b[-1], row.u[-1], row.t[-1], self.closed.get(right, True))
        for i in range(1, row.n):
            for side in (row.b, row.t):
                if abs(side[i] - side[i - 1]) > 1e-3:
                    add(row.u[i], side[i - 1], row.u[i], side[i], True)
        return row.to_world(points).reshape(-1, 2, 2), tuple(closed)


def _rectangle_names(row: Row) -> list[tuple[str, str]]:
    """Return the names of the top and bottom edge of each rectangle of a row."""
    by_place = {-1: ("tl", "bl"), 0: ("t", "b"), 1: ("tr", "br")}
    return [by_place[i - row.main] for i in range(row.n)]


def shapes_of_world(world: World) -> list[Shape]:
    """Return the true regions, labelled with their names."""
    return [shape_of(region) for region in world.regions]


def shape_of(region: Region) -> Shape:
    """Return a true region, labelled with its name."""
    return Shape(region.id, region.type, region.name or region.type, region.row, parent=region.parent)


def shapes_of_map(regions: Iterable[RegionFeature]) -> list[Shape]:
    """Return the credible regions of a `RegionMap`, labelled as it names them (those of a plain list: their types)."""
    name = getattr(regions, "name", lambda region: region.type)
    drawn = [r for r in regions if r.credible and _sigmoid(r.existence) >= CREDIBLE_EXISTENCE]
    parents = {child: r.id for r in drawn for child, log_odds in r.children.items() if log_odds > 0}
    shapes = []
    for r in drawn:
        linked = [i for by_edge in r.neighbours.values() for i, log_odds in by_edge.items() if log_odds > 0]
        closed = {name: state is not EdgeState.OPEN for name, state in r.edges.items()}
        certainty = _sigmoid(r.existence) * _sigmoid(r.type_log_odds)
        shapes.append(Shape(r.id, r.type, name(r), r.row, closed, certainty, tuple(linked), parents.get(r.id)))
    return shapes


def main_direction(shapes: Iterable[Shape]) -> float:
    """Return the direction of most walls in (−π/4, π/4], weighted by length: the mean over four-fold symmetry, rad."""
    return float(np.angle(sum((np.exp(4j * s.row.phi) * np.sqrt(s.row.area) for s in shapes), 0j)) / 4)


def _sigmoid(log_odds: float) -> float:
    return float(1 / (1 + np.exp(-log_odds)))
