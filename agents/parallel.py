"""One function over many seeds, in as many processes as this one may use processors."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""What linear algebra libraries read their number of threads from when they are loaded."""


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def over_seeds(
    function: Callable[[int], T],
    seeds: Sequence[int],
    warm_up: Callable[[], object] = lambda: None,
    workers: int | None = None,
) -> Iterator[T]:
    """Yield `function(seed)` for every seed, in the order of the seeds.

    Parameters
    ----------
    function
        Of a module, or a `functools.partial` of one: it is sent to other processes.
    warm_up
        Called here first, so that kernels are compiled once and not in every process.
    workers
        Number of processes; by default one per processor. With one, everything runs here.
    """
    workers = min(workers or processors(), len(seeds))
    if workers <= 1:
        yield from map(function, seeds)
        return
    warm_up()
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")  # a fork would copy the progress display's thread half alive
    with single_threaded():
        pool = ProcessPoolExecutor(workers, context, initializer=depend_on_the_parent)
        futures = [pool.submit(function, seed) for seed in seeds]
    try:
        for future in futures:
            yield future.result()
    except BaseException:  # an error, an interrupt, or nobody wants the rest
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def single_threaded() -> Iterator[None]:
    """Let processes started here use one thread each for linear algebra."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def depend_on_the_parent() -> None:
    """Leave interrupts to the parent, and end with it, even where it was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
