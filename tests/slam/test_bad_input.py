"""What comes from real sensors: refused with a word, or handled as documented; never a silent NaN."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.belief import Belief
from slam.config import SlamConfig
from slam.fastslam import RegionSLAM
from slam.measurement import LINK, MAX_MEASUREMENTS, MeasurementNoise, RegionMeasurement, Scan
from slam.motion import MotionNoise, Odometry
from slam.region import EdgeState, Subrectangle

compiled_only = pytest.mark.compiled

BAD = [math.nan, math.inf, -math.inf]
INDEFINITE = np.array([[1.0, 2.0], [2.0, 1.0]])


def office(**fields: object) -> RegionMeasurement:
    return RegionMeasurement(**{"type": "office", "x": 1.0, "y": 2.0, "w": 4.0, "h": 3.0} | fields)  # type: ignore[arg-type]


def sub(**fields: object) -> Subrectangle:
    return Subrectangle(**{"w": 1.0, "h": 1.0, "y": 0.0} | fields)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("name", ["x", "y", "w", "h", "phi", "confidence", "var_phi"])
def test_numbers_that_are_none_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"measurement 0 \('office'\): {name} is -?(nan|inf), expected"):
        Scan([office(**{name: value})])


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("name", ["w", "h", "y", "var_y"])
def test_so_they_are_in_subrectangles(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"measurement 0 \('office'\): right\.{name} is -?(nan|inf), expected"):
        Scan([office(right=sub(**{name: value}))])


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"w": -1.0}, r"w is -1\.0, expected a size above 0"),
        ({"h": 0.0}, r"h is 0\.0, expected a size above 0"),
        ({"x": 2e6}, r"x is 2000000\.0, expected a length of at most 1e\+06 m"),
        ({"x": "far"}, "x is 'far', expected a number"),
        ({"cov_xy": 0.1}, "cov_xy is 0.1, expected a symmetric positive definite"),
        ({"type": 3}, "type is 3, expected a text"),
        ({"cov_xy": INDEFINITE}, r"cov_xy is \[\[.*, expected a symmetric positive definite"),
        ({"cov_xy": np.full((2, 2), math.nan)}, r"cov_xy is \[\[nan.*, expected a symmetric positive definite"),
        ({"cov_wh": np.zeros((2, 2))}, r"cov_wh is \[\[0.*, expected a symmetric positive definite"),
        ({"cov_wh": np.eye(2) * 1e-20}, r"cov_wh is .*, expected variances from 1e-18"),
        ({"var_phi": -0.1}, r"var_phi is -0\.1, expected a variance above 0"),
        ({"var_phi": 1e20}, r"var_phi is 1e\+20, expected a variance from"),
        ({"left": sub(cov_wh=INDEFINITE)}, r"left\.cov_wh is .*, expected a symmetric positive definite"),
        ({"left": sub(var_y=-1.0)}, r"left\.var_y is -1\.0, expected a variance above 0, or 0 for not told"),
        ({"left": sub(end=EdgeState.SUBRECT)}, "ll is 'SUBRECT', expected OPEN or CLOSED"),
        ({"t": 7}, "t is '7', expected OPEN or CLOSED"),
        ({"links": {0: 0.5}}, "links is 0, expected the index of another"),
        ({"links": {-1: 0.5}}, "links is -1, expected the index of another"),
        ({"links": {1.5: 0.5}}, r"links is 1\.5, expected the index of another"),
        ({"links": {5: math.nan}}, "links is 5, expected the index of another"),
    ],
)
def test_impossible_measurements_are_refused(fields: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Scan([office(**fields)])


def corrupt(change: Callable[[np.ndarray], None]) -> Scan:
    """A scan of two regions from records, one of which was tampered with."""
    good = Scan([office(), office(right=sub())])
    records = good.records.copy()
    change(records)
    return Scan.from_records(records, good.types)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("x", math.nan, r"measurement 1 \('office'\): x is nan, expected a finite number"),
        ("w", -1.0, r"w is -1\.0, expected a size above 0"),
        ("type", 1, "type number 1.*expected the number of one of 1 types"),
        ("n", 4, "n is 4, expected 1 to 3 rectangles"),
        ("main", 2, "main is 2, expected"),
        ("cov_xy", INDEFINITE, "cov_xy is .*, expected a symmetric positive definite"),
        ("var_phi", 0.0, r"var_phi is 0\.0, expected a variance above 0"),
        ("sub_var_y", math.nan, r"right\.var_y is nan, expected a variance above 0"),
        ("edges", 0, "r is 'OPEN', expected SUBRECT where a subrectangle is"),
    ],
)
def test_records_can_be_checked(field: str, value: object, message: str) -> None:
    def change(records: np.ndarray) -> None:
        records[field][1] = value

    scan = corrupt(change)  # unchecked, as documented
    with pytest.raises(ValueError, match=message):
        scan.check()


def test_links_and_views_of_records_can_be_checked() -> None:
    good = Scan([office(), office()])
    assert Scan.from_records(good.records, good.types, view=np.array([(3.0, -3), (3, 3), (-3, 0)])).check() is not good
    for source, target in ((2, 0), (0, 2), (0, 0), (-1, 0)):
        with pytest.raises(ValueError, match="expected the index of"):
            Scan.from_records(good.records, good.types, np.array([(source, target, 0.9)], LINK)).check()
    with pytest.raises(ValueError, match="view is an array"):
        Scan.from_records(good.records, good.types, view=np.full((4, 2), math.nan)).check()


def test_a_view_that_turns_back_is_refused() -> None:
    """Points are found by bisection over their angle."""
    with pytest.raises(ValueError, match="view turns back at point"):
        Scan(view=np.array([(4.0, 0.0), (0.0, 4.0), (3.0, 3.0), (-4.0, 0.0), (0.0, -4.0)]))
    Scan(view=np.array([(0.0, 0.0), (4.0, -4.0), (2.0, -2.0), (2.0, 2.0), (4.0, 4.0)]))  # rays that end at a corner


@pytest.mark.parametrize("turns", [-3, -1, 1, 100])
def test_headings_are_wrapped(turns: int) -> None:
    (record,) = Scan([office(phi=0.4 + 2 * np.pi * turns)]).records
    assert record.phi == pytest.approx(0.4)


@pytest.mark.parametrize("value", [*BAD, None, "far", 1e7])
@pytest.mark.parametrize("name", ["distance", "lateral", "rotation"])
def test_impossible_odometry_is_refused(name: str, value: object) -> None:
    with pytest.raises(ValueError, match=rf"odometry is .*{name}={value!r}.*, expected finite numbers"):
        Odometry(**{"distance": 0.0, name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_impossible_noise_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match=r"sigma_xy is .*, expected a standard deviation"):
        MeasurementNoise(sigma_xy=value)
    with pytest.raises(ValueError, match=r"distance is .*, expected a variance"):
        MotionNoise(distance=value)


def test_a_scan_holds_fewer_measurements_than_identities_can_tell_apart() -> None:
    with pytest.raises(ValueError, match="expected fewer than 4096"):
        Scan([office()] * MAX_MEASUREMENTS)


def sound(belief: Belief) -> None:
    """Whatever came, the belief is made of numbers, and every region is one."""
    assert np.isfinite(belief.pose_mean).all() and np.isfinite(belief.pose_cov).all()
    assert np.linalg.eigvalsh(belief.pose_cov).min() >= -1e-9 * max(1.0, np.abs(belief.pose_cov).max())
    assert belief.ess >= 1 - 1e-9
    for particle in range(len(belief.particles)):
        for m in belief.regions_of(particle):
            size = 2 + 3 * int(m.n)
            assert np.isfinite(m.state[:size]).all() and np.isfinite(m.cov[:size, :size]).all()
            assert np.diag(m.cov)[:size].min() >= 0
            assert all(np.isfinite(m[name]) for name in ("type_log_odds", "existence", "radius"))
    assert all(math.isfinite(m.w) and m.w > 0 for m in belief.map.hypotheses)
    assert all(0 <= p <= 1 + 1e-9 for p in belief.where().values())


def anything(rng: np.random.Generator, scale: float) -> RegionMeasurement:
    """Any legal measurement: sizes over six decades, variances over ten."""

    def size() -> float:
        return float(scale * 10 ** rng.uniform(-3, 3))

    def covariance() -> np.ndarray:
        a, b = 10 ** rng.uniform(-8, 2, 2)
        return np.array([[a, 0.9 * np.sqrt(a * b)], [0.9 * np.sqrt(a * b), b]])

    def edge() -> EdgeState:
        return EdgeState(int(rng.integers(2)))

    def part() -> Subrectangle | None:
        if rng.random() < 0.6:
            return None
        return Subrectangle(size(), size(), rng.normal(0, 2), edge(), edge(), edge(), covariance(), rng.uniform(0, 1))

    x, y = scale * rng.normal(0, 3, 2)
    edges = {name: edge() for name in "tblr"}
    told = {"cov_xy": covariance(), "cov_wh": covariance(), "var_phi": float(10 ** rng.uniform(-8, 1))}
    return RegionMeasurement(
        str(rng.choice(["office", "hallway", "desk"])),
        x,
        y,
        size(),
        size(),
        rng.uniform(-9, 9),
        rng.uniform(),
        **edges,
        left=part(),
        right=part(),
        **(told if rng.random() < 0.5 else {}),  # type: ignore[arg-type]
    )


@compiled_only
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([0.1, 1.0, 100.0]), again=st.booleans())
def test_beliefs_stay_numbers_whatever_is_legal(seed: int, scale: float, again: bool) -> None:
    rng = np.random.default_rng(seed)
    slam = RegionSLAM(SlamConfig(n_particles=2, confirmed_after=1), seed=0)
    view = 8 * scale * np.array([[1.0, -1], [1, 1], [-1, 1], [-1, -1]])
    seen: list[RegionMeasurement] = []
    for _ in range(6):
        seen = [*(seen if again else []), *(anything(rng, scale) for _ in range(3))][-8:]
        motion = Odometry(rng.normal(0, scale), rng.normal(0, 0.1), rng.normal(0, 2.0))
        sound(slam.step(motion, Scan(seen, view if rng.random() < 0.5 else None)))


@compiled_only
@pytest.mark.parametrize(("size", "variance"), [(1000.0, 1e-2), (4.0, 1e-6), (1000.0, 1e-6), (0.02, 1e-6), (9e5, 1.0)])
def test_extreme_sizes_and_variances(size: float, variance: float) -> None:
    """Rooms of 1 km, or measured to a millimetre: seen ten times, they are mapped once and as they are."""
    slam = RegionSLAM(SlamConfig(n_particles=2), seed=0)
    z = office(w=size, h=size / 2, cov_xy=np.eye(2) * variance, cov_wh=np.eye(2) * min(variance, (size / 100) ** 2))
    for _ in range(10):
        belief = slam.step(Odometry(0.0), Scan([z]))
        sound(belief)
    (m,) = belief.map.regions
    assert (m.w, m.h) == pytest.approx((size, size / 2), rel=0.01)


@compiled_only
def test_a_robot_far_from_the_origin() -> None:
    slam = RegionSLAM(SlamConfig(n_particles=2), seed=0)
    slam.reset((1e6, -1e6, 3.0))
    for _ in range(5):
        belief = slam.step(Odometry(0.0), Scan([office()]))
    sound(belief)
    assert len(belief.map.regions) == 1


@compiled_only
def test_500_measurements_in_a_scan() -> None:
    """Desks in rows of 25, three times: every one is found again."""
    desks = [office(type="desk", x=2.0 * (k % 25) - 24, y=1.5 * (k // 25) - 14, w=1.6, h=0.8) for k in range(500)]
    slam = RegionSLAM(SlamConfig(n_particles=2, sensor_range=40.0), seed=0)
    for _ in range(3):
        belief = slam.step(Odometry(0.0), Scan(desks))
    sound(belief)
    assert len(belief.map.regions) == 500
    assert {m.sightings for m in belief.map.regions} == {3}


@compiled_only
def test_an_impossible_scan_leaves_the_belief_as_it_was() -> None:
    slam = RegionSLAM(seed=0)
    before = slam.step(Odometry(0.0), Scan([office()])).pose_mean.copy()
    with pytest.raises(ValueError, match="x is nan"):
        slam.step(Odometry(0.0), Scan([dataclasses.replace(office(), x=math.nan)]))
    np.testing.assert_array_equal(slam.belief.pose_mean, before)
