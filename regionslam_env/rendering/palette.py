"""Colours and fonts, the same in every picture: a type keeps its colour from the animation to the map."""

from __future__ import annotations

import colorsys
import hashlib
import itertools
import string
from collections.abc import Iterable
from functools import cache, lru_cache
from importlib.resources import files
from io import BytesIO

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

Colour = tuple[int, int, int]

INK: Colour = (38, 44, 56)
MUTED: Colour = (110, 118, 132)
FAINT: Colour = (196, 201, 209)
PAPER: Colour = (255, 255, 255)
FLOOR: Colour = (246, 245, 242)
UNSEEN: Colour = (226, 229, 234)
TRUTH: Colour = (31, 78, 158)
BELIEF: Colour = (196, 43, 84)
GOAL: Colour = (222, 120, 0)
LIDAR: Colour = (22, 140, 120)
LINK: Colour = (90, 98, 112)
PERSON: Colour = (122, 52, 158)
SHUT: Colour = (176, 24, 24)

LIDAR_SHARE = 0.13
"""How strongly the area swept by the lidar is tinted."""

PLAIN = frozenset(string.ascii_letters + string.digits + string.punctuation + " \n©«°±´·»‘’“”…‹›⁄™")
"""Characters that Pillow's own font has."""

WIDE = 0.92
"""Size of the other font, whose letters are wider, over that of Pillow's own."""

_TYPES: dict[str, str] = {
    "hallway": "#f1e9d2",
    "office": "#b3cfee",
    "kitchen": "#f9bd7e",
    "laboratory": "#c7b2ea",
    "meeting room": "#a5dcb4",
    "toilet": "#95dbe0",
    "storage": "#d3bea4",
    "classroom": "#f4dd86",
    "lobby": "#f3cfc6",
    "stairs": "#bcc4ce",
    "elevator": "#9ca8b8",
    "entrance": "#eeb0c6",
    "service room": "#c6c49c",
    "living room": "#bfe3a0",
    "bedroom": "#9aa9e0",
    "ward": "#88b6c9",
    "outdoor": "#cfe0b8",
    "door": "#d9694f",
    "desk": "#a98d6c",
    "cupboard": "#857360",
    "table": "#bb9264",
    "bed": "#8f7fb5",
    "sofa": "#b0687f",
    "other": "#d6d8db",
}


@cache
def type_colour(region_type: str) -> Colour:
    """Return the fill colour of a semantic type; an unknown type gets a pale one of its own, always the same."""
    code = _TYPES.get(region_type)
    if code is not None:
        return int(code[1:3], 16), int(code[3:5], 16), int(code[5:7], 16)
    hue = hashlib.sha256(region_type.encode()).digest()[0] / 256
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.35, 0.9)
    return round(255 * red), round(255 * green), round(255 * blue)


def blend(colour: Colour, other: Colour, share: float) -> Colour:
    """Return `colour` mixed with a share in [0, 1] of `other`."""
    red, green, blue = (round((1 - share) * a + share * b) for a, b in zip(colour, other, strict=True))
    return red, green, blue


def picture_colours(types: Iterable[str]) -> list[Colour]:
    """Return the colours of which pictures with these types are made: plain, pale, under the lidar and along edges."""
    colours = [INK, MUTED, FAINT, PAPER, FLOOR, UNSEEN, TRUTH, BELIEF, GOAL, LIDAR, LINK, PERSON, SHUT]
    for ground in (PAPER, FLOOR, UNSEEN, *map(type_colour, types)):
        colours += [ground, blend(ground, LIDAR, LIDAR_SHARE), blend(ground, INK, 0.35), blend(ground, INK, 0.7)]
        colours += [blend(ground, PAPER, 0.25), blend(ground, PAPER, 0.5)]
    return list(dict.fromkeys(colours))


def colour_table(colours: Iterable[Colour]) -> list[Colour]:
    """Return at most 256 colours: those given and as fine a cube of all colours as there is room for."""
    own = list(dict.fromkeys(colours))[:248]
    levels = int((256 - len(own)) ** (1 / 3) + 1e-9)
    steps = np.linspace(0, 255, levels).round().astype(int).tolist()
    return [*own, *itertools.product(steps, repeat=3)]


def reduced(picture: Image.Image, colours: Iterable[Colour]) -> Image.Image:
    """Return a picture in mode "P": these colours stay exact, which Pillow's own reduction does not promise."""
    table = np.array(colour_table(colours), np.int64)
    codes, inverse = np.unique(np.asarray(picture, np.int64) @ (1 << 16, 1 << 8, 1), return_inverse=True)
    found = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1)
    nearest = np.sum((found[:, None] - table) ** 2, axis=2).argmin(axis=1).astype(np.uint8)
    image = Image.fromarray(nearest[inverse].reshape(picture.height, picture.width))
    image.putpalette(table.ravel().tolist())
    return image


def font(size: int, text: str = "") -> ImageFont.FreeTypeFont:
    """Return a font that has the letters of a text, the same one on every machine.

    Pillow's own where that will do; else a part of DejaVu Sans with the letters of European languages.

    Raises
    ------
    OSError
        Where Pillow was built without FreeType.
    """
    return _own_font(size) if PLAIN.issuperset(text) else _wide_font(size)


@cache
def _own_font(size: int) -> ImageFont.FreeTypeFont:
    loaded = ImageFont.load_default(size)
    if not isinstance(loaded, ImageFont.FreeTypeFont):
        raise OSError("Pillow was built without FreeType, which the pictures' text needs")
    return loaded


@cache
def _wide_font(size: int) -> ImageFont.FreeTypeFont:
    data = (files("regionslam_env.rendering") / "fonts" / "DejaVuSans-subset.ttf").read_bytes()
    return ImageFont.truetype(BytesIO(data), WIDE * size)


@cache
def text_width(text: str, size: int) -> float:
    """Return the width of a text, px."""
    return font(size, text).getlength(text)


@lru_cache(maxsize=4096)
def text_mask(text: str, size: int) -> Image.Image:
    """Return a text's coverage, mode "L": pasted through it, any colour is quicker than set anew."""
    left, top, right, bottom = font(size, text).getbbox(text)
    mask = Image.new("L", (max(1, int(right - left) + 2), max(1, int(bottom - top) + 2)))
    ImageDraw.Draw(mask).text((1 - left, 1 - top), text, 255, font(size, text))
    return mask


@lru_cache(maxsize=4096)
def text_halo(text: str, size: int) -> Image.Image:
    """Return what surrounds a text by 2 px, mode "L", with the same middle as its `text_mask`."""
    mask = text_mask(text, size)
    halo = Image.new("L", (mask.width + 6, mask.height + 6))
    halo.paste(mask, (3, 3))
    return halo.filter(ImageFilter.MaxFilter(5)).filter(ImageFilter.GaussianBlur(0.8)).point(lambda v: round(0.8 * v))
