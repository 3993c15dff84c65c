"""Jobs in processes of their own: one that hangs, crashes or eats all memory is told of and harms no other."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

from agents.parallel import depend_on_the_parent, single_threaded

STARTUP = 300.0
"""Seconds that a process may take to start and to warm up."""

MEMORY = 8 << 30
"""Bytes of address space of a process."""


@dataclass(frozen=True)
class Job:
    """A job that has ended: its item, its result, or why there is none ("hung" or "crashed")."""

    item: int
    result: Any
    trouble: str | None = None


class _Worker:
    """A process that waits for items."""

    def __init__(self, function: Callable[[int], Any], warm_up: Callable[[], object] | None) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_work, args=(theirs, function, warm_up), daemon=True)
        with single_threaded():
            self.process.start()
        theirs.close()
        self.item: int | None = None
        self.until = time.monotonic() + STARTUP

    def give(self, item: int, seconds: float) -> None:
        """Send an item, to be done within a time."""
        self.item, self.until = item, time.monotonic() + seconds
        self.pipe.send(item)

    def answer(self) -> tuple[Any, str | None]:
        """Return the result of the item and None, or None and what went wrong."""
        if not self.pipe.poll():
            return None, "hung"
        try:
            return self.pipe.recv(), None
        except EOFError:
            return None, "crashed"

    def end(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def guarded(
    function: Callable[[int], Any],
    items: Sequence[int],
    seconds: float,
    workers: int,
    warm_up: Callable[[], object] | None = None,
) -> Iterator[Job]:
    """Yield the jobs `function(item)` as they end, each done within some seconds or given up.

    Parameters
    ----------
    function, warm_up
        Of a module, or a `functools.partial` of one; `warm_up` is called once in every process, outside of the limit.
    """
    waiting = list(reversed(items))
    pool = [_Worker(function, warm_up) for _ in range(min(workers, len(waiting)))]
    try:
        while pool:
            soonest = min(worker.until for worker in pool) - time.monotonic()
            ready = wait([worker.pipe for worker in pool], max(soonest, 0))
            for worker in [w for w in pool if w.pipe in ready or time.monotonic() > w.until]:
                result, trouble = worker.answer()
                if worker.item is None and trouble is not None:
                    raise RuntimeError(f"a process {trouble} while it started")
                if worker.item is not None:
                    yield Job(worker.item, result, trouble)
                if waiting and trouble is None:
                    worker.give(waiting.pop(), seconds)
                    continue
                pool.remove(worker)
                worker.end()
                if waiting:
                    pool.append(_Worker(function, warm_up))
    finally:
        for worker in pool:
            worker.end()


def _work(pipe: Connection, function: Callable[[int], Any], warm_up: Callable[[], object] | None) -> None:
    """Answer every item with its result; an exception ends the process and counts as a crash."""
    depend_on_the_parent()
    _limit_memory()
    if warm_up is not None:
        warm_up()
    pipe.send(None)
    while True:
        pipe.send(function(pipe.recv()))


def _limit_memory() -> None:
    """Turn a flood of memory into a `MemoryError`, where the system can do that."""
    try:
        import resource
    except ImportError:  # Windows
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, hard))
