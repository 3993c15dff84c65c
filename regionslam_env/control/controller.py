"""Drives to a point on lidar alone: through doors, around furniture, without touching anything.

Every call plans afresh on the current scan (`window`, `search`) and follows the path's farthest point in plain sight
(`pursuit`). Nothing is remembered, so the same inputs give the same action.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from regionslam_env.config import RobotConfig
from regionslam_env.control.pursuit import look_ahead, pursue
from regionslam_env.control.search import search, trace
from regionslam_env.control.window import Window, driving_cost, obstacle_points
from slam.rows import Floats

WALL = 0.05
"""Walls and furniture are this much thicker in the simulation than lidar and map say, m."""


class LocalController:
    """Gets to a point in the robot's surroundings.

    Parameters
    ----------
    robot
        Radius and limits of the robot.
    n_rays, max_range
        Number of rays of its lidar and their reach (m).
    window
        The grid it plans on.
    margin
        Distance kept to obstacles beyond the robot's radius where it can be helped at all, m.

    Attributes
    ----------
    blocked : bool
        After `drive`: no way towards the target is in sight.
    clearance : float
        Distance from the robot's centre to the nearest obstacle in the last scan, m.
    path : ndarray
        Planned path in the robot's frame, shape (k, 2), m.
    """

    def __init__(
        self,
        robot: RobotConfig | None = None,
        n_rays: int = 180,
        max_range: float = 10.0,
        window: Window | None = None,
        margin: float = 0.03,
    ) -> None:
        self.robot = robot or RobotConfig()
        self.window = window or Window(n_rays=n_rays)
        self.max_range = max_range
        self.touch = self.robot.radius + WALL
        self.forbidden = self.touch + margin
        self.comfortable = self.touch + 0.5
        angles = self.window.angles()
        self._directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        self._ray, self._distance = self.window.polar()
        shape = (self.window.size, self.window.size)
        self._cost, self._reach = np.empty(shape, np.float32), np.empty(shape, np.float32)
        self._parent = np.empty(shape, np.int32)
        self._points = np.empty((8 * n_rays, 2))
        self.blocked = False
        self.clearance = np.inf
        self.path: Floats = np.zeros((1, 2))

    def drive(self, target: ArrayLike, ranges: ArrayLike, final: bool = False) -> Floats:
        """Return the next action, forward and turning speed in [-1, 1], on the way to a point.

        Parameters
        ----------
        target
            Where to, x and y in the robot's frame, m; any distance.
        ranges
            Lidar ranges, shape (n_rays,), m; the maximum where nothing was hit.
        final
            Stop at the target; otherwise it is a way point to be passed at speed.
        """
        goal_x, goal_y = (float(v) for v in np.asarray(target, dtype=np.float64))
        points = self._look(np.asarray(ranges, dtype=np.float64))
        self.path = self._plan(goal_x, goal_y)
        short = float(np.hypot(goal_x - self.path[-1, 0], goal_y - self.path[-1, 1]))
        inside = max(abs(goal_x), abs(goal_y)) < self.window.half * self.window.cell
        at_end = float(np.hypot(*self.path[-1])) < 3 * self.window.cell
        self.blocked = short > 0.5 and (inside or at_end)
        if np.hypot(goal_x, goal_y) < 0.05 or (len(self.path) == 1 and self.blocked):
            return np.zeros(2)
        length = float(np.sum(np.hypot(*np.diff(self.path, axis=0).T)))
        ahead = look_ahead(self._cost, self.path / self.window.cell + self.window.half, 1.5 / self.window.cell)
        robot = self.robot
        speed, turn = pursue(
            self.path[ahead, 0],
            self.path[ahead, 1],
            length if final or self.blocked else np.inf,
            points,
            self.touch,
            robot.max_speed,
            robot.max_turn_rate,
            robot.max_acceleration,
        )
        return np.array([speed / robot.max_speed, turn / robot.max_turn_rate])

    def turn(self, angle: float) -> Floats:
        """Return the action that turns on the spot by an angle (rad, counter-clockwise)."""
        rate = np.clip(3.0 * angle, -self.robot.max_turn_rate, self.robot.max_turn_rate)
        return np.array([0.0, rate / self.robot.max_turn_rate])

    def _look(self, ranges: Floats) -> Floats:
        """Turn the scan into obstacle points and driving costs."""
        if ranges.shape != (self.window.n_rays,):
            raise ValueError(f"ranges has shape {ranges.shape}, expected ({self.window.n_rays},)")
        gap = 2 * self.touch
        n = obstacle_points(ranges, self._directions, self.max_range - 0.1, gap, 0.1, self._points)
        points = self._points[:n]
        driving_cost(
            ranges,
            points,
            self._ray,
            self._distance,
            self.window.cell,
            self.forbidden,
            self.comfortable,
            self._cost,
        )
        self.clearance = float(np.sqrt(np.min(np.sum(points**2, axis=1)))) if n else np.inf
        return points

    def _plan(self, goal_x: float, goal_y: float) -> Floats:
        """Return the path towards the goal in the robot's frame, ending exactly on it where it is reached."""
        half, cell = self.window.half, self.window.cell
        column, row = goal_x / cell + half, goal_y / cell + half
        end = search(self._cost, self.window.centre, column, row, self._reach, self._parent)
        cells: NDArray[np.int64] = trace(self._parent, end)
        path = np.asarray((cells[:, ::-1] - half) * cell, dtype=np.float64)
        if round(column) == cells[-1, 1] and round(row) == cells[-1, 0]:
            path[-1] = goal_x, goal_y
        return path
