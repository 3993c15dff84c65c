from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import threading
import time

import pytest

from agents.parallel import THREADS, over_seeds, processors


def test_results_come_in_the_order_of_the_seeds_from_other_processes():
    before = {name: os.environ.get(name) for name in THREADS}
    warm: list[bool] = []
    seeds = [3, 1, 2]
    assert list(over_seeds(hex, seeds, lambda: warm.append(True), workers=2)) == ["0x3", "0x1", "0x2"]
    assert {name: os.environ.get(name) for name in THREADS} == before
    assert warm == [True]


def test_one_worker_runs_here():
    assert list(over_seeds(lambda seed: os.getpid() + seed, [0, 1], workers=1)) == [os.getpid(), os.getpid() + 1]


def test_no_seed_gives_nothing():
    assert list(over_seeds(hex, [])) == []


def test_an_error_of_a_seed_is_raised_and_no_process_stays():
    with pytest.raises(ValueError, match="chr"):
        list(over_seeds(chr, [1, 2, -1, 4], workers=2))
    assert multiprocessing.active_children() == []


def test_leaving_early_stops_the_processes():
    results = over_seeds(hex, range(100), workers=2)
    assert next(results) == "0x0"
    results.close()
    assert multiprocessing.active_children() == []


def test_processes_end_with_a_parent_that_is_killed(tmp_path):
    """The workers hold a pipe's writing end open: it is read to its end once they are gone."""
    code = """
import time
from agents.parallel import over_seeds
if __name__ == "__main__":
    list(over_seeds(time.sleep, [0, 0, 600, 600], lambda: print(flush=True), 2))
"""
    script = tmp_path / "killed.py"
    script.write_text(code)
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        parent.stdout.readline()
        time.sleep(3)  # until the workers are at it
        parent.kill()
        reader = threading.Thread(target=parent.stdout.read, daemon=True)
        reader.start()
        reader.join(60)
        assert not reader.is_alive()


def test_there_is_a_processor():
    assert processors() >= 1
