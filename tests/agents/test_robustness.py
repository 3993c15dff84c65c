"""The scenarios of what goes wrong: every one keeps its limits."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from agents.cli import app
from agents.robustness import run, summary
from agents.scenarios import SCENARIOS, on
from tests.floors import single_room


def test_a_drive_slips_and_is_blind_where_it_is_said_to() -> None:
    poses = np.stack([np.arange(11.0), np.zeros(11), np.zeros(11)], axis=1)
    drive = on((single_room(), poses), slip=(3, 5, 0.7), blind=(8, 10))
    assert np.flatnonzero(drive.slip == 0.7).tolist() == [2, 3]  # the metres that end at 3 and 4
    assert np.flatnonzero(drive.blind).tolist() == [7, 8]


def test_a_summary_holds_median_and_worst() -> None:
    runs = [
        {"scenario": "kidnapped", "seed": s, "found": f, "type_accuracy": t, "passed": f is not None}
        for s, (f, t) in enumerate([(3, 1.0), (None, 0.9), (5, 0.95)])
    ]
    result = summary(runs)
    assert result["passed"] == 2
    assert result["figures"]["found"] == {"median": 4.0, "worst": None}
    assert result["figures"]["type_accuracy"] == {"median": 0.95, "worst": 0.9}


@pytest.mark.compiled
def test_twin_offices_and_the_same_from_the_command_line() -> None:
    first = run("twin offices", 0)
    assert first["passed"], first
    result = CliRunner().invoke(
        app, ["benchmark", "robustness", "--seeds", "1", "--scenario", "twin offices", "--json"]
    )
    assert result.exit_code == 0, result.output
    assert json.loads(result.output.splitlines()[-1])["runs"] == [first]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_keeps_its_limits(name: str, seed: int) -> None:
    figures = run(name, seed)
    assert figures["passed"], figures
