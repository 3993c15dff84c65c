"""Real floor plans, where the folder with them is at hand."""

from pathlib import Path

PLANS = Path(__file__).parents[2].parent / "shared" / "data" / "plans"
LUPERTO = sorted((PLANS / "luperto").glob("*.xml"))
MISSING = f"no floor plans in {PLANS}"
