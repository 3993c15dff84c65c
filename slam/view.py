"""What was in view: the visible polygon of a scan, star-shaped about the robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.jit import Array, lean


@lean
def is_in_view(view: Array, x: float, y: float, margin: float) -> bool:
    """Say whether a point (robot frame, m) lies inside the view, at least `margin` m before its end along the ray.

    The vertices run counter-clockwise by angle, so the two that bracket the point are found by bisection. A sensor
    with a limited field of view puts the robot itself, (0, 0), first: nothing outside the span of the others is
    visible.
    """
    n = len(view)
    first = 1 if view[0, 0] == 0.0 and view[0, 1] == 0.0 else 0
    distance = np.sqrt(x * x + y * y)
    if distance < 1e-9:
        return True
    origin = diamond(view[first, 0], view[first, 1])
    angle = diamond_from(origin, x, y)
    low, high = first, n - 1
    if diamond_from(origin, view[high, 0], view[high, 1]) < angle:
        if first == 1:
            return False
        a, b = n - 1, 0
    else:
        while high - low > 1:
            middle = (low + high) // 2
            if diamond_from(origin, view[middle, 0], view[middle, 1]) <= angle:
                low = middle
            else:
                high = middle
        a, b = low, high
    scale = 1.0 + margin / distance
    ex, ey = view[b, 0] - view[a, 0], view[b, 1] - view[a, 1]
    return ex * (y * scale - view[a, 1]) - ey * (x * scale - view[a, 0]) >= 0.0


@lean
def diamond_from(origin: float, x: float, y: float) -> Any:
    """Return the `diamond` of a vector counted from another's, in [0, 4); a modulo would take many times as long."""
    angle = diamond(x, y) - origin
    if angle < 0.0:
        return angle + 4.0
    return angle - 4.0 if angle >= 4.0 else angle


@lean
def diamond(x: float, y: float) -> Any:
    """Return a number in [0, 4) that grows with the angle of a vector, without trigonometry."""
    total = abs(x) + abs(y)
    if total == 0.0:
        return 0.0
    if y >= 0.0:
        return y / total if x >= 0.0 else 1.0 - x / total
    return 2.0 - y / total if x < 0.0 else 3.0 + x / total
