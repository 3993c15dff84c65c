from __future__ import annotations

from itertools import combinations

from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.rendering.palette import blend, type_colour


def test_the_usual_types_can_be_told_apart():
    for one, other in combinations(SEMANTIC_TYPES, 2):
        difference = sum(abs(a - b) for a, b in zip(type_colour(one), type_colour(other), strict=True))
        assert difference >= 25, (one, other)


def test_an_unknown_type_always_gets_the_same_pale_colour():
    colour = type_colour("swimming pool")
    assert colour == type_colour("swimming pool") and min(colour) > 120
    assert colour != type_colour("wine cellar")


def test_blend():
    assert blend((0, 0, 0), (200, 100, 50), 0.5) == (100, 50, 25)
    assert blend((1, 2, 3), (200, 100, 50), 0.0) == (1, 2, 3)
