import numpy as np
import pytest

from regionslam_env.belief import Localizer
from slam.config import SlamConfig
from slam.measurement import RegionMeasurement, Scan
from slam.mixture import weigh_inside
from slam.motion import MotionNoise, Odometry
from tests.env.believed import Believed

OFFICE, HALLWAY = 0, 1
NOISE = MotionNoise(distance=0.01, heading_per_metre=0.02, heading_per_radian=0.03)


def localizer(localization):
    made = Localizer(localization, SlamConfig(n_particles=1, motion_noise=NOISE))
    made.reset(np.random.default_rng(0))
    return made


def office_ahead(x, y, theta):
    """A scan of a 4 x 4 m office around the map's (5, 0), from a pose."""
    c, s = np.cos(theta), np.sin(theta)
    dx, dy = 5.0 - x, -y
    return Scan([RegionMeasurement("office", c * dx + s * dy, c * dy - s * dx, 4.0, 4.0, -theta)])


def test_the_oracle_takes_the_true_pose_as_certain():
    made, true = localizer("oracle"), np.array([1.0, 0.5, 0.3])
    belief = made.step(Odometry(9.0, 0.0, 1.0), office_ahead(*true), true)
    assert belief.pose_mean == pytest.approx(true) and not belief.pose_cov.any()


def test_dead_reckoning_ignores_truth_and_measurements():
    made = localizer("odometry")
    for _ in range(3):
        belief = made.step(Odometry(1.0), office_ahead(0, 0, 0), np.array([50.0, 50.0, 1.0]))
    assert belief.pose_mean == pytest.approx([3.0, 0.0, 0.0])
    belief = made.step(Odometry(0.0, 0.0, np.pi / 2), Scan(), np.zeros(3))
    belief = made.step(Odometry(2.0), Scan(), np.zeros(3))
    assert belief.pose_mean == pytest.approx([3.0, 2.0, np.pi / 2])


def test_dead_reckoning_tells_its_uncertainty():
    belief = localizer("odometry").step(Odometry(2.0, 0.0, 0.5), Scan(), np.zeros(3))
    heading = 0.02 * 2 + 0.03 * 0.5
    assert belief.pose_cov == pytest.approx(np.diag([0.01 * 2, 0.0, heading]))
    assert belief.particles[0]["spread"] == pytest.approx(belief.pose_cov)


@pytest.mark.parametrize(("localization", "x"), [("oracle", 5.0), ("odometry", 4.0)])
def test_regions_are_mapped_from_the_pose_of_the_rung(localization, x):
    made = localizer(localization)
    for _ in range(4):  # odometry has missed a metre that the truth has driven
        belief = made.step(Odometry(0.0), office_ahead(1.0, 0.0, 0.0), np.array([1.0, 0.0, 0.0]))
    (office,) = belief.map.regions
    assert (office.x, office.y) == pytest.approx((x, 0.0), abs=0.01)


def test_a_reset_forgets_pose_and_map():
    made = localizer("odometry")
    made.step(Odometry(1.0), office_ahead(0, 0, 0), np.zeros(3))
    made.reset(np.random.default_rng(0))
    belief = made.step(Odometry(0.0), Scan(), np.zeros(3))
    assert not belief.pose_mean.any() and not belief.pose_cov.any() and not (belief.features["n"] > 0).any()


def test_probability_in_a_type_is_the_weight_of_the_particles_inside():
    built = Believed(n_particles=3).put(0, 1, "office", at=(0.0, 0.0)).put(1, 2, "office", at=(0.5, 0.0))
    built.put(2, 3, "hallway", at=(5.0, 0.0)).put(3, 4, "hallway", rival=0).put(4, 5, "hallway", sightings=2)
    built.set.particles["log_weight"] = np.log([0.5, 0.3, 0.2])
    built.set.particles["expected"][:, 0] = [0.0, 5.0, 20.0]
    assert weigh_inside(built.set.particles, tuple(built.maps), OFFICE, 3) == pytest.approx(0.5)  # once, though in two
    assert weigh_inside(built.set.particles, tuple(built.maps), HALLWAY, 3) == pytest.approx(0.3)


def test_probability_in_a_type_nobody_has_seen_is_zero():
    belief = localizer("slam").step(Odometry(0.0), office_ahead(0, 0, 0), np.zeros(3))
    assert belief.probability_in("kitchen") == 0
