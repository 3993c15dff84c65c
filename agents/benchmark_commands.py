"""Commands that measure: `regionslam benchmark env | filter | tour | accuracy | robustness | worlds | fuzz`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from agents.console import DONE, FAILED, App, InputError, bar, console, print_json, track
from agents.options import Json, Noise, Occlusion, Particles, WorldName, check_folder


class EnvironmentByDefault(TyperGroup):
    """The group of all benchmarks; without the name of one it is `env`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put `env` before options that follow no benchmark."""
        if not args or (args[0].startswith("-") and args[0] not in ctx.help_option_names):
            args = ["env", *args]
        return super().parse_args(ctx, args)


app = App(cls=EnvironmentByDefault, help="Measure speed and accuracy.", rich_markup_mode=None)

Steps = Annotated[int, typer.Option(min=100, help="Steps in all.")]
Copies = Annotated[int, typer.Option(min=1, help="Copies in the vector environment.")]
Seeds = Annotated[int, typer.Option(min=1, help="Number of seeds.")]


@app.command("env")
def environment(steps: Steps = 20_000, world: WorldName = "institute", copies: Copies = 64, json: Json = False) -> int:
    """Count steps per second, of one environment and of many.

    Installed peers take turns with them, and a step is timed by part.
    """
    from agents.benchmark import benchmark_environment

    say = console()
    result = benchmark_environment(steps, copies=copies, world=world, tell=say.print)
    say.print(
        f"{result['env']}: {result['steps_per_second']:.0f} steps per second, reset {result['reset_ms']:.1f} ms "
        f"({result['quiet']} of {result['repeats']} repeats on a quiet machine)"
    )
    say.print("taken part by part, with timers, a step spends")
    for part, microseconds in result["microseconds"].items():
        say.print(f"  {part:<14}{microseconds:8.1f} µs")
    say.print(
        f"{copies} copies in one process: {result['vector_steps_per_second']:.0f} steps per second in all, "
        f"{result['vector_ratio']:.2f} times as many"
    )
    for peer, figures in result["peers"].items():
        say.print(
            f"{peer}: {figures['steps_per_second']:.0f} steps per second; ours are {figures['ratio']:.2f} times "
            f"as many, {figures['vector_ratio']:.2f} times with {copies} copies"
        )
    return _done(result, json)


@app.command("filter")
def filter_(json: Json = False) -> int:
    """Time an update of the filter, and weigh its maps.

    An update over particles, measurements and regions, and by part; the maps of 1,000 particles.
    """
    from agents.filter_benchmark import benchmark_filter

    say = console()
    result = benchmark_filter(say.print)
    for part, microseconds in result["parts_us"].items():
        say.print(f"  {part:<14}{microseconds:8.1f} µs")
    stored = result["memory"]
    say.print(
        f"{result['update_us']:.0f} µs per update of 4 particles, 12 measurements, 30 regions; "
        f"{result['tour_us']:.0f} µs on the tour with {result['tour_measurements']:.0f} measurements"
    )
    say.print(f"{result['map_size_ratio']:.2f} times as long with 10,000 regions in the map and the same view")
    say.print(f"{result['particles_1000_hz']:.0f} updates per second of 1,000 particles")
    say.print(
        f"1,000 particles x 10,000 regions, {stored['driven']:.0f} m driven: {stored['megabytes']:.0f} MB "
        f"({stored['unshared_megabytes']:.0f} MB if they shared nothing)"
    )
    return _done(result, json)


@app.command()
def tour(
    seeds: Seeds = 10,
    particles: Particles = 4,
    noise: Noise = "standard",
    occlusion: Occlusion = False,
    json: Json = False,
) -> int:
    """Judge the filter on a course of 328 m, seed by seed."""
    from agents import accuracy
    from agents.parallel import over_seeds

    run = partial(accuracy.tour, n_particles=particles, noise=noise, occlusion=occlusion)
    runs = list(track(over_seeds(run, range(seeds), accuracy.warm_up), seeds, "seeds"))
    say = console()
    for values in runs:
        say.print("  ".join(f"{name} {_figure(value)}" for name, value in values.items()))
    worst = max(values["ape_max"] for values in runs)
    say.print(f"{seeds} seeds: position off by {worst:.2f} m at most")
    settings = {"seeds": seeds, "n_particles": particles, "noise": noise, "occlusion": occlusion}
    return _done({**settings, "ape_max_worst": worst, "runs": runs}, json)


@app.command("accuracy")
def accuracy_(
    seeds: Seeds = 20,
    particles: Annotated[
        list[int] | None, typer.Option("--particles", min=1, help="Particles; repeat it for several (default 4, 16).")
    ] = None,
    noise: Noise = "standard",
    occlusion: Occlusion = False,
    calibrated: Annotated[
        bool, typer.Option(help="Simulate the noise that the filter is told, no larger one.")
    ] = False,
    json: Json = False,
) -> int:
    """Compare the filter with the optimum of the same data."""
    from agents import accuracy
    from agents.batch import AVAILABLE, MISSING
    from agents.comparison import compare, summarize
    from agents.parallel import over_seeds

    numbers = sorted(set(particles or (4, 16)))
    run = partial(compare, particles=numbers, noise=noise, occlusion=occlusion, calibrated=calibrated)
    runs = list(track(over_seeds(run, range(seeds), accuracy.warm_up), seeds, "seeds"))
    settings = {"noise": noise, "occlusion": occlusion, "calibrated": calibrated}
    result = {**settings, **summarize(runs, numbers)}
    say = console()
    if not AVAILABLE:
        say.print(f"Without the smoothed optimum: {MISSING}.")
    say.print(f"{'':<14}RMSE m  aligned   90 %  worst  pose NEES / 3  region NEES")
    for name, values in result["filters"].items():
        calibration = "".join(f"{values[key]:>13.2f}" if key in values else "" for key in ("pose_nees", "region_nees"))
        errors = (values[key] for key in ("ape_rmse", "ape_aligned", "ape_rmse_p90", "ape_max_worst"))
        say.print(f"{name:<14}" + "".join(f"{error:>7.3f}" for error in errors) + calibration)
    for key in ("ratio_to_optimum", "ratio_to_optimum_4", "ratio_to_batch"):
        if result[key] is not None:
            say.print(f"{key}: {result[key]:.2f}, aligned {result[key + '_aligned']:.2f}")
    return _done(result, json)


@app.command()
def robustness(
    seeds: Seeds = 10,
    scenario: Annotated[list[str] | None, typer.Option(help="Only this one; may be repeated.")] = None,
    json: Json = False,
) -> int:
    """Judge the filter where things go wrong.

    Wheel slip, wrong types, twins, kidnapping and more.
    """
    from agents import robustness as measure
    from agents.parallel import over_seeds
    from agents.scenarios import SCENARIOS
    from regionslam_env.errors import unknown

    names = tuple(scenario or SCENARIOS)
    for name in names:
        if name not in SCENARIOS:
            raise InputError(unknown("scenario", name, SCENARIOS))
    items = range(len(names) * seeds)
    item = partial(measure.run_item, names=names, seeds=seeds)
    runs = list(track(over_seeds(item, items, measure.warm_up), len(items), "runs"))
    rows = [measure.summary(runs[k * seeds : (k + 1) * seeds]) for k in range(len(names))]
    say = console()
    say.print("scenario (seeds passed): median / worst of each figure")
    for row in rows:
        figures = [f"{k} {_figure(v['median'])} / {_figure(v['worst'])}" for k, v in row["figures"].items()]
        say.print(f"{row['scenario']} ({row['passed']} of {seeds}): {', '.join(figures)}")
    return _done({"seeds": seeds, "scenarios": rows, "runs": runs}, json)


@app.command()
def worlds(
    count: Annotated[int, typer.Option("--worlds", min=1, help="Worlds of each kind.")] = 100,
    size: Annotated[int, typer.Option(min=5, max=10_000, help="Regions of each, about.")] = 30,
    kind: Annotated[list[str] | None, typer.Option(help="Only this kind; may be repeated.")] = None,
    json: Json = False,
) -> int:
    """Time the generation of worlds, and check each.

    Valid, connected, and free to start and to arrive in.
    """
    from agents.world_benchmark import benchmark_worlds
    from regionslam_env.errors import unknown
    from regionslam_env.worlds.generate.generator import KINDS

    for name in kind or ():
        if name not in KINDS:
            raise InputError(unknown("kind of world", name, KINDS))
    return _done(benchmark_worlds(count, size, kind or KINDS, console().print), json)


@app.command()
def fuzz(
    mutations: Annotated[int, typer.Option(min=1, help="Damaged buildings.")] = 10_000,
    first: Annotated[int, typer.Option(min=0, help="Number of the first; the number is its seed.")] = 0,
    examples: Annotated[
        Path | None, typer.Option(help="Folder of buildings to damage; by default those of the tests.")
    ] = None,
    limit: Annotated[float, typer.Option(min=1, help="Seconds after which one counts as hung.")] = 60.0,
    out: Annotated[Path | None, typer.Option(help="Folder for the damaged files of what failed.")] = None,
    json: Json = False,
) -> int:
    """Damage buildings of every format, and try to import them.

    Each has to give a world or one clear line, in time and without a traceback.
    """
    from agents.fuzzing.campaign import EXAMPLES, benchmark_fuzz

    check_folder(out)
    with bar() as shown:
        task = shown.add_task("damaged buildings", total=mutations)
        result = benchmark_fuzz(mutations, first, examples or EXAMPLES, limit, out, lambda outcome: shown.advance(task))
    say = console()
    for name, counts in result["formats"].items():
        say.print(f"{name:<10}  " + ", ".join(f"{outcome} {count}" for outcome, count in sorted(counts.items())))
    for failure in result["failures"]:
        last = failure["detail"].strip().splitlines()[-1:]
        say.print("{number}: {file}: {outcome}: ".format(**failure) + "".join(last), markup=False)
    say.print(f"{len(result['failures'])} of {mutations} failed; --first N --mutations 1 does number N again")
    _done(result, json)
    return FAILED if result["failures"] else DONE


def _done(result: dict[str, Any], json: bool) -> int:
    if json:
        print_json(result)
    return DONE


def _figure(value: float | None) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)
