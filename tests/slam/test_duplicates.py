from __future__ import annotations

import numpy as np
import pytest

from slam.config import Parameters, SlamConfig
from slam.duplicates import are_rivals, resolve_duplicates, share_place
from slam.measurement import MeasurementNoise
from tests.slam.drawn import P, forget_dropped, links_to, mapped, maps, near, stored

SCAN = 12
ROOM = [0.0, -2, 2, -1.5, 1.5]


def resolve(regions: np.ndarray, *slots: int, p: Parameters = P) -> None:
    """Resolve after a scan that measured these slots."""
    for turn in range(len(slots)):
        regions["last_seen"][0, list(slots)] = SCAN + turn
        drawn = stored(regions)
        resolve_duplicates(drawn, *near(drawn), links_to(*((s, 0, 0, 0) for s in slots)), SCAN + turn, p)
        forget_dropped(regions, drawn)


def test_twins_become_one_older_region() -> None:
    regions = maps(mapped(ROOM, (0.3, 0), 0.02), mapped(ROOM, (0, 0), 0.02))
    regions["id"][0, :2] = 200, 100
    regions["sightings"][0, :2] = 4, 3
    regions["existence"][0, :2] = 1.0, 2.0
    resolve(regions, 0)
    assert regions["n"][0, :2].tolist() == [0, 1]
    m = regions[0, 1]
    assert (m.id, m.sightings, m.existence) == (100, 7, 2.0)
    np.testing.assert_allclose(m.anchor[0] + m.state[1:3], [-1.85, 2.15], atol=1e-6)  # half way
    np.testing.assert_allclose(np.diag(m.cov)[1:5], 0.01, atol=1e-3)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_twins_in_different_descriptions_become_one(quarters: int) -> None:
    turned = [0.0, -1.5, 1.5, -2, 2] if quarters % 2 else ROOM
    turned = [quarters * np.pi / 2, *turned[1:]]
    regions = maps(mapped(ROOM, (0, 0), 0.02), mapped(turned, (0.2, 0.1), 0.02))
    resolve(regions, 1)
    assert regions["n"][0, :2].tolist() == [1, 0]
    m = regions[0, 0]
    np.testing.assert_allclose(m.state[:5], [0, -1.9, 2.1, -1.45, 1.55], atol=1e-6)


def test_a_twin_gives_its_closed_edges_to_an_open_one() -> None:
    """Two halves of a room with one common wall, one closed on the left, one on the right."""
    first = mapped(ROOM, (0, 0), 0.01, open_edges=[2])
    first.state[2] = 1.0
    second = mapped(ROOM, (0, 0), 0.01, open_edges=[1])
    second.state[1] = -1.0
    regions = maps(first, second)
    resolve(regions, 0)
    m = regions[0, 0]
    assert regions["n"][0, :2].tolist() == [1, 0]
    np.testing.assert_allclose(m.state[1:3], [-2, 2], atol=1e-4)
    assert m.closed[:5].all()


def test_what_a_scan_confirms_is_compared_before_the_robot_leaves() -> None:
    regions = maps(mapped(ROOM, (0.3, 0), 0.02), mapped(ROOM, (0, 0), 0.02), mapped(ROOM, (10, 0), 0.02))
    regions["id"][0, :3] = 200, 100, 300
    for sightings, left in ((P.confirmed_after - 1, [1, 1, 1]), (P.confirmed_after, [0, 1, 1])):
        regions["sightings"][0, 0] = sightings
        regions["last_seen"][0, [0, 2]] = SCAN + 1
        drawn = stored(regions)
        resolve_duplicates(drawn, *near(drawn), links_to(*((s, 0, 0, 0) for s in (0, 2))), SCAN + 1, P)
        forget_dropped(regions, drawn)
        assert regions["n"][0, :3].tolist() == left


def test_neighbours_stay() -> None:
    regions = maps(mapped(ROOM, (0, 0), 0.01), mapped(ROOM, (4.0, 0), 0.01), mapped(ROOM, (0, 3), 0.01))
    resolve(regions, 0)
    assert regions["n"][0, :3].tolist() == [1, 1, 1]


def test_two_regions_of_one_scan_are_two() -> None:
    regions = maps(mapped(ROOM, (0.2, 0), 0.02), mapped(ROOM, (0, 0), 0.02))
    resolve(regions, 0, 1)
    assert regions["n"][0, :2].tolist() == [1, 1]


def test_desks_back_to_back_stay_two_whatever_the_noise() -> None:
    """The noisier the sensor, the farther apart estimates of one place may be; but a second desk stands by the wall."""
    desk = [0.0, -0.8, 0.8, -0.4, 0.4]
    noisy = SlamConfig(measurement_noise=MeasurementNoise(0.3, 0.3, 0.05)).parameters()
    regions = maps(mapped(desk, (0, 0), 0.02), mapped(desk, (0.5, 0.8), 0.02))
    resolve(regions, 0, p=noisy)
    assert regions["n"][0, :2].tolist() == [1, 1]


def contradicting(*sightings: int) -> np.ndarray:
    """Twins off by more than their covariances allow: an older one with two open edges, and a closed one."""
    regions = maps(mapped(ROOM, (0, 0), 1e-5, open_edges=[2, 4]), mapped(ROOM, (0.8, 0.3), 1e-5))
    regions["sightings"][0, :2] = sightings
    return regions


def test_twins_that_contradict_each_other_become_one_all_the_same() -> None:
    """Drift between two visits: metres decide, and the richer geometry is kept under the older identity."""
    regions = contradicting(3, 4)
    resolve(regions, 0)
    assert regions["n"][0, :2].tolist() == [1, 0]
    m = regions[0, 0]
    assert (m.id, m.sightings) == (100, 4)  # sightings of the other one do not count for it
    np.testing.assert_allclose(m.anchor, [0.8, 0.3])
    assert m.closed[:5].all()


@pytest.mark.parametrize(("sightings", "kept"), [((1, 4), 1), ((4, 1), 0), ((1, 1), 0)])
def test_of_contradicting_twins_a_confirmed_one_is_kept_else_the_one_just_seen(
    sightings: tuple[int, int], kept: int
) -> None:
    """An invented region inside a real one must not take its place for having all edges closed."""
    regions = contradicting(*sightings)
    resolve(regions, 0)
    assert regions["n"][0, :2].tolist() == [1, 0]
    np.testing.assert_allclose(regions[0, 0].anchor, [(0, 0), (0.8, 0.3)][kept])


def test_regions_that_overlap_by_noise_stay() -> None:
    regions = maps(mapped(ROOM, (0, 0), 0.01), mapped(ROOM, (3.4, 0), 0.01))
    resolve(regions, 0)
    assert regions["n"][0, :2].tolist() == [1, 1]


def hypotheses(*log_odds: float) -> np.ndarray:
    """Regions of different types at one place."""
    regions = maps(*(mapped(ROOM, (0.05 * k, 0), 0.01) for k in range(len(log_odds))))
    regions["type"][0, : len(log_odds)] = range(len(log_odds))
    regions["type_log_odds"][0, : len(log_odds)] = log_odds
    return regions


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2), (1, 2, 0), (0,), (1,), (2,)])
def test_of_three_types_only_the_most_credible_stands(order: tuple[int, ...]) -> None:
    """Whichever of them was measured, and wherever they stand in the map."""
    for log_odds in ((3.0, 1.0, -1.0), (1.0, 3.0, -1.0), (-1.0, 1.0, 3.0)):
        regions = hypotheses(*log_odds)
        resolve(regions, *range(3))
        resolve(regions, *order)
        standing = [k for k in range(3) if regions["rival"][0, k] < 0]
        assert standing == [int(np.argmax(log_odds))]


def test_a_tentative_hypothesis_does_not_outdo_a_confirmed_one() -> None:
    """Or nothing would stand at the place: tentative regions are not handed out."""
    regions = hypotheses(-1.0, 3.0)
    regions["sightings"][0, :2] = 5, 1
    resolve(regions, 0, 1)
    assert regions["rival"][0, :2].tolist() == [-1, 0]
    regions["sightings"][0, 1] = 5
    resolve(regions, 0, 1)
    assert regions["rival"][0, :2].tolist() == [1, -1]


def test_the_lead_can_change() -> None:
    regions = hypotheses(2.0, 1.0)
    resolve(regions, 0)
    assert regions["rival"][0, :2].tolist() == [-1, 0]
    regions["type_log_odds"][0, :2] = 1.0, 2.0
    resolve(regions, 1)
    assert regions["rival"][0, :2].tolist() == [1, -1]


def test_a_rival_that_is_gone_is_forgotten() -> None:
    regions = hypotheses(2.0, 1.0)
    resolve(regions, 0)
    regions["n"][0, 0] = 0
    resolve(regions, 1)
    assert regions["rival"][0, 1] == -1
    regions = hypotheses(2.0, 1.0)
    resolve(regions, 0)
    regions[0, 0] = mapped(ROOM, (30, 0))  # the slot was reused far away
    resolve(regions, 1)
    assert regions["rival"][0, 1] == -1


def test_a_desk_is_no_rival_of_its_office() -> None:
    regions = hypotheses(2.0, 1.0)
    regions[0, 1] = mapped([0, -0.8, 0.8, -0.4, 0.4])
    regions[0, 1].type = 1
    assert not are_rivals(regions[0, 0], regions[0, 1], 0.3)
    resolve(regions, 0)
    assert regions["rival"][0, :2].tolist() == [-1, -1]


def test_sharing_a_place() -> None:
    assert share_place(mapped(ROOM), mapped(ROOM, (1.5, 0)), 0.3)
    assert not share_place(mapped(ROOM), mapped(ROOM, (2.5, 0)), 0.3)
    assert share_place(mapped([0, -10, 10, -1, 1]), mapped(ROOM, (8, 0)), 0.3)  # one centre suffices
