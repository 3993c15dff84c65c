from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import shapely

from slam.config import SlamConfig
from slam.contact import nearest_edge
from slam.growth import shift_right, take_row
from slam.maps import ADJACENT, FREE_LINKS, INSIDE, Maps, drop, region_of
from slam.measurement import RegionMeasurement, Scan
from slam.paper_form import edge_names
from slam.priors import Priors
from slam.region import REGION, EdgeState, b_index, u_index
from slam.rows import Row
from slam.semantic_update import LIMIT
from slam.topology_update import gain, logit, measured_relations, update_topology
from slam.turning import turn
from tests.slam.drawn import P, links_to, mapped, maps, measured, particles, stored

PRIORS = SlamConfig(prior_link=0.2, link_unseen=0.1, prior_child=0.1).priors()


def log_odds(p: float) -> float:
    return float(np.log(p / (1 - p)))


def evidence_of(*scan: RegionMeasurement) -> np.ndarray:
    out = np.full((len(scan), len(scan), 4), np.nan)
    measured_relations(measured(*scan), Scan(scan).links, 0.1, out)
    return out


def links_of(maps: Maps, slot: int) -> Iterator[np.record]:
    count, index = 0, int(region_of(maps, 0, slot).first_link)
    while index >= 0:
        yield maps.links[index]
        count, index = count + 1, int(maps.next_links[index])
    assert count == region_of(maps, 0, slot).n_links


def believed(maps: Maps, slot: int) -> dict[tuple[int, int], float]:
    """Log-odds by (target, kind)."""
    return {(int(link.target), int(link.kind)): float(link.log_odds) for link in links_of(maps, slot)}


class Two:
    """Two regions of one map, measured together."""

    def __init__(self) -> None:
        self.regions = maps(mapped([0, -2, 2, -1, 1]), mapped([0, -2, 2, -1, 1], (4, 0)))
        self.maps = stored(self.regions)
        self.robots = particles()

    def scan(
        self,
        evidence: dict[tuple[int, int, int], float],
        slots: tuple[int, int] = (0, 1),
        contact: tuple[float, float] = (2.0, 0.0),
        p: Priors = PRIORS,
    ) -> dict[tuple[int, int], float]:
        array = np.zeros((2, 2, 4))
        for place, value in evidence.items():
            array[place] = value
        array[:, :, 2:] = contact
        update_topology(self.robots, self.maps, links_to(*((s, 0, 0, 0) for s in slots)), array, P, p)
        return believed(self.maps, 0)

    def by_edge(self) -> dict[str, float]:
        """Log-odds of the links of the first region by the name of the edge."""
        region, links = region_of(self.maps, 0, 0), list(links_of(self.maps, 0))
        names = edge_names(region)
        found = {names[nearest_edge(region, *link.place)[0]]: float(link.log_odds) for link in links}
        assert len(found) == len(links)
        return found


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
    second = first + log_odds(0.01)
    assert two.scan({(0, 1, INSIDE): log_odds(0.01)}) == {(1, INSIDE): pytest.approx(second)}
    assert two.scan({}) == {(1, INSIDE): pytest.approx(second)}  # nothing is known


def test_a_containment_begins_when_it_is_likely() -> None:
    assert Two().scan({(0, 1, INSIDE): log_odds(0.45)}) == {}


def test_priors_are_those_of_the_types() -> None:
    """Tables are found inside rooms, but not vice versa."""
    config = SlamConfig(
        prior_child={("table", "room"): 0.6, ("room", "table"): 0.02}, prior_link={("room", "table"): 0.3}
    )
    for number, prior in ((config.named_types.index("table"), 0.6), (config.named_types.index("room"), 0.02)):
        two = Two()
        two.regions["type"][0, :2] = number, 1 - number
        links = two.scan({(0, 1, INSIDE): log_odds(0.8)}, p=config.priors())
        assert links == {(1, INSIDE): pytest.approx(log_odds(prior) + log_odds(0.8))}
        two.scan({(0, 1, ADJACENT): log_odds(0.9)}, p=config.priors())
        links = two.scan({}, p=config.priors())
        assert links[1, ADJACENT] == pytest.approx(log_odds(0.9) + log_odds(0.1) - log_odds(0.3))


def test_every_edge_has_its_own_links() -> None:
    """A neighbour around the corner, seen at the right edge, then at the top: there it is new, here it wasn't seen."""
    two = Two()
    two.scan({(0, 1, ADJACENT): 2.0}, contact=(2.0, 0.0))
    assert two.by_edge() == {"r": pytest.approx(2.0)}
    two.scan({(0, 1, ADJACENT): 3.0}, contact=(0.0, 1.0))
    unseen = log_odds(0.1) - log_odds(0.2)
    assert two.by_edge() == {"r": pytest.approx(2.0 + unseen), "t": pytest.approx(3.0)}
    two.scan({(0, 1, ADJACENT): 2.0}, contact=(2.1, -0.9))
    assert two.by_edge() == {
        "r": pytest.approx(2.0 + unseen + 2.0 - log_odds(0.2)),
        "t": pytest.approx(3.0 + unseen),
    }


def test_in_a_corner_noise_makes_no_second_link() -> None:
    two = Two()
    for contact in ((2.0, 0.9), (1.9, 1.0), (2.0, 0.8)):
        two.scan({(0, 1, ADJACENT): 2.0}, contact=contact)
    assert two.by_edge() == {"r": pytest.approx(2.0 + 2 * (2.0 - log_odds(0.2)))}


def test_contacts_come_in_the_frame_of_the_robot() -> None:
    two = Two()
    two.robots["pose"] = 5.0, 0.0, np.pi  # looking back from the right
    two.scan({(0, 1, ADJACENT): 2.0}, contact=(3.0, 0.0))
    assert two.by_edge() == {"r": pytest.approx(2.0)}


def test_links_stay_at_their_edge_when_a_region_is_described_anew() -> None:
    two = Two()
    two.scan({(0, 1, ADJACENT): 2.0})
    turned = np.zeros(1, REGION)
    turn(two.regions[0, 0], 1, turned[0])
    take_row(turned[0], two.regions[0, 0])
    assert two.by_edge() == {"b": pytest.approx(2.0)}  # what was right lies at the bottom of the turned row
    shift_right(two.regions[0, 0])
    m = two.regions[0, 0]
    m.state[u_index(0)], m.state[b_index(0)], m.state[b_index(0) + 1] = m.state[u_index(1)] - 3, -1.0, 1.0
    assert two.by_edge() == {"b": pytest.approx(2.0)}


def test_a_containment_has_no_place() -> None:
    two = Two()
    two.scan({(0, 1, INSIDE): 2.0}, contact=(3.0, 0.0))
    assert [link.place.tolist() for link in links_of(two.maps, 0)] == [[0.0, 0.0]]


def test_a_link_to_a_region_that_is_gone_is_forgotten() -> None:
    two = Two()
    two.scan({(0, 1, ADJACENT): 1.0})
    free = int(two.maps.counts[FREE_LINKS])
    two.maps.slots[1].id = 999  # the slot holds another region now
    assert two.scan({(0, 1, ADJACENT): 2.0}) == {(1, ADJACENT): pytest.approx(2.0)}
    assert two.maps.links[region_of(two.maps, 0, 0).first_link].target_id == 999
    assert two.maps.counts[FREE_LINKS] == free
    drop(two.maps, 0, 1)
    assert two.scan({}, (0, -1)) == {}
    assert two.maps.counts[FREE_LINKS] == free + 1


def test_several_neighbours_hang_on_one_region() -> None:
    regions = maps(*(mapped([0, -2, 2, -1, 1], (4 * i, 0)) for i in range(4)))
    drawn = stored(regions)
    evidence = np.zeros((4, 4, 4))
    evidence[0, 1:, ADJACENT] = 1.0, 2.0, 3.0
    evidence[2, 0, ADJACENT] = 4.0
    update_topology(particles(), drawn, links_to(*((s, 0, 0, 0) for s in range(4))), evidence, P, PRIORS)
    assert believed(drawn, 0) == pytest.approx({(1, ADJACENT): 1.0, (2, ADJACENT): 2.0, (3, ADJACENT): 3.0})
    assert believed(drawn, 2) == pytest.approx({(0, ADJACENT): 4.0})


def bayes(log_odds: float, given: float, prior: float) -> float:
    """Eqs. (16) and (17), probabilities clamped."""
    given = min(max(given, 0.01), 0.99)
    return log_odds + float(np.log(given / (1 - given)) - np.log(prior / (1 - prior)))


def test_gains_against_the_bayes_filter() -> None:
    """Eqs. (14) to (18) by type pair, p(m -> n) either way round, p(m < n) one way only."""
    link, child = {("door", "office"): 0.4}, {("desk", "office"): 0.6}
    for semantics in ("completed", "paper"):
        config = SlamConfig(prior_link=link, prior_child=child, link_unseen=0.15, semantics=semantics)
        p, types = config.priors(), (*config.named_types, "hall")
        rng = np.random.default_rng(0)
        for m, first in enumerate(types):
            for n, second in enumerate(types):
                prior = 0.4 if {first, second} == {"door", "office"} else 0.2
                value = rng.uniform(0.01, 0.99)
                seen = gain(ADJACENT, log_odds(value), m, n, p)
                assert seen == pytest.approx(bayes(0.0, value, prior))
                assert gain(ADJACENT, 0.0, m, n, p) == pytest.approx(bayes(0.0, 0.15, prior))
                prior = 0.6 if (first, second) == ("desk", "office") else 0.1
                # The inverse model (18) completed with the prior: logit (18) + logit p(m < n), clamped before.
                completed = log_odds(value) if semantics == "completed" else bayes(0.0, value, prior)
                assert gain(INSIDE, log_odds(value), m, n, p) == pytest.approx(completed)


def test_not_to_see_a_link_never_speaks_for_it() -> None:
    p = SlamConfig(prior_link=0.05, link_unseen=0.1).priors()
    assert gain(ADJACENT, 0.0, 0, 0, p) == 0.0


def test_nothing_known_of_a_containment_changes_nothing() -> None:
    assert gain(INSIDE, 0.0, 0, 0, PRIORS) == 0.0


def test_measured_links_become_evidence() -> None:
    a = RegionMeasurement("office", 0, 0, 4, 3, links={1: 0.8})
    b = RegionMeasurement("hallway", 0, 4, 20, 2, links={0: 0.5})
    evidence = evidence_of(a, b)
    assert evidence[0, 1, ADJACENT] == pytest.approx(log_odds(0.8))
    assert evidence[1, 0, ADJACENT] == pytest.approx(0.0, abs=1e-9)
    assert evidence[1, 0, ADJACENT] != 0.0  # measured with one half is not the same as not measured
    assert evidence[[0, 1], [1, 0], INSIDE] == pytest.approx(log_odds(0.01))


def test_a_subregion_by_hand() -> None:
    """Eq. (18): a desk of 1.6 x 0.8, three quarters of it inside an office of 16 m^2."""
    desk = RegionMeasurement("desk", 2.0 + 0.4, 0, 1.6, 0.8, t=EdgeState.OPEN)  # [1.6, 3.2], office ends at 2.8
    office = RegionMeasurement("office", 0.8, 0, 4, 4)
    evidence = evidence_of(desk, office)
    assert evidence[0, 1, INSIDE] == pytest.approx(log_odds(0.75))
    assert evidence[1, 0, INSIDE] == pytest.approx(log_odds(0.01))  # 0.06 of the office, times 0.006
    inside = evidence_of(RegionMeasurement("desk", 0.8, 0, 1.6, 0.8), office)
    assert inside[0, 1, INSIDE] == pytest.approx(log_odds(0.99))
    apart = evidence_of(RegionMeasurement("desk", 9.0, 0, 1.6, 0.8), office)
    assert apart[0, 1, INSIDE] == pytest.approx(log_odds(0.01))


def test_a_subregion_against_shapely() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        pair = [RegionMeasurement(t, *rng.normal(0, 0.7, 2), *rng.uniform(0.5, 4, 2), rng.uniform(-1, 1)) for t in "ab"]
        a, b = (shapely.Polygon(Row.from_parameters(z.x, z.y, z.w, z.h, z.phi).rectangles()[0]) for z in pair)
        shared = a.intersection(b).area
        evidence = evidence_of(*pair)[:, :, INSIDE]
        if shared > 0.5 * max(a.area, b.area):
            assert not evidence.any()
            continue
        for place, m, n in (((0, 1), a, b), ((1, 0), b, a)):
            p = min(max(shared / m.area * min(n.area**2 / m.area**2, 1), 0.01), 0.99)
            assert evidence[place] == pytest.approx(log_odds(p), abs=1e-6)


def test_hypotheses_of_one_place_do_not_contain_each_other() -> None:
    office, lab = RegionMeasurement("office", 0, 0, 4, 4), RegionMeasurement("lab", 0.1, 0, 3.8, 4)
    assert not evidence_of(office, lab)[:, :, INSIDE].any()


def test_the_order_of_the_scan_and_the_turn_of_the_pair_do_not_matter() -> None:
    """The same pair under a rotation of the robot, office first."""
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)
    desk = RegionMeasurement("desk", 2.4 * c, 2.4 * s, 1.6, 0.8, angle)
    office = RegionMeasurement("office", 0.8 * c, 0.8 * s, 4, 4, angle + np.pi / 2)
    evidence = evidence_of(office, desk)
    assert evidence[1, 0, INSIDE] == pytest.approx(log_odds(0.75))
    assert evidence[0, 1, INSIDE] == pytest.approx(log_odds(0.01))


def test_linked_regions_and_regions_of_one_type_contain_nothing() -> None:
    door = RegionMeasurement("door", 2.0, 0, 0.2, 0.9, links={1: 0.9})
    office = RegionMeasurement("office", 0, 0, 4, 4)
    assert evidence_of(door, office)[[0, 1], [1, 0], INSIDE] == pytest.approx(log_odds(0.01))
    assert evidence_of(RegionMeasurement("office", 0, 0, 1, 1), office)[0, 1, INSIDE] == 0.0


def test_probabilities_are_clamped_before_log_odds() -> None:
    assert logit(0.0) == pytest.approx(log_odds(0.01))
    assert logit(1.0) == pytest.approx(log_odds(0.99))
    assert logit(0.3) == pytest.approx(log_odds(0.3))
