"""How the command line fails and speaks: one clear line and an exit code, never a traceback for bad input."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import gymnasium
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeElapsedColumn
from typer.core import TyperCommand, TyperGroup

T = TypeVar("T")

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


class InputError(ValueError):
    """Something given on the command line that cannot be used."""


class Command(TyperCommand):
    """A command; it says so before it compiles the filter."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command: its options have been read."""
        from agents.compiling import told  # loads Numba, which `--help` does without

        with told():
            return super().invoke(ctx)


class App(typer.Typer):
    """Commands that belong together."""

    def command(self, *args: Any, **kwargs: Any) -> Any:
        """Return the decorator that adds a command."""
        return super().command(*args, **{"cls": Command, **kwargs})


class Commands(TyperGroup):
    """The group of all commands, with the project's exit codes.

    0: done; 1: the mission failed; 2: bad input, told in one line on standard error. A command returns its own code.
    """

    def main(  # type: ignore[override]
        self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any
    ) -> Any:
        """Run a command line and exit."""
        try:
            code = super().main(args, prog_name, **{**extra, "standalone_mode": False})
        except BrokenPipeError:
            sys.exit(FAILED)
        except (ValueError, OSError, gymnasium.error.Error) as error:
            if type(error) is ValueError:
                raise  # bad input has an error of its own; this one is a defect and shows where
            sys.exit(_refuse(_one_line(error)))
        except KeyboardInterrupt:
            sys.exit(INTERRUPTED)
        except Exception as error:
            if type(error).__name__ == "Abort":
                sys.exit(INTERRUPTED)
            if not hasattr(error, "format_message"):
                raise
            message = error.format_message()
            if type(error).__name__ == "NoArgsIsHelpError":
                print(message)
                sys.exit(BAD_INPUT)
            sys.exit(_refuse(_one_line(message)))
        sys.exit(code or DONE)


def _refuse(message: str) -> int:
    print(f"error: {message}", file=sys.stderr)
    return BAD_INPUT


def _one_line(error: object) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return " ".join(str(error).split())


def console() -> Console:
    """Return a console on the present standard output."""
    return Console(highlight=False, soft_wrap=True)


def status_console() -> Console:
    """Return a console on the present standard error, for progress that is no result."""
    return Console(stderr=True, highlight=False)


def progress(*columns: ProgressColumn) -> Progress:
    """Return a progress display on standard error that vanishes when done and is silent where nobody watches."""
    target = status_console()
    return Progress(*columns, console=target, transient=True, disable=not target.is_terminal)


def bar() -> Progress:
    """Return a progress display of how many of how many are done."""
    return progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())


def track(items: Iterable[T], total: int, what: str) -> Iterator[T]:
    """Yield the items and show how many of `total` have come."""
    with bar() as shown:
        task = shown.add_task(what, total=total)
        for item in items:
            shown.advance(task)
            yield item


def print_json(values: Mapping[str, Any]) -> None:
    """Print one JSON object on a line of its own."""
    typer.echo(json.dumps(values, allow_nan=False, ensure_ascii=False))
