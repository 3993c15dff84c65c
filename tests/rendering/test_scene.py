from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from regionslam_env.rendering import Renderer
from regionslam_env.rendering.palette import FLOOR, PERSON, SHUT, type_colour
from regionslam_env.simulation.furniture import pieces_of, without
from regionslam_env.simulation.movers import Scene
from slam.rows import Row
from tests.rendering.scene import DESK, world
from tests.rendering.test_renderer import START, snapshot

MOVED = replace(DESK, row=Row.from_parameters(2.0, 0.6, 1.6, 0.8))
SCENE = Scene(
    people=np.array([(7.0, 2.0, 0.5)]),
    person_radius=0.25,
    closed_doors=("door",),
    door_segments=np.array([(4.0, 1.55, 4.0, 2.45)]),
    furniture=(MOVED,),
    obstacles=(MOVED.row.outline(),),
)


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(without(world(), pieces_of(world())), START, width=800, scene=SCENE)


def truth(renderer: Renderer, scene: Scene | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the overview of the truth, and the belief beside it."""
    frame, (width, height), y = renderer.frame(snapshot(scene=scene)), renderer.overview_size, renderer.rows[0]
    first, second = renderer.columns
    return frame[y : y + height, first : first + width], frame[y : y + height, second : second + width]


def at(renderer: Renderer, panel: np.ndarray, x: float, y: float) -> tuple[int, ...]:
    column, row = (round(v) for v in renderer.overview.pixels([(x, y)])[0])
    return tuple(panel[row, column])


def count(image: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((image == colour).all(axis=2).sum())


def test_people_and_closed_doors_are_drawn_on_the_truth_alone(renderer):
    left, right = truth(renderer, SCENE)
    assert count(left, PERSON) > 20 and count(right, PERSON) == 0
    assert count(left, SHUT) > 20 and count(right, SHUT) == 0
    assert at(renderer, left, 4.0, 1.7) == SHUT
    left, _ = truth(renderer, replace(SCENE, people=np.zeros((0, 3)), door_segments=np.zeros((0, 4))))
    assert count(left, PERSON) == count(left, SHUT) == 0


def test_furniture_is_drawn_where_it_stands_now(renderer):
    left, _ = truth(renderer, SCENE)
    assert at(renderer, left, 2.7, 0.7) == type_colour("desk")
    assert at(renderer, left, 0.7, 3.6) in (type_colour("office"), FLOOR)


def test_the_legend_explains_them(renderer):
    still = Renderer(world(), START, width=800)
    assert count(still.frame(snapshot()), PERSON) == 0
    empty = replace(SCENE, people=np.zeros((0, 3)), door_segments=np.zeros((0, 4)))
    legend = renderer.frame(snapshot(scene=empty))[-80:]
    assert count(legend, PERSON) > 20 and count(legend, SHUT) > 20 and count(legend, type_colour("desk")) > 50
