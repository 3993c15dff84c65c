"""The infos of many environments as one dictionary, in the way of `gymnasium.vector.VectorEnv`."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

Info = dict[str, Any]
Terms = tuple[NDArray[np.bool_], dict[str, NDArray[np.float64]]]
"""Whose terms of the reward there are, shape (N,), and the terms by name, each of shape (N,)."""

TERMS = "reward_terms"


def gather_infos(
    vector: VectorEnv[Any, Any, Any], infos: list[Info], last: dict[int, Info], together: Terms | None
) -> Info:
    """Return one info for all environments, equal to that of `SyncVectorEnv`.

    Parameters
    ----------
    vector
        Knows the rules.
    infos
        Of all environments.
    last
        By environment: "final_obs" and "final_info" of an episode that has ended in this step.
    together
        Terms of the rewards of those that were judged together; they are in none of the infos.
    """
    gathered: Info = {}
    spoken = [(i, info) for i, info in enumerate(infos) if info or i in last]
    alone = [i for i, info in spoken if TERMS in info]
    for i, info in spoken:
        if i in last:
            gathered = vector._add_info(gathered, last[i], i)
        if len(info) > (TERMS in info):
            gathered = vector._add_info(gathered, {key: info[key] for key in info if key != TERMS}, i)
    whose, terms = together or (np.zeros(len(infos), np.bool_), {})
    whose[alone] = True
    for name in infos[alone[0]][TERMS] if alone else ():
        values = terms.setdefault(name, np.zeros(len(infos)))
        values[alone] = [infos[i][TERMS][name] for i in alone]
    if whose.any():
        masks = {f"_{name}": whose.copy() for name in terms}
        gathered[TERMS], gathered[f"_{TERMS}"] = terms | masks, whose
    return gathered
