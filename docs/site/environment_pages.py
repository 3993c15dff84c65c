"""Pages about the environments: made from the registry, the spaces and the docstrings of the classes."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec, load_env_creator

import regionslam_env  # noqa: F401 - registers the ids
from regionslam_env.observations import LinkColumn, RegionColumn, region_table

NAMESPACE = "RegionSLAM"

SECTIONS = (
    *("Description", "Action Space", "Observation Space", "Rewards", "Starting State", "Episode End", "Arguments"),
    "Version History",
)
"""Sections of a page, as Gymnasium's own pages have them."""

HEADED = re.compile(r"^## (.+)\n((?:(?!## ).*\n?)*)", re.MULTILINE)


def tasks() -> dict[str, list[EnvSpec]]:
    """Return the registered environments by task: `GoTo` with `GoTo-v0`, its plain form, first, then its variants."""
    by_task: dict[str, list[EnvSpec]] = {}
    for spec in gymnasium.registry.values():
        if spec.namespace == NAMESPACE:
            by_task.setdefault(spec.name.split("-")[0], []).append(spec)
    return {task: sorted(specs, key=lambda s: s.name != task) for task, specs in by_task.items()}


def environment_class(spec: EnvSpec) -> type[gymnasium.Env[Any, Any]]:
    """Return the class behind an id."""
    entry = spec.entry_point
    return load_env_creator(entry) if isinstance(entry, str) else entry  # type: ignore[return-value]


def summary(spec: EnvSpec) -> str:
    """Return the first line of the class docstring."""
    return (inspect.getdoc(environment_class(spec)) or "").split("\n", 1)[0]


def environment_page(task: str, specs: Sequence[EnvSpec]) -> str:
    """Return the page of a task: what it is at a glance, its ids, and everything that its class says about itself."""
    plain = specs[0]
    kind = environment_class(plain)
    env = gymnasium.make(plain.id)
    keys = ", ".join(f"`{key}`" for key in env.observation_space.spaces)  # type: ignore[attr-defined]
    glance = table(
        ("", ""),
        [
            ("**Action space**", f"`{env.action_space}`"),
            ("**Observation space**", f"`Dict` of {keys}"),
            ("**Make**", f'`gymnasium.make("{plain.id}")`'),
            ("**Class**", f"`{kind.__module__}.{kind.__qualname__}`"),
        ],
    )
    env.close()
    ids = table(("Id", "Arguments that it sets"), [(f"`{spec.id}`", arguments(spec)) for spec in specs])
    told = sections(kind)
    parts = "\n\n".join(f"## {heading}\n\n{told[heading]}" for heading in SECTIONS)
    picture = f"![An episode of the scripted agent: truth and belief](../{task.lower()}.png)"
    return f"# {task}\n\n{summary(plain)}\n\n{picture}\n\n{glance}\n\n{ids}\n\n{parts}\n"


def sections(kind: type[Any]) -> dict[str, str]:
    """Return the sections of a class docstring by heading, each with what its base classes add to it."""
    told: dict[str, str] = {}
    for origin in kind.__mro__:
        for heading, text in re.findall(HEADED, inspect.cleandoc(origin.__dict__.get("__doc__") or "")):
            told[heading] = f"{told[heading]}\n\n{text.strip()}" if heading in told else text.strip()
    return told


def index_page() -> str:
    """Return the page that lists every environment, and explains what they have in common."""
    listed = [
        (f"[{task}]({task.lower()}.md)", f"`{specs[0].id}`", summary(specs[0]), str(len(specs) - 1))
        for task, specs in tasks().items()
    ]
    return f"""# Environments

{table(("Task", "Id", "What is to be done", "Variants"), listed)}

A variant is an id for a set of arguments; whatever an id does not set can be given to `gymnasium.make`. The names mean:

| Variant | What is different |
| --- | --- |
| `-Declare` | the robot has to declare that it is done, right or wrong: the action has a third component |
| `-Oracle` | it is told its true pose; the map is built from it |
| `-Odometry` | it believes its wheels: dead reckoning, no filter |

[The localization ladder](../ladder.md) says what the last two are for.

## Rows of `regions` and `links`

Tables are flattened row by row, because most libraries take one-dimensional boxes only;
`regionslam_env.region_table(observation)` and `link_table(observation)` give the rows back as views. A region's row:

{region_columns()}

The names are those of the enumeration `regionslam_env.RegionColumn`; main, left and right rectangle are explained with
[the region](../region-slam.md#the-region-fig-1-fig-2-section-ii-b). From `TYPES` on there is one column for each of
`SEMANTIC_TYPES`: its probability. A link's row (`LinkColumn`) holds
{", ".join(f"`{column.name}`" for column in LinkColumn)}: two rows of `regions`, how probable the link is, and 0 for a
passage between both or 1 where the second lies in the first.
"""


def region_columns() -> str:
    """Return a table of the columns of a region's row with their bounds."""
    env = gymnasium.make(f"{NAMESPACE}/GoTo-v0")
    spaces = env.observation_space.spaces  # type: ignore[attr-defined]
    low, high = (
        region_table({"regions": bound, "regions_mask": np.zeros(spaces["regions_mask"].n)})[0]
        for bound in (spaces["regions"].low, spaces["regions"].high)
    )
    env.close()
    rows = [(str(int(c)), f"`{c.name}`", f"{low[c]:g}", f"{high[c]:g}") for c in RegionColumn]
    return table(("Column", "Name", "Low", "High"), rows)


def arguments(spec: EnvSpec) -> str:
    """Return the arguments that an id sets, as they are written in Python."""
    return ", ".join(f"`{name}={value!r}`" for name, value in spec.kwargs.items()) or "none"


def table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [heading, ["---"] * len(heading), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


@cache
def pages() -> dict[str, str]:
    """Return every generated page about environments by its place in the site."""
    found = {f"environments/{task.lower()}.md": environment_page(task, specs) for task, specs in tasks().items()}
    return {"environments/index.md": index_page(), **found}
