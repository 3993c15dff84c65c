"""Real floor plans, where the folder with them is at hand."""

from pathlib import Path

import pytest

PLANS = Path(__file__).parents[2].parent / "shared" / "data" / "plans"
LUPERTO = sorted((PLANS / "luperto").glob("*.xml"))
compiled_only = pytest.mark.compiled

MISSING = f"no floor plans in {PLANS}"
