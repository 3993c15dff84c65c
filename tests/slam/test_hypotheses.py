from __future__ import annotations

import numpy as np

from slam.association import ASSOCIATION, CANDIDATES_PER_MEASUREMENT, associate
from slam.comparison import CANDIDATE
from slam.hypotheses import alternatives, copy_hypotheses, keep_hypotheses
from slam.maps import Maps
from slam.measurement import RegionMeasurement
from slam.particles import ParticleSet
from tests.slam.drawn import P, associated, mapped, maps, measured, near, particles, stored

DOOR = [0.0, -0.5, 0.5, -0.1, 0.1]


def ids_of(cloud: ParticleSet) -> list[list[int]]:
    """Ids of the regions that each hypothesis knows."""
    table = cloud.maps.table
    return [[int(cloud.maps.pool[record].id) for record in row if record >= 0] for row in table[: len(cloud.particles)]]


def hypotheses(*known: int, rows: int = 8) -> ParticleSet:
    """Hypotheses that know so many regions each, the first ones of a row."""
    regions = maps(*(mapped(DOOR, (2.0 * k, 0.0)) for k in range(4)), particles=rows)
    for i in range(rows):
        regions["n"][i, known[i] if i < len(known) else 0 :] = 0
    robots = particles(count=len(known))
    robots["pose"][:, 0] = np.arange(len(known))
    return ParticleSet(robots, stored(regions))


def holders(maps: Maps) -> int:
    return int(maps.holders.sum())


def test_copies_share_the_records_of_their_parents() -> None:
    cloud = hypotheses(1, 2, 3)
    copy_hypotheses(cloud, np.array([0, 2, 2]))
    assert ids_of(cloud) == [[100], [100, 101], [100, 101, 102], [100], [100, 101, 102], [100, 101, 102]]
    assert cloud.particles["pose"][:, 0].tolist() == [0, 1, 2, 0, 2, 2]
    assert holders(cloud.maps) == int((cloud.maps.table >= 0).sum())


def test_the_kept_move_to_the_front_and_the_others_are_forgotten() -> None:
    for kept in ([0, 1, 2, 3], [3], [0, 3], [1, 2], [0], [1, 2, 3], [0, 1]):
        cloud = hypotheses(1, 2, 3, 4)
        places = keep_hypotheses(cloud, np.array(kept))
        assert sorted(places) == kept
        assert cloud.particles["pose"][:, 0].tolist() == places.tolist()
        assert ids_of(cloud) == [[100, 101, 102, 103][: place + 1] for place in places]
        assert (cloud.maps.table[len(kept) :] < 0).all()
        assert holders(cloud.maps) == int((cloud.maps.table >= 0).sum())


def test_two_doors_that_one_could_be_are_two_hypotheses() -> None:
    regions = maps(mapped(DOOR, (3.0, 0.5)), mapped(DOOR, (3.0, -0.6)), mapped(DOOR, (3.0, 4.0)))
    scan = measured(RegionMeasurement("office", 3.0, 0.0, 1.0, 0.2))
    robots = particles(cov=np.diag([0.01, 0.2, 0.001]))
    associations, candidates, n = associated(robots, regions, scan)
    assert associations[0, 0].slot == 0
    drawn = stored(regions)
    others, lacking = alternatives(candidates[0, : n[0]], associations[0], scan, drawn.marks, 4, P)
    assert others["slot"].tolist() == [[1]]
    assert 0.0 < lacking[0] < 1.0
    assert (drawn.marks == -1).all()
    assert len(alternatives(candidates[0, : n[0]], associations[0], scan, drawn.marks, 0, P)[0]) == 0


def test_a_measurement_that_gives_way_leaves_its_region_to_another() -> None:
    """Two doors seen, three mapped in a line: both are one further, or none is."""
    regions = maps(*(mapped(DOOR, (3.0, y)) for y in (0.0, 1.5, 3.0)))
    scan = measured(RegionMeasurement("office", 3.0, 0.7, 1.0, 0.2), RegionMeasurement("office", 3.0, 2.2, 1.0, 0.2))
    robots = particles(cov=np.diag([0.01, 0.5, 0.0001]))
    associations, candidates, n = associated(robots, regions, scan)
    assert associations["slot"].tolist() == [[0, 1]]
    others, _ = alternatives(candidates[0, : n[0]], associations[0], scan, stored(regions).marks, 4, P)
    assert [1, 2] in others["slot"].tolist()


def test_what_is_certain_has_no_alternative() -> None:
    regions = maps(mapped(DOOR, (3.0, 0.5)), mapped(DOOR, (3.0, -2.6)))
    scan = measured(RegionMeasurement("office", 3.0, 0.5, 1.0, 0.2))
    drawn = stored(regions)
    associations = np.zeros((1, 1), ASSOCIATION)
    candidates, n = np.zeros((1, CANDIDATES_PER_MEASUREMENT), CANDIDATE), np.zeros(1, np.int64)
    associate(particles(), drawn, *near(drawn), scan, P, associations, candidates, n)
    assert len(alternatives(candidates[0, : n[0]], associations[0], scan, drawn.marks, 4, P)[0]) == 0
