"""Where worlds come from: one that is always the same, or a new one of a kind for every number.

The worlds of a kind are numbered within each split, and the seeds of two splits never coincide.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from regionslam_env.config import from_dict
from regionslam_env.errors import ConfigError, unknown
from regionslam_env.worlds.generate.generator import KINDS, generate
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.world import World

SPLITS = ("train", "val", "test")
"""Disjoint seeds: one and the same seed gives other worlds, other missions and other noise in each."""

PER_SPLIT = 2**32
"""Number of worlds of a kind in every split."""


def world_seed(split: str, number: int) -> int:
    """Return the seed of a split's world: each split has a range of seeds of its own, that of "train" begins at 0.

    Raises
    ------
    ConfigError
        For an unknown split, or a number that is none of 0 to `PER_SPLIT` - 1.
    """
    if split not in SPLITS:
        raise ConfigError(unknown("split", split, SPLITS))
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < PER_SPLIT:
        raise ConfigError(f"world_seed is {number!r}, expected a whole number from 0 to {PER_SPLIT - 1}")
    return SPLITS.index(split) * PER_SPLIT + number


class WorldSource:
    """The worlds of an environment.

    Parameters
    ----------
    world
        A kind such as ``"office"``, or what `load` takes: a built-in name, a path, a `World`.
    options
        Of generated worlds: keys of `WorldOptions`.
    split
        "train", "val" or "test".

    Attributes
    ----------
    kind
        Of the generated worlds; None for one that is always the same.

    Raises
    ------
    ConfigError, WorldError
        For what is unknown, and for options of a world that is not generated.
    """

    def __init__(
        self, world: str | Path | World, options: Mapping[str, Any] | WorldOptions | None = None, split: str = "train"
    ) -> None:
        if not isinstance(world, str | Path | World):
            raise ConfigError(f"world is {world!r}, expected a name, a path or a World")
        self.kind = world if isinstance(world, str) and world in KINDS else None
        self._split = split
        self._options = from_dict(WorldOptions, options, "world_options")
        if self.kind is None:
            self._fixed = load(world)
            if options is not None:
                raise ConfigError(
                    f"world_options is {options!r}, expected none for world {self._fixed.name!r}: "
                    f"they shape the worlds of a kind ({', '.join(KINDS)})"
                )

    def world(self, number: int) -> World:
        """Return the world of a number, or the only one there is."""
        if self.kind is None:
            return self._fixed
        return _generated(self.kind, world_seed(self._split, number), self._options)


@lru_cache(maxsize=16)
def _generated(kind: str, seed: int, options: WorldOptions) -> World:
    """Generate a world once as long as it is in use: worlds are immutable, and what is computed of one is kept."""
    return generate(kind, seed, options)
