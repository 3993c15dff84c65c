"""One Gaussian over the pose and all regions of a map (the joint posterior of one association hypothesis).

Entries 0, 1, 2 are the pose (x, y, theta). Every region has entries for its heading and for its closed edges: its
state vector (`slam.region`) without the open ones, which are bounds and correlate with nothing. `entries` says where
they are, so that a new description of a region only renames them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from slam.edge_form import state_size
from slam.jit import Array, Record, njit
from slam.region import MAX_STATE, b_index, is_u, u_index
from slam.rows import Floats

POSE = 3
"""Entries of the pose."""

FLAT = 1e6
"""Variance of an entry about which nothing is known yet, in variances of what is about to settle it."""

APART = 0.01
"""Share of its variance that each of several edges on one line has to itself."""

USED, RELEASED = range(2)
"""What `JointGaussian.counts` counts: entries up to the last one ever used, and those among them to be used again."""

ROOM, SLOTS = 64, 16
"""Room at first."""


class JointGaussian(NamedTuple):
    """The arrays of a Gaussian, as kernels take them: N entries, S slots of regions; unused entries are zero."""

    mean: np.ndarray  # (N,) m and rad, map frame
    cov: np.ndarray  # (N, N)
    entries: np.ndarray  # (S, MAX_STATE) int64: of a region's state vector, -1 for open edges and absent regions
    anchors: np.ndarray  # (S, 2) anchor of a region, map frame, m
    released: np.ndarray  # (N,) int64: a stack
    counts: np.ndarray  # (2,) int64

    @classmethod
    def at(cls, pose: Floats) -> JointGaussian:
        """Return a Gaussian without regions that knows its pose (x, y, theta) for certain."""
        empty = cls(
            np.zeros(ROOM),
            np.zeros((ROOM, ROOM)),
            np.full((SLOTS, MAX_STATE), -1, np.int64),
            np.zeros((SLOTS, 2)),
            np.zeros(ROOM, np.int64),
            np.array([POSE, 0]),
        )
        empty.mean[:POSE] = pose
        return empty

    @property
    def used(self) -> int:
        """Number of entries up to the last one ever used."""
        return int(self.counts[USED])

    def copy(self) -> JointGaussian:
        """Return a Gaussian that shares nothing with this one."""
        return JointGaussian(*(array.copy() for array in self))

    def with_room(self, entries: int, slots: int) -> JointGaussian:
        """Return a Gaussian with room for so many more entries and for so many slots in all."""
        grown = self
        if self.used + entries > len(self.mean):
            size = max(self.used + entries, 2 * len(self.mean))
            grown = grown._replace(
                mean=_grown(self.mean, (size,)),
                cov=_grown(self.cov, (size, size)),
                released=_grown(self.released, (size,)),
            )
        if slots > len(self.entries):
            size = max(slots, 2 * len(self.entries))
            more = np.full((size, MAX_STATE), -1, np.int64)
            more[: len(self.entries)] = self.entries
            grown = grown._replace(entries=more, anchors=_grown(self.anchors, (size, 2)))
        return grown


def _grown(array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    larger = np.zeros(shape, array.dtype)
    larger[tuple(slice(length) for length in array.shape)] = array
    return larger


@njit
def allocate(joint: Record, mean: float, variance: float) -> Any:
    """Return the place of a new entry that correlates with nothing yet; the caller has made room."""
    if joint.counts[RELEASED] > 0:
        joint.counts[RELEASED] -= 1
        place = joint.released[joint.counts[RELEASED]]
    else:
        place = joint.counts[USED]
        joint.counts[USED] += 1
    joint.mean[place], joint.cov[place, place] = mean, variance
    return place


@njit
def release(joint: Record, place: int) -> None:
    """Marginalise an entry: what it told of all others stays in their covariances."""
    joint.mean[place] = 0.0
    for a in range(joint.counts[USED]):
        joint.cov[place, a] = joint.cov[a, place] = 0.0
    joint.released[joint.counts[RELEASED]] = place
    joint.counts[RELEASED] += 1


@njit
def marginalise(joint: Record, slot: int) -> None:
    """Drop a region."""
    for k in range(MAX_STATE):
        if joint.entries[slot, k] >= 0:
            release(joint, joint.entries[slot, k])
            joint.entries[slot, k] = -1


@njit
def negate(joint: Record, place: int) -> None:
    """Count an entry in the opposite direction."""
    joint.mean[place] = -joint.mean[place]
    for a in range(joint.counts[USED]):
        joint.cov[place, a] = -joint.cov[place, a]
    for a in range(joint.counts[USED]):
        joint.cov[a, place] = -joint.cov[a, place]


@njit
def duplicate(joint: Record, place: int) -> Any:
    """Return the place of a new entry that equals another one up to a share of its variance."""
    variance = (1 + APART) * joint.cov[place, place]
    copy = allocate(joint, joint.mean[place], variance)
    for a in range(joint.counts[USED]):
        joint.cov[copy, a] = joint.cov[a, copy] = joint.cov[place, a]
    joint.cov[copy, copy] = variance
    return copy


@njit
def follow_turn(joint: Record, slot: int, old: Record, new: Record, quarters: int) -> None:
    """Follow a region from one description to another that is turned by quarters of a full turn.

    Its edges are the same lines, so each takes the entry of the one that lies where it does: after a quarter turn the
    new u edges are old v edges, the new v edges minus old u edges. A line that becomes several edges is duplicated.
    """
    before, taken = joint.entries[slot].copy(), np.zeros(MAX_STATE, np.bool_)
    joint.entries[slot, 1:] = -1
    for k in range(1, state_size(new.n)):
        sign = 1.0 if quarters == 0 or quarters == (1 if is_u(k) else 3) else -1.0
        source, nearest = -1, np.inf
        for j in range(1, state_size(old.n)):
            if new.closed[k] and before[j] >= 0 and (is_u(j) == is_u(k)) == (quarters % 2 == 0):
                distance = abs(sign * old.state[j] - new.state[k])
                if distance < nearest or (distance == nearest and not taken[j]):
                    source, nearest = j, distance
        if source < 0:
            continue
        if taken[source]:
            joint.entries[slot, k] = duplicate(joint, before[source])
            continue
        taken[source] = True
        joint.entries[slot, k] = before[source]
        if sign < 0.0:
            negate(joint, before[source])
    for j in range(1, MAX_STATE):
        if before[j] >= 0 and not taken[j]:
            release(joint, before[j])
    joint.mean[before[0]] += quarters * np.pi / 2


@njit
def follow_shift(joint: Record, slot: int, n: int) -> None:
    """Follow `slam.geometric_update.shift_right` of a region that had n rectangles: all edges move up by one."""
    entries = joint.entries[slot]
    for k in range(n, -1, -1):
        entries[u_index(k + 1)] = entries[u_index(k)]
    for i in range(n - 1, -1, -1):
        entries[b_index(i + 1)], entries[b_index(i + 1) + 1] = entries[b_index(i)], entries[b_index(i) + 1]
    entries[u_index(0)] = entries[b_index(0)] = entries[b_index(0) + 1] = -1


@njit
def place_pose(joint: Record, pose: Array) -> None:
    """Put the robot at a pose (x, y, theta) known for certain."""
    for i in range(POSE):
        joint.mean[i] = pose[i]
        for a in range(joint.counts[USED]):
            joint.cov[i, a] = joint.cov[a, i] = 0.0


@njit
def move(joint: Record, motion: Any, variances: Any) -> None:
    """Move the pose by odometry, p(x_t | x_{t-1}, u_t): it enters the pose's rows of the covariance and no others.

    `motion` is distance, lateral (m) and rotation (rad) in the robot's frame at its start; `variances` are those of
    `MotionNoise` in order.
    """
    mean, cov, used = joint.mean, joint.cov, joint.counts[USED]
    distance, lateral, rotation = motion
    driven = np.sqrt(distance * distance + lateral * lateral)
    c, s = np.cos(mean[2]), np.sin(mean[2])
    dx, dy = c * distance - s * lateral, s * distance + c * lateral
    # F = I + [0 0 -dy; 0 0 dx; 0 0 0] from both sides, G = [c 0; s 0; 0 1]
    for a in range(used):
        cov[0, a] -= dy * cov[2, a]
        cov[1, a] += dx * cov[2, a]
    for a in range(used):
        cov[a, 0] -= dy * cov[a, 2]
        cov[a, 1] += dx * cov[a, 2]
    along = variances[0] * driven
    cov[0, 0] += c * c * along
    cov[0, 1] += c * s * along
    cov[1, 0] += c * s * along
    cov[1, 1] += s * s * along
    cov[2, 2] += variances[1] * driven + variances[2] * abs(rotation)
    mean[0] += dx
    mean[1] += dy
    mean[2] += rotation
