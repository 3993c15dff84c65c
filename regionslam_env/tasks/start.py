"""Where an episode starts: drawn, or given and checked."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from regionslam_env.errors import ConfigError, WorldError
from regionslam_env.worlds.feature import FARTHEST
from regionslam_env.worlds.geodesic import MARGIN, Field, Geodesic

Pose = tuple[float, float, float]


def draw_start(
    rng: np.random.Generator,
    geodesic: Geodesic,
    field: Field,
    goal: str,
    at_least: float,
    reaching: Iterable[Field] = (),
) -> Pose:
    """Draw a free pose in any direction whose distance from a goal, of this name, is at least `at_least`, m.

    There is a way from it in each of the fields `reaching` as well.

    Raises
    ------
    ConfigError
        Where there is none.
    """
    try:
        x, y = geodesic.sample_free(rng, field, at_least=at_least, reaching=reaching)
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
    x0, y0, x1, y1 = geodesic.world.bounds
    if not standing and not (x0 - MARGIN <= x <= x1 + MARGIN and y0 - MARGIN <= y <= y1 + MARGIN):
        raise ConfigError(
            f"world {geodesic.world.name!r}: start ({x:g}, {y:g}) lies outside, "
            f"expected x from {x0:.1f} to {x1:.1f} m and y from {y0:.1f} to {y1:.1f} m"
        )
    if not standing and not geodesic.free(x, y):
        raise ConfigError(
            f"world {geodesic.world.name!r}: start ({x:g}, {y:g}) is not free for a robot of "
            f"{geodesic.radius:g} m radius"
        )
    return x, y, theta


def distance_from(field: Field, start: Pose, standing: bool) -> float:
    """Return the distance in a field from a start, m; a robot that is `standing` may be where no way begins."""
    return (field.near if standing else field.at)(start[0], start[1])


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
