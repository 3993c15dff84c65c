"""Speed of the whole environment, by part, of many copies of it, and of its peers.

Times are the processor's, of this process alone: it waits for its turn where others want the same core. What runs
beside it still makes it up to two times slower. A fixed loop is therefore timed around every repeat, and only repeats
that ran while that loop was about as quick as ever are kept.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import cycle, islice
from typing import Any, cast

import gymnasium
import numpy as np

from agents.peers import installed_peers
from regionslam_env.errors import ConfigError

QUIET = 1.15
"""A repeat counts if the fixed loop around it took at most this much longer than its quickest run."""

PARTS = {
    "physics": ("simulation", "step"),
    "lidar": ("lidar", "measure"),
    "region sensor": ("region_sensor", "measure"),
    "filter": ("localizer", "step"),
    "observation": ("observer", "observe"),
}
"""Parts of a step: which method of which attribute of the environment."""


def benchmark_environment(
    steps: int = 20_000,
    repeats: int = 10,
    env_id: str = "RegionSLAM/GoTo-v0",
    seed: int = 0,
    copies: int = 64,
    tell: Callable[[str], None] = lambda line: None,
    **kwargs: Any,
) -> dict[str, Any]:
    """Return steps per second of an environment under random actions that were sampled beforehand, resets included.

    A single environment, the native vector environment and the peers that are installed take turns, on one core. The
    goals' distance fields, which a process computes once, are not timed.

    Parameters
    ----------
    steps
        In all, of each; they are split into `repeats`.
    copies
        In the vector environment. Its episodes begin one after the other, so that resets are spread evenly.
    tell
        Hears what is being done.
    kwargs
        Of the environment.

    Returns
    -------
    dict
        ``steps_per_second`` and ``reset_ms`` (medians of the quiet repeats; the first includes the resets),
        ``vector_steps_per_second`` with ``copies``, ``vector_ratio`` (of the two, turn by turn), ``peers`` (by id their
        ``steps_per_second``, and our ``ratio`` and ``vector_ratio`` to them, turn by turn), ``microseconds``
        by part, from a run of its own in which steps are taken part by part, with timers, instead of in one call, and
        ``quiet`` of ``repeats``.
    """
    count = max(1, steps // repeats)
    tell("setting out")
    single = _Single(env_id, count, seed, kwargs)
    many = _Many(env_id, copies, max(1, count // copies), seed, kwargs)
    peers = installed_peers(count)
    contenders: dict[str, Any] = {"single": single, "vector": many, **peers}
    tell(f"timing {', '.join(contenders)}, turn by turn")
    durations, quiet = race([contender.drive for contender in contenders.values()], repeats)
    per_step = durations / np.array([[count], [many.steps], *[[count]] * len(peers)])
    speeds = [1 / float(np.median(times[still])) for times, still in zip(per_step, quiet, strict=True)]
    result = {
        "env": env_id,
        "steps_per_second": speeds[0],
        "reset_ms": 1e3 * float(np.median(np.array(single.reset_times)[quiet[0]])),
        "vector_steps_per_second": speeds[1],
        "copies": copies,
        "vector_ratio": float(np.median(per_step[0] / per_step[1])),
        "peers": {
            peer: {
                "steps_per_second": speeds[k],
                "ratio": float(np.median(per_step[k] / per_step[0])),
                "vector_ratio": float(np.median(per_step[k] / per_step[1])),
            }
            for k, peer in enumerate(peers, 2)
        },
        "microseconds": _by_part(single.env, single.actions),
        "steps": count * repeats,
        "quiet": int(quiet[0].sum()),
        "repeats": repeats,
    }
    for contender in contenders.values():
        contender.close()
    return result


class _Single:
    """One environment that takes all its actions, and is reset at the end."""

    def __init__(self, env_id: str, steps: int, seed: int, kwargs: dict[str, Any]) -> None:
        self.env = gymnasium.make(env_id, **kwargs)
        self.actions = _actions((steps, *(self.env.action_space.shape or ())), seed)
        self.reset_times: list[float] = []
        _, info = self.env.reset(seed=seed)
        if "world_seed" not in info:  # a world of its own for every episode is never computed beforehand
            _compute_fields(self.env.unwrapped)
            self.env.reset(seed=seed)
        for action in self.actions[:50]:
            self.env.step(action)

    def drive(self) -> None:
        """Take all actions, with resets where episodes end and at the end."""
        self.reset_times.append(_drive(self.env, self.actions))

    def close(self) -> None:
        self.env.close()


class _Many:
    """Copies in the middle of episodes of all ages; as with one of them, no action returns within an episode."""

    def __init__(self, env_id: str, copies: int, steps: int, seed: int, kwargs: dict[str, Any]) -> None:
        mode = "vector_entry_point"
        self._envs = cast(Any, gymnasium.make_vec(env_id, copies, vectorization_mode=mode, **kwargs))
        self.steps, self._count = steps * copies, steps
        self._envs.reset(seed=seed)
        (length, *_) = self._envs.get_attr("max_steps")
        self._actions = cycle(_actions((length, *(self._envs.action_space.shape or ())), seed))
        begun = 0
        for k in range(length):
            due = copies * (k + 1) // length
            if due > begun:
                mask = np.zeros(copies, np.bool_)
                mask[begun:due] = True
                self._envs.reset(options={"reset_mask": mask})
                begun = due
            self._envs.step(next(self._actions))

    def drive(self) -> None:
        for actions in islice(self._actions, self._count):
            self._envs.step(actions)

    def close(self) -> None:
        self._envs.close()


def _actions(shape: tuple[int, ...], seed: int) -> np.ndarray:
    """Return random actions; none of them declares anything."""
    actions = np.random.default_rng(seed).uniform(-1, 1, shape).astype(np.float32)
    actions[..., 2:] = -1
    return actions


def timed(repeat: Callable[[], object], repeats: int) -> tuple[np.ndarray, np.ndarray]:
    """Run something several times; return the duration of each, s, and which ones ran on a quiet machine."""
    durations, quiet = race([repeat], repeats)
    return durations[0], quiet[0]


def race(contenders: Sequence[Callable[[], object]], repeats: int) -> tuple[np.ndarray, np.ndarray]:
    """Let several take turns; return the durations, shape (contenders, repeats), s, and which were of quiet times."""
    durations, around = np.empty((2, len(contenders), repeats))
    for k in range(repeats):
        for j, contender in enumerate(contenders):
            before = _fixed_loop()
            start = time.process_time()
            contender()
            durations[j, k] = time.process_time() - start
            around[j, k] = max(before, _fixed_loop())
    return durations, around <= QUIET * around.min(axis=1, keepdims=True)


def _compute_fields(env: Any) -> None:
    """Reset once for every goal that an environment draws, so that its world keeps their distance fields."""
    for goal in env.task.goals if env.task.option == "goal" else ():
        with suppress(ConfigError):  # a goal that cannot be reached is never drawn
            env.reset(options={"goal": goal})


def _fixed_loop() -> float:
    """Return the time of a loop that always does the same, s: how busy the machine is."""
    start = time.process_time()
    total = 0
    for i in range(100_000):
        total += i * i
    return time.process_time() - start


def _drive(env: gymnasium.Env[Any, Any], actions: np.ndarray) -> float:
    """Drive through all actions, with resets where episodes end and at the end; return the mean time of a reset, s."""
    resetting, resets = 0.0, 0
    for k, action in enumerate(actions):
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated or k == len(actions) - 1:
            start = time.process_time()
            env.reset()
            resetting, resets = resetting + time.process_time() - start, resets + 1
    return resetting / resets


def _by_part(env: gymnasium.Env[Any, Any], actions: np.ndarray) -> dict[str, float]:
    """Return µs of each part of a step that is taken part by part; what the timers themselves take is in `other`."""
    base: Any = env.unwrapped
    fusible, base.fusible = base.fusible, False
    try:
        return _time_parts(env, actions)
    finally:
        base.fusible = fusible


def _time_parts(env: gymnasium.Env[Any, Any], actions: np.ndarray) -> dict[str, float]:
    """Do so for an environment that takes its steps part by part."""
    base: Any = env.unwrapped
    spent = dict.fromkeys(PARTS, 0.0)
    env.reset()
    env.step(actions[0])  # kernels that a step in one call has never called are loaded
    env.reset()
    targets = {part: (getattr(base, owner), name) for part, (owner, name) in PARTS.items()}
    count, total = 0, 0.0
    with _timers(targets, spent):
        for action in actions:
            start = time.process_time()
            _, _, terminated, truncated, _ = env.step(action)
            total += time.process_time() - start
            count += 1
            if terminated or truncated:
                break
    parts = {part: 1e6 * seconds / count for part, seconds in spent.items()}
    return {**parts, "other": 1e6 * total / count - sum(parts.values()), "total": 1e6 * total / count}


@contextmanager
def _timers(targets: dict[str, tuple[Any, str]], spent: dict[str, float]) -> Iterator[None]:
    """Replace methods of objects by timed ones for a while."""

    def timer(part: str, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **kwargs: Any) -> Any:
            start = time.process_time()
            result = method(*args, **kwargs)
            spent[part] += time.process_time() - start
            return result

        return call

    for part, (owner, name) in targets.items():
        setattr(owner, name, timer(part, getattr(owner, name)))
    try:
        yield
    finally:
        for owner, name in targets.values():
            delattr(owner, name)
