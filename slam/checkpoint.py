"""A filter on disk: settings, generator, particles and maps, so that it goes on as if it had never stopped.

One compressed file of arrays without pickle, beside a text (JSON) that says what they are. A digest of all of it tells
a damaged file from a sound one before anything is made of it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.config import SlamConfig
from slam.geojson import MapError
from slam.measurement import MeasurementNoise
from slam.motion import MotionNoise
from slam.priors import TypePrior
from slam.storage import load_arrays, save_arrays, with_dtypes

KIND, VERSION = "regionslam filter", 2

SETTINGS = {cls.__name__: cls for cls in (SlamConfig, MotionNoise, MeasurementNoise, TypePrior)}
"""Classes that settings are made of."""

GENERATORS = ("PCG64", "PCG64DXSM", "MT19937", "Philox", "SFC64")

Arrays = Mapping[str, NDArray[Any]]


def save_checkpoint(path: str | os.PathLike[str], about: Mapping[str, Any], arrays: Arrays) -> None:
    """Write a filter: what JSON can hold of it, and its arrays by name."""
    text = json.dumps({"kind": KIND, "version": VERSION, **about}, allow_nan=False)
    save_arrays(path, {**arrays, "about": np.array(text), "digest": np.array(_digest(text, arrays))})


def load_checkpoint(path: str | os.PathLike[str], dtypes: Mapping[str, Any]) -> tuple[dict[str, Any], Arrays]:
    """Read what `save_checkpoint` wrote; `dtypes` names the arrays that must be there.

    Raises
    ------
    MapError
        If the file is damaged, no filter's, or of a version that is not known.
    """
    name = os.fspath(path)
    arrays = load_arrays(path)
    about, digest = arrays.pop("about", None), arrays.pop("digest", None)
    try:
        text = str(about)
        content = json.loads(text)
        kind, version = content["kind"], content["version"]
    except (TypeError, KeyError, ValueError):
        kind, version = None, None
    if kind != KIND:
        raise MapError(f"{name}: not a filter that was saved with RegionSLAM.save")
    if version != VERSION:
        raise MapError(f"{name}: version is {version!r}, expected {VERSION}")
    if str(digest) != _digest(text, arrays):
        raise MapError(f"{name}: the file is damaged (its digest does not match its content)")
    return content, with_dtypes(path, arrays, dtypes)


def _digest(text: str, arrays: Arrays) -> str:
    digest = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.shape} {array.dtype.itemsize}".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def settings_to_plain(value: Any) -> Any:
    """Return settings as JSON can hold them."""
    if is_dataclass(value) and not isinstance(value, type):
        named = {field.name: settings_to_plain(getattr(value, field.name)) for field in fields(value)}
        return {"class": type(value).__name__, "fields": named}
    if isinstance(value, Mapping):
        return {"items": [[settings_to_plain(key), settings_to_plain(entry)] for key, entry in value.items()]}
    if isinstance(value, tuple):
        return [settings_to_plain(entry) for entry in value]
    return value.item() if isinstance(value, np.generic) else value


def settings_from_plain(value: Any) -> Any:
    """Return the settings that `settings_to_plain` was given."""
    if isinstance(value, list):
        return tuple(settings_from_plain(entry) for entry in value)
    if isinstance(value, Mapping) and "class" in value:
        return SETTINGS[value["class"]](**{name: settings_from_plain(v) for name, v in value["fields"].items()})
    if isinstance(value, Mapping):
        return {settings_from_plain(key): settings_from_plain(entry) for key, entry in value["items"]}
    return value


def generator_to_plain(generator: np.random.Generator) -> dict[str, Any]:
    """Return the state of a generator of NumPy as JSON can hold it."""
    state = generator.bit_generator.state
    if state["bit_generator"] not in GENERATORS:
        raise ValueError(f"seed is a generator of {state['bit_generator']}, expected one of {', '.join(GENERATORS)}")
    return json.loads(json.dumps(state, default=lambda array: array.tolist()))


def generator_from_plain(state: Mapping[str, Any]) -> np.random.Generator:
    """Return a generator in a state of `generator_to_plain`."""
    if state["bit_generator"] not in GENERATORS:
        raise MapError(f"generator is {state['bit_generator']!r}, expected one of {', '.join(GENERATORS)}")
    bits = getattr(np.random, state["bit_generator"])()
    bits.state = _with_arrays(state, bits.state)
    return np.random.Generator(bits)


def _with_arrays(plain: Mapping[str, Any], like: Mapping[str, Any]) -> dict[str, Any]:
    """Return a state with arrays where one like it has them."""
    state: dict[str, Any] = {}
    for name, value in plain.items():
        model = like[name]
        if isinstance(model, Mapping):
            state[name] = _with_arrays(value, model)
        else:
            state[name] = np.array(value, model.dtype) if isinstance(model, np.ndarray) else value
    return state
