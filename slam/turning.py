"""Equivalent descriptions of a region in edge form: quarter turns, those of longer rows included.

A row of several rectangles has a quarter turn if it is a row along its other axis as well: its bottoms and tops lie on
at most four lines, and every strip between two of them is one rectangle. Edges on one line are estimated as one: they
are *conditioned* to coincide, if they can within their uncertainty. A line that becomes several edges is copied, and
each copy keeps a small share of uncertainty of its own. `slam.equivalents` says the same of exact rows, by their cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.edge_form import state_size, write_edge_form
from slam.jit import Array, Record, lean, njit
from slam.region import MAX_STATE, b_index, u_index
from slam.rows import MAX_RECTANGLES

COINCIDENT = 4.0**2
"""Squared distance, in variances, up to which two edges can be on one line."""

APART = 0.1**2
"""Share of its variance that each of several edges on one line keeps to itself."""


REVERSED = np.array(
    [
        [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10],
        [0, 2, 1, 4, 3, 5, 6, 7, 8, 9, 10],
        [0, 5, 2, 7, 6, 1, 4, 3, 8, 9, 10],
        [0, 8, 5, 10, 9, 2, 7, 6, 1, 4, 3],
    ],
    np.uint8,
)
"""By number of rectangles: which entry is which of the row read from its other end, where edges change sign."""

ACROSS = np.array([0, 3, 4, 2, 1, 5, 6, 7, 8, 9, 10], np.uint8)
"""Which entry of a rectangle is which after a quarter turn, where v edges change sign."""


def _turns() -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return source and sign of every entry by number of rectangles and quarter turns; odd turns of one rectangle."""
    source = np.tile(np.arange(MAX_STATE, dtype=np.uint8), (MAX_RECTANGLES + 1, 4, 1))
    sign = np.ones(source.shape)
    source[1, 1], sign[1, 1, 3:5] = ACROSS, -1.0
    for n in range(1, MAX_RECTANGLES + 1):
        for quarters in range(2):
            source[n, quarters + 2] = source[n, quarters, REVERSED[n]]
            sign[n, quarters + 2, 1:] = -sign[n, quarters, REVERSED[n, 1:]]
    return source, sign


SOURCE, SIGN = _turns()


@lean
def turn(region: Record, quarters: int, out: Record) -> None:
    """Write the equivalent description that is turned by `quarters` times 90 degrees; ``out.n = 0`` if there is none.

    A half turn reverses the row. The first axis turns with phi: after a quarter turn the new u edges are the old v
    edges, the new v edges minus the old u.
    """
    n, main, quarters = region.n, region.main, quarters % 4
    if quarters % 2 == 1 and n > 1:
        turn_across(region, quarters, out)
        return
    main = n - 1 - main if quarters >= 2 else main
    write(region, region.state, region.cov, n, main, quarters, SOURCE[n, quarters], SIGN[n, quarters], out)


@njit
def turn_across(region: Record, quarters: int, out: Record) -> None:
    """Write a row of several rectangles as one along its other axis, turned by one quarter or by three."""
    source, sign = np.zeros(MAX_STATE, np.uint8), np.ones(MAX_STATE)
    mean, cov = region.state.copy(), region.cov.copy()
    n, main = lay_across(region, mean, cov, source, sign)
    if quarters == 3:
        source, sign, main = source[REVERSED[n]], -sign[REVERSED[n]], n - 1 - main
        sign[0] = 1.0
    write(region, mean, cov, n, main, quarters, source, sign, out)
    for i in range(1, state_size(n)):
        for j in range(1, state_size(n)):
            if i != j and source[i] == source[j]:
                out.cov[i, i] += APART * cov[source[i], source[i]]
                break


@lean
def write(
    region: Record,
    mean: Array,
    cov: Array,
    n: int,
    main: int,
    quarters: int,
    source: Array,
    sign: Array,
    out: Record,
) -> None:
    """Write a description of which entry i is `sign[i]` times entry `source[i]` of mean and covariance."""
    out.id, out.type, out.level = region.id, region.type, region.level
    out.confidence, out.radius = region.confidence, region.radius
    out.n, out.main = n, main
    out.anchor[0], out.anchor[1] = region.anchor[0], region.anchor[1]
    size = state_size(n)
    for i in range(size):
        out.state[i] = sign[i] * mean[source[i]]
        out.closed[i], out.contrary[i] = region.closed[source[i]], region.contrary[source[i]]
        for j in range(size):
            out.cov[i, j] = sign[i] * sign[j] * cov[source[i], source[j]]
    out.state[0] = mean[0] + quarters * np.pi / 2


@njit
def lay_across(region: Record, mean: Array, cov: Array, source: Array, sign: Array) -> Any:
    """Find the row along the other axis; return its number of rectangles (0: there is none) and its main one.

    `source` and `sign` are written for a quarter turn; `mean` and `cov` come as those of the region and are conditioned
    on edges of one line being equal.
    """
    n = region.n
    group, leader = np.zeros(MAX_STATE, np.int64), np.zeros(4, np.int64)
    strips, main, thickest = group_lines(region, group, leader) - 1, 0, 0.0
    if strips < 1:
        return 0, 0
    before, after = 0, -1  # rectangles that share the last strip
    for g in range(strips):
        if g > 0 and not region.closed[leader[g]]:
            return 0, 0  # a joint is a known line
        first, last, count = n, -1, 0
        for i in range(n):
            k = b_index(i)
            if group[k] <= g < group[k + 1]:
                first, last, count = min(first, i), i, count + 1
            if group[k] >= group[k + 1]:
                return 0, 0  # too thin to tell its bottom from its top
        if count == 0 or count != last - first + 1 or (g > 0 and (first > after or last < before)):
            return 0, 0
        before, after = first, last
        i = b_index(g)
        source[u_index(g)], source[u_index(g + 1)] = leader[g], leader[g + 1]
        source[i], source[i + 1] = u_index(last + 1), u_index(first)
        sign[i] = sign[i + 1] = -1.0
        thickness = mean[leader[g + 1]] - mean[leader[g]]
        if first <= region.main <= last and thickness > thickest:
            main, thickest = g, thickness
    for i in range(n):
        for k in range(b_index(i), b_index(i) + 2):
            if k != leader[group[k]] and region.closed[k]:
                make_equal(mean, cov, state_size(n), leader[group[k]], k)
    return strips, 1 if strips == 3 else main


@njit
def group_lines(region: Record, group: Array, leader: Array) -> int:
    """Write the number of the line that each bottom and top lies on into `group`; return how many lines there are.

    Lines ascend, and each goes by one of its edges, `leader` (4,). More than four lines, or edges of both states on one
    line, give 0.
    """
    count = 2 * region.n
    order = np.empty(count, np.int64)
    for i in range(count):
        k = b_index(i // 2) + i % 2
        place = i
        while place > 0 and region.state[order[place - 1]] > region.state[k]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = k
    lines = 0
    for r in range(count):
        k = order[r]
        if r > 0 and can_coincide(region, order[r - 1], k):
            if region.closed[k] != region.closed[leader[lines - 1]]:
                return 0
        elif lines == 4:
            return 0
        else:
            leader[lines] = k
            lines += 1
        group[k] = lines - 1
    if not region.closed[order[count - 1]]:
        leader[lines - 1] = order[count - 1]  # of open edges the outermost holds
    return lines


@lean
def can_coincide(region: Record, i: int, j: int) -> bool:
    """Say whether two edges can be on one line, given their uncertainty.

    A bound lies on no line of the opposite side, and counts as uncertain as the worst known edge at most.
    """
    variance = region.cov[i, i] + region.cov[j, j] - 2 * region.cov[i, j]
    if not (region.closed[i] and region.closed[j]):
        if (i - j) % 3 != 0:
            return False
        known = 0.0
        for k in range(1, state_size(region.n)):
            if region.closed[k]:
                known = max(known, region.cov[k, k])
        variance = min(variance, 2 * known)
    difference = region.state[i] - region.state[j]
    return difference * difference <= COINCIDENT * variance


@njit
def make_equal(mean: Array, cov: Array, size: int, i: int, j: int) -> None:
    """Condition a Gaussian on two of its entries being equal."""
    variance = cov[i, i] + cov[j, j] - 2 * cov[i, j]
    if variance <= 1e-12 * (cov[i, i] + cov[j, j]):
        return
    difference = mean[i] - mean[j]
    gain = np.empty(size)
    for k in range(size):
        gain[k] = (cov[k, i] - cov[k, j]) / variance
    for k in range(size):
        mean[k] -= gain[k] * difference
        for a in range(size):
            cov[k, a] -= gain[k] * gain[a] * variance


@njit
def observe(records: Array, type_numbers: Array, out: Record) -> None:
    """Write every measurement in its equivalent descriptions, `out` (M, 4) of `REGION`: quarter turns in order.

    `type_numbers` translates the scan's types into the filter's.
    """
    jacobian = np.empty((MAX_STATE + 1, MAX_STATE))
    for i in range(len(records)):
        write_edge_form(records[i], out[i, 0], jacobian)
        out[i, 0].type = type_numbers[records[i].type]
        for quarters in range(1, 4):
            turn(out[i, 0], quarters, out[i, quarters])
