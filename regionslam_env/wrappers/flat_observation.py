"""The observation as one plain vector."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from regionslam_env.observations import Observation


class FlatObservation(gymnasium.ObservationWrapper[NDArray[np.float32], Any, Observation]):
    """Gives every part of an observation, one after the other in the order of the space, as one float32 vector.

    Parameters
    ----------
    env
        With a `Dict` of one-dimensional `Box` and `MultiBinary` spaces.
    """

    def __init__(self, env: gymnasium.Env[Observation, Any]) -> None:
        super().__init__(env)
        space: spaces.Space[Any] = env.observation_space
        if not isinstance(space, spaces.Dict):
            raise TypeError(f"the observation space is {space}, expected a Dict")
        self._keys = tuple(space)
        low = [part.low if isinstance(part, spaces.Box) else np.zeros(part.shape or ()) for part in space.values()]
        high = [part.high if isinstance(part, spaces.Box) else np.ones(part.shape or ()) for part in space.values()]
        self.observation_space = spaces.Box(
            np.concatenate(low, dtype=np.float32), np.concatenate(high, dtype=np.float32), dtype=np.float32
        )

    def observation(self, observation: Observation) -> NDArray[np.float32]:
        """Return the observation as one vector."""
        return np.concatenate([observation[key] for key in self._keys], dtype=np.float32)
