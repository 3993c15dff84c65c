"""The way from region to region along the links of a map."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray


def route(
    starts: Iterable[int], target: int, centres: NDArray[np.floating], links: Sequence[tuple[int, int]]
) -> list[int]:
    """Return the regions on the shortest way to a region, itself the last, without the one the way starts in.

    A link is as long as the centres of its regions are apart (Dijkstra). Where no links lead there, the way is the
    target alone.

    Parameters
    ----------
    starts
        Regions that the robot is in.
    target
        Where to.
    centres
        Of all regions, shape (n, 2), m; the robot is at the origin.
    links
        Pairs of regions, to be passed both ways.
    """
    neighbours: dict[int, list[int]] = {}
    for a, b in links:
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    before: dict[int, int] = {}
    queue = [(0.0, start, -1) for start in starts]
    heapq.heapify(queue)
    while queue:
        length, region, previous = heapq.heappop(queue)
        if region in before:
            continue
        before[region] = previous
        if region == target:
            break
        for other in neighbours.get(region, ()):
            here = np.zeros(2) if previous < 0 else centres[region]
            heapq.heappush(queue, (length + float(np.hypot(*(centres[other] - here))), other, region))
    way = [target]
    while before.get(way[-1], -1) >= 0:
        way.append(before[way[-1]])
    return way[-2::-1] if len(way) > 1 else way
