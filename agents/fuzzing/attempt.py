"""One damaged building, given to the command line and to the environment: what became of it."""

from __future__ import annotations

import contextlib
import io
import random
import tempfile
import time
import traceback
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import gymnasium
import typer

from agents.console import BAD_INPUT, DONE, Commands
from agents.fuzzing.examples import Example
from agents.world_commands import app as world_app
from regionslam_env.errors import ConfigError, WorldError
from regionslam_env.worlds.loading import load

WORLD, REFUSED, UNPLAYABLE, FAILED = "world", "refused", "unplayable", "failed"
"""A world; refused by the command line; a world in which no mission can be drawn; anything else."""

LONGEST_LINE = 2000
STEPS = 5

app = typer.Typer(cls=Commands)
app.add_typer(world_app, name="world")


@dataclass(frozen=True)
class Outcome:
    """What became of a damaged building; `detail` is the message, or the traceback where something failed."""

    outcome: str
    detail: str
    seconds: float


def attempt(number: int, examples: Sequence[Example]) -> Outcome:
    """Damage one of the examples as its number says, and use it."""
    began = time.perf_counter()
    rng = random.Random(number)
    with tempfile.TemporaryDirectory() as folder:
        path = examples[number % len(examples)].damaged(Path(folder), rng)
        try:
            outcome, detail = _use(path, rng)
        except Exception:
            outcome, detail = FAILED, traceback.format_exc()
    return Outcome(outcome, detail, time.perf_counter() - began)


def warm_up(examples: Sequence[Example]) -> None:
    """Load and compile all that the examples need as they are."""
    for example in examples:
        _play(example.path)


def _use(path: Path, rng: random.Random) -> tuple[str, str]:
    out = path.parent / "out"
    out.mkdir()
    written = out / "world.geojson"
    command = rng.choice(
        [
            ["import", str(path), "--out", str(written), "--json"],
            ["import", str(path), "--out", str(written), "--scale", "0.01"],
            ["validate", str(path), "--json"],
            ["show", str(path), "--out", str(out / "world.png")],
        ]
    )
    code, told = _command(["world", *command])
    if code == BAD_INPUT:
        lines = told.splitlines()
        if len(lines) != 1 or not told.startswith("error: ") or len(told) > LONGEST_LINE or path.name not in told:
            return FAILED, f"expected one line of error that names {path.name}, got: {told}"
        return REFUSED, told
    if code != DONE or told:
        return FAILED, f"exit code {code}, on standard error: {told}"
    return _play(written if written.exists() else path)


def _command(arguments: list[str]) -> tuple[object, str]:
    """Run a command; return its exit code and what it wrote to standard error."""
    errors = io.StringIO()
    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(errors),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", DeprecationWarning)  # as outside of tests
        try:
            app(arguments, prog_name="regionslam")
        except SystemExit as end:
            return end.code, errors.getvalue()
    raise AssertionError("the command line came back")


def _play(path: Path) -> tuple[str, str]:
    """Load a world, and drive some steps in it."""
    load(path)
    try:
        env = gymnasium.make("RegionSLAM/GoTo-v0", world=str(path))
        env.reset(seed=0)
    except (ConfigError, WorldError) as error:
        return UNPLAYABLE, str(error)
    for _ in range(STEPS):
        env.step([1.0, 0.5])
    return WORLD, ""
