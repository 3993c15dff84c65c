import numpy as np
import pytest
import shapely

from regionslam_env.worlds.passages import fit_opening, jambs

LEFT = np.array([(0, 0), (4, 0), (4, 3), (0, 3)], dtype=float)


def right(gap=0.0, low=0.0, high=3.0):
    return np.array([(4 + gap, low), (9, low), (9, high), (4 + gap, high)], dtype=float)


def fitted(second, point, **options):
    return fit_opening("door", ("a", "b"), (LEFT, second), point, **options)


def ends(opening):
    return sorted([(opening.x0, opening.y0), (opening.x1, opening.y1)])


def test_a_door_is_cut_where_it_is_said_to_be():
    opening = fitted(right(), (4, 1.5))
    assert ends(opening) == [pytest.approx((4, 1.05)), pytest.approx((4, 1.95))]
    assert opening.depth == pytest.approx(0.2)
    assert len(jambs(opening)) == 0


def test_a_door_at_a_corner_is_shifted_until_it_fits():
    assert ends(fitted(right(), (4, 3))) == [pytest.approx((4, 1.85)), pytest.approx((4, 2.75))]


def test_a_short_border_takes_a_door_close_to_its_ends():
    assert ends(fitted(right(low=1.0, high=2.0), (4, 1.5))) == [pytest.approx((4, 1.05)), pytest.approx((4, 1.95))]


def test_a_border_too_short_for_a_full_door_takes_a_narrower_one():
    opening = fitted(right(low=1.0, high=1.85), (4, 1.4))
    assert opening.y1 - opening.y0 == pytest.approx(-0.75) or opening.y1 - opening.y0 == pytest.approx(0.75)


def test_a_gap_between_the_borders_makes_a_passage_with_jambs():
    opening = fitted(right(gap=0.5), (4.2, 1.5))
    assert ends(opening) == [pytest.approx((4.25, 1.05)), pytest.approx((4.25, 1.95))]
    assert opening.depth == pytest.approx(0.7)
    for wall, y in zip(sorted(jambs(opening).tolist(), key=lambda w: w[1]), (1.05, 1.95), strict=True):
        assert sorted(wall[::2]) == pytest.approx([4, 4.5])
        assert wall[1::2] == pytest.approx([y, y])


def test_the_border_of_a_third_room_is_not_cut():
    third = shapely.LinearRing([(3, 1.2), (5, 1.2), (5, 1.8), (3, 1.8)])
    low, high = (y for _, y in ends(fitted(right(), (4, 1.4), others=[third])))
    assert high <= 1.2 + 0.02 or low >= 1.8 - 0.02


def test_rooms_without_a_common_border_have_no_door():
    assert fitted(right(gap=2), (5, 1.5)) is None
    assert fitted(right(low=3.5, high=6), (4, 3.2)) is None
