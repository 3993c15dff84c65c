"""Doors that close and open again."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import DynamicsConfig
from regionslam_env.worlds.world import World

Floats = NDArray[np.float64]

SPREAD = (0.5, 1.5)
"""Shortest and longest time that a door stays as it is, over the mean."""
RETRY = 1.0
"""How long a door waits (s) that could not close because something stood in it."""


class Doors:
    """Every door of a world, some of which close.

    Parameters
    ----------
    world
        The truth.
    config
        How many close, and for how long.
    step
        Duration of an environment step, s.

    Attributes
    ----------
    segments
        Every opening as a segment x0, y0, x1, y1, shape (D, 4), m.
    closed
        Which ones are closed now, shape (D,).
    """

    def __init__(self, world: World, config: DynamicsConfig, step: float) -> None:
        doors = [(door.x0, door.y0, door.x1, door.y1) for door in world.doors]
        self.segments: Floats = np.array(doors, dtype=np.float64).reshape(-1, 4)
        self._share, self._times, self._step = config.closing_doors, (config.time_open, config.time_closed), step
        self.closed = np.zeros(len(doors), dtype=bool)

    def draw(self, rng: np.random.Generator) -> None:
        """Open every door, and draw which ones close and when."""
        self._rng = rng
        count = len(self.closed)
        closing = rng.permutation(count)[: round(self._share * count)]
        self.closed[:] = False
        self._now = 0
        self._due = np.full(count, np.iinfo(np.int64).max)
        for k in np.sort(closing):
            self._due[k] = self._steps(0.0, SPREAD[1] * self._times[0])

    def step(self, is_free: Callable[[int], bool]) -> list[int]:
        """Let a step pass; return the doors that have closed or opened in it.

        Parameters
        ----------
        is_free
            Tells whether nothing stands in a door that is about to close.
        """
        self._now += 1
        changed = []
        for k in np.flatnonzero(self._due <= self._now).tolist():
            if not self.closed[k] and not is_free(k):
                self._due[k] = self._now + self._steps(RETRY, RETRY)
                continue
            self.closed[k] = not self.closed[k]
            mean = self._times[int(self.closed[k])]
            self._due[k] = self._now + self._steps(SPREAD[0] * mean, SPREAD[1] * mean)
            changed.append(k)
        return changed

    def _steps(self, shortest: float, longest: float) -> int:
        return max(1, round(self._rng.uniform(shortest, longest) / self._step))
