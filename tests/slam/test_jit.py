"""The compiling decorator: same results, and no stale machine code when another file changes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import slam
from slam import jit

KERNEL = """
from slam.jit import njit
from kernels.helper import scale

@njit
def scaled(x):
    return scale(x)
"""

HELPER = """
from slam.jit import njit

@njit
def scale(x):
    return {factor} * x
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of two kernels, one of which inlines the other from its own file."""
    folder = tmp_path / "kernels"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "kernel.py").write_text(KERNEL)
    (folder / "helper.py").write_text(HELPER.format(factor=2))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    return folder


def test_a_compiled_function_gives_the_same() -> None:
    def total(values: np.ndarray) -> float:
        result = 0.0
        for value in values:
            result += value
        return result

    assert jit.njit(total)(np.arange(5.0)) == total(np.arange(5.0)) == 10.0


def test_division_by_zero_is_as_in_numpy() -> None:
    def ratio(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return a / b

    with np.errstate(divide="ignore", invalid="ignore"):
        np.testing.assert_array_equal(jit.njit(ratio)(np.array([1.0, 0.0]), np.zeros(2)), [np.inf, np.nan])


def test_decorating_leaves_the_settings_of_numba_alone() -> None:
    before = numba.config.CACHE_DIR
    jit.njit(lambda x: x)
    assert before == numba.config.CACHE_DIR


def test_the_cache_folder_follows_the_kernel_sources(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = jit.cache_folder.__wrapped__
    module = type(sys)("kernels")
    module.__file__ = str(package / "__init__.py")
    monkeypatch.setitem(sys.modules, "kernels", module)
    first = folder("kernels")
    assert first.parent.parent == package.parent / "cache"
    assert folder("kernels") == first
    assert folder("slam") != first
    (package / "helper.py").write_text(HELPER.format(factor=3))
    second = folder("kernels")
    assert second != first
    (package / "helper.py").rename(package / "other.py")
    assert folder("kernels") not in (first, second)


def test_the_own_kernels_of_slam_count_for_every_package() -> None:
    folder = jit.cache_folder.__wrapped__
    assert folder("slam") == folder("some script")  # without a package of its own: slam's


@pytest.mark.skipif(bool(os.environ.get("NUMBA_DISABLE_JIT", "0") != "0"), reason="nothing is compiled")
def test_a_change_of_a_helper_in_another_file_is_seen(package: Path) -> None:
    def run() -> str:
        paths = [str(package.parent), str(Path(slam.__file__).parent.parent)]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"}
        code = "from kernels.kernel import scaled; print(scaled(10), sum(scaled.stats.cache_hits.values()))"
        return subprocess.check_output([sys.executable, "-c", code], env=environment, text=True).strip()

    assert run() == "20 0"
    assert run() == "20 1"  # the cache works at all
    (package / "helper.py").write_text(HELPER.format(factor=3))
    assert run() == "30 0"
