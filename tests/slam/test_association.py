from __future__ import annotations

import math

import numpy as np
import pytest

from slam.association import AMBIGUOUS, CANDIDATES_PER_MEASUREMENT, NEW
from slam.config import SlamConfig
from slam.geometric_update import fuse
from slam.innovation import workspace
from slam.measurement import RegionMeasurement
from slam.region import Subrectangle
from tests.slam.drawn import CLOSED, OPEN, P, associated, mapped, maps, measured, particles

ROOM = [0.0, -2, 2, -1.5, 1.5]
TINY = 1e-4


def room(x: float = 0.0, y: float = 0.0, cov: float = TINY) -> np.record:
    return mapped(ROOM, (x, y), cov)


def seen(
    x: float, y: float = 0.0, w: float = 4.0, h: float = 3.0, phi: float = 0.0, **fields: object
) -> RegionMeasurement:
    return RegionMeasurement(fields.pop("type", "office"), x, y, w, h, phi, **fields)  # type: ignore[arg-type]


def slots(scan: np.ndarray, *regions: np.record, cov: float = 1e-6, p: object = P) -> list[int]:
    links, _, _ = associated(particles(cov=cov), maps(*regions), scan, p)  # type: ignore[arg-type]
    return links["slot"][0].tolist()


def test_every_measurement_finds_its_region_whatever_the_order() -> None:
    scan = measured(seen(6.1), seen(0.1, -0.1), seen(11.9))
    assert slots(scan, room(0), room(6), room(12)) == [1, 0, 2]
    assert slots(scan, room(12), room(0), room(6)) == [2, 1, 0]


def test_a_region_explains_one_measurement_the_better_one() -> None:
    near, nearer = seen(0.3), seen(0.05)
    assert slots(measured(near, nearer), room()) == [AMBIGUOUS, 0]  # a second view of it begins no twin
    assert slots(measured(nearer, near), room()) == [0, AMBIGUOUS]


def test_a_measurement_takes_the_most_likely_region() -> None:
    assert slots(measured(seen(0.3)), room(0), room(0.4)) == [1]


def shifted(distance_squared: float) -> float:
    """How far both ends of a room move for a squared Mahalanobis distance, all else exact."""
    # Ends at x -+ w/2 move together: only the midpoint's variance counts, and the mapped edges' own.
    return math.sqrt(distance_squared * (0.1**2 + 0.5 * TINY + 1e-6))


def test_three_zones() -> None:
    """Below the first gate associated, above the second new, between them neither."""
    p = SlamConfig(gate_associate=100.0, gate_new=300.0).parameters()
    assert slots(measured(seen(shifted(95))), room(), p=p) == [0]
    assert slots(measured(seen(shifted(105))), room(), p=p) == [AMBIGUOUS]
    assert slots(measured(seen(shifted(290))), room(), p=p) == [AMBIGUOUS]
    assert slots(measured(seen(shifted(310))), room(), p=p) == [NEW]
    _, candidates, n = associated(particles(cov=1e-6), maps(room()), measured(seen(shifted(95))), p)
    assert n.tolist() == [1]
    assert candidates[0, 0].distance == pytest.approx(95, rel=0.01)


def test_gates_grow_with_the_uncertainty_of_the_pose() -> None:
    assert slots(measured(seen(2.5)), room()) == [NEW]
    assert slots(measured(seen(2.5)), room(), cov=0.5) == [0]


def test_the_default_gates_are_wide() -> None:
    """Particles are overconfident at loop closure: five standard deviations are the same place, nine no new one."""
    assert slots(measured(seen(0.5)), room()) == [0]
    assert slots(measured(seen(0.9)), room()) == [AMBIGUOUS]


def test_a_doubtful_fit_to_a_region_that_is_taken_is_new() -> None:
    p = SlamConfig(gate_associate=20.0, gate_new=300.0).parameters()
    assert slots(measured(seen(0.0), seen(shifted(100))), room(), p=p) == [0, NEW]
    assert slots(measured(seen(shifted(100))), room(), p=p) == [AMBIGUOUS]


def test_types_do_not_mix_but_other_types_are_candidates() -> None:
    scan = measured(seen(0.0, type="kitchen"))
    links, candidates, n = associated(particles(), maps(room()), scan)
    assert links["slot"].tolist() == [[NEW]]
    assert n.tolist() == [1]
    assert (candidates[0, 0].slot, candidates[0, 0].same_type) == (0, 0)


def test_an_empty_scan_and_an_empty_map() -> None:
    links, _, n = associated(particles(), maps(room()), measured())
    assert links.shape == (1, 0)
    assert n.tolist() == [0]
    assert slots(measured(seen(0), seen(1))) == [NEW, NEW]


def test_a_free_slot_is_no_region() -> None:
    regions = maps(room())
    regions["n"] = 0
    links, _, _ = associated(particles(), regions, measured(seen(0)))
    assert links["slot"].tolist() == [[NEW]]


@pytest.mark.parametrize("heading", [0.0, 1.0, math.pi / 2, 3.0, -2.0])
def test_a_rectangle_is_found_in_every_description(heading: float) -> None:
    """The robot stands in the middle of the room and looks in any direction."""
    robot = particles((0, 0, heading), 1e-6)
    for quarters in range(4):
        w, h = (4.0, 3.0) if quarters % 2 == 0 else (3.0, 4.0)
        scan = measured(seen(0, 0, w, h, -heading + quarters * math.pi / 2))
        links, candidates, _ = associated(robot, maps(room()), scan)
        assert links["slot"].tolist() == [[0]]
        assert candidates[0, 0].distance == pytest.approx(0.0, abs=1e-9)


def test_a_row_read_from_its_other_end_is_found() -> None:
    m = mapped([0, -3, -1, -1, 1, 2, -2, 2], cov=TINY)
    left_first = seen(0.5, 0, 3, 4, left=Subrectangle(2, 2, 0))
    right_first = seen(0.5, 0, 3, 4, math.pi, right=Subrectangle(2, 2, 0))
    for z in (left_first, right_first):
        links, candidates, _ = associated(particles(), maps(m), measured(z))
        assert links["slot"].tolist() == [[0]]
        assert candidates[0, 0].distance == pytest.approx(0.0, abs=1e-9)


def test_rectangles_are_aligned_by_their_closed_edges() -> None:
    """A view of the middle and right rectangles, cut short, of a row of three."""
    m = mapped([0, -6, -2, -1, 1, 3, -2, 2, 7, -1.5, 1.2], cov=TINY)
    z = seen(2.0, 0, 2, 4, l=OPEN, right=Subrectangle(1.5, 2.7, -0.15, end=OPEN))
    links, _, _ = associated(particles(), maps(m), measured(z))
    assert (links[0, 0].slot, links[0, 0].offset) == (0, 1)
    glimpse = seen(5.0, -0.15, 2, 2.7, l=OPEN, r=OPEN)
    links, _, _ = associated(particles(), maps(m), measured(glimpse))
    assert (links[0, 0].slot, links[0, 0].offset) == (0, 2)


def test_a_new_rectangle_along_the_other_axis_turns_the_map() -> None:
    """A room known as one rectangle, 4 wide: it has an alcove above, so as a row it runs along y."""
    m = mapped(ROOM, cov=TINY, open_edges=[4])
    z = seen(0, 0, 3, 4, math.pi / 2, right=Subrectangle(2, 1, 0))  # along y: [-1.5, 1.5], then [1.5, 3.5]
    regions, scan = maps(m), measured(z)
    links, _, _ = associated(particles(), regions, scan)
    assert (links[0, 0].slot, links[0, 0].turn_map, links[0, 0].offset) == (0, 1, 0)


def test_neighbours_that_share_a_wall_stay_apart() -> None:
    """Two rooms side by side, each seen in part: the line of their common walls agrees, their place does not."""
    left = mapped([0, -2, 2, -1.5, 1.5], (0, 0), TINY, open_edges=[1])
    scan = measured(seen(4.0, r=OPEN))
    assert slots(scan, left) == [NEW]


def test_association_leads_to_the_same_map_from_either_end() -> None:
    """Fusing a reversed row must not mirror the region."""
    m = mapped([0, -3, -1, -1, 1, 2, -2, 2], cov=0.01)
    z = seen(0.5, 0, 3, 4, math.pi, right=Subrectangle(2, 2, 0), t=CLOSED)
    scan = measured(z)
    links, _, _ = associated(particles(), maps(m), scan)
    a = links[0, 0]
    fuse(scan[0, a.turn], m, a.offset, np.zeros(3), workspace())
    np.testing.assert_allclose(m.state[:8], [0, -3, -1, -1, 1, 2, -2, 2], atol=1e-9)
    assert m.cov[1, 1] < 0.01


def test_a_glimpse_begins_no_region() -> None:
    """One closed edge of a small patch says too little; two edges or a large patch are enough."""
    patch = {"w": 1.5, "h": 1.5, "l": OPEN, "b": OPEN}
    assert slots(measured(seen(3, r=OPEN, **patch))) == [AMBIGUOUS]
    assert slots(measured(seen(3, **patch))) == [NEW]
    assert slots(measured(seen(3, l=OPEN, b=OPEN, r=OPEN))) == [NEW]


def settled(m: np.record, log_odds: float = 2.0) -> np.record:
    m.type, m.type_log_odds = 1, log_odds
    return m


def test_a_place_whose_type_is_settled_gets_no_hypothesis_of_another_one() -> None:
    """Regions of type 1, measurements of type 0: whole, half, and of half the place."""
    whole, half = seen(0.0), seen(-1.0, w=2.0, r=OPEN)
    assert slots(measured(whole), settled(room())) == [AMBIGUOUS]
    assert slots(measured(half), settled(mapped([0.0, -2, 8, -1.5, 1.5], (0, 0), TINY))) == [AMBIGUOUS]
    assert slots(measured(whole), settled(room(), 1.0)) == [NEW]


def test_a_desk_in_a_settled_office_and_a_room_beside_it_are_new() -> None:
    desk, beside = seen(0.5, 0.5, w=1.6, h=0.8), seen(4.0)
    assert slots(measured(desk, beside), settled(room())) == [NEW, NEW]


def test_of_many_candidates_the_most_likely_are_kept() -> None:
    """Fifteen regions could be the measured one, the right one coming last; a second one has candidates as well."""
    crowd = [room(0.02 * k) for k in range(15)]
    links, _, n = associated(particles(), maps(*crowd, room(9.0), slots=16), measured(seen(0.28), seen(9.0)))
    assert n[0] == CANDIDATES_PER_MEASUREMENT + 1
    assert links["slot"][0].tolist() == [14, 15]
