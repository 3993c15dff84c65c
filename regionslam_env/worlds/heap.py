"""A binary heap on plain arrays, for shortest paths inside kernels: least key first."""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.jit import njit


@njit
def push(keys: Any, items: Any, size: int, key: float, item: int) -> Any:
    """Add an item; returns (keys, items, size), which are new arrays where the old ones were full."""
    if size == len(keys):
        more_keys, more_items = np.empty(2 * size + 16, np.float64), np.empty(2 * size + 16, np.int64)
        more_keys[:size], more_items[:size] = keys, items
        keys, items = more_keys, more_items
    i = size
    while i > 0 and keys[(i - 1) // 2] > key:
        keys[i], items[i] = keys[(i - 1) // 2], items[(i - 1) // 2]
        i = (i - 1) // 2
    keys[i], items[i] = key, item
    return keys, items, size + 1


@njit
def drop_first(keys: Any, items: Any, size: int) -> int:
    """Remove the first item (read it from ``keys[0], items[0]`` before); returns the new size."""
    size -= 1
    key, item = keys[size], items[size]
    i = 0
    while True:
        child = 2 * i + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[i], items[i] = keys[child], items[child]
        i = child
    keys[i], items[i] = key, item
    return size
