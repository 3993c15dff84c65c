"""Actions that mean something: drive to this region of the map, look around."""

from __future__ import annotations

from collections import Counter
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from regionslam_env.actions import read_choice
from regionslam_env.control.controller import LocalController
from regionslam_env.control.window import Window
from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.observations import Observation
from regionslam_env.wrappers.look_around import LookAround
from regionslam_env.wrappers.region_drive import RegionDrive, slot_at

ARRIVED_AFTER = 1.0
"""A drive ends when the robot has been in the region for this long, s."""

START = np.zeros(2)
"""Where the map was begun, in its own frame, m."""


class SemanticActions(gymnasium.Wrapper[Observation, Any, Observation, Any]):
    """Offers to drive to the region in a slot of the map; one step of it lasts until that drive is over.

    Action k drives to the region that holds slot k (row k of the observation's table) at that moment; the drive keeps
    to this region even if it gets another slot or none. The built-in controller drives on belief and lidar alone,
    through the doors that links lead through: into the region, up to a thing that cannot be entered, or to the middle
    of a region that the robot is in already. After the slots come, in this order: in a `MissionEnv` an action that
    drives back to the start, with `arrival="declare"` one that declares, and always, as the last one, looking around:
    the robot turns once around on the spot. That can always be chosen, also on the empty map right after a reset.

    Rewards and reward terms are summed over the steps of the environment. `info` is that of the last one, and also has

    * ``steps``: how many steps of the environment it took,
    * ``outcome``: "arrived" (a second ago), "looked" (once around), "blocked" (no way on), "limit", "ended" (the
      episode did), "declared" or "refused",
    * ``action_mask``: which actions can be chosen next, int8 (also after a reset).

    An action whose slot is empty is refused: the robot stands still for one step. `action_masks()` gives the mask as
    sb3-contrib's `MaskablePPO` asks for it.

    Parameters
    ----------
    env
        A `SemanticNavigationEnv`, or one in wrappers that keep its observations and actions. Wrappers of observations
        go around this one.
    limit
        Steps of the environment that a drive or a look around may last.
    """

    def __init__(self, env: gymnasium.Env[Observation, NDArray[np.float32]], limit: int = 300) -> None:
        super().__init__(env)
        if isinstance(limit, bool) or not isinstance(limit, int) or limit < 1:
            raise ValueError(f"limit is {limit!r}, expected a whole number of at least 1")
        base: gymnasium.Env[Any, Any] = env.unwrapped
        spaces_kept = (env.observation_space, env.action_space) == (base.observation_space, base.action_space)
        if not isinstance(base, SemanticNavigationEnv) or not spaces_kept:
            raise TypeError(f"the environment is {env}, expected a SemanticNavigationEnv with its own spaces")
        self._env, self._limit = base, limit
        self._n_slots = len(base.slot_ids)
        self._declares = base.arrival == "declare"
        self._returns = base.task_type.option == "mission"
        self.action_space = spaces.Discrete(self._n_slots + self._returns + self._declares + 1)
        n_rays, reach = base.sensors.n_lidar_rays, base.sensors.lidar_range
        self._controller = LocalController(base.robot, n_rays, reach, Window(n_rays=n_rays))
        self._arrived_after = max(1, round(ARRIVED_AFTER / base.robot.step))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; `info` holds the action mask."""
        self._observation, info = self.env.reset(seed=seed, options=options)
        return self._observation, info | {"action_mask": self._mask()}

    def step(self, action: np.int64) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive to the region in a slot, or look around, until that is over.

        Raises
        ------
        ValueError
            For anything but the number of an action.
        ResetNeeded
            Before the first reset and after the end of an episode.
        """
        self._require_episode()
        mask, point = self._mask(), None
        slot, last = read_choice(action, len(mask)), len(mask) - 1
        if slot == last:
            return self._run(LookAround(self._controller, self._observation), "")
        if self._declares and slot == last - 1:
            return self._run(None, "declared")
        if not mask[slot]:
            return self._run(None, "refused")
        if slot == self._n_slots:
            slot, point = slot_at(self._observation, START), START
        ids = self._env.slot_ids
        return self._run(RegionDrive(self._controller, self._observation, ids, slot, self._arrived_after, point), "")

    def action_masks(self) -> NDArray[np.bool_]:
        """Return which actions can be chosen now, under the name by which sb3-contrib looks for it.

        Raises
        ------
        ResetNeeded
            Before the first reset.
        """
        self._require_episode()
        return self._mask().astype(np.bool_)

    def _require_episode(self) -> None:
        if not hasattr(self, "_observation"):
            raise ResetNeeded("there is no running episode: call env.reset() first")

    def _run(
        self, drive: RegionDrive | LookAround | None, outcome: str
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Take steps until there is an outcome; without a drive, one step of standing still."""
        total, steps, terms = 0.0, 0, Counter[str]()
        while True:
            speeds = np.zeros(2) if drive is None else drive.act(self._observation)
            command = [*speeds, 1.0 if outcome == "declared" else -1.0] if self._declares else speeds
            self._observation, reward, terminated, truncated, info = self.env.step(np.array(command, np.float32))
            total, steps = total + float(reward), steps + 1
            terms.update(info["reward_terms"])
            if drive is not None:
                outcome = drive.judge(self._observation, self._env.slot_ids)
                if terminated or truncated:
                    outcome = "ended"
                elif not outcome and steps >= self._limit:
                    outcome = "limit"
            if outcome:
                break
        info |= {"reward_terms": dict(terms), "steps": steps, "outcome": outcome, "action_mask": self._mask()}
        return self._observation, total, terminated, truncated, info

    def _mask(self) -> NDArray[np.int8]:
        """Return which actions can be chosen now: slots that hold a region, the start on any map, the others always."""
        mask = self._observation["regions_mask"]
        more = [*([mask.any()] if self._returns else []), *([True] if self._declares else []), True]
        return np.append(mask, np.array(more, np.int8))
