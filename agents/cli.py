"""The command line `regionslam`. Commands import what they need when they run: `--help` stays quick."""

from __future__ import annotations

import time
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.progress import SpinnerColumn, TextColumn
from rich.table import Table

from agents.benchmark_commands import app as benchmark_app
from agents.console import DONE, FAILED, App, Commands, bar, console, print_json, progress, status_console
from agents.options import Dynamics, Json, WorldName, check_folder, given
from agents.reproduce_commands import app as reproduce_app
from agents.world_commands import app as world_app

if TYPE_CHECKING:
    from agents.run import Moment

app = App(
    cls=Commands,
    help="Semantic navigation under SLAM uncertainty: run missions, train and evaluate agents, measure, tend worlds.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.add_typer(benchmark_app, name="benchmark")
app.add_typer(reproduce_app, name="reproduce")
app.add_typer(world_app, name="world")

EnvId = Annotated[str, typer.Option("--env", help="Id of an environment.")]
Goal = Annotated[str | None, typer.Option(help="Semantic type to go to; by default one drawn per episode.")]
MissionText = Annotated[
    str | None, typer.Option("--mission", help="In words, for a Mission environment; by default one drawn per episode.")
]


def main() -> None:
    """Run the command line."""
    app()


def _version(asked: bool) -> None:
    if asked:
        console().print(f"regionslam {version('regionslam-env')}")
        raise typer.Exit


@app.callback()
def _options(
    asked: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Take what comes before a command."""


@app.command()
def run(
    mission: Annotated[str, typer.Argument(help="In words, e.g. 'go to the lab, then return'.")],
    world: WorldName = "institute",
    seed: Annotated[int, typer.Option(min=0, help="Seed of start, noise and filter.")] = 0,
    start_distance: Annotated[
        float | None, typer.Option(min=0, help="Start at least this far (m, as driven) from the first goal.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for mission.gif, mission.png, map.png, map.geojson and summary.json.")
    ] = None,
    localization: Annotated[str, typer.Option(help="slam, oracle or odometry.")] = "slam",
    noise: Annotated[str, typer.Option(help="Noise set: standard, heavy or none.")] = "standard",
    dynamics: Dynamics = None,
    json: Json = False,
) -> int:
    """Run a mission in words with the scripted agent."""
    from agents.run import RunSettings, run_mission

    check_folder(out)
    settings = RunSettings(mission, world, seed, start_distance, out, localization, noise, dynamics)
    say = console()
    with _Teller(mission) as teller:
        summary = run_mission(settings, teller.tell)
    say.print(_verdict(summary))
    if out is not None:
        say.print(f"See {out / 'mission.png'}, mission.gif, map.png, map.geojson and summary.json beside it.")
    if json:
        print_json(summary)
    return DONE if summary["success"] else FAILED


@app.command()
def evaluate(
    agent: Annotated[str, typer.Argument(help="scripted, random, or the file of a trained model.")],
    env: Annotated[str | None, typer.Option(help="Id of an environment; by default the one trained on.")] = None,
    episodes: Annotated[int, typer.Option(min=1, help="Number of episodes.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first episode; the next ones follow.")] = 0,
    world: Annotated[
        str | None, typer.Option(help="A built-in world, a kind such as office, or the file of one.")
    ] = None,
    goal: Goal = None,
    mission: MissionText = None,
    split: Annotated[str | None, typer.Option(help="train, val or test: disjoint seeds.")] = None,
    localization: Annotated[str | None, typer.Option(help="slam, oracle or odometry.")] = None,
    dynamics: Dynamics = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for a film and a picture of each episode, and summary.json.")
    ] = None,
    json: Json = False,
) -> int:
    """Evaluate an agent: means with 95 % confidence intervals."""
    import gymnasium

    from agents.evaluate import check_environment, load_model, make_agent, settings_of, summarize, write_summary
    from agents.evaluate import evaluate as run_episodes

    check_folder(out)
    model = load_model(agent)
    trained = {} if model is None else model.regionslam
    env_id = check_environment(env or trained.get("env_id", "RegionSLAM/GoTo-v0"), goal=goal, mission=mission)
    chosen = given(world=world, goal=goal, mission=mission, split=split, localization=localization, dynamics=dynamics)
    kwargs = {**trained.get("env_kwargs", {}), **chosen}
    environment = gymnasium.make(env_id, **kwargs)
    with bar() as shown:
        task = shown.add_task("episodes", total=episodes)
        results = run_episodes(
            environment,
            make_agent(agent, environment, seed, model),
            episodes,
            seed,
            lambda episode, metrics: shown.advance(task),
            out,
        )
    environment.close()
    metrics = summarize(results)
    console().print(_metrics_table(f"{agent} on {env_id}, {episodes} episodes", metrics))
    made = {"agent": agent, "env": env_id, "episodes": episodes, "seed": seed, "settings": settings_of(environment)}
    summary = {**made, "version": version("regionslam-env"), "metrics": metrics}
    if out is not None:
        write_summary(out, summary)
    if json:
        print_json(summary)
    return DONE


@app.command()
def train(
    env: EnvId = "RegionSLAM/GoTo-v0",
    steps: Annotated[int, typer.Option(min=1, help="Environment steps in all.")] = 1_000_000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of policy and episodes.")] = 0,
    out: Annotated[Path, typer.Option(help="File of the model (.zip); logs go beside it.")] = Path("runs/ppo.zip"),
    n_envs: Annotated[int, typer.Option("--envs", min=1, help="Environments side by side.")] = 1,
    checkpoint_every: Annotated[int, typer.Option(min=1, help="Steps between checkpoints.")] = 50_000,
    world: Annotated[
        str | None, typer.Option(help="A built-in world, a kind such as office, or the file of one.")
    ] = None,
    goal: Goal = None,
    mission: MissionText = None,
    json: Json = False,
) -> int:
    """Train Stable-Baselines3's PPO (extra `train`)."""
    from agents.evaluate import check_environment
    from agents.train import TrainSettings
    from agents.train import train as run_training

    check_environment(env, goal=goal, mission=mission)
    check_folder(out.parent)
    began = time.perf_counter()
    settings = TrainSettings(
        env, steps, seed, out, n_envs, checkpoint_every, given(world=world, goal=goal, mission=mission)
    )
    saved = run_training(settings, progress=status_console().is_terminal)
    seconds = time.perf_counter() - began
    console().print(f"Trained {steps} steps in {seconds:.0f} s; saved {saved}. Evaluate: regionslam evaluate {saved}")
    if json:
        print_json({"model": str(saved), "env": env, "steps": steps, "seed": seed, "wall_seconds": round(seconds, 3)})
    return DONE


@app.command()
def play(
    env: EnvId = "RegionSLAM/GoTo-v0",
    world: WorldName = "institute",
    goal: Goal = None,
    mission: MissionText = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Play one certain episode, again and again.")] = None,
    dynamics: Dynamics = None,
    json: Json = False,
) -> int:
    """Drive by keyboard in a window (extra `render`)."""
    import gymnasium

    from agents.evaluate import check_environment
    from agents.play import HELP
    from agents.play import play as drive

    say = console()
    check_environment(env, goal=goal, mission=mission)
    chosen = given(goal=goal, mission=mission, dynamics=dynamics)
    environment = gymnasium.make(env, world=world, render_mode="rgb_array", **chosen)
    say.print(HELP)
    finished: list[dict[str, Any]] = []

    def tell(info: dict[str, Any]) -> None:
        finished.append({"success": info["success"], "spl": info["spl"]})
        say.print(f"{'Done' if info['success'] else 'Failed'}: SPL {info['spl'] or 0:.2f}.")

    drive(environment, seed, tell)
    environment.close()
    if json:
        print_json({"env": env, "world": world, "episodes": finished})
    return DONE


class _Teller:
    """Shows the progress of a mission on standard error and the robot's words on standard output."""

    def __init__(self, mission: str) -> None:
        self._out = console()
        self._progress = progress(SpinnerColumn(), TextColumn("{task.description}"))
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
    from agents.run import ending, shortfall

    if summary["success"]:
        verdict = "[bold green]Done[/bold green]"
    else:
        verdict = f"[bold red]Failed[/bold red] ({ending(summary)}, {shortfall(summary)})"
    spl = "" if summary["spl"] is None else f"SPL {summary['spl']:.2f}, "
    return (
        f"{verdict}: {summary['path_length']:.1f} m in {summary['steps']} steps, {spl}"
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


if __name__ == "__main__":
    main()
