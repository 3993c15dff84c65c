"""Equivalent descriptions of rows: the shapes of the paper, and any row on a small grid against its set of cells."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.edges import row_edges
from slam.equivalents import Description, equivalents
from slam.overlap import iou
from slam.region import EdgeState
from slam.rows import Row

OPEN, CLOSED, SUBRECT = EdgeState.OPEN, EdgeState.CLOSED, EdgeState.SUBRECT


def described(u: list[float], b: list[float], t: list[float], main: int | None = None, opened: str = "") -> Description:
    """A row with some edges open, by their names."""
    n = len(b)
    main = n // 2 if main is None else main
    states = {"t": CLOSED, "b": CLOSED, "l": CLOSED if main == 0 else SUBRECT, "r": SUBRECT if main < n - 1 else CLOSED}
    states |= {"tl": CLOSED, "bl": CLOSED, "ll": CLOSED} if main > 0 else {}
    states |= {"tr": CLOSED, "br": CLOSED, "rr": CLOSED} if main < n - 1 else {}
    states |= dict.fromkeys(opened.split(), OPEN)
    return Row(1.0, -2.0, 0.3, np.array(u, float), np.array(b, float), np.array(t, float), main), states


def shapes(found: list[Description]) -> list[tuple[int, int]]:
    """Number of rectangles and of quarter turns of each description."""
    return sorted((row.n, round((row.phi - 0.3) / (math.pi / 2)) % 4) for row, _ in found)


SHAPES = {
    "rectangle": (([0, 4], [0], [3]), [(1, 0), (1, 1), (1, 2), (1, 3)]),
    "L": (([0, 2, 5], [0, 0], [4, 2]), [(2, 0), (2, 1), (2, 2), (2, 3)]),
    "T along its bar": (([0, 2, 4, 6], [0, 0, 0], [2, 5, 2]), [(2, 1), (2, 3), (3, 0), (3, 2)]),
    "T along its stem": (([0, 2, 5], [-3, -1], [3, 1]), [(2, 0), (2, 2), (3, 1), (3, 3)]),
    "Z": (([0, 2, 4], [0, 1], [3, 5]), [(2, 0), (2, 2), (3, 1), (3, 3)]),
    "plus": (([0, 2, 4, 6], [2, 0, 2], [4, 6, 4]), [(3, 0), (3, 1), (3, 2), (3, 3)]),
    "U": (([0, 1, 3, 4], [0, 0, 0], [3, 1, 3]), [(3, 0), (3, 2)]),
    "stairs": (([0, 1, 2, 3], [0, 1, 2], [3, 4, 5]), [(3, 0), (3, 2)]),
    "apart": (([0, 1, 2], [0, 2], [1, 3]), [(2, 0), (2, 2)]),
    "touching in a corner": (([0, 1, 2], [0, 1], [1, 2]), [(2, 0), (2, 2)]),
    "idle joint": (([0, 1, 3], [0, 0], [2, 2]), [(1, 0), (1, 1), (1, 2), (1, 3), (2, 0), (2, 2)]),
    "L with an idle joint": (
        ([0, 2, 5, 6], [0, 0, 0], [4, 2, 2]),
        [(2, 0), (2, 1), (2, 2), (2, 3), (3, 0), (3, 2)],
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_and_their_descriptions(name: str) -> None:
    row, expected = SHAPES[name]
    assert shapes(equivalents(*described(*row))) == expected


def test_edges_keep_their_states() -> None:
    """An L whose right arm is open at its end, and whose upper arm is open at its left."""
    row, states = described([0, 2, 5], [0, 0], [4, 2], main=0, opened="rr l")
    ways = {round((r.phi - 0.3) / (math.pi / 2)) % 4: (r, s) for r, s in equivalents(row, states)}
    assert sorted(ways) == [0, 1, 2, 3]
    across, across_states = ways[1]  # along +v: the lower slab, 5 wide, then the upper one, 2 wide
    np.testing.assert_array_equal(across.u, [0, 2, 4])
    np.testing.assert_array_equal(across.b, [-5, -2])
    np.testing.assert_array_equal(across.t, [0, 0])
    assert across.main == 0
    expected = {"t": OPEN, "b": OPEN, "l": CLOSED, "r": SUBRECT, "tr": OPEN, "br": CLOSED, "rr": CLOSED}
    assert across_states == expected


@pytest.mark.parametrize("opened", ["b", "br", "tr"])
def test_states_that_one_line_cannot_hold_are_no_description(opened: str) -> None:
    """Of an L: bottoms that differ are no line of one state, and where the arm's top is open no joint is known."""
    row, states = described([0, 2, 5], [0, 0], [4, 2], main=0, opened=opened)
    assert shapes(equivalents(row, states)) == [(2, 0), (2, 2)]


@st.composite
def rows(draw: st.DrawFn) -> Description:
    """Rows on a small grid, so that edges coincide often, in any edge states."""
    n = draw(st.integers(1, 3))
    u = np.cumsum([0, *draw(st.lists(st.integers(1, 2), min_size=n, max_size=n))])
    b = draw(st.lists(st.integers(0, 2), min_size=n, max_size=n))
    t = [low + draw(st.integers(1, 3)) for low in b]
    main = draw(st.integers(0, n - 1)) if n == 2 else n // 2
    row, states = described(list(u), b, t, main)
    for name in states:
        if states[name] != SUBRECT and draw(st.integers(0, 3)) == 0:
            states[name] = OPEN
    return row, states


def outline_states(row: Row, states: dict[str, EdgeState]) -> dict[tuple[float, ...], bool]:
    """Whether the outline is closed at quarters of the grid, by points on it."""
    out: dict[tuple[float, ...], bool] = {}
    for edge in row_edges(row, states):
        start, normal = np.array(edge.start), np.array(edge.normal)
        along = np.array([-normal[1], normal[0]])
        for step in np.arange(0.25, edge.length, 0.5):
            point = start + step * along
            beyond = row.contains([point + 1e-6 * normal, point - 1e-6 * normal])
            if beyond[0] != beyond[1]:
                key = tuple(np.round(point, 6) + 0.0)
                out[key] = edge.state != OPEN
    # The end of a subrectangle that faces the main one is no edge by name: what of it is outline is a known line.
    for k in range(1, row.n):
        for v in np.arange(min(row.b) + 0.25, max(row.t), 0.5):
            point = row.to_world([[row.u[k], v]])[0]
            sides = row.contains(row.to_world([[row.u[k] - 1e-6, v], [row.u[k] + 1e-6, v]]))
            if sides[0] != sides[1]:
                out[tuple(np.round(point, 6) + 0.0)] = True
    return out


@settings(max_examples=150, deadline=None)
@given(rows())
def test_every_description_is_the_same_place(drawn: Description) -> None:
    row, states = drawn
    found = equivalents(row, states)
    expected = outline_states(row, states)
    for other, other_states in found:
        assert iou(row, other) == pytest.approx(1.0)
        assert outline_states(other, other_states) == expected
        assert len(equivalents(other, other_states)) >= 2
    keys = {(r.n, tuple(np.round(r.u, 6)), round((r.phi - 0.3) / (math.pi / 2)) % 4) for r, _ in found}
    assert len(keys) == len(found)


@settings(max_examples=100, deadline=None)
@given(rows())
def test_the_row_itself_and_its_other_end_are_among_them(drawn: Description) -> None:
    row, states = drawn
    found = equivalents(row, states)
    own = [s for r, s in found if r.n == row.n and r.phi == row.phi and np.array_equal(r.u, row.u)]
    assert own == [states]
