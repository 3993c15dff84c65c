"""The topological map: regions as nodes, links and containments as edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from slam.region import RegionFeature


@dataclass(frozen=True)
class GraphEdge:
    """An adjacency (kind "adjacent", both directions) or a containment ("contains", target inside source)."""

    source: int
    target: int
    kind: str
    probability: float


@dataclass(frozen=True)
class MapGraph:
    """The topological map as plain lists: ids of regions as nodes, adjacency and containment as edges."""

    nodes: tuple[int, ...]
    edges: tuple[GraphEdge, ...]
    features: tuple[RegionFeature, ...]

    def to_networkx(self) -> Any:
        """Return a `networkx.MultiDiGraph`; nodes carry `type`, `level`, `x`, `y`, edges `kind` and `probability`.

        Raises
        ------
        ImportError
            If networkx isn't installed.
        """
        try:
            import networkx
        except ImportError as error:
            raise ImportError(
                "a networkx graph needs networkx: pip install networkx, or use .nodes and .edges as they are"
            ) from error
        graph = networkx.MultiDiGraph()
        for feature in self.features:
            x, y = feature.row.centre
            graph.add_node(feature.id, type=feature.type, level=feature.level, x=x, y=y)
        for edge in self.edges:
            graph.add_edge(edge.source, edge.target, kind=edge.kind, probability=edge.probability)
            if edge.kind == "adjacent":
                graph.add_edge(edge.target, edge.source, kind=edge.kind, probability=edge.probability)
        return graph
