"""Geometric update on the paper's own parameters (Oberländer et al. 2008, section II-C.1).

1. Open edges of m are pushed out to z, eqs. (1) and (2); subrectangles that only z has are added.
2. Open edges of z are pushed out to m in the same manner. Where the parameter of m is complete, they are put exactly on
   m's edges instead (Fig. 4), so that all that z says are the length differences of edges closed in both.
3. Complete and partially available parameters of z update those of m by a Kalman filter, eqs. (3)-(6), in independent
   blocks: phi; (x, y); (w, h); (w_l, h_l); y_l; (w_r, h_r); y_r.

The paper moves an expanded parameter without touching its covariance, and so ends far too confident; here it is raised
to at least the measurement's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.edge_form import bounding_radius, to_edge_form
from slam.expansion import add_rectangles, close_edges, expand, place
from slam.growth import LEAST_SIZE, keep_order, take_row
from slam.innovation import wrap
from slam.jit import Array, Record, njit
from slam.parameters import to_parameters
from slam.region import MAX_STATE, b_index


@njit
def fuse_parameters(z: Record, m: Record, offset: int, pose: Array, work: Record) -> None:
    """Update region m with row z, seen from a certain pose with rectangle j of z being rectangle j + offset of m.

    Where the middle rectangle of the union is one that only z has, it has no estimate to be updated: then z becomes the
    region, and m updates it.
    """
    seen, other = work.regions[0], work.regions[1]
    take_row(z, seen)
    seen.anchor[0], seen.anchor[1] = pose[0], pose[1]
    seen.state[0] = z.state[0] + pose[2]
    if max(m.n, z.n + offset) - min(offset, 0) == 3 and not 0 <= 1 + min(offset, 0) < m.n:
        take_row(m, other)
        x, y = m.anchor[0], m.anchor[1]
        take_row(seen, m)
        to_parameters(m, work.figures[0])
        write(work.figures[0], x, y, m, LEAST_SIZE * work.tolerance)
        combine(other, m, -offset, work)
    else:
        combine(seen, m, offset, work)


@njit
def combine(z: Record, m: Record, offset: int, work: Record) -> None:
    """Update region m with region z, both in the map frame; z is changed too."""
    pushed = np.zeros(MAX_STATE, np.bool_)  # by place in z: edges of m that z pushes out
    seen = z.closed.copy()
    _expand(m, z, -offset, False, pushed, work)
    _expand(z, m, offset, True, np.zeros(MAX_STATE, np.bool_), work)
    common = min(m.n, z.n + offset) - max(0, offset)
    first = max(0, -offset)  # common rectangles, as z counts them
    close_edges(z, m, offset)
    offset = add_rectangles(z, m, offset)
    z.main = min(max(m.main - offset, 0), z.n - 1)
    ours, theirs = work.figures[0], work.figures[1]
    to_parameters(m, ours)
    to_parameters(z, theirs)
    for i in range(z.n):
        known = first <= i < first + common
        update_rectangle(ours, theirs, i + offset - m.main, i, known, seen, pushed)
    gain = ours.var_phi / (ours.var_phi + theirs.var_phi)  # (4)
    ours.phi = wrap(ours.phi + gain * wrap(theirs.phi - ours.phi))  # (5)
    ours.var_phi *= 1.0 - gain  # (6)
    write(ours, m.anchor[0], m.anchor[1], m, LEAST_SIZE * work.tolerance)


@njit
def _expand(a: Record, b: Record, offset: int, exact: bool, pushed: Array, work: Record) -> None:
    """Expand a region by moving its parameters alone: their covariances stay."""
    before, after = work.figures[0], work.figures[1]
    to_parameters(a, before)
    expand(a, b, offset, exact, pushed)
    to_parameters(a, after)
    after.cov_xy[:, :], after.cov_wh[:, :] = before.cov_xy, before.cov_wh
    after.sub_cov_wh[:, :, :], after.sub_var_y[:] = before.sub_cov_wh, before.sub_var_y
    write(after, a.anchor[0], a.anchor[1], a, LEAST_SIZE * work.tolerance)


@njit
def update_rectangle(ours: Record, theirs: Record, at: int, i: int, known: bool, seen: Array, pushed: Array) -> None:
    """Update the parameters of one rectangle of m, or take those of a new subrectangle over.

    `at`: -1 left, 0 main, 1 right of m; `i`: which one of z; `seen`, `pushed`: by place in z, edges that z measured and
    edges of m that it pushed out.
    """
    available, moved = np.zeros(2, np.bool_), np.zeros(2, np.bool_)
    for axis in range(2):
        low, high = place(i, axis, 0), place(i, axis, 1)
        available[axis], moved[axis] = seen[low] or seen[high], pushed[low] or pushed[high]
    if at == 0:
        _update_midpoint(ours, theirs, available, moved)
        mean, measured = np.array([ours.w, ours.h]), np.array([theirs.w, theirs.h])
        update_block(mean, ours.cov_wh, measured, theirs.cov_wh, available, moved)
        ours.w, ours.h = mean[0], mean[1]
        return
    side = (at + 1) // 2
    noise = np.empty((2, 2))
    w, h, y, var_y = subrectangle_of(theirs, ours, i, side, noise)
    if not known:
        ours.sub_w[side], ours.sub_h[side], ours.sub_y[side], ours.sub_var_y[side] = w, h, y, var_y
        ours.sub_cov_wh[side, :, :] = noise
        return
    mean = np.array([ours.sub_w[side], ours.sub_h[side]])
    update_block(mean, ours.sub_cov_wh[side], np.array([w, h]), noise, available, moved)
    ours.sub_w[side], ours.sub_h[side] = mean[0], mean[1]
    has_main = theirs.main != i
    main = b_index(theirs.main)
    if moved[1] or (has_main and (pushed[main] or pushed[main + 1])):
        ours.sub_var_y[side] = max(ours.sub_var_y[side], var_y)
    if available[1] and (not has_main or seen[main] or seen[main + 1]):
        gain = ours.sub_var_y[side] / (ours.sub_var_y[side] + var_y)  # (4)
        ours.sub_y[side] += gain * (y - ours.sub_y[side])  # (5)
        ours.sub_var_y[side] *= 1.0 - gain  # (6)


@njit
def subrectangle_of(theirs: Record, ours: Record, i: int, side: int, noise: Array) -> Any:
    """Return (w, h, y) and the variance of y that z tells of a subrectangle; `noise`: covariance of (w, h), written.

    Without the main rectangle in view, y is the distance of the subrectangle from m's own main rectangle.
    """
    if theirs.main != i:
        noise[:, :] = theirs.sub_cov_wh[side]
        return theirs.sub_w[side], theirs.sub_h[side], theirs.sub_y[side], theirs.sub_var_y[side]
    noise[:, :] = theirs.cov_wh
    c, s = np.cos(ours.phi), np.sin(ours.phi)
    y = -s * (theirs.x - ours.x) + c * (theirs.y - ours.y)
    return theirs.w, theirs.h, y, _along(theirs.cov_xy, -s, c) + _along(ours.cov_xy, -s, c)


@njit
def _along(cov: Array, a: float, b: float) -> Any:
    """Return the variance of the component along a unit vector."""
    return a * a * cov[0, 0] + 2 * a * b * cov[0, 1] + b * b * cov[1, 1]


@njit
def _turned(cov: Array, c: float, s: float) -> Any:
    """Return a covariance in axes turned by the angle of cosine c and sine s."""
    out = np.empty((2, 2))
    out[0, 0], out[1, 1] = _along(cov, c, s), _along(cov, -s, c)
    out[0, 1] = out[1, 0] = c * s * (cov[1, 1] - cov[0, 0]) + (c * c - s * s) * cov[0, 1]
    return out


@njit
def _update_midpoint(ours: Record, theirs: Record, available: Array, moved: Array) -> None:
    """Update (x, y) along the axes of m: edges left and right tell of one component, top and bottom of the other."""
    c, s = np.cos(ours.phi), np.sin(ours.phi)
    dx, dy = theirs.x - ours.x, theirs.y - ours.y
    step, cov = np.zeros(2), _turned(ours.cov_xy, c, s)
    update_block(
        step, cov, np.array([c * dx + s * dy, -s * dx + c * dy]), _turned(theirs.cov_xy, c, s), available, moved
    )
    ours.x += c * step[0] - s * step[1]
    ours.y += s * step[0] + c * step[1]
    ours.cov_xy[:] = _turned(cov, c, -s)


@njit
def update_block(mean: Array, cov: Array, measured: Array, noise: Array, available: Array, moved: Array) -> None:
    """Kalman update of two parameters in place, eqs. (3)-(6), with those components of the measurement that exist.

    Variances of parameters that were moved by an expansion are raised to the measurement's first.
    """
    for a in range(2):
        if moved[a]:
            cov[a, a] = max(cov[a, a], noise[a, a])
    # S^-1, with zeros for a component that the measurement does not have.
    s00, s01, s11 = cov[0, 0] + noise[0, 0], cov[0, 1] + noise[0, 1], cov[1, 1] + noise[1, 1]
    i00, i01, i11 = 0.0, 0.0, 0.0
    if available[0] and available[1]:
        determinant = s00 * s11 - s01 * s01
        i00, i01, i11 = s11 / determinant, -s01 / determinant, s00 / determinant
    elif available[0]:
        i00 = 1.0 / s00
    elif available[1]:
        i11 = 1.0 / s11
    p00, p01, p11 = cov[0, 0], cov[0, 1], cov[1, 1]
    k00, k01 = p00 * i00 + p01 * i01, p00 * i01 + p01 * i11  # (4)
    k10, k11 = p01 * i00 + p11 * i01, p01 * i01 + p11 * i11
    r0, r1 = measured[0] - mean[0], measured[1] - mean[1]
    mean[0] += k00 * r0 + k01 * r1  # (5)
    mean[1] += k10 * r0 + k11 * r1
    cov[0, 0] -= k00 * p00 + k01 * p01  # (6)
    cov[1, 1] -= k10 * p01 + k11 * p11
    cov[0, 1] = cov[1, 0] = p01 - k00 * p01 - k01 * p11


@njit
def write(fig: Record, x: float, y: float, m: Record, least: float) -> None:
    """Write parameters into a region about its anchor (x, y), sizes of at least `least` m, blocks independent."""
    kept = m.type
    confidence = m.confidence
    fig.x -= x
    fig.y -= y
    m.cov[:] = 0.0
    to_edge_form(fig, m)
    m.type, m.confidence = kept, confidence
    m.anchor[0], m.anchor[1] = x, y
    keep_order(m, least)
    m.radius = bounding_radius(m)
