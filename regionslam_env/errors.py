"""Errors on user input: what came, what was expected, and the nearest known names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

LONGEST = 80
"""Names longer than this are not told to their end."""

FEW = 6
"""So many known names are all listed, even where one is near."""


class ConfigError(ValueError):
    """A setting that is unknown, of the wrong type or out of range."""


class WorldError(ValueError):
    """A world that cannot be used; the message names file, feature, field, value and expectation."""


def unknown(kind: str, name: object, known: Iterable[str]) -> str:
    """Return one line saying that `name` is no known `kind`, with the nearest known names, or those that it contains.

    Parameters
    ----------
    kind
        What was looked for, e.g. ``"world"``.
    name
        What came.
    known
        Every valid name; all are listed where none is near or they are few.
    """
    names = sorted(set(known))
    lower: dict[str, str] = {}
    for candidate in names:
        lower.setdefault(candidate.lower(), candidate)
    near = [lower[n] for n in difflib.get_close_matches(str(name).lower()[:200], lower, n=3, cutoff=0.6)]
    near = near or [lower[n] for n in lower if f" {n} " in f" {str(name).lower()[:200]} "]
    line = f"unknown {kind} {short(name)}"
    if not names:
        return line
    if not near:
        return f"{line}: expected one of {listed(names)}"
    line += f": did you mean {' or '.join(map(short, near))}?"
    return line if len(names) > FEW or len(names) == len(near) else f"{line} Expected one of {listed(names)}"


def listed(names: Iterable[str]) -> str:
    """Return names in quotes and in their order, the first 20 of them."""
    every = sorted(set(names))
    return ", ".join(map(short, every[:20])) + (", ..." if len(every) > 20 else "")


def short(name: object) -> str:
    """Return a name in quotes, or what is no text as Python writes it; the end is cut off where it is very long."""
    text = name if isinstance(name, str) else repr(name)
    text = text if len(text) <= LONGEST else text[:LONGEST] + "..."
    return repr(text) if isinstance(name, str) else text


def hint(needs: str, extra: str) -> str:
    """Return one line on what an extra is needed for, e.g. "figures need matplotlib", and how to install it."""
    return f'{needs}: pip install -e ".[{extra}]"'
