import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from regionslam_env.envs import GoToEnv
from regionslam_env.observations import LINK_COLUMNS, RegionColumn, link_table, region_table
from regionslam_env.wrappers import EdgeKind, GraphObservation
from tests.env.believed import Believed
from tests.env.wrappers.still import TYPES, Still
from tests.floors import two_rooms


def rooms():
    """An office around the robot, a kitchen, a door that leads to both, and a doubtful other inside the office."""
    built = Believed(TYPES)
    built.put(0, 10, "office").put(1, 11, "kitchen", at=(5.0, 0.0)).put(3, 12, "door", at=(1.0, 0.0), u=(-0.1, 0.1))
    built.put(4, 13, "other", at=(-0.5, 0.0), u=(-0.1, 0.1), b=(-0.1,), t=(0.1,), existence=0.6)
    return built.link(0, 3, p=0.9).link(3, 1, p=0.8).link(4, 0, kind=1, p=0.7)


def padded(graph, columns, n_slots):
    """Return the tables and masks that a graph stands for."""
    regions = np.zeros((n_slots, columns["regions"].stop - columns["regions"].start), np.float32)
    mask = np.zeros(n_slots, np.int8)
    slots = graph.nodes[:, columns["slot"]].ravel().astype(int)
    regions[slots[1:]], mask[slots[1:]] = graph.nodes[1:, columns["regions"]], 1
    links = np.zeros((4 * n_slots, LINK_COLUMNS), np.float32)
    links_mask = np.zeros(4 * n_slots, np.int8)
    count = 0
    for (p, kind), (first, second) in zip(graph.edges, graph.edge_links, strict=True):
        if kind != EdgeKind.PRESENCE:
            links[count], links_mask[count] = (slots[first], slots[second], p, kind), 1
            count += 1
    return regions, mask, links, links_mask


def check_round_trip(wrapper, graph, observation):
    regions, mask, links, links_mask = padded(graph, wrapper.columns, len(observation["regions_mask"]))
    assert (regions == region_table(observation)).all() and (links == link_table(observation)).all()
    assert (mask == observation["regions_mask"]).all() and (links_mask == observation["links_mask"]).all()
    for key in set(observation) - {"regions", "regions_mask", "links", "links_mask", "lidar"}:
        assert (graph.nodes[0, wrapper.columns[key]] == observation[key]).all()


def test_a_graph_says_what_the_padded_tables_say():
    env = Still(rooms())
    wrapper = GraphObservation(env)
    graph, _ = wrapper.reset()
    assert graph in wrapper.observation_space
    assert len(graph.nodes) == 1 + 4
    assert env.shown["links_mask"].sum() == 3
    check_round_trip(wrapper, graph, env.shown)


def test_the_robot_is_linked_to_where_it_may_be():
    wrapper = GraphObservation(Still(rooms()))
    graph, _ = wrapper.reset()
    present = graph.edges[:, 1] == EdgeKind.PRESENCE
    ends = graph.edge_links[present]
    assert (ends[:, 0] == 0).all()
    contains_me = graph.nodes[:, wrapper.columns["regions"]][:, RegionColumn.CONTAINS_ME]
    assert dict(zip(ends[:, 1].tolist(), graph.edges[present, 0].tolist(), strict=True)) == {
        k: p for k, p in enumerate(contains_me.tolist()) if p > 0
    }
    assert 1 in ends[:, 1]


def test_a_sector_holds_its_nearest_obstacle():
    wrapper = GraphObservation(Still(rooms(), ranges=np.where(np.arange(72) == 37, 0.5, 9.0)))
    graph, _ = wrapper.reset()
    lidar = graph.nodes[0, wrapper.columns["lidar"]]
    assert len(lidar) == 36 and lidar[18] == 0.5 and (np.delete(lidar, 18) == 9.0).all()
    assert not graph.nodes[1:, wrapper.columns["lidar"]].any() and not graph.nodes[0, wrapper.columns["regions"]].any()


def test_an_empty_map_is_a_robot_alone():
    wrapper = GraphObservation(Still(Believed(TYPES)))
    graph, _ = wrapper.reset()
    assert len(graph.nodes) == 1 and graph.edges is None and graph.edge_links is None
    assert graph in wrapper.observation_space


@pytest.mark.compiled
def test_gymnasium_accepts_it_and_it_survives_a_drive():
    env = GoToEnv(world=two_rooms())
    wrapper = GraphObservation(env)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version.*")
        warnings.filterwarnings("ignore", message=".*not having a spec.*")
        check_env(wrapper)
    observation, _ = env.reset(seed=1)
    for _ in range(40):
        observation, *_ = env.step(np.float32([0.6, 0.2]))
        graph = wrapper.observation(observation)
        if graph.edges is not None:
            check_round_trip(wrapper, graph, observation)
    assert graph in wrapper.observation_space and len(graph.nodes) > 3


def test_wrapping_what_does_not_fit_is_refused():
    with pytest.raises(TypeError, match="expected a Dict with regions"):
        GraphObservation(gymnasium.make("CartPole-v1"))
