import subprocess
import sys
from collections import Counter
from itertools import combinations

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from regionslam_env.config import SEMANTIC_TYPES
from regionslam_env.errors import ConfigError
from regionslam_env.worlds.floorplan import distance_to_edges
from regionslam_env.worlds.format import save_world
from regionslam_env.worlds.generate.generator import KINDS, generate
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.reachability import cut_off

FURNITURE = {"desk", "cupboard", "table", "bed", "sofa"}

kinds = st.sampled_from(KINDS)
seeds = st.integers(0, 2**40)
shares = st.floats(0, 1)
worlds = st.builds(
    lambda kind, seed, size, clutter, ambiguity: generate(
        kind, seed, {"size": size, "clutter": clutter, "ambiguity": ambiguity}
    ),
    kinds,
    seeds,
    st.integers(5, 150),
    shares,
    shares,
)
several = settings(max_examples=30, deadline=None, derandomize=True)


def rooms_of(world):
    return [r for r in world.regions if r.parent is None and r.type != "door"]


def inner_corners(row):
    return row.outline() + 1e-6 * np.sign(np.array(row.centre) - row.outline())


@several
@given(worlds)
def test_the_robot_and_larger_ones_get_everywhere(world):
    assert cut_off(world, 0.2) == () and cut_off(world, 0.3) == ()


def test_ways_of_a_campus_lead_away_from_the_building():
    """Here the entrance looks to the middle of the building's depth, beyond which there is another wing."""
    world = generate("campus", 2150, {"size": 108, "clutter": 0.00390625, "ambiguity": 0.671875})
    assert cut_off(world, 0.3) == ()


@several
@given(worlds)
def test_links_join_all_places_and_no_room_is_behind_a_toilet(world):
    graph = networkx.Graph((link.source, link.target) for link in world.links)
    places = [r.id for r in world.regions if r.parent is None]
    assert set(graph) == set(places) and networkx.is_connected(graph)
    without = graph.subgraph(r for r in places if world.region(r).type not in ("toilet", "storage", "elevator"))
    rest = without.subgraph(r for r in without if without.degree(r) or world.region(r).type != "door")
    assert networkx.is_connected(rest)


@several
@given(worlds)
def test_rooms_do_not_overlap_and_furniture_stands_in_its_room(world):
    x0, y0, x1, y1 = world.bounds
    points = np.random.default_rng(0).uniform((x0, y0), (x1, y1), (2000, 2))
    assert np.sum([r.row.contains(points) for r in rooms_of(world)], axis=0).max() == 1
    for item in world.regions:
        assert (item.type in FURNITURE) == (item.parent is not None)
        if item.parent is not None:
            assert world.region(item.parent).row.contains(inner_corners(item.row)).all()


@several
@given(worlds)
def test_doors_open_the_walls_between_their_two_rooms(world):
    for door in world.doors:
        middle = np.array([(door.x0 + door.x1) / 2, (door.y0 + door.y1) / 2])
        assert np.hypot(door.x1 - door.x0, door.y1 - door.y0) >= 0.9 - 1e-9
        assert {link.target for link in world.links_of(door.id)} == set(door.regions)
        for link in world.links_of(door.id):
            name, distance = distance_to_edges(world.region(link.target).row, *middle)
            assert name == link.target_edge and distance == pytest.approx(0, abs=1e-9)
        start, along = world.walls[:, :2], world.walls[:, 2:] - world.walls[:, :2]
        length = np.hypot(*along.T)
        share = np.clip(((middle - start) * along).sum(axis=1) / length**2, 0, 1)
        assert np.hypot(*(start + share[:, None] * along - middle).T).min() >= 0.45 - 1e-9


@several
@given(worlds)
def test_walls_stand_on_the_borders_of_rooms(world):
    for wall in world.walls:
        middle = (wall[:2] + wall[2:]) / 2
        assert min(distance_to_edges(r.row, *middle)[1] for r in rooms_of(world)) < 1e-9


@several
@given(kinds, seeds, st.integers(12, 150))
def test_the_size_is_about_what_was_wished(kind, seed, size):
    assert abs(len(generate(kind, seed, {"size": size}).regions) - size) <= max(6, 0.25 * size)


@pytest.mark.parametrize("kind", KINDS)
def test_from_the_smallest_to_the_large(kind):
    for size in (5, 8, 1000):
        number = len(generate(kind, 1, {"size": size}).regions)
        assert 0.9 * size <= number <= 1.1 * size + 3


@pytest.mark.parametrize(
    ("kind", "usual", "typical"),
    [
        ("office", "office", {"hallway", "meeting room", "kitchen", "toilet"}),
        ("apartment", "bedroom", {"living room", "kitchen", "toilet", "hallway"}),
        ("school", "classroom", {"hallway", "lobby", "toilet", "office"}),
        ("hospital", "ward", {"hallway", "toilet", "office", "service room"}),
        ("campus", "office", {"outdoor", "hallway", "lobby", "classroom"}),
    ],
)
def test_kinds_have_their_rooms(kind, usual, typical):
    counts = Counter(r.type for seed in range(8) for r in rooms_of(generate(kind, seed, {"size": 100})))
    assert set(counts) <= set(SEMANTIC_TYPES) and typical <= set(counts)
    most = [t for t, _ in counts.most_common() if t not in ("hallway", "toilet", "kitchen", "living room", "outdoor")]
    assert most[0] == usual


def test_hallways_branch_and_close_loops_and_rooms_are_not_all_rectangles():
    loops, shapes = 0, Counter()
    for seed in range(12):
        world = generate("office", seed, {"size": 100})
        hallways = {r.id for r in world.regions_of_type("hallway")}
        graph = networkx.Graph(d.regions for d in world.doors if set(d.regions) <= hallways)
        graph.add_edges_from((k.source, k.target) for k in world.links if {k.source, k.target} <= hallways)
        loops += bool(networkx.cycle_basis(graph)) or any(world.region(h).row.n == 3 for h in hallways)
        shapes.update((r.type == "hallway", r.row.n) for r in rooms_of(world))
    assert loops >= 6
    assert shapes[True, 2] + shapes[True, 3] >= 6 and shapes[False, 2] >= 3


def test_clutter_is_furniture_and_ambiguity_is_rooms_that_are_the_same():
    def furniture(clutter):
        return sum(r.parent is not None for r in generate("office", 3, {"size": 80, "clutter": clutter}).regions)

    def twins(ambiguity):
        total = 0
        for seed in range(4):
            world = generate("office", seed, {"size": 100, "ambiguity": ambiguity})
            sizes = [
                tuple(sorted((round(np.ptp(r.row.u), 3), round(r.row.t[0] - r.row.b[0], 3))))
                for r in world.regions_of_type("office")
            ]
            total += sum(a == b for a, b in combinations(sizes, 2))
        return total

    assert furniture(0.0) == 0 and furniture(0.2) < furniture(0.5) < furniture(1.0)
    assert twins(0.0) < twins(0.5) < twins(1.0)


SCRIPT = """
import hashlib, sys, tempfile, pathlib
from regionslam_env.worlds.format import save_world
from regionslam_env.worlds.generate.generator import KINDS, generate
digest = hashlib.sha256()
with tempfile.TemporaryDirectory() as folder:
    for kind in KINDS:
        save_world(generate(kind, 7, {"size": 60, "clutter": 0.7, "ambiguity": 0.4}), f"{folder}/w.geojson")
        digest.update(pathlib.Path(f"{folder}/w.geojson").read_bytes())
print(digest.hexdigest())
"""


def test_every_process_generates_the_same():
    runs = [
        subprocess.run(
            [sys.executable, "-c", SCRIPT],
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": hash_seed, "PYTHONPATH": ":".join(sys.path)},
        ).stdout
        for hash_seed in ("1", "2")
    ]
    namespace = {}
    exec(SCRIPT.replace("print(", "here = ("), namespace)
    assert runs[0] == runs[1] == namespace["here"] + "\n"


def test_the_global_generator_is_left_alone(tmp_path):
    def text(seed):
        np.random.seed(seed)  # noqa: NPY002
        save_world(generate("school", 2), tmp_path / "world.geojson")
        return (tmp_path / "world.geojson").read_bytes()

    assert text(0) == text(1)


def test_another_seed_gives_another_world():
    firsts = [generate("office", seed).walls for seed in range(5)]
    assert not any(np.array_equal(a, b) for a, b in combinations(firsts, 2))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("offise", 0),
            "unknown kind of world 'offise': did you mean 'office'? "
            "Expected one of 'apartment', 'campus', 'hospital', 'office', 'school'",
        ),
        (("office", -1), "world seed is -1, expected a whole number of at least 0"),
        (("office", 1.5), "world seed is 1.5, expected a whole number of at least 0"),
        (("office", 0, {"size": 4}), "world_options.size is 4, expected 5 to 10000 regions"),
        (("office", 0, {"size": 10_001}), "world_options.size is 10001, expected 5 to 10000 regions"),
        (("office", 0, {"size": 30.5}), "world_options.size is 30.5, expected a whole number"),
        (("office", 0, {"clutter": 1.5}), "world_options.clutter is 1.5, expected a share from 0 to 1"),
        (("office", 0, {"ambiguity": float("nan")}), "world_options.ambiguity is nan, expected a finite number"),
        (
            ("office", 0, {"cluter": 0.5}),
            "unknown key of world_options 'cluter': did you mean 'clutter'? "
            "Expected one of 'ambiguity', 'clutter', 'size'",
        ),
        (("office", 0, 7), "world_options is 7, expected a dictionary or WorldOptions"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(arguments, message):
    with pytest.raises(ConfigError) as caught:
        generate(*arguments)
    assert str(caught.value) == message


def test_options_as_a_dictionary_or_as_they_are():
    options = {"size": 20, "clutter": 1}
    assert np.array_equal(generate("office", 4, options).walls, generate("office", 4, WorldOptions(20, 1.0)).walls)
