from __future__ import annotations

import math

import gymnasium
import pytest

import regionslam_env  # noqa: F401 - registers the ids
from agents.console import InputError
from agents.evaluate import check_environment, evaluate, load_model, make_agent, summarize, wilson
from regionslam_env.tasks.metrics import METRICS


def result(**values: object) -> dict[str, object]:
    return {"steps": 10, **dict.fromkeys(METRICS), **values}


def test_wilson_of_9_in_10():
    low, high = wilson(0.9, 10)
    assert (low, high) == pytest.approx((0.5958, 0.9821), abs=1e-4)
    assert wilson(1.0, 10) == pytest.approx((0.7225, 1.0), abs=1e-4)
    assert wilson(0.0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)


def test_means_and_intervals_leave_out_what_has_no_meaning():
    summary = summarize([result(spl=0.5, success=True), result(spl=0.7, success=False), result(spl=None, success=True)])
    assert summary["spl"]["n"] == 2 and summary["spl"]["mean"] == pytest.approx(0.6)
    half = 1.959964 * math.sqrt(0.02) / math.sqrt(2)
    assert summary["spl"]["high"] == pytest.approx(0.6 + half)
    assert summary["success"]["mean"] == pytest.approx(2 / 3) and summary["success"]["n"] == 3
    assert summary["success"]["low"] == pytest.approx(wilson(2 / 3, 3)[0])
    assert summary["ape_max"] == {"mean": None, "low": None, "high": None, "n": 0}


def test_one_episode_has_a_mean_but_no_interval():
    assert summarize([result(spl=0.5)])["spl"] == {"mean": 0.5, "low": None, "high": None, "n": 1}


@pytest.fixture(scope="module")
def env():
    env = gymnasium.make("RegionSLAM/GoTo-Declare-v0", max_steps=30)
    yield env
    env.close()


@pytest.mark.compiled
def test_episodes_are_those_of_consecutive_seeds(env):
    told = []
    results = evaluate(env, make_agent("random", env), 2, seed=5, tell=lambda k, metrics: told.append((k, metrics)))
    assert [r["seed"] for r in results] == [5, 6] and [k for k, _ in told] == [0, 1]
    assert all(set(METRICS) <= set(r) for r in results)
    (again,) = evaluate(env, make_agent("scripted", env), 1, seed=6)
    assert again["seed"] == 6 and again["steps"] <= 30


@pytest.mark.compiled
def test_episodes_are_filmed_where_asked_for(env, tmp_path):
    evaluate(env, make_agent("random", env), 1, seed=5, films=tmp_path / "films")
    assert sorted(file.name for file in (tmp_path / "films").iterdir()) == ["episode-5.gif", "episode-5.png"]


@pytest.mark.compiled
def test_the_random_agent_declares_nothing_and_repeats_itself(env):
    one, other = make_agent("random", env, seed=1), make_agent("random", env, seed=1)
    for _ in range(5):
        action = one.act({})
        assert action[2] == -1 and (action == other.act({})).all() and env.action_space.contains(action)


def test_unknown_names():
    with pytest.raises(InputError, match="'RegionSLAM/GoTo-v0'"):
        check_environment("RegionSLAM/GoTo-v9")
    with pytest.raises(InputError, match="scripted"):
        load_model("scriptd")
    assert load_model("random") is None
