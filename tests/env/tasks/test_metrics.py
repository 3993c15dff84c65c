import math
from dataclasses import replace

import numpy as np
import pytest

from regionslam_env.tasks.metrics import (
    METRICS,
    EpisodeFacts,
    PoseErrors,
    episode_metrics,
    normalised_square,
    soft_spl,
    spl,
)

FACTS = EpisodeFacts(
    success=True,
    over=True,
    declared=None,
    believed=0.9,
    shortest=8.0,
    remaining=0.0,
    path_length=10.0,
    believed_path_length=16.0,
    collisions=2,
)
MAP = {"region_precision": 1.0, "region_recall": 0.5, "region_iou": 0.75, "type_accuracy": None, "link_f1": math.nan}


@pytest.mark.parametrize(
    ("success", "shortest", "path", "expected"),
    [
        (True, 8.0, 10.0, 0.8),
        (True, 8.0, 8.0, 1.0),
        (True, 8.0, 7.9, 1.0),  # a grid distance may exceed the path driven
        (False, 8.0, 10.0, 0.0),
        (False, 8.0, 0.0, 0.0),  # never moved
        (True, 0.0, 0.0, 1.0),  # started in the goal and stayed
        (True, 0.0, 2.0, 0.0),  # started in the goal, left and came back
        (False, 0.0, 0.0, 0.0),
    ],
)
def test_spl(success, shortest, path, expected):
    assert spl(success, shortest, path) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("shortest", "remaining", "path", "expected"),
    [
        (8.0, 0.0, 10.0, 0.8),
        (8.0, 4.0, 4.0, 0.5),
        (8.0, 4.0, 16.0, 0.25),
        (8.0, 8.0, 0.0, 0.0),  # never moved
        (8.0, 12.0, 4.0, 0.0),  # went away: no negative progress
        (0.0, 0.0, 0.0, 1.0),
        (0.0, 1.0, 1.0, 0.0),
    ],
)
def test_soft_spl(shortest, remaining, path, expected):
    assert soft_spl(shortest, remaining, path) == pytest.approx(expected)


@pytest.mark.parametrize("shortest", [math.inf, math.nan, -1.0])
def test_an_unreachable_goal_has_no_spl(shortest):
    with pytest.raises(ValueError, match="shortest is"):
        spl(True, shortest, 1.0)
    with pytest.raises(ValueError, match="shortest is"):
        soft_spl(shortest, 1.0, 1.0)
    with pytest.raises(ValueError, match="remaining is"):
        soft_spl(1.0, math.inf, 1.0)


def metrics(facts=FACTS, **changes):
    return episode_metrics(replace(facts, **changes), PoseErrors(), MAP)


def test_every_metric_is_there_and_null_where_it_means_nothing():
    result = metrics()
    assert set(result) == set(METRICS)
    assert result["spl"] == pytest.approx(0.8)
    assert result["belief_spl"] == pytest.approx(0.5)
    assert result["collisions"] == 2
    assert result["ape_rmse"] is None  # no step yet
    assert result["type_accuracy"] is None and result["link_f1"] is None  # null, never NaN
    assert result["region_recall"] == 0.5


@pytest.mark.parametrize(
    ("success", "over", "declared", "false_arrival"),
    [
        (True, True, None, None),
        (False, False, None, None),
        (True, True, True, False),
        (False, True, True, True),
        (False, False, False, False),
        (False, False, True, False),  # an instruction of several, rightly, when time was up
    ],
)
def test_false_arrival(success, over, declared, false_arrival):
    assert metrics(success=success, over=over, declared=declared)["false_arrival"] is false_arrival


@pytest.mark.parametrize(
    ("believed", "declared", "expected"),
    [(0.9, None, True), (0.5, None, False), (0.9, True, True), (0.9, False, False), (0.1, True, False)],
)
def test_belief_success_is_the_robots_own_verdict(believed, declared, expected):
    result = metrics(believed=believed, declared=declared, success=False)
    assert result["belief_success"] is expected
    assert result["belief_spl"] == (0.5 if expected else 0.0)


def test_pose_errors_of_a_path_by_hand():
    errors = PoseErrors()
    cov = np.diag([0.04, 0.01, 0.25])
    errors.add(np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), cov)
    errors.add(np.array([3.0, 4.0, 3.1]), np.array([0.0, 0.0, 3.1]), cov)
    errors.add(np.array([0.0, 0.1, -3.1]), np.array([0.2, 0.0, 3.1]), cov)
    result = errors.metrics()
    assert result["ape_max"] == pytest.approx(5.0)
    assert result["ape_rmse"] == pytest.approx(math.sqrt((25 + 0.05) / 3))
    assert result["ape_end"] == pytest.approx(math.sqrt(0.05))
    turn = 2 * math.pi - 6.2  # the short way round
    nees = [0.0, 9 / 0.04 + 16 / 0.01, 1.0 + 1.0 + turn**2 / 0.25]
    assert result["pose_nees"] == pytest.approx(sum(nees) / 3)


def test_a_pose_that_is_known_has_errors_but_no_nees():
    errors = PoseErrors()
    errors.add(np.zeros(3), np.zeros(3), np.zeros((3, 3)))
    assert errors.metrics() == {"ape_rmse": 0.0, "ape_max": 0.0, "ape_end": 0.0, "pose_nees": None}


def test_steps_without_a_positive_definite_covariance_do_not_count():
    errors = PoseErrors()
    errors.add(np.ones(3), np.zeros(3), np.diag([1.0, 0.0, 1.0]))
    errors.add(np.ones(3), np.zeros(3), np.eye(3))
    assert errors.metrics()["pose_nees"] == pytest.approx(3.0)


def test_normalised_square_is_the_inverse_by_hand():
    rng = np.random.default_rng(5)
    for _ in range(20):
        root = rng.normal(size=(3, 3))
        cov, e = root @ root.T + 0.1 * np.eye(3), rng.normal(size=3)
        assert normalised_square(*e, cov) == pytest.approx(e @ np.linalg.inv(cov) @ e)
    assert normalised_square(1.0, 1.0, 1.0, -np.eye(3)) == -1
    assert normalised_square(1.0, 1.0, 1.0, np.ones((3, 3))) == -1


@pytest.mark.parametrize("success", [True, False])
def test_without_a_goal_nothing_is_said_of_its_distance(success):
    facts = replace(FACTS, success=success, believed=None, shortest=None, remaining=None, declared=True)
    metrics = episode_metrics(facts, PoseErrors(), MAP | {"explored": 0.5, "closed_edges": 0.25})
    assert set(metrics) == set(METRICS)
    empty = ("spl", "soft_spl", "distance_to_goal", "belief_success", "belief_spl")
    assert all(metrics[name] is None for name in empty)
    assert metrics["success"] is success and metrics["false_arrival"] is not success
    assert (metrics["explored"], metrics["closed_edges"]) == (0.5, 0.25)
