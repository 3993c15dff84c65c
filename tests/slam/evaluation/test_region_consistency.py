"""The normalised error of mapped regions: drawn errors, rigid motions, and every way to describe the truth."""

from __future__ import annotations

import numpy as np
import pytest

from slam.equivalents import equivalents
from slam.evaluation.consistency import nees_band
from slam.evaluation.region_consistency import region_nees
from slam.overlap import overlap_area
from slam.region import EDGE_NAMES, EdgeState, u_index
from slam.rows import Row
from slam.se2 import compose
from tests.slam.drawn import mapped, random_state
from tests.slam.naive import random_covariance

L_SHAPE = Row(0, 0, 0.3, np.array([0.0, 2.0, 5.0]), np.array([0.0, 0.0]), np.array([4.0, 1.5]))
T_SHAPE = Row(1, 2, -0.4, np.array([0.0, 2.0, 3.0, 6.0]), np.array([0.0, -3.0, 0.0]), np.array([2.0, 2.0, 2.0]), main=1)
Z_SHAPE = Row(0, 0, 0.0, np.array([0.0, 2.0, 4.0, 6.0]), np.array([0.0, 1.0, 2.0]), np.array([2.0, 3.0, 4.0]), main=1)
ROOM = Row(3, 1, 0.2, np.array([-2.0, 2.0]), np.array([-1.5]), np.array([1.5]))


def row_of(state: np.ndarray, anchor: tuple[float, float]) -> Row:
    n = (len(state) - 2) // 3
    u = [state[u_index(k)] for k in range(n + 1)]
    return Row(
        *anchor,
        state[0],
        np.array(u),
        state[[3 + 3 * i for i in range(n)]],
        state[[4 + 3 * i for i in range(n)]],
        main=n // 2,
    )


def state_of(row: Row) -> np.ndarray:
    state = [row.phi, row.u[0], row.u[1], row.b[0], row.t[0]]
    for i in range(1, row.n):
        state += [row.u[i + 1], row.b[i], row.t[i]]
    return np.array(state)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_errors_drawn_from_the_stated_covariance_are_chi_square(n: int) -> None:
    rng = np.random.default_rng(n)
    state, size = random_state(rng, n), 2 + 3 * n
    cov = random_covariance(rng, size, 0.05)
    truth = row_of(state, (3.0, -2.0))
    values = []
    for _ in range(400):
        drawn = rng.multivariate_normal(state, cov)
        value, dof = region_nees(mapped(drawn, anchor=(3.0, -2.0), cov=cov), truth)
        assert dof == size
        values.append(value)
    low, high = nees_band(400, size, 0.999)
    assert low < np.mean(values) < high


def test_a_hand_drawn_error() -> None:
    m = mapped([0.2, -2.1, 2.0, -1.5, 1.5], anchor=(3, 1), cov=0.01)
    assert region_nees(m, ROOM) == (pytest.approx(1.0), 5)
    m.closed[1] = 0
    assert region_nees(m, ROOM) == (pytest.approx(0.0, abs=1e-12), 4)


def test_the_anchor_may_lie_anywhere() -> None:
    m = mapped([0.2, -2.0 - 1.0, 2.0 - 1.0, -1.5 - 0.5, 1.5 - 0.5], anchor=ROOM.to_world([[1.0, 0.5]])[0])
    assert region_nees(m, ROOM) == (pytest.approx(0.0, abs=1e-9), 5)


def test_the_frame_of_the_map_does_not_matter() -> None:
    rng = np.random.default_rng(5)
    m = mapped(state_of(T_SHAPE) + rng.normal(0, 0.1, 11), anchor=(1, 2), cov=random_covariance(rng, 11, 0.1))
    value, dof = region_nees(m, T_SHAPE)
    pose = np.array([10.0, -4.0, 2.5])
    x, y, phi = compose(pose, (T_SHAPE.x, T_SHAPE.y, T_SHAPE.phi))
    moved = Row(x, y, phi, T_SHAPE.u, T_SHAPE.b, T_SHAPE.t, main=1)
    assert region_nees(m, moved, pose) == (pytest.approx(value), dof)
    assert region_nees(m, moved)[0] > 100 * value


@pytest.mark.parametrize(("row", "count"), [(ROOM, 4), (L_SHAPE, 4), (T_SHAPE, 4), (Z_SHAPE, 2)])
def test_every_description_covers_the_same_set_and_gives_no_error(row: Row, count: int) -> None:
    found = [description for description, _ in equivalents(row, dict.fromkeys(EDGE_NAMES, EdgeState.CLOSED))]
    assert len(found) == count
    for description in found:
        assert description.area == pytest.approx(row.area)
        assert overlap_area(description, row) == pytest.approx(row.area)
        m = mapped(state_of(description), anchor=(row.x, row.y))
        assert region_nees(m, row) == (pytest.approx(0.0, abs=1e-9), 2 + 3 * description.n)


def test_a_part_is_compared_with_the_part_that_it_shows() -> None:
    # Of three rectangles the middle and the right one were seen, with the left end open.
    m = mapped([0.0, 2.5, 4.0, 1.0, 3.0, 6.0, 2.0, 4.0], open_edges=[1])
    assert region_nees(m, Z_SHAPE) == (pytest.approx(0.0, abs=1e-9), 7)
    m.closed[1] = 1
    assert region_nees(m, Z_SHAPE) == (0.0, 0)


def test_what_cannot_be_the_true_row_has_no_degrees_of_freedom() -> None:
    assert region_nees(mapped([0, -2, 0, -1, 1, 2, -1.5, 1.5]), ROOM) == (0.0, 0)
