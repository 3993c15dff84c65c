"""One mission in words, from start to end: what `regionslam run` does."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import gymnasium

from agents.evaluate import plain, scripted_agent, write_summary
from agents.recorder import Recorder
from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.missions.language import parse
from regionslam_env.worlds.source import WorldSource
from regionslam_env.worlds.world import World
from slam.storage import replacing, save_map

ENVIRONMENT = "RegionSLAM/Mission-v0"
MAX_STEPS = 6000
MAX_REGIONS = 128
MAP_SHARE = 0.9

SUMMARY_KEYS = (
    *("success", "completed", "explored", "false_arrival", "steps", "path_length", "spl"),
    *("ape_max", "ape_end", "collisions", "wall_seconds"),
    *("mission", "world", "seed", "start_distance", "localization", "noise", "dynamics", "version"),
)


@dataclass(frozen=True)
class Moment:
    """What can be told of a running mission after a step."""

    step: int
    seconds: float
    driven: float
    doing: str
    place: str


@dataclass(frozen=True)
class RunSettings:
    """A mission to run.

    Parameters
    ----------
    mission
        In words, e.g. "go to the hallway".
    world
        Built-in name, kind or file.
    seed
        Of the episode: start, sensor noise and filter; of a kind also the number of the world.
    start_distance
        Least geodesic distance of the start from the first goal, m; None: that of the environment.
    out
        Folder for `mission.gif`, `mission.png`, `map.png`, `map.geojson` and `summary.json`; None writes nothing.
    localization
        "slam", "oracle" or "odometry".
    noise
        Name of a noise set.
    dynamics
        Name of what moves; None: nothing.
    """

    mission: str
    world: str = "institute"
    seed: int = 0
    start_distance: float | None = None
    out: Path | None = None
    localization: str = "slam"
    noise: str = "standard"
    dynamics: str | None = None


def run_mission(settings: RunSettings, tell: Callable[[Moment], None] = lambda moment: None) -> dict[str, Any]:
    """Run a mission and return its summary; the same settings give the same summary but for `wall_seconds`.

    Parameters
    ----------
    settings
        What to run.
    tell
        Called after every step.

    Raises
    ------
    ValueError
        For a mission, world or option that cannot be used, before anything has been driven or written.
    """
    began = time.perf_counter()
    world = WorldSource(settings.world).world(settings.seed)
    env = make_environment(settings, world)
    try:
        observation, _ = env.reset(seed=settings.seed)
        if settings.out is not None:
            settings.out.mkdir(parents=True, exist_ok=True)
        base: Any = env.unwrapped
        agent = scripted_agent(base)
        recorder = Recorder(base, settings.mission) if settings.out is not None else None
        info: dict[str, Any] = {}
        done, step = False, 0
        while not done:
            action = agent.act(observation)
            observation, _, terminated, truncated, info = env.step(action)
            done, step = terminated or truncated, step + 1
            if recorder is not None:
                recorder.add(agent.say(), done)
            tell(_moment(base, agent, step))
        summary = _summary(settings, base, info, step, time.perf_counter() - began)
        if settings.out is not None and recorder is not None:
            _write(settings.out, recorder, base, summary)
        return summary
    finally:
        env.close()


def make_environment(settings: RunSettings, world: World) -> gymnasium.Env[Any, Any]:
    """Return the environment of a mission; the world's own types may be goals beside the usual ones."""
    mission = parse(settings.mission, world.types)
    *types, other = SEMANTIC_TYPES
    types += [name for name in mission.types if name not in SEMANTIC_TYPES]
    kwargs: dict[str, Any] = {
        "world": world,
        "mission": mission,
        "arrival": "declare",
        "max_steps": MAX_STEPS,
        "max_regions": MAX_REGIONS,
        "map_share": MAP_SHARE,
        "semantic_types": (*types, other),
        "localization": settings.localization,
        "noise": settings.noise,
        "dynamics": settings.dynamics,
    }
    if settings.start_distance is not None:
        kwargs["start_distance"] = settings.start_distance
    return gymnasium.make(ENVIRONMENT, **kwargs)


def _moment(base: Any, agent: Any, step: int) -> Moment:
    belief = base.belief
    place = belief.map.describe(belief.pose_mean, probabilities=belief.where()) if step % 10 == 1 else ""
    return Moment(step, step * base.robot.step, base.simulation.path_length, agent.say(), place)


def _summary(settings: RunSettings, base: Any, info: dict[str, Any], steps: int, wall_seconds: float) -> dict[str, Any]:
    values = {
        **{key: info[key] for key in SUMMARY_KEYS if key in info},
        "steps": steps,
        "wall_seconds": round(wall_seconds, 3),
        **{key: value for key, value in vars(settings).items() if key in SUMMARY_KEYS},
        "start_distance": base.task.start_distance,
        "dynamics": settings.dynamics or "none",
        "version": version("regionslam-env"),
    }
    return {key: plain(values[key]) for key in SUMMARY_KEYS}


def ending(summary: dict[str, Any]) -> str:
    """Return in words how a mission ended."""
    if summary["success"]:
        return "done"
    return "declared done what was not" if summary["false_arrival"] else "out of time"


def shortfall(summary: dict[str, Any]) -> str:
    """Return in words how much of a failed mission was done."""
    words = f"{summary['completed']:.0%} of the instructions done"
    explored = summary["explored"]
    if explored is None or explored >= MAP_SHARE:
        return words
    return f"{words}, {explored:.1%} of the regions mapped where {MAP_SHARE:.0%} are needed"


def _verdict(summary: dict[str, Any]) -> str:
    """Return how a mission ended, in a few words."""
    return f"{ending(summary)}; at the end the robot is {100 * summary['ape_end']:.0f} cm from where it believes to be"


def _write(out: Path, recorder: Recorder, base: Any, summary: dict[str, Any]) -> None:
    """Write everything; each file is complete or absent, the summary comes last."""
    recorder.write_animation(out / "mission.gif")
    for name, picture in (
        ("mission.png", recorder.mission_picture(_verdict(summary))),
        ("map.png", recorder.map_picture()),
    ):
        with replacing(out / name) as temporary:
            picture.save(temporary)
    save_map(base.belief.map, out / "map.geojson")
    write_summary(out, summary)
