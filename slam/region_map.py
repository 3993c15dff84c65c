"""The map as it leaves the filter: queries by type, place and relation."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from slam import relations, storeys, words
from slam.edges import Point
from slam.geojson import features_from_geojson, features_to_geojson
from slam.map_graph import GraphEdge, MapGraph
from slam.region import RegionFeature
from slam.rows import Floats

Reference = RegionFeature | int
"""A region of the map, or its id."""


class UnknownRegionError(ValueError):
    """A region was asked for that the map doesn't hold."""


class RegionMap:
    """A semantic map of regions in the map frame.

    A region is credible if no hypothesis of another type outdoes it at its place, and neither is it more likely absent
    than not, nor its type more likely wrong than right. Queries answer with credible regions, in the order of their
    ids; links and containments count if they are more likely than not. Wherever a region is asked for, its id will do.
    Queries by type or place look at one `level` or, by default, at all; a building is on every level.

    Parameters
    ----------
    features
        All hypotheses.
    """

    def __init__(self, features: Sequence[RegionFeature] = ()) -> None:
        self.hypotheses: tuple[RegionFeature, ...] = tuple(sorted(features, key=lambda feature: feature.id))
        self._by_id = {feature.id: feature for feature in self.hypotheses}
        if len(self._by_id) != len(self.hypotheses):
            ids = [feature.id for feature in self.hypotheses]
            raise ValueError(
                f"region ids must differ; {sorted({i for i in ids if ids.count(i) > 1})} come more than once"
            )

    @classmethod
    def from_geojson(cls, collection: object) -> RegionMap:
        """Return the map that `to_geojson` wrote.

        Raises
        ------
        MapError
            If it is no such collection; the message names feature, field and what was expected.
        """
        return cls(features_from_geojson(collection))

    def __len__(self) -> int:
        return len(self.regions)

    def __iter__(self) -> Iterator[RegionFeature]:
        return iter(self.regions)

    def __contains__(self, region: object) -> bool:
        return (region.id if isinstance(region, RegionFeature) else region) in self._by_id

    def __getitem__(self, region: Reference) -> RegionFeature:
        """Return the region with an id (a feature is looked up by its own)."""
        key = region.id if isinstance(region, RegionFeature) else region
        try:
            return self._by_id[key]
        except KeyError:
            near = difflib.get_close_matches(str(key), [str(i) for i in self._by_id], n=3)
            hint = f"; nearest ids: {', '.join(near)}" if near else ""
            raise UnknownRegionError(f"no region {key!r} in a map of {len(self.hypotheses)}{hint}") from None

    @cached_property
    def regions(self) -> tuple[RegionFeature, ...]:
        """The credible regions."""
        return tuple(m for m in self.hypotheses if m.credible and m.existence >= 0 and m.type_log_odds >= 0)

    @cached_property
    def types(self) -> tuple[str, ...]:
        """Semantic types of the credible regions, sorted."""
        return tuple(sorted({feature.type for feature in self.regions}))

    @cached_property
    def levels(self) -> tuple[int, ...]:
        """Levels that the credible regions lie on, from the lowest; a building doesn't count."""
        return tuple(sorted({feature.level for feature in self.regions if feature.type not in storeys.BUILDINGS}))

    def regions_of_type(self, type: str, level: int | None = None) -> tuple[RegionFeature, ...]:
        """Return the credible regions of a semantic type; none for a type that wasn't seen."""
        return tuple(feature for feature in self.regions if feature.type == type and storeys.is_on(feature, level))

    def region_at(self, x: float, y: float, level: int | None = None) -> RegionFeature | None:
        """Return the innermost credible region around a point of the map (m), or None."""
        inside = self.regions_at(x, y, level)
        return inside[0] if inside else None

    def regions_at(self, x: float, y: float, level: int | None = None) -> tuple[RegionFeature, ...]:
        """Return all credible regions around a point (m), innermost first: deepest containment, then smallest.

        Storeys and buildings come last.
        """
        centres, radii = self._circles
        near = np.flatnonzero((centres[:, 0] - x) ** 2 + (centres[:, 1] - y) ** 2 <= radii**2)
        around = (self.regions[i] for i in near if storeys.is_on(self.regions[i], level))
        inside = [feature for feature in around if feature.row.contains([(x, y)])[0]]
        return tuple(sorted(inside, key=lambda feature: (*self._depth(feature), feature.row.area, feature.id)))

    def neighbours(self, region: Reference) -> tuple[RegionFeature, ...]:
        """Return the credible regions linked to a region, the surest link first."""
        feature = self[region]
        found = self._links.get(feature.id, {})
        return tuple(self._by_id[i] for i in sorted(found, key=lambda i: (-found[i], i)))

    def parent(self, region: Reference) -> RegionFeature | None:
        """Return the region that contains a region most likely, or None."""
        parent = self._parents.get(self[region].id)
        return None if parent is None else self._by_id[parent]

    def children(self, region: Reference) -> tuple[RegionFeature, ...]:
        """Return the regions directly inside a region."""
        key = self[region].id
        return tuple(self._by_id[child] for child, parent in sorted(self._parents.items()) if parent == key)

    def ancestors(self, region: Reference) -> tuple[RegionFeature, ...]:
        """Return the regions around a region, from its parent outwards."""
        found, key = [], self[region].id
        while key in self._parents:
            key = self._parents[key]
            found.append(self._by_id[key])
        return tuple(found)

    def next_to(self, a: Reference, b: Reference) -> bool:
        """Return whether two regions are next to each other (`relations.next_to`)."""
        return relations.next_to(self[a], self[b])

    def in_front_of(self, place: Reference | ArrayLike, target: Reference) -> bool:
        """Return whether a point, pose or the centre of a region is in front of a region (`relations.in_front_of`)."""
        room = self.parent(target)
        if room is not None and room.type in storeys.CONTAINERS:
            room = None
        return self._share_level(place, target) and relations.in_front_of(self._point(place), self[target], room)

    def in_the_middle_of(self, place: Reference | ArrayLike, region: Reference) -> bool:
        """Return whether a point, pose or region's centre is in the middle of one (`relations.in_the_middle_of`)."""
        return self._share_level(place, region) and relations.in_the_middle_of(self._point(place), self[region])

    def at_the_end_of(self, place: Reference | ArrayLike, hallway: Reference) -> bool:
        """Return whether a point, pose or region is at the end of a hallway (`relations.at_the_end_of`)."""
        where: object = place
        return relations.at_the_end_of(self[where] if _is_reference(where) else self._point(where), self[hallway])

    def name(self, region: Reference) -> str:
        """Return what to call a region: the name it was given, or else one derived from its type.

        It is "kitchen" if it is the only one of its level, else "office 3", counted by ids; a storey goes by its level.
        """
        feature = self[region]
        if feature.name:
            return feature.name
        if feature.type in storeys.STOREYS:
            return storeys.ordinal(feature.level)
        alike = self.regions_of_type(feature.type, None if feature.type in storeys.BUILDINGS else feature.level)
        if len(alike) < 2 or feature not in alike:
            return feature.type
        return f"{feature.type} {alike.index(feature) + 1}"

    def describe(self, pose: ArrayLike, level: int = 0, probabilities: Mapping[int, float] | None = None) -> str:
        """Return a sentence about a pose: "I am in the hallway, next to the door leading to the kitchen.".

        Parameters
        ----------
        pose
            A point or pose in the map frame.
        level
            The storey that it is on.
        probabilities
            P(robot in region) by region id (`Belief.where`). With it the sentence tells a doubt about the room.
        """
        point = self._point(pose)
        doubt = words.doubt(self, point, level, probabilities or {})
        return doubt or words.describe(self, point, level)

    def graph(self) -> MapGraph:
        """Return credible regions, links and containments as plain lists (`.to_networkx()` for a graph object)."""
        edges = [
            GraphEdge(source, target, "adjacent", _probability(log_odds))
            for source, targets in sorted(self._links.items())
            for target, log_odds in sorted(targets.items())
            if source < target
        ]
        edges += [
            GraphEdge(parent, child, "contains", _probability(self._by_id[parent].children[child]))
            for child, parent in sorted(self._parents.items())
        ]
        return MapGraph(tuple(feature.id for feature in self.regions), tuple(edges), self.regions)

    def to_geojson(self) -> dict[str, Any]:
        """Return all hypotheses as a GeoJSON FeatureCollection in local metres, with every field of Fig. 1."""
        return features_to_geojson(self.hypotheses)

    def _depth(self, region: RegionFeature) -> tuple[bool, int]:
        """Return what sorts the innermost of regions first; storeys and buildings hold all others."""
        is_container = region.type in storeys.CONTAINERS
        above = [r for r in self.ancestors(region) if is_container or r.type not in storeys.CONTAINERS]
        return is_container, -len(above)

    def _share_level(self, place: object, region: Reference) -> bool:
        """Return whether two regions have a level in common; a point is on every level."""
        return not _is_reference(place) or storeys.is_on(self[place], self[region].level)

    def _point(self, place: object) -> Point:
        """Return a point from a point, a pose, or a region's centre."""
        if _is_reference(place):
            return self[place].row.centre
        values = np.asarray(place, dtype=np.float64)
        if values.shape not in ((2,), (3,)):
            raise ValueError(f"a place is a region, its id, (x, y) or a pose (x, y, theta); got shape {values.shape}")
        return float(values[0]), float(values[1])

    @cached_property
    def _circles(self) -> tuple[Floats, Floats]:
        """Centres (k, 2) and radii (k,) of circles around the credible regions, m."""
        centres, radii = np.zeros((len(self.regions), 2)), np.zeros(len(self.regions))
        for i, feature in enumerate(self.regions):
            corners = feature.row.rectangles().reshape(-1, 2)
            centres[i] = (corners.min(axis=0) + corners.max(axis=0)) / 2
            radii[i] = np.hypot(*(corners - centres[i]).T).max() * (1 + 1e-9)
        return centres, radii

    @cached_property
    def _links(self) -> dict[int, dict[int, float]]:
        """Log-odds above 0 of the links between credible regions, in both directions: the surer belief counts."""
        credible = {feature.id for feature in self.regions}
        links: dict[int, dict[int, float]] = {}
        for feature in self.regions:
            for neighbours in feature.neighbours.values():
                for other, log_odds in neighbours.items():
                    if log_odds > 0 and other in credible and other != feature.id:
                        for a, b in ((feature.id, other), (other, feature.id)):
                            links.setdefault(a, {})[b] = max(log_odds, links.get(a, {}).get(b, log_odds))
        return links

    @cached_property
    def _parents(self) -> dict[int, int]:
        """Child to parent: the surest containments that make a forest."""
        credible = {feature.id for feature in self.regions}
        pairs = [
            (-log_odds, feature.id, child)
            for feature in self.regions
            for child, log_odds in feature.children.items()
            if log_odds > 0 and child in credible
        ]
        parents: dict[int, int] = {}
        for _, parent, child in sorted(pairs):
            above: int | None = parent
            while above is not None and above != child:
                above = parents.get(above)
            if child not in parents and above is None:
                parents[child] = parent
        return parents


def _is_reference(place: object) -> TypeGuard[Reference]:
    return isinstance(place, RegionFeature) or (isinstance(place, int | np.integer) and not isinstance(place, bool))


def _probability(log_odds: float) -> float:
    return float(1 / (1 + np.exp(-log_odds)))
