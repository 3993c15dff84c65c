from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.config import SlamConfig
from slam.expansion import expand
from slam.geometric_update import start
from slam.innovation import workspace
from slam.measurement import RegionMeasurement
from slam.paper_form import to_feature, to_region
from slam.paper_update import fuse_parameters
from slam.region import MAX_STATE, REGION, EdgeState, RegionFeature, Subrectangle
from tests.slam import naive
from tests.slam.drawn import CLOSED, OPEN, measured
from tests.slam.naive_paper import differences, feature_of, place_of, update

PAPER = SlamConfig(geometric_update="paper").parameters()
ORIGIN = np.zeros(3)


def region(feature: RegionFeature) -> np.record:
    out = np.zeros(1, REGION)[0]
    to_region(feature, ["office"], out)
    return out


def feature(x: float, y: float, w: float, h: float, phi: float = 0.0, **fields: object) -> RegionFeature:
    fields = {"cov_xy": np.eye(2) * 0.01, "cov_wh": np.eye(2) * 0.02, "var_phi": 0.001} | fields
    return RegionFeature(1, "office", 0.0, x, y, w, h, phi, **fields)  # type: ignore[arg-type]


def partial_view(
    rng: np.random.Generator, first: int, count: int, main: int, closed: np.ndarray, noise: float, phi: float
) -> dict[str, object]:
    """Fields of Fig. 1 of some rectangles of a row of three; open edges lie up to half a metre inside, or outside."""
    u = np.array([-6.0, -2.0, 2.5, 7.0]) + rng.normal(0, noise, 4)
    b, t = np.array([-1.5, -2.0, -1.0]) + rng.normal(0, noise, 3), np.array([1.0, 2.2, 1.4]) + rng.normal(0, noise, 3)
    u, b, t = u[first : first + count + 1], b[first : first + count], t[first : first + count]
    u[0] += 0 if closed[0] else rng.uniform(-0.2, 0.5)
    u[-1] -= 0 if closed[1] else rng.uniform(-0.2, 0.5)
    for i in range(count):
        b[i] += 0 if closed[2 + 2 * i] else rng.uniform(-0.2, 0.5)
        t[i] -= 0 if closed[3 + 2 * i] else rng.uniform(-0.2, 0.5)
    states = [EdgeState.CLOSED if c else EdgeState.OPEN for c in closed]
    along, across = naive.axes(phi)
    mid_u, mid_v = (u[main] + u[main + 1]) / 2, (b[main] + t[main]) / 2
    x, y = along * mid_u + across * mid_v
    fields: dict[str, object] = {"x": x, "y": y, "w": u[main + 1] - u[main], "h": t[main] - b[main], "phi": phi}
    fields |= {"b": states[2 + 2 * main], "t": states[3 + 2 * main], "l": states[0], "r": states[1]}
    for i, name in ((main - 1, "left"), (main + 1, "right")):
        if 0 <= i < count:
            sub = Subrectangle(
                u[i + 1] - u[i],
                t[i] - b[i],
                (b[i] + t[i]) / 2 - mid_v,
                states[3 + 2 * i],
                states[2 + 2 * i],
                states[0 if name == "left" else 1],
                naive.random_covariance(rng, 2, 0.1),
                rng.uniform(0.005, 0.02),
            )
            fields |= {name: sub, name[0]: EdgeState.SUBRECT}
    fields |= {"cov_xy": naive.random_covariance(rng, 2, 0.1), "cov_wh": naive.random_covariance(rng, 2, 0.1)}
    return fields | {"var_phi": rng.uniform(0.0005, 0.002)}


@st.composite
def meetings(draw: st.DrawFn) -> tuple[RegionFeature, RegionMeasurement, int, np.ndarray]:
    """A mapped part of a row of three, a measured part, their offset and the robot's pose."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    m_first = draw(st.integers(0, 2))
    m_count = draw(st.integers(1, 3 - m_first))
    z_first = draw(st.integers(0, m_first + m_count - 1))
    z_count = draw(st.integers(max(1, m_first - z_first + 1), 3 - z_first))
    views = []
    pose = np.array([*rng.normal(0, 2, 2), rng.uniform(-3, 3)])
    for first, count, noise, phi in ((m_first, m_count, 0.02, 0.3), (z_first, z_count, 0.1, 0.3 + rng.normal(0, 0.05))):
        closed = np.array(draw(st.lists(st.booleans(), min_size=2 + 2 * count, max_size=2 + 2 * count)))
        closed[0] &= first == 0
        closed[1] &= first + count == 3
        main = 1 if count == 3 else draw(st.integers(0, count - 1))
        views.append(partial_view(rng, first, count, main, closed, noise, phi))
    seen = views[1]
    along, across = naive.axes(-pose[2])
    seen["x"], seen["y"] = np.stack([along, across], axis=1) @ (np.array([seen["x"], seen["y"]]) - pose[:2])
    seen["phi"] -= pose[2]  # type: ignore[operator]
    m = RegionFeature(1, "office", 0.0, **views[0])  # type: ignore[arg-type]
    return m, RegionMeasurement("office", **seen), z_first - m_first, pose  # type: ignore[arg-type]


@settings(max_examples=200, deadline=None)
@given(meetings())
def test_update_is_that_of_the_equations(meeting: tuple[RegionFeature, RegionMeasurement, int, np.ndarray]) -> None:
    """All shapes, edge states and correspondences."""
    f, z, offset, pose = meeting
    m = region(f)
    fuse_parameters(measured(z)[0, 0], m, offset, pose, workspace())
    ours = to_feature(m, ["office"])
    expected = feature_of(update(place_of(f, ORIGIN), place_of(z, pose), offset))
    for name in ("x", "y", "w", "h", "var_phi"):
        assert getattr(ours, name) == pytest.approx(expected[name], abs=1e-9)
    assert np.remainder(ours.phi - expected["phi"] + 1, 2 * np.pi) == pytest.approx(1)
    np.testing.assert_allclose(ours.cov_xy, expected["cov_xy"], atol=1e-10)
    np.testing.assert_allclose(ours.cov_wh, expected["cov_wh"], atol=1e-10)
    closed = expected["closed"]
    assert {e: getattr(ours, e) != OPEN for e in "tblr"} == closed
    for name in ("left", "right"):
        a, b = getattr(ours, name), expected[name]
        assert (a is None) == (b is None)
        if a is not None:
            assert (a.w, a.h, a.y, a.var_y) == pytest.approx((b.w, b.h, b.y, b.var_y), abs=1e-9)
            np.testing.assert_allclose(a.cov_wh, b.cov_wh, atol=1e-10)
            assert (a.t, a.b, a.end) == (b.t, b.b, b.end)


def test_expansion_is_equations_1_and_2() -> None:
    """The region grows to the top and right, where it is open and the measurement goes farther (Fig. 3)."""
    f = feature(0, 0, 4, 2, 0.1, t=OPEN, r=OPEN, cov_xy=np.zeros((2, 2)))
    z = feature(1.5, 0.8, 3, 2.2, 0.15)
    d = differences(place_of(f, ORIGIN).boxes[0], 0.1, place_of(z, ORIGIN).boxes[0], 0.15)
    m, seen = region(f), region(z)
    expand(m, seen, 0, False, np.zeros(MAX_STATE, np.bool_))
    assert m.state[1:5].tolist() == pytest.approx([-2, 2 + d["r"], -1, 1 + d["t"]])
    assert min(d["r"], d["t"]) > 0.5


def test_a_partial_view_of_a_known_width_tells_of_one_edge() -> None:
    """Fig. 4: the measured width becomes the known one but for the difference at the right, where both are closed."""
    m = region(feature(0, 0, 6, 2))
    z = measured(RegionMeasurement("office", 2.2, 0, 2, 2, l=OPEN, cov_xy=np.eye(2) * 0.01, cov_wh=np.eye(2) * 0.02))
    fuse_parameters(z[0, 0], m, 0, ORIGIN, workspace())
    after = to_feature(m, ["office"])
    assert after.w == pytest.approx(6 + 0.2 / 2)
    assert after.x == pytest.approx(0.1 / 2)
    assert after.cov_wh[0, 0] == pytest.approx(0.01)


def test_a_restricted_parameter_only_expands() -> None:
    """Neither end of a hallway is in view, before or now: it grows, and learns its height alone."""
    m = region(feature(0, 0, 6, 2, l=OPEN, r=OPEN))
    z = measured(RegionMeasurement("office", 2.0, 0, 6, 2.2, l=OPEN, r=OPEN, cov_wh=np.eye(2) * 0.02))
    fuse_parameters(z[0, 0], m, 0, ORIGIN, workspace())
    after = to_feature(m, ["office"])
    assert (after.x, after.w) == pytest.approx((1, 8))
    assert after.h == pytest.approx(2.1)
    assert after.cov_wh[0, 0] == pytest.approx(0.02)
    assert after.open_edges == ("l", "r")


def test_an_expanded_parameter_is_as_uncertain_as_the_measurement() -> None:
    m = region(feature(0, 0, 6, 2, r=OPEN, cov_wh=np.eye(2) * 1e-4, cov_xy=np.eye(2) * 1e-4))
    z = measured(RegionMeasurement("office", 4.0, 0, 6, 2, l=OPEN, r=OPEN, cov_wh=np.eye(2) * 0.02))
    fuse_parameters(z[0, 0], m, 0, ORIGIN, workspace())
    after = to_feature(m, ["office"])
    assert (after.cov_wh[0, 0], after.cov_xy[0, 0]) == pytest.approx((0.02, 0.01))
    assert after.cov_wh[1, 1] < 1e-4


def test_a_new_region_keeps_its_open_edges_and_blocks() -> None:
    z = RegionMeasurement("office", 3.0, 1.0, 4.0, 3.0, 0.4, r=OPEN, right=None)
    m = np.zeros(1, REGION)[0]
    start(measured(z)[0, 0], np.array([1.0, 2.0, 0.5]), m, PAPER)
    f = to_feature(m, ["office"])
    assert (f.w, f.h, f.r, f.l) == (pytest.approx(4.0), pytest.approx(3.0), OPEN, CLOSED)
    np.testing.assert_allclose(f.cov_wh, np.eye(2) * 0.15**2, atol=1e-12)
    np.testing.assert_allclose(f.cov_xy, np.eye(2) * 0.1**2, atol=1e-12)
