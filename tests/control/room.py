"""A hand-drawn room, a slow obvious lidar and a robot without inertia."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
ANGLES = -np.pi + 2 * np.pi * np.arange(180) / 180


def box(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float, float, float]]:
    """Return the four sides of a box."""
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]


def scan(pose: Floats, segments: Floats, noise: Floats | None = None, reach: float = 10.0) -> Floats:
    """Return the distance along each ray to the nearest segment, at most `reach`."""
    direction = np.stack([np.cos(ANGLES + pose[2]), np.sin(ANGLES + pose[2])], axis=1)[:, None]
    start, along = segments[None, :, :2] - pose[:2], (segments[:, 2:] - segments[:, :2])[None]
    cross = direction[..., 0] * along[..., 1] - direction[..., 1] * along[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (start[..., 0] * along[..., 1] - start[..., 1] * along[..., 0]) / cross
        part = (start[..., 0] * direction[..., 1] - start[..., 1] * direction[..., 0]) / cross
    hit = (distance > 0) & (part >= 0) & (part <= 1)
    ranges = np.where(hit, distance, np.inf).min(axis=1)
    if noise is not None:
        ranges = ranges + noise
    return np.clip(ranges, 0.0, reach)


def clearance(position: Floats, segments: Floats) -> float:
    """Return the distance from a point to the nearest segment."""
    a, b = segments[:, :2], segments[:, 2:]
    t = np.clip(np.sum((position - a) * (b - a), axis=1) / np.sum((b - a) ** 2, axis=1), 0, 1)
    return float(np.hypot(*(a + t[:, None] * (b - a) - position).T).min())


def move(pose: Floats, action: Floats, step: float = 0.1) -> Floats:
    """Drive an arc at action = (forward speed in m/s, turning speed in 2 rad/s)."""
    heading = pose[2] + action[1] * 2.0 * step / 2
    turn = action[1] * 2.0 * step
    return pose + np.array([action[0] * step * np.cos(heading), action[0] * step * np.sin(heading), turn])


def to_robot(point: tuple[float, float], pose: Floats) -> Floats:
    """Return a world point in the robot's frame."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[c, s], [-s, c]]) @ (np.asarray(point) - pose[:2])
