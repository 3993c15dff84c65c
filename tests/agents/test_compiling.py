"""Whoever waits for the filter to be compiled is told, and nobody else."""

import subprocess
import sys

import numba
import pytest
from typer.testing import CliRunner

from agents import compiling
from agents.cli import app
from agents.compiling import COMPILING


def compile_one(module):
    """Compile a new function of that module."""

    def double(x):
        return 2 * x

    double.__module__ = module
    numba.njit(double)(1)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(compiling, "cache_folder", lambda package: tmp_path)
    return tmp_path


def run_with(monkeypatch, *modules):
    """Run a command that compiles a function of each module."""

    def run_mission(settings, tell):
        for module in modules:
            compile_one(module)
        return {"success": True, "path_length": 0.0, "steps": 1, "spl": 1.0, "collisions": 0} | dict.fromkeys(
            ("ape_end", "ape_max"), 0.0
        )

    monkeypatch.setattr("agents.run.run_mission", run_mission)
    result = CliRunner().invoke(app, ["run", "go to the kitchen"])
    assert result.exit_code == 0, result.output
    return result


@pytest.mark.compiled
def test_the_first_run_says_once_that_it_compiles(cache, monkeypatch):
    (cache / "grid.enter-1.py311.nbi").write_bytes(b"")  # compiled by an import
    result = run_with(monkeypatch, "slam.innovation", "slam.proposal")
    assert result.stderr == COMPILING + "\n" and COMPILING not in result.stdout


@pytest.mark.compiled
def test_one_kernel_more_beside_a_warm_cache_is_not_worth_a_word(cache, monkeypatch):
    (cache / "slam").mkdir()
    (cache / "slam" / "scan_update.update_particles-1.py311.nbi").write_bytes(b"")
    assert run_with(monkeypatch, "slam.innovation").stderr == ""


@pytest.mark.compiled
def test_nothing_is_said_of_other_kernels(cache, monkeypatch):
    assert run_with(monkeypatch, "regionslam_env.worlds.flooding").stderr == ""


def test_help_does_not_load_the_compiler():
    code = (
        "import sys; from typer.testing import CliRunner; from agents.cli import app; "
        "result = CliRunner().invoke(app, ['run', '--help']); assert 'Usage' in result.stdout and not result.stderr; "
        "assert 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
