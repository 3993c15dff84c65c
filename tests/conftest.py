"""Tests that run whole episodes need compiled kernels: without the JIT each of them would take minutes."""

from __future__ import annotations

import numba
import pytest


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if numba.config.DISABLE_JIT:
        for item in items:
            if item.get_closest_marker("compiled"):
                item.add_marker(pytest.mark.skip(reason="minutes without the JIT"))
