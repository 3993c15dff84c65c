"""Worlds without end: a kind and a seed give a floor, always the same one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from regionslam_env.config import from_dict
from regionslam_env.errors import ConfigError, unknown
from regionslam_env.worlds.generate.building import draw_building
from regionslam_env.worlds.generate.campus import draw_campus
from regionslam_env.worlds.generate.draft import Draft, Turn
from regionslam_env.worlds.generate.filling import draw
from regionslam_env.worlds.generate.flats import lone_flat
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.generate.programs import PROGRAMS
from regionslam_env.worlds.generate.raising import raise_world, walls_of
from regionslam_env.worlds.world import World

KINDS = ("office", "apartment", "school", "hospital", "campus")
"""Kinds of worlds that can be generated."""

ATTEMPTS = 8
"""How often a floor is drawn anew to come nearer to its size."""

NEAR = 0.05
"""Share by which a floor may miss its size without another attempt."""

LARGEST_FLAT = 34
"""Regions up to which an apartment is one dwelling, not a storey of several."""


def generate(kind: str, seed: int, options: WorldOptions | Mapping[str, Any] | None = None) -> World:
    """Return the world of a kind and a seed.

    Parameters
    ----------
    kind
        "office", "apartment", "school", "hospital" or "campus".
    seed
        At least 0; the same kind, seed and options give the same world in every process.
    options
        Size and difficulty.

    Raises
    ------
    ConfigError
        For an unknown kind or option, or a value out of range.
    """
    if kind not in KINDS:
        raise ConfigError(unknown("kind of world", kind, KINDS))
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise ConfigError(f"world seed is {seed!r}, expected a whole number of at least 0")
    wanted = from_dict(WorldOptions, options, "world_options")
    draft = _of_size(kind, int(seed), wanted)
    rng = _generator(kind, int(seed), ATTEMPTS)
    _trim(draft, wanted.size, rng)
    flips = rng.integers(0, 2, 3).tolist()
    draft.transform(Turn(*map(bool, flips)))
    corners = np.array(walls_of(draft))
    x0, y0 = corners[:, :2].min(axis=0).tolist()
    draft.transform(Turn(dx=-x0, dy=-y0))
    return raise_world(f"{kind} {seed}", draft)


def _generator(kind: str, seed: int, purpose: int) -> np.random.Generator:
    """Return the generator of a world's attempt, or of what comes after all attempts: none shares its numbers."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(KINDS.index(kind), purpose)))


def _of_size(kind: str, seed: int, options: WorldOptions) -> Draft:
    """Return a draft with as many regions as wished, or a few pieces of furniture more, if that can be."""
    rooms, best = options.size / (2.3 + 2.2 * options.clutter), None
    for attempt in range(ATTEMPTS):
        draft = _draw(kind, max(1, round(rooms)), options, _generator(kind, seed, attempt))
        missed = draft.size - options.size
        surplus = missed - len(draft.items) // (8 if options.size > 12 else 1)  # can be left out unnoticed
        error = -missed if missed < 0 else max(0, surplus)
        if best is None or error < best[0]:
            best = (error, draft)
        if error <= NEAR * options.size:
            break
        rooms *= max(0.5, min(2.0, (options.size + len(draft.items) / 16) / draft.size))
    assert best is not None
    return best[1]


def _draw(kind: str, rooms: int, options: WorldOptions, rng: np.random.Generator) -> Draft:
    if kind == "campus":
        return draw_campus(rooms, options, rng)
    if kind == "apartment":
        if options.size <= LARGEST_FLAT:
            return _one_flat(rooms, options, rng)
        rooms = max(2, rooms // 5)
    return draw_building(PROGRAMS[kind], rooms, options, rng).draft


def _one_flat(rooms: int, options: WorldOptions, rng: np.random.Generator) -> Draft:
    draft = Draft()
    if rooms <= 3:
        width, depth = draw(rng, (44, 66)), draw(rng, (54, 72))
    else:
        columns = 1 if rooms <= 4 else 2
        width = draw(rng, (62, 66) if columns == 1 else (78, 100)) + 3 * max(0, rooms - 8)
        depth = max(76, 40 + 27 * (rooms - 2) // columns + draw(rng, (-10, 10)))
    lone_flat(draft, (0, 0, width, depth), options.clutter, rng, rooms)
    return draft


def _trim(draft: Draft, size: int, rng: np.random.Generator) -> None:
    """Leave out furniture above the wished size, drawn from all rooms."""
    surplus = min(draft.size - size, len(draft.items) // (4 if size > 12 else 1))
    if surplus > 0:
        dropped = set(rng.permutation(len(draft.items))[:surplus].tolist())
        draft.items = [item for i, item in enumerate(draft.items) if i not in dropped]
