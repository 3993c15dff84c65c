"""Looking around, step by step: once around on the spot, and whether that is over."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.control.controller import LocalController
from regionslam_env.observations import Observation

CLOSE = 0.1
"""A turn is full when this much of it is left, rad."""


class LookAround:
    """A full turn to the left, measured on the believed heading.

    Parameters
    ----------
    controller
        Turns on the spot.
    observation
        Of the moment in which the turn begins.
    """

    def __init__(self, controller: LocalController, observation: Observation) -> None:
        self._controller = controller
        self._left, self._heading = 2 * math.pi, _heading(observation)

    def act(self, observation: Observation) -> NDArray[np.float64]:
        """Return the next action, forward and turning speed in [-1, 1]."""
        return self._controller.turn(self._left)

    def judge(self, observation: Observation, slot_ids: NDArray[np.int64]) -> str:
        """Return the outcome after an action, by the observation that came of it: "looked" or ""."""
        before, self._heading = self._heading, _heading(observation)
        self._left -= math.remainder(self._heading - before, 2 * math.pi)
        return "looked" if self._left < CLOSE else ""


def _heading(observation: Observation) -> float:
    """Return the believed heading, rad; the pose is x, y, cos, sin."""
    pose: NDArray[Any] = observation["pose"]
    return math.atan2(pose[3], pose[2])
