"""The observation: the belief as a flat dictionary of fixed-size arrays, and the names of their columns.

Tables (`regions`, `links`) and the covariance are flattened row by row, because Stable-Baselines3 and RLlib take
one-dimensional boxes only; `region_table` and `link_table` give them their rows back.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from regionslam_env import tables
from regionslam_env.config import RobotConfig
from regionslam_env.errors import ConfigError
from regionslam_env.missions.mission import Explore, GoTo, Instruction, Return, goal_of
from slam.belief import Belief
from slam.jit import njit
from slam.motion import Odometry

Observation = dict[str, NDArray[Any]]

LINK_COLUMNS = 4
LINKS_PER_SLOT = 4
COVARIANCE_LIMIT = 1e4
"""Entries of the pose's covariance are clipped to this, m² and rad²."""


INSTRUCTIONS = (GoTo, Explore, Return)
"""Kinds of instructions, in the order in which `progress` tells which one is to be followed."""


class ProgressColumn(IntEnum):
    """Entries of `progress`: shares of the episode's steps and of the instructions, then one-hot what to do now."""

    ELAPSED = 0
    COMPLETED = 1
    DECLARED = 2
    GO_TO = 3
    EXPLORE = 4
    RETURN = 5


class RegionColumn(IntEnum):
    """Columns of a region's row: main rectangle and subrectangles (Fig. 1) in the robot's frame, states, beliefs.

    From `TYPES` on there is one column for every semantic type.
    """

    X = 0
    Y = 1
    COS = 2
    SIN = 3
    W = 4
    H = 5
    LEFT_W = 6
    LEFT_H = 7
    LEFT_Y = 8
    RIGHT_W = 9
    RIGHT_H = 10
    RIGHT_Y = 11
    OPEN_T = 12
    OPEN_B = 13
    OPEN_L = 14
    OPEN_R = 15
    OPEN_TL = 16
    OPEN_BL = 17
    OPEN_LL = 18
    OPEN_TR = 19
    OPEN_BR = 20
    OPEN_RR = 21
    EXISTENCE = tables.EXISTENCE
    TYPE_P = tables.TYPE_P
    VISITED = tables.VISITED
    CONTAINS_ME = tables.CONTAINS_ME
    TYPES = tables.TYPES


class LinkColumn(IntEnum):
    """Columns of a link's row; the slots are places in the table of regions."""

    FIRST = 0
    SECOND = 1
    PROBABILITY = 2
    KIND = 3


class LinkKind(IntEnum):
    """Kinds of links: a passage between two regions, or the second inside the first."""

    ADJACENCY = 0
    CONTAINMENT = 1


def region_table(observation: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
    """Return the rows of the regions, shape (slots, columns of `RegionColumn`); a view of the observation."""
    return observation["regions"].reshape(len(observation["regions_mask"]), -1)


def link_table(observation: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
    """Return the rows of the links, shape (4 slots, columns of `LinkColumn`); a view of the observation."""
    return observation["links"].reshape(-1, LINK_COLUMNS)


def observation_space(
    n_slots: int, n_types: int, robot: RobotConfig, n_lidar_rays: int, lidar_range: float
) -> spaces.Dict:
    """Return the space of observations.

    Parameters
    ----------
    n_slots
        Rows for regions.
    n_types
        Number of semantic types.
    robot
        Bounds the velocities: twice the largest, because they are measured.
    n_lidar_rays, lidar_range
        Of the lidar; m.
    """

    def box(low: Any, high: Any, shape: tuple[int, ...] | None = None) -> spaces.Box:
        return spaces.Box(np.float32(low), np.float32(high), shape, np.float32)

    length = tables.LENGTH_LIMIT
    region_low = np.zeros(RegionColumn.TYPES + n_types)
    region_high = np.ones(RegionColumn.TYPES + n_types)
    region_low[[RegionColumn.COS, RegionColumn.SIN]] = -1
    region_high[RegionColumn.X : RegionColumn.OPEN_T] = length
    region_high[[RegionColumn.COS, RegionColumn.SIN]] = 1
    region_low[[RegionColumn.X, RegionColumn.Y, RegionColumn.LEFT_Y, RegionColumn.RIGHT_Y]] = -length
    n_links = LINKS_PER_SLOT * n_slots
    velocity = 2 * np.array([robot.max_speed, robot.max_turn_rate])
    pose = np.array([length, length, 1, 1])
    return spaces.Dict(
        {
            "pose": box(-pose, pose),
            "pose_cov": box(-COVARIANCE_LIMIT, COVARIANCE_LIMIT, (9,)),
            "velocity": box(-velocity, velocity),
            "regions": box(np.tile(region_low, n_slots), np.tile(region_high, n_slots)),
            "regions_mask": spaces.MultiBinary(n_slots),
            "links": box(0, np.tile([n_slots, n_slots, 1, 1], n_links)),
            "links_mask": spaces.MultiBinary(n_links),
            "lidar": box(0, lidar_range, (n_lidar_rays,)),
            "goal": box(0, 1, (n_types,)),
            "progress": box(0, 1, (3 + len(INSTRUCTIONS),)),
        }
    )


class Observer:
    """Writes observations, each into fresh arrays, and remembers which region has which slot.

    Parameters
    ----------
    types
        Semantic types that are told apart; the last one is for all others.
    n_slots
        Rows for regions.
    robot
        For the duration of a step and the bounds of the velocities.
    n_lidar_rays, lidar_range
        Of the lidar; m.
    """

    def __init__(
        self, types: Sequence[str], n_slots: int, robot: RobotConfig, n_lidar_rays: int, lidar_range: float
    ) -> None:
        self.types = tuple(types)
        self.space = observation_space(n_slots, len(self.types), robot, n_lidar_rays, lidar_range)
        self._limits = np.array([robot.step, 2 * robot.max_speed, 2 * robot.max_turn_rate, lidar_range])
        self._sizes = {key: space.shape[0] for key, space in self.space.items() if space.shape}
        self._regions_shape = (n_slots, tables.TYPES + len(self.types))
        self._links_shape = (LINKS_PER_SLOT * n_slots, LINK_COLUMNS)
        self._ids = np.full(n_slots, -1)
        self._places = np.full(n_slots, -1)
        self._type_columns = np.zeros(0, np.int64)
        self._goal = self._kind = 0

    def aim(self, instruction: Instruction) -> None:
        """Set what is to be done now."""
        goal = goal_of(instruction)
        self._goal = -1 if goal is None else self.types.index(goal)
        self._kind = ProgressColumn.GO_TO + INSTRUCTIONS.index(type(instruction))

    def reset(self) -> None:
        """Begin an episode with every slot free."""
        self._ids[:] = -1
        self._places[:] = -1
        self._type_columns = np.zeros(0, np.int64)

    @property
    def limits(self) -> NDArray[np.float64]:
        """What `write_senses` clips to."""
        return self._limits

    @property
    def aimed(self) -> tuple[int, int]:
        """Column of the type to go to, -1 for none, and column of `progress` that tells the kind of instruction."""
        return self._goal, self._kind

    def slots(self, types: Sequence[str]) -> tuple[NDArray[np.int64], ...]:
        """Return ids and places of the rows' regions, and the columns of the filter's types: what kernels share."""
        if len(types) != len(self._type_columns):
            self._learn_types(types)
        return self._ids, self._places, self._type_columns

    @property
    def slot_ids(self) -> NDArray[np.int64]:
        """Id of the region in each slot, -1 for none (a copy)."""
        return self._ids.copy()

    def observe(
        self,
        belief: Belief,
        odometry: Odometry,
        ranges: NDArray[np.float64],
        elapsed: float,
        completed: float,
        declared: bool,
    ) -> Observation:
        """Return the observation of a moment.

        Parameters
        ----------
        belief
            About pose and map.
        odometry
            Of the last step.
        ranges
            Of the lidar, m.
        elapsed, completed
            Shares of the episode that has passed and of the instructions that are done.
        declared
            Whether the last action declared so.
        """
        ids, places, columns = self.slots(belief.types)
        size = self._sizes
        regions, links = np.zeros(self._regions_shape, np.float32), np.zeros(self._links_shape, np.float32)
        observation: Observation = {  # in the order of the space, which sorts its keys
            "goal": np.zeros(size["goal"], np.float32),
            "lidar": np.empty(size["lidar"], np.float32),
            "links": links.reshape(-1),
            "links_mask": np.zeros(size["links_mask"], np.int8),
            "pose": np.empty(4, np.float32),
            "pose_cov": np.empty(9, np.float32),
            "progress": np.zeros(size["progress"], np.float32),
            "regions": regions.reshape(-1),
            "regions_mask": np.zeros(size["regions_mask"], np.int8),
            "velocity": np.empty(2, np.float32),
        }
        write_senses(
            observation["pose"],
            observation["pose_cov"],
            observation["velocity"],
            observation["lidar"],
            observation["goal"],
            observation["progress"],
            belief.pose_mean,
            belief.pose_cov,
            ranges,
            self._limits,
            odometry.distance,
            odometry.rotation,
            self._goal,
            self._kind,
            elapsed,
            completed,
            declared,
        )
        tables.write_map(
            regions,
            observation["regions_mask"],
            links,
            observation["links_mask"],
            ids,
            places,
            belief.pose,
            belief.heaviest,
            belief.particles,
            tuple(belief.maps),
            columns,
            len(self.types),
            self._goal,
            belief.confirmed_after,
        )
        return observation

    def _learn_types(self, known: Sequence[str]) -> None:
        """Map the filter's types, which grow with what it meets, to those of the observation."""
        other = len(self.types) - 1
        self._type_columns = np.array([self.types.index(t) if t in self.types else other for t in known], np.int64)


def observed_types(types: Sequence[str]) -> tuple[str, ...]:
    """Return the types an observation tells apart: those given, with "other" as the last one.

    Raises
    ------
    ConfigError
        For no types at all, or the same one twice.
    """
    if not isinstance(types, Sequence) or isinstance(types, str) or not all(isinstance(t, str) and t for t in types):
        raise ConfigError(f"semantic_types is {types!r}, expected a sequence of names")
    named = tuple(t for t in types if t != "other")
    if not named or len(set(named)) < len(named):
        raise ConfigError(f"semantic_types is {types!r}, expected at least one name and none of them twice")
    return (*named, "other")


@njit
def write_senses(
    pose: NDArray[np.float32],
    pose_cov: NDArray[np.float32],
    velocity: NDArray[np.float32],
    lidar: NDArray[np.float32],
    goal: NDArray[np.float32],
    progress: NDArray[np.float32],
    mean: NDArray[np.float64],
    covariance: NDArray[np.float64],
    ranges: NDArray[np.float64],
    limits: NDArray[np.float64],
    distance: float,
    rotation: float,
    goal_type: int,
    kind: int,
    elapsed: float,
    completed: float,
    declared: bool,
) -> None:
    """Write all of an observation but the map; `limits`: step, velocities and range of the lidar."""
    pose[0], pose[1] = tables.clip(mean[0], tables.LENGTH_LIMIT), tables.clip(mean[1], tables.LENGTH_LIMIT)
    pose[2], pose[3] = math.cos(mean[2]), math.sin(mean[2])
    for i in range(3):
        for j in range(3):
            pose_cov[3 * i + j] = tables.clip(covariance[i, j], COVARIANCE_LIMIT)
    velocity[0] = tables.clip(distance / limits[0], limits[1])
    velocity[1] = tables.clip(rotation / limits[0], limits[2])
    for i in range(len(lidar)):
        lidar[i] = min(limits[3], max(0.0, ranges[i]))
    if goal_type >= 0:
        goal[goal_type] = 1
    progress[0], progress[1], progress[2] = elapsed, completed, declared
    progress[kind] = 1
