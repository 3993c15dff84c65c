import numpy as np
import pytest

from regionslam_env.worlds.walls import cut, merge_collinear


def test_shared_borders_become_one_wall():
    merged = merge_collinear([(0, 0, 2, 0), (5, 0, 2, 0), (1, 0, 3, 0), (0, 1, 2, 1)])
    ends = sorted(sorted(map(tuple, wall.reshape(2, 2).tolist())) for wall in merged)
    assert ends == [[(0, 0), (5, 0)], [(0, 1), (2, 1)]]


def test_gaps_on_one_line_stay():
    assert len(merge_collinear([(0, 0, 1, 0), (2, 0, 3, 0)])) == 2


def test_slanted_walls_of_one_line_are_joined():
    merged = merge_collinear([(0, 0, 3, 4), (3, 4, 6, 8)])
    assert np.hypot(*(merged[0, 2:] - merged[0, :2])) == pytest.approx(10)


def test_points_are_no_walls():
    assert len(merge_collinear([(1, 1, 1, 1)])) == 0
    assert merge_collinear(np.empty((0, 4))).shape == (0, 4)


def test_an_opening_is_cut_out_of_the_wall_it_lies_on():
    assert cut([(0, 0, 4, 0)], (1, 0, 2, 0), 0.2) == pytest.approx(np.array([[0, 0, 1, 0], [2, 0, 4, 0]]), abs=1e-6)


def test_walls_beside_the_opening_stay():
    walls = np.array([(0, 0.2, 4, 0.2), (1, 0, 1, 3), (2, 0, 2, -3)], dtype=float)
    assert cut(walls, (1, 0, 2, 0), 0.2).tolist() == walls.tolist()


def test_a_wall_inside_the_opening_is_gone():
    assert len(cut([(1.2, 0, 1.8, 0)], (1, 0, 2, 0), 0.2)) == 0


def test_a_slanted_opening_cuts_a_slanted_wall():
    pieces = cut([(0, 0, 10, 10)], (4, 4, 6, 6), 0.2)
    assert pieces == pytest.approx(np.array([[0, 0, 4, 4], [6, 6, 10, 10]]), abs=1e-6)
