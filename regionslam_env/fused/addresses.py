"""Arrays of many owners in one compiled call: by their addresses.

A kernel that looks after many environments cannot be handed thousands of arrays, each of a size of its own. It is
handed a table instead: a row for each owner, with address and shape of every array.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba import carray
from numba.core import types
from numba.extending import intrinsic, overload
from numpy.typing import NDArray

from slam.jit import njit

WORDS = 3
"""Words of a row for an array: its address, and its shape in two numbers."""

Row = NDArray[np.int64]


class Addresses:
    """A table of addresses, and a hold on the arrays, so that none of them goes away.

    Parameters
    ----------
    owners, arrays
        Numbers of owners, and of arrays of each.

    Attributes
    ----------
    table
        Shape (owners, WORDS * arrays).
    """

    def __init__(self, owners: int, arrays: int) -> None:
        self.table = np.zeros((owners, WORDS * arrays), np.int64)
        self._held: list[list[NDArray[Any] | None]] = [[None] * arrays for _ in range(owners)]

    def put(self, owner: int, first: int, arrays: Sequence[NDArray[Any]]) -> None:
        """Enter arrays of one or two dimensions from place `first` on.

        Raises
        ------
        ValueError
            For an array that is not contiguous, or holds objects: kernels would write over what it points to.
        """
        row, held = self.table[owner], self._held[owner]
        for place, array in enumerate(arrays, first):
            if held[place] is not array:
                if not array.flags.c_contiguous or array.dtype.hasobject:
                    raise ValueError(f"array {place} ({array.dtype}) is no contiguous array of numbers")
                held[place] = array
                shape = array.shape if array.ndim == 2 else (len(array), 1)
                row[WORDS * place : WORDS * (place + 1)] = (array.__array_interface__["data"][0], *shape)


def pointer(address: int) -> Any:
    """Return an address as a pointer, for `numba.carray`."""
    return ctypes.c_void_p(int(address))


@intrinsic
def _as_pointer(typing_context: Any, address: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())

    return types.voidptr(types.int64), generate


@overload(pointer)
def _pointer_in_kernels(address: Any) -> Any:
    def implementation(address: Any) -> Any:
        return _as_pointer(address)

    return implementation


@njit
def line(row: Row, place: int, dtype: Any) -> Any:
    """Return the array of one dimension at a place of a row."""
    return carray(pointer(row[WORDS * place]), (row[WORDS * place + 1],), dtype)


@njit
def sheet(row: Row, place: int, dtype: Any) -> Any:
    """Return the array of two dimensions at a place of a row."""
    return carray(pointer(row[WORDS * place]), (row[WORDS * place + 1], row[WORDS * place + 2]), dtype)
