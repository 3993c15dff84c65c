"""Exact overlap of two rows of rectangles, for hot loops: closed form, no allocation.

A row is given in edge form: frame (x, y, phi), boundaries ``u``, bottoms ``b`` and tops ``t`` of which the first
``n + 1`` and ``n`` entries count (`slam.rows.Row`; lengths in m, angle in rad).

The overlap of an upright box ``[u0, u1] x [b, t]`` with a polygon is the integral of ``clamp(y, b, t) dx`` along the
polygon's outline between u0 and u1 (Green's theorem). It needs no clipped polygon, and it is exact up to rounding.
"""

from __future__ import annotations

import math

from slam.jit import lean
from slam.rows import Floats, Row


@lean
def rows_overlap(
    ax: float,
    ay: float,
    aphi: float,
    au: Floats,
    ab: Floats,
    at: Floats,
    an: int,
    bx: float,
    by: float,
    bphi: float,
    bu: Floats,
    bb: Floats,
    bt: Floats,
    bn: int,
) -> float:
    """Return the area (m²) that two rows of one frame have in common."""
    a_low, a_high = ab[0], at[0]
    for i in range(1, an):
        a_low, a_high = min(a_low, ab[i]), max(a_high, at[i])
    b_low, b_high = bb[0], bt[0]
    for j in range(1, bn):
        b_low, b_high = min(b_low, bb[j]), max(b_high, bt[j])
    # Circles about the origins of both frames: they need no angle and settle most pairs.
    a_reach = math.sqrt(max(abs(au[0]), abs(au[an])) ** 2 + max(abs(a_low), abs(a_high)) ** 2)
    b_reach = math.sqrt(max(abs(bu[0]), abs(bu[bn])) ** 2 + max(abs(b_low), abs(b_high)) ** 2)
    if (bx - ax) ** 2 + (by - ay) ** 2 >= (a_reach + b_reach) ** 2:
        return 0.0
    c, s = math.cos(aphi), math.sin(aphi)
    dx, dy = c * (bx - ax) + s * (by - ay), c * (by - ay) - s * (bx - ax)
    c, s = math.cos(bphi - aphi), math.sin(bphi - aphi)
    area = 0.0
    for j in range(bn):
        along, across = (bu[j] + bu[j + 1]) / 2, (bb[j] + bt[j]) / 2
        x, y = dx + c * along - s * across, dy + s * along + c * across
        half_w, half_h = (bu[j + 1] - bu[j]) / 2, (bt[j] - bb[j]) / 2
        for i in range(an):
            area += box_overlap(au[i], au[i + 1], ab[i], at[i], x, y, c, s, half_w, half_h)
    return area


@lean
def box_overlap(
    u0: float, u1: float, b: float, t: float, x: float, y: float, c: float, s: float, half_w: float, half_h: float
) -> float:
    """Return the overlap (m²) of the box ``[u0, u1] x [b, t]`` with a rectangle about (x, y) of heading (c, s)."""
    reach_x = abs(c) * half_w + abs(s) * half_h
    reach_y = abs(s) * half_w + abs(c) * half_h
    if x + reach_x <= u0 or x - reach_x >= u1 or y + reach_y <= b or y - reach_y >= t:
        return 0.0
    wx, wy, hx, hy = c * half_w, s * half_w, -s * half_h, c * half_h
    area = _under(x - wx - hx, y - wy - hy, x + wx - hx, y + wy - hy, u0, u1, b, t)
    area += _under(x + wx - hx, y + wy - hy, x + wx + hx, y + wy + hy, u0, u1, b, t)
    area += _under(x + wx + hx, y + wy + hy, x - wx + hx, y - wy + hy, u0, u1, b, t)
    area += _under(x - wx + hx, y - wy + hy, x - wx - hx, y - wy - hy, u0, u1, b, t)
    return max(0.0, -area)  # counter-clockwise corners run forward below and backward above


@lean
def _under(x0: float, y0: float, x1: float, y1: float, u0: float, u1: float, b: float, t: float) -> float:
    """Return the integral of ``clamp(y, b, t) - b`` over dx along a segment, as far as x lies within [u0, u1]."""
    start, end = min(max(x0, u0), u1), min(max(x1, u0), u1)
    if start == end:
        return 0.0
    slope = (y1 - y0) / (x1 - x0)
    low, high = y0 + slope * (start - x0) - b, y0 + slope * (end - x0) - b
    top = t - b
    if low <= 0.0 and high <= 0.0:
        return 0.0
    if low >= top and high >= top:
        return (end - start) * top
    if 0.0 <= low <= top and 0.0 <= high <= top:
        return (end - start) * (low + high) / 2
    # The segment crosses the bottom, the top or both: at these fractions of its length the clamped height bends.
    first, second = -low / (high - low), (top - low) / (high - low)
    if first > second:
        first, second = second, first
    first, second = min(max(first, 0.0), 1.0), min(max(second, 0.0), 1.0)
    at_start, at_end = min(max(low, 0.0), top), min(max(high, 0.0), top)
    at_first = min(max(low + first * (high - low), 0.0), top)
    at_second = min(max(low + second * (high - low), 0.0), top)
    mean = (
        (at_start + at_first) * first + (at_first + at_second) * (second - first) + (at_second + at_end) * (1 - second)
    )
    return (end - start) * mean / 2


@lean
def row_area(u: Floats, b: Floats, t: Floats, n: int) -> float:
    """Return the area (m²) of a row."""
    area = 0.0
    for i in range(n):
        area += (u[i + 1] - u[i]) * (t[i] - b[i])
    return area


@lean
def row_contains(x: float, y: float, phi: float, u: Floats, b: Floats, t: Floats, n: int, px: float, py: float) -> bool:
    """Return whether the point (px, py) lies in one of a row's rectangles."""
    c, s = math.cos(phi), math.sin(phi)
    along, across = c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)
    inside = False
    for i in range(n):
        inside |= u[i] <= along <= u[i + 1] and b[i] <= across <= t[i]
    return inside


def overlap_area(a: Row, b: Row) -> float:
    """Return the area (m²) that two rows of one frame have in common."""
    return float(rows_overlap(a.x, a.y, a.phi, a.u, a.b, a.t, a.n, b.x, b.y, b.phi, b.u, b.b, b.t, b.n))


def iou(a: Row, b: Row) -> float:
    """Return the intersection of two rows over their union, in [0, 1]."""
    common = overlap_area(a, b)
    return common / (a.area + b.area - common)


def covered(a: Row, b: Row) -> float:
    """Return the intersection of two rows over the smaller of them, in [0, 1]: 1 where one lies inside the other."""
    return overlap_area(a, b) / min(a.area, b.area)
