"""Every format that can be imported, told apart by what is in a file rather than by its ending.

A reader is a module with ``refusal(source)``, why a file is not of its format (None where it is), and
``read(source, options)``, the drawing of one level. A folder is a source as well: IMDF and Azure Maps spread one
building over several files.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from regionslam_env.errors import WorldError
from regionslam_env.worlds.importers.levels import check_level
from regionslam_env.worlds.importers.realise import Imported, ImportOptions, realise
from regionslam_env.worlds.importers.source import Source
from regionslam_env.worlds.importers.vocabulary import vocabulary

JSON, YAML, XML, IFC = (".geojson", ".json"), (".yaml", ".yml"), (".xml", ".osm"), (".ifc",)


@dataclass(frozen=True)
class Format:
    """A format: name of its reader and its table of types, what to call it, endings of its files.

    `scalable` where its unit is not known to be the metre, so that a scale can be given.
    """

    name: str
    title: str
    endings: tuple[str, ...]
    scalable: bool = False

    @property
    def reader(self) -> ModuleType:
        """The module that reads it; loaded when needed."""
        return importlib.import_module(f"regionslam_env.worlds.importers.{self.name}")


FORMATS = (
    Format("imdf", "IMDF or Azure Maps GeoJSON", JSON),
    Format("osm", "OpenStreetMap indoor", (*JSON, *XML)),
    Format("procthor", "ProcTHOR house", JSON),
    Format("houseexpo", "HouseExpo", JSON, scalable=True),
    Format("luperto", "Luperto XML", XML, scalable=True),
    Format("rmf", "RMF building.yaml", YAML, scalable=True),
    Format("pyrobosim", "PyRoboSim world", YAML),
    Format("rosmap", "ROS map", YAML, scalable=True),
    Format("ifc", "IFC", IFC),
)
COMPANIONS = (".rooms.yaml",)
"""Endings of files that belong to others: annotations of a ROS map."""

ENDINGS = (*JSON, *YAML, *XML, *IFC)

ACCEPTED = f"{', '.join(ENDINGS)}, packed ones such as .ifc.gz, or a folder that holds one building"
"""What can be imported, for an error."""


def import_plan(path: Path, options: ImportOptions) -> Imported:
    """Return the world of a file or of a folder that holds one building, and the report.

    Raises
    ------
    WorldError
        Naming the file and what is wrong with it, or every format that was tried and why it is none of them.
    """
    found, source = detect(path)
    if options.scale is not None:
        if not found.scalable:
            raise WorldError(f"{path}: scale is {options.scale!r}, expected none: {found.title} has a unit of its own")
        if not (math.isfinite(options.scale) and options.scale > 0):
            raise WorldError(f"{path}: scale is {options.scale!r}, expected metres per unit above 0")
    try:
        drawing = found.reader.read(source, options)
        check_level(drawing.levels, options.level, path)
        return realise(drawing, vocabulary(found.name, options.types), options, str(path), found.title)
    except WorldError as error:
        text = str(error)
        raise WorldError(text if str(path) in text else f"{path}: {text}") from None


def detect(path: Path) -> tuple[Format, Source]:
    """Return the format of a file or folder, and its source."""
    source = Source(path)
    if path.is_dir():
        imdf = FORMATS[0]
        reason = imdf.reader.refusal(source)
        if reason is not None:
            raise WorldError(f"{path}: a folder that is no building ({imdf.title}: {reason}); expected a file")
        return imdf, source
    tried = ["our own (no feature with a known 'kind')"] if source.ending in JSON else []
    for candidate in FORMATS:
        if source.ending in candidate.endings:
            reason = candidate.reader.refusal(source)
            if reason is None:
                return candidate, source
            tried.append(f"{candidate.title} ({reason})")
    if source.ending not in ENDINGS:
        raise WorldError(f"{path}: ending {source.ending!r}, expected one of {ACCEPTED}")
    raise WorldError(f"{path}: of no known format; tried {'; '.join(tried)}")


def is_one_building(folder: Path) -> bool:
    """Return whether the files of a folder are those of one building."""
    return bool(FORMATS[0].reader.is_dataset(folder))


def plans_in(folder: Path) -> Iterator[Path]:
    """Yield what may be buildings in a folder and below: files by their ending, and folders that are one building."""
    if is_one_building(folder):
        yield folder
        return
    for entry in sorted(folder.iterdir()):
        if entry.is_dir():
            yield from plans_in(entry)
        elif Source(entry).ending in ENDINGS and not entry.name.endswith(COMPANIONS):
            yield entry
