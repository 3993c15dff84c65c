"""A slow twin of the paper's geometric update, on midpoints and sizes as Oberländer et al. 2008 write it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from slam.measurement import RegionMeasurement
from slam.region import EdgeState, RegionFeature, Subrectangle
from tests.slam.naive import Floats, axes

OPEN, CLOSED, SUBRECT = EdgeState.OPEN, EdgeState.CLOSED, EdgeState.SUBRECT


@dataclass
class Box:
    """One rectangle of a row: midpoint, size, and which of its edges are closed (joints are)."""

    mid: Floats
    w: float
    h: float
    closed: dict[str, bool]


@dataclass
class Place:
    """A row of rectangles with the covariances of Fig. 1, in the map frame."""

    phi: float
    boxes: list[Box]
    main: int
    cov_xy: Floats
    cov_wh: Floats
    var_phi: float
    sub_covs: dict[int, tuple[Floats, float]]  # by place relative to the main rectangle: of (w, h) and of y


def place_of(f: RegionFeature | RegionMeasurement, pose: Floats) -> Place:
    """Put a feature or a measurement seen from a pose into the map."""
    along, across = axes(pose[2])
    turn = np.stack([along, across], axis=1)
    phi = f.phi + pose[2]
    along, across = axes(phi)
    mid = pose[:2] + turn @ [f.x, f.y]
    boxes = [Box(mid, f.w, f.h, {"t": f.t != OPEN, "b": f.b != OPEN, "l": f.l != OPEN, "r": f.r != OPEN})]
    covs = {}
    for at, sub in ((-1, f.left), (1, f.right)):
        if sub is None:
            continue
        closed = {"t": sub.t != OPEN, "b": sub.b != OPEN, "l": True, "r": True}
        closed["l" if at < 0 else "r"] = sub.end != OPEN
        boxes[0].closed["l" if at < 0 else "r"] = True
        box = Box(mid + at * along * (f.w + sub.w) / 2 + across * sub.y, sub.w, sub.h, closed)
        boxes.append(box) if at > 0 else boxes.insert(0, box)
        covs[at] = sub.cov_wh, sub.var_y
    assert f.cov_xy is not None
    assert f.cov_wh is not None
    assert f.var_phi is not None
    return Place(phi, boxes, int(f.left is not None), turn @ f.cov_xy @ turn.T, f.cov_wh, f.var_phi, covs)


def differences(m: Box, phi_m: float, z: Box, phi_z: float) -> dict[str, float]:
    """Eqs. (1), (2) and their analogues."""
    along, across = axes(phi_m)
    half_h, half_w = z.h * np.cos(phi_z - phi_m) / 2, z.w * np.cos(phi_z - phi_m) / 2
    d = z.mid - m.mid
    return {
        "t": across @ d + half_h - m.h / 2,
        "b": across @ d - half_h + m.h / 2,
        "r": along @ d + half_w - m.w / 2,
        "l": along @ d - half_w + m.w / 2,
    }


def grown(m: Box, phi: float, d: dict[str, float]) -> Box:
    """Move edges outwards (t, r) or inwards (b, l) by positive differences."""
    along, across = axes(phi)
    mid = m.mid + along * (d.get("l", 0.0) + d.get("r", 0.0)) / 2 + across * (d.get("t", 0.0) + d.get("b", 0.0)) / 2
    return Box(mid, m.w + d.get("r", 0.0) - d.get("l", 0.0), m.h + d.get("t", 0.0) - d.get("b", 0.0), dict(m.closed))


PAIRS = {"t": "bt", "b": "bt", "l": "lr", "r": "lr"}


def expanded(m: Box, phi_m: float, z: Box, phi_z: float, exact: bool) -> tuple[Box, set[str]]:
    """Expand m to explain z; `exact`: take over the edges of z's complete parameters (Fig. 4)."""
    moves = {}
    for edge, d in differences(m, phi_m, z, phi_z).items():
        outward = d if edge in "tr" else -d
        complete = exact and all(z.closed[e] for e in PAIRS[edge])
        if not m.closed[edge] and (complete or outward > 0):
            moves[edge] = d
    return grown(m, phi_m, moves), set(moves)


def kalman(
    mean: Floats, cov: Floats, z: Floats, noise: Floats, available: list[bool], moved: list[bool]
) -> tuple[Floats, Floats]:
    """Eqs. (3)-(6) for the available components."""
    cov = cov.copy()
    for a in range(len(mean)):
        if moved[a]:
            cov[a, a] = max(cov[a, a], noise[a, a])
    h = np.eye(len(mean))[available]
    gain = cov @ h.T @ np.linalg.inv(h @ (cov + noise) @ h.T)
    return mean + gain @ h @ (z - mean), (np.eye(len(mean)) - gain @ h) @ cov


def update(m: Place, z: Place, offset: int) -> Place:
    """Return the updated region; rectangle j of z is rectangle j + offset of m."""
    shift = max(0, -offset)
    first, last = min(offset, 0), max(len(m.boxes), len(z.boxes) + offset)
    n = last - first
    main = 1 if n == 3 else m.main + shift
    if not 0 <= main - shift < len(m.boxes):
        return update(z, m, -offset)
    seen = [dict(box.closed) for box in z.boxes]
    ours = {i + shift: box for i, box in enumerate(m.boxes)}
    theirs = {i + offset + shift: (i, box) for i, box in enumerate(z.boxes)}
    moved: dict[int, set[str]] = {}
    for i in set(ours) & set(theirs):
        before = ours[i]
        ours[i], moved[i] = expanded(before, m.phi, theirs[i][1], z.phi, False)
    for i in set(ours) & set(theirs):
        j, box = theirs[i]
        theirs[i] = j, expanded(box, z.phi, ours[i], m.phi, True)[0]
    for i in set(ours) & set(theirs):
        closed = seen[theirs[i][0]]
        ours[i].closed = {edge: ours[i].closed[edge] or closed[edge] for edge in closed}
    m = replace(m, boxes=[ours[i] for i in sorted(ours)])
    z = replace(z, boxes=[theirs[i][1] for i in sorted(theirs)])
    return blocks(m, z, ours, theirs, moved, seen, main, shift, offset)


def blocks(m, z, ours, theirs, moved, seen, main, shift, offset):  # type: ignore[no-untyped-def]
    """The Kalman updates of all blocks."""
    along, across = axes(m.phi)
    frame = np.stack([along, across])
    covs_m, covs_z = rerooted(m, main - shift), rerooted(z, main - offset - shift)
    centre, size = ours[main], np.array([ours[main].w, ours[main].h])
    mid, cov_xy, cov_wh = frame @ centre.mid, frame @ covs_m.cov_xy @ frame.T, covs_m.cov_wh
    has_main = main in theirs
    if has_main:
        j, box = theirs[main]
        available = [seen[j]["l"] or seen[j]["r"], seen[j]["b"] or seen[j]["t"]]
        gone = [bool(moved[main] & set("lr")), bool(moved[main] & set("bt"))]
        noise = frame @ covs_z.cov_xy @ frame.T
        mid, cov_xy = kalman(mid, cov_xy, frame @ box.mid, noise, available, gone)
        size, cov_wh = kalman(size, cov_wh, np.array([box.w, box.h]), covs_z.cov_wh, available, gone)
    gain = m.var_phi / (m.var_phi + z.var_phi)
    turn = np.remainder(z.phi - m.phi + np.pi, 2 * np.pi) - np.pi
    phi, var_phi = m.phi + gain * turn, (1 - gain) * m.var_phi
    new_along, new_across = axes(phi)
    out_mid = frame.T @ mid
    boxes, covs = {main: Box(out_mid, *size, centre.closed)}, {}
    z_across = axes(z.phi)[1]
    for at in (-1, 1):
        i = main + at
        if i not in ours and i not in theirs:
            continue
        if i in ours:
            y = across @ (ours[i].mid - centre.mid)
            sub, (cov, var_y), closed = np.array([ours[i].w, ours[i].h]), covs_m.sub_covs[at], ours[i].closed
        if i in theirs:
            j, box = theirs[i]
            there = np.array([box.w, box.h])
            if has_main:
                noise, noise_y = covs_z.sub_covs[at]
                y_there = z_across @ (box.mid - theirs[main][1].mid)
                main_seen = seen[theirs[main][0]]["t"] or seen[theirs[main][0]]["b"]
                main_moved = bool(moved[main] & set("bt"))
            else:
                noise, y_there = z.cov_wh, across @ (box.mid - centre.mid)
                noise_y = across @ (z.cov_xy + covs_m.cov_xy) @ across
                main_seen, main_moved = True, False
            if i not in ours:
                sub, cov, y, var_y, closed = there, noise, y_there, noise_y, box.closed
            else:
                available = [seen[j]["l"] or seen[j]["r"], seen[j]["b"] or seen[j]["t"]]
                gone = [bool(moved[i] & set("lr")), bool(moved[i] & set("bt"))]
                sub, cov = kalman(sub, cov, there, noise, available, gone)
                y1, v1 = kalman(
                    np.array([y]),
                    np.array([[var_y]]),
                    np.array([y_there]),
                    np.array([[noise_y]]),
                    [available[1] and main_seen],
                    [gone[1] or main_moved],
                )
                y, var_y = y1[0], v1[0, 0]
        boxes[i] = Box(out_mid + at * new_along * (size[0] + sub[0]) / 2 + new_across * y, *sub, closed)
        covs[at] = cov, var_y
    low = min(boxes)
    return Place(phi, [boxes[i] for i in sorted(boxes)], main - low, frame.T @ cov_xy @ frame, cov_wh, var_phi, covs)


def rerooted(place: Place, main: int) -> Place:
    """The same row with another main rectangle (covariances only): what is independent of the old one propagates."""
    if main == place.main or not 0 <= main < len(place.boxes):
        return place
    at = main - place.main
    cov_sub, var_y = place.sub_covs[at]
    along, across = axes(place.phi)
    # new midpoint = old + at (w + w_s) / 2 along + y across, with the lever of phi
    lever = place.boxes[main].mid - place.boxes[place.main].mid
    turn = np.array([-lever[1], lever[0]])
    cov_xy = (
        place.cov_xy
        + np.outer(along, along) * (place.cov_wh[0, 0] + cov_sub[0, 0]) / 4
        + np.outer(across, across) * var_y
        + np.outer(turn, turn) * place.var_phi
    )
    return replace(place, main=main, cov_xy=cov_xy, cov_wh=cov_sub, sub_covs={-at: (place.cov_wh, var_y)})


def feature_of(place: Place) -> dict[str, object]:
    """Fig. 1's fields of a place."""
    across = axes(place.phi)[1]
    centre = place.boxes[place.main]
    out: dict[str, object] = {
        "x": centre.mid[0],
        "y": centre.mid[1],
        "w": centre.w,
        "h": centre.h,
        "phi": place.phi,
        "cov_xy": place.cov_xy,
        "cov_wh": place.cov_wh,
        "var_phi": place.var_phi,
        "closed": centre.closed,
    }
    for at, name in ((-1, "left"), (1, "right")):
        if at in place.sub_covs:
            box = place.boxes[place.main + at]
            cov, var_y = place.sub_covs[at]
            out[name] = Subrectangle(
                box.w,
                box.h,
                float(across @ (box.mid - centre.mid)),
                *(CLOSED if box.closed[e] else OPEN for e in ("t", "b", "l" if at < 0 else "r")),
                cov_wh=cov,
                var_y=var_y,
            )
        else:
            out[name] = None
    return out
