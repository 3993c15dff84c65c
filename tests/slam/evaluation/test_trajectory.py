"""Absolute and relative pose errors of drawn trajectories."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slam.evaluation.trajectory import ErrorStatistics, alignment, ape, rpe
from slam.se2 import compose

LINE = np.array([[x, 0.0, 0.0] for x in range(5)])


def test_statistics() -> None:
    assert ErrorStatistics.of([3.0, 4.0, 0.0, 1.0]) == ErrorStatistics(
        rmse=math.sqrt(26 / 4), max=4.0, mean=2.0, end=1.0
    )


def test_ape_of_a_sideways_drift() -> None:
    estimated = LINE + [[0, 0.1 * k, 0] for k in range(5)]
    error = ape(estimated, LINE)
    assert error.position.max == error.position.end == pytest.approx(0.4)
    assert error.position.mean == pytest.approx(0.2)
    assert error.position.rmse == pytest.approx(0.1 * math.sqrt((1 + 4 + 9 + 16) / 5))
    assert error.heading.max == 0


def test_heading_errors_are_wrapped() -> None:
    a, b = LINE.copy(), LINE.copy()
    a[:, 2], b[:, 2] = 3.1, -3.1
    assert ape(a, b).heading.rmse == pytest.approx(2 * math.pi - 6.2)
    assert rpe(a, a).heading.max == 0


def test_alignment_takes_out_a_rigid_motion() -> None:
    rng = np.random.default_rng(4)
    true = rng.normal(size=(20, 3))
    estimated = compose((1.0, -2.0, 2.5), true)
    assert ape(estimated, true).position.rmse > 1
    assert ape(estimated, true, align=True).position.max == pytest.approx(0, abs=1e-12)
    assert ape(estimated, true, align=True).heading.max == pytest.approx(0, abs=1e-12)
    np.testing.assert_allclose(compose(alignment(estimated, true), (1.0, -2.0, 2.5)), (0, 0, 0), atol=1e-12)


def test_alignment_is_the_best_rigid_motion() -> None:
    rng = np.random.default_rng(5)
    true = rng.normal(size=(30, 3))
    estimated = compose((0.3, 0.1, 0.4), true) + rng.normal(size=(30, 3)) * 0.2
    best = alignment(estimated, true)

    def squared_error(pose: np.ndarray) -> float:
        return float(np.sum((compose(pose, estimated) - true)[:, :2] ** 2))

    for step in np.vstack([np.eye(3), -np.eye(3)]) * 1e-3:
        assert squared_error(best) < squared_error(best + step)


def test_alignment_of_a_standing_robot_only_moves() -> None:
    np.testing.assert_allclose(alignment([[1, 2, 0.5]] * 3, [[4, 4, 0.0]] * 3), (3, 2, 0), atol=1e-12)


def test_rpe_sees_one_slip_once() -> None:
    estimated = LINE.copy()
    estimated[3:, 0] += 0.5
    error = rpe(estimated, LINE)
    assert error.position.max == pytest.approx(0.5)
    assert error.position.mean == pytest.approx(0.5 / 4)
    assert error.position.end == 0
    assert rpe(estimated, LINE, delta=4).position.mean == pytest.approx(0.5)


def test_rpe_doesnt_depend_on_the_frame() -> None:
    rng = np.random.default_rng(6)
    true, estimated = rng.normal(size=(2, 10, 3))
    moved = compose((5.0, 5.0, 1.0), estimated)
    assert rpe(moved, true).position.rmse == pytest.approx(rpe(estimated, true).position.rmse)


def test_a_turn_is_a_relative_error_of_heading() -> None:
    estimated = LINE.copy()
    estimated[2:, 2] = 0.1
    error = rpe(estimated, LINE)
    assert error.heading.max == pytest.approx(0.1)
    assert error.heading.mean == pytest.approx(0.1 / 4)


@pytest.mark.parametrize(
    ("estimated", "message"),
    [
        (LINE[:3], "3 estimated poses cannot be compared with 5 true ones"),
        (LINE[:, :2], r"the estimated trajectory has shape \(5, 2\)"),
        (np.where(LINE == 2, np.nan, LINE), "the estimated trajectory isn't finite at step 2"),
        (np.zeros((0, 3)), r"shape \(0, 3\)"),
    ],
)
def test_bad_trajectories_are_refused(estimated: np.ndarray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ape(estimated, LINE)


def test_bad_delta_is_refused() -> None:
    with pytest.raises(ValueError, match="delta is 5, expected a number of steps from 1 to 4"):
        rpe(LINE, LINE, delta=5)
