"""Options that several commands share, and checks of what they were given."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from agents.console import InputError

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object as the last line.")]
WorldName = Annotated[str, typer.Option("--world", help="A built-in world, a kind such as office, or the file of one.")]
Particles = Annotated[int, typer.Option("--particles", min=1, help="Particles of the filter.")]
Noise = Annotated[str, typer.Option("--noise", help="Noise set: standard, heavy or none.")]
Dynamics = Annotated[str | None, typer.Option("--dynamics", help="What moves: none, people, doors, furniture or all.")]
Occlusion = Annotated[bool, typer.Option(help="Whether walls hide regions.")]


def given(**options: Any) -> dict[str, Any]:
    """Return the options that were given."""
    return {name: value for name, value in options.items() if value is not None}


def check_folder(folder: Path | None) -> None:
    """Refuse a folder that cannot be one before any work is done."""
    if folder is None:
        return
    for part in (folder, *folder.parents):
        if part.exists():
            if not part.is_dir():
                raise InputError(f"{part}: a file, expected a folder")
            return
