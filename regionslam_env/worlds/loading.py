"""One way to any world: a built-in by name, a file of our format, or a file that an importer understands."""

from __future__ import annotations

from functools import lru_cache
from importlib import resources
from pathlib import Path

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.format import is_native, load_world
from regionslam_env.worlds.generate.generator import KINDS
from regionslam_env.worlds.importers.formats import ACCEPTED, ENDINGS, import_plan
from regionslam_env.worlds.importers.levels import check_level
from regionslam_env.worlds.importers.realise import ImportOptions
from regionslam_env.worlds.importers.source import Source
from regionslam_env.worlds.world import World


def builtin_names() -> tuple[str, ...]:
    """Return the names of the worlds that ship with the package."""
    folder = resources.files("regionslam_env.worlds") / "data"
    return tuple(sorted(Path(f.name).stem for f in folder.iterdir() if f.name.endswith(".geojson")))


def load(world: str | Path | World, scale: float | None = None, level: str | None = None) -> World:
    """Return a world by built-in name or path.

    Parameters
    ----------
    world
        ``"institute"`` or another built-in name; the path of a GeoJSON file of our format or of a plan in any format
        of `importers.formats`, or of a folder that holds one building; a `World` is handed back as it is.
    scale
        Metres per unit of an imported plan, where its own scale is not to be trusted.
    level
        Which level of several; default: what the file names, or the level with the most rooms.

    Raises
    ------
    WorldError
        For an unknown name or level (with those that there are) or a file that cannot be used.
    """
    if isinstance(world, World):
        check_level((world.level,), level, f"world {world.name!r}")
        return world
    name = str(world)
    if name in builtin_names():
        return load(_builtin(name), level=level)
    path = Path(world)
    check_there(path, name)
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    status = [file.stat() for file in files]
    return _file(path, scale, level, tuple((s.st_mtime_ns, s.st_size) for s in status))


def check_there(path: Path, name: str) -> None:
    """Refuse a path at which there is no file or folder; what looks like a name gets the nearest built-in ones."""
    try:
        found = path.is_file() or (path.is_dir() and name not in ("", "."))
    except (OSError, ValueError):  # a name too long for any file
        found = False
    if not found:
        if Source(path).ending in ENDINGS or len(path.parts) > 1:
            raise WorldError(f"{path}: no such file, expected a world file ({ACCEPTED}) or a built-in name")
        raise WorldError(unknown("world", name, (*builtin_names(), *KINDS)))


@lru_cache(maxsize=16)
def _file(path: Path, scale: float | None, level: str | None, state: tuple[tuple[int, int], ...]) -> World:
    """Read a file once as long as it does not change: worlds are immutable, and importing takes a while."""
    if is_native(path):
        return load_world(path, level)
    return import_plan(path, ImportOptions(level=level, scale=scale)).world


@lru_cache(maxsize=16)
def _builtin(name: str) -> World:
    """Read a built-in once: worlds are immutable."""
    with resources.as_file(resources.files("regionslam_env.worlds") / "data" / f"{name}.geojson") as path:
        return load_world(path)
