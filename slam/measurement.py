"""Measurements of regions, the noise they are told with, and the scan that holds them.

A measurement is a region in the robot's frame, mostly partial: edges where the view ends are open.
`RegionMeasurement` is for people, `MEASUREMENT` (the same fields as a record) for sensors and kernels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slam.checks import LARGEST, check_records
from slam.region import EdgeState, Subrectangle
from slam.rows import Floats
from slam.se2 import wrap_angles

MEASUREMENT = np.dtype(
    (
        np.record,
        [
            ("type", np.int64),  # index into the scan's types
            ("n", np.int64),  # rectangles
            ("main", np.int64),  # index of the main rectangle: 1 where there is a left subrectangle
            ("edges", np.int8, (10,)),  # states in the order of EDGE_NAMES
            ("confidence", np.float64),  # p(z)
            ("x", np.float64),
            ("y", np.float64),
            ("w", np.float64),
            ("h", np.float64),
            ("phi", np.float64),
            ("sub_w", np.float64, (2,)),  # left, right
            ("sub_h", np.float64, (2,)),
            ("sub_y", np.float64, (2,)),
            ("cov_xy", np.float64, (2, 2)),
            ("cov_wh", np.float64, (2, 2)),
            ("var_phi", np.float64),
            ("sub_cov_wh", np.float64, (2, 2, 2)),
            ("sub_var_y", np.float64, (2,)),
        ],
    )
)
"""One measured region in the paper's parameters (Fig. 1), robot frame."""

LINK = np.dtype((np.record, [("source", np.int64), ("target", np.int64), ("confidence", np.float64)]))
"""A measured topological link between two measurements of one scan: p(z_m -> z_n)."""


MAX_MEASUREMENTS = 4096
"""A scan holds fewer; a region's id is the number of its first scan times this, plus the measurement's index."""


@dataclass(frozen=True)
class MeasurementNoise:
    """Standard deviations of a region sensor; small sizes are measured in proportion.

    Parameters
    ----------
    sigma_xy
        Of midpoints and lateral displacements, m.
    sigma_wh
        Of sizes of `full_size` and above, m.
    sigma_phi
        Of the heading, rad.
    full_size
        Size below which the standard deviation shrinks with the size, m.
    """

    sigma_xy: float = 0.10
    sigma_wh: float = 0.15
    sigma_phi: float = 0.03
    full_size: float = 1.0

    def __post_init__(self) -> None:
        for name in ("sigma_xy", "sigma_wh", "sigma_phi"):
            value = getattr(self, name)
            if not 0 <= value <= LARGEST:
                raise ValueError(f"{name} is {value!r}, expected a standard deviation of at least 0")

    def variance_of_size(self, size: float) -> float:
        """Return the variance (m²) with which a width or height of `size` m is measured."""
        return (self.sigma_wh * min(1.0, size / self.full_size)) ** 2


@dataclass(frozen=True, eq=False)
class RegionMeasurement:
    """A measured region in the robot's frame, with the fields of Fig. 1.

    Covariances that are not given follow from the filter's `MeasurementNoise`. Lengths are finite and at most 1,000 km,
    standard deviations 1 nm to 1,000 km (1e-9 to 1e6 rad), covariances symmetric and positive definite. What is thinner
    than 1 cm is mapped as 1 cm.

    Parameters
    ----------
    type, confidence
        Semantic type and p(z) in [0, 1].
    x, y, w, h, phi
        Midpoint (m), size (m, above 0) and heading (rad, any: it is wrapped) of the main rectangle.
    t, b, l, r
        States of its edges; `l` and `r` become SUBRECT where `left` and `right` are given.
    left, right
        Subrectangles or None.
    cov_xy, cov_wh, var_phi
        What the sensor says of its own noise.
    links
        Topological links to other measurements of the scan: index -> p(z_m -> z_n).
    """

    type: str
    x: float
    y: float
    w: float
    h: float
    phi: float = 0.0
    confidence: float = 0.9
    t: EdgeState = EdgeState.CLOSED
    b: EdgeState = EdgeState.CLOSED
    l: EdgeState = EdgeState.CLOSED  # noqa: E741 - the paper's name
    r: EdgeState = EdgeState.CLOSED
    left: Subrectangle | None = None
    right: Subrectangle | None = None
    cov_xy: Floats | None = None
    cov_wh: Floats | None = None
    var_phi: float | None = None
    links: Mapping[int, float] = field(default_factory=dict)


class Scan:
    """All regions measured at one time, and what was in view.

    Parameters
    ----------
    measurements
        The measured regions.
    view
        Visible polygon in the robot's frame, shape (k, 2), m, counter-clockwise and star-shaped about the robot: what
        lies inside and was not measured is evidence against a region. A view narrower than a full turn begins with the
        robot itself, (0, 0). None: no such evidence.
    noise
        Noise of measurements that do not tell their own.
    level
        Storey that the robot is on, and so all that it measures; 0 is the ground floor.
    """

    def __init__(
        self,
        measurements: Sequence[RegionMeasurement] = (),
        view: NDArray[np.float64] | None = None,
        noise: MeasurementNoise | None = None,
        level: int = 0,
    ) -> None:
        noise = noise or MeasurementNoise()
        if len(measurements) >= MAX_MEASUREMENTS:
            raise ValueError(f"a scan of {len(measurements)} measurements, expected fewer than {MAX_MEASUREMENTS}")
        self.types = tuple(dict.fromkeys(z.type for z in measurements))
        self.records = np.zeros(len(measurements), MEASUREMENT)
        for i, measurement in enumerate(measurements):
            _check(i, measurement, len(measurements))
            _write(self.records[i], measurement, self.types.index(measurement.type), noise)
        links = [(i, j, p) for i, z in enumerate(measurements) for j, p in z.links.items()]
        self.links = np.array(links, LINK)
        check_records(self.records, self.links, self.types)
        self.records["phi"] = wrap_angles(self.records["phi"])
        self.view = None if view is None else _checked_view(view)
        self.level = _checked_level(level)

    @classmethod
    def from_records(
        cls,
        records: NDArray[np.void],
        types: tuple[str, ...],
        links: NDArray[np.void] | None = None,
        view: NDArray[np.float64] | None = None,
        level: int = 0,
    ) -> Scan:
        """Wrap arrays of `MEASUREMENT` and `LINK` as they are, unchecked and uncopied: the fast way in.

        What `check` refuses makes the filter's belief meaningless without a word: call it on records from a source
        that you do not trust.
        """
        scan = cls.__new__(cls)
        scan.types, scan.records, scan.view, scan.level = types, records, view, level
        scan.links = np.zeros(0, LINK) if links is None else links
        return scan

    def check(self) -> Scan:
        """Refuse records that no sensor can mean, as the constructor refuses measurements; return the scan itself.

        Raises
        ------
        ValueError
            With the index of the measurement or link, the field, its value and what was expected.
        """
        check_records(self.records, self.links, self.types)
        if self.view is not None:
            self.view = _checked_view(self.view)
        return self

    def __len__(self) -> int:
        return len(self.records)


_SCALARS = ("x", "y", "w", "h", "phi", "confidence")


def _check(index: int, z: RegionMeasurement, count: int) -> None:
    """Refuse what a record cannot even hold; `check_records` sees to the rest."""

    def refuse(name: str, value: object, expected: str) -> None:
        raise ValueError(f"measurement {index} ({z.type!r}): {name} is {value!r}, expected {expected}")

    kind: object = z.type
    if not isinstance(kind, str):
        refuse("type", kind, "a text")
    for side, part in (("", z), ("left.", z.left), ("right.", z.right)):
        for name in ("x", "y", "w", "h", "phi", "confidence", "var_phi", "var_y"):
            value = getattr(part, name, None)
            if value is not None and not _is_numeric(value, ()):
                refuse(side + name, value, "a number")
        for name in ("cov_xy", "cov_wh"):
            value = getattr(part, name, None)
            if value is not None and not _is_numeric(value, (2, 2)):
                refuse(side + name, value, "a symmetric positive definite 2 x 2 matrix")
        # Zero means not told; then the noise that the scan is given counts.
        if isinstance(part, Subrectangle) and not part.var_y >= 0:
            refuse(side + "var_y", part.var_y, "a variance above 0, or 0 for not told")
    for name, sub in (("l", z.left), ("r", z.right)):
        if getattr(z, name) == EdgeState.SUBRECT and sub is None:
            refuse(name, "SUBRECT", "a subrectangle on that side")
    targets: Iterable[object] = z.links
    for target in targets:
        if isinstance(target, bool) or not isinstance(target, int | np.integer):
            refuse("links", target, f"the index of another of the scan's {count} measurements")


def _is_numeric(value: object, shape: tuple[int, ...]) -> bool:
    try:
        return np.asarray(value, dtype=np.float64).shape == shape
    except (TypeError, ValueError):
        return False


def _checked_level(level: object) -> int:
    if isinstance(level, bool) or not isinstance(level, int | np.integer):
        raise ValueError(f"level is {level!r}, expected an integer (0 is the ground floor)")
    return int(level)


def _checked_view(view: NDArray[np.float64]) -> NDArray[np.float64]:
    view = np.ascontiguousarray(view, dtype=np.float64)
    if view.ndim != 2 or view.shape[1] != 2 or len(view) < 3 or not np.all(np.isfinite(view)):
        raise ValueError(f"view is an array of shape {view.shape}, expected at least 3 finite points of shape (k, 2)")
    if len(view) > 3 and np.array_equal(view[0], view[-1]):
        view = np.ascontiguousarray(view[:-1])  # closed rings are common outside
    x, y = view.T
    area = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)
    if not area > 0:
        raise ValueError(f"view has a signed area of {area} m², expected a counter-clockwise polygon")
    open_sector = not view[0].any()  # the robot itself comes first: the last point and the first need not meet
    turns = (x * np.roll(y, -1) - y * np.roll(x, -1))[: len(view) - open_sector]
    if turns.min() < -1e-6 * np.abs(view).max() ** 2:
        raise ValueError(f"view turns back at point {int(np.argmin(turns))}, expected points in order of their angle")
    return view


def _write(record: np.record, z: RegionMeasurement, type_index: int, noise: MeasurementNoise) -> None:
    """Write a measurement into its record."""
    record.type = type_index
    record.n = 1 + (z.left is not None) + (z.right is not None)
    record.main = int(z.left is not None)
    for name in _SCALARS:
        record[name] = getattr(z, name)
    sub = EdgeState.SUBRECT
    record.edges[:4] = z.t, z.b, z.l if z.left is None else sub, z.r if z.right is None else sub
    variance = noise.variance_of_size
    record.cov_xy[:] = np.eye(2) * noise.sigma_xy**2 if z.cov_xy is None else z.cov_xy
    record.cov_wh[:] = np.diag([variance(z.w), variance(z.h)]) if z.cov_wh is None else z.cov_wh
    record.var_phi = noise.sigma_phi**2 if z.var_phi is None else z.var_phi
    for side, rectangle in enumerate((z.left, z.right)):
        if rectangle is not None:
            record.edges[4 + 3 * side : 7 + 3 * side] = rectangle.t, rectangle.b, rectangle.end
            record.sub_w[side], record.sub_h[side], record.sub_y[side] = rectangle.w, rectangle.h, rectangle.y
            told = np.any(rectangle.cov_wh)
            record.sub_cov_wh[side] = (
                rectangle.cov_wh if told else np.diag([variance(rectangle.w), variance(rectangle.h)])
            )
            record.sub_var_y[side] = rectangle.var_y if rectangle.var_y > 0 else noise.sigma_xy**2
