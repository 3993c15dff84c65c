"""Speed of the whole environment, by part.

Other programs on the same core make a machine up to two times slower. A fixed loop is therefore timed around every
repeat, and only repeats that ran while that loop was about as quick as ever are kept.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import gymnasium
import numpy as np

from regionslam_env.errors import ConfigError

QUIET = 1.15
"""A repeat counts if the fixed loop around it took at most this much longer than its quickest run."""

PARTS = {
    "physics": ("simulation", "step"),
    "lidar": ("_lidar", "measure"),
    "region sensor": ("_region_sensor", "measure"),
    "filter": ("_localizer", "step"),
    "observation": ("_observer", "observe"),
}
"""Parts of a step: which method of which attribute of the environment."""


def benchmark_environment(
    steps: int = 20_000, repeats: int = 10, env_id: str = "RegionSLAM/GoTo-v0", seed: int = 0, **kwargs: Any
) -> dict[str, Any]:
    """Return steps per second of an environment under random actions that were sampled beforehand, resets included.

    The goals' distance fields, which a process computes once, are not.

    Parameters
    ----------
    steps
        In all; they are split into `repeats`.
    kwargs
        Of the environment.

    Returns
    -------
    dict
        ``steps_per_second`` and ``reset_ms`` (medians of the quiet repeats; the first includes the resets),
        ``microseconds`` per step by part, from a run of its own with timers in it, and ``quiet`` of ``repeats``.
    """
    env = gymnasium.make(env_id, **kwargs)
    rng = np.random.default_rng(seed)
    shape = (max(1, steps // repeats), *(env.action_space.shape or ()))
    actions = rng.uniform(-1, 1, shape).astype(np.float32)
    actions[:, 2:] = -1
    _, info = env.reset(seed=seed)
    if "world_seed" not in info:  # a world of its own for every episode is never computed beforehand
        _compute_fields(env.unwrapped)
        env.reset(seed=seed)
    for action in actions[:50]:
        env.step(action)
    reset_times: list[float] = []

    def repeat() -> None:
        reset_times.append(_drive(env, actions))

    durations, quiet = timed(repeat, repeats)
    result = {
        "env": env_id,
        "steps_per_second": len(actions) / float(np.median(durations[quiet])),
        "reset_ms": 1e3 * float(np.median(np.array(reset_times)[quiet])),
        "microseconds": _by_part(env, actions),
        "steps": len(actions) * repeats,
        "quiet": int(quiet.sum()),
        "repeats": repeats,
    }
    env.close()
    return result


def timed(repeat: Callable[[], object], repeats: int) -> tuple[np.ndarray, np.ndarray]:
    """Run something several times; return the duration of each, s, and which ones ran on a quiet machine."""
    durations, around = np.empty(repeats), np.empty(repeats)
    for k in range(repeats):
        before = _fixed_loop()
        start = time.perf_counter()
        repeat()
        durations[k] = time.perf_counter() - start
        around[k] = max(before, _fixed_loop())
    quiet = around <= QUIET * around.min()
    return durations, quiet


def _compute_fields(env: Any) -> None:
    """Reset once for every goal that an environment draws, so that its world keeps their distance fields."""
    for goal in env.task.goals if env.task.option == "goal" else ():
        with suppress(ConfigError):  # a goal that cannot be reached is never drawn
            env.reset(options={"goal": goal})


def _fixed_loop() -> float:
    """Return the time of a loop that always does the same, s: how busy the machine is."""
    start = time.perf_counter()
    total = 0
    for i in range(100_000):
        total += i * i
    return time.perf_counter() - start


def _drive(env: gymnasium.Env[Any, Any], actions: np.ndarray) -> float:
    """Drive through all actions, with resets where episodes end and at the end; return the mean time of a reset, s."""
    resetting, resets = 0.0, 0
    for k, action in enumerate(actions):
        _, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated or k == len(actions) - 1:
            start = time.perf_counter()
            env.reset()
            resetting, resets = resetting + time.perf_counter() - start, resets + 1
    return resetting / resets


def _by_part(env: gymnasium.Env[Any, Any], actions: np.ndarray) -> dict[str, float]:
    """Return µs per step of each part; what the timers themselves take is in `other`."""
    base: Any = env.unwrapped
    spent = dict.fromkeys(PARTS, 0.0)
    targets = {part: (getattr(base, owner), name) for part, (owner, name) in PARTS.items()}
    env.reset()
    count, total = 0, 0.0
    with _timers(targets, spent):
        for action in actions:
            start = time.perf_counter()
            _, _, terminated, truncated, _ = env.step(action)
            total += time.perf_counter() - start
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
            start = time.perf_counter()
            result = method(*args, **kwargs)
            spent[part] += time.perf_counter() - start
            return result

        return call

    for part, (owner, name) in targets.items():
        setattr(owner, name, timer(part, getattr(owner, name)))
    try:
        yield
    finally:
        for owner, name in targets.values():
            delattr(owner, name)
