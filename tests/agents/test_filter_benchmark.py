from __future__ import annotations

import numpy as np
import pytest

from agents import filter_benchmark as benchmark

pytestmark = pytest.mark.compiled


def test_a_floor_is_mapped_whole_and_once() -> None:
    floor, slam = benchmark.mapped(60)
    regions = slam.belief.map.regions
    assert len(regions) == 60
    np.testing.assert_allclose(np.sort([r.x for r in regions]), np.sort(floor.places[:, 0]), atol=1e-6)


def test_particles_share_the_map_until_they_write_to_it() -> None:
    floor, slam = benchmark.standing(5, 60)
    maps = slam.belief.maps
    assert len(slam.belief.map) == 60
    assert (maps.table[0] == maps.table).all()
    slam.step(benchmark.STILL, floor.scan(floor.seen_from(0.0, 0.0, 3)))
    own = (maps.table[:, : maps.counts[0]] != maps.table[0, : maps.counts[0]])[1:]
    assert len(slam.belief.map) == 60
    assert (own.sum(axis=1) == 3).all()


def test_every_part_takes_its_time(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = benchmark.by_part(particles=2, measurements=3, regions=30, steps=5)
    assert set(parts) == {
        *("look up", "association", "proposal", "draw", "semantics", "geometry", "topology", "existence", "duplicates")
    }
    assert parts["association"] > 0
    assert benchmark.time_steps(2, 3, 30, repeats=2, seconds=0.001) > 0


def test_the_memory_of_particles_that_drove_apart() -> None:
    stored = benchmark.memory(particles=4, regions=200, steps=6)
    assert stored["driven"] == 3.0
    assert stored["used_megabytes"] <= stored["megabytes"]
    assert stored["used_megabytes"] < stored["unshared_megabytes"]
