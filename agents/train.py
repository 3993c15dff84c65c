"""Training with Stable-Baselines3's PPO (extra `train`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium

from agents.console import InputError
from regionslam_env.errors import hint

MISSING = hint("training needs Stable-Baselines3", "train")


@dataclass(frozen=True)
class TrainSettings:
    """What to train.

    Parameters
    ----------
    env_id
        Any registered environment.
    steps
        Environment steps in all.
    seed
        Of policy, rollouts and episodes.
    out
        The model's file, a `.zip` (added where there is no ending); logs for TensorBoard and checkpoints go into a
        folder of the same name beside it.
    n_envs
        Environments side by side, each in a process of its own if there are several.
    checkpoint_every
        Steps between checkpoints.
    env_kwargs
        Keyword arguments of the environment; they are saved with the model.
    """

    env_id: str = "RegionSLAM/GoTo-v0"
    steps: int = 1_000_000
    seed: int = 0
    out: Path = Path("runs/ppo.zip")
    n_envs: int = 1
    checkpoint_every: int = 50_000
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)


def train(settings: TrainSettings, progress: bool = True) -> Path:
    """Train PPO with `MultiInputPolicy`, save it and return its file.

    Raises
    ------
    InputError
        For a file of another ending than `.zip`, and where the extra `train` is not installed.
    """
    if settings.out.suffix not in ("", ".zip"):
        raise InputError(f"{settings.out}: ending {settings.out.suffix!r}, expected .zip")
    sb3 = _library()
    out = settings.out.with_suffix(".zip")
    logs = out.with_suffix("")
    out.parent.mkdir(parents=True, exist_ok=True)
    environments = _environments(settings)
    try:
        model = sb3.PPO(
            "MultiInputPolicy",
            environments,
            n_steps=max(64, 2048 // settings.n_envs),
            batch_size=256,
            ent_coef=0.01,
            seed=settings.seed,
            tensorboard_log=str(logs),
            device="cpu",
        )
        model.regionslam = {"env_id": settings.env_id, "env_kwargs": dict(settings.env_kwargs)}
        from stable_baselines3.common.callbacks import CheckpointCallback

        every = max(1, settings.checkpoint_every // settings.n_envs)
        callback = CheckpointCallback(every, str(logs / "checkpoints"), name_prefix="ppo")
        model.learn(settings.steps, callback=callback, progress_bar=progress)
        temporary = out.with_name(f".{out.stem}.part.zip")
        model.save(temporary)
        temporary.replace(out)
    finally:
        environments.close()
    return out


def load(path: Path) -> Any:
    """Return a model saved by `train`; its attribute `regionslam` names the environment that it was trained on.

    Raises
    ------
    InputError
        If the file is no such model.
    """
    sb3 = _library()
    try:
        model = sb3.PPO.load(path, device="cpu")
    except Exception as error:  # whatever a wrong or truncated archive makes the unpickler raise
        raise InputError(f"{path}: no model saved by 'regionslam train' ({type(error).__name__}: {error})") from None
    if not hasattr(model, "regionslam"):
        raise InputError(f"{path}: a model, but not one saved by 'regionslam train': it names no environment")
    return model


def _library() -> Any:
    try:
        import stable_baselines3
    except ImportError:
        raise InputError(MISSING) from None
    return stable_baselines3


def _environments(settings: TrainSettings) -> Any:
    """Return the vectorized, monitored environments; kernels are compiled before any process is forked."""
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

    make = partial(gymnasium.make, settings.env_id, **settings.env_kwargs)
    if settings.n_envs > 1:
        warm = make()
        warm.reset(seed=settings.seed)
        warm.step(warm.action_space.sample())
        warm.close()
    kind = SubprocVecEnv if settings.n_envs > 1 else DummyVecEnv
    return make_vec_env(make, settings.n_envs, settings.seed, vec_env_cls=kind)
