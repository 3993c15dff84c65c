"""A grid over the regions of all maps: what lies near a place is found without looking at the whole map.

Every slot is a circle that covers its region in all particles' maps. Circles are sorted by size into layers, whose
cells double in width from one to the next; each circle lies in the cell of its centre, on the first layer whose cells
are at least as wide as its radius. Cells are buckets of a hash table.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from slam.jit import Array, Record, lean, njit

CELL = 8.0
"""Width of the smallest cells, in the unit of length; it decides on speed alone."""

FOUND = 64
"""Room for slots that a search begins with."""

SLOT = np.dtype(
    (
        np.record,
        [
            ("id", np.int64),  # of the region
            ("holders", np.int64),  # particles that know it
            ("x", np.float64),  # centre of the circle, map frame, m
            ("y", np.float64),
            ("radius", np.float64),  # m; negative before the first one
            ("layer", np.int64),
            ("column", np.int64),
            ("row", np.int64),
            ("next", np.int64),  # in the same bucket, -1 at the end
        ],
    )
)
"""A region's place in all maps and in the grid."""


@lean
def bucket_of(layer: int, column: int, row: int, n_buckets: int) -> Any:
    """Return the bucket of a cell; `n_buckets` is a power of two."""
    return (column * 73856093 ^ row * 19349663 ^ layer * 83492791) & (n_buckets - 1)


@lean
def enter(slots: Array, buckets: Array, slot: int, n_layers: Array) -> None:
    """Put a slot's circle into its cell; `n_layers[0]` counts the layers in use."""
    place = slots[slot]
    layer, width = 0, CELL
    while width < place.radius:
        layer, width = layer + 1, 2 * width
    n_layers[0] = max(n_layers[0], layer + 1)
    place.layer = layer
    place.column, place.row = int(np.floor(place.x / width)), int(np.floor(place.y / width))
    bucket = bucket_of(layer, place.column, place.row, len(buckets))
    place.next = buckets[bucket]
    buckets[bucket] = slot


@lean
def leave(slots: Array, buckets: Array, slot: int) -> None:
    """Take a slot's circle out of its cell."""
    place = slots[slot]
    bucket = bucket_of(place.layer, place.column, place.row, len(buckets))
    if buckets[bucket] == slot:
        buckets[bucket] = place.next
        return
    index = buckets[bucket]
    while slots[index].next != slot:
        index = slots[index].next
    slots[index].next = place.next


@njit
def search(slots: Array, buckets: Array, n_layers: int, x: float, y: float, radius: float) -> Array:
    """Return the slots whose circles touch a circle about (x, y), in ascending order."""
    if (2 * (radius / CELL + 1) + 1) ** 2 > len(slots):
        return search_all(slots, x, y, radius)  # fewer slots than cells
    found = np.empty(FOUND, np.int64)
    n = search_cells(slots, buckets, n_layers, x, y, radius, found)
    if n > len(found):
        found = np.empty(n, np.int64)
        search_cells(slots, buckets, n_layers, x, y, radius, found)
    found[:n].sort()
    return found[:n]


@lean
def search_cells(slots: Array, buckets: Array, n_layers: int, x: float, y: float, radius: float, found: Array) -> int:
    """Write the slots whose circles touch a circle about (x, y), as many as there is room for; return how many are."""
    n, width = 0, CELL
    for layer in range(n_layers):
        reach = radius + width
        if (2 * reach / width) ** 2 > len(buckets):  # more cells than buckets: every bucket once
            for slot in buckets:
                while slot >= 0:
                    if slots[slot].layer == layer and meets(slots[slot], x, y, radius):
                        if n < len(found):
                            found[n] = slot
                        n += 1
                    slot = slots[slot].next
            width *= 2
            continue
        for column in range(int(np.floor((x - reach) / width)), int(np.floor((x + reach) / width)) + 1):
            for row in range(int(np.floor((y - reach) / width)), int(np.floor((y + reach) / width)) + 1):
                slot = buckets[bucket_of(layer, column, row, len(buckets))]
                while slot >= 0:
                    if touches(slots[slot], layer, column, row, x, y, radius):
                        if n < len(found):
                            found[n] = slot
                        n += 1
                    slot = slots[slot].next
        width *= 2
    return n


@njit
def search_all(slots: Array, x: float, y: float, radius: float) -> Any:
    """Do the same without the grid."""
    found, n = np.empty(len(slots), np.int64), 0
    for slot in range(len(slots)):
        place = slots[slot]
        dx, dy, reach = place.x - x, place.y - y, place.radius + radius
        if place.holders > 0 and place.radius >= 0.0 and dx * dx + dy * dy <= reach * reach:
            found[n] = slot
            n += 1
    return found[:n]


@lean
def touches(place: Record, layer: int, column: int, row: int, x: float, y: float, radius: float) -> bool:
    """Say whether a circle lies in a cell (others share its bucket) and touches the circle about (x, y)."""
    if place.layer != layer or place.column != column or place.row != row:
        return False
    return meets(place, x, y, radius)


@lean
def meets(place: Record, x: float, y: float, radius: float) -> bool:
    """Say whether a slot's circle touches the circle about (x, y)."""
    dx, dy, reach = place.x - x, place.y - y, place.radius + radius
    return dx * dx + dy * dy <= reach * reach
