"""A scripted expert: plans on the believed map, explores what it does not know, drives on lidar.

It reads the observation alone. Nothing is drawn at random: the same observations give the same actions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from agents.believed import BelievedRegion, View
from agents.planner import DEPTH, DEPTH_SHARE, Planner, Target
from agents.progress import Progress
from agents.terrain import Terrain
from regionslam_env.config import SEMANTIC_TYPES, RobotConfig
from regionslam_env.control.controller import LocalController
from slam.rows import Floats

SURE = 0.95
"""Probability of being inside, and of type and existence, from which the robot believes that it has arrived."""
CONFIRMATIONS = 5
"""Consecutive steps for which it has to believe so before it declares."""
FIRST_LOOK = 20
"""Steps of standing still at the start: at rest the pose is certain, and the regions on whose headings the whole map
will hang are measured many times."""
LOST = 0.5
"""Standard deviation of the position (m) above which it declares nothing."""
HOME = 0.5
"""Distance from the start (m) within which the robot has returned."""
AT_A_GOAL = 30
"""Steps for which it stands at a goal without being sure."""
AT_A_DOOR = 150
"""Steps for which it waits before a shut door."""
VERBS = {
    "goal": "driving to",
    "approach": "looking for the way to",
    "explore": "exploring:",
    "door": "waiting for",
}
"""What it does about a target, by its kind."""
WAY_POINT = 2.0
"""Length of the way (m) handed to the local controller."""


class ScriptedAgent:
    """Goes to a region of the wanted type, or back to the start, or explores until no way leads to unknown rooms.

    Parameters
    ----------
    observation_space, action_space
        Of the environment: a Dict as in `regionslam_env.observations`, and Box(2), or Box(3) where arrival is declared.
    semantic_types
        Types in the order of the observation's columns.
    robot
        Radius and limits of the robot.
    sight
        Range of the region sensor, m.
    """

    def __init__(
        self,
        observation_space: spaces.Dict,
        action_space: spaces.Box,
        semantic_types: Sequence[str] = SEMANTIC_TYPES,
        robot: RobotConfig | None = None,
        sight: float = 8.0,
    ) -> None:
        lidar = observation_space["lidar"]
        goal = observation_space["goal"]
        assert isinstance(lidar, spaces.Box) and isinstance(goal, spaces.Box)
        if len(semantic_types) != goal.shape[0]:
            raise ValueError(f"semantic_types has {len(semantic_types)} names, the observation {goal.shape[0]}")
        n_rays, max_range = lidar.shape[0], float(lidar.high[0])
        self._types = tuple(semantic_types)
        self._declares = action_space.shape[0] == 3
        self.controller = LocalController(robot or RobotConfig(), n_rays, max_range)
        self.terrain = Terrain(n_rays, max_range, min(sight, max_range) - 1.0, self.controller.touch)
        self.planner = Planner(self.terrain)
        self.reset()

    def reset(self) -> None:
        """Begin an episode."""
        self.terrain.reset()
        self._time = 0
        self._completed = 0.0
        self._words = "starting"
        self._follow()

    def _follow(self) -> None:
        """Begin an instruction: what the floor looks like stays known, all decisions are made anew."""
        self.planner.reset()
        self.target: Target | None = None
        self.route: Floats = np.zeros((0, 2))
        self._progress = Progress()
        self._due = self._route_due = 0  # when to decide anew
        self._confirmations = 0
        self._waiting = 0  # steps spent standing at the target
        self._seen_all = False

    def say(self) -> str:
        """Return in words what the robot is doing."""
        return self._words

    def act(self, observation: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Return the next action for an observation."""
        view = View(observation, self._types)
        if view.completed != self._completed:
            self._completed = view.completed
            self._follow()
        ranges = np.asarray(observation["lidar"], dtype=np.float64)
        self.terrain.insert(view.pose, ranges)
        drive = self._drive(view, ranges)
        arrived = self._arrived(view) or (self._declares and self._seen_all)
        if arrived and (self._declares or self.target is None or self.target.kind != "goal"):
            self._words = _arrival(view)
            drive = np.zeros(2)
        self._time += 1
        if self._declares:
            drive = np.append(drive, 1.0 if arrived else -1.0)
        return drive.astype(np.float32)

    def _drive(self, view: View, ranges: Floats) -> Floats:
        """Return the speeds towards the target, which is chosen anew when due."""
        if self._time < FIRST_LOOK:
            self._words = "taking a first look"
            return np.zeros(2)
        self._decide(view)
        if self.target is None:
            self._words = "looking around"
            return np.array([0.0, 0.5])
        if self._time >= self._route_due or len(self.route) == 0:
            self.route = self.terrain.route(view.pose[:2], self.target.point)
            self._route_due = self._time + 10
        way_point, last = self._way_point(view)
        if self._progress.recovering:
            self._words = "backing off"
            return self._progress.escape(self.controller, ranges)
        if last and self.target.kind in ("goal", "door") and np.hypot(*(way_point - view.pose[:2])) < 0.15:
            return self._wait(AT_A_DOOR if self.target.kind == "door" else AT_A_GOAL)
        action = self.controller.drive(view.to_robot(way_point), ranges, final=last)
        remaining = _length(self.route) + float(np.hypot(*(self.target.point - self.route[-1])))
        if self._progress.stuck(remaining, self.controller.blocked):
            self.planner.avoid(self.target)
            self._due = self._time + 1
            self.target = None
        return action

    def _decide(self, view: View) -> None:
        """Choose the target anew where it is due, or where the frontier has been resolved."""
        current = self.target
        resolved = current is not None and current.kind != "goal" and self.planner.resolved(current, view)
        if not resolved and self._time < self._due:
            return
        if resolved and current is not None and np.hypot(*(current.point - view.pose[:2])) < 0.5:
            self.planner.avoid(current, radius=0.3)  # what is left unseen there cannot be seen from there
        target = self.planner.decide(view, current)
        if target is not None and (current is None or np.hypot(*(target.point - current.point)) > 0.5):
            self._progress.restart()
        self.target = target
        self._seen_all = view.goal is None and not view.returns and not self.planner.leads_on
        self.route = np.zeros((0, 2))
        self._due = self._time + (10 if target is not None and target.kind == "goal" else 20)
        if target is not None:
            self._words = f"{VERBS[target.kind]} {target.place}"

    def _way_point(self, view: View) -> tuple[Floats, bool]:
        """Return the point of the route to steer for, and whether it is the last one."""
        lengths = np.hypot(*(self.route - view.pose[:2]).T)
        nearest = int(np.argmin(lengths))
        along = np.cumsum(np.hypot(*np.diff(self.route[nearest:], axis=0, prepend=view.pose[None, :2]).T))
        beyond = np.flatnonzero(along > WAY_POINT)
        if len(beyond):
            return self.route[nearest + int(beyond[0])], False
        assert self.target is not None
        reached = np.hypot(*(self.route[-1] - self.target.point)) < 0.2
        return (self.target.point if reached else self.route[-1]), True

    def _wait(self, steps: int) -> Floats:
        """Stand at the goal until sure, or before a door until it opens; after so many steps, try another spot."""
        self._waiting += 1
        if self._waiting > steps and self.target is not None:
            self._waiting = 0
            self.planner.avoid(self.target, radius=0.4, for_good=self.target.kind == "door")
            self._due = self._time + 1
        return np.zeros(2)

    def _arrived(self, view: View) -> bool:
        """Tell whether the robot has believed for some steps that it is well inside the place where it has to be."""
        if view.returns:
            inside = float(np.hypot(*view.pose[:2])) < HOME
        else:
            inside = any(_well_inside(r, view.pose) for r in view.goal_regions())
        inside = inside and view.position_sigma < LOST
        self._confirmations = self._confirmations + 1 if inside else 0
        return self._confirmations >= CONFIRMATIONS


def _arrival(view: View) -> str:
    """Return in words what the robot has done."""
    if view.returns:
        return "back at the start"
    return "done exploring" if view.goal is None else f"arrived in the {view.goal}"


def _well_inside(region: BelievedRegion, pose: Floats) -> bool:
    """Tell whether the robot is surely in a region that is surely there, not just across its edge."""
    if region.contains_me < SURE or region.existence < SURE or region.goal_p < 0.8:
        return False
    return bool(region.depth(pose[None, :2])[0] >= 0.7 * min(DEPTH, DEPTH_SHARE * region.extent))


def _length(route: Floats) -> float:
    return float(np.sum(np.hypot(*np.diff(route, axis=0).T)))
