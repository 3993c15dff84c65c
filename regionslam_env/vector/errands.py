"""Steps of many robots that go to a place, judged together as long as nothing ends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.tasks.goto import GoToTask

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]
Terms = tuple[Flags, dict[str, Floats]]
"""Whose terms of the reward there are, shape (N,), and the terms by name, each of shape (N,)."""


class Errands:
    """The tasks of environments that go to a place.

    Parameters
    ----------
    envs
        Environments with a `GoToTask`, of the same arguments.
    """

    def __init__(self, envs: Sequence[SemanticNavigationEnv]) -> None:
        self._envs = envs
        self._remaining, self._stayed = np.zeros(len(envs)), np.zeros(len(envs), np.int64)

    def load(self, i: int) -> None:
        """Take over the state of a task."""
        approach = self._task(i).approach
        self._remaining[i], self._stayed[i] = approach.remaining, approach.stayed

    def store(self, i: int) -> None:
        """Bring a task up to date."""
        approach = self._task(i).approach
        approach.remaining, approach.stayed = float(self._remaining[i]), int(self._stayed[i])

    def _task(self, i: int) -> GoToTask:
        task = self._envs[i].task
        assert isinstance(task, GoToTask)
        return task

    def judge(self, which: Ints, copies: NDArray[Any], declared: Flags) -> tuple[Ints, Floats, Terms]:
        """Judge the steps that end nothing; return whose these are, their rewards (N,) and their terms.

        Parameters
        ----------
        which
            Robots that have stepped.
        copies
            All robots: `COPY`.
        declared
            Which of them have declared to be there, shape (N,).
        """
        n, task, env = len(self._envs), self._task(0), self._envs[0]
        way, before = copies["way"][which], self._remaining[which]
        stayed = np.where(way <= 0, self._stayed[which] + 1, 0)
        arrives = (stayed >= task.approach.steps_to_stay) & (not task.settings.declares)
        goes_on = ~(arrives | declared[which] | (copies["steps"][which] >= env.max_steps))
        now = np.where(way > 0, way, 0.0)
        now = np.where(np.isfinite(now), now, before)  # squeezed against something: no nearer, no farther
        them, weights = which[goes_on], task.rewards
        collided = copies["collided"][them]
        values: dict[str, Any] = {
            "progress": weights.progress * (before - now)[goes_on],
            "success": 0.0,
            "time": weights.time,
            "collision": np.where(collided, weights.collision, 0.0),
            "false_arrival": 0.0,
        }
        self._remaining[them], self._stayed[them] = now[goes_on], stayed[goes_on]
        rewards, whose = np.zeros(n), np.zeros(n, np.bool_)
        terms: dict[str, Floats] = {}
        whose[them] = True
        for name, value in values.items():
            terms[name] = np.zeros(n)
            terms[name][them] = value
            rewards[them] += value
        return them, rewards, (whose, terms)
