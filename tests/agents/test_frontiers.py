from __future__ import annotations

import numpy as np
import pytest

from agents.frontiers import cluster
from agents.terrain import UNSEEN


def naive_clusters(pending: np.ndarray) -> list[set[tuple[int, int]]]:
    """Flood fill with sets."""
    left = {(int(r), int(c)) for r, c in np.argwhere(pending)}
    groups = []
    while left:
        group, edge = set(), {min(left)}
        while edge:
            group |= edge
            edge = {(r + i, c + j) for r, c in edge for i in (-1, 0, 1) for j in (-1, 0, 1)} & left - group
        groups.append(group)
        left -= group
    return groups


def test_clusters_agree_with_the_obvious_computation() -> None:
    rng = np.random.default_rng(3)
    scores = rng.choice(np.array([UNSEEN, 0, 5], np.int8), (30, 40), p=[0.15, 0.8, 0.05])
    scores[[0, -1]] = scores[:, [0, -1]] = 0
    clearances = rng.uniform(0, 3, scores.shape).astype(np.float32)
    reach = np.where(rng.random(scores.shape) < 0.1, np.inf, 1).astype(np.float32)
    unseen = np.pad(scores == UNSEEN, 1)
    beside = unseen[:-2, 1:-1] | unseen[2:, 1:-1] | unseen[1:-1, :-2] | unseen[1:-1, 2:]
    pending = (scores == 0) & beside & (clearances >= 0.3) & np.isfinite(reach)
    pending[[0, -1]] = pending[:, [0, -1]] = False
    expected = naive_clusters(pending)
    cells, sizes = cluster(scores, clearances, reach, 0.3)
    assert sizes.tolist() == [len(g) for g in expected]
    for cell, group in zip(cells, expected, strict=True):
        assert tuple(cell) in group


def test_the_cell_is_in_the_middle() -> None:
    scores = np.zeros((9, 30), np.int8)
    scores[:4] = UNSEEN
    reach, clearances = np.ones(scores.shape, np.float32), np.ones(scores.shape, np.float32)
    cells, sizes = cluster(scores, clearances, reach, 0.3)
    assert sizes.tolist() == [28]
    assert cells[0] == pytest.approx((4, 14.5), abs=0.5)
