"""Standard normal numbers for kernels: drawn many at a time, used one after the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class Normals:
    """A store of standard normal numbers. How many are drawn at a time changes none of them.

    Parameters
    ----------
    size
        Numbers to draw at a time; no more can be asked for at once.

    Attributes
    ----------
    numbers
        Shape (size,).
    used
        How many of them are spent, shape (1,): whoever takes numbers says so here.
    """

    def __init__(self, size: int) -> None:
        self.numbers, self.used = np.zeros(size), np.array([size])

    def begin(self, rng: np.random.Generator) -> None:
        """Draw from this generator from now on."""
        self._rng = rng
        self.used[0] = len(self.numbers)

    def refill(self) -> None:
        """Draw as many numbers as are spent; what is left comes first."""
        used = int(self.used[0])
        self.numbers[: len(self.numbers) - used] = self.numbers[used:].copy()
        self._rng.standard_normal(out=self.numbers[len(self.numbers) - used :])
        self.used[0] = 0

    def ahead(self, count: int) -> NDArray[np.float64]:
        """Return the next numbers, at least so many, without spending them."""
        if self.used[0] + count > len(self.numbers):
            self.refill()
        return self.numbers[self.used[0] :]

    def take(self, count: int) -> NDArray[np.float64]:
        """Return the next numbers, shape (count,), and spend them."""
        taken = self.ahead(count)[:count]
        self.used[0] += count
        return taken
