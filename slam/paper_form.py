"""Records of the filter as `RegionFeature` objects and back, and a particle's whole map as features.

Means and edge states are exact both ways; covariances are the marginals of the joint one, all that Fig. 1 can hold.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from slam.contact import nearest_edge
from slam.edge_form import to_edge_form
from slam.maps import ADJACENT, INSIDE, Maps
from slam.measurement import MEASUREMENT
from slam.parameters import to_parameters
from slam.region import EdgeState, RegionFeature, Subrectangle, b_index, u_index
from slam.rows import Row


def row_of(region: np.record) -> Row:
    """Return the geometry of a `REGION` record as a row about its anchor."""
    n, mean = int(region.n), region.state
    u = [mean[u_index(k)] for k in range(n + 1)]
    b = [mean[b_index(i)] for i in range(n)]
    t = [mean[b_index(i) + 1] for i in range(n)]
    x, y = region.anchor
    return Row(float(x), float(y), float(mean[0]), np.array(u), np.array(b), np.array(t), int(region.main))


def to_feature(region: np.record, types: Sequence[str]) -> RegionFeature:
    """Return a `REGION` record as a feature without links."""
    fig = np.zeros(1, MEASUREMENT)[0]
    to_parameters(region, fig)
    states = [EdgeState(int(state)) for state in fig.edges]
    return RegionFeature(
        id=int(region.id),
        type=types[region.type],
        type_log_odds=float(region.type_log_odds),
        x=float(fig.x),
        y=float(fig.y),
        w=float(fig.w),
        h=float(fig.h),
        phi=float(fig.phi),
        t=states[0],
        b=states[1],
        l=states[2],
        r=states[3],
        left=_subrectangle(fig, 0, states),
        right=_subrectangle(fig, 1, states),
        cov_xy=fig.cov_xy.copy(),
        cov_wh=fig.cov_wh.copy(),
        var_phi=float(fig.var_phi),
        existence=float(region.existence),
        sightings=int(region.sightings),
        visited=bool(region.visited),
        credible=bool(region.rival < 0),
        level=int(region.level),
    )


def _subrectangle(fig: np.record, side: int, states: Sequence[EdgeState]) -> Subrectangle | None:
    """Return the left (0) or right (1) subrectangle, if there is one."""
    if states[2 + side] is not EdgeState.SUBRECT:
        return None
    w, h, y, var_y = (float(fig[name][side]) for name in ("sub_w", "sub_h", "sub_y", "sub_var_y"))
    t, b, end = states[4 + 3 * side : 7 + 3 * side]
    return Subrectangle(w, h, y, t, b, end, fig.sub_cov_wh[side].copy(), var_y)


def edge_places(region: np.record) -> dict[str, int]:
    """Return by name the place of each edge in the state vector."""
    main = int(region.main)
    i = b_index(main)
    places = {"t": i + 1, "b": i, "l": u_index(main), "r": u_index(main + 1)}
    if main > 0:
        j = b_index(main - 1)
        places |= {"tl": j + 1, "bl": j, "ll": u_index(main - 1)}
    if main + 1 < region.n:
        j = b_index(main + 1)
        places |= {"tr": j + 1, "br": j, "rr": u_index(main + 2)}
    return places


def edge_names(region: np.record) -> dict[int, str]:
    """Return the names of edges by their places in the state vector."""
    return {place: name for name, place in edge_places(region).items()}


def to_region(feature: RegionFeature, types: Sequence[str], out: np.record) -> None:
    """Write a feature into a `REGION` record anchored at the midpoint of its main rectangle.

    Links and the rank among rival hypotheses belong to a particle's map, not to the record: see `to_links`.

    Raises
    ------
    ValueError
        For a type that is not among `types`.
    """
    if feature.type not in types:
        raise ValueError(f"type is {feature.type!r}, expected one of {', '.join(map(repr, types))}")
    fig = np.zeros(1, MEASUREMENT)[0]
    fig.n, fig.main = feature.row.n, feature.row.main
    fig.w, fig.h, fig.phi, fig.var_phi = feature.w, feature.h, feature.phi, feature.var_phi
    fig.cov_xy[:], fig.cov_wh[:] = feature.cov_xy, feature.cov_wh
    fig.edges[:4] = feature.t, feature.b, feature.l, feature.r
    for side, sub in enumerate((feature.left, feature.right)):
        if sub is not None:
            fig.sub_w[side], fig.sub_h[side], fig.sub_y[side] = sub.w, sub.h, sub.y
            fig.sub_cov_wh[side], fig.sub_var_y[side] = sub.cov_wh, sub.var_y
            fig.edges[4 + 3 * side : 7 + 3 * side] = sub.t, sub.b, sub.end
    to_edge_form(fig, out)
    out.anchor[:] = feature.x, feature.y
    out.id, out.type, out.type_log_odds = feature.id, types.index(feature.type), feature.type_log_odds
    out.level, out.type_prior = feature.level, 0.0  # what part of its log-odds was the prior, a feature does not tell
    out.existence, out.sightings, out.visited = feature.existence, feature.sightings, feature.visited
    out.first_link = out.rival = -1


def to_links(features: Sequence[RegionFeature]) -> list[tuple[int, int, int, str, float]]:
    """Return the links of features as a map holds them: source id, target id, kind, edge of the source, log-odds.

    A child is linked to its parent, through no edge.
    """
    adjacent = [
        (feature.id, target, ADJACENT, edge, log_odds)
        for feature in features
        for edge, neighbours in feature.neighbours.items()
        for target, log_odds in neighbours.items()
    ]
    inside = [
        (child, feature.id, INSIDE, "", log_odds)
        for feature in features
        for child, log_odds in feature.children.items()
    ]
    return adjacent + inside


def to_features(maps: Maps, particle: int, types: Sequence[str], confirmed_after: int) -> list[RegionFeature]:
    """Return a particle's confirmed regions with their links per edge and their children."""
    records = maps.table[particle]
    regions = {s: maps.pool[records[s]] for s in np.flatnonzero(records >= 0).tolist()}
    features = {s: to_feature(m, types) for s, m in regions.items() if m.sightings >= confirmed_after}
    children: dict[int, dict[int, float]] = {s: {} for s in features}
    for slot, feature in features.items():
        neighbours: dict[str, dict[int, float]] = {}
        names = edge_names(regions[slot])
        for target, target_id, kind, log_odds, place in links_of(regions[slot], maps):
            if target not in features or features[target].id != target_id:
                continue
            if kind == ADJACENT:
                edge = names[nearest_edge(regions[slot], *place)[0]]
                neighbours.setdefault(edge, {})[target_id] = log_odds
            else:
                children[target][feature.id] = log_odds
        object.__setattr__(feature, "neighbours", neighbours)
        object.__setattr__(feature, "children", children[slot])
    return list(features.values())


def links_of(region: np.record, maps: Maps) -> Iterable[tuple[int, int, int, float, list[float]]]:
    """Return the links of a region in their order: slot and id of the target, kind, log-odds, and where (x, y) m."""
    chain, index = [], int(region.first_link)
    while index >= 0:
        chain.append(index)
        index = int(maps.next_links[index])
    links = maps.links[chain]
    columns = ("target", "target_id", "kind", "log_odds", "place")
    return zip(*(links[name].tolist() for name in columns), strict=True)
