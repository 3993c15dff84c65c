"""The compiling decorators of the project.

Numba notices a change of the decorated file only: a kernel that inlined a helper from *another* file keeps running its
stale machine code. The cache of every kernel therefore lives in a folder named after the sources of all kernels and of
the modules whose constants they may have frozen.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core.options import DefaultOptions
from numpy.typing import NDArray

Array = NDArray[Any]
"""An array in a kernel's signature."""

Record = Any
"""One record of a structured array, or a workspace, in a kernel's signature."""

F = TypeVar("F", bound=Callable[..., Any])


def njit(function: F) -> F:
    """Compile `function` with Numba in nopython mode, cached on disk under a key of all kernel sources.

    Random numbers never come from inside a kernel (Numba's generator is not seeded by NumPy): hand them in.
    """
    return _compiled(function, counts_references=True)


def lean(function: F) -> F:
    """Do what `njit` does for a function that makes no array, without counting references.

    Otherwise every call counts each array that it is handed up and down again, one after the other, and a tuple of
    arrays takes longer to count than a small kernel to run. What makes an array or returns a new one won't compile.
    """
    return _compiled(function, counts_references=False)


def _compiled(function: F, counts_references: bool) -> F:
    # Where it is not told, Numba takes the option from whichever function calls this one first.
    options = {"_nrt": counts_references} if hasattr(DefaultOptions, "_nrt") else {}
    package = function.__module__.partition(".")[0]
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder(package))
    try:
        return numba.njit(cache=True, error_model="numpy", **options)(function)
    finally:
        numba.config.CACHE_DIR = before


@cache
def cache_folder(package: str) -> Path:
    """Return the cache folder for the kernels of a top-level package.

    Its name digests the kernel sources of `slam` and of the package, with all modules of theirs that those import.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for name, source in _kernel_sources(sorted({Path(__file__).parent, _root(package)})).items():
        digest.update(name.encode())
        digest.update(source.read_bytes())
    home = os.environ.get("NUMBA_CACHE_DIR") or Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    folder = Path(home) / "regionslam" / digest.hexdigest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        # A home that cannot be written to: compiled code then lives as long as the machine's temporary files.
        folder = Path(tempfile.gettempdir()) / "regionslam" / folder.name
    return folder


def _root(package: str) -> Path:
    """Return the folder of a top-level package (a test or a user's own script counts as `slam`)."""
    module = sys.modules.get(package)
    file = getattr(module, "__file__", None)
    return Path(file).parent if file and Path(file).name == "__init__.py" else Path(__file__).parent


def _kernel_sources(roots: list[Path]) -> dict[str, Path]:
    """Return, by module name, the files below `roots` that use the decorator and all that these import from there."""
    modules = {
        ".".join((root.name, *source.relative_to(root).with_suffix("").parts)): source
        for root in roots
        for source in root.rglob("*.py")
    }
    imports = {name: _imported(source) for name, source in modules.items()}
    waiting = [name for name in modules if "slam.jit" in imports[name]]
    found = {__name__}
    while waiting:
        name = waiting.pop()
        if name in modules and name not in found:
            found.add(name)
            waiting += imports[name]
    return {name: modules[name] for name in sorted(found) if name in modules}


def _imported(source: Path) -> list[str]:
    """Return the dotted names of the modules that a file imports."""
    return re.findall(r"^(?:from|import) ([\w.]+)", source.read_text("utf-8"), re.MULTILINE)
