"""What an installation gives: ids without an import, and nothing for those who do not use Gymnasium."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import PackageNotFoundError, distribution

import pytest

try:
    files = [str(f) for f in distribution("regionslam-env").files or ()]
except PackageNotFoundError:
    files = []
pytestmark = pytest.mark.skipif("regionslam_env.pth" not in files, reason="needs an installation")


def run(code: str, tmp_path) -> str:
    command = [sys.executable, "-W", "error", "-c", code]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_gymnasium_finds_the_ids_without_an_import(tmp_path):
    code = (
        "import gymnasium as gym; print(gym.spec('RegionSLAM/GoTo-v0').id, gym.spec('RegionSLAM/GoTo-Declare-v0').id)"
    )
    assert run(code, tmp_path) == "RegionSLAM/GoTo-v0 RegionSLAM/GoTo-Declare-v0"


def test_an_import_of_our_own_is_welcome_in_any_order(tmp_path):
    for imports in ("import regionslam_env, gymnasium", "import gymnasium, regionslam_env"):
        assert run(f"{imports}; print(gymnasium.spec('RegionSLAM/GoTo-v0').version)", tmp_path) == "0"


def test_importing_gymnasium_loads_no_physics_and_no_filter(tmp_path):
    code = (
        "import gymnasium, sys; print([m for m in ('numba', 'pymunk', 'shapely', 'slam', 'PIL') if m in sys.modules])"
    )
    assert run(code, tmp_path) == "[]"


def test_an_interpreter_without_gymnasium_loads_nothing_of_ours(tmp_path):
    code = "import sys; print([m for m in ('gymnasium', 'regionslam_env', 'numpy') if m in sys.modules])"
    assert run(code, tmp_path) == "[]"


def test_a_broken_installation_of_ours_does_not_break_gymnasium(tmp_path):
    (tmp_path / "regionslam_env").mkdir()
    (tmp_path / "regionslam_env" / "__init__.py").write_text("raise RuntimeError('broken')")
    code = (
        "import sys, warnings; sys.path.insert(0, '.')\n"
        "with warnings.catch_warnings(record=True) as told:\n"
        "    warnings.simplefilter('always')\n"
        "    import gymnasium\n"
        "print(gymnasium.spec('CartPole-v1').id, 'broken' in str(told[0].message))"
    )
    assert run(code, tmp_path) == "CartPole-v1 True"
