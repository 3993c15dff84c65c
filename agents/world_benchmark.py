"""Generated worlds judged: how fast they come, and whether each is valid, connected and can be lived in."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from regionslam_env.config import SEMANTIC_TYPES, RobotConfig
from regionslam_env.errors import ConfigError, WorldError
from regionslam_env.tasks.goto import GoToTask
from regionslam_env.tasks.task import TaskSettings
from regionslam_env.worlds.format import load_world, save_world
from regionslam_env.worlds.generate.generator import KINDS, generate
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.reachability import cut_off, unreachable
from regionslam_env.worlds.world import World

CHECKS = ("valid", "connected", "reachable", "spawn_free")
"""What is checked of a world, see `judge`."""

LARGE = 2_000
"""Regions above which the floor is searched by grid steps, and no mission is drawn: distances take minutes there."""

MISSIONS = 3
"""Missions drawn in every world."""


def judge(world: World, seed: int = 0) -> dict[str, bool]:
    """Return what holds of a world.

    ``valid``: its file is accepted and gives the same world back. ``connected``: links join all places. ``reachable``:
    the robot gets into every room and every door, by geodesic distance (by grid steps above `LARGE` regions).
    ``spawn_free``: drawn missions start where the robot fits, with a way to the goal (not above `LARGE` regions).
    """
    radius = RobotConfig().radius
    large = len(world.regions) > LARGE
    return {
        "valid": _comes_back(world),
        "connected": _linked(world),
        "reachable": not (cut_off(world, radius) if large else unreachable(world, radius)),
        **({} if large else {"spawn_free": _starts(world, radius, seed)}),
    }


def benchmark_worlds(
    worlds: int, size: int = 30, kinds: Iterable[str] = KINDS, tell: Callable[[str], None] = lambda line: None
) -> dict[str, Any]:
    """Generate and judge worlds of every kind.

    Parameters
    ----------
    worlds
        Of each kind.
    size
        Regions of each, about.
    tell
        Called with a line about each kind.

    Returns
    -------
    dict
        ``worlds_per_minute`` by kind (from the median time, one process), and ``kinds`` with the times, the numbers of
        regions, the share of worlds for which each check holds, and the seeds for which one does not.
    """
    options = WorldOptions(size=size)
    rows = {}
    for kind in kinds:
        generate(kind, 0, options)  # loads and compiles what is needed
        rows[kind] = _row(kind, worlds, options)
        tell(_line(kind, rows[kind]))
    speeds = {kind: row["worlds_per_minute"] for kind, row in rows.items()}
    return {"size": size, "worlds": worlds, "worlds_per_minute": speeds, "kinds": rows}


def _row(kind: str, worlds: int, options: WorldOptions) -> dict[str, Any]:
    seconds, regions, verdicts = [], [], []
    for seed in range(worlds):
        began = time.perf_counter()
        world = generate(kind, seed, options)
        seconds.append(time.perf_counter() - began)
        regions.append(len(world.regions))
        verdicts.append(judge(world, seed))
    held = {check: [verdict[check] for verdict in verdicts] for check in CHECKS if check in verdicts[0]}
    return {
        "worlds_per_minute": 60 / float(np.median(seconds)),
        "generation_ms": {"median": 1e3 * float(np.median(seconds)), "worst": 1e3 * max(seconds)},
        "regions": {"median": float(np.median(regions)), "least": min(regions), "most": max(regions)},
        **{check: float(np.mean(values)) for check, values in held.items()},
        "failed": {
            check: [seed for seed, value in enumerate(values) if not value]
            for check, values in held.items()
            if not all(values)
        },
    }


def _line(kind: str, row: dict[str, Any]) -> str:
    checks = ", ".join(f"{check.replace('_', ' ')} {row[check]:.1%}" for check in CHECKS if check in row)
    time_, regions = row["generation_ms"], row["regions"]
    return (
        f"{kind}: {row['worlds_per_minute']:.0f} worlds per minute ({time_['median']:.1f} ms, worst "
        f"{time_['worst']:.1f} ms), {regions['least']} to {regions['most']} regions; {checks}"
    )


def _comes_back(world: World) -> bool:
    """Return whether a world's file is accepted and holds the same."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.geojson"
        save_world(world, path)
        try:
            again = load_world(path)
        except WorldError:
            return False
    places = [[(r.id, r.type, r.name, r.parent) for r in w.regions] for w in (world, again)]
    rows = [np.concatenate([r.row.outline() for r in w.regions]) for w in (world, again)]
    return (
        places[0] == places[1]
        and np.allclose(rows[0], rows[1], atol=1e-9)
        and np.array_equal(world.walls, again.walls)
        and (world.doors, world.links) == (again.doors, again.links)
        and len(world.obstacles) == len(again.obstacles)
    )


def _linked(world: World) -> bool:
    """Return whether links lead from any place to any other; furniture has none."""
    places = {region.id for region in world.regions if region.parent is None}
    seen, waiting = set(), [next(iter(sorted(places)))]
    while waiting:
        place = waiting.pop()
        if place not in seen:
            seen.add(place)
            waiting.extend(link.target for link in world.links_of(place))
    return seen == places


def _starts(world: World, radius: float, seed: int) -> bool:
    """Return whether drawn missions start on free floor, with a way to their goal."""
    task = GoToTask(world, Geodesic(world, radius), TaskSettings(SEMANTIC_TYPES))
    rng = np.random.default_rng(seed)
    try:
        missions = [task.draw(rng) for _ in range(MISSIONS)]
    except ConfigError:
        return False
    return all(task.geodesic.free(*m.start[:2]) and m.shortest is not None for m in missions)
