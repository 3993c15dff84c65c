"""Keeps what happened in an episode and draws it afterwards."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from regionslam_env.rendering import GifWriter, Renderer, Snapshot, Stop, draw_map, draw_mission
from regionslam_env.rendering.shapes import Shape, shapes_of_map
from regionslam_env.simulation.movers import Scene

MAX_FRAMES = 160
FIRST_INTERVAL = 4


@dataclass(frozen=True, eq=False)
class _Moment:
    step: int
    true_pose: NDArray[np.float64]
    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    shapes: tuple[Shape, ...]
    lidar: NDArray[np.float64]
    driven: float
    caption: str
    now: str
    goal: str | None
    scene: Scene | None


class Recorder:
    """Records truth and belief of an episode, evenly spread over it and never more than `MAX_FRAMES` moments.

    Parameters
    ----------
    env
        The unwrapped environment, after its reset.
    title
        The mission in words.
    """

    def __init__(self, env: Any, title: str) -> None:
        self.env, self.title = env, title
        self._start = np.array(env.true_pose, dtype=np.float64)
        self._true_path = [self._start[:2]]
        self._path = [np.array(env.belief.pose_mean[:2])]
        self._interval = FIRST_INTERVAL
        self._moments = [self._moment("")]
        self._stops: list[Stop] = []

    def add(self, doing: str, last: bool = False) -> None:
        """Take in the state after a step; `doing` is what the agent says."""
        self._true_path.append(np.array(self.env.true_pose[:2]))
        self._path.append(np.array(self.env.belief.pose_mean[:2]))
        self._note_stops()
        step = len(self._path) - 1
        if step % self._interval and not last:
            return
        self._moments.append(self._moment(doing))
        if len(self._moments) > MAX_FRAMES:
            self._interval *= 2
            self._moments = [m for m in self._moments if m.step % self._interval == 0]

    def snapshots(self) -> list[Snapshot]:
        """Return every recorded moment, ready to be drawn."""
        true_path, path, seconds = np.array(self._true_path), np.array(self._path), self.env.robot.step
        return [
            Snapshot(
                m.true_pose,
                m.pose,
                m.covariance,
                m.shapes,
                true_path[: m.step + 1],
                path[: m.step + 1],
                m.lidar,
                f"“{self.title}”",
                m.caption,
                m.step * seconds,
                m.driven,
                m.now,
                m.goal,
                m.scene,
            )
            for m in self._moments
        ]

    def write_animation(self, path: Path) -> None:
        """Write the episode as a GIF."""
        renderer = Renderer(
            self.env.fixed_world,
            self._start,
            robot_radius=self.env.robot.radius,
            lidar_range=self.env.sensors.lidar_range,
            scene=self.env.scene,
        )
        with GifWriter(path, colours=renderer.colours) as gif:
            for snapshot in self.snapshots():
                gif.add(renderer.frame(snapshot))

    def mission_picture(self, verdict: str) -> Image.Image:
        """Return one picture of the whole episode; `verdict` tells how it ended."""
        types = self.env.mission.mission.types
        end = replace(self.snapshots()[-1], caption=verdict, goal=types[0] if len(types) == 1 else None)
        return draw_mission(self.env.world, self._start, end, self._stops, robot_radius=self.env.robot.radius)

    def map_picture(self) -> Image.Image:
        """Return a picture of the present map."""
        belief = self.env.belief
        return draw_map(
            shapes_of_map(belief.map),
            belief.pose_mean,
            belief.pose_cov,
            np.array(self._path),
            self.env.goal,
            f"Believed map after “{self.title}”",
            robot_radius=self.env.robot.radius,
        )

    def _note_stops(self) -> None:
        """Note where the instructions were done that have been done since the last step."""
        instructions = self.env.mission.mission.instructions
        for k in range(len(self._stops), round(self.env.task.completed * len(instructions))):
            self._stops.append(Stop(str(instructions[k]), self.env.true_pose, np.array(self.env.belief.pose_mean)))

    def _moment(self, doing: str) -> _Moment:
        belief = self.env.belief
        words = belief.map.describe(belief.pose_mean)
        return _Moment(
            len(self._path) - 1,
            np.array(self.env.true_pose, dtype=np.float64),
            np.array(belief.pose_mean),
            np.array(belief.pose_cov),
            tuple(shapes_of_map(belief.map)),
            np.array(self.env.ranges),
            float(self.env.simulation.path_length),
            f"{words}  ({doing})" if doing else words,
            self.env.instruction_text,
            self.env.goal,
            self.env.scene,
        )
