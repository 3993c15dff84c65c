"""The way to a place, and on from there: how much of it is left, and whether the robot has arrived."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.tasks.task import TaskSettings
from regionslam_env.worlds.geodesic import Field, Geodesic
from slam.jit import njit

STAY_SECONDS = 1.0
"""How long the robot's centre has to be inside where arrival is not declared, s."""

REMAINING, STAYED, TO_STAY = range(3)
"""Places in `Approach.state`."""


class Outcome(NamedTuple):
    """What one step has brought.

    Parameters
    ----------
    progress
        Decrease of the way that is left, m.
    inside
        The robot's true centre is inside the place.
    success, false_arrival
        The way ends with this step, well or with a wrong declaration.
    """

    progress: float
    inside: bool
    success: bool
    false_arrival: bool


class Approach:
    """Judges the steps of a robot that has to be in a place, and to go on to others from there.

    Parameters
    ----------
    geodesic
        Of the world.
    place
        Where to be: the distance to it, 0 or less inside.
    settings
        Duration of a step, and whether arrival is declared.
    beyond
        The way that follows; None where this place is the last one.

    Attributes
    ----------
    field
        Length of the shortest way through the place, and through those beyond in their order, from outside of it, m.
    state
        What changes from step to step, by the places `REMAINING` (length of the way that is left, m) and `STAYED`
        (steps that the robot has been inside), and what does not: `TO_STAY` (after how many of them it has arrived;
        infinitely many where that is declared). Kernels write it, too.
    """

    def __init__(
        self, geodesic: Geodesic, place: Field, settings: TaskSettings, beyond: Approach | None = None
    ) -> None:
        self.place, self._beyond = place, beyond
        self.field: Field = place if beyond is None else geodesic.field_through(place, beyond.field)
        self._declares = settings.declares
        to_stay = math.inf if settings.declares else max(1.0, np.ceil(STAY_SECONDS / settings.step - 1e-9))
        self.state = np.array([math.inf, 0.0, to_stay])

    def begin(self, remaining: float) -> None:
        """Set off with this much of the way left, m."""
        self.state[REMAINING], self.state[STAYED] = remaining, 0

    @property
    def remaining(self) -> float:
        """Length of the way that is left after the last step, m."""
        return float(self.state[REMAINING])

    @property
    def is_last(self) -> bool:
        """Whether no other place follows."""
        return self._beyond is None

    def left(self, x: float, y: float) -> float:
        """Return the length of the way from a point, m; infinite where there is none."""
        return self._left(x, y, self.place.at(x, y))

    def near(self, x: float, y: float) -> float:
        """Return the same from where a robot stands; from beside it where that is no place to be."""
        here = self.left(x, y)
        return here if math.isfinite(here) else self.field.near(x, y)

    def step(self, x: float, y: float, declared: bool) -> Outcome:
        """Judge a step that ends at this true position (world frame, m)."""
        distance, state = self.place.at(x, y), self.state
        inside = distance <= 0
        progress = advance(state, self._left(x, y, distance), inside)
        if self._declares:
            return Outcome(progress, inside, declared and inside, declared and not inside)
        return Outcome(progress, inside, bool(state[STAYED] >= state[TO_STAY]), False)

    def _left(self, x: float, y: float, distance: float) -> float:
        """Return the same where the distance to the place is known, m."""
        if self._beyond is None:
            return max(0.0, distance)
        return self._beyond.left(x, y) if distance <= 0 else self.field.at(x, y)


@njit
def advance(state: NDArray[np.float64], remaining: float, inside: bool) -> float:
    """Write down a step (`Approach.state`), after which this much of the way is left, m; return the progress, m."""
    if not math.isfinite(remaining):  # squeezed against something: no nearer, no farther
        remaining = state[REMAINING]
    progress = state[REMAINING] - remaining
    state[REMAINING] = remaining
    state[STAYED] = state[STAYED] + 1 if inside else 0
    return progress
