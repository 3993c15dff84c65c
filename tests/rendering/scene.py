"""One room with a door and a desk, 10 m wide and 4 m high."""

from __future__ import annotations

import numpy as np

from regionslam_env.worlds.world import Region, World
from slam.rows import Row

OFFICE = Region("office", "office", "office 1", Row.from_parameters(2.0, 2.0, 4.0, 4.0))
KITCHEN = Region("kitchen", "kitchen", "the kitchen", Row.from_parameters(7.0, 2.0, 6.0, 4.0))
DOOR = Region("door", "door", "", Row.from_parameters(4.0, 2.0, 0.2, 0.9))
DESK = Region("desk", "desk", "", Row.from_parameters(1.0, 3.5, 1.6, 0.8), parent="office")
WALLS = np.array([(0, 0, 10, 0), (10, 0, 10, 4), (10, 4, 0, 4), (0, 4, 0, 0), (4, 0, 4, 1.55), (4, 2.45, 4, 4)])


def world() -> World:
    return World("two rooms", (OFFICE, KITCHEN, DOOR, DESK), WALLS, obstacles=(DESK.row.outline(),))
