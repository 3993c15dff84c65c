from __future__ import annotations

import numpy as np
import pytest

from regionslam_env.rendering.panel import Panel, Viewport

WHITE, BLACK, RED = (255, 255, 255), (0, 0, 0), (255, 0, 0)


def test_the_viewport_turns_y_upwards():
    view = Viewport.fit((0, 0, 10, 5), (120, 70), margin=10)
    assert view.scale == 10
    assert view.pixels([(0, 0), (10, 5), (0, 5)]) == [(10, 60), (110, 10), (10, 10)]


def test_the_narrower_side_decides_the_scale_and_the_rest_is_centred():
    view = Viewport.fit((0, 0, 10, 5), (120, 200), margin=10)
    assert view.pixels([(5, 2.5)]) == [(60, 100)]
    assert view.scale == 10


def test_points_of_a_turned_frame():
    view = Viewport.centred(0, 0, 10, (100, 100)).seen_from((1.0, 2.0, np.pi / 2))
    # One metre ahead of a pose that looks up: (1, 3) in the world.
    assert view.pixels([(1.0, 0.0)]) == [pytest.approx((60, 20))]


def test_a_polygon_fills_exactly_its_pixels():
    panel = Panel((10, 10), WHITE)
    panel.polygon([(2, 2), (6, 2), (6, 6), (2, 6)], RED)
    image = np.asarray(panel.finish())
    assert (image[3, 3] == RED).all() and (image[8, 8] == WHITE).all() and (image[3, 8] == WHITE).all()


def test_a_dashed_segment_has_gaps_and_dashes_at_both_ends():
    panel = Panel((100, 10), WHITE)
    panel.dashes((10, 5), (90, 5), BLACK, 2)
    dark = np.asarray(panel.finish())[:, :, 0].min(axis=0) < 128
    assert dark[11] and dark[88]
    inked = np.flatnonzero(np.diff(dark[10:90].astype(int)))
    assert len(inked) >= 16  # at least eight gaps
    assert not dark[:9].any() and not dark[92:].any()


def test_dots_lie_around_their_centres():
    panel = Panel((20, 10), WHITE)
    panel.dots([(5, 5), (15, 5)], BLACK)
    ink = 255 - np.asarray(panel.finish())[:, :, 0].astype(float)
    assert ink.sum() == pytest.approx(2 * 13 / 4 * 255, rel=0.02)  # 13 of 4 times as many pixels each
    assert (ink * np.arange(20)).sum() / ink.sum() == pytest.approx(10 - 0.5, abs=0.3)


def test_a_panel_goes_on_from_another_one_without_changing_it():
    base = Panel((10, 10), WHITE)
    panel = Panel((10, 10), base)
    panel.polygon([(0, 0), (10, 0), (10, 10), (0, 10)], BLACK)
    assert (np.asarray(base.finish()) == 255).all()
    assert (np.asarray(panel.finish())[2:8, 2:8] == 0).all()


BELOW, ABOVE, RIGHT, LEFT = (0, 22), (0, -22), (32, 0), (-32, 0)


@pytest.mark.parametrize(
    ("taken", "place"),
    [([], BELOW), ([BELOW], ABOVE), ([BELOW, ABOVE], RIGHT), ([BELOW, ABOVE, RIGHT], LEFT)],
    ids=["below", "above", "right", "left"],
)
@pytest.mark.parametrize("by", ["text", "disc"])
def test_a_text_beside_a_mark_takes_the_first_place_that_is_free(taken, place, by):
    panel = Panel((200, 200), WHITE)
    for x, y in taken:
        if by == "text":
            panel.text(100 + x, 100 + y, "hall", BLACK, 12)
        else:
            panel.keep_clear((100 + x, 100 + y), 5)
    panel.text_beside((100, 100), 12, "start", RED, 15, WHITE)
    image = np.asarray(panel.finish()).astype(int)
    y, x = np.nonzero(image[:, :, 0] - image[:, :, 1] > 128)
    assert (x.mean() - 100, y.mean() - 100) == pytest.approx(place, abs=4)


def test_a_text_beside_a_mark_stays_in_the_panel():
    panel = Panel((200, 110), WHITE)  # no room below
    panel.text_beside((100, 100), 12, "start", RED, 15, WHITE)
    image = np.asarray(panel.finish()).astype(int)
    assert np.nonzero(image[:, :, 0] - image[:, :, 1] > 128)[0].mean() == pytest.approx(78, abs=4)


@pytest.mark.parametrize("size", [(200, 40), (200, 100)], ids=["beside", "above or below"])
def test_texts_move_aside_for_the_robot_and_stay_in_the_panel(size):
    plain, moved = Panel(size, WHITE), Panel(size, WHITE)
    middle = (size[0] / 2, size[1] / 2)
    for panel in (plain, moved):
        panel.text(*middle, "kitchen", BLACK, 12)
    moved.keep_clear(middle, 8)
    y, x = np.mgrid[: size[1], : size[0]]
    disc = np.hypot(x - middle[0], y - middle[1]) < 8
    before, after = (np.asarray(panel.finish())[:, :, 0] < 128 for panel in (plain, moved))
    assert (before & disc).any() and not (after & disc).any()
    assert after.sum() == before.sum()
