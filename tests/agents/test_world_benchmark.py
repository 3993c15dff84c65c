from dataclasses import replace

import numpy as np
import pytest

from agents.world_benchmark import CHECKS, benchmark_worlds, judge
from regionslam_env.worlds.generate.generator import KINDS, generate
from regionslam_env.worlds.reachability import cut_off, unreachable
from tests.floors import two_rooms

compiled_only = pytest.mark.compiled


@compiled_only
def test_a_small_sample_of_every_kind_holds():
    result = benchmark_worlds(5)
    assert set(result["worlds_per_minute"]) == set(KINDS)
    for row in result["kinds"].values():
        assert [row[check] for check in CHECKS] == [1.0] * 4 and row["failed"] == {}
        assert row["worlds_per_minute"] == pytest.approx(60_000 / row["generation_ms"]["median"])
        assert 25 <= row["regions"]["least"] <= row["regions"]["most"] <= 35


@compiled_only
def test_a_wall_across_the_door_is_found():
    world = two_rooms()
    closed = replace(world, walls=np.concatenate([world.walls, [[6, 1, 6, 3]]]))
    assert judge(world) == dict.fromkeys(CHECKS, True)
    assert not judge(closed)["reachable"] and judge(closed)["connected"]
    assert cut_off(closed) == unreachable(closed) and len(cut_off(closed)) >= 1


@compiled_only
def test_missing_links_are_found():
    world = two_rooms()
    assert not judge(replace(world, links=world.links[:1]))["connected"]


@compiled_only
def test_grid_steps_and_distances_agree():
    for kind in KINDS:
        world = generate(kind, 3, {"size": 30, "clutter": 1.0})
        assert cut_off(world) == unreachable(world) == ()


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_thousand_worlds_are_valid_connected_and_free(kind):
    row = benchmark_worlds(1000, size=40, kinds=[kind])["kinds"][kind]
    assert row["failed"] == {}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_ten_thousand_regions_are_valid_and_connected(kind):
    row = benchmark_worlds(1, size=10_000, kinds=[kind])["kinds"][kind]
    assert row["failed"] == {} and row["regions"]["least"] > 9000
