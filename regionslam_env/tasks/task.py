"""What a task is to the environment: it draws missions, judges every step on the truth, and pays for it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from regionslam_env.errors import ConfigError
from regionslam_env.missions.mission import Instruction, Mission
from regionslam_env.tasks.start import Pose
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.world import World
from slam.belief import Belief

if TYPE_CHECKING:
    from regionslam_env.tasks.approach import Approach


@dataclass(frozen=True)
class DrawnMission:
    """A drawn mission.

    Parameters
    ----------
    mission
        What is to be done.
    start
        Pose (x, y, theta) in the world frame, m and rad.
    shortest
        Length of the shortest way from the start, m; None where no place has to be gone to.
    """

    mission: Mission
    start: Pose
    shortest: float | None


@dataclass(frozen=True)
class TaskSettings:
    """What an environment tells every task.

    Parameters
    ----------
    types
        Semantic types that an observation can tell apart: what a goal can be.
    step
        Duration of a step, s.
    declares
        Whether the robot declares that it is done.
    """

    types: Sequence[str]
    step: float = 0.1
    declares: bool = False


class Moment(NamedTuple):
    """The end of a step.

    Parameters
    ----------
    pose
        True pose in the world frame, shape (3,).
    collided, declared
        Something held the robot back; it declared that it is done.
    believe
        Returns the belief about pose and map, which not every task asks for.
    origin
        Pose of the map frame in the world frame.
    last
        No step may follow.
    """

    pose: NDArray[np.float64]
    collided: bool
    declared: bool
    believe: Callable[[], Belief]
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
        What the environment tells every task.
    """

    option: ClassVar[str | None] = None
    """The argument, and the option of a reset, that says what is to be done; None where there is nothing to choose."""

    def __init__(self, world: World, geodesic: Geodesic, settings: TaskSettings) -> None:
        self.world, self.geodesic, self.settings = world, geodesic, settings

    @classmethod
    def read(cls, wanted: Any, types: Sequence[str]) -> Mission:
        """Return the mission that the value of `option` stands for, of places with these types.

        Raises
        ------
        ConfigError
            For a value that stands for none.
        """
        raise ConfigError(f"mission is {wanted!r}, expected none: this task is always the same")

    @abstractmethod
    def draw(
        self,
        rng: np.random.Generator,
        mission: Mission | None = None,
        start: Sequence[float] | None = None,
        *,
        standing: bool = False,
        home: Pose | None = None,
    ) -> DrawnMission:
        """Draw what is not given and begin the episode.

        Parameters
        ----------
        rng
            Of missions and starts.
        mission
            What is to be done.
        start
            Pose (x, y, theta) in the world frame, m and rad.
        standing
            Whether the robot is there already; it may touch something then.
        home
            Pose at which the map was begun; None: the start.

        Raises
        ------
        ConfigError
            For a mission or a start that cannot be one.
        """

    @abstractmethod
    def verdict(self, moment: Moment) -> Verdict:
        """Judge a step, and return its reward."""

    @abstractmethod
    def quiet_terms(self, progress: Any, collided: Any) -> dict[str, Any]:
        """Return the terms of the reward of a step, or of many, that neither ends nor explores anything.

        Parameters
        ----------
        progress
            Decrease of the way that is left, m; a number or shape (N,).
        collided
            Whether something held the robot back; the same.
        """

    @property
    def approach(self) -> Approach | None:
        """The way that the robot has to go now; None where it has no place to be."""
        return None

    @property
    @abstractmethod
    def instruction(self) -> Instruction:
        """What the robot has to do now."""

    @property
    @abstractmethod
    def completed(self) -> float:
        """Share of the instructions that are done."""

    def believed(self, belief: Belief) -> float | None:
        """Return the probability, by the belief, that the mission is done; None where the robot cannot tell."""
        return None

    @property
    def remaining(self) -> float | None:
        """Length of the way that is left after the last step, m; None where no place has to be gone to."""
        return None

    @property
    def figures(self) -> Mapping[str, float | None]:
        """Metrics of its own after the last step, by name."""
        return {}
