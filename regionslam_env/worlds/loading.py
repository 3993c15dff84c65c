"""One way to any world: a built-in by name, a file of our format, or a file that an importer understands."""

from __future__ import annotations

from functools import lru_cache
from importlib import resources
from pathlib import Path

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.format import load_world
from regionslam_env.worlds.generate.generator import KINDS
from regionslam_env.worlds.importers.luperto import load_luperto
from regionslam_env.worlds.world import World

SUFFIXES = (".geojson", ".json", ".xml")
"""Endings of files that can be loaded."""


def builtin_names() -> tuple[str, ...]:
    """Return the names of the worlds that ship with the package."""
    folder = resources.files("regionslam_env.worlds") / "data"
    return tuple(sorted(Path(f.name).stem for f in folder.iterdir() if f.name.endswith(".geojson")))


def load(world: str | Path | World, scale: float | None = None) -> World:
    """Return a world by built-in name or path.

    Parameters
    ----------
    world
        ``"institute"`` or another built-in name; the path of a GeoJSON file of our format or of a Luperto XML plan;
        a `World` is handed back as it is.
    scale
        Metres per unit of an imported plan, where its own scale is not to be trusted.

    Raises
    ------
    WorldError
        For an unknown name (with the nearest ones) or a file that cannot be used.
    """
    if isinstance(world, World):
        return world
    name = str(world)
    if name in builtin_names():
        return _builtin(name)
    path = Path(world)
    suffix = path.suffix.lower()
    try:
        found = path.is_file()
    except (OSError, ValueError):  # a name too long for any file
        found = False
    if not found:
        if suffix in SUFFIXES or len(path.parts) > 1:
            raise WorldError(f"{path}: no such file, expected a world file ({', '.join(SUFFIXES)}) or a built-in name")
        raise WorldError(unknown("world", name, (*builtin_names(), *KINDS)))
    if suffix not in SUFFIXES:
        raise WorldError(f"{path}: ending {suffix!r}, expected one of {', '.join(SUFFIXES)}")
    status = path.stat()
    return _file(path, scale, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=16)
def _file(path: Path, scale: float | None, changed: int, size: int) -> World:
    """Read a file once as long as it does not change: worlds are immutable, and importing takes a while."""
    if path.suffix.lower() == ".xml":
        return load_luperto(path, scale=scale)
    return load_world(path)


@lru_cache(maxsize=16)
def _builtin(name: str) -> World:
    """Read a built-in once: worlds are immutable."""
    with resources.as_file(resources.files("regionslam_env.worlds") / "data" / f"{name}.geojson") as path:
        return load_world(path)
