from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from PIL import Image

from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.rendering.palette import (
    PLAIN,
    blend,
    font,
    picture_colours,
    reduced,
    text_mask,
    text_width,
    type_colour,
)


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


def test_pillows_own_font_has_what_is_plain():
    own, nothing = font(20), font(20).getmask("\ufffe")
    assert all(bytes(own.getmask(c)) != bytes(nothing) for c in PLAIN - {"\n"})


@pytest.mark.parametrize("text", ["Lolë", "Crazyfête", "Žižkov", "Ærø", "¿Qué?", "Łódź", "Αθήνα", "Москва", "12 m²"])
def test_letters_of_european_languages_are_no_empty_boxes(text):
    chosen = font(20, text)
    nothing = bytes(chosen.getmask("\ufffe"))
    assert all(bytes(chosen.getmask(letter)) != nothing for letter in text if letter != " ")
    assert text_width(text, 20) == chosen.getlength(text) and text_mask(text, 20).getbbox() is not None


def test_a_plain_text_keeps_pillows_own_font():
    assert font(20, "the kitchen") is font(20) is not font(20, "Crazyfête")


def test_blend():
    assert blend((0, 0, 0), (200, 100, 50), 0.5) == (100, 50, 25)
    assert blend((1, 2, 3), (200, 100, 50), 0.0) == (1, 2, 3)
