from __future__ import annotations

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.maps import ADJACENT, FREE_LINKS, INSIDE, Maps, drop, region_of
from slam.measurement import RegionMeasurement, Scan
from slam.region import EdgeState
from slam.semantic_update import LIMIT
from slam.topology_update import logit, measured_relations, update_topology
from tests.slam.drawn import links_to, mapped, maps, measured, stored

P = SlamConfig(prior_link=0.2, link_unseen=0.1, prior_child=0.1).parameters()


def log_odds(p: float) -> float:
    return float(np.log(p / (1 - p)))


def evidence_of(*scan: RegionMeasurement) -> np.ndarray:
    out = np.full((len(scan), len(scan), 2), np.nan)
    measured_relations(measured(*scan), Scan(scan).links, out)
    return out


def believed(maps: Maps, slot: int) -> dict[tuple[int, int], float]:
    """Log-odds by (target, kind), newest first; each pair must appear once."""
    found: dict[tuple[int, int], float] = {}
    index = int(region_of(maps, 0, slot).first_link)
    while index >= 0:
        link = maps.links[index]
        assert (int(link.target), int(link.kind)) not in found
        found[int(link.target), int(link.kind)] = float(link.log_odds)
        index = int(link.next)
    assert len(found) == region_of(maps, 0, slot).n_links
    return found


class Two:
    """Two regions of one map, measured together."""

    def __init__(self) -> None:
        self.regions = maps(mapped([0, -2, 2, -1, 1]), mapped([0, -2, 2, -1, 1], (4, 0)))
        self.maps = stored(self.regions)

    def scan(
        self, evidence: dict[tuple[int, int, int], float], slots: tuple[int, int] = (0, 1)
    ) -> dict[tuple[int, int], float]:
        array = np.zeros((2, 2, 2))
        for place, value in evidence.items():
            array[place] = value
        update_topology(self.maps, links_to(*((s, 0, 0, 0) for s in slots)), array, P)
        return believed(self.maps, 0)


def test_a_link_by_hand() -> None:
    """Eq. (16): from the prior 0.2, measured with 0.9, then with 0.7, then not measured (p_0 = 0.1)."""
    two = Two()
    first = log_odds(0.2) + log_odds(0.9) - log_odds(0.2)
    assert two.scan({(0, 1, ADJACENT): log_odds(0.9)}) == {(1, ADJACENT): pytest.approx(first)}
    second = first + log_odds(0.7) - log_odds(0.2)
    assert two.scan({(0, 1, ADJACENT): log_odds(0.7)}) == {(1, ADJACENT): pytest.approx(second)}
    third = second + log_odds(0.1) - log_odds(0.2)
    assert two.scan({}) == {(1, ADJACENT): pytest.approx(third)}
    assert believed(two.maps, 1) == {}  # links are directed


def test_nothing_changes_where_one_region_was_not_measured() -> None:
    """Eq. (15)."""
    two = Two()
    before = two.scan({(0, 1, ADJACENT): 1.0})
    for slots in ((0, -1), (-2, 1), (-1, -1)):
        assert two.scan({(0, 1, ADJACENT): 5.0, (1, 0, ADJACENT): 5.0}, slots) == before


def test_links_are_clamped() -> None:
    two = Two()
    for _ in range(20):
        links = two.scan({(0, 1, ADJACENT): 4.0})
    assert links == {(1, ADJACENT): LIMIT}
    for _ in range(40):
        links = two.scan({})
    assert links == {(1, ADJACENT): -LIMIT}


def test_containment_by_hand() -> None:
    """Eqs. (17) and (18) with the prior once: 0.1, then evidence 0.9, then none at all (clamped to 0.01)."""
    two = Two()
    first = log_odds(0.1) + log_odds(0.9)
    assert two.scan({(0, 1, INSIDE): log_odds(0.9)}) == {(1, INSIDE): pytest.approx(first)}
    assert two.scan({}) == {(1, INSIDE): pytest.approx(first + log_odds(0.01))}


def test_a_link_to_a_region_that_is_gone_is_forgotten() -> None:
    two = Two()
    two.scan({(0, 1, ADJACENT): 1.0})
    free = int(two.maps.counts[FREE_LINKS])
    two.maps.slots[1].id = 999  # the slot holds another region now
    assert two.scan({(0, 1, ADJACENT): 2.0}) == {(1, ADJACENT): 2.0}
    assert two.maps.links[region_of(two.maps, 0, 0).first_link].target_id == 999
    assert two.maps.counts[FREE_LINKS] == free
    drop(two.maps, 0, 1)
    assert two.scan({}, (0, -1)) == {}
    assert two.maps.counts[FREE_LINKS] == free + 1


def test_several_neighbours_hang_on_one_region() -> None:
    regions = maps(*(mapped([0, -2, 2, -1, 1], (4 * i, 0)) for i in range(4)))
    drawn = stored(regions)
    evidence = np.zeros((4, 4, 2))
    evidence[0, 1:, ADJACENT] = 1.0, 2.0, 3.0
    evidence[2, 0, ADJACENT] = 4.0
    update_topology(drawn, links_to(*((s, 0, 0, 0) for s in range(4))), evidence, P)
    assert believed(drawn, 0) == {(1, ADJACENT): 1.0, (2, ADJACENT): 2.0, (3, ADJACENT): 3.0}
    assert believed(drawn, 2) == {(0, ADJACENT): 4.0}


def test_measured_links_become_evidence() -> None:
    a = RegionMeasurement("office", 0, 0, 4, 3, links={1: 0.8})
    b = RegionMeasurement("hallway", 0, 4, 20, 2, links={0: 0.5})
    evidence = evidence_of(a, b)
    assert evidence[0, 1, ADJACENT] == pytest.approx(log_odds(0.8))
    assert evidence[1, 0, ADJACENT] == pytest.approx(0.0, abs=1e-9)
    assert evidence[1, 0, ADJACENT] != 0.0  # measured with one half is not the same as not measured
    assert not evidence[:, :, INSIDE].any()


def test_a_subregion_by_hand() -> None:
    """Eq. (18): a desk of 1.6 x 0.8, three quarters of it inside an office of 16 m^2."""
    desk = RegionMeasurement("desk", 2.0 + 0.4, 0, 1.6, 0.8, t=EdgeState.OPEN)  # [1.6, 3.2], office ends at 2.8
    office = RegionMeasurement("office", 0.8, 0, 4, 4)
    evidence = evidence_of(desk, office)
    assert evidence[0, 1, INSIDE] == pytest.approx(log_odds(0.75))
    assert evidence[1, 0, INSIDE] == 0.0
    inside = evidence_of(RegionMeasurement("desk", 0.8, 0, 1.6, 0.8), office)
    assert inside[0, 1, INSIDE] == pytest.approx(log_odds(0.99))


def test_the_order_of_the_scan_and_the_turn_of_the_pair_do_not_matter() -> None:
    """The same pair under a rotation of the robot, office first."""
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)
    desk = RegionMeasurement("desk", 2.4 * c, 2.4 * s, 1.6, 0.8, angle)
    office = RegionMeasurement("office", 0.8 * c, 0.8 * s, 4, 4, angle + np.pi / 2)
    evidence = evidence_of(office, desk)
    assert evidence[1, 0, INSIDE] == pytest.approx(log_odds(0.75))
    assert evidence[0, 1, INSIDE] == 0.0


def test_linked_regions_and_regions_of_one_type_contain_nothing() -> None:
    door = RegionMeasurement("door", 2.0, 0, 0.2, 0.9, links={1: 0.9})
    office = RegionMeasurement("office", 0, 0, 4, 4)
    assert evidence_of(door, office)[0, 1, INSIDE] == 0.0
    assert evidence_of(RegionMeasurement("office", 0, 0, 1, 1), office)[0, 1, INSIDE] == 0.0


def test_probabilities_are_clamped_before_log_odds() -> None:
    assert logit(0.0) == pytest.approx(log_odds(0.01))
    assert logit(1.0) == pytest.approx(log_odds(0.99))
    assert logit(0.3) == pytest.approx(log_odds(0.3))
