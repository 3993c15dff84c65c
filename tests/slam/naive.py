"""Slow, obvious twins of the filter's kernels: textbook formulas on plain NumPy arrays, sharing no code with `slam`.

A region is a vector (phi, u0, u1, b0, t0, u2, b1, t1, u3, b2, t2) about an anchor, as far as its rectangles go.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def u_places(n: int) -> list[int]:
    """Places of the boundaries u_0 .. u_n in the vector."""
    return [1, 2, 5, 8][: n + 1]


def bt_places(n: int) -> list[tuple[int, int]]:
    """Places of (bottom, top) of every rectangle in the vector."""
    return [(3, 4), (6, 7), (9, 10)][:n]


def axes(phi: float) -> tuple[Floats, Floats]:
    """Unit vectors along and across a row."""
    return np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])


def derivative(function: Callable[[Floats], Floats], at: ArrayLike, step: float = 1e-6) -> Floats:
    """Jacobian by central differences."""
    at = np.asarray(at, float)
    columns = []
    for i in range(len(at)):
        offset = np.zeros(len(at))
        offset[i] = step
        columns.append((function(at + offset) - function(at - offset)) / (2 * step))
    return np.stack(columns, axis=1)


def edges_from_parameters(p: Floats, left: bool, right: bool) -> Floats:
    """Edge positions, as distances from the robot, of (x, y, w, h, phi, then w, h, y of the subrectangles)."""
    x, y, w, h, phi = p[:5]
    along, across = axes(phi)
    middle = np.array([x, y])
    rectangles = [(middle, w, h)]
    rest = list(p[5:])
    if left:
        ws, hs, ys = rest[:3]
        rest = rest[3:]
        rectangles.insert(0, (middle - along * (w / 2 + ws / 2) + across * ys, ws, hs))
    if right:
        ws, hs, ys = rest
        rectangles.append((middle + along * (w / 2 + ws / 2) + across * ys, ws, hs))
    u = [along @ (rectangles[0][0] - along * rectangles[0][1] / 2)]
    u += [along @ (m + along * ws / 2) for m, ws, _ in rectangles]
    sides = [(across @ m - hs / 2, across @ m + hs / 2) for m, _, hs in rectangles]
    out = [phi, u[0], u[1], *sides[0]]
    for k in range(1, len(rectangles)):
        out += [u[k + 1], *sides[k]]
    return np.array(out)


def seen_from(state: Floats, anchor: ArrayLike, pose: ArrayLike) -> Floats:
    """What an exact sensor at a pose measures of a mapped region: heading and distances of all its lines."""
    pose = np.asarray(pose, float)
    n = (len(state) - 2) // 3
    along, across = axes(state[0])
    offset = np.asarray(anchor, float) - pose[:2]
    out = state.copy()
    out[0] = state[0] - pose[2]
    for k in u_places(n):
        out[k] = along @ offset + state[k]
    for bottom, top in bt_places(n):
        out[bottom] = across @ offset + state[bottom]
        out[top] = across @ offset + state[top]
    return out


def corners(state: Floats, anchor: ArrayLike) -> Floats:
    """Corners of every rectangle, shape (n, 4, 2), counter-clockwise from bottom left."""
    n = (len(state) - 2) // 3
    along, across = axes(state[0])
    u = [state[k] for k in u_places(n)]
    out = []
    for i, (b, t) in enumerate(bt_places(n)):
        box = [(u[i], state[b]), (u[i + 1], state[b]), (u[i + 1], state[t]), (u[i], state[t])]
        out.append([np.asarray(anchor) + p * along + q * across for p, q in box])
    return np.array(out)


def contains(state: Floats, anchor: ArrayLike, point: ArrayLike, margin: float = 0.0) -> bool:
    """Whether a point lies in one of the rectangles."""
    n = (len(state) - 2) // 3
    along, across = axes(state[0])
    offset = np.asarray(point) - np.asarray(anchor)
    u, v = along @ offset, across @ offset
    places = u_places(n)
    return any(
        state[places[i]] - margin <= u <= state[places[i + 1]] + margin and state[b] - margin <= v <= state[t] + margin
        for i, (b, t) in enumerate(bt_places(n))
    )


def log_density(residual: Floats, cov: Floats) -> float:
    """Log of a zero-mean normal density."""
    _, log_det = np.linalg.slogdet(cov)
    distance = residual @ np.linalg.inv(cov) @ residual
    return float(-0.5 * (distance + log_det + len(residual) * np.log(2 * np.pi)))


def kalman(mean: Floats, cov: Floats, h: Floats, residual: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Textbook update, Oberländer et al. 2008, eqs. (4)-(6)."""
    gain = cov @ h.T @ np.linalg.inv(h @ cov @ h.T + noise)
    return mean + gain @ residual, (np.eye(len(mean)) - gain @ h) @ cov


def predict(pose: Floats, cov: Floats, odometry: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Textbook EKF prediction; odometry (forward, left, turn), noise (m^2/m, rad^2/m, rad^2/rad)."""

    def move(x: Floats, u: Floats) -> Floats:
        c, s = np.cos(x[2]), np.sin(x[2])
        return np.array([x[0] + c * u[0] - s * u[1], x[1] + s * u[0] + c * u[1], x[2] + u[2]])

    metres = np.hypot(odometry[0], odometry[1])
    q = np.diag([noise[0] * metres, noise[1] * metres + noise[2] * abs(odometry[2])])
    f = derivative(lambda x: move(x, odometry), pose)
    g = derivative(lambda u: move(pose, u), odometry)[:, [0, 2]]
    return move(pose, odometry), f @ cov @ f.T + g @ q @ g.T


def in_polygon(polygon: Floats, x: float, y: float) -> bool:
    """Even-odd rule."""
    inside = False
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
    return inside


def systematic(weights: Floats, uniform: float) -> list[int]:
    """Systematic resampling by walking along the weights."""
    total, ancestors = float(np.sum(weights)), []
    for k in range(len(weights)):
        position, i, passed = (k + uniform) / len(weights) * total, 0, weights[0]
        while passed <= position and i + 1 < len(weights):
            i += 1
            passed += weights[i]
        ancestors.append(i)
    return ancestors


def random_covariance(rng: np.random.Generator, size: int, scale: float = 0.1) -> Floats:
    """A well-conditioned covariance without structure."""
    a = rng.normal(size=(size, size))
    return np.asarray(scale**2 * (a @ a.T / size + 0.3 * np.eye(size)))
