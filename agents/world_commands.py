"""Commands about worlds: list, show, import, validate, generate, gallery."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from agents.console import DONE, App, InputError, console, print_json
from agents.generation_commands import gallery, generate
from agents.options import Json

if TYPE_CHECKING:
    from regionslam_env.worlds.world import World

app = App(help="List, show, import, generate and check worlds.", no_args_is_help=True, rich_markup_mode=None)
app.command()(generate)
app.command()(gallery)


@app.command("list")
def list_worlds(json: Json = False) -> int:
    """List the built-in worlds, and the kinds that can be generated."""
    from regionslam_env.worlds.generate.generator import KINDS
    from regionslam_env.worlds.loading import builtin_names, load

    facts = [_facts(load(name)) for name in builtin_names()]
    table = Table()
    for heading in ("world", "regions", "doors", "size (m)"):
        table.add_column(heading, justify="left" if heading == "world" else "right")
    for world in facts:
        table.add_row(
            world["name"], str(world["regions"]), str(world["doors"]), "{:.0f} x {:.0f}".format(*world["size"])
        )
    console().print(table)
    console().print(f"Kinds to generate: {', '.join(KINDS)}")
    if json:
        print_json({"worlds": facts, "kinds": list(KINDS)})
    return DONE


@app.command()
def show(
    world: Annotated[str, typer.Argument(help="A built-in world, a kind such as office, or the file of one.")],
    seed: Annotated[int, typer.Option(min=0, help="Number of the world, for a kind.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Picture to draw (.png).")] = None,
    json: Json = False,
) -> int:
    """Describe a world and draw it."""
    from regionslam_env.worlds.source import WorldSource

    truth = WorldSource(world).world(seed)
    facts = _facts(truth)
    say = console()
    say.print(
        "{}: {:.0f} x {:.0f} m, {} regions, {} doors".format(
            facts["name"], *facts["size"], facts["regions"], facts["doors"]
        )
    )
    say.print(", ".join(f"{count} {kind}" for kind, count in facts["types"].items()))
    if out is not None:
        from regionslam_env.rendering import draw_truth
        from slam.storage import replacing

        if out.suffix.lower() not in (".png", ".jpg", ".webp"):
            raise InputError(f"{out}: ending {out.suffix!r}, expected a picture, e.g. {out.with_suffix('.png').name}")
        with replacing(out) as temporary:
            draw_truth(truth).save(temporary)
        say.print(f"Drawn: {out}")
    if json:
        print_json(facts)
    return DONE


@app.command("import")
def import_world(
    file: Annotated[Path, typer.Argument(help="A building's file, its folder, or a folder of many of them.")],
    out: Annotated[Path | None, typer.Option(help="The world in our format (.geojson); of many: a folder.")] = None,
    level: Annotated[str | None, typer.Option(help="Which level; default: the one with the most rooms.")] = None,
    scale: Annotated[float | None, typer.Option(help="Metres per unit of the file.")] = None,
    types: Annotated[Path | None, typer.Option(help="Table of types (JSON) that overlays ours.")] = None,
    assume_doors: Annotated[bool, typer.Option(help="Whether rooms without a way in get a door to a hallway.")] = True,
    json: Json = False,
) -> int:
    """Turn a building's file into our format, and report.

    The report tells how well it went.
    """
    from agents.plans import import_folder, import_one
    from regionslam_env.worlds.importers.formats import is_one_building
    from regionslam_env.worlds.importers.realise import ImportOptions

    options = ImportOptions(level, scale, types, assume_doors)
    if file.is_dir() and not is_one_building(file):
        return import_folder(file, out, options, json)
    return import_one(file, out, options, json)


@app.command()
def survey(
    folder: Annotated[Path, typer.Argument(help="A folder of buildings in any format.")],
    json: Json = False,
) -> int:
    """Try to import all buildings in a folder, every level.

    Prints how well each went, and writes nothing.
    """
    from agents.plans import survey_folder

    return survey_folder(folder, json)


@app.command()
def validate(file: Annotated[Path, typer.Argument(help="The file of a world.")], json: Json = False) -> int:
    """Check a world's file.

    Warns of regions that the robot cannot get to.
    """
    from regionslam_env.worlds.loading import load
    from regionslam_env.worlds.reachability import unreachable

    world = load(file)
    if all(region.type == "door" or region.parent is not None for region in world.regions):
        raise InputError(
            f"world {world.name!r} has no room: expected a region that is neither a door nor inside another"
        )
    out_of_reach = list(unreachable(world))
    say = console()
    for name in out_of_reach:
        say.print(f"warning: {file}: region {name!r}: out of reach for a robot of 0.2 m radius", markup=False)
    say.print(f"{file}: valid", markup=False)
    if json:
        print_json({**_facts(world), "valid": True, "unreachable": out_of_reach})
    return DONE


def _facts(world: World) -> dict[str, Any]:
    x0, y0, x1, y1 = world.bounds
    counts = Counter(region.type for region in world.regions)
    return {
        "name": world.name,
        "regions": len(world.regions),
        "doors": len(world.doors),
        "size": [round(x1 - x0, 2), round(y1 - y0, 2)],
        "types": dict(counts.most_common()),
    }
