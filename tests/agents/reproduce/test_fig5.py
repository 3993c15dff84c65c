from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from agents.reproduce.draw_fig5 import draw_fig5
from agents.reproduce.fig5 import PLACE, RANGE, comparison, course, errors, fig5, fig5_runs, measure, track
from slam.evaluation.consistency import nees_band
from slam.measurement import MEASUREMENT

pytestmark = pytest.mark.compiled


def test_the_course_goes_to_and_fro_and_never_sees_the_whole_region() -> None:
    poses = course()
    assert poses.shape == (3600, 3)
    assert poses[[0, 299, 300, 599], 0].tolist() == pytest.approx([-5.98, 5.98, 5.98, -5.98])
    assert np.abs(poses[:, 1]).max() < 0.31
    heading = np.stack([np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])], axis=1)
    step = np.diff(poses[:, :2], axis=0)
    assert np.all((step * heading).sum(axis=1)[np.linalg.norm(step, axis=1) > 1e-9] > 0)
    records = measure(0)
    assert len(records) == 3600
    assert (records["w"] + records["sub_w"].sum(axis=1)).max() < 2 * RANGE + 1.5


def test_a_perfect_estimate_has_no_error() -> None:
    truth = PLACE.parameters()
    figures = np.zeros(1, MEASUREMENT)
    for name in ("x", "y", "w", "h"):
        figures[name] = truth[name]
    figures["phi"] = truth["phi"] + 2 * np.pi
    for side, name in enumerate(("left", "right")):
        figures["sub_w"][:, side], figures["sub_h"][:, side], figures["sub_y"][:, side] = truth[name]
    np.testing.assert_allclose(errors(figures), 0.0, atol=1e-12)
    figures["sub_y"][0, 1] += 0.25
    assert errors(figures)[0].tolist() == pytest.approx([0.0] * 10 + [0.25])


def test_one_seed_gives_every_figure_and_a_picture(tmp_path: Path) -> None:
    runs = list(fig5_runs(1))
    result = fig5(runs)
    assert result["seeds"] == 1
    for update in ("edges", "paper"):
        figures = result[update]
        assert 200 < figures["step_complete"] < 300
        assert figures["trace_end"] < 1e-2 * figures["trace_start"]
        assert figures["rmse_length"] == abs(runs[0][update].length[0]) < 0.15
    assert len(comparison(result)) == 7
    again = track(0)
    assert again["edges"].length == runs[0]["edges"].length
    draw_fig5(runs, tmp_path / "fig5.png")
    assert (tmp_path / "fig5.png").stat().st_size > 20_000


@pytest.mark.slow
def test_the_edge_form_is_accurate_and_knows_how_wrong_it_is() -> None:
    """Acceptance of Fig. 5 on 60 seeds; simulated covariances are 1.2 times the told ones."""
    result = fig5(list(fig5_runs(60)))
    low, high = (1.2 * bound for bound in nees_band(60, 1))
    edges, paper = result["edges"], result["paper"]
    assert edges["rmse_length"] < 0.015
    assert edges["rmse_w"] < 0.01
    assert low < edges["nees_length"] < high
    assert low < edges["nees_w"] < high
    assert paper["nees_length"] > high  # blocks without the correlation of midpoint and size know too much
