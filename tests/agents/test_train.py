from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from agents.cli import app
from agents.console import InputError
from agents.train import TrainSettings, load, train

pytest.importorskip("stable_baselines3")

STEPS = 2_000


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("train") / "ppo.zip"
    settings = TrainSettings(steps=STEPS, seed=1, out=out, checkpoint_every=1_000, env_kwargs={"max_steps": 100})
    return train(settings, progress=False)


@pytest.mark.compiled
def test_training_leaves_model_checkpoints_and_logs(model):
    assert model.is_file()
    assert len(list((model.with_suffix("") / "checkpoints").glob("*.zip"))) >= 2
    assert list(model.with_suffix("").rglob("events.out.tfevents.*"))
    assert not list(model.parent.glob(".*"))


@pytest.mark.compiled
def test_a_saved_model_knows_its_environment(model):
    loaded = load(model)
    assert loaded.num_timesteps >= STEPS
    assert loaded.regionslam == {"env_id": "RegionSLAM/GoTo-v0", "env_kwargs": {"max_steps": 100}}


@pytest.mark.compiled
def test_a_saved_model_can_be_evaluated(model):
    result = CliRunner().invoke(app, ["evaluate", str(model), "--episodes", "2", "--json"])
    assert result.exit_code == 0, result.output
    values = json.loads(result.stdout.rstrip().split("\n")[-1])
    assert values["env"] == "RegionSLAM/GoTo-v0" and values["episodes"] == 2
    assert values["metrics"]["success"]["n"] == 2 and values["metrics"]["steps"]["mean"] <= 100


@pytest.mark.compiled
def test_a_model_of_another_environment_is_refused(model):
    result = CliRunner().invoke(app, ["evaluate", str(model), "--env", "RegionSLAM/GoTo-Declare-v0"])
    assert result.exit_code == 2 and "action space" in result.stderr


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 truncated", b"no zip at all"])
def test_a_file_that_is_no_model(tmp_path, content):
    file = tmp_path / "model.zip"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"model\.zip"):
        load(file)
