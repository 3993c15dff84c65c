"""Spatial relations of regions and points in words' sense, each with a stated meaning.

Points are (x, y) in the map frame, m. Only edges that were seen (closed) count: where a view ended is nothing to be
next to.
"""

from __future__ import annotations

import math

from slam.edges import Edge, Point, distance_to, edges_of
from slam.region import EdgeState, RegionFeature
from slam.rows import Row

NEXT_TO = 1.5
"""Regions whose closed edges face each other across at most this gap are next to each other, m."""

IN_FRONT_OF = 2.0
"""How far the place in front of a door or a piece of furniture reaches, m."""

END = 2.0
"""How far the end of a hallway reaches, m."""

ELONGATED = 1.5
"""A rectangle has ends if it is this many times as long as wide."""

STANDING_ROOM = 0.6
"""Furniture is approached from sides with this much free floor, m."""

WALL = 0.3
"""Edges that face each other may overlap this much: maps are noisy, m."""


def linked(a: RegionFeature, b: RegionFeature) -> bool:
    """Return whether a passage between two regions is more likely than not, in the belief of either of them."""
    return link_log_odds(a, b) > 0


def link_log_odds(a: RegionFeature, b: RegionFeature) -> float:
    """Return the log-odds of a passage between two regions: the surer of both directions, -inf if never considered."""
    beliefs = [edge[b.id] for edge in a.neighbours.values() if b.id in edge]
    beliefs += [edge[a.id] for edge in b.neighbours.values() if a.id in edge]
    return max(beliefs, default=-math.inf)


def next_to(a: RegionFeature, b: RegionFeature) -> bool:
    """Return whether two regions are linked, or on one level closed edges face each other within `NEXT_TO`."""
    if a.id == b.id:
        return False
    if linked(a, b):
        return True
    if a.level != b.level:
        return False
    closed_a, closed_b = (_closed(edges_of(region)) for region in (a, b))
    return any(_facing(one, other) for one in closed_a for other in closed_b)


def in_front_of(point: Point, target: RegionFeature, room: RegionFeature | None = None) -> bool:
    """Return whether a point lies in front of a door or a piece of furniture.

    In front means outside of it, within `IN_FRONT_OF` of a side from which it is approached, and not farther to the
    side of that edge than away from it.

    Parameters
    ----------
    point
        The place in question.
    target
        A door is approached across its long edges.
    room
        The region that contains the furniture, if it is furniture: the point must be inside as well, and only sides
        with free floor before them count, long ones first.
    """
    if room is not None and distance_to(room.row, point) > 0:
        return False
    return any(
        edge.height(point) > 0 and edge.distance(point) <= IN_FRONT_OF and edge.beside(point) <= edge.height(point)
        for edge in approach_edges(target, room)
    )


def approach_edges(target: RegionFeature, room: RegionFeature | None = None) -> tuple[Edge, ...]:
    """Return the edges from which a door, or furniture inside `room`, is approached."""
    edges = [edge for edge in edges_of(target) if edge.state != EdgeState.SUBRECT]
    longest = max(edge.length for edge in edges)
    long = [edge for edge in edges if edge.length > 0.9 * longest]
    if room is None:
        return tuple(long)
    for candidates in (long, edges):
        free = [edge for edge in candidates if distance_to(room.row, _before(edge)) == 0]
        if free:
            return tuple(free)
    return tuple(long)


def in_the_middle_of(point: Point, region: RegionFeature) -> bool:
    """Return whether a point is inside a region and farther from every closed edge than a third of its smaller extent.

    The smaller extent is that of the rectangle around the point, whose length along the row is the whole row's.
    """
    row = region.row
    along, across = row.to_local([point])[0]
    rectangles = zip(row.u[:-1], row.u[1:], row.b, row.t, strict=True)
    heights = [t - b for u0, u1, b, t in rectangles if u0 <= along <= u1 and b <= across <= t]
    if not heights:
        return False
    margin = min(float(max(heights)), float(row.u[-1] - row.u[0])) / 3
    return all(edge.distance(point) > margin for edge in _closed(edges_of(region)))


def at_the_end_of(place: RegionFeature | Point, hallway: RegionFeature) -> bool:
    """Return whether a region or a point is at the end of a hallway.

    A region is if it is linked to a short end edge or, on the same level, within `END` of one; a point is inside the
    hallway within `END` of one.
    """
    ends = end_edges(hallway)
    if isinstance(place, RegionFeature):
        if place.id == hallway.id:
            return False
        if any(hallway.neighbours.get(edge.name, {}).get(place.id, -math.inf) > 0 for edge in ends):
            return True
        return place.level == hallway.level and any(_gap(edge, place) <= END for edge in ends)
    return distance_to(hallway.row, place) == 0 and any(edge.distance(place) <= END for edge in ends)


def end_edges(region: RegionFeature) -> tuple[Edge, ...]:
    """Return the closed short edges of elongated rectangles; the corner of an L or the bar of a T is no end."""
    row = region.row
    ends = []
    for edge in _closed(edges_of(region)):
        i = row.main + {"": 0, "l": -1, "r": 1}[edge.name[1:]]
        width, height = float(row.u[i + 1] - row.u[i]), float(row.t[i] - row.b[i])
        if edge.name[0] in "lr":
            leg = any(_sticks_out(row, i, side, width) for side in "tb") if row.n > 1 else False
            is_end = not leg and float(row.u[-1] - row.u[0]) >= ELONGATED * height
        else:
            is_end = height >= ELONGATED * width and _sticks_out(row, i, edge.name[0], width)
        if is_end:
            ends.append(edge)
    return tuple(ends)


def _sticks_out(row: Row, i: int, side: str, enough: float) -> bool:
    """Return whether the top or bottom of rectangle i lies at least `enough` beyond that of those beside it."""
    beside = [j for j in (i - 1, i + 1) if 0 <= j < row.n]
    if side == "t":
        return all(float(row.t[i] - row.t[j]) >= enough for j in beside)
    return all(float(row.b[j] - row.b[i]) >= enough for j in beside)


def _closed(edges: tuple[Edge, ...]) -> list[Edge]:
    return [edge for edge in edges if edge.state == EdgeState.CLOSED]


def _facing(one: Edge, other: Edge) -> bool:
    """Return whether two edges look at each other, side by side, across at most `NEXT_TO`."""
    if one.normal[0] * other.normal[0] + one.normal[1] * other.normal[1] > -math.cos(math.radians(30)):
        return False
    if not -WALL <= one.height(other.middle) <= NEXT_TO:
        return False
    first, last = sorted((one.along(other.start), one.along(other.end)))
    return first < one.length and last > 0


def _gap(edge: Edge, region: RegionFeature) -> float:
    """Return the distance between an edge and the nearest corner or edge of a region outside of it, m."""
    if distance_to(region.row, edge.middle) == 0:
        return 0.0
    corners = [(float(x), float(y)) for x, y in region.row.rectangles().reshape(-1, 2)]
    ends = [distance_to(region.row, point) for point in (edge.start, edge.middle, edge.end)]
    return min(*(edge.distance(corner) for corner in corners), *ends)


def _before(edge: Edge) -> Point:
    x, y = edge.middle
    return x + STANDING_ROOM * edge.normal[0], y + STANDING_ROOM * edge.normal[1]
