"""What a generated world can be asked for: its size and how hard it is."""

from __future__ import annotations

from dataclasses import dataclass

from regionslam_env.errors import ConfigError

SMALLEST, LARGEST = 5, 10_000


@dataclass(frozen=True)
class WorldOptions:
    """Difficulty of generated worlds, plain data.

    Parameters
    ----------
    size
        Regions in all, about: rooms, hallways, doors and furniture, 5 to 10,000.
    clutter
        Share of the furniture that rooms have space for, 0 to 1.
    ambiguity
        Share of the rooms that are copies of their type's standard room: same shape, same door, same furniture.
    """

    size: int = 40
    clutter: float = 0.5
    ambiguity: float = 0.3

    def __post_init__(self) -> None:
        if not SMALLEST <= self.size <= LARGEST:
            raise ConfigError(f"size is {self.size}, expected {SMALLEST} to {LARGEST} regions")
        for name in ("clutter", "ambiguity"):
            value = getattr(self, name)
            if not 0 <= value <= 1:
                raise ConfigError(f"{name} is {value}, expected a share from 0 to 1")
