"""Damaged files of every format give a world or one line that says what is wrong: no other exception, no hang."""

import random
from collections import Counter

import pytest

from agents.console import InputError
from agents.fuzzing.attempt import FAILED, REFUSED, WORLD, attempt
from agents.fuzzing.campaign import EXAMPLES, benchmark_fuzz
from agents.fuzzing.examples import examples_in
from agents.fuzzing.tree_changes import change_json
from regionslam_env.worlds.importers.formats import FORMATS

FEW = 120
KNOWN = examples_in(EXAMPLES)

pytestmark = pytest.mark.compiled


def test_there_is_an_example_of_every_format():
    missing = {"ours", *(f.name for f in FORMATS)} - {example.format for example in KNOWN}
    assert missing <= {"ifc"}  # an extra


def test_a_number_does_the_same_damage_again(tmp_path):
    for number, example in enumerate(KNOWN):
        copies = []
        for name in ("a", "b"):
            folder = tmp_path / name / str(number)
            folder.mkdir(parents=True)
            example.damaged(folder, random.Random(number))
            copies.append({file.relative_to(folder): file.read_bytes() for file in folder.rglob("*") if file.is_file()})
        assert copies[0] == copies[1]


def test_what_is_huge_already_can_be_changed_again():
    for number in range(100):
        assert change_json(b'{"level": 1%s}' % (b"0" * 400), random.Random(number))


def test_damaged_files():
    outcomes = {number: attempt(number, KNOWN) for number in range(FEW)}
    assert {number: o.detail for number, o in outcomes.items() if o.outcome == FAILED} == {}
    counts = Counter(o.outcome for o in outcomes.values())
    assert counts[WORLD] > FEW / 10 and counts[REFUSED] > FEW / 3


def test_a_failure_is_told_with_its_traceback(monkeypatch):
    def broken(path):
        raise RuntimeError("a defect")

    monkeypatch.setattr("agents.fuzzing.attempt.load", broken)
    failed = [o for number in range(12) if (o := attempt(number, KNOWN)).outcome == FAILED]
    assert failed and all("a defect" in o.detail for o in failed)


def test_a_folder_without_buildings_is_refused(tmp_path):
    with pytest.raises(InputError, match="no building that loads"):
        benchmark_fuzz(1, folder=tmp_path)


@pytest.mark.slow
def test_many_damaged_files(tmp_path):
    result = benchmark_fuzz(2_000, first=1_000_000, keep=tmp_path)
    assert result["failures"] == []
    assert sum(result["outcomes"].values()) == 2_000
