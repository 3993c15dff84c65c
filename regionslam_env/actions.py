"""What an agent can do: drive, and declare that it has arrived."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike

Arrival = Literal["stay", "declare"]

ARRIVALS: tuple[Arrival, ...] = ("stay", "declare")
"""How an episode of `GoTo` ends: by staying in the goal for a second, or by declaring to be there, right or wrong."""


class Action(NamedTuple):
    """An action in parts: speed and turn rate as shares of the robot's largest, in [-1, 1], and the declaration."""

    forward: float
    turn: float
    declare: bool


def action_space(arrival: Arrival) -> spaces.Box:
    """Return the action space: forward and turning speed in [-1, 1], and a third component that declares where > 0."""
    return spaces.Box(-1.0, 1.0, (3 if arrival == "declare" else 2,), np.float32)


def read_action(action: ArrayLike, size: int) -> Action:
    """Return the parts of an action of `size` components; speeds beyond [-1, 1] are clipped.

    Raises
    ------
    ValueError
        For another number of components, or one that is not a number.
    """
    values = np.asarray(action)
    if values.shape != (size,):
        raise ValueError(f"action is {action!r}, expected {size} finite numbers in [-1, 1]")
    forward, turn, *declare = values.tolist()
    if not (math.isfinite(forward) and math.isfinite(turn) and all(map(math.isfinite, declare))):
        raise ValueError(f"action is {action!r}, expected {size} finite numbers in [-1, 1]")
    return Action(min(1.0, max(-1.0, forward)), min(1.0, max(-1.0, turn)), size == 3 and declare[0] > 0)
