"""Edges of a mapped region as lines in the map: where a wall is known, where the view ended, where rectangles join."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slam.region import EdgeState, RegionFeature
from slam.rows import Row

Point = tuple[float, float]


@dataclass(frozen=True)
class Edge:
    """One edge of a region, in the frame of the region.

    Attributes
    ----------
    name
        One of `EDGE_NAMES`.
    state
        OPEN, CLOSED or SUBRECT (a joint).
    start, end
        End points, m, counter-clockwise about the region.
    normal
        Unit vector pointing outwards.
    """

    name: str
    state: EdgeState
    start: Point
    end: Point
    normal: Point

    @property
    def length(self) -> float:
        """Length, m."""
        return math.dist(self.start, self.end)

    @property
    def middle(self) -> Point:
        """Midpoint, m."""
        return (self.start[0] + self.end[0]) / 2, (self.start[1] + self.end[1]) / 2

    def height(self, point: Point) -> float:
        """Return how far a point lies outside the edge's line, m (negative: inside)."""
        return self.normal[0] * (point[0] - self.start[0]) + self.normal[1] * (point[1] - self.start[1])

    def along(self, point: Point) -> float:
        """Return the place of a point along the edge's line, m from its start."""
        # The outward normal is the direction from start to end, turned clockwise by a right angle.
        return -self.normal[1] * (point[0] - self.start[0]) + self.normal[0] * (point[1] - self.start[1])

    def beside(self, point: Point) -> float:
        """Return how far a point lies beyond the ends of the edge, measured along its line, m (0: level with it)."""
        along = self.along(point)
        return max(0.0, -along, along - self.length)

    def distance(self, point: Point) -> float:
        """Return the distance of a point from the edge, m."""
        return math.hypot(self.height(point), self.beside(point))


def edges_of(feature: RegionFeature) -> tuple[Edge, ...]:
    """Return all edges of a region, in the order of `EDGE_NAMES`; a joint appears as edge of the main rectangle."""
    return row_edges(feature.row, feature.edges)


def row_edges(row: Row, states: dict[str, EdgeState]) -> tuple[Edge, ...]:
    """Return the edges of a row for which a state is given, in the order of `states`."""
    c, s = math.cos(row.phi), math.sin(row.phi)
    along, across = (c, s), (-s, c)
    outward = {"t": across, "b": (s, -c), "l": (-c, -s), "r": along}

    def edge(name: str, state: EdgeState) -> Edge:
        side = name[0]
        # "tl" is the top of the left subrectangle, "ll" its end; "l" alone belongs to the main rectangle.
        i = row.main + {"": 0, "l": -1, "r": 1}[name[1:]]
        u0, u1, b, t = (float(values) for values in (row.u[i], row.u[i + 1], row.b[i], row.t[i]))
        ends = {"t": ((u1, t), (u0, t)), "b": ((u0, b), (u1, b)), "l": ((u0, t), (u0, b)), "r": ((u1, b), (u1, t))}
        start, end = ((row.x + c * u - s * v, row.y + s * u + c * v) for u, v in ends[side])
        return Edge(name, state, start, end, outward[side])

    return tuple(edge(name, state) for name, state in states.items())


def distance_to(row: Row, point: Point) -> float:
    """Return the distance of a point from a row, m; 0 inside."""
    c, s = math.cos(row.phi), math.sin(row.phi)
    dx, dy = point[0] - row.x, point[1] - row.y
    along, across = c * dx + s * dy, c * dy - s * dx
    return min(
        math.hypot(max(row.u[i] - along, 0.0, along - row.u[i + 1]), max(row.b[i] - across, 0.0, across - row.t[i]))
        for i in range(row.n)
    )
