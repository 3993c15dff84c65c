"""Maps and arrays on disk: complete files or none, and no pickle."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.geojson import MapError
from slam.region_map import RegionMap


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Hand out a temporary file beside `path` that takes its name once it is written; after an error nothing is left.

    A reader sees the old file or the new one, never a part.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
    except OSError as error:  # of a name that nobody gave
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)  # temporary files are private, results are not
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def save_map(region_map: RegionMap, path: str | os.PathLike[str]) -> None:
    """Write a map with all its hypotheses as GeoJSON in local metres."""
    text = json.dumps(region_map.to_geojson(), indent=1, allow_nan=False, ensure_ascii=False)
    with replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def load_map(path: str | os.PathLike[str]) -> RegionMap:
    """Read a map that `save_map` wrote.

    Raises
    ------
    MapError
        If the file is no such map; the message names file, feature and field.
    """
    try:
        return RegionMap.from_geojson(json.loads(Path(path).read_text(encoding="utf-8")))
    except (ValueError, RecursionError) as error:
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else error
        raise MapError(f"{os.fspath(path)}: {reason}") from None


def save_arrays(path: str | os.PathLike[str], arrays: Mapping[str, ArrayLike]) -> None:
    """Write named arrays (records included) to one compressed file."""
    plain = {name: _plain(np.asarray(array)) for name, array in arrays.items()}
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **plain)


def load_arrays(path: str | os.PathLike[str], dtypes: Mapping[str, Any] | None = None) -> dict[str, NDArray[Any]]:
    """Read the arrays that `save_arrays` wrote.

    Parameters
    ----------
    path
        The file.
    dtypes
        Expected dtype of arrays by name, e.g. ``{"features": REGION}``; records come back as that dtype.

    Raises
    ------
    MapError
        If the file is no such file, or an array is missing or of another dtype.
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {key: stored[key] for key in stored.files}
    except FileNotFoundError:
        raise
    except Exception as error:  # numpy raises whatever its zip reader does: BadZipFile, ValueError, EOFError, ...
        raise MapError(f"{os.fspath(path)}: not a file of arrays ({error})") from None
    return with_dtypes(path, arrays, dtypes or {})


def with_dtypes(
    path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]], dtypes: Mapping[str, Any]
) -> dict[str, NDArray[Any]]:
    """Return arrays of a file as the dtypes that are expected; MapError if one is missing or of another dtype."""
    seen = dict(arrays)
    for key, dtype in dtypes.items():
        if key not in arrays:
            raise MapError(f"{os.fspath(path)}: {key} is missing, expected an array of dtype {dtype}")
        if arrays[key].dtype != _plain(np.zeros(0, dtype)).dtype:
            raise MapError(f"{os.fspath(path)}: {key} has dtype {arrays[key].dtype}, expected {dtype}")
        seen[key] = arrays[key].view(dtype)
    return seen


def _plain(array: NDArray[Any]) -> NDArray[Any]:
    """Return records as plain structures: an npz file doesn't know `np.record`."""
    if array.dtype.names is None:
        if array.dtype.hasobject:
            raise MapError(f"arrays of objects are not stored; got dtype {array.dtype}")
        return array
    return array.view(np.dtype((np.void, array.dtype)))
