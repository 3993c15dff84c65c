"""The observation as a graph, for networks that pass messages along the links of the map."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.spaces import GraphInstance
from numpy.typing import NDArray

from regionslam_env.observations import LinkColumn, LinkKind, Observation, RegionColumn, link_table, region_table

SECTORS = 36
"""Equal sectors around the robot whose nearest obstacle its node knows."""

TABLES = ("regions", "regions_mask", "links", "links_mask")
"""Parts of an observation that nodes and edges stand for."""


class EdgeKind(IntEnum):
    """Kinds of edges: those of links, and from the robot's node to a region that may contain it."""

    ADJACENCY = LinkKind.ADJACENCY
    CONTAINMENT = LinkKind.CONTAINMENT
    PRESENCE = 2


class GraphObservation(gymnasium.ObservationWrapper[GraphInstance, Any, Observation]):
    """Gives the believed map as a graph: a node for the robot, one for every region, an edge for every link.

    Node 0 is the robot, the others are the regions of the padded table in the order of their slots. All nodes have the
    same columns: the slot (-1: the robot), the columns of `RegionColumn` (zeros for the robot), and the other parts of
    the observation in the order of the space (zeros for regions), the lidar as the nearest distance (m) in each of
    `SECTORS` equal sectors, counter-clockwise from straight back. `columns` tells where each of them stands.

    An edge has two columns: probability and kind (`EdgeKind`). Links come first, in the order of the padded table and
    each of them once, from its first to its second region; then an edge of kind `PRESENCE` from the robot to every
    region that it is in with a probability above 0. With neither, `edges` and `edge_links` are None, as Gymnasium has
    it. Except for the rays within a sector, nothing of the padded observation is lost.

    Parameters
    ----------
    env
        With the observations of `SemanticNavigationEnv`.

    Attributes
    ----------
    columns
        Columns of the nodes, by name: "slot", "regions", and every other part of the observation.
    """

    def __init__(self, env: gymnasium.Env[Observation, Any]) -> None:
        super().__init__(env)
        space: spaces.Space[Any] = env.observation_space
        if not isinstance(space, spaces.Dict) or not {*TABLES, "lidar"} <= set(space):
            raise TypeError(f"the observation space is {space}, expected a Dict with regions, links and lidar")
        n_rays = len(_bounds(space["lidar"])[0])
        sectors = min(SECTORS, n_rays)
        self._starts = np.arange(sectors) * n_rays // sectors
        self._parts = tuple(key for key in space if key not in TABLES)
        bounds = self._node_bounds(space)
        ends = np.cumsum([len(low) for low, _ in bounds.values()]).tolist()
        self.columns = {key: slice(a, b) for key, a, b in zip(bounds, [0, *ends[:-1]], ends, strict=True)}
        self._width: int = ends[-1]
        low = np.concatenate([np.minimum(low, 0) for low, _ in bounds.values()])
        high = np.concatenate([np.maximum(high, 0) for _, high in bounds.values()])
        self.observation_space = spaces.Graph(
            spaces.Box(np.float32(low), np.float32(high), dtype=np.float32),
            spaces.Box(np.zeros(2, np.float32), np.array([1, max(EdgeKind)], np.float32), dtype=np.float32),
        )

    def _node_bounds(self, space: spaces.Dict) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
        """Return the lowest and highest values of every part of a node's columns."""
        n_slots = len(_bounds(space["regions_mask"])[0])
        low, high = _bounds(space["regions"])
        bounds = {"slot": (np.full(1, -1.0), np.full(1, n_slots - 1.0))}
        bounds["regions"] = low.reshape(n_slots, -1)[0], high.reshape(n_slots, -1)[0]
        bounds |= {key: _bounds(space[key]) for key in self._parts}
        low, high = bounds["lidar"]
        bounds["lidar"] = low[self._starts], high[self._starts]
        return bounds

    def observation(self, observation: Observation) -> GraphInstance:
        """Return the observation as a graph."""
        columns, slots = self.columns, np.flatnonzero(observation["regions_mask"])
        regions = region_table(observation)[slots]
        nodes = np.zeros((1 + len(slots), self._width), np.float32)
        nodes[0, columns["slot"]] = -1
        for key in self._parts:
            nodes[0, columns[key]] = observation[key] if key != "lidar" else self._nearest(observation[key])
        nodes[1:, columns["slot"]] = slots[:, None]
        nodes[1:, columns["regions"]] = regions

        node_of = np.zeros(len(observation["regions_mask"]), np.int32)
        node_of[slots] = 1 + np.arange(len(slots))
        links = link_table(observation)[observation["links_mask"] > 0]
        ends = node_of[links[:, [LinkColumn.FIRST, LinkColumn.SECOND]].astype(np.int64)]
        inside = 1 + np.flatnonzero(regions[:, RegionColumn.CONTAINS_ME] > 0).astype(np.int32)
        if len(links) + len(inside) == 0:
            return GraphInstance(nodes, None, None)
        presence = np.full((len(inside), 2), EdgeKind.PRESENCE, np.float32)
        presence[:, 0] = regions[inside - 1, RegionColumn.CONTAINS_ME]
        edges = np.concatenate([links[:, [LinkColumn.PROBABILITY, LinkColumn.KIND]], presence])
        from_robot = np.stack([np.zeros_like(inside), inside], axis=1)
        return GraphInstance(nodes, edges, np.concatenate([ends, from_robot]))

    def _nearest(self, ranges: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the nearest distance in every sector, m."""
        return np.minimum.reduceat(ranges, self._starts)


def _bounds(space: spaces.Space[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the bounds of a part of the observation."""
    if isinstance(space, spaces.Box):
        return space.low, space.high
    return np.zeros(space.shape or ()), np.ones(space.shape or ())
