"""Evaluation of an agent over episodes: means with 95 % confidence intervals."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import Any, Protocol

import gymnasium
import numpy as np

from agents.console import InputError
from agents.options import given
from agents.recorder import Recorder
from agents.scripted import ScriptedAgent
from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.errors import unknown
from regionslam_env.registration import ENVIRONMENTS, misplaced, option_of
from regionslam_env.tasks.metrics import METRICS
from slam.storage import replacing

Z95 = 1.959964

SETTINGS = ("world", "split", "localization", "noise", "dynamics")
"""Arguments of an environment that a summary always tells."""


class Agent(Protocol):
    """Anything that acts on observations."""

    def reset(self) -> None:
        """Begin an episode."""

    def act(self, observation: Mapping[str, Any]) -> Any:
        """Return an action."""


class RandomAgent:
    """Drives at random; declares nothing.

    Parameters
    ----------
    action_space
        Box(2), or Box(3) where arrival is declared.
    seed
        Of its own generator.
    """

    def __init__(self, action_space: gymnasium.spaces.Box, seed: int = 0) -> None:
        self._size = action_space.shape[0]
        self._rng = np.random.default_rng(seed)

    def reset(self) -> None:
        """Begin an episode."""

    def act(self, observation: Mapping[str, Any]) -> Any:
        """Return a random action."""
        action = self._rng.uniform(-1, 1, self._size).astype(np.float32)
        action[2:] = -1
        return action


class PolicyAgent:
    """A trained Stable-Baselines3 model; takes its most probable action."""

    def __init__(self, model: Any) -> None:
        self.model = model

    def reset(self) -> None:
        """Begin an episode."""

    def act(self, observation: Mapping[str, Any]) -> Any:
        """Return the model's action."""
        action, _ = self.model.predict(observation, deterministic=True)
        return action


def check_environment(env_id: str, **wanted: str | None) -> str:
    """Return a known environment id that takes what is wanted of it.

    Parameters
    ----------
    env_id
        What came.
    wanted
        Values of the options ``goal`` and ``mission``; None: not given.

    Raises
    ------
    InputError
        For an unknown id, with the nearest ones, and for an option that belongs to other environments.
    """
    if env_id not in ENVIRONMENTS:
        raise InputError(unknown("environment", env_id, ENVIRONMENTS))
    for name, value in given(**wanted).items():
        line = misplaced(env_id, option_of(env_id), name, value, dashes="--")
        if line is not None:
            raise InputError(line)
    return env_id


def make_agent(name: str, env: gymnasium.Env[Any, Any], seed: int = 0, model: Any = None) -> Agent:
    """Return the agent ``"scripted"``, ``"random"``, or the policy of a loaded model, for an environment."""
    base: Any = env.unwrapped
    if model is not None:
        for kind in ("observation_space", "action_space"):
            if getattr(model, kind) != getattr(env, kind):
                raise InputError(f"{name}: trained on another {kind.replace('_', ' ')} than that of {base.spec.id}")
        return PolicyAgent(model)
    if name == "scripted":
        return scripted_agent(base)
    return RandomAgent(base.action_space, seed)


def scripted_agent(base: Any) -> ScriptedAgent:
    """Return the scripted agent for an unwrapped environment: it is told what spaces, robot and sensors there are."""
    return ScriptedAgent(
        base.observation_space, base.action_space, base.semantic_types, base.robot, sight=base.sensors.range
    )


def load_model(agent: str) -> Any:
    """Return the trained model behind the name of an agent, None for those that are no files.

    Raises
    ------
    InputError
        If the name is neither a known agent nor the file of a model.
    """
    if agent in ("scripted", "random"):
        return None
    path = Path(agent)
    if not path.is_file():
        if path.suffix == ".zip" or len(path.parts) > 1:
            raise InputError(f"{path}: no such file, expected a model saved by 'regionslam train'")
        raise InputError(unknown("agent", agent, ("scripted", "random")))
    from agents.train import load

    return load(path)


def evaluate(
    env: gymnasium.Env[Any, Any],
    agent: Agent,
    episodes: int,
    seed: int = 0,
    tell: Callable[[int, Mapping[str, Any]], None] = lambda episode, metrics: None,
    films: Path | None = None,
) -> list[dict[str, Any]]:
    """Run episodes with the seeds ``seed``, ``seed + 1``, ... and return the metrics of each, with `seed` and `steps`.

    Parameters
    ----------
    tell
        Called after each episode with its number and metrics.
    films
        Folder for a film and a picture of each episode, `episode-SEED.gif` and `.png`.
    """
    results = []
    for episode in range(episodes):
        observation, info = env.reset(seed=seed + episode)
        agent.reset()
        recorder = None if films is None else Recorder(env.unwrapped, info["mission"])
        done, steps = False, 0
        while not done:
            observation, _, terminated, truncated, info = env.step(agent.act(observation))
            done, steps = terminated or truncated, steps + 1
            if recorder is not None:
                recorder.add("", done)
        metrics = {key: plain(info[key]) for key in METRICS}
        results.append({"seed": seed + episode, "steps": steps, **metrics})
        if recorder is not None and films is not None:
            recorder.write_animation(films / f"episode-{seed + episode}.gif")
            with replacing(films / f"episode-{seed + episode}.png") as temporary:
                recorder.mission_picture("done" if info["success"] else "not done").save(temporary)
        tell(episode, results[-1])
    return results


def summarize(results: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float | int | None]]:
    """Return mean, 95 % confidence interval and number of episodes of every metric, over the episodes that have it.

    Rates (true or false) get Wilson's interval, other metrics the normal one of the mean.
    """
    summary: dict[str, dict[str, float | int | None]] = {}
    for key in ("steps", *METRICS):
        values = [result[key] for result in results if result.get(key) is not None]
        if not values:
            summary[key] = {"mean": None, "low": None, "high": None, "n": 0}
            continue
        mean = float(np.mean(values))
        low: float | None = None
        high: float | None = None
        if all(isinstance(value, bool) for value in values):
            low, high = wilson(mean, len(values))
        elif len(values) > 1:
            half = Z95 * float(np.std(values, ddof=1)) / math.sqrt(len(values))
            low, high = mean - half, mean + half
        summary[key] = {"mean": mean, "low": low, "high": high, "n": len(values)}
    return summary


def settings_of(env: gymnasium.Env[Any, Any]) -> dict[str, Any]:
    """Return what an environment was made with as plain data: every argument given, and `SETTINGS` by default."""
    parameters = signature(SemanticNavigationEnv.__init__).parameters
    chosen = {} if env.spec is None else env.spec.kwargs
    settings = {name: parameters[name].default for name in SETTINGS} | chosen
    plainly: dict[str, Any] = json.loads(
        json.dumps(settings | {"dynamics": settings["dynamics"] or "none"}, default=str)
    )
    return plainly


def write_summary(folder: Path, summary: Mapping[str, Any]) -> None:
    """Write `summary.json`, which tells what came out and how it was made."""
    with replacing(folder / "summary.json") as temporary:
        temporary.write_text(json.dumps(summary, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def wilson(rate: float, n: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a rate seen in n trials (Wilson 1927)."""
    centre = (rate + Z95**2 / (2 * n)) / (1 + Z95**2 / n)
    half = Z95 * math.sqrt(rate * (1 - rate) / n + Z95**2 / (4 * n**2)) / (1 + Z95**2 / n)
    return max(0.0, centre - half), min(1.0, centre + half)


def plain(value: Any) -> Any:
    """Return a NumPy scalar as Python's own, for JSON."""
    return value.item() if isinstance(value, np.generic) else value
