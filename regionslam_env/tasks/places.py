"""Where instructions lead: rooms of a type, or back to where the map was begun."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from regionslam_env.worlds.geodesic import Field, Geodesic

AT_HOME = 1.0
"""Length of the way (m) within which the robot is back where the map was begun."""


class Place(Protocol):
    """A part of the floor."""

    @property
    def field(self) -> Field:
        """Distance from everywhere, m: 0 or less inside."""

    @property
    def nodes(self) -> NDArray[np.bool_]:
        """Nodes of the grid that are inside and free, (nx, ny)."""

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point is inside."""


class Rooms:
    """The regions of a type.

    Parameters
    ----------
    geodesic
        Of the world.
    region_type
        At least one region has it.
    """

    def __init__(self, geodesic: Geodesic, region_type: str) -> None:
        regions = geodesic.world.regions
        self._indices = tuple(i for i, region in enumerate(regions) if region.type == region_type)
        self._geodesic = geodesic
        self.field = geodesic.field(self._indices)

    @property
    def nodes(self) -> NDArray[np.bool_]:
        """Nodes of the grid that are inside and free, (nx, ny)."""
        return self._geodesic.floor(self._indices)

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point is inside one of the regions."""
        return bool(self.field.inside(x, y))


class Home:
    """Where the map was begun: all points with a way of at most `AT_HOME` to it.

    Parameters
    ----------
    geodesic
        Of the world.
    x, y
        World frame, m.
    """

    def __init__(self, geodesic: Geodesic, x: float, y: float) -> None:
        self.field = geodesic.field_to_points(np.array([[x, y]]), np.array([-AT_HOME]))

    @property
    def nodes(self) -> NDArray[np.bool_]:
        """Nodes of the grid that are inside, (nx, ny)."""
        return self.field.nodes <= 0

    def contains(self, x: float, y: float) -> bool:
        """Return whether the way from a point is short enough."""
        return self.field.at(x, y) <= 0
