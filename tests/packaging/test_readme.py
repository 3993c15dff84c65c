"""The examples of the README run as they stand."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[2] / "README.md"
EXAMPLES = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_there_are_examples():
    assert len(EXAMPLES) >= 6


@pytest.mark.parametrize("example", EXAMPLES)
@pytest.mark.compiled
def test_an_example_runs(example, capsys):
    exec(compile(example, README.name, "exec"), {"__name__": "readme"})
    assert capsys.readouterr().out.strip()


def test_every_file_it_points_to_exists():
    links = re.findall(r"\]\(([^):]+)\)", README.read_text(encoding="utf-8"))
    assert links and all((README.parent / link).is_file() for link in links)
