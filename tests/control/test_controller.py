from __future__ import annotations

import numpy as np
import pytest

from regionslam_env.config import RobotConfig
from regionslam_env.control.controller import LocalController
from tests.control.room import Floats, box, clearance, move, scan, to_robot

ROOM = box(-4, -3, 4, 3)
WALL_WITH_DOOR = [(0, -3, 0, -0.45), (0, 0.45, 0, 3)]
DESKS = box(-3, 0.5, -1.4, 1.3) + box(1.2, -0.6, 2.0, 1.0)


def drive(pose: tuple[float, float, float], target: tuple[float, float], segments: Floats, steps: int) -> list[Floats]:
    """Drive towards a target and return all poses; fails where the robot touches a wall."""
    controller = LocalController(RobotConfig())
    rng = np.random.default_rng(0)
    poses = [np.array(pose)]
    for _ in range(steps):
        ranges = scan(poses[-1], segments, rng.normal(0, 0.02, 180))
        action = controller.drive(to_robot(target, poses[-1]), ranges, final=True)
        assert np.all(np.abs(action) <= 1)
        poses.append(move(poses[-1], action))
        assert clearance(poses[-1][:2], segments) > 0.25
        if np.hypot(*to_robot(target, poses[-1])) < 0.15:
            break
    return poses


@pytest.mark.parametrize("y", [-2.5, -1.0, 0.0, 2.0])
@pytest.mark.parametrize("heading", [0.0, 2.5])
def test_passes_a_door_at_any_angle(y: float, heading: float) -> None:
    segments = np.array(ROOM + WALL_WITH_DOOR, float)
    poses = drive((-1.5, y, heading), (1.5, -y), segments, 120)
    assert np.hypot(poses[-1][0] - 1.5, poses[-1][1] + y) < 0.15


def test_drives_around_desks() -> None:
    segments = np.array(ROOM + WALL_WITH_DOOR + DESKS, float)
    poses = drive((-3.5, 2.0, -1.0), (3.0, 0.2), segments, 200)
    assert np.hypot(poses[-1][0] - 3.0, poses[-1][1] - 0.2) < 0.15
    length = np.sum(np.hypot(*np.diff([p[:2] for p in poses], axis=0).T))
    assert length < 9.5  # straight lines through the middle of the door measure 8.0 m


def test_drives_at_full_speed_in_the_open() -> None:
    poses = drive((-9, 0, 0), (9, 0), np.array(box(-10, -1, 10, 1), float), 195)
    assert len(poses) < 192


def test_stops_at_a_final_target() -> None:
    controller = LocalController(RobotConfig())
    ranges = np.full(180, 10.0)
    assert controller.drive((0.01, 0.0), ranges, final=True) == pytest.approx([0, 0])
    assert controller.drive((0.3, 0.0), ranges, final=True)[0] < controller.drive((0.3, 0.0), ranges)[0]


def test_says_that_a_closed_room_is_blocked() -> None:
    controller = LocalController(RobotConfig())
    ranges = scan(np.array([-1.0, 0, 0]), np.array(box(-3, -2, 1, 2), float))
    controller.drive((3.5, 0.0), ranges)
    assert controller.blocked
    controller.drive((1.0, 1.0), ranges)
    assert not controller.blocked


def test_a_gap_too_narrow_is_no_way() -> None:
    controller = LocalController(RobotConfig())
    segments = np.array([*ROOM, (0, -3, 0, -0.22), (0, 0.22, 0, 3)], float)
    controller.drive((2.0, 0.0), scan(np.array([-1.0, 0, 0]), segments))
    assert controller.path[-1, 0] < 1.0


def test_touching_a_wall_it_gets_away() -> None:
    segments = np.array(ROOM, float)
    controller = LocalController(RobotConfig())
    pose = np.array([3.76, 0.0, 0.0])
    for _ in range(60):
        before = clearance(pose[:2], segments)
        pose = move(pose, controller.drive(to_robot((-2.0, 0.0), pose), scan(pose, segments)))
        assert clearance(pose[:2], segments) >= min(before, 0.25) - 1e-6
    assert pose[0] < 0


def test_wrong_number_of_rays_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\(90,\).*\(180,\)"):
        LocalController(RobotConfig()).drive((1, 0), np.zeros(90))
