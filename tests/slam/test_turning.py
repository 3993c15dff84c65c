"""Quarter turns of regions in edge form against exact rows, and what they do to means and covariances."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.edge_form import edge_form, state_size
from slam.equivalents import Description, equivalents
from slam.measurement import Scan
from slam.region import REGION, EdgeState, Subrectangle
from slam.turning import APART, turn
from tests.slam import naive
from tests.slam.drawn import CLOSED, OPEN, mapped, random_measurement, random_state
from tests.slam.test_equivalents import described, rows

SHAPES = [(1, False), (2, True), (2, False), (3, True)]
L = ([0, 2, 5], [0, 0], [4, 2])
T = ([0, 2, 4, 6], [0, 0, 0], [2, 5, 2])
U = ([0, 1, 3, 4], [0, 0, 0], [3, 1, 3])


def record(description: Description, cov: np.ndarray | float = 1e-4) -> np.record:
    """A region of an exact row."""
    row, states = description
    state, closed = [row.phi], [True]
    bounds = {0: "l" if row.main == 0 else "ll", row.n: "r" if row.main == row.n - 1 else "rr"}
    for k, u in enumerate(row.u):
        state.append(u)
        closed.append(k not in bounds or states[bounds[k]] != EdgeState.OPEN)
        if k > 0:
            side = "" if k - 1 == row.main else "lr"[k - 1 > row.main]
            state += [row.b[k - 1], row.t[k - 1]]
            closed += [states[name + side] != EdgeState.OPEN for name in "bt"]
    m = mapped(state, (row.x, row.y), cov, [k for k, known in enumerate(closed) if not known])
    m.main = row.main
    return m


def turned(m: np.record, quarters: int) -> np.record:
    out = np.zeros(1, REGION)[0]
    turn(m, quarters, out)
    return out


@settings(max_examples=200, deadline=None)
@given(rows(), st.integers(0, 3))
def test_turns_are_the_equivalent_descriptions(drawn: Description, quarters: int) -> None:
    """All shapes, all edge states: the kernel finds a turn if and only if there is one by the set of cells."""
    row, states = drawn
    n_lines = {0: row.n, 1: 0}[quarters % 2]  # along its own axis a row keeps the joints it has
    expected = [
        (r, s)
        for r, s in equivalents(row, states)
        if round((r.phi - row.phi) / (math.pi / 2)) == quarters and (n_lines == 0 or r.n == n_lines)
    ]
    m = record(drawn)
    other = turned(m, quarters)
    assert other.n == (expected[0][0].n if expected else 0)
    if expected:
        r, s = expected[0]
        theirs = record((r, s))
        size = state_size(r.n)
        np.testing.assert_allclose(other.state[:size], theirs.state[:size], atol=1e-9)
        np.testing.assert_array_equal(other.closed[:size], theirs.closed[:size])


def naive_turn(state: np.ndarray, cov: np.ndarray, lines: list[list[int]], rows: list[tuple[int, float]]) -> tuple:
    """Condition on the edges of a line being equal; then a linear map, copies with a share of their own."""
    constraints = []
    for line in lines:
        for other in line[1:]:
            h = np.zeros(len(state))
            h[line[0]], h[other] = 1.0, -1.0
            constraints.append(h)
    h = np.array(constraints).reshape(-1, len(state))
    gain = cov @ h.T @ np.linalg.inv(h @ cov @ h.T) if constraints else np.zeros((len(state), 0))
    mean, cov = state - gain @ h @ state, cov - gain @ h @ cov
    a = np.zeros((len(rows), len(state)))
    for i, (source, sign) in enumerate(rows):
        a[i, source] = sign
    out = a @ cov @ a.T
    sources = [source for source, _ in rows]
    for i, source in enumerate(sources):
        if sources.count(source) > 1:
            out[i, i] += APART * cov[source, source]
    return a @ mean, out


@pytest.mark.parametrize(
    ("shape", "lines", "across"),
    [
        # phi, then u0 u1 b0 t0 u2 b1 t1 of the turned row, each by its entry of the row before and its sign
        (L, [[3, 6]], [(0, 1), (3, 1), (7, 1), (5, -1), (1, -1), (4, 1), (2, -1), (1, -1)]),
        (T, [[3, 6, 9], [4, 10]], [(0, 1), (3, 1), (4, 1), (8, -1), (1, -1), (7, 1), (5, -1), (2, -1)]),
    ],
)
def test_edges_of_one_line_are_estimated_as_one(
    shape: tuple, lines: list[list[int]], across: list[tuple[int, float]]
) -> None:
    rng = np.random.default_rng(0)
    m = record(described(*shape))
    size = state_size(m.n)
    m.cov[:size, :size] = naive.random_covariance(rng, size, 0.1)
    m.state[1:size] += 0.1 * rng.standard_normal(size - 1)
    mean, cov = naive_turn(m.state[:size].copy(), m.cov[:size, :size].copy(), lines, across)
    mean[0] += math.pi / 2
    other = turned(m, 1)
    np.testing.assert_allclose(other.state[: len(mean)], mean, atol=1e-12)
    np.testing.assert_allclose(other.cov[: len(mean), : len(mean)], cov, atol=1e-12)
    assert np.linalg.eigvalsh(other.cov[: len(mean), : len(mean)]).min() > 0
    back = turned(turned(m, 1), 3)
    np.testing.assert_allclose(back.state[1:size], turned(back, 0).state[1:size], atol=1e-12)
    assert back.n == m.n
    for line in lines:
        assert np.ptp(back.state[line]) < 0.05  # once one line, edges stay together


def test_a_step_beyond_its_uncertainty_is_one() -> None:
    """Bottoms 0.3 m apart: one line as long as either may be off by that, and else a row of three strips."""
    m = record(described([0, 2, 5], [0, 0.3], [4, 2]), 0.1**2)
    assert turned(m, 1).n == 2
    m = record(described([0, 2, 5], [0, 0.3], [4, 2]), 0.03**2)
    assert turned(m, 1).n == 3
    assert turned(record(described(*U)), 1).n == 0


def test_a_thin_row_has_no_turn() -> None:
    """Its bottom and top are too near to be told apart."""
    assert turned(record(described([0, 2, 5], [0, 0], [0.2, 2]), 0.1**2), 1).n == 0


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


def test_a_quarter_turn_is_the_rectangle_with_width_and_height_exchanged() -> None:
    z = random_measurement(np.random.default_rng(3), 1, t=OPEN, l=OPEN)
    assert z.cov_wh is not None
    other = dataclasses.replace(
        z, w=z.h, h=z.w, phi=z.phi + math.pi / 2, cov_wh=z.cov_wh[::-1, ::-1], t=OPEN, b=CLOSED, l=CLOSED, r=OPEN
    )  # top becomes right, left becomes top
    ours, theirs = turned(edge_form(Scan([z]).records[0]), 1), edge_form(Scan([other]).records[0])
    assert math.cos(ours.state[0] - theirs.state[0]) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(ours.state[1:], theirs.state[1:], atol=1e-12)
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
    assert math.cos(ours.state[0] - theirs.state[0]) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(ours.state[1:], theirs.state[1:], atol=1e-12)
    np.testing.assert_allclose(ours.cov, theirs.cov, atol=1e-12)
    np.testing.assert_array_equal(ours.closed, theirs.closed)
    assert ours.main == theirs.main
