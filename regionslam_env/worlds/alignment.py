"""Rooms drawn by hand: bring edges that mean the same wall onto one line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slam.rows import Floats, Row

SQUARE = np.radians(0.5)
"""Rows turned by less than this (rad) from the building's axes take part."""

LEAST = 0.5
"""An edge is not moved where a rectangle would keep less than this share of its size."""


@dataclass
class _Group:
    """Edges that shall share one line: their positions, lengths, extents along the line, and owners."""

    low: float
    high: float
    moment: float
    weight: float
    spans: Floats  # (k, 2)
    members: list[tuple[int, int]]  # row, index into its list of lines


def align(rows: Sequence[Row], heading: float, spread: float = 0.3, reach: float = 0.5) -> list[Row]:
    """Return the rows with edges that lie close together moved onto common lines.

    Parameters
    ----------
    rows
        Regions; those not parallel to the building come back unchanged.
    heading
        Direction of the building's axes, rad.
    spread
        Largest distance (m) of edges that are brought together.
    reach
        Edges are brought together only where their extents along the line overlap or come within this distance, m.
    """
    edges = [_lines(row, heading) for row in rows]
    moved: dict[tuple[int, int], float] = {}
    for axis in (0, 1):
        groups = [
            _Group(position, position, position * weight, weight, np.array([span]), [(i, k)])
            for i, lines in enumerate(edges)
            for k, (direction, position, weight, span) in enumerate(lines)
            if direction == axis
        ]
        for group in _merge(groups, spread, reach):
            for member in group.members:
                moved[member] = group.moment / group.weight
    return [_rebuilt(row, heading, [moved.get((i, k)) for k in range(len(edges[i]))]) for i, row in enumerate(rows)]


def _quarters(row: Row, heading: float) -> int | None:
    """Return by how many right angles a row is turned from the building's axes, None where it is not parallel."""
    turns = (row.phi - heading) / (np.pi / 2)
    return round(turns) % 4 if abs(turns - round(turns)) * np.pi / 2 < SQUARE else None


def _lines(row: Row, heading: float) -> list[tuple[int, float, float, tuple[float, float]]]:
    """Return a row's lines u[0..n], then b and t of each rectangle: axis, position, length, extent in the building."""
    quarters = _quarters(row, heading)
    if quarters is None:
        return []
    c, s = np.cos(heading), np.sin(heading)
    to_building = np.array([[c, -s], [s, c]])
    lines = []
    for k in range(row.n + 1):
        touching = [i for i in (k - 1, k) if 0 <= i < row.n]
        ends = [(row.u[k], min(row.b[i] for i in touching)), (row.u[k], max(row.t[i] for i in touching))]
        lines.append(ends)
    for i in range(row.n):
        lines += [[(row.u[i], row.b[i]), (row.u[i + 1], row.b[i])], [(row.u[i], row.t[i]), (row.u[i + 1], row.t[i])]]
    result = []
    for number, ends in enumerate(lines):
        points = row.to_world(ends) @ to_building
        axis = quarters % 2 if number <= row.n else 1 - quarters % 2
        low, high = sorted(points[:, 1 - axis])
        result.append((axis, float(points[:, axis].mean()), float(high - low), (float(low), float(high))))
    return result


def _merge(groups: list[_Group], spread: float, reach: float) -> list[_Group]:
    """Join the nearest two groups as long as some may be joined."""
    groups = sorted(groups, key=lambda g: g.low)
    while True:
        best: tuple[float, int, int] | None = None
        for i, first in enumerate(groups):
            for j in range(i + 1, len(groups)):
                second = groups[j]
                if second.low - first.low > spread:
                    break
                if max(first.high, second.high) - first.low > spread or not _beside(first, second, reach):
                    continue
                distance = abs(first.moment / first.weight - second.moment / second.weight)
                if best is None or distance < best[0] - 1e-12:
                    best = (distance, i, j)
        if best is None:
            return groups
        second, first = groups.pop(best[2]), groups.pop(best[1])
        joined = _Group(
            min(first.low, second.low),
            max(first.high, second.high),
            first.moment + second.moment,
            first.weight + second.weight,
            np.concatenate([first.spans, second.spans]),
            first.members + second.members,
        )
        groups = sorted([*groups, joined], key=lambda g: g.low)


def _beside(first: _Group, second: _Group, reach: float) -> bool:
    low = np.maximum(first.spans[:, None, 0], second.spans[None, :, 0])
    high = np.minimum(first.spans[:, None, 1], second.spans[None, :, 1])
    return bool((high - low > -reach).any())


def _rebuilt(row: Row, heading: float, positions: list[float | None]) -> Row:
    """Return a row with its lines moved to new positions in building axes, or as it was where that would crush it."""
    quarters = _quarters(row, heading)
    if quarters is None:
        return row
    c, s = np.cos(heading), np.sin(heading)
    origin = np.array([c * row.x + s * row.y, -s * row.x + c * row.y])
    axis, sign_u = quarters % 2, 1.0 if quarters in (0, 1) else -1.0
    sign_v = 1.0 if quarters in (0, 3) else -1.0
    old = [*row.u, *(v for i in range(row.n) for v in (row.b[i], row.t[i]))]
    new = []
    for number, (position, before) in enumerate(zip(positions, old, strict=True)):
        if position is None:
            new.append(float(before))
        elif number <= row.n:
            new.append(sign_u * (position - origin[axis]))
        else:
            new.append(sign_v * (position - origin[1 - axis]))
    u, b, t = np.array(new[: row.n + 1]), np.array(new[row.n + 1 :: 2]), np.array(new[row.n + 2 :: 2])
    touching = all(min(t[i], t[i + 1]) > max(b[i], b[i + 1]) for i in range(row.n - 1))
    if (np.diff(u) < LEAST * np.diff(row.u)).any() or (t - b < LEAST * (row.t - row.b)).any() or not touching:
        return row
    square = Row(row.x, row.y, heading + quarters * np.pi / 2, u, b, t, row.main)
    parameters = square.parameters()
    parameters["phi"] = float(np.pi - np.mod(np.pi - parameters["phi"], 2 * np.pi))
    return Row.from_parameters(**parameters)
