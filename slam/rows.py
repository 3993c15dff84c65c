"""Rows of at most three rectangles: the only geometry of a region, believed, measured or true.

A row lies in a frame with origin (x, y) and heading phi. Its boundaries ``u[0] < ... < u[n]`` run along the frame's
first axis; rectangle ``i`` spans ``[u[i], u[i+1]]`` by ``[b[i], t[i]]``. Oberländer et al. 2008, section II-B and
Fig. 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

MAX_RECTANGLES = 3

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Row:
    """One to three rectangles in a row, each with a free lateral offset.

    Parameters
    ----------
    x, y, phi
        Origin (m) and heading (rad) of the row's frame in the surrounding frame.
    u
        Boundaries along the row, ascending, shape (n + 1,), m.
    b, t
        Bottom and top of each rectangle, shape (n,), m, ``b < t``.
    main
        Index of the main rectangle (Fig. 1): the middle one of three.
    """

    x: float
    y: float
    phi: float
    u: Floats
    b: Floats
    t: Floats
    main: int = 0

    def __post_init__(self) -> None:
        for name in ("u", "b", "t"):
            values = np.array(getattr(self, name), dtype=np.float64)
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        n = len(self.b)
        if not 1 <= n <= MAX_RECTANGLES or len(self.t) != n or len(self.u) != n + 1:
            raise ValueError(
                f"a row has 1 to {MAX_RECTANGLES} rectangles with len(u) == len(b) + 1 == len(t) + 1; "
                f"got len(u)={len(self.u)}, len(b)={n}, len(t)={len(self.t)}"
            )
        if not (np.all(np.diff(self.u) > 0) and np.all(self.t > self.b)):
            raise ValueError(
                f"a row's rectangles have positive width and height; got u={self.u}, b={self.b}, t={self.t}"
            )
        if not 0 <= self.main < n or (n == MAX_RECTANGLES and self.main != 1):
            raise ValueError(f"the main rectangle of a row of {n} cannot be number {self.main}")

    @classmethod
    def from_parameters(
        cls,
        x: float,
        y: float,
        w: float,
        h: float,
        phi: float = 0.0,
        left: tuple[float, float, float] | None = None,
        right: tuple[float, float, float] | None = None,
    ) -> Row:
        """Build a row from Fig. 1: midpoint and size of the main rectangle, (w, h, y) of the subrectangles."""
        u, b, t = [-w / 2, w / 2], [-h / 2], [h / 2]
        if left is not None:
            u.insert(0, u[0] - left[0])
            b.insert(0, left[2] - left[1] / 2)
            t.insert(0, left[2] + left[1] / 2)
        if right is not None:
            u.append(u[-1] + right[0])
            b.append(right[2] - right[1] / 2)
            t.append(right[2] + right[1] / 2)
        return cls(x, y, phi, np.array(u), np.array(b), np.array(t), main=0 if left is None else 1)

    def parameters(self) -> dict[str, Any]:
        """Return the arguments of `from_parameters` that build this row."""
        i = self.main
        along, across = (self.u[i] + self.u[i + 1]) / 2, (self.b[i] + self.t[i]) / 2
        c, s = np.cos(self.phi), np.sin(self.phi)

        def subrectangle(j: int) -> tuple[float, float, float]:
            return (
                float(self.u[j + 1] - self.u[j]),
                float(self.t[j] - self.b[j]),
                float((self.b[j] + self.t[j]) / 2 - across),
            )

        return {
            "x": float(self.x + c * along - s * across),
            "y": float(self.y + s * along + c * across),
            "w": float(self.u[i + 1] - self.u[i]),
            "h": float(self.t[i] - self.b[i]),
            "phi": float(self.phi),
            "left": subrectangle(i - 1) if i > 0 else None,
            "right": subrectangle(i + 1) if i + 1 < self.n else None,
        }

    @property
    def n(self) -> int:
        """Number of rectangles."""
        return len(self.b)

    @property
    def area(self) -> float:
        """Area, m²."""
        return float(np.sum(np.diff(self.u) * (self.t - self.b)))

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of area in the surrounding frame, m."""
        areas = np.diff(self.u) * (self.t - self.b)
        along = np.sum(areas * (self.u[:-1] + self.u[1:]) / 2) / np.sum(areas)
        across = np.sum(areas * (self.b + self.t) / 2) / np.sum(areas)
        point = self.to_world([[along, across]])[0]
        return float(point[0]), float(point[1])

    def rectangles(self) -> Floats:
        """Return the corners of every rectangle, counter-clockwise, shape (n, 4, 2), in the surrounding frame."""
        left, right = self.u[:-1], self.u[1:]
        corners = np.stack(
            [
                np.stack([left, self.b], -1),
                np.stack([right, self.b], -1),
                np.stack([right, self.t], -1),
                np.stack([left, self.t], -1),
            ],
            axis=1,
        )
        return self.to_world(corners.reshape(-1, 2)).reshape(-1, 4, 2)

    def outline(self) -> Floats:
        """Return the closed outline of the union, counter-clockwise, shape (4 n, 2), in the surrounding frame.

        Where two neighbouring rectangles do not touch, the outline runs along their joint.
        """
        i = range(self.n)
        bottom = [p for j in i for p in ((self.u[j], self.b[j]), (self.u[j + 1], self.b[j]))]
        top = [p for j in reversed(i) for p in ((self.u[j + 1], self.t[j]), (self.u[j], self.t[j]))]
        return self.to_world(bottom + top)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return for each point, shape (k, 2), whether it lies in one of the rectangles."""
        local = self.to_local(points)
        along, across = local[:, 0, None], local[:, 1, None]
        inside = (self.u[:-1] <= along) & (along <= self.u[1:]) & (self.b <= across) & (across <= self.t)
        return np.asarray(inside.any(axis=1))

    def to_world(self, points: ArrayLike) -> Floats:
        """Move points, shape (k, 2), from the row's frame to the surrounding frame."""
        c, s = np.cos(self.phi), np.sin(self.phi)
        return np.asarray(points, dtype=np.float64) @ np.array([[c, s], [-s, c]]) + (self.x, self.y)

    def to_local(self, points: ArrayLike) -> Floats:
        """Move points, shape (k, 2), from the surrounding frame to the row's frame."""
        c, s = np.cos(self.phi), np.sin(self.phi)
        return (np.asarray(points, dtype=np.float64) - (self.x, self.y)) @ np.array([[c, -s], [s, c]])
