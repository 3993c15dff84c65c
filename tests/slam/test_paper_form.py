from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.edge_form import state_size
from slam.geometric_update import start
from slam.maps import ADJACENT, INSIDE, add_link
from slam.measurement import RegionMeasurement
from slam.paper_form import row_of, to_feature, to_features, to_links, to_region
from slam.region import REGION, EdgeState, RegionFeature, Subrectangle
from tests.slam import naive
from tests.slam.drawn import CLOSED, OPEN, P, mapped, maps, measured, random_measurement, random_state, stored

SHAPES = [(1, False), (2, True), (2, False), (3, True)]


def parameters(state: np.ndarray, anchor: np.ndarray, main: int) -> np.ndarray:
    """x, y, w, h, phi and w, h, y of the subrectangles, from corners."""
    boxes = naive.corners(state, anchor)
    along, across = naive.axes(state[0])
    middle = boxes.mean(axis=1)
    w = np.einsum("ij,j->i", boxes[:, 1] - boxes[:, 0], along)
    h = np.einsum("ij,j->i", boxes[:, 3] - boxes[:, 0], across)
    out = [*middle[main], w[main], h[main], state[0]]
    for i in (main - 1, main + 1):
        if 0 <= i < len(boxes):
            out += [w[i], h[i], across @ (middle[i] - middle[main])]
    return np.array(out)


@pytest.mark.parametrize(("n", "main"), [(1, 0), (2, 0), (2, 1), (3, 1)])
def test_parameters_and_covariances_are_the_marginals(n: int, main: int) -> None:
    rng = np.random.default_rng(n)
    size = state_size(n)
    m = mapped(random_state(rng, n), (1.0, 2.0), naive.random_covariance(rng, size))
    m.main = main
    anchor = m.anchor.copy()
    feature = to_feature(m, ["office"])
    mean = parameters(m.state[:size], anchor, main)
    subs = [sub for sub in (feature.left, feature.right) if sub is not None]
    found = [feature.x, feature.y, feature.w, feature.h, feature.phi]
    found += [value for sub in subs for value in (sub.w, sub.h, sub.y)]
    np.testing.assert_allclose(found, mean)
    j = naive.derivative(lambda x: parameters(x, anchor, main), m.state[:size])
    cov = j @ m.cov[:size, :size] @ j.T
    np.testing.assert_allclose(feature.cov_xy, cov[:2, :2], atol=1e-8)
    np.testing.assert_allclose(feature.cov_wh, cov[2:4, 2:4], atol=1e-8)
    assert feature.var_phi == pytest.approx(cov[4, 4])
    for k, sub in enumerate(subs):
        at = 5 + 3 * k
        np.testing.assert_allclose(sub.cov_wh, cov[at : at + 2, at : at + 2], atol=1e-8)
        assert sub.var_y == pytest.approx(cov[at + 2, at + 2])


@pytest.mark.parametrize(("n", "left"), SHAPES)
def test_a_measurement_of_a_new_region_comes_back_whole(n: int, left: bool) -> None:
    """From the origin, every field of Fig. 1 but the pairwise correlations that it cannot hold."""
    z = random_measurement(np.random.default_rng(n), n, left)
    m = np.zeros(1, REGION)[0]
    start(measured(z)[0, 0], np.zeros(3), m, P)
    feature = to_feature(m, ["office"])
    for name in ("x", "y", "w", "h", "phi", "var_phi"):
        assert getattr(feature, name) == pytest.approx(getattr(z, name))
    assert (feature.t, feature.b) == (CLOSED, CLOSED)
    np.testing.assert_allclose(feature.cov_xy, z.cov_xy, atol=1e-12)
    np.testing.assert_allclose(feature.cov_wh, z.cov_wh, atol=1e-12)
    for theirs, ours, side in ((z.left, feature.left, feature.l), (z.right, feature.right, feature.r)):
        assert (theirs is None) == (ours is None)
        assert side is (EdgeState.CLOSED if theirs is None else EdgeState.SUBRECT)
        if theirs is not None and ours is not None:
            assert (ours.w, ours.h, ours.y) == pytest.approx((theirs.w, theirs.h, theirs.y))
            np.testing.assert_allclose(ours.cov_wh, theirs.cov_wh, atol=1e-12)
            assert ours.var_y == pytest.approx(theirs.var_y)
            assert ours.end is CLOSED


def test_edge_states_come_back() -> None:
    left = Subrectangle(1, 1, 0, t=OPEN, b=CLOSED, end=OPEN)
    right = Subrectangle(2, 1, 0, t=CLOSED, b=OPEN, end=CLOSED)
    z = RegionMeasurement("office", 0, 0, 2, 2, t=CLOSED, b=OPEN, left=left, right=right)
    m = np.zeros(1, REGION)[0]
    start(measured(z)[0, 0], np.zeros(3), m, P)
    feature = to_feature(m, ["office"])
    assert feature.open_edges == ("b", "tl", "ll", "br")
    assert feature.edges["l"] is feature.edges["r"] is EdgeState.SUBRECT


@st.composite
def features(draw: st.DrawFn) -> RegionFeature:
    """Every shape and every edge state."""
    n, left = draw(st.sampled_from(SHAPES))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    state = st.sampled_from([OPEN, CLOSED])
    z = random_measurement(rng, n, left)
    subs = [
        sub and dataclasses.replace(sub, t=draw(state), b=draw(state), end=draw(state)) for sub in (z.left, z.right)
    ]
    ends = [draw(state) if sub is None else EdgeState.SUBRECT for sub in subs]
    return RegionFeature(
        42,
        "kitchen",
        1.5,
        *(z.x, z.y, z.w, z.h, rng.uniform(-np.pi, np.pi), draw(state), draw(state), *ends, *subs),
        cov_xy=z.cov_xy,  # type: ignore[arg-type]
        cov_wh=z.cov_wh,  # type: ignore[arg-type]
        var_phi=z.var_phi,  # type: ignore[arg-type]
        existence=2.5,
        sightings=7,
        visited=True,
        level=2,
    )


def assert_same(a: object, b: object) -> None:
    assert dataclasses.is_dataclass(a)
    for field in dataclasses.fields(a):
        ours, theirs = getattr(a, field.name), getattr(b, field.name)
        if isinstance(ours, Subrectangle):
            assert_same(ours, theirs)
        elif isinstance(ours, np.ndarray | float):
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-12)
        else:
            assert ours == theirs


@settings(max_examples=100, deadline=None)
@given(features())
def test_every_field_of_a_feature_comes_back_from_its_record(feature: RegionFeature) -> None:
    m = np.zeros(1, REGION)[0]
    to_region(feature, ["office", "kitchen"], m)
    assert_same(to_feature(m, ["office", "kitchen"]), feature)
    m.anchor[0] += 1.0  # shifted, not the same place: the test can fail
    assert to_feature(m, ["office", "kitchen"]).x != pytest.approx(feature.x)


@pytest.mark.parametrize(("n", "main"), [(1, 0), (2, 0), (2, 1), (3, 1)])
def test_a_record_comes_back_from_its_feature_but_for_correlations(n: int, main: int) -> None:
    rng = np.random.default_rng(n)
    size = state_size(n)
    m = mapped(random_state(rng, n), (1.0, 2.0), naive.random_covariance(rng, size), open_edges=[1, 3])
    m.main = main
    back = np.zeros(1, REGION)[0]
    to_region(to_feature(m, ["office"]), ["office"], back)
    np.testing.assert_allclose(row_of(back).rectangles(), row_of(m).rectangles(), atol=1e-9)
    np.testing.assert_array_equal(back.closed, m.closed)
    assert (back.n, back.main, back.cov[0, 0]) == (n, main, m.cov[0, 0])
    again = to_feature(back, ["office"])
    np.testing.assert_allclose(again.cov_xy, to_feature(m, ["office"]).cov_xy, rtol=1e-9)


def test_a_type_that_the_filter_does_not_know_is_refused() -> None:
    feature = RegionFeature(1, "attic", 0.0, 0, 0, 1, 1, 0)
    with pytest.raises(ValueError, match="type is 'attic', expected one of 'office'"):
        to_region(feature, ["office"], np.zeros(1, REGION)[0])


def test_links_of_features_as_a_map_holds_them() -> None:
    room = RegionFeature(1, "office", 0.0, 0, 0, 4, 4, 0, neighbours={"t": {2: 1.5}, "l": {3: -0.5}}, children={4: 2.0})
    assert to_links([room]) == [(1, 2, ADJACENT, "t", 1.5), (1, 3, ADJACENT, "l", -0.5), (4, 1, INSIDE, "", 2.0)]


def test_a_row_lies_where_its_corners_are() -> None:
    m = mapped(random_state(np.random.default_rng(0), 3), (1.0, -3.0))
    np.testing.assert_allclose(row_of(m).rectangles(), naive.corners(m.state[:11], m.anchor), atol=1e-12)


def test_links_and_children_by_id() -> None:
    regions = maps(mapped([0, -2, 2, -1, 1]), mapped([0, -2, 2, -1, 1], (0, 2)), mapped([0, -0.5, 0.5, -0.5, 0.5]))
    regions["sightings"] = 5
    drawn = stored(regions)
    for source, target, target_id, kind, log_odds in (
        (0, 1, 101, ADJACENT, 2.0),
        (0, 2, 555, ADJACENT, 9.0),  # stale: the slot holds another region now
        (2, 0, 100, INSIDE, 3.0),
    ):
        add_link(drawn, regions[0, source])
        link = drawn.links[regions[0, source].first_link]
        link.target, link.target_id, link.kind, link.log_odds = target, target_id, kind, log_odds
        link.place[:] = 0.5, 0.9
    features = {m.id: m for m in to_features(drawn, 0, ["office"], 3)}
    assert set(features) == {100, 101, 102}
    assert features[100].neighbours == {"t": {101: 2.0}}
    assert features[100].children == {102: 3.0}
    assert features[102].neighbours == {}
    regions["sightings"][0, 1] = 2
    features = {m.id: m for m in to_features(drawn, 0, ["office"], 3)}
    assert set(features) == {100, 102}
    assert features[100].neighbours == {}  # tentative regions aren't handed out, nor links to them


def test_a_feature_holds_its_standing() -> None:
    m = mapped([0, -2, 2, -1, 1])
    m.rival, m.visited, m.existence, m.sightings, m.type_log_odds, m.type, m.id = 3, 1, 2.5, 7, -1.5, 1, 42
    m.level = -1
    feature = to_feature(m, ["office", "kitchen"])
    assert (feature.level, feature.name) == (-1, "")
    assert isinstance(feature, RegionFeature)
    assert (feature.id, feature.type, feature.type_log_odds, feature.existence) == (42, "kitchen", -1.5, 2.5)
    assert (feature.sightings, feature.visited, feature.credible) == (7, True, False)
