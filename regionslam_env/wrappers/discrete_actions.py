"""A few motions by number, for algorithms that want discrete actions."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from regionslam_env.actions import read_choice

MOTIONS = {
    "forward": (1.0, 0.0),
    "forward left": (0.7, 0.5),
    "forward right": (0.7, -0.5),
    "turn left": (0.0, 0.5),
    "turn right": (0.0, -0.5),
    "back": (-0.5, 0.0),
    "stop": (0.0, 0.0),
}
"""Speed and turn rate, as shares of the robot's largest, of every discrete motion."""


class DiscreteActions(gymnasium.ActionWrapper[Any, np.int64, NDArray[np.float32]]):
    """Offers the motions of `MOTIONS` by number, and "declare" as the last one where arrival is declared.

    Attributes
    ----------
    names
        Of the actions, in the order of their numbers.
    """

    def __init__(self, env: gymnasium.Env[Any, NDArray[np.float32]]) -> None:
        super().__init__(env)
        space: spaces.Space[Any] = env.action_space
        if not isinstance(space, spaces.Box) or space.shape not in ((2,), (3,)):
            raise TypeError(f"the action space is {space}, expected a Box of speed, turn rate and maybe a declaration")
        declares = space.shape == (3,)
        rows = [(*motion, -1.0)[: space.shape[0]] for motion in MOTIONS.values()]
        self.names = (*MOTIONS, "declare") if declares else tuple(MOTIONS)
        self._actions = np.array([*rows, (0.0, 0.0, 1.0)] if declares else rows, dtype=np.float32)
        self.action_space = spaces.Discrete(len(self.names))

    def action(self, action: np.int64) -> NDArray[np.float32]:
        """Return the continuous action with this number.

        Raises
        ------
        ValueError
            For anything but the number of an action.
        """
        return self._actions[read_choice(action, len(self._actions))].copy()
