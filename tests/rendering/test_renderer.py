from __future__ import annotations

import numpy as np
import pytest

from regionslam_env.rendering import Renderer, Snapshot, draw_map, draw_truth
from regionslam_env.rendering.palette import BELIEF, GOAL, TRUTH, UNSEEN, type_colour
from regionslam_env.rendering.shapes import Shape
from slam.rows import Row
from tests.rendering.scene import world

START = (2.0, 2.0, np.pi / 2)


def snapshot(**changes: object) -> Snapshot:
    # The map frame lies at the start, which looks up: the kitchen is to its right.
    kitchen = Shape(1, "kitchen", "kitchen", Row.from_parameters(0, -5, 4, 6), {"b": False})
    values = {
        "true_pose": START,
        "pose": (0.0, 0.0, 0.0),
        "covariance": np.diag([0.01, 0.01, 0.001]),
        "shapes": (kitchen,),
        "true_path": np.array([(2.0, 1.0), (2.0, 2.0)]),
        "path": np.array([(-1.0, 0.0), (0.0, 0.0)]),
        "lidar": np.full(180, 1.0),
        "goal": "kitchen",
    }
    return Snapshot(**{**values, **changes})


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(world(), START, width=800)


def count(image: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((image == colour).all(axis=2).sum())


def halves(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    top, bottom = 70, image.shape[0] - 90  # without titles and legend
    middle = image.shape[1] // 2
    return image[top:bottom, :middle], image[top:bottom, middle:]


def test_truth_is_on_the_left_and_belief_on_the_right(renderer):
    left, right = halves(renderer.frame(snapshot()))
    assert count(left, type_colour("office")) > 500 and count(right, type_colour("office")) == 0
    assert count(left, TRUTH) > 50 and count(right, TRUTH) == 0
    assert count(right, BELIEF) > 50 and count(left, BELIEF) == 0
    assert count(right, UNSEEN) > 500 and count(left, UNSEEN) == 0


def test_the_belief_is_shown_where_it_lies_in_the_world(renderer):
    size = renderer.overview_size
    (x, y), first = (renderer.columns[1], renderer.rows[0]), renderer.frame(snapshot())
    panel = first[y : y + size[1], x : x + size[0]]
    column, row = (round(v) for v in renderer.overview.pixels([(8.0, 1.0)])[0])
    assert tuple(panel[row, column]) == type_colour("kitchen")
    column, row = (round(v) for v in renderer.overview.pixels([(3.0, 3.7)])[0])
    assert tuple(panel[row, column]) == UNSEEN


def test_goal_regions_are_outlined_on_both_sides(renderer):
    left, right = halves(renderer.frame(snapshot()))
    assert count(left, GOAL) > 100 and count(right, GOAL) > 100
    left, right = halves(renderer.frame(snapshot(goal="office")))
    assert count(left, GOAL) > 100 and count(right, GOAL) == 0  # the mission goes on to what is not known yet


def test_frames_have_one_size_and_share_no_memory(renderer):
    first = renderer.frame(snapshot())
    kept = first.copy()
    second = renderer.frame(snapshot(caption="I am in the kitchen.", title="go", seconds=3.0, shapes=()))
    assert first.shape == second.shape == (renderer.size[1], 800, 3) and first.dtype == np.uint8
    assert (first == kept).all() and (second != first).any()


@pytest.mark.parametrize("width", [640, 641, 800, 802, 1280])
def test_width_and_height_are_even_as_video_codecs_want_them(width):
    height, drawn, _ = Renderer(world(), START, width=width).frame(snapshot()).shape
    assert height % 2 == drawn % 2 == 0 and drawn - width in (0, 1)


def test_the_same_moment_gives_the_same_picture(renderer):
    again = Renderer(world(), START, width=800)
    assert (renderer.frame(snapshot()) == again.frame(snapshot())).all()


def test_a_moment_without_map_path_or_lidar(renderer):
    empty = snapshot(shapes=(), true_path=(), path=(), lidar=None, covariance=np.zeros((3, 3)))
    assert renderer.frame(empty).shape == renderer.frame(snapshot()).shape


def test_a_map_is_drawn_upright_whatever_its_frame():
    def picture(phi: float) -> np.ndarray:
        c, s = np.cos(phi), np.sin(phi)
        rooms = [Shape(k, "office", "office", Row.from_parameters(6 * k * c, 6 * k * s, 6, 4, phi)) for k in range(3)]
        return np.asarray(draw_map(rooms, width=600))

    upright, turned = picture(0.0), picture(0.4)
    assert upright.shape == turned.shape
    assert np.mean(np.abs(upright.astype(int) - turned)) < 2


def test_a_map_lies_on_its_longer_side():
    rooms = [Shape(k, "office", "office", Row.from_parameters(0, 6 * k, 4, 6)) for k in range(3)]
    width, height = draw_map(rooms, width=600).size
    assert width > height


def test_an_empty_map_is_a_picture_too():
    assert draw_map([]).size[0] == 1280


def test_the_true_floor_alone():
    image = np.asarray(draw_truth(world(), goal="kitchen", width=600))
    assert count(image, type_colour("office")) > 1000 and count(image, GOAL) > 100
    assert count(np.asarray(draw_truth(world(), width=600)), GOAL) == 0
