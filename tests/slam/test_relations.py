"""What next to, in front of, in the middle of and at the end of mean, on hand-drawn regions."""

from __future__ import annotations

import math

import pytest

from slam.region import EdgeState, RegionFeature, Subrectangle
from slam.relations import at_the_end_of, end_edges, in_front_of, in_the_middle_of, linked, next_to

OPEN, SUBRECT = EdgeState.OPEN, EdgeState.SUBRECT


def region(x: float, y: float, w: float, h: float, id: int = 1, **fields: object) -> RegionFeature:
    return RegionFeature(id, "office", 0.0, x, y, w, h, fields.pop("phi", 0.0), **fields)  # type: ignore[arg-type]


def test_linked_by_the_belief_of_either() -> None:
    a, b = region(0, 0, 2, 2, id=1, neighbours={"t": {2: -1.0}}), region(50, 0, 2, 2, id=2, neighbours={"l": {1: 0.5}})
    assert linked(a, b) and linked(b, a) and next_to(a, b)
    assert not linked(a, region(50, 0, 2, 2, id=2))


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (region(3, 0, 2, 2, id=2), True),  # faces across 1 m
        (region(3.5, 0, 2, 2, id=2), True),  # 1.5 m
        (region(3.6, 0, 2, 2, id=2), False),
        (region(2, 0, 2, 2, id=2), True),  # shares a wall
        (region(1.8, 0, 2, 2, id=2), True),  # noise makes neighbours overlap
        (region(3, 2.1, 2, 2, id=2), False),  # diagonal: the edges don't face each other
        (region(3, 1.9, 2, 2, id=2), True),
        (region(3, 0, 2, 2, id=2, l=OPEN), False),  # that edge was never seen
        (region(3, 0, 2, 2, id=2, phi=math.pi), True),
        (region(3.4, 0, 2, 2, id=2, phi=math.pi / 4), False),  # turned: no edge faces
        (region(0, 0, 1, 1, id=2), False),  # inside: edges look the same way
        (region(3, 0, 2, 2, id=1), False),  # itself
    ],
)
def test_next_to(other: RegionFeature, expected: bool) -> None:
    a = region(0, 0, 2, 2)
    assert next_to(a, other) is expected
    assert next_to(other, a) is expected


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((0, 1), True),
        ((0, -1), True),  # a door has two sides
        ((0, 2.0), True),
        ((0, 2.2), False),  # beyond 2 m
        ((0.45, 1), True),
        ((1.2, 1), True),  # as far beside as away
        ((1.5, 1), False),
        ((1, 0), False),  # in the wall beside it
        ((0, 0), False),  # inside
    ],
)
def test_in_front_of_a_door(point: tuple[float, float], expected: bool) -> None:
    assert in_front_of(point, region(0, 0, 0.9, 0.2)) is expected


def test_furniture_is_approached_from_its_free_long_sides() -> None:
    room, desk = region(0, 0, 6, 6), region(-2.6, 0, 0.8, 1.6, id=2)  # against the west wall at x = -3
    assert in_front_of((-1.5, 0), desk, room)
    assert not in_front_of((-3.5, 0), desk, room)  # next door
    assert not in_front_of((-2.6, 1.5), desk, room)  # its narrow side
    table = region(0, 0, 1.6, 0.8, id=3)
    assert in_front_of((0, 1), table, room) and in_front_of((0, -1), table, room)
    nook = region(0, 0, 1.0, 6)
    counter = region(0, -1, 1.0, 0.9, id=4)  # only its ends along the nook are free
    assert in_front_of((0, 0), counter, nook)


def test_in_the_middle_is_a_third_of_the_smaller_extent_from_closed_edges() -> None:
    office = region(0, 0, 6, 3)
    assert in_the_middle_of((0, 0), office)
    assert in_the_middle_of((1.9, 0.4), office)
    assert not in_the_middle_of((2.1, 0), office)
    assert not in_the_middle_of((0, 0.6), office)
    assert not in_the_middle_of((9, 0), office)
    assert in_the_middle_of((2.9, 0), region(0, 0, 6, 3, r=OPEN))  # where the view ended is no edge


def test_joints_are_no_edges_of_the_middle() -> None:
    long = region(0, 0, 4, 2, l=SUBRECT, left=Subrectangle(4, 2, 0))
    assert in_the_middle_of((-2, 0), long)


def test_ends_of_hallways() -> None:
    assert [edge.name for edge in end_edges(region(0, 0, 10, 2))] == ["l", "r"]
    assert [edge.name for edge in end_edges(region(0, 0, 2, 10))] == ["t", "b"]
    assert end_edges(region(0, 0, 4, 3)) == ()
    assert [edge.name for edge in end_edges(region(0, 0, 10, 2, l=OPEN))] == ["r"]


def test_ends_of_an_l_and_a_t() -> None:
    """An L ends at its two tips, not at its corner; a T at three."""
    ell = region(0, 0, 10, 2, r=SUBRECT, right=Subrectangle(2, 10, -4))  # the leg goes down from the right end
    assert [edge.name for edge in end_edges(ell)] == ["l", "br"]
    tee = region(0, -4, 2, 10, l=SUBRECT, r=SUBRECT, left=Subrectangle(5, 2, 4), right=Subrectangle(5, 2, 4))
    assert [edge.name for edge in end_edges(tee)] == ["b", "ll", "rr"]


def test_at_the_end_of_a_hallway() -> None:
    hallway = region(0, 0, 20, 2, neighbours={"r": {7: 2.0, 8: -2.0}, "t": {9: 2.0}})
    assert at_the_end_of((9, 0), hallway)
    assert not at_the_end_of((7.9, 0), hallway)
    assert not at_the_end_of((10.5, 0), hallway)  # outside
    far = 60.0
    assert at_the_end_of(region(far, 0, 2, 2, id=7), hallway)  # linked to the end
    assert not at_the_end_of(region(far, 0, 2, 2, id=8), hallway)
    assert not at_the_end_of(region(far, 0, 2, 2, id=9), hallway)  # linked elsewhere
    assert at_the_end_of(region(13, 0, 2, 2, id=3), hallway)  # 2 m beyond
    assert not at_the_end_of(region(13.1, 0, 2, 2, id=3), hallway)
    assert not at_the_end_of(hallway, hallway)
