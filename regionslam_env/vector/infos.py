"""The infos of many environments as one dictionary, in the way of `gymnasium.vector.VectorEnv`."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv

Info = dict[str, Any]

TERMS = "reward_terms"


def gather_infos(vector: VectorEnv[Any, Any, Any], infos: list[Info], last: dict[int, Info]) -> Info:
    """Return one info for all environments, equal to that of `SyncVectorEnv`.

    Parameters
    ----------
    vector
        Knows the rules.
    infos
        Of all environments.
    last
        By environment: "final_obs" and "final_info" of an episode that has ended in this step.
    """
    gathered: Info = {}
    with_terms = [i for i, info in enumerate(infos) if TERMS in info]
    for i, info in enumerate(infos):
        if i in last:
            gathered = vector._add_info(gathered, last[i], i)
        if len(info) > (TERMS in info):
            gathered = vector._add_info(gathered, {key: info[key] for key in info if key != TERMS}, i)
    if with_terms:
        gathered[TERMS], gathered[f"_{TERMS}"] = _columns([infos[i][TERMS] for i in with_terms], with_terms, len(infos))
    return gathered


def _columns(terms: list[dict[str, float]], which: list[int], n: int) -> tuple[Info, np.ndarray[Any, Any]]:
    """Return the terms by name, each an array (n,) with its mask, and the mask of all: what every step brings."""
    mask = np.zeros(n, np.bool_)
    mask[which] = True
    columns: Info = {}
    for name in terms[0]:
        values = np.zeros(n)
        values[which] = [each[name] for each in terms]
        columns[name], columns[f"_{name}"] = values, mask.copy()
    return columns, mask
