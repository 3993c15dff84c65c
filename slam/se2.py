"""Angles, poses and frames of the plane.

A pose is an array (x, y, theta) in m, m, rad; theta turns counter-clockwise. `world_T_robot` is the pose of the robot's
frame in the world, and it takes points of the robot's frame to the world. Poses may be stacked, shape (..., 3).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from slam.jit import njit
from slam.rows import Floats


@njit
def wrap(angle: float) -> float:
    """Return the same direction in (-pi, pi], rad (scalar kernel)."""
    if -math.pi < angle <= math.pi:
        return angle
    return angle - 2 * math.pi * math.ceil((angle - math.pi) / (2 * math.pi))


@njit
def to_world(x: float, y: float, theta: float, px: float, py: float) -> tuple[float, float]:
    """Return the world point that lies at (px, py) in the frame of the pose (x, y, theta) (scalar kernel)."""
    c, s = math.cos(theta), math.sin(theta)
    return x + c * px - s * py, y + s * px + c * py


@njit
def to_local(x: float, y: float, theta: float, px: float, py: float) -> tuple[float, float]:
    """Return where the world point (px, py) lies in the frame of the pose (x, y, theta) (scalar kernel)."""
    c, s = math.cos(theta), math.sin(theta)
    return c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)


def wrap_angles(angles: ArrayLike) -> Floats:
    """Return the same directions in (-pi, pi], rad, in an array of the same shape."""
    angles = np.asarray(angles, dtype=np.float64)
    turns = np.ceil((angles - np.pi) / (2 * np.pi))
    return np.asarray(angles - 2 * np.pi * turns)


def compose(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the pose ``a * b``: b, given in the frame of a, in the frame that a is given in. Shapes (..., 3)."""
    a, b = _pose(a), _pose(b)
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = a[..., 0] + c * b[..., 0] - s * b[..., 1]
    y = a[..., 1] + s * b[..., 0] + c * b[..., 1]
    return np.stack([x, y, wrap_angles(a[..., 2] + b[..., 2])], axis=-1)


def inverse(pose: ArrayLike) -> Floats:
    """Return the pose that undoes `pose`: ``compose(pose, inverse(pose))`` is (0, 0, 0). Shapes (..., 3)."""
    pose = _pose(pose)
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = pose[..., 0], pose[..., 1]
    return np.stack([-c * x - s * y, s * x - c * y, wrap_angles(-pose[..., 2])], axis=-1)


def between(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the pose b in the frame of a: ``compose(a, between(a, b))`` is b. Shapes (..., 3)."""
    return compose(inverse(a), b)


def transform(pose: ArrayLike, points: ArrayLike) -> Floats:
    """Take points, shape (k, 2) or (2,), from the frame of one pose to the frame that the pose is given in."""
    x, y, theta = _pose(pose)
    c, s = np.cos(theta), np.sin(theta)
    return np.asarray(np.asarray(points, dtype=np.float64) @ np.array([[c, s], [-s, c]]) + (x, y))


def _pose(pose: ArrayLike) -> Floats:
    pose = np.asarray(pose, dtype=np.float64)
    if pose.shape[-1:] != (3,):
        raise ValueError(f"a pose is (x, y, theta), an array of shape (..., 3); got shape {pose.shape}")
    return pose
