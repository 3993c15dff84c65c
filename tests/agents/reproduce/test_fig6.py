"""Fig. 6: the figures of runs drawn by hand, the picture, and the paper's statements as a slow test."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.accuracy import Tour
from agents.reproduce import fig6
from agents.reproduce.draw_fig6 import draw_fig6
from slam.region import REGION
from slam.region_map import RegionMap


def course(seed: int, off: float, optimum: float | None = None, **figures: Any) -> fig6.Course:
    """A straight run of 20 m; half way the estimate is off by `off` m, at the end by a tenth of it."""
    true = np.zeros((21, 3))
    true[:, 0] = np.arange(21.0)
    estimated = true.copy()
    estimated[:, 1] = np.interp(np.arange(21), [0, 10, 20], [0, off, off / 10])
    tour = Tour(estimated, np.zeros((21, 3, 3)), true, RegionMap(), np.zeros(0, REGION), [])
    given = {
        "ape_max": off,
        "ape_end": off / 10,
        "regions_seen": 5,
        "regions_mapped": 5,
        "duplicates": 0,
        "missed": 0,
        "spurious": 0,
        "type_accuracy": 1.0,
        "region_iou": 0.8,
        "pose_nees": 1.0,
        "region_nees": 2.0,
        **figures,
    }
    return fig6.Course(seed, tour, given, optimum)


COURSES = [
    course(0, 0.2),
    course(1, 1.5, optimum=1.2, duplicates=2, regions_mapped=7),
    course(2, 0.4, missed=1, type_accuracy=0.9, region_nees=None),
    course(3, 0.6),
]


def test_figures_by_hand() -> None:
    result = fig6.fig6(COURSES, 4)
    assert (result["seeds"], result["n_particles"]) == (4, 4)
    assert result["ape_max_median"] == pytest.approx(0.5)
    assert result["ape_max_worst"] == 1.5
    assert result["ape_end_median"] == pytest.approx(0.05)
    assert result["below_1m"] == 0.75
    assert (result["duplicates"], result["missed"], result["spurious"]) == (2, 1, 0)
    assert (result["regions_seen"], result["regions_mapped"]) == (5.0, 5.5)
    assert result["type_accuracy"] == pytest.approx(0.975)
    assert result["region_nees"] == pytest.approx(2.0)  # over the runs that have it
    assert result["misses"] == [{"seed": 1, "ape_max": 1.5, "optimum_ape_max": 1.2}]


def test_the_run_that_is_shown_is_the_median_one() -> None:
    assert fig6.median_course(COURSES).seed == 2
    assert fig6.course_length(COURSES[0]) == pytest.approx(20.0)
    assert COURSES[1].position_errors.max() == pytest.approx(1.5)


def test_the_comparison_says_how_many_runs_stay_below_a_metre() -> None:
    rows = {row[0]: row[2] for row in fig6.comparison(fig6.fig6(COURSES, 4), 20.0)}
    assert rows["position error at all times"] == "below 1 m in 3 of 4 runs"
    assert rows["map"] == "5.5 of 5 regions; in all 1 missed, 2 twice"


@pytest.mark.compiled
def test_one_run_of_the_course_is_drawn(tmp_path: Path) -> None:
    run = fig6.run_course(0)
    assert run.figures["ape_max"] < fig6.BELOW
    assert run.optimum is None
    draw_fig6([run], fig6.fig6([run], 4), tmp_path / "fig6.png")
    assert (tmp_path / "fig6.png").stat().st_size > 20_000


@pytest.mark.slow
def test_the_papers_statements_hold_over_twenty_seeds() -> None:
    result = fig6.fig6([fig6.run_course(seed) for seed in range(20)], 4)
    assert result["below_1m"] == 1.0
    assert result["ape_end_median"] < 0.05
    assert (result["duplicates"], result["missed"], result["type_accuracy"]) == (0, 0, 1.0)
