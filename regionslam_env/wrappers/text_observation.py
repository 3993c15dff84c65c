"""The observation in words, for language models."""

from __future__ import annotations

import string
import unicodedata
from collections.abc import Iterable
from typing import Any

import gymnasium
from gymnasium import spaces

from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.observations import Observation
from regionslam_env.wrappers.situation import Situation

LETTERS = "".join(map(chr, range(0xC0, 0x180)))
"""Latin letters beyond ASCII."""

CHARACTERS = string.digits + string.ascii_letters + string.punctuation + " \n" + LETTERS
"""All characters a text may have: printable ASCII, the line break, and the letters of European languages."""

SHORTEST = 200
"""Least value of `max_length`."""


class TextObservation(gymnasium.ObservationWrapper[str, Any, Observation]):
    """Tells in plain English what the robot believes and senses, all from its own point of view.

    One line each for mission, what of it is to be done now, progress, place, certainty, pose, motion, obstacles by
    direction, and what was just seen; then one for every region of the map: the number of its slot (what
    `SemanticActions` takes), name, distance and bearing, size, doubts, where it may go on unseen, and links. Regions of
    the goal's type come first, then the nearest. A text that would be too long ends with a whole line and a note of how
    many were left out. Names in other scripts are written with the letters that `CHARACTERS` has, or "?".

    Parameters
    ----------
    env
        A `SemanticNavigationEnv`, or one in wrappers that keep its observations.
    max_length
        Of a text, at least `SHORTEST` characters.
    """

    def __init__(self, env: gymnasium.Env[Observation, Any], max_length: int = 8000) -> None:
        super().__init__(env)
        if isinstance(max_length, bool) or not isinstance(max_length, int) or max_length < SHORTEST:
            raise ValueError(f"max_length is {max_length!r}, expected a whole number of at least {SHORTEST}")
        base: gymnasium.Env[Any, Any] = env.unwrapped
        if not isinstance(base, SemanticNavigationEnv) or env.observation_space != base.observation_space:
            raise TypeError(f"the environment is {env}, expected a SemanticNavigationEnv with its own observations")
        self._env = base
        self._max_length = max_length
        self.observation_space = spaces.Text(max_length, charset=CHARACTERS)

    def observation(self, observation: Observation) -> str:
        """Return the observation in words."""
        env = self._env
        situation = Situation(
            mission=env.mission.mission,
            observation=observation,
            belief=env.belief,
            scan=env.scan,
            slot_ids=env.slot_ids,
            types=env.semantic_types,
            max_steps=env.max_steps,
        )
        return fit(map(spell, situation.lines()), self._max_length)


def fit(lines: Iterable[str], max_length: int) -> str:
    """Return as many whole lines as fit, and then a note of how many do not; a line too long for itself is cut."""
    kept: list[str] = []
    rest = list(lines)
    room = max_length - len("\n(10000 more lines left out)")
    length = -1
    if sum(map(len, rest)) + len(rest) - 1 <= max_length:
        return "\n".join(rest)
    while rest and length + 1 + len(rest[0]) <= room:
        length += 1 + len(rest[0])
        kept.append(rest.pop(0))
    if not kept:
        kept.append(rest.pop(0)[:room])
    return "\n".join([*kept, f"({len(rest)} more lines left out)"])


def spell(text: str) -> str:
    """Return a line of text with `CHARACTERS` alone."""
    if text.isascii() and text.isprintable():
        return text
    composed = unicodedata.normalize("NFC", " ".join(text.split()))
    return "".join(_known(character) for character in composed)


def _known(character: str) -> str:
    if character in CHARACTERS:
        return character
    base = "".join(c for c in unicodedata.normalize("NFKD", character) if c in CHARACTERS)
    return base or "?"
