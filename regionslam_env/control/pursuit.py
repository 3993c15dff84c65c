"""Following a path: which of its points to steer for, and how fast."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slam.jit import njit


@njit
def look_ahead(cost: NDArray[np.float32], path: NDArray[np.float64], farthest: float) -> int:
    """Return the index of the farthest path point that a straight line reaches as comfortably as the path does.

    Parameters
    ----------
    cost
        Driving cost per cell.
    path
        Points (column, row) in cells, the robot first, shape (k, 2).
    farthest
        Longest line tried, in cells.
    """
    best = min(1, len(path) - 1)
    worst = cost[math.floor(path[0, 1] + 0.5), math.floor(path[0, 0] + 0.5)]
    x0, y0 = path[0, 0], path[0, 1]
    for j in range(1, len(path)):
        x, y = path[j, 0], path[j, 1]
        length = math.hypot(x - x0, y - y0)
        if length > farthest:
            break
        here = cost[math.floor(y + 0.5), math.floor(x + 0.5)]
        worst = max(worst, here)
        steps = int(2 * length) + 1
        clear = True
        for s in range(1, steps):
            along = s / steps
            there = cost[math.floor(y0 + along * (y - y0) + 0.5), math.floor(x0 + along * (x - x0) + 0.5)]
            if there > 1.2 * worst + 0.3:
                clear = False
                break
        if clear:
            best = j
    return best


@njit
def pursue(
    x: float,
    y: float,
    remaining: float,
    points: NDArray[np.float64],
    touch: float,
    max_speed: float,
    max_turn_rate: float,
    max_acceleration: float,
) -> tuple[float, float]:
    """Return forward speed (m/s) and turn rate (rad/s) towards a point.

    Turns on the spot where the point lies aside or behind, slows down beside obstacles, and takes the highest speed
    whose arc stays clear of every obstacle until the robot could stand still.

    Parameters
    ----------
    x, y
        The point in the robot's frame, m.
    remaining
        Length of the path up to where the robot shall stop (m); inf: nowhere.
    points
        Obstacles in the robot's frame, shape (k, 2), m.
    touch
        Distance of the robot's centre from an obstacle at which they touch, m.
    max_speed, max_turn_rate, max_acceleration
        Limits in m/s, rad/s and m/s².
    """
    angle = math.atan2(y, x)
    turn = min(max(4.0 * angle, -max_turn_rate), max_turn_rate)
    if abs(angle) > 0.9:
        return 0.0, turn
    clearance = math.inf
    for k in range(len(points)):
        clearance = min(clearance, math.hypot(points[k, 0], points[k, 1]))
    speed = max_speed * math.cos(angle) ** 3
    speed = min(speed, 0.35 + 1.8 * max(0.0, clearance - touch))
    if math.isfinite(remaining):
        speed = min(speed, 0.7 * math.sqrt(2.0 * max_acceleration * remaining))
    keep = min(touch + 0.02, clearance - 0.002)  # a robot that touches already may only get away
    for _ in range(6):
        if _clear(speed, turn, 0.25 + speed / max_acceleration, points, keep):
            return speed, turn
        speed *= 0.6
    return 0.0, turn


@njit
def _clear(speed: float, turn: float, duration: float, points: NDArray[np.float64], keep: float) -> bool:
    """Tell whether the arc of a speed and a turn rate keeps a distance (m) to all points for a duration (s)."""
    x, y, heading = 0.0, 0.0, 0.0
    step = 0.05
    far = (keep + speed * duration) ** 2
    for _ in range(int(duration / step) + 1):
        heading += 0.5 * turn * step
        x += speed * math.cos(heading) * step
        y += speed * math.sin(heading) * step
        heading += 0.5 * turn * step
        for k in range(len(points)):
            px, py = points[k, 0], points[k, 1]
            if px * px + py * py < far and (px - x) ** 2 + (py - y) ** 2 < keep * keep:
                return False
    return True
