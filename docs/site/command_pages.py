"""The page about the command line, made from the commands themselves."""

from __future__ import annotations

import typer
from typer.cli import get_docs_for_click

from agents.cli import app


def command_page() -> str:
    """Return what `regionslam --help` and the help of every command say."""
    command = typer.main.get_command(app)
    context = command.make_context("regionslam", [], resilient_parsing=True)
    return get_docs_for_click(obj=command, ctx=context, name="regionslam", title="Command line")  # type: ignore[arg-type]
