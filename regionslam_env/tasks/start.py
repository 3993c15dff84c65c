"""Where an episode starts: drawn, or given and checked."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from regionslam_env.errors import ConfigError, WorldError
from regionslam_env.worlds.feature import FARTHEST
from regionslam_env.worlds.geodesic import Field, Geodesic

Pose = tuple[float, float, float]

CONTACT = 0.03
"""How far a touching robot is moved to measure its distance, m; contacts overlap by less than half of that."""


def draw_start(rng: np.random.Generator, geodesic: Geodesic, field: Field, goal: str, at_least: float) -> Pose:
    """Draw a free pose in any direction whose distance from a goal, of this name, is at least `at_least`, m.

    Raises
    ------
    ConfigError
        Where there is none.
    """
    try:
        x, y = geodesic.sample_free(rng, field, at_least=at_least)
    except WorldError as error:
        raise ConfigError(_no_start(geodesic, field, goal, at_least)) from error
    return x, y, float(rng.uniform(-math.pi, math.pi))


def checked_start(geodesic: Geodesic, start: Sequence[float], standing: bool) -> Pose:
    """Return a start as a pose, or refuse it; a robot that is `standing` may touch something."""
    try:
        values = np.asarray(start, dtype=np.float64).tolist()
    except (TypeError, ValueError, OverflowError):
        values = None
    if not isinstance(values, list) or len(values) != 3 or not all(map(_is_finite, values)):
        raise ConfigError(f"start is {start!r}, expected a pose (x, y, theta) in m, m, rad")
    x, y, theta = values
    if not standing and not geodesic.free(x, y):
        raise ConfigError(
            f"world {geodesic.world.name!r}: start ({x:g}, {y:g}) is not free for a robot of "
            f"{geodesic.radius:g} m radius"
        )
    return x, y, theta


def from_start(distance: Callable[[float, float], float], start: Pose, standing: bool) -> float:
    """Return a distance from a start, m: from beside it where a standing robot is squeezed against something."""
    x, y, _ = start
    here = distance(x, y)
    if math.isfinite(here) or not standing:
        return here
    turns = np.linspace(0, 2 * math.pi, 8, endpoint=False).tolist()
    return min(distance(x + CONTACT * math.cos(turn), y + CONTACT * math.sin(turn)) for turn in turns)


def checked_distance(start_distance: float) -> float:
    """Return the least distance of a start from its goal, m, or refuse it."""
    number = isinstance(start_distance, int | float) and not isinstance(start_distance, bool)
    if not number or not 0 <= start_distance <= FARTHEST:
        raise ConfigError(f"start_distance is {start_distance!r}, expected a length from 0 to {FARTHEST:g} m")
    return float(start_distance)


def _is_finite(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def _no_start(geodesic: Geodesic, field: Field, goal: str, at_least: float) -> str:
    reach = field.roots.value[np.isfinite(field.roots.value)]
    prefix = f"world {geodesic.world.name!r}: "
    if not len(reach):
        return f"{prefix}no {goal!r} can be reached by the robot"
    return (
        f"{prefix}no free place is {at_least:g} m or more from every {goal!r} (start_distance): "
        f"the farthest is {reach.max():.1f} m away"
    )
