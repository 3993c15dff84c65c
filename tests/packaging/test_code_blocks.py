"""Every block of code in README and docs runs, or says why it does not.

A comment before a block in Markdown changes what is done with it: ``<!-- not run: reason -->``, ``<!-- slow -->`` (only
among the slow tests), ``<!-- shortened: A to B, C to D -->`` (run with every word A replaced by B and C by D). Lines of
`regionslam` are read by the command line here, so that none names an option that is not there, and run among the slow
tests.
"""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path
from typing import NamedTuple

import pytest
import typer
import yaml

ROOT = Path(__file__).parents[2]
FILES = sorted({ROOT / "README.md", *(ROOT / "docs").glob("*.md")})
BLOCK = re.compile(r"(?:<!-- ([^\n]*?) -->\n)?^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LANGUAGES = {"python", "sh", "json", "yaml"}


class Block(NamedTuple):
    where: str
    remark: str
    language: str
    text: str

    def as_run(self) -> str:
        text = self.text
        for long, short in re.findall(r"(\S+) to ([^\s,]+)", self.remark.removeprefix("shortened: ")):
            text = re.sub(rf"(?<!\S){re.escape(long)}(?!\S)", short, text)
        return text


def blocks_of(path: Path) -> list[Block]:
    text = path.read_text(encoding="utf-8")
    return [
        Block(f"{path.name}:{text.count(chr(10), 0, m.start()) + 1}", m[1] or "", m[2], m[3])
        for m in BLOCK.finditer(text)
    ]


BLOCKS = [block for path in FILES for block in blocks_of(path)]


def params(language: str):
    return [
        pytest.param(block, id=block.where, marks=[pytest.mark.slow] if block.remark == "slow" else [])
        for block in BLOCKS
        if block.language == language and not block.remark.startswith("not run")
    ]


def commands(block: Block) -> list[list[str]]:
    """Return the command lines of a block that are ours, without comments."""
    lines = (shlex.split(line, comments=True) for line in block.as_run().splitlines())
    return [line for line in lines if line[:1] == ["regionslam"]]


def test_every_block_is_accounted_for():
    fences = sum(path.read_text(encoding="utf-8").count("\n```") for path in FILES)
    assert fences == 2 * len(BLOCKS) and {block.language for block in BLOCKS} <= LANGUAGES
    for block in BLOCKS:
        assert re.fullmatch(r"|slow|not run: .+|shortened: \S+ to \S+(, \S+ to \S+)*", block.remark), block.where
        assert block.as_run() != block.text or not block.remark.startswith("shortened"), block.where
    assert {path.name for path in FILES} > {"README.md", "first-agent.md", "wrappers.md", "ladder.md"}


@pytest.mark.parametrize("block", params("python"))
@pytest.mark.compiled
def test_python_runs(block, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(block.as_run(), block.where, "exec"), {"__name__": "example"})
    assert capsys.readouterr().out.strip(), "an example shows what comes out"


@pytest.mark.parametrize("block", params("json"))
def test_json_is_json(block):
    assert json.loads(block.text)


@pytest.mark.parametrize("block", params("yaml"))
def test_yaml_is_yaml(block):
    assert yaml.safe_load(block.text)


@pytest.mark.parametrize("block", params("sh"))
def test_commands_exist_with_their_options(block):
    from agents.cli import app

    for line in commands(block):
        command, name, rest = typer.main.get_command(app), "regionslam", line[1:]
        while True:
            context = command.make_context(name, list(rest))
            if not hasattr(command, "commands"):
                break
            name, command, rest = command.resolve_command(context, [*context._protected_args, *context.args])


@pytest.mark.slow
@pytest.mark.parametrize("block", params("sh"))
def test_commands_run(block, tmp_path, monkeypatch):
    from agents.cli import app

    shutil.copytree(ROOT / "tests/worlds/importers/data", tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    for line in commands(block):
        with pytest.raises(SystemExit) as end:
            app(line[1:])
        assert end.value.code == 0, line
