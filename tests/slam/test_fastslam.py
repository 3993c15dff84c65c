"""The whole filter on a floor of three rooms along a hallway, driven back and forth."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from slam.belief import Belief
from slam.config import SlamConfig
from slam.fastslam import RegionSLAM
from slam.measurement import MeasurementNoise, RegionMeasurement, Scan
from slam.motion import MotionNoise, Odometry
from slam.region import EdgeState, Subrectangle
from slam.se2 import between, compose, inverse, transform
from tests.slam.storage import check_storage

FLOOR = [
    RegionMeasurement("hallway", 3, 0, 8, 2, left=Subrectangle(3, 3, 0.5), links={1: 0.9, 2: 0.9}),
    RegionMeasurement("office", 1, 3, 4, 4),
    RegionMeasurement("kitchen", 5, 3.5, 4, 5),
    RegionMeasurement("desk", 1, 4, 1.6, 0.8, 0.3),
]
NOISE = MeasurementNoise()
MOTION = MotionNoise()

Course = list[tuple[Odometry, list[RegionMeasurement]]]


def noisy(z: RegionMeasurement, pose: np.ndarray, rng: np.random.Generator) -> RegionMeasurement:
    """A region of the floor as the robot measures it, heading in (-pi/2, pi/2]."""
    x, y, phi = compose(inverse(pose), (z.x, z.y, z.phi))
    left = z.left
    if not -math.pi / 2 < phi <= math.pi / 2:
        phi += math.pi
    turned = abs(math.remainder(phi - (z.phi - pose[2]), 2 * math.pi)) > 1.0
    noise = 0.3 * rng.standard_normal(5)
    size = [NOISE.sigma_wh * min(1.0, s) for s in (z.w, z.h)]
    if left is not None and turned:
        left = dataclasses.replace(left, y=-left.y)
    return dataclasses.replace(
        z,
        x=x + 0.1 * noise[0],
        y=y + 0.1 * noise[1],
        w=z.w + size[0] * noise[2],
        h=z.h + size[1] * noise[3],
        phi=math.remainder(phi + 0.03 * noise[4], 2 * math.pi),
        left=None if turned else left,
        right=left if turned else None,
    )


def course(seed: int = 0, steps: int = 24) -> tuple[Course, list[np.ndarray]]:
    """Odometry and scans of a drive, and the true poses."""
    rng = np.random.default_rng(seed)
    pose, out, poses = np.zeros(3), [], []
    for step in range(steps):
        turn = math.pi / 4 if step % 12 >= 8 else 0.02
        before, pose = pose, compose(pose, (0.6, 0.0, turn))
        forward, left, rotation = between(before, pose)
        forward += math.sqrt(MOTION.distance * 0.6) * rng.standard_normal()
        variance = MOTION.heading_per_metre * 0.6 + MOTION.heading_per_radian * abs(rotation)
        rotation += math.sqrt(variance) * rng.standard_normal()
        seen = [noisy(z, pose, rng) for z in FLOOR]
        out.append((Odometry(float(forward), float(left), float(rotation)), seen))
        poses.append(pose)
    return out, poses


def run(
    drive: Course, seed: int = 1, start: tuple[float, float, float] = (0, 0, 0), **settings: object
) -> list[Belief]:
    slam = RegionSLAM(SlamConfig(**{"n_particles": 3, "drawn_share": 0.5, **settings}), seed=seed)  # type: ignore[arg-type]
    slam.reset(start)
    out = []
    for odometry, seen in drive:
        belief = slam.step(odometry, Scan(seen))
        assert belief.map is not None  # made now, for the arrays are the filter's
        assert all(0 <= p <= 1 + 1e-9 for p in belief.where().values())
        out.append(belief)
    return out


@pytest.fixture(scope="module")
def drive() -> tuple[Course, list[np.ndarray]]:
    return course()


@pytest.fixture(scope="module")
def beliefs(drive: tuple[Course, list[np.ndarray]]) -> list[Belief]:
    return run(drive[0])


def test_the_robot_is_where_it_was_and_the_floor_mapped_once(
    beliefs: list[Belief], drive: tuple[Course, list[np.ndarray]]
) -> None:
    errors = [np.linalg.norm(b.pose_mean[:2] - pose[:2]) for b, pose in zip(beliefs, drive[1], strict=True)]
    assert max(errors) < 0.3
    floor = beliefs[-1].map
    assert sorted(m.type for m in floor.regions) == ["desk", "hallway", "kitchen", "office"]
    for z in FLOOR:
        (m,) = floor.regions_of_type(z.type)
        assert np.hypot(m.x - z.x, m.y - z.y) < 0.3
        assert len(m.row.u) == (3 if z.left else 2)
        assert m.row.area == pytest.approx(4 * 4 if z.type == "office" else m.row.area, rel=0.1)


def test_topology_of_the_floor(beliefs: list[Belief]) -> None:
    floor = beliefs[-1].map
    (hallway,), (office,) = floor.regions_of_type("hallway"), floor.regions_of_type("office")
    (kitchen,), (desk,) = floor.regions_of_type("kitchen"), floor.regions_of_type("desk")
    assert {m.id for m in floor.neighbours(hallway)} == {office.id, kitchen.id}
    assert [m.id for m in floor.children(office)] == [desk.id]
    assert floor.children(hallway) == ()


def test_identities_are_those_of_the_first_sighting(beliefs: list[Belief]) -> None:
    assert {m.id for m in beliefs[-1].map.regions} == {4096, 4097, 4098, 4099}


def test_the_belief_is_sound_at_every_step(beliefs: list[Belief]) -> None:
    for belief in beliefs:
        assert np.all(np.isfinite(belief.pose_mean))
        assert np.all(np.linalg.eigvalsh(belief.pose_cov) >= -1e-15)
        assert 1 <= belief.ess <= 3 + 1e-9


def test_one_seed_gives_one_belief(beliefs: list[Belief], drive: tuple[Course, list[np.ndarray]]) -> None:
    again, other = run(drive[0]), run(drive[0][:3], seed=2)
    for a, b in zip(beliefs, again, strict=True):
        np.testing.assert_array_equal(a.pose_mean, b.pose_mean)
        np.testing.assert_array_equal(a.pose_cov, b.pose_cov)
        np.testing.assert_array_equal(a.pose, b.pose)
    assert beliefs[-1].features.tobytes() == again[-1].features.tobytes()
    assert not np.array_equal(beliefs[2].pose, other[2].pose)


@pytest.mark.parametrize("start", [(-2.0, 7.0, 2.1), (0.0, 0.0, math.pi)])
def test_a_rigid_motion_of_the_start_moves_the_belief_along(
    start: tuple[float, float, float], beliefs: list[Belief], drive: tuple[Course, list[np.ndarray]]
) -> None:
    moved = run(drive[0], start=start)
    for a, b in zip(beliefs, moved, strict=True):
        expected = compose(start, a.pose_mean)
        np.testing.assert_allclose(b.pose_mean[:2], expected[:2], atol=1e-6)
        assert math.remainder(b.pose_mean[2] - expected[2], 2 * math.pi) == pytest.approx(0, abs=1e-6)
        np.testing.assert_allclose(np.linalg.eigvalsh(b.pose_cov), np.linalg.eigvalsh(a.pose_cov), atol=1e-9)
    same_floor(beliefs[-1], moved[-1], start)


def same_floor(a: Belief, b: Belief, motion: tuple[float, float, float] = (0, 0, 0)) -> None:
    """The same regions, as sets of points, under the same ids."""
    assert [m.id for m in a.map.hypotheses] == [m.id for m in b.map.hypotheses]
    for m, n in zip(a.map.hypotheses, b.map.hypotheses, strict=True):
        corners = transform(motion, m.row.rectangles().reshape(-1, 2))
        others = n.row.rectangles().reshape(-1, 2)
        nearest = np.linalg.norm(corners[:, None] - others[None], axis=2).min(axis=1)
        assert nearest.max() < 1e-6
        assert n.type_log_odds == pytest.approx(m.type_log_odds)
        assert n.existence == pytest.approx(m.existence)


def otherwise(z: RegionMeasurement, quarters: int) -> RegionMeasurement:
    """The same measurement in another description: a rectangle turned by quarters, a row read from its other end."""
    for _ in range(quarters):
        if z.left is None and z.right is None:
            z = dataclasses.replace(z, w=z.h, h=z.w, phi=z.phi + math.pi / 2, r=z.t, t=z.l, l=z.b, b=z.r)
        else:
            ends = [s and dataclasses.replace(s, y=-s.y, t=s.b, b=s.t) for s in (z.right, z.left)]
            z = dataclasses.replace(z, phi=z.phi + math.pi, left=ends[0], right=ends[1], t=z.b, b=z.t, l=z.r, r=z.l)
    return z


def test_descriptions_of_measurements_do_not_matter(
    beliefs: list[Belief], drive: tuple[Course, list[np.ndarray]]
) -> None:
    rng = np.random.default_rng(0)
    other = [(odometry, [otherwise(z, int(rng.integers(4))) for z in seen]) for odometry, seen in drive[0]]
    turned = run(other)
    for a, b in zip(beliefs, turned, strict=True):
        np.testing.assert_allclose(b.pose_mean, a.pose_mean, atol=1e-6)
        np.testing.assert_allclose(b.pose_cov, a.pose_cov, atol=1e-8)
    same_floor(beliefs[-1], turned[-1])


def test_resampled_particles_live_their_own_lives(drive: tuple[Course, list[np.ndarray]]) -> None:
    slam = RegionSLAM(SlamConfig(n_particles=4, resample_below=1.0), seed=0)
    for odometry, seen in drive[0][:6]:
        belief = slam.step(odometry, Scan(seen))
        assert np.allclose(np.exp(belief.particles["log_weight"]).sum(), 1.0)
    slam.predict(Odometry(0.5))
    after = slam.update(Scan())  # drawn anew from the motion: no two alike
    assert len({tuple(p) for p in after.particles["pose"].round(12).tolist()}) == 4


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_poses_are_drawn_wholly_or_not_at_all(drive: tuple[Course, list[np.ndarray]], share: float) -> None:
    slam = RegionSLAM(SlamConfig(n_particles=4, drawn_share=share), seed=0)
    for odometry, seen in drive[0][:5]:
        particles = slam.step(odometry, Scan(seen)).particles
        assert len({tuple(p) for p in particles["pose"].tolist()}) == (4 if share else 1)
        np.testing.assert_array_equal(particles["cov"], 0.0 if share else particles["spread"])


def clutter(rng: np.random.Generator) -> RegionMeasurement:
    """Anything a sensor could come up with: any shape, any edge open, thin and wide."""

    def edge() -> EdgeState:
        return EdgeState(int(rng.integers(2)))

    def sub() -> Subrectangle:
        return Subrectangle(*rng.uniform(0.1, 4, 2), rng.normal(), t=edge(), b=edge(), end=edge())

    x, y = rng.normal(0, 3, 2)
    w, h = np.exp(rng.uniform(-2.3, 2.3, 2))
    return RegionMeasurement(
        str(rng.choice(["office", "hallway", "desk"])),
        x,
        y,
        w,
        h,
        rng.uniform(-1.5, 1.5),
        confidence=rng.uniform(),
        t=edge(),
        b=edge(),
        l=edge(),
        r=edge(),
        left=sub() if rng.random() < 0.4 else None,
        right=sub() if rng.random() < 0.4 else None,
        links={0: rng.uniform()} if rng.random() < 0.3 else {},
    )


@pytest.mark.parametrize("seed", range(2))
def test_clutter_breaks_nothing(seed: int) -> None:
    """Whatever comes, every particle's map stays sound: finite, ordered, positive, with whole lists of links."""
    rng = np.random.default_rng(seed)
    slam = RegionSLAM(
        SlamConfig(n_particles=2, gate_associate=200, gate_new=200, confirmed_after=1, relocalise=False), seed=seed
    )
    view = np.array([[9.0, -9], [9, 9], [-9, 9], [-9, -9]])
    kept: list[RegionMeasurement] = []
    for _ in range(15):
        first = clutter(rng)
        kept = [dataclasses.replace(first, links={}), *kept[:2], clutter(rng)]
        for odometry in (Odometry(rng.normal(0, 0.1), 0.0, rng.normal(0, 0.1)), Odometry(0.0)):
            belief = slam.step(odometry, Scan(kept, view=view))
        assert belief.map is not None
        assert np.isfinite(belief.pose_mean).all()
        check_storage(belief.maps)
        for i in range(len(belief.particles)):
            for m in belief.regions_of(i):
                size = 2 + 3 * int(m.n)
                assert np.isfinite(m.state[:size]).all()
                assert np.all(np.diff(m.state[[1, 2, 5, 8][: m.n + 1]]) > 0)
                assert all(m.state[4 + 3 * i] > m.state[3 + 3 * i] for i in range(m.n))
                assert np.linalg.eigvalsh(m.cov[:size, :size]).min() > -1e-9
                assert m.main == 1 if m.n == 3 else m.main < m.n
                assert m.closed[[2, 5][: m.n - 1]].all()  # joints are known lines
                assert m.rival < 0 or belief.maps.slots[m.rival].id != m.id


def test_a_scan_without_measurements_keeps_the_motion() -> None:
    slam = RegionSLAM(SlamConfig(n_particles=2), seed=0)
    belief = slam.step(Odometry(1.0, 0.0, 0.5), Scan())
    np.testing.assert_allclose(belief.pose_mean, [1.0, 0.0, 0.5])
    np.testing.assert_allclose(np.diag(belief.pose_cov), [MOTION.distance, 0.0, 0.0001 + 0.0009 * 0.5], atol=1e-12)
    assert len(belief.map) == 0
    assert belief.where() == {}


def test_prediction_alone_widens_the_belief() -> None:
    slam = RegionSLAM(seed=0)
    slam.predict(Odometry(1.0))
    slam.predict(Odometry(1.0))
    np.testing.assert_allclose(slam.belief.pose_mean, [2.0, 0.0, 0.0])
    assert slam.belief.pose_cov[0, 0] == pytest.approx(2 * MOTION.distance)


def test_a_given_pose_is_taken_as_certain() -> None:
    slam = RegionSLAM(SlamConfig(n_particles=1, confirmed_after=1), seed=0)
    z = RegionMeasurement("office", 1, 0, 2, 2, r=EdgeState.OPEN)
    belief = slam.step(Odometry(0.3), Scan([z]), pose=(5, 5, 1.0))
    np.testing.assert_array_equal(belief.pose_mean[:2], [5, 5])
    assert not belief.pose_cov.any()
    np.testing.assert_array_equal(belief.pose, [5, 5, 1.0])
    (m,) = belief.map.regions
    assert m.open_edges == ("r",)


def test_a_reset_forgets_everything(drive: tuple[Course, list[np.ndarray]]) -> None:
    slam = RegionSLAM(seed=0)
    for odometry, seen in drive[0][:3]:
        slam.step(odometry, Scan(seen))
    belief = slam.reset((1, 2, 3))
    assert belief.pose_mean.tolist() == [1, 2, 3]
    assert len(belief.map) == 0
    assert belief.types == []


def test_a_map_outgrows_its_first_arrays() -> None:
    """More regions than there are slots at first, and links between all of them."""
    slam = RegionSLAM(SlamConfig(n_particles=2, confirmed_after=1), seed=0)
    for row in range(4):
        scan = Scan(
            [RegionMeasurement("office", 6.0 * k, 6.0 * row, 4, 4, links={(k + 1) % 20: 0.9}) for k in range(20)]
        )
        belief = slam.step(Odometry(0.0), scan)
    assert len(belief.map) == 80
    assert all(len(belief.map.neighbours(m)) >= 1 for m in belief.map.regions)


@pytest.mark.parametrize("pose", [(0, 0), (0, 0, math.nan), "home"])
def test_a_bad_start_is_refused(pose: object) -> None:
    with pytest.raises(ValueError, match="pose is"):
        RegionSLAM(seed=0).reset(pose)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="pose is"):
        RegionSLAM(seed=0).step(Odometry(0.0), Scan(), pose=pose)  # type: ignore[arg-type]


def test_bad_odometry_is_refused() -> None:
    with pytest.raises(ValueError, match="odometry"):
        RegionSLAM(seed=0).step(Odometry(math.nan), Scan())


def test_storeys_are_mapped_one_above_the_other() -> None:
    """Rooms of one type and place on two floors are two regions; on the upper floor the lower one is not missed."""
    slam = RegionSLAM(SlamConfig(n_particles=2), seed=0)
    view = np.array([[7.0, -7], [7, 7], [-7, 7], [-7, -7]])
    office, kitchen = RegionMeasurement("office", 0, 0, 5, 4), RegionMeasurement("kitchen", 4.5, 0, 3.5, 4)
    for level, seen in ((0, [office, kitchen]), (1, [office]), (0, [office, kitchen])):
        for _ in range(8):
            belief = slam.step(Odometry(0.0), Scan(seen, view=view, level=level))
    assert [(m.type, m.level) for m in belief.map.regions] == [("office", 0), ("kitchen", 0), ("office", 1)]
    assert belief.map.regions_of_type("kitchen")[0].existence > 4
    assert not belief.lost


def test_a_filter_goes_on_with_the_map_of_another(drive: tuple[Course, list[np.ndarray]]) -> None:
    mapper = RegionSLAM(SlamConfig(n_particles=3), seed=0)
    for odometry, seen in drive[0][:12]:
        mapper.step(odometry, Scan(seen))
    slam = RegionSLAM(SlamConfig(n_particles=2, prior_type={"kitchen": 0.4}), seed=1)
    belief = slam.take_map(mapper)
    check_storage(belief.maps)
    theirs = mapper.belief
    assert belief.map.to_geojson() == theirs.map.to_geojson()
    np.testing.assert_array_equal(belief.pose, theirs.pose)
    before = theirs.features.tobytes()
    for odometry, seen in drive[0][12:]:
        belief = slam.step(odometry, Scan(seen))
    assert [m.id for m in belief.map.regions] == [m.id for m in theirs.map.regions]
    assert theirs.features.tobytes() == before  # nothing is shared with the other filter
    joint = RegionSLAM(SlamConfig(posterior="joint"), seed=0)
    with pytest.raises(ValueError, match="posterior is 'joint'"):
        joint.take_map(mapper)
