import networkx
import numpy as np
import pytest

from regionslam_env.control.route import route

CENTRES = np.array([(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (2.0, 5.0), (9.0, 9.0)])
"""A room at the robot, a door, a room behind it, a detour, and a region without links."""


def test_the_way_leads_along_the_shortest_links():
    links = [(0, 1), (1, 2), (0, 3), (3, 2)]
    assert route([0], 2, CENTRES, links) == [1, 2]
    assert route([0], 2, CENTRES, [(2, 3), (3, 0)]) == [3, 2]


def test_where_no_links_lead_the_way_is_straight():
    assert route([0], 4, CENTRES, [(0, 1)]) == [4]
    assert route([], 2, CENTRES, [(0, 1), (1, 2)]) == [2]


def test_of_several_regions_around_the_robot_the_best_is_left():
    assert route([0, 1], 2, CENTRES, [(0, 1), (1, 2)]) == [2]


def test_a_region_around_the_robot_is_its_own_way():
    assert route([0], 0, CENTRES, [(0, 1)]) == [0]


@pytest.mark.parametrize("seed", range(5))
def test_the_way_is_as_long_as_that_of_a_reference(seed):
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-10, 10, (12, 2))
    centres[0] = 0
    links = [(a, b) for a in range(12) for b in range(a) if rng.random() < 0.3]
    graph = networkx.Graph()
    graph.add_weighted_edges_from((a, b, np.hypot(*(centres[a] - centres[b]))) for a, b in links)
    graph.add_nodes_from(range(12))
    for target in range(1, 12):
        way = route([0], target, centres, links)
        if networkx.has_path(graph, 0, target):
            length = networkx.path_weight(graph, [0, *way], "weight")
            assert length == pytest.approx(networkx.shortest_path_length(graph, 0, target, "weight"))
        else:
            assert way == [target]
