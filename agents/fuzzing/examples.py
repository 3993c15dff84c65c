"""The files that are damaged: every building in a folder, and what belongs to each."""

from __future__ import annotations

import importlib.util
import random
import shutil
from dataclasses import dataclass
from pathlib import Path

from agents.fuzzing.byte_changes import add_bomb, change_bytes
from agents.fuzzing.image_changes import change_image
from agents.fuzzing.tree_changes import change_json, change_xml, change_yaml
from regionslam_env.errors import WorldError
from regionslam_env.worlds.format import is_native
from regionslam_env.worlds.importers.formats import detect, plans_in
from regionslam_env.worlds.importers.source import Source
from regionslam_env.worlds.loading import load

STRUCTURED = {
    ".json": change_json,
    ".geojson": change_json,
    ".yaml": change_yaml,
    ".xml": change_xml,
    ".osm": change_xml,
    ".pgm": change_image,
}


@dataclass(frozen=True)
class Example:
    """A building that loads: its path, the name of its format, and the files that are read with it."""

    path: Path
    format: str
    companions: tuple[Path, ...]

    def damaged(self, folder: Path, rng: random.Random) -> Path:
        """Copy the building into an empty folder, with one of its files changed; return its place there."""
        target = folder / self.path.name
        if self.path.is_dir():
            shutil.copytree(self.path, target)
            files = sorted(file for file in target.iterdir() if file.is_file())
        else:
            files = [Path(shutil.copy(file, folder)) for file in (self.path, self.path, *self.companions)]
        file = rng.choice(files)
        content = file.read_bytes()
        for _ in range(rng.choice([1, 1, 1, 2, 4])):
            content = _changed(content, file.suffix, rng)
        if rng.random() < 0.03:
            content = add_bomb(content, rng)
        file.write_bytes(content)
        return target


def examples_in(folder: Path) -> list[Example]:
    """Return the buildings in a folder that load as they are; IFC only where it can be read."""
    found = []
    for path in plans_in(folder):
        name = _format(path)
        if name == "ifc" and importlib.util.find_spec("ifcopenshell") is None:
            continue
        try:
            load(path)
        except WorldError:
            continue
        found.append(Example(path, name, () if path.is_dir() else _companions(path)))
    return found


def _format(path: Path) -> str:
    try:
        return "ours" if is_native(path) else detect(path)[0].name
    except WorldError:
        return "none"


def _companions(path: Path) -> tuple[Path, ...]:
    """Return the files beside a plan that it names, and the annotations of a map."""
    try:
        text = Source(path).text
    except WorldError:
        return ()
    beside = sorted(file for file in path.parent.iterdir() if file.is_file() and file != path)
    return tuple(file for file in beside if file.name in text or file.name == f"{path.stem}.rooms.yaml")


def _changed(content: bytes, suffix: str, rng: random.Random) -> bytes:
    """Return the content with one change, of its structure or of its bytes."""
    change = STRUCTURED.get(suffix)
    if change is not None and rng.random() < 0.7:
        try:
            return change(content, rng)
        except (ValueError, RecursionError):  # not well formed any more
            pass
    return change_bytes(content, rng)
