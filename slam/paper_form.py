"""From edge positions back to the parameters of Fig. 1, and a particle's map as `RegionFeature` objects.

Means and edge states are exact; covariances are the marginals of the joint one, all that Fig. 1 can hold.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slam.maps import ADJACENT, Maps
from slam.region import EDGE_NAMES, EdgeState, RegionFeature, Subrectangle, b_index, u_index
from slam.rows import Floats, Row


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
    row, main = row_of(region), int(region.main)
    cov = np.array(region.cov)
    parameters = row.parameters()
    k, i = u_index(main), b_index(main)
    k1 = u_index(main + 1)
    c, s = np.cos(row.phi), np.sin(row.phi)
    along, across = (region.state[k] + region.state[k1]) / 2, (region.state[i] + region.state[i + 1]) / 2

    midpoint = np.zeros((2, len(cov)))  # d (x, y) / d state
    midpoint[:, 0] = -s * along - c * across, c * along - s * across
    midpoint[:, [k, k1]] = np.array([[c / 2], [s / 2]])
    midpoint[:, [i, i + 1]] = np.array([[-s / 2], [c / 2]])
    size = _difference(len(cov), [(k1, k), (i + 1, i)])
    state = {name: EdgeState.CLOSED if closed else EdgeState.OPEN for name, closed in _edges(region).items()}
    left = _subrectangle(region, main - 1, "l", state, cov) if main > 0 else None
    right = _subrectangle(region, main + 1, "r", state, cov) if main + 1 < row.n else None
    return RegionFeature(
        id=int(region.id),
        type=types[region.type],
        type_log_odds=float(region.type_log_odds),
        **{name: parameters[name] for name in ("x", "y", "w", "h", "phi")},
        t=state["t"],
        b=state["b"],
        l=state["l"] if left is None else EdgeState.SUBRECT,
        r=state["r"] if right is None else EdgeState.SUBRECT,
        left=left,
        right=right,
        cov_xy=midpoint @ cov @ midpoint.T,
        cov_wh=size @ cov @ size.T,
        var_phi=float(cov[0, 0]),
        existence=float(region.existence),
        sightings=int(region.sightings),
        visited=bool(region.visited),
        credible=bool(region.rival < 0),
    )


def _edges(region: np.record) -> dict[str, bool]:
    """Return by name whether each edge is closed."""
    main, closed = int(region.main), region.closed
    i = b_index(main)
    states = {"t": closed[i + 1], "b": closed[i], "l": closed[u_index(main)], "r": closed[u_index(main + 1)]}
    if main > 0:
        j = b_index(main - 1)
        states |= {"tl": closed[j + 1], "bl": closed[j], "ll": closed[u_index(main - 1)]}
    if main + 1 < region.n:
        j = b_index(main + 1)
        states |= {"tr": closed[j + 1], "br": closed[j], "rr": closed[u_index(main + 2)]}
    return {name: bool(value) for name, value in states.items()}


def _difference(size: int, pairs: Sequence[tuple[int, int]]) -> Floats:
    """Return the Jacobian of differences of state entries."""
    jacobian = np.zeros((len(pairs), size))
    for row, (plus, minus) in enumerate(pairs):
        jacobian[row, plus], jacobian[row, minus] = 1.0, -1.0
    return jacobian


def _subrectangle(region: np.record, i: int, side: str, state: dict[str, EdgeState], cov: Floats) -> Subrectangle:
    j, main = b_index(i), b_index(int(region.main))
    size = _difference(len(cov), [(u_index(i + 1), u_index(i)), (j + 1, j)])
    offset = np.zeros(len(cov))
    offset[[j, j + 1]], offset[[main, main + 1]] = 0.5, -0.5
    w, h = size @ region.state
    return Subrectangle(
        w=float(w),
        h=float(h),
        y=float(offset @ region.state),
        t=state[f"t{side}"],
        b=state[f"b{side}"],
        end=state[side * 2],
        cov_wh=size @ cov @ size.T,
        var_y=float(offset @ cov @ offset),
    )


def to_features(maps: Maps, particle: int, types: Sequence[str], confirmed_after: int) -> list[RegionFeature]:
    """Return a particle's confirmed regions with their links per edge and their children."""
    records = maps.table[particle]
    regions = {s: maps.pool[records[s]] for s in np.flatnonzero(records >= 0).tolist()}
    slots = [s for s, region in regions.items() if region.sightings >= confirmed_after]
    rows = {s: row_of(regions[s]) for s in slots}
    neighbours: dict[int, dict[str, dict[int, float]]] = {s: {} for s in slots}
    children: dict[int, dict[int, float]] = {s: {} for s in slots}
    for slot in slots:
        index = int(regions[slot].first_link)
        while index >= 0:
            link = maps.links[index]
            target = int(link.target)
            if target in rows and int(regions[target].id) == int(link.target_id):
                if link.kind == ADJACENT:
                    edge = facing_edge(rows[slot], rows[target])
                    neighbours[slot].setdefault(edge, {})[int(link.target_id)] = float(link.log_odds)
                else:
                    children[target][int(regions[slot].id)] = float(link.log_odds)
            index = int(link.next)
    features = []
    for slot in slots:
        feature = to_feature(regions[slot], types)
        object.__setattr__(feature, "neighbours", neighbours[slot])
        object.__setattr__(feature, "children", children[slot])
        features.append(feature)
    return features


def facing_edge(row: Row, other: Row) -> str:
    """Return the name of the row's edge nearest to the other row's centre."""
    u, v = row.to_local([other.centre])[0]
    best, name = np.inf, EDGE_NAMES[0]
    for i in range(row.n):
        side = "lr"[i > row.main] if i != row.main else ""
        sides = {"t" + side: ("v", row.t[i]), "b" + side: ("v", row.b[i])}
        if i == 0:
            sides["l" * (1 + (i != row.main))] = ("u", row.u[0])
        if i == row.n - 1:
            sides["r" * (1 + (i != row.main))] = ("u", row.u[-1])
        for edge, (axis, position) in sides.items():
            near_u = min(max(u, row.u[i]), row.u[i + 1]) if axis == "v" else position
            near_v = position if axis == "v" else min(max(v, row.b[i]), row.t[i])
            distance = np.hypot(u - near_u, v - near_v)
            if distance < best:
                best, name = distance, edge
    return name
