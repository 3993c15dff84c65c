from __future__ import annotations

from itertools import combinations

import numpy as np
from PIL import Image

from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.rendering.palette import blend, picture_colours, reduced, type_colour


def test_the_usual_types_can_be_told_apart():
    for one, other in combinations(SEMANTIC_TYPES, 2):
        difference = sum(abs(a - b) for a, b in zip(type_colour(one), type_colour(other), strict=True))
        assert difference >= 25, (one, other)


def test_an_unknown_type_always_gets_the_same_pale_colour():
    colour = type_colour("swimming pool")
    assert colour == type_colour("swimming pool") and min(colour) > 120
    assert colour != type_colour("wine cellar")


def test_a_reduced_picture_keeps_its_own_colours_exact():
    colours = picture_colours(SEMANTIC_TYPES)
    picture = Image.fromarray(np.array([[*colours, (1, 2, 3)]], np.uint8))
    image = reduced(picture, colours)
    pixels = np.asarray(image.convert("RGB"))[0]
    assert image.mode == "P" and pixels[:-1].tolist() == [list(colour) for colour in colours]
    assert np.abs(pixels[-1].astype(int) - (1, 2, 3)).max() <= 43


def test_blend():
    assert blend((0, 0, 0), (200, 100, 50), 0.5) == (100, 50, 25)
    assert blend((1, 2, 3), (200, 100, 50), 0.0) == (1, 2, 3)
