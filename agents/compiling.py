"""The first run compiles the filter, for minutes; who waits is told."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

from slam.jit import cache_folder

FILTER = "slam"
"""The package whose kernels take long: those of worlds and sensors are ready in seconds."""

MOST_OF_IT = "scan_update.*.nbi"
"""Files that are in the cache once most of the filter has been compiled; a kernel or two are at every import."""

COMPILING = "compiling the filter, once; this takes some minutes"


class _Teller(event.Listener):  # type: ignore[misc]
    """Waits for the first kernel of the filter to be compiled."""

    def __init__(self) -> None:
        self._told = False

    def on_start(self, event: Any) -> None:
        """Tell where the filter is not stored yet: a kernel that is compiled beside it takes little time."""
        package = event.data["dispatcher"].py_func.__module__.partition(".")[0]
        if not self._told and package == FILTER:
            self._told = True
            if not any(cache_folder(FILTER).rglob(MOST_OF_IT)):
                print(COMPILING, file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Say nothing more."""


@contextmanager
def told() -> Iterator[None]:
    """Say so on standard error before the filter is compiled for the first time."""
    with event.install_listener("numba:compile", _Teller()):
        yield
