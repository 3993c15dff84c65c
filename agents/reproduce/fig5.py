"""Fig. 5 of Oberländer et al. 2008: one region, larger than the sensor's range, estimated from partial views alone.

The robot knows its pose and goes to and fro along the long axis of a region of three rectangles. The same measurements
go into both geometric updates: the paper's and the edge form.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.parallel import over_seeds
from regionslam_env.config import NoiseConfig, SensorConfig
from regionslam_env.sensors.region_sensor import RegionSensor
from regionslam_env.worlds.world import Region, World
from slam.comparison import CANDIDATE, compare
from slam.config import GEOMETRIC_UPDATES, Parameters, SlamConfig
from slam.evaluation.consistency import nees_band
from slam.geometric_update import fuse_as_set, start
from slam.growth import take_row
from slam.innovation import workspaces
from slam.jit import Array, njit
from slam.measurement import MEASUREMENT, MeasurementNoise
from slam.parameters import to_parameters
from slam.particles import PARTICLE
from slam.region import MAX_STATE, REGION, u_index
from slam.rows import Floats, Row
from slam.turning import observe, turn

PLACE = Row.from_parameters(0.0, 0.0, 8.0, 4.0, left=(5.0, 2.4, 0.4), right=(5.0, 3.0, -0.3))
"""The region: 18 m from left to right."""

RANGE = 5.0
PASSES, POSITIONS = 12, 300
"""Times along the region, and positions of each time."""

SIMULATED = 1.2
"""Simulated over told covariance."""

NOISE = NoiseConfig(regions=MeasurementNoise(0.10, 0.20, 0.03), simulated_factor=SIMULATED)


class Track(NamedTuple):
    """What one update made of one seed."""

    squared_error: Floats  # (T,) summed over the parameters of Fig. 1, m² and rad²
    trace: Floats  # (T,) of their covariance
    complete: int  # first step with all edges closed, or T
    length: tuple[float, float]  # error (m) and variance (m²) of the whole length at the end
    width: tuple[float, float]  # and of the main rectangle's width


def course() -> Floats:
    """Return the poses (x, y, theta), shape (T, 3): from x = -6 m to 6 m and back, with a slight lateral sine."""
    share = (np.arange(POSITIONS) + 0.5) / POSITIONS
    x, y = -6 + 12 * share, 0.3 * np.sin(2 * np.pi * share)
    passes = []
    for k in range(PASSES):
        along, across = (x, y) if k % 2 == 0 else (x[::-1], y[::-1])
        theta = np.arctan2(np.gradient(across), np.gradient(along))
        passes.append(np.stack([along, across, theta], axis=1))
    return np.concatenate(passes)


def measure(seed: int) -> NDArray[np.void]:
    """Return what a sensor without occlusion measures of the region along the course, shape (T,) of `MEASUREMENT`."""
    world = World("fig5", (Region("hallway", "hallway", "hallway", PLACE),), np.zeros((0, 4)))
    config = SensorConfig(range=RANGE, occlusion=False)
    sensor = RegionSensor(config, NOISE, world.arrays, np.random.default_rng(seed))
    return np.concatenate([sensor.measure(pose).records for pose in course()])


@njit
def follow(records: Array, poses: Array, parameters: tuple[Any, ...], figures: Array, m: Array) -> int:
    """Estimate the region from measurements at known poses; return the first step with all edges closed, or T.

    `figures` (T,) of `MEASUREMENT`: the estimate after every step, left to right as the truth is; `m` (1,) of `REGION`:
    the last one. Both are written.
    """
    p = Parameters(*parameters)
    work = workspaces(p.tolerance)
    descriptions, scratch = np.zeros((1, 4), REGION), np.zeros(1, REGION)
    candidates, robots = np.zeros(1, CANDIDATE), np.zeros(1, PARTICLE)
    type_numbers = np.zeros(1, np.int64)
    complete = len(records)
    for t in range(len(records)):
        observe(records[t : t + 1], type_numbers, descriptions)
        candidate, robot = candidates[0], robots[0]
        robot.pose[:] = poses[t]
        if t == 0:
            start(descriptions[0, 0], poses[0], m[0], p)
        elif compare(descriptions[0], m[0], robot, p, work[0], scratch[0], candidate):
            if candidate.turn_map:
                turn(m[0], 1, scratch[0])
                take_row(scratch[0], m[0])
            fuse_as_set(descriptions[0, candidate.turn], m[0], candidate.offset, poses[t], work[0], p)
        turn(m[0], 0 if np.cos(m[0].state[0]) > 0 else 2, scratch[0])
        to_parameters(scratch[0], figures[t])
        if complete == len(records) and m[0].n == 3 and m[0].closed.sum() == MAX_STATE:
            complete = t
    return complete


def errors(figures: NDArray[np.void]) -> Floats:
    """Return estimates minus truth, shape (T, 11): x, y, w, h, phi, then w, h, y of the left and right subrectangle.

    A subrectangle that was not seen yet counts as one of size 0.
    """
    truth = PLACE.parameters()
    out = np.empty((len(figures), 11))
    for k, name in enumerate(("x", "y", "w", "h", "phi")):
        out[:, k] = figures[name] - truth[name]
    out[:, 4] = np.remainder(out[:, 4] + np.pi, 2 * np.pi) - np.pi
    for side, name in enumerate(("left", "right")):
        for k, field in enumerate(("sub_w", "sub_h", "sub_y")):
            out[:, 5 + 3 * side + k] = figures[field][:, side] - truth[name][k]
    return out


def traces(figures: NDArray[np.void]) -> Floats:
    """Return the trace of the covariance of all parameters, shape (T,), m² and rad²."""
    blocks = [figures["cov_xy"], figures["cov_wh"], figures["sub_cov_wh"][:, 0], figures["sub_cov_wh"][:, 1]]
    return sum(np.trace(b, axis1=1, axis2=2) for b in blocks) + figures["var_phi"] + figures["sub_var_y"].sum(axis=1)


def track(seed: int) -> dict[str, Track]:
    """Return what both updates make of the measurements of one seed."""
    records, poses, out = measure(seed), course(), {}
    for update in GEOMETRIC_UPDATES:
        config = SlamConfig(measurement_noise=NOISE.regions, sensor_range=RANGE, geometric_update=update)
        figures, m = np.zeros(len(records), MEASUREMENT), np.zeros(1, REGION)
        complete = follow(records, poses, tuple(config.parameters()), figures, m)
        spans = [((0, int(m[0].n)), PLACE.u[-1] - PLACE.u[0]), ((1, 2), PLACE.u[2] - PLACE.u[1])]
        length, width = (_span(m[0], u_index(i), u_index(j), true) for (i, j), true in spans)
        out[update] = Track((errors(figures) ** 2).sum(axis=1), traces(figures), complete, length, width)
    return out


def _span(m: np.record, i: int, j: int, true: float) -> tuple[float, float]:
    """Return the error and the variance of the distance between two boundaries."""
    return float(m.state[j] - m.state[i] - true), float(m.cov[i, i] + m.cov[j, j] - 2 * m.cov[i, j])


def fig5(runs: Sequence[dict[str, Track]]) -> dict[str, Any]:
    """Return the figures of all seeds' runs, ready for JSON.

    Returns
    -------
    dict
        `seeds`; `nees_band`, the 95 % band of a mean NEES for the simulated noise; and for each update `rmse_length`
        and `rmse_w` (m) of the whole length and the main width at the end, `nees_length` and `nees_w`, `trace_start`
        and `trace_end` of the covariance, and `step_complete`, the mean step at which all edges are closed.
    """
    low, high = nees_band(len(runs), 1)
    result: dict[str, Any] = {"seeds": len(runs), "nees_band": [SIMULATED * low, SIMULATED * high]}
    for update in GEOMETRIC_UPDATES:
        tracks = [run[update] for run in runs]
        length, width = (np.array([getattr(track, name) for track in tracks]) for name in ("length", "width"))
        result[update] = {
            "rmse_length": math.sqrt(np.mean(length[:, 0] ** 2)),
            "rmse_w": math.sqrt(np.mean(width[:, 0] ** 2)),
            "nees_length": float(np.mean(length[:, 0] ** 2 / length[:, 1])),
            "nees_w": float(np.mean(width[:, 0] ** 2 / width[:, 1])),
            "trace_start": float(np.mean([track.trace[0] for track in tracks])),
            "trace_end": float(np.mean([track.trace[-1] for track in tracks])),
            "step_complete": float(np.mean([track.complete for track in tracks])),
        }
    return result


def fig5_runs(seeds: int, workers: int | None = None) -> Iterator[dict[str, Track]]:
    """Yield the runs of seeds 0 to `seeds` - 1, in parallel."""
    return over_seeds(track, range(seeds), warm_up=partial(track, 0), workers=workers)


def comparison(result: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return the figures of both updates, row by row: (what, the paper's update, the edge form)."""
    low, high = result["nees_band"]
    rows = [
        ("error of the whole length (RMS)", "rmse_length", "{:.4f} m"),
        ("error of the main width (RMS)", "rmse_w", "{:.4f} m"),
        (f"NEES of the length ({low:.2f} to {high:.2f} is honest)", "nees_length", "{:.2f}"),
        (f"NEES of the width ({low:.2f} to {high:.2f} is honest)", "nees_w", "{:.2f}"),
        ("trace of the covariance, first", "trace_start", "{:.3g}"),
        ("trace of the covariance, last", "trace_end", "{:.3g}"),
        ("step at which all edges are closed (the paper: about 150)", "step_complete", "{:.0f}"),
    ]
    return [(what, form.format(result["paper"][key]), form.format(result["edges"][key])) for what, key, form in rows]
