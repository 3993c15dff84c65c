"""Where an episode takes place and what is to be done there: the one world there is, or one drawn with its mission."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from regionslam_env.errors import ConfigError, unknown
from regionslam_env.tasks.task import DrawnMission, Task
from regionslam_env.worlds.source import PER_SPLIT, WorldSource
from regionslam_env.worlds.world import World

WORLD_TRIES = 100
"""Worlds of a kind that are drawn until one has the goal and a place to start from."""


class MissionSource:
    """Draws a world, where they are drawn, and a mission in it.

    Parameters
    ----------
    worlds
        Where worlds come from.
    task_in
        Returns the task in a world.
    goal
        The goal type of every episode; None: drawn for each.
    types
        What a goal can be.

    Attributes
    ----------
    task
        The task in the world of the last mission; before the first one, in world number 0.

    Raises
    ------
    ConfigError
        For a goal that cannot be one.
    """

    def __init__(
        self, worlds: WorldSource, task_in: Callable[[World], Task], goal: str | None, types: Sequence[str]
    ) -> None:
        self._worlds, self._task_in, self._goal, self._types = worlds, task_in, goal, tuple(types)
        self.task = task_in(worlds.world(0))
        self._number: int | None = None
        if goal is not None:
            self._check(goal)

    def draw(
        self,
        rng: np.random.Generator,
        world_rng: np.random.Generator,
        goal: str | None = None,
        start: Sequence[float] | None = None,
        number: int | None = None,
    ) -> tuple[DrawnMission, int | None]:
        """Draw what is not given; return the mission and the world's number within its split, if it has one.

        Raises
        ------
        ConfigError
            Where the goal cannot be reached, the start is not free, no place is far enough from the goal, or the world
            has no number.
        """
        goal = self._checked(goal)
        if self._worlds.kind is None:
            if number is not None:
                name = self.task.world.name
                raise ConfigError(f"world_seed is {number!r}, expected none: world {name!r} is always the same")
            return self.task.draw(rng, goal, start), None
        if number is not None or start is not None:
            return self._enter(int(world_rng.integers(PER_SPLIT)) if number is None else number, rng, goal, start)
        for _ in range(WORLD_TRIES):
            try:
                return self._enter(int(world_rng.integers(PER_SPLIT)), rng, goal, None)
            except ConfigError as error:
                last = error
        raise ConfigError(f"none of {WORLD_TRIES} worlds of kind {self._worlds.kind!r} will do; the last one: {last}")

    def stay(
        self,
        rng: np.random.Generator,
        pose: Sequence[float],
        goal: str | None = None,
        start: Sequence[float] | None = None,
        number: int | None = None,
    ) -> tuple[DrawnMission, int | None]:
        """Draw another mission in the world of the last one; without a start, the robot stays at its pose there.

        Raises
        ------
        ConfigError
            As in `draw`, and for the number of another world.
        """
        if number != self._number and number is not None:
            here = self._number if self._number is not None else repr(self.task.world.name)
            raise ConfigError(f"world_seed is {number!r}, expected that of the map to keep: {here}")
        goal = self._checked(goal)
        standing = start is None
        return self.task.draw(rng, goal, pose if standing else start, standing=standing), self._number

    def _checked(self, goal: str | None) -> str | None:
        """Return the goal to look for, the one of all missions where none is given."""
        goal = self._goal if goal is None else goal
        if goal is not None:
            self._check(goal)
        return goal

    def _enter(
        self, number: int, rng: np.random.Generator, goal: str | None, start: Sequence[float] | None
    ) -> tuple[DrawnMission, int]:
        """Draw a mission in a world of this number, which becomes that of the task unless there is none."""
        world = self._worlds.world(number)
        if goal is not None and goal not in world.types:
            raise ConfigError(f"world {world.name!r}: {unknown('goal', goal, set(world.types) & set(self._types))}")
        task = self.task if world is self.task.world else self._task_in(world)
        mission = task.draw(rng, goal, start)
        self.task, self._number = task, number
        return mission, number

    def _check(self, goal: str) -> None:
        if not self.task.takes_goal:
            raise ConfigError(f"goal is {goal!r}, expected none: this task looks for no type of region")
        known = set(self._types)
        if self._worlds.kind is None:
            known &= set(self.task.world.types)
        if goal not in known:
            name = self._worlds.kind or self.task.world.name
            raise ConfigError(f"world {name!r}: {unknown('goal', goal, known)}")
