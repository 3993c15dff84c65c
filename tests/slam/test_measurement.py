"""Measurements and scans: records as written, and refusals that name measurement, field and value."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slam.measurement import LINK, MEASUREMENT, MeasurementNoise, RegionMeasurement, Scan
from slam.region import EdgeState, Subrectangle

OPEN, CLOSED, SUBRECT = EdgeState


def office(**fields: object) -> RegionMeasurement:
    return RegionMeasurement(**{"type": "office", "x": 1.0, "y": 2.0, "w": 4.0, "h": 3.0} | fields)  # type: ignore[arg-type]


def test_noise_of_sizes_is_relative_below_one_metre() -> None:
    noise = MeasurementNoise(sigma_wh=0.2)
    assert noise.variance_of_size(5.0) == noise.variance_of_size(1.0) == pytest.approx(0.04)
    assert noise.variance_of_size(0.5) == pytest.approx(0.01)


def test_a_rectangle_as_record() -> None:
    noise = MeasurementNoise(sigma_xy=0.1, sigma_wh=0.2, sigma_phi=0.3)
    scan = Scan([office(phi=0.5, confidence=0.8, h=0.5, t=OPEN, r=OPEN)], noise=noise)
    (record,) = scan.records
    assert scan.types == ("office",) and len(scan) == 1
    assert (record.type, record.n, record.main, record.confidence) == (0, 1, 0, 0.8)
    assert (record.x, record.y, record.w, record.h, record.phi) == (1, 2, 4, 0.5, 0.5)
    assert record.edges.tolist() == [OPEN, CLOSED, CLOSED, OPEN, 0, 0, 0, 0, 0, 0]
    np.testing.assert_allclose(record.cov_xy, np.eye(2) * 0.01)
    np.testing.assert_allclose(record.cov_wh, np.diag([0.04, 0.01]))
    assert record.var_phi == pytest.approx(0.09)


def test_subrectangles_as_record() -> None:
    left = Subrectangle(2.0, 0.5, 0.25, OPEN, CLOSED, OPEN)
    right = Subrectangle(3.0, 1.5, -0.5, CLOSED, OPEN, CLOSED, np.diag([0.5, 0.6]), 0.7)
    noise = MeasurementNoise(sigma_xy=0.1, sigma_wh=0.2)
    (record,) = Scan([office(left=left, right=right)], noise=noise).records
    assert (record.n, record.main) == (3, 1)
    assert record.edges.tolist() == [CLOSED, CLOSED, SUBRECT, SUBRECT, OPEN, CLOSED, OPEN, CLOSED, OPEN, CLOSED]
    assert (record.sub_w.tolist(), record.sub_h.tolist(), record.sub_y.tolist()) == ([2, 3], [0.5, 1.5], [0.25, -0.5])
    np.testing.assert_allclose(record.sub_cov_wh[0], np.diag([0.04, 0.01]))
    np.testing.assert_allclose(record.sub_cov_wh[1], np.diag([0.5, 0.6]))
    np.testing.assert_allclose(record.sub_var_y, [0.01, 0.7])


@pytest.mark.parametrize(("side", "n", "main"), [("left", 2, 1), ("right", 2, 0)])
def test_one_subrectangle(side: str, n: int, main: int) -> None:
    (record,) = Scan([office(**{side: Subrectangle(2.0, 1.0, 0.0)})]).records
    assert (record.n, record.main) == (n, main)
    assert record.edges[2 if side == "left" else 3] == SUBRECT
    assert record.edges[3 if side == "left" else 2] == CLOSED


def test_what_a_sensor_tells_of_its_noise_counts() -> None:
    cov_xy, cov_wh = np.array([[0.4, 0.1], [0.1, 0.3]]), np.array([[0.2, 0.0], [0.0, 0.5]])
    (record,) = Scan([office(cov_xy=cov_xy, cov_wh=cov_wh, var_phi=0.6)]).records
    np.testing.assert_array_equal(record.cov_xy, cov_xy)
    np.testing.assert_array_equal(record.cov_wh, cov_wh)
    assert record.var_phi == 0.6


def test_types_are_listed_once_and_links_keep_their_direction() -> None:
    scan = Scan([office(links={1: 0.9}), office(type="door", links={0: 0.8, 2: 0.7}), office()])
    assert scan.types == ("office", "door")
    assert scan.records["type"].tolist() == [0, 1, 0]
    assert scan.links.dtype == LINK
    assert scan.links.tolist() == [(0, 1, 0.9), (1, 0, 0.8), (1, 2, 0.7)]


def test_an_empty_scan() -> None:
    scan = Scan()
    assert len(scan) == 0 and scan.types == () and scan.view is None
    assert scan.records.dtype == MEASUREMENT and scan.links.dtype == LINK and len(scan.links) == 0


def test_records_are_wrapped_without_a_copy() -> None:
    records, view = np.zeros(2, MEASUREMENT), np.zeros((5, 2))
    scan = Scan.from_records(records, ("office",), view=view)
    assert scan.records is records and scan.view is view and len(scan.links) == 0 and len(scan) == 2


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"x": math.nan}, "x is nan, expected a finite number"),
        ({"w": math.inf}, "w is inf, expected a finite number"),
        ({"w": 0.0}, "w is 0.0, expected a size above 0"),
        ({"h": -1.0}, "h is -1.0, expected a size above 0"),
        ({"left": Subrectangle(0.0, 1.0, 0.0)}, r"left\.w is 0\.0, expected a size above 0"),
        ({"right": Subrectangle(1.0, math.nan, 0.0)}, r"right\.h is nan, expected a size above 0"),
        ({"right": Subrectangle(1.0, 1.0, math.inf)}, r"right\.y is inf, expected a finite number"),
        ({"confidence": 1.1}, r"confidence is 1\.1, expected a probability in \[0, 1\]"),
        ({"t": SUBRECT}, "t is 'SUBRECT', expected OPEN or CLOSED"),
        ({"l": SUBRECT}, "l is 'SUBRECT', expected a subrectangle on that side"),
        ({"cov_xy": np.eye(3)}, "cov_xy is .*, expected a symmetric positive definite 2 x 2 matrix"),
        ({"cov_wh": -np.eye(2)}, "cov_wh is .*, expected a symmetric positive definite"),
        ({"cov_wh": np.array([[1.0, 0.5], [0.0, 1.0]])}, "cov_wh is .*, expected a symmetric positive definite"),
        ({"var_phi": 0.0}, r"var_phi is 0\.0, expected a variance above 0"),
        ({"links": {1: 0.5}}, "links is 1, expected the index of another of the scan's 2 measurements"),
        ({"links": {2: 0.5}}, "links is 2, expected the index of another"),
        ({"links": {0: 1.5}}, r"links\[0\] is 1\.5, expected a probability"),
    ],
)
def test_impossible_measurements_are_refused(fields: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=r"(?s)measurement 1 \('office'\): " + message):
        Scan([office(), office(**fields)])


@pytest.mark.parametrize("view", [np.zeros((2, 2)), np.zeros((5, 3)), np.zeros(6), np.full((4, 2), np.nan)])
def test_a_view_is_a_finite_polygon(view: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"view is an array of shape .*, expected at least 3 finite points"):
        Scan([], view=view)


def test_a_view_is_made_contiguous() -> None:
    view = Scan([], view=[(0, 0), (4, 0), (0, 4)]).view  # type: ignore[arg-type]
    assert view is not None and view.dtype == np.float64 and view.flags.c_contiguous and view.shape == (3, 2)


def test_a_closed_ring_is_opened_and_a_clockwise_one_refused() -> None:
    """A repeated first point would make an edge without length, on whose inner side every point lies."""
    square = [(2.0, -2), (2, 2), (-2, 2), (-2, -2)]
    view = Scan([], view=np.array([*square, square[0]])).view
    assert view is not None
    np.testing.assert_array_equal(view, square)
    with pytest.raises(ValueError, match="counter-clockwise"):
        Scan([], view=np.array(square[::-1]))


def test_a_scan_is_of_one_level() -> None:
    assert Scan().level == 0
    assert Scan([RegionMeasurement("office", 0, 0, 4, 3)], level=np.int64(-1)).level == -1
    assert Scan.from_records(np.zeros(0, MEASUREMENT), (), level=3).level == 3
    for level in (1.5, "first", True, None):
        with pytest.raises(ValueError, match=r"level is .*, expected an integer"):
            Scan(level=level)  # type: ignore[arg-type]
