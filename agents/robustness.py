"""How does the filter bear what goes wrong? Figures of one seed of a scenario, and of many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.scenarios import SCENARIOS, Drive, Scenario
from regionslam_env.config import SensorConfig
from regionslam_env.sensors.odometry import OdometrySensor
from regionslam_env.sensors.region_sensor import RegionSensor
from slam import RegionMap, RegionSLAM, SlamConfig
from slam.evaluation.map_quality import map_quality
from slam.evaluation.trajectory import alignment, position_errors
from slam.measurement import Scan
from slam.motion import Odometry
from slam.rows import Floats, Row
from slam.se2 import between, compose

SETTLED = 500
"""Scans before the end after which a standing robot's regions should no longer change."""

SEEN_ENOUGH = 5
"""A region that was in view in fewer scans need not be mapped: some scans leave doubts, or miss it."""

SMALLEST = ("type_accuracy",)
"""Figures of which the smallest is the worst."""


def run(name: str, seed: int) -> dict[str, Any]:
    """Run a scenario with one seed and return its figures.

    Returns
    -------
    dict
        `ape_max`, `ape_end` (m); of the map (after SE(2) alignment of the path, for errors of position have figures of
        their own) `duplicates`, `spurious`, `missed`, `type_accuracy`; `false_alarms`, how often the filter was lost
        for no reason; where the robot stands at last, `drift` (m) and `growth` (largest shift of a region's end over
        the last 500 scans, m); where it was carried, `detected` and `found` (scans until it was lost, and then until it
        was not, None: never) and `found_error` (m). `ape_max` is that before it was carried. And `passed`.
    """
    scenario = SCENARIOS[name]
    drive = scenario.drive()
    estimated, lost, early, late, seen = _drive(scenario, drive, seed)
    true = np.array([between(drive.poses[0], pose) for pose in drive.poses[1:]])
    error = position_errors(estimated, true)
    frame = compose(drive.poses[0], alignment(estimated, true))
    quality = map_quality(late.regions, drive.world.regions, (), seen, pose=frame)
    end = len(lost) if drive.carried_at is None else drive.carried_at
    figures: dict[str, Any] = {
        "ape_max": float(error[:end].max()),
        "ape_end": float(error[-1]),
        "duplicates": len(quality.duplicates),
        "spurious": len(quality.spurious),
        "missed": len(quality.missed),
        "type_accuracy": quality.type_accuracy,
        "false_alarms": int(np.count_nonzero(lost[1:end] > lost[: end - 1])),
    }
    if drive.carried_at is not None:
        figures |= _found_again(lost[end:], error[end:])
    if np.array_equal(drive.poses[-SETTLED], drive.poses[-1]):
        figures["drift"] = float(np.hypot(*(estimated[-1] - estimated[-2 * SETTLED])[:2]))
        figures["growth"] = max(_shift(late[a.id].row, a.row) for a in early.regions if a.id in late)
    return {"scenario": name, "seed": seed, **figures, "passed": _passed(figures, scenario.limits)}


def _drive(
    scenario: Scenario, drive: Drive, seed: int
) -> tuple[Floats, NDArray[np.bool_], RegionMap, RegionMap, list[str]]:
    """Return estimated poses, when the filter was lost, its map `SETTLED` scans before the end and at it, ids seen."""
    odometry_rng, region_rng, filter_rng = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(3))
    odometer = OdometrySensor(scenario.noise, odometry_rng)
    sensor = RegionSensor(SensorConfig(occlusion=scenario.occlusion), scenario.noise, drive.world.arrays, region_rng)
    config = SlamConfig(motion_noise=scenario.noise.odometry, measurement_noise=scenario.noise.regions)
    slam = RegionSLAM(config, filter_rng)
    steps, early = len(drive.slip), RegionMap()
    estimated, lost = np.empty((steps, 3)), np.zeros(steps, bool)
    for k, (before, after) in enumerate(pairwise(drive.poses)):
        odometry, scan = odometer.measure(before, after), sensor.measure(after)
        odometry = Odometry(0.0) if k == drive.carried_at else odometry
        odometry = replace(odometry, distance=odometry.distance * drive.slip[k])
        belief = slam.step(odometry, Scan([], scan.view) if drive.blind[k] else scan)
        estimated[k], lost[k] = belief.pose_mean, belief.lost
        if k == steps - SETTLED:
            early = belief.map
    often = zip(drive.world.regions, sensor.sightings, strict=True)
    return estimated, lost, early, slam.belief.map, [region.id for region, n in often if n >= SEEN_ENOUGH]


def _found_again(lost: NDArray[np.bool_], error: Floats) -> dict[str, Any]:
    """Return the figures of a robot that was carried in the first of these steps."""
    if not lost.any():
        return {"detected": None, "found": None, "found_error": None}
    detected = int(np.argmax(lost))
    if lost[detected:].all():
        return {"detected": detected + 1, "found": None, "found_error": None}
    found = int(np.argmin(lost[detected:]))
    return {"detected": detected + 1, "found": found, "found_error": float(error[detected + found])}


def _shift(late: Row, early: Row) -> float:
    """Return by how much the ends of a row differ from earlier ones along its axes at most, m."""
    corners = early.to_local(late.outline())
    low, high = (early.u[0], early.b.min()), (early.u[-1], early.t.max())
    return float(max(np.abs(corners.min(axis=0) - low).max(), np.abs(corners.max(axis=0) - high).max()))


def _passed(figures: Mapping[str, Any], limits: Mapping[str, float]) -> bool:
    for name, limit in limits.items():
        value = figures[name]
        if value is None or (value < limit if name in SMALLEST else value > limit):
            return False
    return True


def run_item(number: int, names: Sequence[str], seeds: int) -> dict[str, Any]:
    """Run one of `seeds` seeds of one of the scenarios, numbered scenario by scenario."""
    return run(names[number // seeds], number % seeds)


def warm_up() -> None:
    """Compile all that a scenario runs."""
    run("twin offices", 0)


def summary(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return of all runs of one scenario: how many `passed`, median and worst of each figure (None is worst)."""
    names = [name for name in runs[0] if name not in ("scenario", "seed", "passed")]
    figures = {}
    for name in names:
        values = [run[name] for run in runs if run[name] is not None]
        worst = min if name in SMALLEST else max
        figures[name] = {
            "median": float(np.median(values)) if values else None,
            "worst": float(worst(values)) if len(values) == len(runs) else None,
        }
    scenario = runs[0]["scenario"]
    passed = sum(run["passed"] for run in runs)
    return {"scenario": scenario, "about": SCENARIOS[scenario].about, "passed": passed, "figures": figures}
