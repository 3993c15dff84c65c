from collections import Counter

import networkx
import numpy as np
import pytest

from regionslam_env.worlds.floorplan import distance_to_edges
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.loading import load
from regionslam_env.worlds.reachability import unreachable
from tests.worlds.plans import compiled_only


@pytest.fixture(scope="module")
def institute():
    return load("institute")


def test_it_has_the_size_and_variety_of_a_real_floor(institute):
    x0, y0, x1, y1 = institute.bounds
    assert (x1 - x0, y1 - y0) == (60, 25)
    counts = Counter(region.type for region in institute.regions)
    assert sum(n for kind, n in counts.items() if kind not in ("door", "desk", "cupboard", "table")) >= 30
    wanted = (
        "hallway",
        "office",
        "kitchen",
        "laboratory",
        "meeting room",
        "toilet",
        "storage",
        "door",
        "desk",
        "cupboard",
    )
    assert set(wanted) <= set(counts)


def test_hallways_need_two_and_three_rectangles_and_form_a_loop(institute):
    hallways = institute.regions_of_type("hallway")
    assert Counter(h.row.n for h in hallways) == {1: 1, 2: 1, 3: 2}
    graph = networkx.Graph()
    ids = {h.id for h in hallways}
    graph.add_edges_from(door.regions for door in institute.doors if set(door.regions) <= ids)
    assert len(networkx.cycle_basis(graph)) >= 2


@compiled_only
def test_everything_can_be_reached_with_room_to_spare(institute):
    assert unreachable(institute, radius=0.3) == ()


def test_walls_stand_on_the_borders_of_rooms(institute):
    for wall in institute.walls:
        middle = (wall[:2] + wall[2:]) / 2
        rooms = [r for r in institute.regions if r.parent is None and r.type != "door"]
        assert min(distance_to_edges(r.row, *middle)[1] for r in rooms) < 1e-9


def test_doors_open_the_walls_and_are_linked_to_both_rooms(institute):
    for door in institute.doors:
        middle = np.array([(door.x0 + door.x1) / 2, (door.y0 + door.y1) / 2])
        assert institute.region_at(*middle).id == door.id
        assert {link.target for link in institute.links_of(door.id)} == set(door.regions)
        for link in institute.links_of(door.id):
            room = institute.region(link.target)
            name, distance = distance_to_edges(room.row, *middle)
            assert (name, distance) == (link.target_edge, pytest.approx(0, abs=1e-9))


def inner_corners(row):
    """Return the corners of a row, a hair nearer to its middle: borders may coincide but for rounding."""
    return row.outline() + 1e-9 * np.sign(np.array(row.centre) - row.outline())


def test_furniture_stands_in_its_room(institute):
    for item in institute.regions:
        if item.parent is not None:
            assert institute.parent(item.id).row.contains(inner_corners(item.row)).all()


def test_rooms_do_not_overlap(institute):
    rng = np.random.default_rng(0)
    rooms = [r for r in institute.regions if r.parent is None and r.type != "door"]
    points = rng.uniform((0, 0), (60, 25), (4000, 2))
    assert np.sum([r.row.contains(points) for r in rooms], axis=0).max() == 1


@compiled_only
@pytest.mark.parametrize("goal", ["kitchen", "meeting room"])
def test_starts_far_from_the_goal_exist(institute, goal):
    geodesic = Geodesic(institute)
    field = geodesic.field(r.id for r in institute.regions_of_type(goal))
    x, y = geodesic.sample_free(np.random.default_rng(0), field, at_least=20)
    assert 20 <= field.at(x, y) < 100
