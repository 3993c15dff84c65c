"""The measured part of a row: cut to what is seen, turned into the canonical orientation, written with noise.

A part is held as boundaries relative to the sensor along the row's axes: `u` (4,), `b` (3,), `t` (3,), and the states
of its edges: `states` (8,) holds those of the left and the right end, then bottom and top of each rectangle.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.sensors.sight import BOTTOM, BOX_U, BOX_V, LEFT, RIGHT, TOP
from slam.jit import lean

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DRAWS = 11  # normal numbers of a measurement: x, y, w, h, phi and w, h, y of each subrectangle

_ROUNDING = 1e-9
_SMALLEST = 0.1  # of its size, that noise leaves of a rectangle
_OPEN, _CLOSED, _SUBRECT = 0, 1, 2  # EdgeState


@lean
def visible_run(row: Any, sights: Floats, useful_length: float) -> tuple[int, int]:
    """Return the first rectangle and the number of rectangles of the longest run that is seen usefully.

    A rectangle is, if the box around its visible part is `useful_length` (m) or half its size along both axes. Of
    equally long runs the first counts, unless a later one holds the main rectangle.
    """
    best, longest, length = 0, 0, 0
    for i in range(row.n):
        wide = min(useful_length, (row.u[i + 1] - row.u[i]) / 2) - _ROUNDING
        high = min(useful_length, (row.t[i] - row.b[i]) / 2) - _ROUNDING
        seen_wide = sights[i, BOX_U + 1] - sights[i, BOX_U]
        seen_high = sights[i, BOX_V + 1] - sights[i, BOX_V]
        length = length + 1 if seen_wide >= wide and seen_high >= high else 0
        first = i - length + 1
        if length > longest or (length == longest and length > 0 and first <= row.main <= i):
            best, longest = first, length
    return best, longest


@lean
def cut_row(
    row: Any,
    at_u: float,
    at_v: float,
    first: int,
    count: int,
    sights: Floats,
    closed_length: float,
    u: Floats,
    b: Floats,
    t: Floats,
    states: Ints,
) -> None:
    """Write the part of a row that a sensor at (at_u, at_v) of the row's frame sees: `count` rectangles from `first`.

    An edge is closed, and lies where it is annotated, if `closed_length` (m) or half of it is seen; else it is open and
    lies where the view ends. A boundary towards a rectangle of the row that is not seen is open: the row goes on there.
    """
    for i in range(count):
        k = first + i
        enough = min(closed_length, (row.u[k + 1] - row.u[k]) / 2) - _ROUNDING
        states[2 + 2 * i] = _CLOSED if sights[k, BOTTOM] >= enough else _OPEN
        states[3 + 2 * i] = _CLOSED if sights[k, TOP] >= enough else _OPEN
        b[i] = row.b[k] - at_v if sights[k, BOTTOM] >= enough else sights[k, BOX_V]
        t[i] = row.t[k] - at_v if sights[k, TOP] >= enough else sights[k, BOX_V + 1]
        u[i] = row.u[k] - at_u
    last = first + count - 1
    u[count] = row.u[last + 1] - at_u
    states[0] = states[1] = _CLOSED
    if first > 0 or sights[first, LEFT] < min(closed_length, (row.t[first] - row.b[first]) / 2) - _ROUNDING:
        states[0], u[0] = _OPEN, sights[first, BOX_U]
    if last < row.n - 1 or sights[last, RIGHT] < min(closed_length, (row.t[last] - row.b[last]) / 2) - _ROUNDING:
        states[1], u[count] = _OPEN, sights[last, BOX_U + 1]


@lean
def turn_part(count: int, u: Floats, b: Floats, t: Floats, states: Ints) -> None:
    """Describe a part in axes turned by pi: the last rectangle becomes the first."""
    for i in range(count // 2 + 1):
        j = count - i
        u[i], u[j] = -u[j], -u[i]
    states[0], states[1] = states[1], states[0]
    for i in range((count + 1) // 2):
        j = count - 1 - i
        b[i], t[i], b[j], t[j] = -t[j], -b[j], -t[i], -b[i]
        bottom, top = states[2 + 2 * i], states[3 + 2 * i]
        states[2 + 2 * i], states[3 + 2 * i] = states[3 + 2 * j], states[2 + 2 * j]
        states[2 + 2 * j], states[3 + 2 * j] = top, bottom


@lean
def write_part(
    record: Any,
    count: int,
    main: int,
    u: Floats,
    b: Floats,
    t: Floats,
    states: Ints,
    axis: tuple[float, float],
    told: tuple[float, float, float, float],
    gain: float,
    draws: Floats,
) -> None:
    """Write a part as a measurement in the sensor's frame, with noise.

    Parameters
    ----------
    record
        One of `MEASUREMENT`; type, confidence and phi are not touched.
    count, main
        Number of rectangles and index of the main one.
    u, b, t, states
        The part.
    axis
        Its first axis in the sensor's frame.
    told
        Standard deviations of positions, of sizes, and of phi; the size (m) from which on that of sizes holds.
    gain
        What the simulated standard deviations are over the told ones.
    draws
        Standard normal numbers, shape (DRAWS,).
    """
    sigma_xy, sigma_wh, sigma_phi, full_size = told
    record.n, record.main = count, main
    mid_u, mid_v = (u[main] + u[main + 1]) / 2, (b[main] + t[main]) / 2
    record.x = axis[0] * mid_u - axis[1] * mid_v + gain * sigma_xy * draws[0]
    record.y = axis[1] * mid_u + axis[0] * mid_v + gain * sigma_xy * draws[1]
    record.cov_xy[0, 0] = record.cov_xy[1, 1] = sigma_xy * sigma_xy
    record.cov_xy[0, 1] = record.cov_xy[1, 0] = 0.0
    record.cov_wh[0, 1] = record.cov_wh[1, 0] = 0.0
    record.var_phi = sigma_phi * sigma_phi
    sigma_w = _sigma(u[main + 1] - u[main], sigma_wh, full_size)
    sigma_h = _sigma(t[main] - b[main], sigma_wh, full_size)
    record.w = _noisy_size(u[main + 1] - u[main], gain * sigma_w * draws[2])
    record.h = _noisy_size(t[main] - b[main], gain * sigma_h * draws[3])
    record.cov_wh[0, 0], record.cov_wh[1, 1] = sigma_w * sigma_w, sigma_h * sigma_h
    record.edges[0], record.edges[1] = states[3 + 2 * main], states[2 + 2 * main]
    for side in range(2):
        i = main - 1 + 2 * side
        here = 0 <= i < count
        record.edges[2 + side] = _SUBRECT if here else states[side]
        for k in range(4 + 3 * side, 7 + 3 * side):
            record.edges[k] = 0
        record.sub_w[side] = record.sub_h[side] = record.sub_y[side] = record.sub_var_y[side] = 0.0
        for k in range(4):
            record.sub_cov_wh[side, k // 2, k % 2] = 0.0
        if not here:
            continue
        w, h, k = u[i + 1] - u[i], t[i] - b[i], 5 + 3 * side
        sigma_w, sigma_h = _sigma(w, sigma_wh, full_size), _sigma(h, sigma_wh, full_size)
        record.sub_w[side] = _noisy_size(w, gain * sigma_w * draws[k])
        record.sub_h[side] = _noisy_size(h, gain * sigma_h * draws[k + 1])
        record.sub_y[side] = (b[i] + t[i]) / 2 - mid_v + gain * sigma_xy * draws[k + 2]
        record.sub_cov_wh[side, 0, 0], record.sub_cov_wh[side, 1, 1] = sigma_w * sigma_w, sigma_h * sigma_h
        record.sub_var_y[side] = sigma_xy * sigma_xy
        record.edges[4 + 3 * side], record.edges[5 + 3 * side] = states[3 + 2 * i], states[2 + 2 * i]
        record.edges[6 + 3 * side] = states[side]


@lean
def _sigma(size: float, sigma: float, full_size: float) -> float:
    """Return the told standard deviation of a size: in proportion if small (`MeasurementNoise.variance_of_size`)."""
    return sigma * min(1.0, size / full_size)


@lean
def _noisy_size(size: float, noise: float) -> float:
    """Return a size with noise, never below a fraction of the size."""
    return max(size + noise, _SMALLEST * size)
