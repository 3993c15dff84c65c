import numpy as np
import pytest

from regionslam_env.worlds.alignment import align
from slam.rows import Row


def turned(row, angle):
    parameters = row.parameters()
    c, s = np.cos(angle), np.sin(angle)
    parameters["x"], parameters["y"] = c * row.x - s * row.y, s * row.x + c * row.y
    return Row.from_parameters(**{**parameters, "phi": row.phi + angle})


def extent(row, angle):
    """Return lowest x, y, highest x, y in axes turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    points = row.outline() @ np.array([[c, -s], [s, c]])
    return [*points.min(axis=0), *points.max(axis=0)]


@pytest.mark.parametrize("angle", [0.0, 0.4, -1.2])
@pytest.mark.parametrize("phi", [0.0, np.pi / 2, np.pi, -np.pi / 2])
def test_borders_that_nearly_meet_become_one(angle, phi):
    lower = Row.from_parameters(0, 0, 4, 2)
    w, h = (2, 4) if abs(np.cos(phi)) < 0.5 else (4, 2)
    upper = Row.from_parameters(0, 2.2, w, h, phi)
    first, second = align([turned(lower, angle), turned(upper, angle)], angle)
    assert extent(first, angle) == pytest.approx([-2, -1, 2, 1.1])
    assert extent(second, angle) == pytest.approx([-2, 1.1, 2, 3.2])


def test_longer_borders_weigh_more():
    long, short = align([Row.from_parameters(0, 0, 9, 2), Row.from_parameters(0, 2.2, 1, 2)], 0.0)
    assert extent(long, 0)[3] == pytest.approx(1 + 0.2 * 1 / 10)
    assert extent(short, 0)[1] == pytest.approx(1 + 0.2 * 1 / 10)


def test_borders_too_far_apart_or_elsewhere_stay():
    apart = [Row.from_parameters(0, 0, 4, 2), Row.from_parameters(0, 2.4, 4, 2)]
    elsewhere = [Row.from_parameters(0, 0, 4, 2), Row.from_parameters(9, 0.2, 4, 2)]
    for rows in (apart, elsewhere):
        for before, after in zip(rows, align(rows, 0.0), strict=True):
            assert after.parameters() == pytest.approx(before.parameters())


def test_rows_that_are_not_parallel_stay():
    rows = [Row.from_parameters(0, 0, 4, 2), Row.from_parameters(0, 2.1, 4, 2, 0.1)]
    assert align(rows, 0.0)[1] is rows[1]


def test_a_thin_rectangle_is_not_crushed():
    thin = Row.from_parameters(0, 1.1, 4, 0.2)
    after = align([thin, Row.from_parameters(0, 0, 4, 2), Row.from_parameters(0, 2.2, 4, 2)], 0.0)[0]
    assert after.t[0] - after.b[0] >= 0.1


def test_every_line_of_a_longer_row_moves():
    tee = Row(0, 0, 0, np.array([0, 2, 3, 6]), np.array([0, 0, 0]), np.array([1, 4, 1]), 1)
    beside = Row.from_parameters(1, 2.6, 1.9, 3)  # left of the stem: x from 0.05 to 1.95, y from 1.1 to 4.1
    first, second = align([tee, beside], 0.0)
    assert extent(second, 0) == pytest.approx(
        [*(0.05 * 3 / 4, 1 + 0.1 * 1.9 / 3.9), *(2 - 0.05 * 3 / 7, 4 + 0.1 * 1.9 / 2.9)]
    )
    corner = first.to_world([[first.u[1], first.t[0]]])[0]
    assert corner == pytest.approx(extent(second, 0)[2:0:-1])
