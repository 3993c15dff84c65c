"""The command line `regionslam`. Commands import what they need when they run: `--help` stays quick."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Table

from agents.console import DONE, FAILED, Commands, InputError, console, print_json, status_console
from agents.world_commands import app as world_app

if TYPE_CHECKING:
    from agents.run import Moment

app = typer.Typer(
    cls=Commands,
    help="Semantic navigation under SLAM uncertainty: run missions, train and evaluate agents, look after worlds.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.add_typer(world_app, name="world")

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object as the last line.")]
WorldName = Annotated[str, typer.Option("--world", help="A built-in world or the file of one.")]
EnvId = Annotated[str, typer.Option("--env", help="Id of an environment.")]


def main() -> None:
    """Run the command line."""
    app()


@app.command()
def run(
    mission: Annotated[str, typer.Argument(help="In words, e.g. 'go to the hallway'.")],
    world: WorldName = "institute",
    seed: Annotated[int, typer.Option(min=0, help="Seed of start, noise and filter.")] = 0,
    start_distance: Annotated[
        float | None, typer.Option(min=0, help="Start this far (m, as driven) from the goal.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for mission.gif, map.png, map.geojson and summary.json.")
    ] = None,
    localization: Annotated[str, typer.Option(help="slam, oracle or odometry.")] = "slam",
    noise: Annotated[str, typer.Option(help="Noise set: standard, heavy or none.")] = "standard",
    json: Json = False,
) -> int:
    """Run a mission in words with the scripted agent."""
    from agents.run import RunSettings, run_mission

    _check_folder(out)
    settings = RunSettings(mission, world, seed, start_distance, out, localization, noise)
    say = console()
    with _Teller(mission) as teller:
        summary = run_mission(settings, teller.tell)
    say.print(_verdict(summary))
    if out is not None:
        say.print(f"See {out / 'mission.gif'}, map.png, map.geojson and summary.json beside it.")
    if json:
        print_json(summary)
    return DONE if summary["success"] else FAILED


@app.command()
def evaluate(
    agent: Annotated[str, typer.Argument(help="scripted, random, or the file of a trained model.")],
    env: Annotated[str | None, typer.Option(help="Id of an environment; by default the one trained on.")] = None,
    episodes: Annotated[int, typer.Option(min=1, help="Number of episodes.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first episode; the next ones follow.")] = 0,
    world: Annotated[str | None, typer.Option(help="A built-in world or the file of one.")] = None,
    goal: Annotated[str | None, typer.Option(help="Semantic type to go to; by default one drawn per episode.")] = None,
    split: Annotated[str | None, typer.Option(help="train, val or test: disjoint seeds.")] = None,
    localization: Annotated[str | None, typer.Option(help="slam, oracle or odometry.")] = None,
    json: Json = False,
) -> int:
    """Evaluate an agent: means with 95 % confidence intervals."""
    import gymnasium

    from agents.evaluate import check_environment, load_model, make_agent, summarize
    from agents.evaluate import evaluate as run_episodes

    model = load_model(agent)
    trained = {} if model is None else model.regionslam
    env_id = check_environment(env or trained.get("env_id", "RegionSLAM/GoTo-v0"))
    kwargs = {**trained.get("env_kwargs", {}), **_given(world=world, goal=goal, split=split, localization=localization)}
    environment = gymnasium.make(env_id, **kwargs)
    with _bar() as progress:
        task = progress.add_task("episodes", total=episodes)
        results = run_episodes(
            environment,
            make_agent(agent, environment, seed, model),
            episodes,
            seed,
            lambda episode, metrics: progress.advance(task),
        )
    environment.close()
    summary = summarize(results)
    console().print(_metrics_table(f"{agent} on {env_id}, {episodes} episodes", summary))
    if json:
        print_json({"agent": agent, "env": env_id, "episodes": episodes, "seed": seed, "metrics": summary})
    return DONE


@app.command()
def train(
    env: EnvId = "RegionSLAM/GoTo-v0",
    steps: Annotated[int, typer.Option(min=1, help="Environment steps in all.")] = 1_000_000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of policy and episodes.")] = 0,
    out: Annotated[Path, typer.Option(help="File of the model; logs go beside it.")] = Path("runs/ppo.zip"),
    n_envs: Annotated[int, typer.Option("--envs", min=1, help="Environments side by side.")] = 1,
    checkpoint_every: Annotated[int, typer.Option(min=1, help="Steps between checkpoints.")] = 50_000,
    world: Annotated[str | None, typer.Option(help="A built-in world or the file of one.")] = None,
    goal: Annotated[str | None, typer.Option(help="Semantic type to go to; by default one drawn per episode.")] = None,
    json: Json = False,
) -> int:
    """Train Stable-Baselines3's PPO (extra `train`)."""
    from agents.evaluate import check_environment
    from agents.train import TrainSettings
    from agents.train import train as run_training

    check_environment(env)
    _check_folder(out.parent)
    began = time.perf_counter()
    settings = TrainSettings(env, steps, seed, out, n_envs, checkpoint_every, _given(world=world, goal=goal))
    saved = run_training(settings, progress=status_console().is_terminal)
    seconds = time.perf_counter() - began
    console().print(f"Trained {steps} steps in {seconds:.0f} s; saved {saved}. Evaluate: regionslam evaluate {saved}")
    if json:
        print_json({"model": str(saved), "env": env, "steps": steps, "seed": seed, "wall_seconds": round(seconds, 3)})
    return DONE


@app.command()
def benchmark(
    what: Annotated[str, typer.Argument(help="env, filter or tour.")] = "env",
    steps: Annotated[int | None, typer.Option(min=100, help="Steps in all (env, filter).")] = None,
    world: WorldName = "institute",
    seeds: Annotated[int, typer.Option(min=1, help="Seeds (tour).")] = 10,
    particles: Annotated[int, typer.Option(min=1, help="Particles (tour).")] = 4,
    occlusion: Annotated[bool, typer.Option(help="Whether walls hide regions (tour).")] = False,
    json: Json = False,
) -> int:
    """Measure the speed of the environment (env, by part) or the filter, or the filter's accuracy on a 300 m tour."""
    from agents.accuracy import tour_errors
    from agents.benchmark import benchmark_environment, benchmark_filter
    from regionslam_env.errors import unknown

    if what == "env":
        result = benchmark_environment(steps or 20_000, world=world)
        lines = _environment_lines(result)
    elif what == "filter":
        result = benchmark_filter(steps=steps or 2_000)
        lines = [
            f"{result['filter_us']:.0f} µs per step with {result['particles']} particles,"
            f" {result['measurements']} measurements, {result['regions']} regions"
        ]
    elif what == "tour":
        runs = []
        for run in tour_errors(seeds, particles, occlusion=occlusion):
            console().print("  ".join(f"{name} {_figure(value)}" for name, value in run.items()))
            runs.append(run)
        worst = max(run["ape_max"] for run in runs)
        lines = [f"{seeds} seeds: position off by {worst:.2f} m at most"]
        result = {
            "seeds": seeds,
            "n_particles": particles,
            "occlusion": occlusion,
            "ape_max_worst": worst,
            "runs": runs,
        }
    else:
        raise InputError(unknown("benchmark", what, ("env", "filter", "tour")))
    console().print("\n".join(lines))
    if json:
        print_json(result)
    return DONE


class _Teller:
    """Shows the progress of a mission on standard error and the robot's words on standard output."""

    def __init__(self, mission: str) -> None:
        self._out = console()
        self._progress = _progress(SpinnerColumn(), TextColumn("{task.description}"))
        self._task = self._progress.add_task(mission, total=None)
        self._said = ("", "")

    def __enter__(self) -> _Teller:
        self._progress.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._progress.stop()

    def tell(self, moment: Moment) -> None:
        """Take in a moment; say something where there is something new."""
        if not moment.place:
            return
        text = f"{moment.seconds:6.1f} s  {moment.driven:6.1f} m  {moment.doing}"
        self._progress.update(self._task, description=text)
        if (moment.place, moment.doing) != self._said:
            self._said = (moment.place, moment.doing)
            self._out.print(f"{moment.seconds:6.1f} s  {moment.place}  [dim]{moment.doing}[/dim]")


def _verdict(summary: dict[str, Any]) -> str:
    if summary["success"]:
        verdict = "[bold green]Done[/bold green]"
    else:
        reason = "arrival declared in the wrong place" if summary["false_arrival"] else "never arrived"
        verdict = f"[bold red]Failed[/bold red] ({reason})"
    return (
        f"{verdict}: {summary['path_length']:.1f} m in {summary['steps']} steps, SPL {summary['spl']:.2f}, "
        f"position off by {summary['ape_end']:.2f} m at the end and {summary['ape_max']:.2f} m at most, "
        f"{summary['collisions']} collisions"
    )


def _metrics_table(title: str, summary: dict[str, dict[str, float | int | None]]) -> Table:
    table = Table(title=title, title_justify="left")
    for heading in ("metric", "mean", "95 % interval", "episodes"):
        table.add_column(heading, justify="left" if heading == "metric" else "right")
    for name, s in summary.items():
        interval = "" if s["low"] is None else f"{s['low']:.3f} to {s['high']:.3f}"
        table.add_row(name, "" if s["mean"] is None else f"{s['mean']:.3f}", interval, str(s["n"]))
    return table


def _figure(value: float | None) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def _environment_lines(result: dict[str, Any]) -> list[str]:
    parts = result["microseconds"]
    return [
        f"{result['env']}: {result['steps_per_second']:.0f} steps per second, reset {result['reset_ms']:.1f} ms "
        f"({result['quiet']} of {result['repeats']} repeats on a quiet machine)",
        *(f"  {part:<14}{microseconds:8.1f} µs" for part, microseconds in parts.items()),
    ]


def _progress(*columns: ProgressColumn) -> Progress:
    """Return a progress display on standard error that vanishes when done and is silent where nobody watches."""
    target = status_console()
    return Progress(*columns, console=target, transient=True, disable=not target.is_terminal)


def _bar() -> Progress:
    return _progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _check_folder(folder: Path | None) -> None:
    """Refuse a folder that cannot be one before any work is done."""
    if folder is None:
        return
    for part in (folder, *folder.parents):
        if part.exists():
            if not part.is_dir():
                raise InputError(f"{part}: a file, expected a folder")
            return


if __name__ == "__main__":
    main()
