"""Driving by keyboard, in a window that shows truth and belief (extra `render`)."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from agents.console import InputError
from regionslam_env.errors import hint

HELP = "Drive with the arrow keys or w, a, s, d; space declares arrival where the environment has it; Esc ends."

MOTIONS = {"w": (1.0, 0.0), "s": (-0.5, 0.0), "a": (0.0, 0.5), "d": (0.0, -0.5)}
MOTIONS |= {first + second: tuple(np.add(MOTIONS[first], MOTIONS[second])) for first in "ws" for second in "ad"}
"""Speed and turn rate, as shares of the robot's largest, by the keys that are held."""

DECLARE = " "

Told = Callable[[dict[str, Any]], None]


def play(env: gymnasium.Env[Any, Any], seed: int | None = None, tell: Told = lambda info: None) -> int:
    """Drive by keyboard until the window is closed, and return how many episodes came to their end.

    Parameters
    ----------
    env
        Of continuous actions, with `render_mode="rgb_array"`.
    seed
        Of every episode: with it they are all the same one.
    tell
        Called at the end of every episode with its last `info`.

    Raises
    ------
    InputError
        Without pygame, or where no window can be opened.
    """
    try:
        import pygame
        from gymnasium.utils.play import play as run_game
    except (ImportError, gymnasium.error.DependencyNotInstalled):
        raise InputError(hint("playing needs pygame", "render")) from None
    _check_display(pygame)
    count = 0

    def after_step(
        before: Any, after: Any, action: Any, reward: float, terminated: bool, truncated: bool, info: Any
    ) -> None:
        nonlocal count
        if terminated or truncated:
            count += 1
            tell(info)

    arrows = {"w": pygame.K_UP, "s": pygame.K_DOWN, "a": pygame.K_LEFT, "d": pygame.K_RIGHT}
    actions: dict[Any, NDArray[np.float32]] = {}
    for keys, motion in MOTIONS.items():
        actions[tuple(keys)] = actions[tuple(arrows[key] for key in keys)] = _action(env, motion, -1.0)
    if env.action_space.shape == (3,):
        actions[tuple(DECLARE)] = _action(env, (0.0, 0.0), 1.0)
    try:
        run_game(env, keys_to_action=actions, noop=_action(env, (0.0, 0.0), -1.0), seed=seed, callback=after_step)
    except pygame.error as error:
        raise InputError(f"no window can be opened: {error}") from None
    return count


def _check_display(pygame: Any) -> None:
    """Refuse to play where nobody sees a window, unless the environment variable of SDL asks for such a driver."""
    try:
        pygame.display.init()
    except pygame.error as error:
        raise InputError(f"no window can be opened: {error}") from None
    if pygame.display.get_driver() in ("dummy", "offscreen") and "SDL_VIDEODRIVER" not in os.environ:
        raise InputError("no window can be opened: there is no display")


def _action(env: gymnasium.Env[Any, Any], motion: tuple[float, ...], declare: float) -> NDArray[np.float32]:
    """Return an action with as many components as the environment takes."""
    return np.array([*motion, declare], np.float32)[: env.action_space.shape[0]]  # type: ignore[index]
