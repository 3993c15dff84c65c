from __future__ import annotations

import pytest
import typer
from typer.testing import CliRunner

from agents.console import Commands, InputError, print_json
from regionslam_env.errors import WorldError

app = typer.Typer(cls=Commands, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def end(code: int = 0) -> int:
    return code


@app.command()
def fail(kind: str) -> None:
    known = {"input": InputError("two\n  lines"), "world": WorldError("no world"), "defect": ValueError("a defect")}
    raise {**known, "file": FileNotFoundError(2, "No such file or directory", "a.json")}[kind]


@app.command()
def tell() -> None:
    print_json({"ä": 1, "none": None})


def invoke(*args: str):
    return CliRunner().invoke(app, list(args))


@pytest.mark.parametrize("code", [0, 1, 2])
def test_a_command_returns_its_exit_code(code):
    assert invoke("end", "--code", str(code)).exit_code == code


@pytest.mark.parametrize(
    ("kind", "line"), [("input", "two lines"), ("world", "no world"), ("file", "a.json: No such file or directory")]
)
def test_bad_input_is_one_line_and_exit_code_2(kind, line):
    result = invoke("fail", kind)
    assert (result.exit_code, result.stderr, result.stdout) == (2, f"error: {line}\n", "")


def test_a_defect_is_not_passed_off_as_bad_input():
    result = invoke("fail", "defect")
    assert result.exit_code == 1 and isinstance(result.exception, ValueError)


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("ent",), ("'ent'", "'end'")),
        (("end", "--cod", "1"), ("--cod", "--code")),
        (("end", "--code", "x"), ("--code", "integer")),
        (("fail",), ("Missing", "kind")),
    ],
)
def test_usage_errors_are_one_line_that_names_the_nearest(args, words):
    result = invoke(*args)
    assert result.exit_code == 2 and result.stdout == ""
    assert result.stderr.startswith("error: ") and result.stderr.count("\n") == 1
    assert all(word.lower() in result.stderr.lower() for word in words), result.stderr


def test_json_is_one_line():
    assert invoke("tell").stdout == '{"ä": 1, "none": null}\n'
