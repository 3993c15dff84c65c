"""From the labels of a format to our semantic types: tables in JSON that anybody can edit or overlay.

A table is an object with ``labels``, from a label (case does not matter) to a type, or to a list of type and typical
floor area (m²). A label is looked up in the user's table, in the format's, and in that of common words; then word by
word from its end ("Executive Office 2.13" is an office). What is found nowhere is "other".
"""

from __future__ import annotations

import re
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path

from regionslam_env.errors import WorldError
from regionslam_env.worlds.format import read_json
from regionslam_env.worlds.importers.node import Node

OTHER = "other"
COMMON = "common"


class Vocabulary:
    """Labels and the types they stand for; earlier tables win."""

    def __init__(self, tables: tuple[dict[str, tuple[str, float | None]], ...]) -> None:
        self._tables = tables

    def type_of(self, *labels: str) -> str:
        """Return the type of the first label that is known, "other" where none is."""
        for label in labels:
            found = self._lookup(label)
            if found is not None:
                return found[0]
        return OTHER

    def area_of(self, label: str) -> float | None:
        """Return the typical floor area (m²) of a label, if it has one."""
        found = self._lookup(label)
        return found[1] if found else None

    def _lookup(self, label: str) -> tuple[str, float | None] | None:
        key = label.strip().casefold()
        for table in self._tables:
            if key in table:
                return table[key]
        words = re.findall(r"[^\W\d_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", label).casefold())[:12]
        for length in range(len(words), 0, -1):
            for start in range(len(words) - length, -1, -1):
                phrase = " ".join(words[start : start + length])
                for table in self._tables:
                    if phrase in table:
                        return table[phrase]
        return None


def vocabulary(format_name: str, own: Path | None = None) -> Vocabulary:
    """Return the vocabulary of a format, overlaid by a table of the user's own."""
    shipped = (_shipped(format_name), _shipped(COMMON))
    return Vocabulary(shipped if own is None else (_own(own), *shipped))


@cache
def _shipped(name: str) -> dict[str, tuple[str, float | None]]:
    with resources.as_file(resources.files("regionslam_env.worlds.importers") / "types" / f"{name}.json") as path:
        return _read(path) if path.is_file() else {}


def _own(path: Path) -> dict[str, tuple[str, float | None]]:
    status = path.stat() if path.is_file() else None
    return _read_again(path, status.st_mtime_ns if status else 0)


@lru_cache(maxsize=8)
def _read_again(path: Path, changed: int) -> dict[str, tuple[str, float | None]]:
    return _read(path)


def _read(path: Path) -> dict[str, tuple[str, float | None]]:
    table = {}
    for label, entry in Node(path, read_json(path))["labels"].fields():
        if isinstance(entry.value, list):
            items = list(entry.items())
            if len(items) != 2:
                raise entry.error("a type, or [type, typical area in m²]")
            kind, area = items[0].text(), None if items[1].value is None else items[1].number(0.1, 1e5)
        else:
            kind, area = entry.text(), None
        if not kind:
            raise WorldError(f"{path}: labels.{label}: expected a type, got an empty text")
        table[label.strip().casefold()] = (kind, area)
    return table
