"""Where regions touch, against shapely and by hand."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from slam.contact import REACH, contact, nearest_edge
from slam.paper_form import edge_places, row_of
from slam.region import u_index
from tests.slam.drawn import mapped, random_state

OFFICE = [0.0, -3.0, 3.0, -2.0, 2.0]
ROW = [0.0, -8.0, -2.0, -1.0, 1.0, 2.0, -2.0, 2.0, 7.0, -1.0, 1.5]
"""Three rectangles: left [-8, -2] x [-1, 1], main [-2, 2] x [-2, 2], right [2, 7] x [-1, 1.5]."""


def edge_name(m: np.record, point: tuple[float, float]) -> str:
    place, _, _ = nearest_edge(m, *point)
    return {k: name for name, k in edge_places(m).items()}[place]


@pytest.mark.parametrize(
    ("neighbour", "anchor", "point", "edge"),
    [
        ([0.0, -0.45, 0.45, -0.1, 0.1], (1.0, 2.0), (1.0, 2.0), "t"),  # a door in the wall
        ([0.0, -0.1, 0.1, -0.45, 0.45], (3.0, -1.0), (3.0, -1.0), "r"),
        (
            [0.0, -1.0, 39.0, 0.0, 2.0],
            (0.0, 2.1),
            (1.0 - 0.15, 2.0),
            "t",
        ),  # a hallway that begins at -1 m, wall between
        ([0.0, -1.0, 1.0, -1.0, 1.0], (0.0, 9.0), (0.0, 2.0), "t"),  # out of reach
        ([0.0, -2.0, 0.0, -1.0, 1.0], (-3.0, 0.0), (-3.0, 0.0), "l"),
    ],
)
def test_a_contact_by_hand(
    neighbour: list[float], anchor: tuple[float, float], point: tuple[float, float], edge: str
) -> None:
    office = mapped(OFFICE)
    found = contact(office, mapped(neighbour, anchor), 0.1)
    assert found == pytest.approx(point, abs=1e-9)
    assert edge_name(office, found) == edge


@pytest.mark.parametrize(
    ("point", "edge"),
    [
        ((0, 3), "t"),
        ((0, -3), "b"),
        ((-5, 2), "tl"),
        ((-5, -2), "bl"),
        ((-9, 0), "ll"),
        ((5, 2), "tr"),
        ((5, -2), "br"),
        ((8, 0), "rr"),
        ((6.9, 0.2), "rr"),
    ],
)
def test_edges_of_three_rectangles(point: tuple[float, float], edge: str) -> None:
    assert edge_name(mapped(ROW), point) == edge


def test_a_joint_is_no_edge() -> None:
    m = mapped([0.0, -2.0, 0.0, -1.0, 1.0, 2.0, -1.0, 1.0])
    place, x, y = nearest_edge(m, 0.0, 0.1)
    assert place != u_index(1)
    assert (x, y) == pytest.approx((0.0, 1.0))


def test_contacts_lie_on_the_longest_edge_within_reach() -> None:
    rng = np.random.default_rng(0)
    for _ in range(100):
        a = mapped(random_state(rng, int(rng.integers(1, 4))), rng.normal(0, 1, 2))
        b = mapped(random_state(rng, 1), rng.normal(0, 5, 2))
        reach = 0.1 * REACH
        u0, u1, v0, v1 = b.state[1:5]
        grown = mapped([b.state[0], u0 - reach, u1 + reach, v0 - reach, v1 + reach], b.anchor)
        within = shapely.Polygon(row_of(grown).rectangles()[0])
        row, rectangles = row_of(a), row_of(a).rectangles()
        sides = [(i, k) for i in range(row.n) for k in range(4) if k in (0, 2) or (k, i) in ((1, row.n - 1), (3, 0))]
        edges = [shapely.LineString([rectangles[i][k], rectangles[i][(k + 1) % 4]]) for i, k in sides]
        parts = [edge.intersection(within) for edge in edges]
        longest = max(parts, key=lambda part: part.length)
        found = shapely.Point(contact(a, b, 0.1))
        if longest.length > 0:
            assert found.distance(longest.interpolate(0.5, normalized=True)) < 1e-6
        else:
            centre = shapely.Point(row_of(b).centre)
            assert found.distance(centre) == pytest.approx(min(edge.distance(centre) for edge in edges))
