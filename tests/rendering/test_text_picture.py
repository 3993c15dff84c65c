import math
import re

import numpy as np
import pytest

from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.rendering.shapes import Shape, shapes_of_world
from regionslam_env.rendering.text_picture import CHARACTERS, HEADINGS, TARGET, TextRenderer, text_picture
from slam.rows import Row
from tests.rendering.scene import world

ESCAPE = re.compile(r"\x1b\[[0-9;]*m")


def office(phi=0.0, x=0.0, y=0.0):
    return [Shape(1, "office", "office", Row.from_parameters(x, y, 4.0, 2.0, phi))]


def grid(text):
    """Return the lines above the legend."""
    lines = text.split("\n")
    return lines[: next(k for k, line in enumerate(lines) if line[1:].startswith(" me"))]


def test_a_room_is_as_large_as_its_characters():
    assert grid(text_picture(office(), (0.9, 0.4, 0.0), width=80, height=40)) == [
        "o" * 16,
        "o" * 11 + ">" + "o" * 4,
        "o" * 16,
        "o" * 16,
    ]


def test_truth_of_every_character():
    lines = grid(text_picture(shapes_of_world(world()), (2.0, 2.0, math.pi / 2), "kitchen", width=41, height=20))
    assert all(len(line) <= 41 for line in lines)
    height = len(lines)
    for shape in shapes_of_world(world()):
        x, y = shape.centre
        expected = TARGET if shape.type == "kitchen" else CHARACTERS[shape.type]
        line, column = min(height - 1, int((4 - y) / 4 * height)), int(x / 10 * 40)
        around = "".join(row[max(0, column - 1) : column + 2] for row in lines[max(0, line - 1) : line + 2])
        assert expected in around
    assert lines[-1].count("o") > 10 and lines[-1].count(TARGET) > 20
    assert sum(line.count("^") for line in lines) == 1


@pytest.mark.parametrize(("heading", "sign"), [(0.0, ">"), (1.5, "^"), (-3.1, "<"), (-1.6, "v"), (0.7, ">")])
def test_the_robot_shows_where_it_heads(heading, sign):
    lines = grid(text_picture(office(), (0.0, 0.0, heading)))
    assert [c for line in lines for c in line if c in HEADINGS] == [sign]


def test_walls_run_along_the_sides():
    turned = text_picture(office(phi=0.5), (0.0, 0.0, 0.5))
    assert {line.replace(">", "o") for line in grid(turned)} == {"o" * len(grid(turned)[0])}


def test_walls_askew_by_half_a_right_angle_do_not_flip_the_picture():
    askew = [math.pi / 4 + shift for shift in (-0.02, 0.02, -0.01, 0.01)]
    alone = {grid(text_picture(office(phi), (0.0, 0.0, phi)))[1].strip("o ") for phi in askew}
    renderer = TextRenderer()
    frames = [renderer.frame(office(phi), (0.0, 0.0, phi)) for phi in askew]
    assert len(alone) > 1 and len(set(frames)) == 1


def test_the_legend_names_what_is_there():
    text = text_picture([*office(), Shape(2, "moat", "moat", Row.from_parameters(8, 0, 4, 2))], (0, 0, 0), "kitchen")
    assert text.endswith("> me  * kitchen (the goal, not known yet)  ? moat  o office")
    assert text_picture(office(), (0, 0, 0), "office").endswith("> me  * office (the goal)")


def test_it_stays_within_its_size_even_far_from_everything():
    shapes = [*shapes_of_world(world()), *office(x=400.0, y=-300.0)]
    lines = text_picture(shapes, (-50.0, 90.0, 0.3), "kitchen", width=40, height=12).split("\n")
    assert max(map(len, lines)) <= 40
    assert len(grid("\n".join(lines))) <= 12
    assert sum(line.count("v") + line.count(">") for line in grid("\n".join(lines))) == 1


def test_nothing_known_is_the_robot_alone():
    assert text_picture([], (3.0, 4.0, 0.0)) == ">\n> me"


def test_colour_is_there_only_when_asked_for():
    pose = np.array([2.0, 2.0, 0.0])
    plain = text_picture(shapes_of_world(world()), pose, "kitchen")
    colourful = text_picture(shapes_of_world(world()), pose, "kitchen", colour=True)
    assert "\x1b" not in plain and "\x1b" in colourful
    bare = ESCAPE.sub("", colourful)
    assert [line.rstrip() for line in bare.split("\n")] == plain.split("\n")


def test_every_type_but_the_last_has_a_character_of_its_own():
    assert set(CHARACTERS) == set(SEMANTIC_TYPES) - {"other"}
    assert len(set(CHARACTERS.values()) | {"?", TARGET, " ", *HEADINGS}) == len(CHARACTERS) + 3 + len(HEADINGS)
