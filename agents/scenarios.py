"""What goes wrong on real floors, one scenario each, with what is expected of the filter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.scenario_floors import long_hallway, symmetric_floor, twin_offices
from regionslam_env.config import NoiseConfig, noise_set
from regionslam_env.worlds.course import INSTITUTE_TOUR, course
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.world import World
from slam.rows import Floats

STANDARD = noise_set("standard")

ONCE = {"duplicates": 0, "spurious": 0, "missed": 0, "false_alarms": 0}
"""Every region is mapped once and nothing else is, and the filter never believes to be lost."""

SOUND = {"ape_max": 1.0, **ONCE}

HIDDEN = {**SOUND, "ape_max": 2.0, "ape_end": 0.5}

BLIND = {**SOUND, "false_alarms": 1}
"""After 20 m of dead reckoning the robot may well be lost."""

AWAY = ("office 10", "hallway 3", "service room", "classroom 1", "hallway 3", "lobby")
"""Where a kidnapped robot, carried away from the lobby, goes on."""


@dataclass(frozen=True, eq=False)
class Drive:
    """A true path and what goes wrong on it.

    Attributes
    ----------
    world, poses
        Where, and the true poses, shape (T + 1, 3).
    slip
        What the measured distance is multiplied by at each step, shape (T,).
    blind
        Steps whose scan is empty although the view is open, shape (T,).
    carried_at
        Step in which the robot is carried, and odometry notices nothing; None: never.
    """

    world: World
    poses: Floats
    slip: Floats
    blind: NDArray[np.bool_]
    carried_at: int | None = None


@dataclass(frozen=True)
class Scenario:
    """A drive, its sensors, and what is expected of every seed.

    Attributes
    ----------
    about
        In words.
    drive
        Makes the drive.
    limits
        Largest values of figures of `agents.robustness.run`; of `type_accuracy` the smallest.
    """

    about: str
    drive: Callable[[], Drive]
    limits: Mapping[str, float]
    noise: NoiseConfig = STANDARD
    occlusion: bool = False


def on(
    place: tuple[World, Floats],
    slip: tuple[float, float, float] | None = None,
    blind: tuple[float, float] | None = None,
    carried_at: int | None = None,
) -> Drive:
    """Return a drive; `slip` is (from, to, factor) and `blind` (from, to), in metres driven."""
    world, poses = place
    metres = np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))
    factors, dark = np.ones(len(metres)), np.zeros(len(metres), bool)
    if slip is not None:
        factors[(metres >= slip[0]) & (metres < slip[1])] = slip[2]
    if blind is not None:
        dark = (metres >= blind[0]) & (metres < blind[1])
    return Drive(world, poses, factors, dark, carried_at)


@cache
def tour() -> tuple[World, Floats]:
    """Return the institute and its tour of 328 m."""
    world = load("institute")
    return world, course(world, INSTITUTE_TOUR)


def standing() -> Drive:
    """Return a drive of 30 m with 1,000 scans at its end."""
    world, poses = tour()
    return on((world, np.concatenate([poses[:300], np.repeat(poses[299:300], 1000, axis=0)])))


def kidnapped() -> Drive:
    """Return the tour, at whose end the robot is carried 15 m away and goes on."""
    world, poses = tour()
    return on((world, np.concatenate([poses, course(world, AWAY)])), carried_at=len(poses) - 1)


def _disturbed(about: str, **noise: Any) -> Scenario:
    types = {"type_accuracy": 0.99} if "misclassification" in noise else {}
    return Scenario(about, lambda: on(tour()), SOUND | types, replace(STANDARD, **noise))


FOUND_AGAIN = {**SOUND, "detected": 15, "found": 25, "found_error": 0.5, "ape_end": 0.5}
"""A robot that was carried: scans until the filter is lost, and then until it knows where it is; and how far off, m."""

SCENARIOS: Mapping[str, Scenario] = {
    "standard": _disturbed("the tour as it is"),
    # Fewer regions are in view at a time, so that the error grows farther until a place is seen again.
    "occlusion": Scenario("walls hide regions", lambda: on(tour()), HIDDEN, occlusion=True),
    "heavy noise": Scenario("noise set heavy", lambda: on(tour()), SOUND, noise_set("heavy")),
    "slip, new floor": Scenario("odometry 30 % short, 10 m", lambda: on(tour(), slip=(20, 30, 0.7)), SOUND),
    "slip, known floor": Scenario("odometry 30 % long, 10 m", lambda: on(tour(), slip=(280, 290, 1.3)), SOUND),
    "misses": _disturbed("10 % of the regions in view are missed", misses=0.1),
    "false positives": _disturbed("every tenth scan has an invented region", false_positives=0.1),
    "wrong types": _disturbed("20 % of the types are wrong", misclassification=0.2),
    "all three": _disturbed("all of this at once", misses=0.1, false_positives=0.1, misclassification=0.2),
    "blind": Scenario("no regions for 20 m", lambda: on(tour(), blind=(150, 170)), BLIND),
    "twin offices": Scenario("alike, side by side", lambda: on(twin_offices()), {**SOUND, "ape_max": 0.5}),
    "symmetry": Scenario("alike in four directions", lambda: on(symmetric_floor()), {**SOUND, "ape_max": 0.5}),
    # The heading of the hallway is known from the first metres alone: 0.01 rad are 0.6 m at its far end.
    "long hallway": Scenario("60 m, bare", lambda: on(long_hallway()), {**ONCE, "ape_max": 1.5, "ape_end": 0.5}),
    # At the end of the view, the first scan that sees an edge closed may come late: there a region grows to the truth.
    "standing": Scenario("1,000 scans in one place", standing, {**SOUND, "drift": 0.02, "growth": 0.5}),
    "kidnapped": Scenario("carried 15 m away after the tour", kidnapped, FOUND_AGAIN),
    "kidnapped, occlusion": Scenario(
        "the same with walls that hide regions",
        kidnapped,
        {**FOUND_AGAIN, **HIDDEN, "found_error": 1.0},
        occlusion=True,
    ),
}
"""By name. What is not said otherwise: below 1 m at all times, every region mapped once, nothing else mapped."""
