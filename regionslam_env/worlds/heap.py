"""A binary heap on plain arrays, for shortest paths inside kernels: the item with the least key comes first.

Items are numbers 0 .. n-1 and stand in the heap at most once, so it never grows beyond n: `heap` holds the items,
`place` where each of them stands in it (-1: nowhere), `key` what they are ordered by.
"""

from __future__ import annotations

from slam.jit import Array, lean


@lean
def lower(heap: Array, place: Array, key: Array, size: int, item: int) -> int:
    """Put an item into the heap, or move it up after its key has become smaller; returns the size."""
    i = place[item]
    if i < 0:
        i = size
        size += 1
    while i > 0:
        above = (i - 1) >> 1
        if key[heap[above]] <= key[item]:
            break
        heap[i] = heap[above]
        place[heap[i]] = i
        i = above
    heap[i] = item
    place[item] = i
    return size


@lean
def drop_first(heap: Array, place: Array, key: Array, size: int) -> int:
    """Remove the first item (read ``heap[0]`` before); returns the size."""
    place[heap[0]] = -1
    size -= 1
    if size == 0:
        return size
    item = heap[size]
    i = 0
    while True:
        child = 2 * i + 1
        if child >= size:
            break
        if child + 1 < size and key[heap[child + 1]] < key[heap[child]]:
            child += 1
        if key[heap[child]] >= key[item]:
            break
        heap[i] = heap[child]
        place[heap[i]] = i
        i = child
    heap[i] = item
    place[item] = i
    return size
