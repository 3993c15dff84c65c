"""A vector environment that steps all of its copies in one process, each part of a step in one compiled call."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import ArrayLike, NDArray

from regionslam_env.actions import read_actions
from regionslam_env.arguments import whole_number
from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.fused.copies import Copies, can_be_fused
from regionslam_env.fused.kernels import OBSERVED
from regionslam_env.observations import Observation
from regionslam_env.vector.infos import Terms, gather_infos

Info = dict[str, Any]
Flags = NDArray[np.bool_]


class NavigationVectorEnv(SyncVectorEnv):
    """Copies of one environment, as `gymnasium.vector.SyncVectorEnv` would step them, bit by bit, and faster.

    Made by ``gymnasium.make_vec(id, num_envs=64, vectorization_mode="vector_entry_point", **kwargs)``. What the kernels
    do not know (another rung of the ladder, things that move, a region sensor with a narrow view or mistakes, a filter
    that is lost) is stepped copy by copy, and so are copies that draw pictures or differ in what was set by `set_attr`.

    Parameters
    ----------
    env_type
        Class of the environments.
    num_envs
        Number of copies.
    autoreset_mode
        When a copy whose episode has ended begins the next one: "NextStep", "SameStep" or "Disabled".
    copy
        Whether observations are handed out as copies; otherwise the next step overwrites them.
    kwargs
        Of the environments.
    """

    envs: list[SemanticNavigationEnv]  # type: ignore[assignment]

    def __init__(
        self,
        env_type: type[SemanticNavigationEnv],
        num_envs: int = 1,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        **kwargs: Any,
    ) -> None:
        make = partial(env_type, **kwargs)
        super().__init__([make] * whole_number("num_envs", num_envs), copy=copy, autoreset_mode=autoreset_mode)
        self._alike = can_step_together(self.envs)
        self._copies: Copies | None = None  # from the first step on that is taken together
        self._was_reset = False

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Observation, Info]:
        """Reset all copies, or those of ``options["reset_mask"]``; seeds are as `SyncVectorEnv` takes them."""
        self._env_obs = [self._row(i) for i in range(self.num_envs)]  # type: ignore[misc]
        result = super().reset(seed=seed, options=options)
        self._was_reset = True
        return result

    def step(self, actions: ArrayLike) -> tuple[Observation, NDArray[np.float64], Flags, Flags, Info]:
        """Step all copies; one whose episode has ended begins another one, as the autoreset mode says.

        Raises
        ------
        ValueError
            For actions of another shape or with a component that is not a number.
        ResetNeeded
            Before the first reset, and after the end of an episode with the autoreset mode "Disabled".
        """
        starting = self._starting()
        shares, declared = read_actions(actions, self.action_space.shape or (), ~starting)
        infos: list[Info] = [{}] * self.num_envs
        last: dict[int, Info] = {}
        for i in np.flatnonzero(starting).tolist():
            infos[i] = self._begin(i)
            self._rewards[i], self._terminations[i], self._truncations[i] = 0.0, False, False
        together = self._together(starting)
        for i in np.flatnonzero(~starting & ~together).tolist():
            infos[i] = self._step_alone(i, np.asarray(actions)[i])
        terms = self._step_together(np.flatnonzero(together), shares, declared, infos) if together.any() else None
        over = self._terminations | self._truncations
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            for i in np.flatnonzero(over).tolist():
                last[i] = {"final_obs": self._row(i), "final_info": infos[i]}
                infos[i] = self._begin(i)
        self._autoreset_envs = over
        observations = (
            {key: rows.copy() for key, rows in self._observations.items()} if self.copy else self._observations
        )
        flags = self._terminations.copy(), self._truncations.copy()
        return observations, self._rewards.copy(), *flags, gather_infos(self, infos, last, terms)

    def _starting(self) -> Flags:
        """Return which copies begin an episode in this step."""
        if not self._was_reset:
            raise ResetNeeded("there is no running episode: call reset() first")
        if self.autoreset_mode == AutoresetMode.NEXT_STEP:
            return self._autoreset_envs
        if self.autoreset_mode == AutoresetMode.DISABLED and self._autoreset_envs.any():
            over = np.flatnonzero(self._autoreset_envs).tolist()
            raise ResetNeeded(f"the episodes of copies {over} are over: reset them with options={{'reset_mask': ...}}")
        return np.zeros(self.num_envs, np.bool_)

    def _together(self, starting: Flags) -> Flags:
        """Return which copies the kernels can step."""
        if not self._alike:
            return np.zeros(self.num_envs, np.bool_)
        ready = np.fromiter((env.is_under_way for env in self.envs), np.bool_, self.num_envs)
        return ready & ~starting

    def _step_alone(self, i: int, action: ArrayLike) -> Info:
        """Step one copy as any environment."""
        observation, self._rewards[i], self._terminations[i], self._truncations[i], info = self.envs[i].step(action)
        self._write(i, observation)
        return info

    def _step_together(self, which: NDArray[np.int64], shares: Any, declared: Flags, infos: list[Info]) -> Terms:
        """Step copies by kernels; return the terms of their rewards that were judged there."""
        if self._copies is None:
            self._copies = Copies(self.envs, self._observations)
        copies, robot = self._copies, self.envs[0].robot
        copies.step(which, shares * np.array([robot.max_speed, robot.max_turn_rate]), declared)
        is_quiet = copies.stage[which] == OBSERVED
        for i in which[~is_quiet].tolist():
            self._rewards[i], self._terminations[i], self._truncations[i], infos[i] = copies.settle(i)
        quiet, whose = which[is_quiet], np.zeros(self.num_envs, np.bool_)
        self._rewards[quiet], self._terminations[quiet], self._truncations[quiet] = 0.0, False, False
        whose[quiet] = True
        return whose, self._judge_together(copies, quiet, infos)

    def _judge_together(
        self, copies: Copies, which: NDArray[np.int64], infos: list[Info]
    ) -> dict[str, NDArray[np.float64]]:
        """Write the rewards of steps that end nothing; return their terms, each of shape (N,)."""
        terms = {}
        for name, values in self.envs[0].task.quiet_terms(copies.progress[which], copies.collided[which]).items():
            terms[name] = np.zeros(self.num_envs)
            terms[name][which] = values
            self._rewards[which] += terms[name][which]
        for i in which.tolist() if self.envs[0].reveal_truth else ():
            infos[i] = {"truth": self.envs[i].truth()}
        return terms

    def _begin(self, i: int) -> Info:
        """Begin an episode of a copy; return its info."""
        observation, info = self.envs[i].reset()
        self._write(i, observation)
        return info

    def _write(self, i: int, observation: Observation) -> None:
        """Take over the observation of a copy that was stepped or reset by itself."""
        for key, value in observation.items():
            self._observations[key][i] = value

    def _row(self, i: int) -> Observation:
        return {key: rows[i].copy() for key, rows in self._observations.items()}

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Call a method of every copy, or return an attribute."""
        results = super().call(name, *args, **kwargs)
        self._alike = can_step_together(self.envs)
        return results

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of every copy to one value, or to each its own of a list."""
        super().set_attr(name, values)
        self._alike = can_step_together(self.envs)

    def __getstate__(self) -> dict[str, Any]:
        """Pickle everything but addresses."""
        return self.__dict__ | {"_copies": None}


def can_step_together(envs: Sequence[SemanticNavigationEnv]) -> bool:
    """Say whether the kernels can step such environments, and these are alike."""
    drawn = any(env.render_mode == "rgb_array" for env in envs)
    return all(map(can_be_fused, envs)) and not drawn and len({(env.max_steps, env.reveal_truth) for env in envs}) == 1
