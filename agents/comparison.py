"""How near does the filter come to the optimum of the same data? Many seeds, errors in the map frame, calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from agents.accuracy import follow, mean_pose_nees, normalised_regions, quality_of, told
from agents.batch import AVAILABLE, Batch
from agents.optimum import ekf_region_nees, lines, online
from agents.recording import Recording, record
from slam import SlamConfig
from slam.evaluation.consistency import nees_band
from slam.evaluation.trajectory import ape
from slam.rows import Floats

FASTSLAM = "fastslam2"
"""FastSLAM 2.0; its rows end with their number of particles."""

JOINT = "joint"
"""The joint posterior; its hypotheses are as many as the data leave open, so one limit on their number will do."""

OPTIMUM, BATCH = "optimum", "batch"

BELOW = 1.0
"""What the largest error is held against, m."""

Row = dict[str, float]


def compare(
    seed: int,
    particles: Sequence[int] = (4, 16),
    noise: str = "standard",
    occlusion: bool = False,
    calibrated: bool = False,
    steps: int | None = None,
) -> dict[str, Row]:
    """Run every filter, the online optimum and, where GTSAM is installed, the batch on the data of one seed.

    Returns
    -------
    dict
        By name, of each: `ape_rmse`, `ape_max`, `ape_end` (m, raw), `ape_aligned` (RMSE after SE(2) alignment) and,
        but for the batch, `pose_nees` (mean over the course, divided by 3), `regions`, `region_nees` and
        `region_freedom` (number of mapped regions, and sums over them).
    """
    recording = record(seed, noise, occlusion, calibrated=calibrated, steps=steps)
    rows = {f"{FASTSLAM}_{n}": _filter(recording, SlamConfig(n, **told(recording))) for n in particles}
    rows[JOINT] = _filter(recording, SlamConfig(min(particles), posterior="joint", **told(recording)))
    ekf, poses, covariances = online(recording)
    rows[OPTIMUM] = {
        **_errors(poses, recording.true),
        "pose_nees": mean_pose_nees(poses, covariances, recording.true),
        **_pooled(list(ekf_region_nees(ekf, recording))),
    }
    if AVAILABLE:
        batch = Batch(recording.noise.odometry, recording.moves, lines(recording), ekf, poses)
        rows[BATCH] = _errors(batch.solve(), recording.true)
    return rows


def _filter(recording: Recording, config: SlamConfig) -> Row:
    run = follow(recording, config)
    return {
        **_errors(run.estimated, run.true),
        "pose_nees": mean_pose_nees(run.estimated, run.covariances, run.true),
        **_pooled(normalised_regions(run, quality_of(run))),
    }


def _pooled(regions: Sequence[tuple[float, int]]) -> Row:
    """Return what is left of the NEES and degrees of freedom of each region: their number and sums."""
    values, freedom = np.array(regions).T
    known = freedom > 0
    return {
        "regions": float(known.sum()),
        "region_nees": float(values[known].sum()),
        "region_freedom": float(freedom.sum()),
    }


def _errors(estimated: Floats, true: Floats) -> Row:
    raw = ape(estimated, true).position
    aligned = ape(estimated, true, align=True).position
    return {"ape_rmse": raw.rmse, "ape_max": raw.max, "ape_end": raw.end, "ape_aligned": aligned.rmse}


def summarize(runs: Sequence[Mapping[str, Row]], particles: Sequence[int]) -> dict[str, Any]:
    """Return the figures of many seeds together.

    Returns
    -------
    dict
        `ratio_to_optimum`: RMSE pooled over the seeds over that of the online optimum, with the largest number of
        particles; `ratio_to_optimum_4` with 4 of them; `ratio_to_batch`; each also with `_aligned` and `_p90` (90th
        percentile of the seeds' RMSE); `filters`, the figures of each by name; `pose_nees_band` and `region_nees_band`,
        where a calibrated filter's means lie with 95 %; and `runs`. The poses of one course share their errors, and so
        do the regions of one map: the bands take one pose and one region of each seed as independent.
    """
    names = list(runs[0])
    filters = {name: _figures([run[name] for run in runs]) for name in names}
    result: dict[str, Any] = {"seeds": len(runs), "particles": list(particles)}
    pairs = {
        "ratio_to_optimum": (f"{FASTSLAM}_{max(particles)}", OPTIMUM),
        "ratio_to_optimum_4": (f"{FASTSLAM}_4", OPTIMUM),
        "ratio_to_batch": (f"{FASTSLAM}_{max(particles)}", BATCH),
    }
    for key, (name, reference) in pairs.items():
        for suffix, figure in (("", "ape_rmse"), ("_aligned", "ape_aligned"), ("_p90", "ape_rmse_p90")):
            known = name in filters and reference in filters
            result[key + suffix] = filters[name][figure] / filters[reference][figure] if known else None
    low, high = nees_band(len(runs), 3)
    result["pose_nees_band"] = [low / 3, high / 3]
    freedom = round(float(np.mean([run[OPTIMUM]["region_freedom"] / run[OPTIMUM]["regions"] for run in runs])))
    low, high = nees_band(len(runs), freedom)
    result["region_nees_band"] = [low / freedom, high / freedom]
    return {**result, "filters": filters, "runs": list(runs)}


def _figures(rows: Sequence[Row]) -> dict[str, float]:
    """Return the figures of one filter over all seeds."""

    def every(name: str) -> Floats:
        return np.array([row[name] for row in rows])

    figures = {
        "ape_rmse": float(np.sqrt(np.mean(every("ape_rmse") ** 2))),
        "ape_aligned": float(np.sqrt(np.mean(every("ape_aligned") ** 2))),
        "ape_rmse_p90": float(np.quantile(every("ape_rmse"), 0.9)),
        "ape_max_median": float(np.median(every("ape_max"))),
        "ape_max_worst": float(np.max(every("ape_max"))),
        "ape_end_median": float(np.median(every("ape_end"))),
        "below_1m": float(np.mean(every("ape_max") < BELOW)),
    }
    if "pose_nees" in rows[0]:
        figures["pose_nees"] = float(np.mean(every("pose_nees")))
        figures["region_nees"] = float(every("region_nees").sum() / every("region_freedom").sum())
    return figures
