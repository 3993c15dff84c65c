"""Where an episode takes place and what is to be done there: the one world there is, or one drawn with its mission."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from regionslam_env.errors import ConfigError, listed, unknown
from regionslam_env.missions.mission import Mission
from regionslam_env.tasks.start import Pose
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
    mission
        That of every episode; None: drawn for each.

    Attributes
    ----------
    task
        The task in the world of the last mission; before the first one, in world number 0.

    Raises
    ------
    ConfigError
        For a mission to what the only world there is does not have.
    """

    def __init__(self, worlds: WorldSource, task_in: Callable[[World], Task], mission: Mission | None) -> None:
        self._worlds, self._task_in, self._mission = worlds, task_in, mission
        self.task = task_in(worlds.world(0))
        self._number: int | None = None
        self._chosen(None)

    def draw(
        self,
        rng: np.random.Generator,
        world_rng: np.random.Generator,
        mission: Mission | None = None,
        start: Sequence[float] | None = None,
        number: int | None = None,
    ) -> tuple[DrawnMission, int | None]:
        """Draw what is not given; return the mission and the world's number within its split, if it has one.

        Raises
        ------
        ConfigError
            Where a goal cannot be reached, the start is not free, no place is far enough from the goal, or the world
            has no number.
        """
        mission = self._chosen(mission)
        if self._worlds.kind is None:
            if number is not None:
                name = self.task.world.name
                raise ConfigError(f"world_seed is {number!r}, expected none: world {name!r} is always the same")
            return self.task.draw(rng, mission, start), None
        if number is not None or start is not None:
            return self._enter(int(world_rng.integers(PER_SPLIT)) if number is None else number, rng, mission, start)
        seen: set[str] = set()
        for _ in range(WORLD_TRIES):
            tried = int(world_rng.integers(PER_SPLIT))
            try:
                return self._enter(tried, rng, mission, None)
            except ConfigError as error:
                last = error
                seen |= set(self._worlds.world(tried).types)
        none = f"none of {WORLD_TRIES} worlds of kind {self._worlds.kind!r}"
        for region_type in () if mission is None else mission.types:
            if region_type not in seen:
                raise ConfigError(f"{none} has a {region_type!r}: expected one of {listed(seen)}")
        raise ConfigError(f"{none} will do; the last one: {last}")

    def stay(
        self,
        rng: np.random.Generator,
        pose: Pose,
        home: Pose,
        mission: Mission | None = None,
        start: Sequence[float] | None = None,
        number: int | None = None,
    ) -> tuple[DrawnMission, int | None]:
        """Draw another mission in the world of the last one; without a start, the robot stays at its pose there.

        Parameters
        ----------
        pose, home
            The robot's, and the one at which the map was begun.

        Raises
        ------
        ConfigError
            As in `draw`, and for the number of another world.
        """
        if number != self._number and number is not None:
            here = self._number if self._number is not None else repr(self.task.world.name)
            raise ConfigError(f"world_seed is {number!r}, expected that of the map to keep: {here}")
        mission = self._chosen(mission)
        standing = start is None
        drawn = self.task.draw(rng, mission, pose if standing else start, standing=standing, home=home)
        return drawn, self._number

    def _chosen(self, mission: Mission | None) -> Mission | None:
        """Return the mission to give, the one of all episodes where none is given."""
        mission = self._mission if mission is None else mission
        if mission is not None and self._worlds.kind is None:
            _check(mission, self.task.world)
        return mission

    def _enter(
        self, number: int, rng: np.random.Generator, mission: Mission | None, start: Sequence[float] | None
    ) -> tuple[DrawnMission, int]:
        """Draw a mission in a world of this number, which becomes that of the task unless there is none."""
        world = self._worlds.world(number)
        if mission is not None:
            _check(mission, world)
        task = self.task if world is self.task.world else self._task_in(world)
        drawn = task.draw(rng, mission, start)
        self.task, self._number = task, number
        return drawn, number


def _check(mission: Mission, world: World) -> None:
    for region_type in mission.types:
        if region_type not in world.types:
            raise ConfigError(f"world {world.name!r}: {unknown('goal', region_type, world.types)}")
