"""Importing buildings: one or a folder of them, with a report of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from agents.console import BAD_INPUT, DONE, FAILED, InputError, console, print_json, track

if TYPE_CHECKING:
    from regionslam_env.worlds.importers.realise import Imported, ImportOptions
    from regionslam_env.worlds.importers.report import ImportReport

ENDINGS = (".geojson", ".json")


@dataclass(frozen=True)
class Attempt:
    """One level of one file: its import, or why it was refused."""

    file: Path
    imported: Imported | None
    refusal: str = ""

    @property
    def report(self) -> ImportReport | None:
        """The report of a success."""
        return None if self.imported is None else self.imported.report


def import_one(file: Path, out: Path | None, options: ImportOptions, json: bool) -> int:
    """Import one building, write it and print the report."""
    from regionslam_env.worlds.format import is_native, load_world, save_world
    from regionslam_env.worlds.importers.formats import import_plan
    from regionslam_env.worlds.loading import check_there

    check_there(file, str(file))
    target = out or Path(file.name.split(".")[0] + ".geojson")
    if target.suffix.lower() not in ENDINGS:
        raise InputError(f"{target}: ending {target.suffix!r}, expected .geojson")
    if target.resolve() == file.resolve():
        raise InputError(f"{target}: the file to import itself, expected another place for the world (--out)")
    say = console()
    if is_native(file):
        world = load_world(file, options.level)
        save_world(world, target)
        say.print(f"{file} -> {target}: of our own format already")
        if json:
            print_json(
                {
                    "file": str(file),
                    "out": str(target),
                    "format": "ours",
                    "regions": len(world.regions),
                    "doors": len(world.doors),
                }
            )
        return DONE
    world, report = import_plan(file, options)
    save_world(world, target)
    say.print("\n".join(report.lines()), markup=False)
    say.print(f"written: {target}", markup=False)
    if json:
        print_json({**report.as_dict(), "regions": len(world.regions), "out": str(target)})
    return DONE


def import_folder(folder: Path, out: Path | None, options: ImportOptions, json: bool) -> int:
    """Import every building of a folder into another one; 1 where some were refused, 2 where all were."""
    from regionslam_env.worlds.format import save_world

    if out is None or out.suffix or (out.exists() and not out.is_dir()):
        raise InputError(f"--out is {str(out)!r}, expected a folder: {folder} holds many buildings")
    attempts = [attempt for file in _plans(folder) for attempt in _attempts(file, options, all_levels=False)]
    for attempt in attempts:
        if attempt.imported is not None:
            target = out / attempt.file.relative_to(folder).with_name(attempt.file.name.split(".")[0] + ".geojson")
            target.parent.mkdir(parents=True, exist_ok=True)
            save_world(attempt.imported.world, target)
    return _tell(attempts, json)


def survey_folder(folder: Path, json: bool) -> int:
    """Import every level of every building of a folder and print a table; nothing is written."""
    from regionslam_env.worlds.importers.realise import ImportOptions

    if not folder.is_dir():
        raise InputError(f"{folder}: no folder")
    files = list(_plans(folder))
    shown = track(files, len(files), "importing")
    attempts = [attempt for file in shown for attempt in _attempts(file, ImportOptions(), all_levels=True)]
    return _tell(attempts, json)


def _plans(folder: Path) -> Iterator[Path]:
    from regionslam_env.worlds.importers.formats import plans_in

    return plans_in(folder)


def _attempts(file: Path, options: ImportOptions, all_levels: bool) -> Iterator[Attempt]:
    """Yield the import of a file's best level, then those of its others; nothing for a world of our own format."""
    from regionslam_env.errors import WorldError
    from regionslam_env.worlds.format import is_native
    from regionslam_env.worlds.importers.formats import import_plan

    levels: list[str | None] = [options.level]
    while levels:
        level = levels.pop(0)
        try:
            if is_native(file):
                return
            imported = import_plan(file, replace(options, level=level))
        except WorldError as error:
            yield Attempt(file, None, " ".join(str(error).split()))
            continue
        yield Attempt(file, imported)
        if all_levels and level is None:
            levels += [other for other in imported.report.levels if other != imported.report.level]


def _tell(attempts: list[Attempt], json: bool) -> int:
    """Print a table of attempts and the totals."""
    from regionslam_env.worlds.importers.report import GOOD, amount

    say = console()
    reports = [report for attempt in attempts if (report := attempt.report) is not None]
    for row in _rows(reports):
        say.print(row, markup=False)
    for attempt in attempts:
        if attempt.report is None:
            say.print(f"refused: {attempt.refusal}", markup=False)
    rooms = [room for report in reports for room in report.rooms]
    shares = {
        "good_share": sum(room.iou > GOOD for room in rooms) / max(len(rooms), 1),
        "good_share_aligned": sum(room.aligned_iou > GOOD for room in rooms) / max(len(rooms), 1),
    }
    say.print(
        "{} on {}: {:.1%} with IoU > {} as drawn, {:.1%} after edges were moved onto common walls".format(
            amount(len(rooms), "room"),
            amount(len(reports), "level"),
            shares["good_share"],
            GOOD,
            shares["good_share_aligned"],
        )
    )
    if json:
        refused = [{"file": str(a.file), "why": a.refusal} for a in attempts if a.imported is None]
        print_json({"imported": [r.as_dict() for r in reports], "refused": refused, "rooms": len(rooms), **shares})
    if not reports:
        return BAD_INPUT
    return DONE if len(reports) == len(attempts) else FAILED


def _rows(reports: list[ImportReport]) -> Iterator[str]:
    """Yield the lines of a table of imports; names come last, where nothing cuts them."""
    yield "rooms  doors  assumed  open  IoU > 0.95  flagged  parts  file, level, format"
    for r in reports:
        yield (
            f"{len(r.rooms):5}  {r.doors:5}  {r.assumed:7}  {r.passages:4}  {r.good_share:10.0%}  {len(r.poor):7}  "
            f"{r.components:5}  {Path(r.file).name}, {r.level}, {r.format}"
        )
