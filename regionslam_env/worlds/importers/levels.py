"""Which level of a building to take."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from regionslam_env.errors import WorldError, unknown


def check_level(levels: Sequence[str], wanted: str | None, where: object) -> None:
    """Refuse a level that is wanted where there is none of this name; None wants none in particular."""
    if wanted is not None and wanted not in levels:
        raise WorldError(f"{where}: {unknown('level', wanted, levels)}")


def choose(
    levels: Sequence[str], rooms: Iterable[str], wanted: str | None, file: object, ground: str | None = None
) -> str:
    """Return the level that is wanted, by default the one with the most rooms, and the ground floor among equals.

    Parameters
    ----------
    levels
        Names of the levels, lowest first.
    rooms
        The level of every room.
    wanted
        Name of a level, None for the default.
    file
        For the error.
    ground
        Name of the ground floor; default: the lowest.
    """
    check_level(levels, wanted, file)
    if wanted is not None:
        return wanted
    counts = Counter(rooms)
    if not levels:
        raise WorldError(f"{file}: no level with a room")
    return max(levels, key=lambda level: (counts[level], level == ground, -levels.index(level)))
