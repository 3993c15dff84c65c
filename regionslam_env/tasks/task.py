"""What a task is to the environment: it draws missions, judges every step on the truth, and pays for it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.errors import ConfigError
from regionslam_env.tasks.rewards import Rewards
from regionslam_env.worlds.geodesic import Field, Geodesic
from regionslam_env.worlds.world import World
from slam.belief import Belief

Pose = tuple[float, float, float]

CONTACT = 0.03
"""How far a touching robot is moved to measure its distance, m; contacts overlap by less than half of that."""


@dataclass(frozen=True)
class DrawnMission:
    """A drawn mission.

    Parameters
    ----------
    text
        In words.
    start
        Pose (x, y, theta) in the world frame, m and rad.
    goal
        Semantic type to go to; None where there is none.
    shortest
        Geodesic distance from the start into the nearest goal region, m; None without a goal.
    """

    text: str
    start: Pose
    goal: str | None
    shortest: float | None


@dataclass(frozen=True)
class TaskSettings:
    """What an environment tells its task.

    Parameters
    ----------
    types
        Semantic types that an observation can tell apart: what a goal can be.
    step
        Duration of a step, s.
    rewards
        Weights of the reward terms, of the task's own kind; None for its standard ones.
    declares
        Whether the robot declares that it is done.
    start_distance
        Least geodesic distance of a drawn start from every goal region, m.
    map_share
        Share of the reachable regions that have to be mapped.
    """

    types: Sequence[str]
    step: float = 0.1
    rewards: Rewards | None = None
    declares: bool = False
    start_distance: float = 2.0
    map_share: float = 0.9

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start_distance) and self.start_distance >= 0):
            raise ConfigError(f"start_distance is {self.start_distance!r}, expected a length of at least 0 m")
        if not (isinstance(self.map_share, int | float) and 0 < self.map_share <= 1):
            raise ConfigError(f"map_share is {self.map_share!r}, expected a share above 0 and up to 1")


class Moment(NamedTuple):
    """The end of a step.

    Parameters
    ----------
    pose
        True pose in the world frame, shape (3,).
    collided, declared
        Something held the robot back; it declared that it is done.
    belief
        About pose and map.
    origin
        Pose of the map frame in the world frame.
    last
        No step may follow.
    """

    pose: NDArray[np.float64]
    collided: bool
    declared: bool
    belief: Belief
    origin: Pose
    last: bool


class Verdict(NamedTuple):
    """What one step has brought: the named terms of its reward, and whether the mission is done or just over."""

    terms: dict[str, float]
    success: bool
    over: bool


class Task(ABC):
    """A kind of mission in one world.

    Parameters
    ----------
    world, geodesic
        The truth, and shortest distances in it.
    settings
        What the environment tells its task.
    """

    takes_goal: ClassVar[bool]
    """Whether a semantic type is looked for."""
    reward_sets: ClassVar[Mapping[str, Any]]
    """Weights of its reward terms by name, "standard" among them."""

    def __init__(self, world: World, geodesic: Geodesic, settings: TaskSettings) -> None:
        self.world, self.geodesic, self.settings = world, geodesic, settings
        self.rewards: Any = self.reward_sets["standard"] if settings.rewards is None else settings.rewards

    @abstractmethod
    def draw(
        self,
        rng: np.random.Generator,
        goal: str | None = None,
        start: Sequence[float] | None = None,
        standing: bool = False,
    ) -> DrawnMission:
        """Draw what is not given and begin the episode; a robot that is `standing` may touch something.

        Raises
        ------
        ConfigError
            For a goal or a start that cannot be one.
        """

    @abstractmethod
    def verdict(self, moment: Moment) -> Verdict:
        """Judge a step, and return its reward."""

    @property
    def remaining(self) -> float | None:
        """Geodesic distance to the goal after the last step, m; None without a goal."""
        return None

    @property
    def figures(self) -> Mapping[str, float | None]:
        """Metrics of its own after the last step, by name."""
        return {}

    def checked(self, start: Sequence[float], standing: bool) -> Pose:
        """Return a start as a pose, or refuse it."""
        values = np.asarray(start, dtype=np.float64).tolist()
        if not isinstance(values, list) or len(values) != 3 or not all(map(math.isfinite, values)):
            raise ConfigError(f"start is {start!r}, expected a pose (x, y, theta) in m, m, rad")
        x, y, theta = values
        if not standing and not self.geodesic.free(x, y):
            radius = self.geodesic.radius
            raise ConfigError(
                f"world {self.world.name!r}: start ({x:g}, {y:g}) is not free for a robot of {radius:g} m radius"
            )
        return x, y, theta


def distance_from(field: Field, start: Pose, standing: bool) -> float:
    """Return the distance from a start, m: from beside it where a standing robot is squeezed against something."""
    x, y, _ = start
    here = field.at(x, y)
    if math.isfinite(here) or not standing:
        return here
    turns = np.linspace(0, 2 * math.pi, 8, endpoint=False).tolist()
    return min(field.at(x + CONTACT * math.cos(turn), y + CONTACT * math.sin(turn)) for turn in turns)
