"""Commands about generated worlds: make one, draw a gallery of all kinds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from agents.console import DONE, InputError, console, print_json
from agents.options import Json

if TYPE_CHECKING:
    from regionslam_env.worlds.world import World

Size = Annotated[int, typer.Option(help="Regions in all, about: 5 to 10,000.")]
Clutter = Annotated[float, typer.Option(help="Share of the furniture that rooms have space for, 0 to 1.")]
Ambiguity = Annotated[float, typer.Option(help="Share of the rooms that are copies of a standard one, 0 to 1.")]

LADDERS = {"size": (20, 60, 200), "clutter": (0, 0.5, 1), "ambiguity": (0, 0.5, 1)}
"""Options in the gallery of one kind, from left to right."""


def generate(
    kind: Annotated[str, typer.Argument(help="office, apartment, school, hospital or campus.")],
    seed: Annotated[int, typer.Option(min=0, help="Number of the world in its split.")] = 0,
    size: Size = 40,
    clutter: Clutter = 0.5,
    ambiguity: Ambiguity = 0.3,
    split: Annotated[str, typer.Option(help="train, val or test: disjoint worlds.")] = "train",
    out: Annotated[Path | None, typer.Option(help="The world in our format (.geojson).")] = None,
    json: Json = False,
) -> int:
    """Generate a world.

    The same kind, seed and options always give the same one.
    """
    from regionslam_env.worlds.format import save_world
    from regionslam_env.worlds.generate.generator import generate as generate_world
    from regionslam_env.worlds.source import world_seed

    target = out or Path(f"{kind}-{seed}.geojson")
    if target.suffix.lower() not in (".geojson", ".json"):
        raise InputError(f"{target}: ending {target.suffix!r}, expected .geojson")
    options = {"size": size, "clutter": clutter, "ambiguity": ambiguity}
    world = generate_world(kind, world_seed(split, seed), options)
    save_world(world, target)
    x0, y0, x1, y1 = world.bounds
    console().print(
        f"{target}: {len(world.regions)} regions, {len(world.doors)} doors, {x1 - x0:.0f} x {y1 - y0:.0f} m"
    )
    if json:
        facts = {"regions": len(world.regions), "doors": len(world.doors), "size": [x1 - x0, y1 - y0]}
        print_json({"kind": kind, "seed": seed, "split": split, **facts, "file": str(target)})
    return DONE


def gallery(
    kind: Annotated[str | None, typer.Option(help="Only this kind, at several sizes and difficulties.")] = None,
    out: Annotated[Path, typer.Option(help="Picture to draw (.png).")] = Path("worlds.png"),
    seed: Annotated[int, typer.Option(min=0, help="Number of the first world of each kind.")] = 0,
    size: Size = 80,
    json: Json = False,
) -> int:
    """Draw worlds of every kind side by side.

    Or of one kind, with easier and harder ones below.
    """
    from regionslam_env.rendering.gallery import draw_gallery
    from regionslam_env.worlds.generate.generator import KINDS
    from slam.storage import replacing

    if out.suffix.lower() not in (".png", ".jpg", ".webp"):
        raise InputError(f"{out}: ending {out.suffix!r}, expected a picture, e.g. {out.with_suffix('.png').name}")
    kinds = list(KINDS) if kind is None else [kind]
    rows = [[_world(name, seed + k, size) for k in range(3)] for name in kinds]
    if kind is not None:
        rows += [[_world(kind, seed, size, option, value) for value in LADDERS[option]] for option in LADDERS]
    picture = draw_gallery(rows)
    with replacing(out) as temporary:
        (picture if out.suffix.lower() == ".png" else picture.convert("RGB")).save(temporary)
    console().print(f"Drawn: {out}")
    if json:
        print_json({"file": str(out), "kinds": kinds, "seeds": [seed, seed + 1, seed + 2]})
    return DONE


def _world(kind: str, seed: int, size: int, option: str = "size", value: float | None = None) -> World:
    """Return a generated world, with one option of a value that is told in its name."""
    from regionslam_env.worlds.generate.generator import generate as generate_world

    if value is None:
        return generate_world(kind, seed, {"size": size})
    world = generate_world(kind, seed, {"size": size} | {option: value})
    return replace(world, name=f"{world.name}, {option} {value}")
