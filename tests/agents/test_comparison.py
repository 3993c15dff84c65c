"""The comparison with the optimum: how figures of single seeds become ratios, and a short tour of the real thing."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

from agents import accuracy, comparison
from agents.batch import AVAILABLE
from agents.cli import app
from agents.comparison import compare, summarize
from agents.parallel import over_seeds
from agents.recording import institute, record


def row(rmse, aligned=1.0, largest=0.5, pose=None, regions=(10, 50.0, 40.0)):
    values = {"ape_rmse": rmse, "ape_max": largest, "ape_end": 0.1, "ape_aligned": aligned}
    if pose is not None:
        names = ("regions", "region_freedom", "region_nees")
        values |= {"pose_nees": pose, **dict(zip(names, regions, strict=True))}
    return values


def test_errors_are_pooled_over_the_seeds():
    runs = [
        {
            "fastslam2_4": row(0.3, pose=5.0, largest=1.2),
            "fastslam2_16": row(0.1, pose=3.0),
            "optimum": row(0.1, 0.5, pose=1.0),
        },
        {"fastslam2_4": row(0.4, pose=7.0), "fastslam2_16": row(0.7, pose=3.0), "optimum": row(0.7, 0.5, pose=2.0)},
    ]
    result = summarize(runs, [4, 16])
    assert result["seeds"] == 2
    assert result["ratio_to_optimum"] == pytest.approx(1.0)
    assert result["ratio_to_optimum_4"] == pytest.approx(math.sqrt(0.25 / 0.5))
    assert result["ratio_to_optimum_aligned"] == pytest.approx(2.0)
    assert result["ratio_to_batch"] is None
    assert result["filters"]["fastslam2_4"]["below_1m"] == 0.5
    assert result["filters"]["fastslam2_4"]["pose_nees"] == 6.0
    assert result["filters"]["optimum"]["region_nees"] == pytest.approx(80 / 100)
    assert result["pose_nees_band"] == pytest.approx([1.2373 / 6, 14.449 / 6], rel=1e-4)  # chi-square of 2 x 3
    assert result["region_nees_band"] == pytest.approx([3.247 / 10, 20.483 / 10], rel=1e-4)
    assert result["runs"] == runs


def test_ratios_to_what_was_not_run_are_left_open():
    runs = [{"fastslam2_8": row(0.2, pose=1.0), "optimum": row(0.1, pose=1.0), "batch": row(0.05)}]
    result = summarize(runs, [8])
    assert result["ratio_to_optimum"] == pytest.approx(2.0)
    assert result["ratio_to_optimum_4"] is None
    assert result["ratio_to_batch"] == pytest.approx(4.0)


@pytest.mark.compiled
def test_all_filters_run_on_the_same_data():
    rows = compare(0, particles=(2,), steps=25)
    assert set(rows) == {"fastslam2_2", "joint", "optimum"} | ({"batch"} if AVAILABLE else set())
    for values in rows.values():
        assert 0 < values["ape_rmse"] < 0.3
        assert values["ape_aligned"] <= values["ape_rmse"] + 1e-12
    assert rows["optimum"]["regions"] >= rows["fastslam2_2"]["regions"] > 5
    assert rows == compare(0, particles=(2,), steps=25)


@pytest.mark.compiled
def test_recordings_depend_on_their_seed_alone():
    first, again, other = record(3, steps=2), record(3, steps=2), record(4, steps=2)
    assert np.array_equal(first.scans[1].records, again.scans[1].records)
    assert first.moves == again.moves
    assert first.moves != other.moves
    calibrated = record(3, steps=2, calibrated=True)
    assert calibrated.moves == first.moves
    assert calibrated.scans[0].records[0].x != first.scans[0].records[0].x
    assert (calibrated.noise.simulated_factor, first.noise.simulated_factor) == (1.0, 1.2)
    assert len(first.true) == 2
    assert len(record(3).true) == len(institute()[1]) - 1


@pytest.mark.slow
def test_the_filter_is_near_the_optimum():
    runs = list(over_seeds(compare, range(20), accuracy.warm_up))
    result = summarize(runs, [4, 16])
    assert result["ratio_to_optimum"] <= 1.15
    assert result["ratio_to_optimum_4"] <= 1.3


@pytest.mark.slow
def test_the_ekf_is_near_the_batch_and_calibrated_on_the_tour():
    runs = [compare(seed, particles=(4,), calibrated=True) for seed in range(6)]
    result = summarize(runs, [4])
    low, high = result["pose_nees_band"]
    assert low < result["filters"]["optimum"]["pose_nees"] < high
    assert result["filters"]["optimum"]["ape_max_worst"] < 1.0
    if AVAILABLE:
        assert result["filters"]["batch"]["ape_rmse"] < 1.1 * result["filters"]["optimum"]["ape_rmse"]


def test_the_command_prints_a_table_and_json(monkeypatch):
    asked = []

    def faked(seed, particles, **settings):
        asked.append((seed, list(particles), settings))
        return {**{f"fastslam2_{n}": row(0.2, pose=4.0) for n in particles}, "optimum": row(0.1, pose=1.0)}

    monkeypatch.setattr(comparison, "compare", faked)
    arguments = ["benchmark", "accuracy", "--seeds", "1", "--particles", "4", "--calibrated", "--json"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert asked == [(0, [4], {"noise": "standard", "occlusion": False, "calibrated": True})]
    assert "fastslam2_4" in result.stdout
    values = json.loads(result.stdout.rstrip("\n").split("\n")[-1])
    assert values["ratio_to_optimum"] == values["ratio_to_optimum_4"] == pytest.approx(2.0)
    assert values["calibrated"] is True
