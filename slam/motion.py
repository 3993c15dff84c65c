"""Odometry and its noise."""

from __future__ import annotations

from dataclasses import dataclass

LARGEST = 1e6
"""Largest motion (m, rad) in one step, and largest variance of a noise."""


@dataclass(frozen=True)
class Odometry:
    """Motion since the last step in the robot's frame at its start.

    Parameters
    ----------
    distance, lateral
        Displacement forward and to the left, m.
    rotation
        Turn, counter-clockwise, rad.
    """

    distance: float
    lateral: float = 0.0
    rotation: float = 0.0

    def __post_init__(self) -> None:
        try:
            if abs(self.distance) <= LARGEST and abs(self.lateral) <= LARGEST and abs(self.rotation) <= LARGEST:
                return
        except TypeError:
            pass
        raise ValueError(f"odometry is {self!r}, expected finite numbers of at most {LARGEST:g}")


@dataclass(frozen=True)
class MotionNoise:
    """Variances that grow with the motion.

    Parameters
    ----------
    distance
        Variance of the distance per metre driven, m²/m.
    heading_per_metre
        Variance of the heading per metre driven, rad²/m.
    heading_per_radian
        Variance of the heading per radian turned, rad²/rad.
    """

    distance: float = 0.0009
    heading_per_metre: float = 0.0001
    heading_per_radian: float = 0.0009

    def __post_init__(self) -> None:
        for name in ("distance", "heading_per_metre", "heading_per_radian"):
            value = getattr(self, name)
            if not 0 <= value <= LARGEST:
                raise ValueError(f"motion noise: {name} is {value!r}, expected a variance of at least 0")
