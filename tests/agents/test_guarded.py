import os
import time

import pytest

from agents.guarded import Job, guarded


def test_results_come_with_their_items():
    jobs = sorted(guarded(abs, range(-3, 0), 60, workers=2), key=lambda job: job.item)
    assert jobs == [Job(-3, 3), Job(-2, 2), Job(-1, 1)]


def test_what_hangs_is_given_up_and_the_others_go_on():
    jobs = list(guarded(time.sleep, [0, 10_000, 0], 1, workers=1))
    assert jobs == [Job(0, None), Job(10_000, None, "hung"), Job(0, None)]


def test_a_crash_is_told():
    assert list(guarded(os._exit, [3], 60, workers=1)) == [Job(3, None, "crashed")]


def test_a_process_that_cannot_start_is_an_error():
    with pytest.raises(RuntimeError, match="crashed while it started"):
        list(guarded(abs, [1], 60, workers=1, warm_up=os.abort))


def test_nothing_to_do():
    assert list(guarded(abs, [], 60, workers=2)) == []
