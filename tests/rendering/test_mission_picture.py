import numpy as np
import pytest

from regionslam_env.rendering import Snapshot, Stop, draw_mission
from regionslam_env.rendering.palette import BELIEF, GOAL, TRUTH, UNSEEN, text_width, type_colour
from regionslam_env.rendering.panel import Panel
from regionslam_env.rendering.shapes import Shape
from slam.rows import Row
from tests.rendering.scene import world

START = (2.0, 2.0, np.pi / 2)  # the map frame looks up: the kitchen is to its right
KITCHEN = Shape(1, "kitchen", "kitchen", Row.from_parameters(0, -5, 4, 6))


def picture(stops=(), goal="kitchen", caption="") -> np.ndarray:
    end = Snapshot(
        true_pose=(8.0, 2.0, 0.0),
        pose=(0.0, -6.0, -np.pi / 2),
        covariance=np.eye(3),
        shapes=(KITCHEN,),
        true_path=np.array([(2.0, 2.0), (8.0, 2.0)]),
        path=np.array([(0.0, 0.0), (0.0, -6.0)]),
        title="“go to the kitchen”",
        caption=caption,
        goal=goal,
    )
    return np.asarray(draw_mission(world(), START, end, stops, width=900))


def count(image: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((image == colour).all(axis=2).sum())


def panels(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return image[90:240, :450], image[90:240, 450:]  # above caption and legend


def test_truth_and_belief_lie_side_by_side_with_their_paths():
    left, right = panels(picture())
    assert count(left, type_colour("office")) > 500 and count(right, type_colour("office")) == 0
    assert count(left, TRUTH) > 300 and count(right, TRUTH) == 0
    assert count(right, BELIEF) > 300 and count(left, BELIEF) == 0
    assert count(right, UNSEEN) > 500 and count(left, GOAL) > 100 and count(right, GOAL) > 100


def test_the_believed_path_lies_where_it_was_driven_when_the_belief_is_right():
    left, right = panels(picture())
    driven, believed = (
        np.flatnonzero((half == colour).all(axis=2).any(axis=0)) for half, colour in ((left, TRUTH), (right, BELIEF))
    )
    assert driven.max() - driven.min() > 200
    assert (driven - 20 == believed - 10).all()  # left edges of the panels


def test_a_stop_has_its_number_on_both_sides_and_its_words_below():
    plain = picture()
    marked = picture([Stop("go to the kitchen", (6.0, 2.0, 0.0), (0.0, -4.0, 0.0))])
    changed = (plain != marked).any(axis=2)
    left, right = panels(changed)
    assert left.any() and right.any() and changed[260:].any()
    assert (picture(caption="done") != plain).any()


def test_a_mission_of_no_type_highlights_nothing():
    assert count(picture(goal=None), GOAL) == 0


@pytest.mark.parametrize("y", [0.6, 1.4, 2.2, 3.0, 3.4])
def test_the_start_covers_no_other_label(y, monkeypatch):
    drawn: list[Panel] = []
    finish = Panel.finish
    monkeypatch.setattr(Panel, "finish", lambda panel: (drawn.append(panel), finish(panel))[1])
    end = Snapshot((2.0, y, 0.0), (0.0, 0.0, 0.0), np.eye(3), true_path=[(2.0, y)], path=[(0.0, 0.0)])
    draw_mission(world(), (2.0, y, 0.0), end, [], width=900)
    labels = {text: (x, y, text_width(text, size) / 2, size / 2) for x, y, text, _, size, _ in drawn[0]._texts}
    x, y, half, high = labels.pop("start")
    assert "office 1" in labels
    assert all(abs(x - a) >= half + w or abs(y - b) >= high + h for a, b, w, h in labels.values())
