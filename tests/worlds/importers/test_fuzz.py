"""Damaged files of every format give a world or a `WorldError` that names the file: no other exception, no hang."""

import importlib.util

import pytest

from tests.worlds.importers.mutations import FILES, attempt

NAMES = [name for name in FILES if name != "ifc" or importlib.util.find_spec("ifcopenshell") is not None]
FEW, MANY = 15, 10_000


@pytest.mark.parametrize("name", NAMES)
def test_damaged_files(tmp_path, name):
    worlds = [attempt(name, seed, tmp_path / "files") for seed in range(FEW)]
    assert not all(worlds)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_many_damaged_files(tmp_path, name):
    share = -(-MANY // len(NAMES))
    worlds = [attempt(name, seed, tmp_path / "files") for seed in range(FEW, FEW + share)]
    assert 0 < sum(worlds) < share
