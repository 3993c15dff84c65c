"""Commands that repeat the paper's experiments: `regionslam reproduce fig5 | fig6`. Each is one function here."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from agents.console import DONE, App, console, print_json, track
from agents.options import Json, Noise, Occlusion, Particles, check_folder

app = App(help="Repeat the paper's experiments and draw its figures.", no_args_is_help=True, rich_markup_mode=None)

Out = Annotated[Path | None, typer.Option(help="Folder to draw the figure in (extra `plots`).")]


@app.command("fig5")
def figure_5(
    seeds: Annotated[int, typer.Option(min=1, help="Number of runs.")] = 60,
    out: Out = None,
    json: Json = False,
) -> int:
    """Repeat figure 5: one region of 18 m from partial views.

    Both geometric updates estimate it.
    """
    from agents.reproduce import fig5

    check_folder(out)
    runs = list(track(fig5.fig5_runs(seeds), seeds, "runs"))
    result = fig5.fig5(runs)
    say = console()
    say.print(_table("Fig. 5", ("", "the paper's update", "edge form"), fig5.comparison(result)))
    if out is not None:
        from agents.reproduce.draw_fig5 import draw_fig5

        draw_fig5(runs, out / "fig5.png")
        say.print(f"Drawn: {out / 'fig5.png'}")
    if json:
        print_json(result)
    return DONE


@app.command("fig6")
def figure_6(
    seeds: Annotated[int, typer.Option(min=1, help="Number of runs.")] = 20,
    out: Out = None,
    particles: Particles = 4,
    noise: Noise = "standard",
    occlusion: Occlusion = False,
    misclassification: Annotated[float, typer.Option(min=0, max=1, help="Share of wrong types.")] = 0.0,
    json: Json = False,
) -> int:
    """Repeat figure 6: the filter on a course of 328 m.

    Its correspondences are unknown.
    """
    from agents import accuracy
    from agents.parallel import over_seeds
    from agents.reproduce import fig6

    check_folder(out)
    run = partial(
        fig6.run_course,
        n_particles=particles,
        noise=noise,
        occlusion=occlusion,
        misclassification=misclassification,
    )
    courses = list(track(over_seeds(run, range(seeds), accuracy.warm_up), seeds, "runs"))
    settings = {"noise": noise, "occlusion": occlusion, "misclassification": misclassification}
    result = {**fig6.fig6(courses, particles), **settings}
    say = console()
    say.print(
        _table("Fig. 6", ("", "the paper says", "we measure"), fig6.comparison(result, fig6.course_length(courses[0])))
    )
    for miss in result["misses"]:
        say.print(
            f"seed {miss['seed']}: off by up to {miss['ape_max']:.2f} m, the optimum of its data by "
            f"{miss['optimum_ape_max']:.2f} m"
        )
    if out is not None:
        from agents.reproduce.draw_fig6 import draw_fig6

        draw_fig6(courses, result, out / "fig6.png")
        say.print(f"Drawn: {out / 'fig6.png'}")
    if json:
        print_json(result)
    return DONE


def _table(title: str, headings: tuple[str, ...], rows: list[tuple[str, str, str]]) -> Table:
    table = Table(title=title, title_justify="left")
    for heading in headings:
        table.add_column(heading)
    for row in rows:
        table.add_row(*row)
    return table
