"""Slow, obvious twins of the simulation's kernels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def cast(pose: Floats, angles: Floats, reach: float, segments: Floats) -> Floats:
    """Intersect every ray with every segment."""
    ranges = np.full(len(angles), reach)
    for i, angle in enumerate(angles):
        direction = np.array([math.cos(pose[2] + angle), math.sin(pose[2] + angle)])
        for x0, y0, x1, y1 in segments:
            start, along = np.array([x0, y0]) - pose[:2], np.array([x1 - x0, y1 - y0])
            cross = direction[0] * along[1] - direction[1] * along[0]
            if cross == 0:
                continue
            distance = (start[0] * along[1] - start[1] * along[0]) / cross
            part = (start[0] * direction[1] - start[1] * direction[0]) / cross
            if distance > 0 and -1e-9 <= part <= 1 + 1e-9:
                ranges[i] = min(ranges[i], distance)
    return ranges


def sight(bounds: tuple[float, float, float, float], rays: Floats, reach: float, tolerance: float) -> Floats:
    """Return how much of each edge (top, bottom, left, right) is seen, and the box around the visible part.

    `rays` are the ends of the rays, shape (n, 2), m, in the rectangle's own axes and relative to the sensor: every beam
    is the pair of a ray and the next one. Only beams that point at an edge count for it.
    """
    left, right, bottom, top = bounds
    seen, points = np.zeros(4), []
    for edge, (axis, line, low, high) in enumerate(
        [(1, top, left, right), (1, bottom, left, right), (0, left, bottom, top), (0, right, bottom, top)]
    ):
        meetings = [_meeting(end, axis, line, reach, tolerance) for end in rays]
        for k, (first, first_place) in enumerate(meetings):
            second, second_place = meetings[(k + 1) % len(rays)]
            if not (first and second and _points_at(rays[k], rays[(k + 1) % len(rays)], axis, line, low, high)):
                continue
            start = max(min(first_place, second_place), low)
            stop = min(max(first_place, second_place), high)
            if stop > start:
                seen[edge] += stop - start
                if first == second == 2:
                    for place in (start, stop):
                        points.append((place, line) if axis else (line, place))
    if left <= 0 <= right and bottom <= 0 <= top:
        points.append((0.0, 0.0))
    points += [tuple(end) for end in rays if left <= end[0] <= right and bottom <= end[1] <= top]
    corners = np.array(points).reshape(-1, 2)
    if not len(corners):
        return np.array([*seen, math.inf, -math.inf, math.inf, -math.inf])
    (u0, v0), (u1, v1) = corners.min(axis=0), corners.max(axis=0)
    return np.array([*seen, u0, u1, v0, v1])


def _meeting(end: Floats, axis: int, line: float, reach: float, tolerance: float) -> tuple[int, float]:
    """Return 2 and where a ray crosses a line, 1 and where it ends at a wall just before the line, or 0."""
    if end[axis] * line <= 0:
        return 0, 0.0
    if abs(end[axis]) >= abs(line):
        return 2, float(line * end[1 - axis] / end[axis])
    if abs(end[axis]) >= abs(line) - tolerance and np.hypot(*end) < reach - 1e-12:
        return 1, float(end[1 - axis])
    return 0, 0.0


def _points_at(first: Floats, second: Floats, axis: int, line: float, low: float, high: float) -> bool:
    """Return whether a beam, if nothing stopped it, would meet the edge."""
    places = sorted(line * end[1 - axis] / end[axis] for end in (first, second))
    return bool(places[1] >= low and places[0] <= high)


def rays_into(bounds: tuple[float, float, float, float], rays: Floats) -> int:
    """Return how many rays enter a rectangle from outside."""
    left, right, bottom, top = bounds
    count = 0
    for end in rays:
        places = np.linspace(0, 1, 2001)[:, None] * end
        inside = (left < places[:, 0]) & (places[:, 0] < right) & (bottom < places[:, 1]) & (places[:, 1] < top)
        count += bool(inside.any())
    return count
