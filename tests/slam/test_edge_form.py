from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from slam.edge_form import bounding_radius, edge_form, state_size, turn
from slam.measurement import RegionMeasurement, Scan
from slam.region import REGION, Subrectangle
from tests.slam import naive
from tests.slam.drawn import CLOSED, OPEN, mapped, random_measurement, random_state

SHAPES = [(1, False), (2, True), (2, False), (3, True)]


def parameters(z: RegionMeasurement) -> tuple[np.ndarray, np.ndarray]:
    """Mean and block-diagonal covariance of the paper's parameters."""
    mean, blocks = [z.x, z.y, z.w, z.h, z.phi], [z.cov_xy, z.cov_wh, [[z.var_phi]]]
    for sub in (z.left, z.right):
        if sub is not None:
            mean += [sub.w, sub.h, sub.y]
            blocks += [sub.cov_wh, [[sub.var_y]]]
    cov = np.zeros((len(mean), len(mean)))
    at = 0
    for block in blocks:
        block = np.atleast_2d(block)
        cov[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return np.array(mean), cov


@pytest.mark.parametrize(("n", "left"), SHAPES)
def test_edges_and_their_covariance_are_those_of_the_parametrisation(n: int, left: bool) -> None:
    for seed in range(5):
        z = random_measurement(np.random.default_rng(seed), n, left)
        mean, q = parameters(z)
        m = edge_form(Scan([z]).records[0])

        def edges(p: np.ndarray, z: RegionMeasurement = z) -> np.ndarray:
            return naive.edges_from_parameters(p, z.left is not None, z.right is not None)

        size = state_size(n)
        g = naive.derivative(edges, mean)
        np.testing.assert_allclose(m.state[:size], edges(mean), atol=1e-12)
        np.testing.assert_allclose(m.cov[:size, :size], g @ q @ g.T, rtol=1e-6, atol=1e-9)
        assert m.n == n
        assert not m.cov[size:].any()


def test_edge_states_keep_their_place() -> None:
    left = Subrectangle(1, 1, 0, t=OPEN, b=CLOSED, end=OPEN)
    right = Subrectangle(1, 1, 0, t=CLOSED, b=OPEN, end=CLOSED)
    z = RegionMeasurement("hallway", 0, 0, 2, 2, t=CLOSED, b=OPEN, left=left, right=right)
    m = edge_form(Scan([z]).records[0])
    #                       phi u0 u1 b0 t0 u2 b1 t1 u3 b2 t2
    assert m.closed.tolist() == [1, 0, 1, 1, 0, 1, 0, 1, 1, 0, 1]
    assert m.main == 1
    one = edge_form(Scan([RegionMeasurement("office", 0, 0, 2, 2, l=OPEN, t=OPEN)]).records[0])
    assert one.closed[:5].tolist() == [1, 0, 1, 1, 0]


def edge_states(m: np.record) -> set[tuple[float, ...]]:
    """Every line of a row, as a sorted pair of its end points in the plane, with its state."""
    boxes = naive.corners(m.state[: state_size(m.n)], m.anchor)
    out = set()
    for i in range(m.n):
        b = (3, 6, 9)[i]
        u = (1, 2, 5, 8)[i], (1, 2, 5, 8)[i + 1]
        for k, place in enumerate((b, u[1], b + 1, u[0])):
            ends = sorted([tuple(np.round(boxes[i][k], 9) + 0.0), tuple(np.round(boxes[i][(k + 1) % 4], 9) + 0.0)])
            out.add((*ends[0], *ends[1], int(m.closed[place])))
    return out


def turned(m: np.record, quarters: int) -> np.record:
    out = np.zeros(1, REGION)[0]
    turn(m, quarters, out)
    return out


@pytest.mark.parametrize(("n", "quarters"), [(1, 1), (1, 2), (1, 3), (2, 2), (3, 2)])
def test_a_turned_description_is_the_same_place(n: int, quarters: int) -> None:
    rng = np.random.default_rng(n + quarters)
    m = mapped(random_state(rng, n), (1.0, -2.0))
    outer = [1, (2, 5, 8)[n - 1], *range(3, 5), *([6, 7] if n > 1 else []), *([9, 10] if n > 2 else [])]
    m.closed[rng.choice(outer, len(outer) // 2, replace=False)] = 0
    other = turned(m, quarters)
    assert edge_states(other) == edge_states(m)
    assert math.isclose(
        math.remainder(other.state[0] - m.state[0] - quarters * math.pi / 2, 2 * math.pi), 0, abs_tol=1e-12
    )
    main = naive.corners(m.state[: state_size(n)], m.anchor)[m.main].mean(axis=0)
    np.testing.assert_allclose(naive.corners(other.state[: state_size(n)], m.anchor)[other.main].mean(axis=0), main)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_turning_back_restores_everything(n: int) -> None:
    rng = np.random.default_rng(n)
    size = state_size(n)
    m = mapped(random_state(rng, n), (1.0, -2.0), naive.random_covariance(rng, size))
    m.closed[[1, 3]] = 0
    m.main = 0
    for quarters in range(1, 4):
        if quarters == 2 or n == 1:
            back = turned(turned(m, quarters), 4 - quarters)
            np.testing.assert_allclose(back.state[1:], m.state[1:], atol=1e-12)
            np.testing.assert_allclose(back.cov, m.cov, atol=1e-15)
            np.testing.assert_array_equal(back.closed, m.closed)
            assert (back.n, back.main) == (m.n, m.main)
            assert back.state[0] == pytest.approx(m.state[0] + 2 * math.pi)


def test_a_longer_row_has_no_quarter_turn() -> None:
    m = mapped(random_state(np.random.default_rng(0), 2))
    assert turned(m, 1).n == 0
    assert turned(m, 3).n == 0


def test_a_quarter_turn_is_the_rectangle_with_width_and_height_exchanged() -> None:
    z = random_measurement(np.random.default_rng(3), 1, t=OPEN, l=OPEN)
    assert z.cov_wh is not None
    other = dataclasses.replace(
        z, w=z.h, h=z.w, phi=z.phi + math.pi / 2, cov_wh=z.cov_wh[::-1, ::-1], t=OPEN, b=CLOSED, l=CLOSED, r=OPEN
    )  # top becomes right, left becomes top
    ours, theirs = turned(edge_form(Scan([z]).records[0]), 1), edge_form(Scan([other]).records[0])
    np.testing.assert_allclose(ours.state, theirs.state, atol=1e-12)
    np.testing.assert_allclose(ours.cov, theirs.cov, atol=1e-12)
    np.testing.assert_array_equal(ours.closed, theirs.closed)


@pytest.mark.parametrize(("n", "left"), SHAPES)
def test_a_half_turn_is_the_row_read_from_its_other_end(n: int, left: bool) -> None:
    z = random_measurement(np.random.default_rng(4), n, left, t=OPEN)

    def mirrored(sub: Subrectangle | None) -> Subrectangle | None:
        return sub and dataclasses.replace(sub, y=-sub.y, t=sub.b, b=sub.t)

    other = dataclasses.replace(
        z, phi=z.phi + math.pi, left=mirrored(z.right), right=mirrored(z.left), t=z.b, b=z.t, l=z.r, r=z.l
    )
    ours, theirs = turned(edge_form(Scan([z]).records[0]), 2), edge_form(Scan([other]).records[0])
    np.testing.assert_allclose(ours.state, theirs.state, atol=1e-12)
    np.testing.assert_allclose(ours.cov, theirs.cov, atol=1e-12)
    np.testing.assert_array_equal(ours.closed, theirs.closed)
    assert ours.main == theirs.main


def test_bounding_radius_holds_every_corner() -> None:
    for seed in range(10):
        m = mapped(random_state(np.random.default_rng(seed), 1 + seed % 3), (3.0, 4.0))
        corners = naive.corners(m.state[: state_size(m.n)], m.anchor).reshape(-1, 2)
        assert bounding_radius(m) >= np.linalg.norm(corners - m.anchor, axis=1).max() - 1e-12
    assert bounding_radius(mapped([0.7, -3, 2, -1, 4])) == pytest.approx(5.0)
