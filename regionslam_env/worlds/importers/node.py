"""A value in a file of plain data (JSON, YAML) that knows where it stands: every wrong one is named with its place."""

from __future__ import annotations

import reprlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from regionslam_env.errors import WorldError, unknown

LARGEST = 1e7
"""Numbers above this are no coordinate of a building, in no unit."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxlevel = 2


@dataclass(frozen=True)
class Node:
    """A value, its file and its place in there, e.g. ``rooms[3].footprint``."""

    file: Path
    value: Any
    place: str = ""

    def error(self, expected: str) -> WorldError:
        """Return an error about this value."""
        where = f"{self.file}: {self.place}" if self.place else str(self.file)
        return WorldError(f"{where}: expected {expected}, got {_SHORT.repr(self.value)}")

    def has(self, *keys: str) -> bool:
        """Return whether this is an object with all these fields, none of them null."""
        return isinstance(self.value, dict) and all(self.value.get(key) is not None for key in keys)

    def __getitem__(self, key: str) -> Node:
        """Return a field that must be there."""
        node = self.get(key)
        if node is None:
            known = [k for k in self.value if isinstance(k, str)]
            where = f"{self.file}: {self.place}" if self.place else str(self.file)
            raise WorldError(f"{where}: field {key!r} is missing: {unknown('field', key, known)}")
        return node

    def get(self, key: str) -> Node | None:
        """Return a field, None where it is missing or null."""
        if not isinstance(self.value, dict):
            raise self.error("an object with fields")
        value = self.value.get(key)
        return None if value is None else Node(self.file, value, f"{self.place}.{key}" if self.place else key)

    def fields(self) -> Iterator[tuple[str, Node]]:
        """Yield the names and values of an object's fields."""
        if not isinstance(self.value, dict):
            raise self.error("an object with fields")
        for key, value in self.value.items():
            yield str(key), Node(self.file, value, f"{self.place}.{key}" if self.place else str(key))

    def items(self) -> Iterator[Node]:
        """Yield the items of a list."""
        if not isinstance(self.value, list):
            raise self.error("a list")
        for i, value in enumerate(self.value):
            yield Node(self.file, value, f"{self.place}[{i}]")

    def listed(self, key: str) -> Iterator[Node]:
        """Yield the items of a field that may be missing."""
        node = self.get(key)
        return iter(()) if node is None else node.items()

    def text(self) -> str:
        """Return a text, or a number as one; spaces at its ends are dropped."""
        if isinstance(self.value, bool) or not isinstance(self.value, str | int | float):
            raise self.error("a text")
        return " ".join(str(self.value).split())[:200]

    def text_of(self, key: str, default: str = "") -> str:
        """Return the text of a field that may be missing."""
        node = self.get(key)
        return default if node is None else node.text()

    def number(self, low: float = -LARGEST, high: float = LARGEST) -> float:
        """Return a number between two bounds."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            raise self.error("a number")
        if not low <= self.value <= high:  # NaN is neither
            raise self.error(f"a number from {low:g} to {high:g}")
        return float(self.value)

    def number_of(self, key: str, default: float, low: float = -LARGEST, high: float = LARGEST) -> float:
        """Return the number of a field that may be missing."""
        node = self.get(key)
        return default if node is None else node.number(low, high)

    def index(self, count: int) -> int:
        """Return an index into a list of `count` items."""
        if isinstance(self.value, bool) or not isinstance(self.value, int) or not 0 <= self.value < count:
            raise self.error(f"an index from 0 to {count - 1}")
        return self.value

    def point(self, x: str = "x", y: str = "y") -> tuple[float, float]:
        """Return a point given as ``[x, y]`` or as an object with two of its fields."""
        if isinstance(self.value, dict):
            return self[x].number(), self[y].number()
        values = list(self.items())
        if len(values) < 2:
            raise self.error("a point [x, y]")
        return values[0].number(), values[1].number()

    def points(self, least: int = 3, x: str = "x", y: str = "y") -> list[tuple[float, float]]:
        """Return a list of at least so many points."""
        found = [item.point(x, y) for item in self.items()]
        if len(found) < least:
            raise self.error(f"at least {least} points")
        return found
