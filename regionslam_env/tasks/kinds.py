"""The tasks there are, by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from regionslam_env.tasks.explore import ExploreTask
from regionslam_env.tasks.goto import GoToTask
from regionslam_env.tasks.task import Task, TaskSettings
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import World

TASKS: Mapping[str, type[GoToTask] | type[ExploreTask]] = {"goto": GoToTask, "explore": ExploreTask}


def task_in(world: World, kind: str, radius: float, settings: TaskSettings) -> Task:
    """Return the task of a kind in a world, for a robot of a radius, m."""
    return TASKS[kind](world, _geodesic(world, radius), settings)


@lru_cache(maxsize=8)
def _geodesic(world: World, radius: float) -> Geodesic:
    """Return the shortest distances in a world, shared by every environment that uses it: worlds are immutable."""
    return Geodesic(world, radius)
