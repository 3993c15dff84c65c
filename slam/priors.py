"""Prior probabilities by semantic type: of regions, p(m), and of links and containments by pairs of types.

A setting is one number for all, or a mapping from names; `ANY` stands for every name that the mapping doesn't hold.
Kernels get arrays by type number. The filter numbers the named types first, so these arrays never grow: their last
entry is the one of all other types.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from slam.rows import Floats

ANY = "*"
"""In a mapping, every type that it doesn't name."""


@dataclass(frozen=True)
class TypePrior:
    """A-priori probability p(m) of a region by its type and dimensions (Oberländer et al. 2008, eq. 7).

    Parameters
    ----------
    probability
        p(m) of a region whose area lies between `min_area` and `max_area`, m².
    min_area, max_area
        A region with unseen edges may turn out larger, so only a whole one can be too small. None: no limit.
    outside
        p(m) of a region of another size.
    """

    probability: float = 0.5
    min_area: float = 0.0
    max_area: float | None = None
    outside: float = 0.1


class Priors(NamedTuple):
    """Log-odds as kernels take them, by type number; the last entry is for types that no setting names."""

    types: Floats  # (T + 1, 4): `by_type`
    links: Floats  # (T + 1, T + 1): `by_pair`
    children: Floats  # (T + 1, T + 1)
    link_unseen: float
    literal: bool  # subtract the prior at every scan


PriorByType = float | Mapping[str, float | TypePrior]
PriorByPair = float | Mapping[tuple[str, str], float]


def checked_by_type(name: str, value: Any) -> PriorByType:
    """Return a setting p(m) with every number checked; a plain mapping of fields stands for a `TypePrior`."""
    if not isinstance(value, Mapping):
        return _probability(name, value)
    found: dict[str, float | TypePrior] = {}
    for type_, prior in value.items():
        where = f"{name}[{type_!r}]"
        if not isinstance(type_, str):
            raise ValueError(f"{name} has the key {type_!r}, expected the name of a type")
        if isinstance(prior, Mapping):
            prior = _type_prior(where, prior)
        if isinstance(prior, TypePrior):
            _check_type_prior(where, prior)
            found[type_] = prior
        else:
            found[type_] = _probability(where, prior)
    return found


def checked_by_pair(name: str, value: Any) -> PriorByPair:
    """Return a setting by pairs of types with every number checked.

    Keys are pairs of names; ``{first: {second: probability}}``, as JSON can hold it, does as well.
    """
    if not isinstance(value, Mapping):
        return _probability(name, value)
    found: dict[tuple[str, str], float] = {}
    for key, prior in value.items():
        pairs = [((key, second), p) for second, p in prior.items()] if isinstance(prior, Mapping) else [(key, prior)]
        for pair, p in pairs:
            if not (isinstance(pair, tuple | list) and len(pair) == 2 and all(isinstance(t, str) for t in pair)):
                raise ValueError(f"{name} has the key {pair!r}, expected a pair of names of types")
            found[tuple(pair)] = _probability(f"{name}[{tuple(pair)!r}]", p)
    return found


def names(settings: Iterable[PriorByType | PriorByPair]) -> tuple[str, ...]:
    """Return the types that settings name, sorted."""
    found: set[str] = set()
    for setting in settings:
        if isinstance(setting, Mapping):
            for key in setting:
                found.update((key,) if isinstance(key, str) else key)
    return tuple(sorted(found - {ANY}))


def by_type(setting: PriorByType, types: Sequence[str], default: float) -> Floats:
    """Return log-odds inside, least and largest area (m²), and log-odds outside, shape (types + 1, 4)."""
    rows = []
    for type_ in (*types, ANY):
        prior: float | TypePrior = default
        if not isinstance(setting, Mapping):
            prior = setting
        elif type_ in setting or ANY in setting:
            prior = setting.get(type_, setting.get(ANY, default))
        if not isinstance(prior, TypePrior):
            prior = TypePrior(prior, outside=prior)
        largest = math.inf if prior.max_area is None else prior.max_area
        rows.append((log_odds(prior.probability), prior.min_area, largest, log_odds(prior.outside)))
    return np.array(rows)


def by_pair(setting: PriorByPair, types: Sequence[str], default: float, mutual: bool) -> Floats:
    """Return log-odds by first and second type, shape (types + 1, types + 1).

    The most exact key counts: (a, b), then (a, ANY), (ANY, b), (ANY, ANY). With `mutual` each may be given either way
    round.
    """
    every = (*types, ANY)
    out = np.empty((len(every), len(every)))
    for i, a in enumerate(every):
        for j, b in enumerate(every):
            out[i, j] = log_odds(_of_pair(setting, a, b, default, mutual))
    return out


def log_odds(probability: float) -> float:
    """Return log p / (1 - p)."""
    return math.log(probability / (1 - probability))


def _of_pair(setting: PriorByPair, a: str, b: str, default: float, mutual: bool) -> float:
    if not isinstance(setting, Mapping):
        return setting
    for first, second in ((a, b), (a, ANY), (ANY, b), (ANY, ANY)):
        for pair in ((first, second), (second, first)) if mutual else ((first, second),):
            if pair in setting:
                return setting[pair]
    return default


def _probability(name: str, value: Any) -> float:
    is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not is_number or not 0 < value < 1:
        raise ValueError(f"{name} is {value!r}, expected a probability between 0 and 1, both excluded")
    return float(value)


def _type_prior(name: str, value: Mapping[str, Any]) -> TypePrior:
    known = [f.name for f in fields(TypePrior)]
    for key in value:
        if key not in known:
            raise ValueError(f"{name} has no field {key!r}, expected {', '.join(known)}")
    return TypePrior(**value)


def _check_type_prior(name: str, prior: TypePrior) -> None:
    _probability(f"{name}.probability", prior.probability)
    _probability(f"{name}.outside", prior.outside)
    if not (math.isfinite(prior.min_area) and prior.min_area >= 0):
        raise ValueError(f"{name}.min_area is {prior.min_area!r}, expected an area of at least 0 m²")
    if prior.max_area is not None and not prior.max_area > prior.min_area:
        raise ValueError(f"{name}.max_area is {prior.max_area!r}, expected more than min_area, {prior.min_area!r} m²")
