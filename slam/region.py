"""Region features (Oberländer et al. 2008, Fig. 1) and their edge form.

The paper describes a region by midpoints and sizes. Written as *edge positions* the same region keeps what a partial
measurement tells: seeing only the right edge fixes x + w/2, neither x nor w. Filter and kernels use the edge form,
people the paper's parameters; `REGION` is the first, `RegionFeature` the second.

State vector of a region with n rectangles, length ``2 + 3 n``, relative to a fixed anchor::

    phi, u0, u1, b0, t0, u2, b1, t1, u3, b2, t2

A smaller region is a prefix of a larger one, so loops run over ``2 + 3 n`` entries.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from slam.jit import njit
from slam.rows import MAX_RECTANGLES, Floats, Row

MAX_STATE = 2 + 3 * MAX_RECTANGLES

EDGE_NAMES = ("t", "b", "l", "r", "tl", "bl", "ll", "tr", "br", "rr")
"""Edges of Fig. 1: of the main rectangle, then of the left and of the right subrectangle."""


class EdgeState(IntEnum):
    """State of a rectangle's edge: unseen, seen, or the joint with a subrectangle."""

    OPEN = 0
    CLOSED = 1
    SUBRECT = 2


REGION = np.dtype(
    (
        np.record,
        [
            ("id", np.int64),  # of the first sighting, inherited by resampling
            ("type", np.int64),  # index into the filter's list of types
            ("level", np.int64),  # storey that it was seen on
            ("n", np.int64),  # rectangles
            ("main", np.int64),  # index of the main rectangle
            ("sightings", np.int64),
            ("last_seen", np.int64),  # number of the scan
            ("first_link", np.int64),  # head of the list of links, -1 for none
            ("n_links", np.int64),
            ("rival", np.int64),  # slot of the more credible hypothesis for the same place, -1 for none
            ("visited", np.int64),  # the robot has been inside
            ("type_log_odds", np.float64),
            ("type_prior", np.float64),  # log-odds of the prior p(m) that is part of it
            ("existence", np.float64),  # log-odds
            ("confidence", np.float64),  # p(z) of a measurement
            ("radius", np.float64),  # of a circle about the anchor that holds the region, m
            ("anchor", np.float64, (2,)),  # map frame, fixed at the first sighting
            ("state", np.float64, (MAX_STATE,)),
            ("cov", np.float64, (MAX_STATE, MAX_STATE)),
            ("closed", np.int8, (MAX_STATE,)),  # edges: 0 open, 1 closed or joint; entry 0 (phi) is always 1
            ("contrary", np.int8, (MAX_STATE,)),  # views beyond a closed edge, lately
        ],
    )
)
"""One region of a particle's map in edge form."""


@njit
def u_index(k: int) -> int:
    """Return the place of boundary u_k in the state vector."""
    return 1 if k == 0 else 3 * k - 1


@njit
def b_index(i: int) -> int:
    """Return the place of the bottom edge of rectangle i in the state vector; its top edge follows."""
    return 3 + 3 * i


@njit
def is_u(k: int) -> bool:
    """Say whether place k of the state vector is a boundary along the row, not an edge across it."""
    return k == 1 or k % 3 == 2


@dataclass(frozen=True, eq=False)
class Subrectangle:
    """Left or right subrectangle of a region (Fig. 1): size, lateral displacement, covariances, edge states."""

    w: float
    h: float
    y: float
    t: EdgeState = EdgeState.CLOSED
    b: EdgeState = EdgeState.CLOSED
    end: EdgeState = EdgeState.CLOSED
    cov_wh: Floats = field(default_factory=lambda: np.zeros((2, 2)))
    var_y: float = 0.0


@dataclass(frozen=True, eq=False)
class RegionFeature:
    """A mapped region with every field of Fig. 1, in the map frame.

    Attributes
    ----------
    id
        Stable identity: the scan and the measurement of the first sighting.
    type, type_log_odds
        Semantic type and the log-odds that it is the right one.
    x, y, w, h, phi
        Midpoint (m), size (m) and heading (rad) of the main rectangle.
    cov_xy, cov_wh, var_phi
        Covariances of (x, y) and (w, h), variance of phi.
    t, b, l, r
        States of the main rectangle's edges; `l` and `r` are SUBRECT where `left` and `right` are given.
    left, right
        Subrectangles or None.
    neighbours
        For every edge name of `EDGE_NAMES` that borders a linked region: the neighbour's id and the link's log-odds.
    children
        Ids of subregions and the log-odds of the containment.
    existence
        Log-odds that there is such a region at all.
    sightings
        Number of scans that measured it.
    visited
        Whether the robot has been inside.
    credible
        False for a hypothesis that is outdone by another type at the same place.
    level
        Storey: 0 is the ground floor. Regions of different levels share (x, y).
    name
        Name that was given to it, such as "building 2" or "B 4.12"; "" for none.
    """

    id: int
    type: str
    type_log_odds: float
    x: float
    y: float
    w: float
    h: float
    phi: float
    t: EdgeState = EdgeState.CLOSED
    b: EdgeState = EdgeState.CLOSED
    l: EdgeState = EdgeState.CLOSED  # noqa: E741 - the paper's name
    r: EdgeState = EdgeState.CLOSED
    left: Subrectangle | None = None
    right: Subrectangle | None = None
    cov_xy: Floats = field(default_factory=lambda: np.zeros((2, 2)))
    cov_wh: Floats = field(default_factory=lambda: np.zeros((2, 2)))
    var_phi: float = 0.0
    neighbours: Mapping[str, Mapping[int, float]] = field(default_factory=dict)
    children: Mapping[int, float] = field(default_factory=dict)
    existence: float = 0.0
    sightings: int = 1
    visited: bool = False
    credible: bool = True
    level: int = 0
    name: str = ""

    @property
    def row(self) -> Row:
        """The geometry alone."""
        left = None if self.left is None else (self.left.w, self.left.h, self.left.y)
        right = None if self.right is None else (self.right.w, self.right.h, self.right.y)
        return Row.from_parameters(self.x, self.y, self.w, self.h, self.phi, left, right)

    @property
    def edges(self) -> dict[str, EdgeState]:
        """States of all its edges by the names of `EDGE_NAMES`."""
        states = {"t": self.t, "b": self.b, "l": self.l, "r": self.r}
        for side, sub in (("l", self.left), ("r", self.right)):
            if sub is not None:
                states |= {f"t{side}": sub.t, f"b{side}": sub.b, side * 2: sub.end}
        return states

    @property
    def open_edges(self) -> tuple[str, ...]:
        """Names of the edges not yet seen."""
        return tuple(name for name, state in self.edges.items() if state is EdgeState.OPEN)
