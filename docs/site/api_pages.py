"""Pages about the Python interface: the public names of a package, and the modules that other pages point to."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parents[2]
CODE_LINK = re.compile(r"\[(`[^`]+`)\]\(\.\./((?:slam|regionslam_env|agents)/[\w/]+)\.py\)")
"""``[`rows.Row`](../slam/rows.py)``: how a page in `docs` points to code."""


def public_page(package: str, introduction: str) -> str:
    """Return the page of everything that a package exports."""
    names = "\n\n".join(f"::: {package}.{name}" for name in import_module(package).__all__)
    return f"# {package}\n\n{introduction}\n\n{names}\n"


def modules_in(text: str) -> set[str]:
    """Return the modules that a page points to."""
    return {place.replace("/", ".") for _, place in CODE_LINK.findall(text)}


def module_page(module: str) -> str:
    """Return the page of a module with its source; the search leaves it out, or it would find every helper."""
    options = "    options:\n      show_root_heading: false\n      show_source: true\n"
    return f"---\nsearch:\n  exclude: true\n---\n\n# {module}\n\n::: {module}\n{options}"


def link_modules(text: str) -> str:
    """Return the text of a page with the links to code turned into references to the pages of modules."""

    def reference(link: re.Match[str]) -> str:
        name, module = link[1].strip("`"), link[2].replace("/", ".")
        inside = name.partition(f"{PurePosixPath(link[2]).name}.")[2]
        return f"[{link[1]}][{f'{module}.{inside}' if inside else module}]"

    return CODE_LINK.sub(reference, text)
