from __future__ import annotations

import math

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.existence import REFUTED, is_expected, update_existence
from slam.fastslam import RegionSLAM
from slam.measurement import RegionMeasurement, Scan
from slam.motion import Odometry
from tests.slam.drawn import P, associated, forget_dropped, mapped, maps, measured, near, particles, stored

TABLE = [0.0, -0.5, 0.5, -0.5, 0.5]
WIDE = np.array([[7.0, -7], [7, 7], [-7, 7], [-7, -7]])
WALLED = np.array([[2.0, -7], [2, 7], [-7, 7], [-7, -7]])  # a wall 2 m ahead


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -2.0])
def test_a_region_in_view_is_expected(heading: float) -> None:
    """In every direction, also straight behind the robot, where angles jump."""
    pose = np.array([1.0, 2.0, 0.3])
    there = pose[:2] + 2.2 * np.array([np.cos(pose[2] + heading), np.sin(pose[2] + heading)])
    assert is_expected(mapped(TABLE, there), pose, WIDE, P)
    assert not is_expected(mapped([0, -0.1, 0.1, -0.1, 0.1], there), pose, WIDE, P)  # too small to be missed


def test_a_region_behind_a_wall_or_out_of_range_is_not() -> None:
    origin = np.zeros(3)
    assert not is_expected(mapped(TABLE, (2.8, 0)), origin, WALLED, P)
    assert not is_expected(mapped(TABLE, (6.5, 0)), origin, WIDE, P)
    assert not is_expected(mapped(TABLE, (2.0, 0)), origin, WALLED, P)  # half of it
    assert is_expected(mapped([0, -3, 3, -3, 3]), origin, WIDE, P)  # the room around


def update(regions: np.ndarray, scan: np.ndarray, view: np.ndarray) -> None:
    robots = particles()
    links, candidates, n = associated(robots, regions, scan)
    drawn = stored(regions)
    update_existence(robots, drawn, *near(drawn), links, candidates, n, view, P)
    forget_dropped(regions, drawn)


def test_existence_by_hand() -> None:
    regions = maps(
        mapped(TABLE, (3, 0), cov=1e-4), mapped(TABLE, (0, 2.5), cov=1e-4), mapped(TABLE, (-40, 0), cov=1e-4)
    )
    regions["existence"], regions["sightings"] = 1.0, 2
    update(regions, measured(RegionMeasurement("office", 3, 0, 1, 1)), WIDE)
    assert regions["existence"][0, :3].tolist() == [1.0 + P.existence_seen, 1.0 - P.existence_missed, 1.0]
    update(regions, measured(RegionMeasurement("office", 3, 0, 1, 1)), np.zeros((0, 2)))
    assert regions["existence"][0, 1] == 1.0 - P.existence_missed  # no view, no negative evidence
    for _ in range(20):
        update(regions, measured(RegionMeasurement("office", 3, 0, 1, 1)), np.zeros((0, 2)))
    assert regions["existence"][0, 0] == P.existence_ceiling


def test_a_scan_that_explains_no_region_refutes_none() -> None:
    """The sensor is blind, or the robot elsewhere; a region born in this scan does not speak against that."""
    regions = maps(mapped(TABLE, (3, 0), cov=1e-4))
    regions["existence"] = 1.0
    update(regions, measured(), WIDE)
    assert regions["existence"][0, 0] == 1.0


def test_a_refuted_type_is_dropped() -> None:
    regions = maps(mapped(TABLE, (3, 0), cov=1e-4), mapped(TABLE, (0, 3), cov=1e-4))
    regions["type_log_odds"][0, :2] = REFUTED - 0.1, REFUTED + 0.1
    update(regions, measured(), WIDE)
    assert regions["n"][0, :2].tolist() == [0, 1]


def test_a_measurement_of_another_region_of_the_type_explains_nothing() -> None:
    """An invented table half a metre beside a real one, which is measured."""
    regions = maps(mapped(TABLE, (3, 0), cov=1e-4), mapped(TABLE, (3, 0.5), cov=1e-4))
    regions["sightings"] = 2
    update(regions, measured(RegionMeasurement("office", 3, 0, 1, 1)), WIDE)
    assert regions["existence"][0, 1] == -P.existence_missed


def test_another_type_at_the_place_is_no_sign_of_absence() -> None:
    regions = maps(mapped(TABLE, (3, 0), cov=1e-4))
    update(regions, measured(RegionMeasurement("kitchen", 3, 0, 1, 1)), WIDE)
    assert regions["existence"][0, 0] == 0.0


def test_a_region_the_robot_stands_in_counts_as_visited() -> None:
    regions = maps(mapped([0, -2, 2, -2, 2]), mapped([0, -2, 2, -2, 2], (4.3, 0)))
    update(regions, measured(), np.zeros((0, 2)))
    assert regions["visited"][0, :2].tolist() == [1, 0]


def drive(view: np.ndarray | None, steps: int = 12) -> list[str]:
    """Types left when a table is measured four times and then never again; an office goes on being measured."""
    slam = RegionSLAM(SlamConfig(n_particles=2), seed=0)
    office = RegionMeasurement("office", 1, 0, 12, 12)
    for _ in range(4):
        slam.step(Odometry(0.0), Scan([office, RegionMeasurement("table", 2.6, 0, 1, 1)], view=WIDE))
    for _ in range(steps):
        belief = slam.step(Odometry(0.0), Scan([office], view=view))
    return [m.type for m in belief.map.hypotheses]


def test_a_phantom_in_view_disappears_and_a_hidden_region_stays() -> None:
    assert drive(WIDE) == ["office"]
    assert drive(WALLED) == ["office", "table"]
    assert drive(None) == ["office", "table"]
