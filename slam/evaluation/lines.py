"""Closed edges of measurements with known origin as line factors, all rows of many measurements at once.

A region has a heading phi, a fixed anchor a and edges e along the normals n_u = (cos phi, sin phi) and
n_v = (-sin phi, cos phi). A measurement of it from pose (p, theta) gives one row for the heading and one for every edge
that it saw::

    r_phi = phi_z - (phi - theta)          r_e = rho_z(phi - theta) - n . (a - p) - e

where rho_z(.) is the measured edge as it lies once the measurement is turned about the robot to the expected heading.
That takes the measured heading out of the edges' rows: to first order the same as rho and alpha used jointly with
G Q G^T, but without the error of a lever that is itself measured, and the rows of phi and edges are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.region import MAX_STATE, REGION, b_index, u_index
from slam.rows import MAX_RECTANGLES, Floats, Row
from slam.se2 import wrap_angles
from slam.turning import observe

Ints = NDArray[np.int64]

_U = np.array([u_index(k) for k in range(MAX_RECTANGLES + 1)])

IS_U = np.isin(np.arange(MAX_STATE), _U)
"""Which entries of the state vector of a region are edges along n_u, shape (MAX_STATE,)."""


@dataclass(frozen=True, eq=False)
class Lines:
    """M measurements with K closed edges in all, in the robot's frame, described as their true regions are.

    Attributes
    ----------
    region
        Number of the true region of each measurement, shape (M,).
    phi, var_phi, middle
        Measured heading (rad) and its variance, and the middle of the main rectangle along n_u, n_v, shape (M, 2), m.
    owner, at, edge
        Of each edge, shape (K,): its measurement, ascending, and its place in the state vector of that measurement and
        of the true region.
    offset
        Measured edge relative to the middle, shape (K,), m.
    noise
        Covariance of each measurement's edges by their places in its state vector, (M, MAX_STATE, MAX_STATE), m².
    """

    region: Ints
    phi: Floats
    var_phi: Floats
    middle: Floats
    owner: Ints
    at: Ints
    edge: Ints
    offset: Floats
    noise: Floats

    @property
    def covariance(self) -> Floats:
        """Covariance of the edges' rows, shape (K, K), m²: measurements are independent of one another."""
        covariance = self.noise[self.owner[:, None], self.at[:, None], self.at]
        return np.where(self.owner[:, None] == self.owner, covariance, 0.0)


_FIELDS = tuple(field.name for field in fields(Lines))


def lines_of(records: NDArray[np.void], sources: NDArray[np.void]) -> Lines:
    """Return the lines of a scan.

    Parameters
    ----------
    records
        The scan, shape (M,) of `MEASUREMENT`.
    sources
        For each of them the true `region`, -1 if there is none, the index `first` of that region's rectangle with which
        the measurement begins, and whether it is `turned` by pi against the region, shape (M,).
    """
    known = sources["region"] >= 0
    records, sources = records[known], sources[known]
    turns = np.zeros((len(records), 4), REGION)
    observe(records, np.zeros(int(records["type"].max(initial=-1)) + 1, np.int64), turns)
    z = turns[np.arange(len(records)), 2 * sources["turned"]]
    places, state = np.arange(MAX_STATE), z["state"]
    owner, at = np.nonzero((z["closed"] != 0) & (places > 0) & (places < 2 + 3 * z["n"][:, None]))
    main = np.stack([_U[z["main"]], _U[z["main"] + 1], b_index(z["main"]), b_index(z["main"]) + 1], axis=1)
    middle = np.take_along_axis(state, main, axis=1).reshape(-1, 2, 2).mean(axis=2)
    lever = np.where(IS_U, middle[:, 1:], -middle[:, :1])  # d rho / d phi_z
    crossed, var_phi = lever[:, :, None] * z["cov"][:, :1], z["cov"][:, 0, 0]
    levers = lever[:, :, None] * lever[:, None] * var_phi[:, None, None]
    return Lines(
        sources["region"],
        state[:, 0].copy(),
        var_phi.copy(),
        middle,
        owner,
        at,
        _shifted(at, sources["first"][owner]),
        state[owner, at] - np.where(IS_U[at], middle[owner, 0], middle[owner, 1]),
        z["cov"] - crossed - crossed.swapaxes(1, 2) + levers,
    )


def stack(scans: Sequence[Lines]) -> Lines:
    """Return the lines of several scans as one."""
    joined = {name: np.concatenate([getattr(scan, name) for scan in scans]) for name in _FIELDS}
    firsts = np.cumsum([0, *(len(scan.region) for scan in scans[:-1])])
    joined["owner"] += np.repeat(firsts, [len(scan.owner) for scan in scans])
    return Lines(**joined)


def state_of(row: Row, anchor: ArrayLike) -> Floats:
    """Return heading (rad) and edges (m, from the anchor) of a true row, shape (MAX_STATE,), nan beyond its end."""
    u, v = row.to_local(np.asarray(anchor, float)[None])[0]
    state = np.full(MAX_STATE, np.nan)
    state[0] = row.phi
    state[[u_index(k) for k in range(row.n + 1)]] = row.u - u
    state[[b_index(i) for i in range(row.n)]] = row.b - v
    state[[b_index(i) + 1 for i in range(row.n)]] = row.t - v
    return state


def residuals(lines: Lines, poses: Floats, phi: Floats, anchor: Floats, edges: Floats) -> tuple[Floats, Floats]:
    """Return the rows of the headings, shape (M,), rad, and of the edges, shape (K,), m.

    Parameters
    ----------
    lines
        The measurements.
    poses
        From where each measurement was taken, shape (M, 3) or (3,).
    phi, anchor
        Heading (M,) and anchor (M, 2) of the region of each measurement.
    edges
        Position of each edge, shape (K,), m.
    """
    poses = np.broadcast_to(poses, (len(phi), 3))
    expected = phi - poses[:, 2]
    seen_u, seen_v, at_u, at_v = _middles(lines, poses, phi, anchor)
    shift = np.where(IS_U[lines.edge], (seen_u - at_u)[lines.owner], (seen_v - at_v)[lines.owner])
    return wrap_angles(lines.phi - expected), lines.offset + shift - edges


def jacobians(lines: Lines, poses: Floats, phi: Floats, anchor: Floats) -> tuple[Floats, Floats]:
    """Return -dr_e / d(x, y, theta), shape (K, 3), and -dr_e / dphi, shape (K,).

    The rest is constant: -dr_e / de is 1, and -dr_phi / d(theta, phi) is (-1, 1).
    """
    poses = np.broadcast_to(poses, (len(phi), 3))
    seen_u, seen_v, at_u, at_v = _middles(lines, poses, phi, anchor)
    own, along = lines.owner, IS_U[lines.edge]
    c, s = np.cos(phi)[own], np.sin(phi)[own]
    turned = np.where(along, seen_v[own], -seen_u[own])
    by_pose = np.stack([np.where(along, -c, s), np.where(along, -s, -c), turned], axis=1)
    return by_pose, np.where(along, at_v[own], -at_u[own]) - turned


def _middles(lines: Lines, poses: Floats, phi: Floats, anchor: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return main middle, turned to the expected heading, and anchor, both seen from the robot, along n_u and n_v."""
    turn = phi - poses[:, 2] - lines.phi
    c, s = np.cos(turn), np.sin(turn)
    u, v = lines.middle.T
    dx, dy = (anchor - poses[:, :2]).T
    cp, sp = np.cos(phi), np.sin(phi)
    return c * u + s * v, c * v - s * u, cp * dx + sp * dy, cp * dy - sp * dx


def _shifted(places: Ints, rectangles: Ints) -> Ints:
    """Return the places in the state vector of the same edges, so many rectangles further along the row."""
    boundary = np.searchsorted(_U, places)
    return np.where(IS_U[places], _U[np.minimum(boundary + rectangles, MAX_RECTANGLES)], places + 3 * rectangles)
