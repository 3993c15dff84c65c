"""Other environments, to be timed in the same run where they are installed."""

from __future__ import annotations

import importlib
import importlib.util
from contextlib import suppress
from typing import Any

import gymnasium
from gymnasium.error import DependencyNotInstalled

PEERS = {
    "MiniGrid-MultiRoom-N6-v0": "minigrid",
    "PointMaze_UMaze-v3": "gymnasium_robotics",
}
"""Ids that users compare with, and the modules that register them."""


class Peer:
    """Another environment under random actions that were sampled beforehand.

    Parameters
    ----------
    env_id
        One of `PEERS`, whose module is installed.
    steps
        Of a `drive`.
    seed
        Of the environment and the actions.
    """

    def __init__(self, env_id: str, steps: int, seed: int = 0) -> None:
        gymnasium.register_envs(importlib.import_module(PEERS[env_id]))
        self._env = gymnasium.make(env_id)
        self._env.reset(seed=seed)
        self._env.action_space.seed(seed)
        self._actions: list[Any] = [self._env.action_space.sample() for _ in range(steps)]
        for action in self._actions[:50]:
            self._step(action)

    def drive(self) -> None:
        """Take all actions, with resets where episodes end."""
        for action in self._actions:
            self._step(action)

    def _step(self, action: Any) -> None:
        _, _, terminated, truncated, _ = self._env.step(action)
        if terminated or truncated:
            self._env.reset()

    def close(self) -> None:
        """Close the environment."""
        self._env.close()


def installed_peers(steps: int) -> dict[str, Peer]:
    """Return the peers that are installed, by id, each to take so many steps at a time."""
    peers = {}
    for env_id, module in PEERS.items():
        if importlib.util.find_spec(module):
            with suppress(DependencyNotInstalled):  # PointMaze without its engine
                peers[env_id] = Peer(env_id, steps)
    return peers
