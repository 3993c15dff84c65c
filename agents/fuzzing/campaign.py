"""Thousands of damaged buildings: each has to give a world, or a message that a person can act on, within a time."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from agents.console import InputError
from agents.fuzzing.attempt import FAILED, Outcome, attempt, warm_up
from agents.fuzzing.examples import examples_in
from agents.guarded import guarded
from agents.parallel import processors

EXAMPLES = Path(__file__).parents[2] / "tests" / "worlds" / "importers" / "data"
"""Small buildings in every format; they are part of the project's source, not of what is installed."""

BAD = (FAILED, "hung", "crashed")


def benchmark_fuzz(
    mutations: int,
    first: int = 0,
    folder: Path = EXAMPLES,
    seconds: float = 60.0,
    keep: Path | None = None,
    tell: Callable[[Outcome], None] = lambda outcome: None,
    workers: int | None = None,
) -> dict[str, Any]:
    """Damage the buildings of a folder in turn and use them.

    Parameters
    ----------
    mutations, first
        How many, numbered from which one: the number is the seed, and one alone does the same again.
    folder
        Buildings that load.
    seconds
        What takes longer hangs.
    keep
        Where to put the damaged files of what failed.
    tell
        Called with each.
    workers
        Number of processes; by default one per processor.

    Returns
    -------
    dict
        ``outcomes``, and ``formats`` with the same by format, as counts; ``seconds`` of the median and the slowest one;
        ``failures`` with number, format, file, outcome ("failed", "hung" or "crashed") and detail of each.
    """
    examples = examples_in(folder) if folder.is_dir() else []
    if not examples:
        raise InputError(f"{folder}: no building that loads, expected a folder of some (--examples)")
    warm_up(examples)  # compiles once, not in every process
    jobs = guarded(
        partial(attempt, examples=examples),
        range(first, first + mutations),
        seconds,
        workers or processors(),
        partial(warm_up, examples=examples),
    )
    formats: dict[str, Counter[str]] = {}
    failures, times = [], []
    for job in jobs:
        example = examples[job.item % len(examples)]
        outcome = Outcome(job.trouble, "", seconds) if job.trouble is not None else job.result
        formats.setdefault(example.format, Counter())[outcome.outcome] += 1
        times.append(outcome.seconds)
        if outcome.outcome in BAD:
            failures.append({"number": job.item, "format": example.format, "file": example.path.name, **vars(outcome)})
            if keep is not None:
                place = keep / str(job.item)
                place.mkdir(parents=True, exist_ok=True)
                example.damaged(place, random.Random(job.item))
        tell(outcome)
    return {
        "mutations": mutations,
        "first": first,
        "outcomes": dict(sum(formats.values(), Counter())),
        "formats": {name: dict(counts) for name, counts in sorted(formats.items())},
        "seconds": {"median": float(np.median(times)), "worst": max(times)},
        "failures": sorted(failures, key=lambda failure: failure["number"]),
    }
