from __future__ import annotations

import numpy as np
import pytest

from agents.benchmark import PARTS, benchmark_environment, race, timed
from agents.peers import PEERS


@pytest.mark.compiled
def test_the_environment_is_timed_by_part():
    result = benchmark_environment(steps=200, repeats=2, copies=2, max_steps=60)
    assert result["steps"] == 200 and result["steps_per_second"] > 0 and result["reset_ms"] > 0
    assert result["vector_steps_per_second"] > 0 and result["vector_ratio"] > 0 and result["copies"] == 2
    assert set(result["peers"]) <= set(PEERS)
    parts = result["microseconds"]
    assert set(parts) == {*PARTS, "other", "total"} and all(parts[part] > 0 for part in PARTS)
    assert sum(v for k, v in parts.items() if k != "total") == pytest.approx(parts["total"])


def test_every_repeat_is_timed_and_at_least_one_counts_as_quiet():
    durations, quiet = timed(lambda: sum(range(100_000)), 3)
    assert len(durations) == 3 and np.all(durations > 0) and quiet.any()


def test_contenders_take_turns():
    turns = []
    durations, quiet = race([lambda: turns.append("a"), lambda: turns.append("b")], 3)
    assert turns == ["a", "b"] * 3
    assert durations.shape == quiet.shape == (2, 3) and quiet.any(axis=1).all()
