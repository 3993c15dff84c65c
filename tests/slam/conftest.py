"""A hand-drawn map: a hallway along x, and north of it a kitchen and two offices, each behind a door."""

from __future__ import annotations

from typing import Any

import pytest

from slam.region import RegionFeature
from slam.region_map import RegionMap

HALL, KITCHEN, OFFICE_1, OFFICE_2 = 10, 20, 31, 32
DOOR_K, DOOR_1, DOOR_2 = 41, 42, 43
WEST_DESK, EAST_DESK, TABLE = 51, 52, 53
STORAGE, GHOST = 60, 70


def feature(id: int, type: str, x: float, y: float, w: float, h: float, **fields: Any) -> RegionFeature:
    return RegionFeature(id, type, fields.pop("type_log_odds", 3.0), x, y, w, h, fields.pop("phi", 0.0), **fields)


def drawn_features() -> list[RegionFeature]:
    return [
        feature(HALL, "hallway", 10, 1, 20, 2, neighbours={"t": {DOOR_K: 2.0, DOOR_1: 3.0, DOOR_2: 1.0}}),
        feature(KITCHEN, "kitchen", 5, 5, 6, 6, neighbours={"b": {DOOR_K: 2.5}}, children={TABLE: 2.0}),
        feature(
            OFFICE_1, "office", 11, 5, 6, 6, neighbours={}, children={WEST_DESK: 2.0, EAST_DESK: 1.0, KITCHEN: -1.0}
        ),
        feature(OFFICE_2, "office", 17, 5, 6, 6),
        feature(DOOR_K, "door", 5, 2, 0.9, 0.2, neighbours={"b": {HALL: 2.0}, "t": {KITCHEN: 1.0, STORAGE: 4.0}}),
        feature(DOOR_1, "door", 11, 2, 0.9, 0.2, neighbours={"t": {OFFICE_1: 2.0}, "b": {KITCHEN: -2.0}}),
        feature(DOOR_2, "door", 17, 2, 0.9, 0.2),
        feature(WEST_DESK, "desk", 8.4, 5, 1.6, 0.8, phi=1.5707963267948966),
        feature(EAST_DESK, "desk", 13.6, 5, 1.6, 0.8, phi=1.5707963267948966),
        feature(TABLE, "table", 5, 6, 1, 1),
        feature(STORAGE, "storage", 5, 5, 6, 6, type_log_odds=-1.0, credible=False),
        feature(GHOST, "lobby", 5, -5, 4, 4, existence=-0.5),
    ]


@pytest.fixture
def drawn() -> RegionMap:
    return RegionMap(drawn_features()[::-1])
