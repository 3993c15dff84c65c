"""What an agent can do: drive, and declare that it has arrived."""

from __future__ import annotations

import math
import operator
from typing import Any, Literal, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

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


def read_actions(
    actions: ArrayLike, shape: tuple[int, ...], counted: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the parts of many actions: shares of speed and turn rate, shape (N, 2), and declarations, shape (N,).

    Parameters
    ----------
    actions
        A row for each robot.
    shape
        That they have to have.
    counted
        Which of them will be taken; the others may be anything.

    Raises
    ------
    ValueError
        For another shape, or a component that is not a number.
    """
    values = np.asarray(actions, dtype=np.float64)
    if values.shape != shape:
        raise ValueError(f"actions have the shape {values.shape}, expected {shape}: finite numbers in [-1, 1]")
    wrong = counted & ~np.isfinite(values).all(axis=1)
    if wrong.any():
        i = int(np.argmax(wrong))
        raise ValueError(f"action {i} is {values[i]!r}, expected {shape[1]} finite numbers in [-1, 1]")
    declared = values[:, 2] > 0 if shape[1] == 3 else np.zeros(len(values), np.bool_)
    return np.clip(values[:, :2], -1.0, 1.0), declared


def read_choice(action: Any, count: int) -> int:
    """Return the number of one of `count` discrete actions.

    Raises
    ------
    ValueError
        For anything but a whole number from 0 to `count` - 1.
    """
    try:
        number = operator.index(action)
    except TypeError:
        number = -1
    if not 0 <= number < count:
        raise ValueError(f"action is {action!r}, expected a whole number from 0 to {count - 1}")
    return number
