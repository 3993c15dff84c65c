from __future__ import annotations

import numpy as np
import pytest

from slam.grid import SLOT, enter, leave, search


class Circles:
    """A grid of circles, and what a look at all of them finds."""

    def __init__(self, n: int, seed: int, buckets: int = 32) -> None:
        rng = np.random.default_rng(seed)
        self.slots, self.buckets = np.zeros(n, SLOT), np.full(buckets, -1, np.int32)
        self.layers = np.zeros(1, np.int64)
        self.slots["x"], self.slots["y"] = rng.uniform(-60, 60, (2, n))
        self.slots["radius"] = np.exp(rng.uniform(-2, 4.5, n))
        self.slots["holders"] = 1
        self.present = set(range(n))
        for slot in range(n):
            enter(self.slots, self.buckets, slot, self.layers)

    def leave(self, slot: int) -> None:
        leave(self.slots, self.buckets, slot)
        self.slots["holders"][slot] = 0
        self.present.remove(slot)

    def found(self, x: float, y: float, radius: float) -> list[int]:
        return search(self.slots, self.buckets, self.layers[0], x, y, radius).tolist()

    def touching(self, x: float, y: float, radius: float) -> list[int]:
        distance = np.hypot(self.slots["x"] - x, self.slots["y"] - y)
        return [i for i in np.flatnonzero(distance <= self.slots["radius"] + radius).tolist() if i in self.present]


@pytest.mark.parametrize("seed", range(3))
def test_a_search_finds_what_a_look_at_everything_does(seed: int) -> None:
    """More circles than buckets, of all sizes; some leave in between."""
    circles, rng = Circles(200, seed), np.random.default_rng(seed)
    for slot in (*range(0, 200, 3), 199):
        if slot in circles.present:
            x, y = rng.uniform(-70, 70, 2)
            radius = float(np.exp(rng.uniform(-3, 3.5)))
            assert circles.found(x, y, radius) == circles.touching(x, y, radius)
            circles.leave(slot)


def test_an_empty_grid_and_a_circle_of_a_kilometre() -> None:
    assert Circles(0, 0).found(0, 0, 5.0) == []
    one = Circles(1, 0)
    one.leave(0)
    one.slots["radius"], one.slots["holders"] = 1000.0, 1
    enter(one.slots, one.buckets, 0, one.layers)
    one.present.add(0)
    assert one.found(900.0, 0.0, 1.0) == [0]
    assert one.found(1100.0, 0.0, 1.0) == []
