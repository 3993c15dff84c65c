"""What must not change the filter's results: where the scene lies, the unit of length, how measurements are written.

A floor with an L, a T and a wide U beside rectangles, seen by a sensor of a limited range that clips the row that the
floor is annotated with, or an equivalent one.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from slam.belief import Belief
from slam.config import SlamConfig
from slam.equivalents import Description, equivalents
from slam.fastslam import RegionSLAM
from slam.measurement import MeasurementNoise, RegionMeasurement, Scan
from slam.motion import MotionNoise, Odometry
from slam.overlap import iou
from slam.paper_form import row_of
from slam.region import REGION, EdgeState, RegionFeature, Subrectangle
from slam.rows import Row
from slam.se2 import between, compose, inverse, transform
from slam.turning import turn
from tests.slam import naive
from tests.slam.test_equivalents import described

pytestmark = pytest.mark.compiled

RANGE = 6.0
OPEN, CLOSED, SUBRECT = EdgeState.OPEN, EdgeState.CLOSED, EdgeState.SUBRECT


def floor() -> list[tuple[str, Description]]:
    """Types and exact rows."""
    return [
        ("hallway", placed(described([0, 10, 12], [0, 0], [2, 6]), (-3, -1, 0.0))),
        ("office", placed(described([0, 2, 4, 6], [0, 0, 0], [2, 4, 2]), (-1, 1.2, 0.0))),
        ("kitchen", placed(described([0, 4], [0], [5]), (5, 1.2, 0.0))),
        ("lobby", placed(described([0, 1.5, 3, 4.5], [0, 0, 0], [4, 2.5, 4]), (-1, -1.2, -math.pi / 2))),
        ("storage", placed(described([0, 2, 4], [0, 1], [3, 4]), (4, -5.2, 0.2))),
        ("desk", placed(described([0, 1.6], [0], [0.8]), (6, 2, 0.7))),
    ]


def placed(description: Description, pose: tuple[float, float, float]) -> Description:
    row, states = description
    return replace(row, x=pose[0], y=pose[1], phi=pose[2]), states


def seen(description: Description, pose: np.ndarray) -> Description | None:
    """What a sensor sees of a row within a square of its range, along the row's axes: the rest is cut off and open."""
    row, _ = description
    u_at, v_at = row.to_local([pose[:2]])[0]
    keep = [
        i
        for i in range(row.n)
        if row.u[i] + 0.3 < u_at + RANGE and row.u[i + 1] - 0.3 > u_at - RANGE
        if row.b[i] + 0.3 < v_at + RANGE and row.t[i] - 0.3 > v_at - RANGE
    ]
    if not keep or keep != list(range(keep[0], keep[-1] + 1)):
        return None
    n, first, last = len(keep), keep[0], keep[-1]
    u, b, t = row.u[first : last + 2].copy(), row.b[first : last + 1].copy(), row.t[first : last + 1].copy()
    u_open = [first > 0 or u[0] < u_at - RANGE, last < row.n - 1 or u[-1] > u_at + RANGE]
    u[0], u[-1] = max(u[0], u_at - RANGE), min(u[-1], u_at + RANGE)
    b_open, t_open = b < v_at - RANGE, t > v_at + RANGE
    b, t = np.maximum(b, v_at - RANGE), np.minimum(t, v_at + RANGE)
    main = 1 if n == 3 else min(max(row.main - first, 0), n - 1)
    shown = described(list(u), list(b), list(t), main)[1]
    for i in range(n):
        side = "" if i == main else "lr"[i > main]
        shown["b" + side] = EdgeState(int(not b_open[i]))
        shown["t" + side] = EdgeState(int(not t_open[i]))
    ends = ("l" if main == 0 else "ll", "r" if main == n - 1 else "rr")
    for name, is_open in zip(ends, u_open, strict=True):
        shown[name] = EdgeState(int(not is_open))
    return Row(row.x, row.y, row.phi, u, b, t, main), shown


def measurement(kind: str, description: Description, pose: np.ndarray, noise: np.ndarray) -> RegionMeasurement:
    """A noisy measurement of an exact row; the noise moves it as a whole, so it is the same in every description."""
    row, states = description
    x, y, phi = compose(inverse(pose), (row.x, row.y, row.phi)) + 0.3 * noise * (0.1, 0.1, 0.03)
    p = replace(row, x=x, y=y, phi=phi).parameters()

    def sub(side: str, size: tuple[float, float, float] | None) -> Subrectangle | None:
        if size is None:
            return None
        return Subrectangle(*size, t=states["t" + side], b=states["b" + side], end=states[side * 2])

    return RegionMeasurement(
        kind,
        **{name: p[name] for name in ("x", "y", "w", "h")},
        phi=math.remainder(phi, 2 * math.pi),
        **{name: states[name] for name in "tblr"},
        left=sub("l", p["left"]),
        right=sub("r", p["right"]),
    )


Pose = tuple[float, float, float]
Course = list[tuple[Odometry, list[RegionMeasurement]]]


def course(seed: int = 0, steps: int = 40, written: str = "as annotated") -> Course:
    """Odometry and scans of a drive back and forth along the hallway, regions written as annotated or otherwise."""
    rng, choice = np.random.default_rng(seed), np.random.default_rng(seed + 1)
    pose, out = np.zeros(3), []
    for step in range(steps):
        turn = math.pi / 5 if 14 <= step % 20 < 19 else 0.01
        before, pose = pose, compose(pose, (0.5, 0.0, turn))
        forward, left, rotation = between(before, pose) + 0.01 * rng.standard_normal(3) * (1, 0, 0.3)
        looks = []
        for kind, description in floor():
            ways = equivalents(*description)
            way = ways[int(choice.integers(len(ways)))]
            alike = [
                w for w in ways if w[0].n == description[0].n and abs(math.sin(w[0].phi - description[0].phi)) < 0.1
            ]
            noise = rng.standard_normal(3)
            chosen = {"as annotated": description, "turned": alike[step % len(alike)], "any": way}[written]
            part = seen(chosen, pose)
            if part is not None:
                looks.append(measurement(kind, part, pose, noise))
        out.append((Odometry(float(forward), float(left), float(rotation)), looks))
    return out


def run(drive: Course, unit: float = 1.0, start: Pose = (0, 0, 0), **settings: Any) -> list[Belief]:
    """Beliefs after every scan, all lengths times `unit`."""
    motion = MotionNoise()
    noise = MeasurementNoise(0.1 * unit, 0.15 * unit, 0.03, full_size=unit)
    config = SlamConfig(
        **{"n_particles": 3, **settings},
        motion_noise=MotionNoise(motion.distance * unit, motion.heading_per_metre / unit, motion.heading_per_radian),
        measurement_noise=noise,
        sensor_range=RANGE * unit,
    )
    slam = RegionSLAM(config, seed=1)
    slam.reset(start)
    view = unit * np.array([[RANGE, -RANGE], [RANGE, RANGE], [-RANGE, RANGE], [-RANGE, -RANGE]])
    out = []
    for odometry, looks in drive:
        moved = Odometry(unit * odometry.distance, unit * odometry.lateral, odometry.rotation)
        belief = slam.step(moved, Scan([scaled(z, unit) for z in looks], view, noise))
        assert belief.map is not None  # made now, for the arrays are the filter's
        out.append(belief)
    return out


def scaled(z: RegionMeasurement, unit: float) -> RegionMeasurement:
    def sub(s: Subrectangle | None) -> Subrectangle | None:
        return s and replace(s, w=unit * s.w, h=unit * s.h, y=unit * s.y)

    return replace(z, x=unit * z.x, y=unit * z.y, w=unit * z.w, h=unit * z.h, left=sub(z.left), right=sub(z.right))


@pytest.fixture(scope="module")
def beliefs() -> list[Belief]:
    return run(course())


def same_beliefs(a: list[Belief], b: list[Belief], start: Pose, unit: float, tol: float) -> None:
    """The same poses, weights, regions under the same ids, and edge states; lengths in another unit and frame."""
    scale = np.array([unit, unit, 1.0])
    for p, q in zip(a, b, strict=True):
        expected = compose(start, p.pose_mean * scale)
        error = (q.pose_mean - expected) / scale
        assert np.abs([error[0], error[1], math.remainder(error[2], 2 * math.pi)]).max() < tol
        assert q.ess == pytest.approx(p.ess, abs=1e-4)
        assert [m.id for m in p.map.hypotheses] == [m.id for m in q.map.hypotheses]
        for m, n in zip(p.map.hypotheses, q.map.hypotheses, strict=True):
            same_region(m, n, start, unit, tol)


def same_region(m: RegionFeature, n: RegionFeature, start: Pose, unit: float, tol: float) -> None:
    corners = transform(start, unit * m.row.rectangles().reshape(-1, 2))
    others = n.row.rectangles().reshape(-1, 2)
    assert len(corners) == len(others)
    assert np.linalg.norm(corners[:, None] - others[None], axis=2).min(axis=1).max() < tol * unit
    assert sorted(m.edges.values()) == sorted(n.edges.values())
    assert (n.type_log_odds, n.existence) == pytest.approx((m.type_log_odds, m.existence), abs=1e-4)
    assert np.linalg.eigvalsh(n.cov_xy) == pytest.approx(unit**2 * np.linalg.eigvalsh(m.cov_xy), rel=1e-4)


def test_the_floor_is_found(beliefs: list[Belief]) -> None:
    floor_map = beliefs[-1].map
    assert sorted(m.type for m in floor_map.regions) == sorted(kind for kind, _ in floor())
    for kind, (row, _) in floor():
        (m,) = floor_map.regions_of_type(kind)
        assert iou(m.row, row) > 0.85


@pytest.mark.parametrize("start", [(-200.0, 70.0, 2.1), (3.0, 0.0, -math.pi / 2)])
def test_a_rigid_motion_of_the_scene_changes_nothing(start: Pose, beliefs: list[Belief]) -> None:
    same_beliefs(beliefs, run(course(), start=start), start, 1.0, 1e-6)


@pytest.mark.parametrize("unit", [1000.0, 0.01])
def test_the_unit_of_length_changes_nothing(unit: float, beliefs: list[Belief]) -> None:
    same_beliefs(beliefs, run(course(), unit), (0, 0, 0), unit, 1e-6)


def test_half_turns_and_turned_rectangles_change_nothing(beliefs: list[Belief]) -> None:
    same_beliefs(beliefs, run(course(written="turned")), (0, 0, 0), 1.0, 1e-6)


def lines_about(m: np.record, other: np.record) -> np.ndarray:
    """Entries of m's state about the anchor of another region."""
    along, across = naive.axes(m.state[0])
    out = m.state[: 2 + 3 * m.n].copy()
    shift = m.anchor - other.anchor
    out[naive.u_places(m.n)] += along @ shift
    out[np.ravel(naive.bt_places(m.n))] += across @ shift
    return out


def differences(m: np.record, n: np.record) -> np.ndarray:
    """Differences of the closed edges of two estimates of one place, in standard deviations, in one description."""
    for quarters in range(4):
        other = np.zeros(1, REGION)[0]
        turn(n, quarters, other)
        if other.n == m.n and math.cos(other.state[0] - m.state[0]) > 0.9:
            d = lines_about(other, m) - lines_about(m, m)
            d[0] = math.remainder(d[0], 2 * math.pi)
            closed = m.closed[: len(d)] == 1
            assert np.array_equal(closed, other.closed[: len(d)] == 1)
            return np.abs(d / np.sqrt(np.diag(m.cov)[: len(d)]))[closed]
    raise AssertionError("the two have no description in common")


@pytest.mark.parametrize("seed", range(3))
def test_other_descriptions_change_nothing_that_matters(seed: int) -> None:
    """Ls along their other arm, Ts along their stem: the same regions and shapes, estimates well within their noise."""
    as_annotated, otherwise = (run(course(seed, written=way), n_particles=1) for way in ("as annotated", "any"))
    for p, q in zip(as_annotated, otherwise, strict=True):
        assert [(m.id, m.type) for m in p.map.hypotheses] == [(m.id, m.type) for m in q.map.hypotheses]
    for kind, (row, _) in floor():
        (m,), (n,) = (
            [m for m in beliefs[-1].features if m.n > 0 and beliefs[-1].types[m.type] == kind]
            for beliefs in (as_annotated, otherwise)
        )
        assert differences(m, n).max() < 0.6
        assert iou(row_of(n), row) > 0.75


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings", [{"posterior": "joint"}, {"geometric_update": "paper"}, {"correspondence": "paper"}]
)
@pytest.mark.parametrize("seed", range(3))
def test_every_model_is_as_indifferent(settings: dict[str, str], seed: int) -> None:
    drive = course(seed)
    first = run(drive, **settings)
    start = (-200.0, 70.0, 2.1)
    same_beliefs(first, run(drive, start=start, **settings), start, 1.0, 1e-6)
    same_beliefs(first, run(drive, 1000.0, **settings), (0, 0, 0), 1000.0, 1e-6)
    same_beliefs(first, run(course(seed, written="turned"), **settings), (0, 0, 0), 1.0, 1e-6)


def noisy(z: RegionMeasurement, rng: np.random.Generator) -> RegionMeasurement:
    """Independent noise on every parameter, as told."""
    noise = MeasurementNoise()

    def size(value: float) -> float:
        return max(0.2 * value, value + math.sqrt(noise.variance_of_size(value)) * rng.standard_normal())

    def sub(s: Subrectangle | None) -> Subrectangle | None:
        return s and replace(s, w=size(s.w), h=size(s.h), y=s.y + noise.sigma_xy * rng.standard_normal())

    x, y = (z.x, z.y) + noise.sigma_xy * rng.standard_normal(2)
    phi = z.phi + noise.sigma_phi * rng.standard_normal()
    return replace(z, x=x, y=y, w=size(z.w), h=size(z.h), phi=phi, left=sub(z.left), right=sub(z.right))


@pytest.mark.slow
@pytest.mark.parametrize("written", ["as annotated", "any"])
def test_noise_in_any_description_makes_no_duplicate(written: str) -> None:
    overlaps = []
    for seed in range(12):
        rng = np.random.default_rng(100 + seed)
        drive = [(odometry, [noisy(z, rng) for z in looks]) for odometry, looks in course(seed, 60, written)]
        regions = run(drive)[-1].map.regions
        assert sorted(m.type for m in regions) == sorted(kind for kind, _ in floor())
        rows = dict(floor())
        overlaps += [iou(m.row, rows[m.type][0]) for m in regions]
    assert np.mean(overlaps) > 0.92
