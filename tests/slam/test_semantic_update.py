from __future__ import annotations

import math

import numpy as np
import pytest

from slam.comparison import CANDIDATE
from slam.config import SlamConfig
from slam.fastslam import RegionSLAM
from slam.measurement import RegionMeasurement, Scan
from slam.motion import Odometry
from slam.priors import PriorByType, TypePrior
from slam.semantic_update import LIMIT, be_born, believe, covered_share, prior_log_odds, update_semantics
from tests.slam.drawn import OPEN, PRIORS, P, associated, mapped, maps, measured, near, particles, stored

ROOM = [0.0, -2, 2, -1.5, 1.5]


def after(*scan: RegionMeasurement, start: float = 0.0) -> float:
    """Log-odds of the type of an office after a scan."""
    robots, regions = particles(), maps(mapped(ROOM, cov=1e-4))
    regions["type_log_odds"] = start
    records = measured(*scan)
    _, candidates, n = associated(robots, regions, records)
    drawn = stored(regions)
    update_semantics(robots, drawn, *near(drawn), records, candidates, n, P, PRIORS)
    return float(regions[0, 0].type_log_odds)


def seen(type: str, confidence: float, w: float = 4.0, h: float = 3.0) -> RegionMeasurement:
    return RegionMeasurement(type, 0, 0, w, h, confidence=confidence)


def test_support_and_opposition_by_hand() -> None:
    """Eqs. (9), (10), (13); the missing side counts one half, overlap is complete."""
    assert after(seen("office", 0.9)) == pytest.approx(0.9 - 0.5)
    assert after(seen("kitchen", 0.8)) == pytest.approx(0.5 - 0.8)
    assert after(seen("office", 0.9), seen("kitchen", 0.6)) == pytest.approx(0.9 - 0.6)
    assert after(seen("office", 0.9), seen("kitchen", 0.6), seen("lobby", 0.2)) == pytest.approx(0.9 - 0.4)
    assert after(seen("office", 0.9), start=1.5) == pytest.approx(1.9)


def test_the_prior_enters_once() -> None:
    """A region is born with its prior and its first support; further scans don't count the prior again."""
    slam = RegionSLAM(SlamConfig(prior_type=0.3, n_particles=1, confirmed_after=1), seed=0)
    for count in range(1, 4):
        belief = slam.step(Odometry(0.0), Scan([seen("office", 0.9)]))
        assert belief.features[0].type_log_odds == pytest.approx(math.log(0.3 / 0.7) + count * 0.4)


def bayes(log_odds: float, p_supp: float, p_opp: float, prior: float, literal: bool) -> float:
    """Eqs. (7) and (12) in probabilities; the inverse model is completed with the prior unless it is read literally."""
    given = 1 / (1 + math.exp(p_opp - p_supp))
    if not literal:
        given = 1 / (1 + (1 - given) / given * (1 - prior) / prior)
    return log_odds + math.log(given / (1 - given)) - math.log(prior / (1 - prior))


@pytest.mark.parametrize("semantics", ["completed", "paper"])
def test_belief_against_the_bayes_filter(semantics: str) -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        prior, confidence = rng.uniform(0.05, 0.95, 2)
        p = SlamConfig(prior_type=float(prior), semantics=semantics).priors()
        m = mapped(ROOM)
        be_born(m, confidence, p)
        expected = bayes(math.log(prior / (1 - prior)), confidence, 0.5, prior, semantics == "paper")
        assert m.type_log_odds == pytest.approx(expected)
        for p_supp, p_opp in rng.uniform(0, 1, (3, 2)):
            believe(m, p_supp, p_opp, p)
            expected = bayes(expected, p_supp, p_opp, prior, semantics == "paper")
            assert m.type_log_odds == pytest.approx(expected)


def test_read_literally_a_low_prior_confirms_every_hypothesis() -> None:
    """What is measured is half against it, and yet it ends at the upper limit; with a prior of one half it stays."""
    for prior, end in ((0.1, LIMIT), (0.9, -LIMIT), (0.5, 0.4)):
        m, p = mapped(ROOM), SlamConfig(prior_type=prior, semantics="paper").priors()
        be_born(m, 0.9, p)
        for _ in range(20):
            believe(m, 0.5, 0.5, p)
        assert m.type_log_odds == pytest.approx(end)


def test_the_prior_follows_the_dimensions_without_counting_twice() -> None:
    hall = TypePrior(0.6, min_area=20.0, max_area=200.0, outside=0.05)
    p = SlamConfig(prior_type={"closet": 0.2, "hall": hall}).priors()
    inside, outside = math.log(1.5), math.log(0.05 / 0.95)
    m = mapped(ROOM, open_edges=[2])  # 12 m²
    m.type = 1
    be_born(m, 0.9, p)
    assert m.type_log_odds == pytest.approx(inside + 0.4)  # it may yet grow
    m.closed[2] = 1
    believe(m, 0.5, 0.5, p)
    assert m.type_log_odds == pytest.approx(outside + 0.4)  # now it is whole and too small
    m.state[2] = 6.0
    believe(m, 0.9, 0.5, p)
    believe(m, 0.5, 0.5, p)
    assert m.type_log_odds == pytest.approx(inside + 0.8)
    m.state[2], m.closed[2] = 90.0, 0
    believe(m, 0.5, 0.5, p)
    assert m.type_log_odds == pytest.approx(outside + 0.8)  # too large already


def test_priors_by_type_and_for_types_not_named() -> None:
    p = SlamConfig(prior_type={"closet": 0.2, "hall": 0.6}).priors()
    for number, prior in ((0, 0.2), (1, 0.6), (2, 0.5), (9, 0.5)):
        m = mapped(ROOM)
        m.type = number
        assert prior_log_odds(m, p) == pytest.approx(math.log(prior / (1 - prior)))


def test_log_odds_are_clamped() -> None:
    assert after(seen("office", 0.9), start=9.9) == LIMIT
    assert after(seen("kitchen", 0.9), start=-9.9) == -LIMIT


def test_a_desk_is_no_evidence_against_its_office() -> None:
    assert after(seen("desk", 1.0, 1.6, 0.8), start=1.0) == 1.0


def test_a_place_beside_is_no_evidence() -> None:
    """A candidate by its closed edges that covers none of the region is not relevant."""
    robots, regions = particles(), maps(mapped(ROOM, cov=1e-4))
    records = measured(RegionMeasurement("kitchen", 4.8, 0, 4, 3, l=OPEN))
    candidates = np.zeros((1, 1), CANDIDATE)
    drawn = stored(regions)
    update_semantics(robots, drawn, *near(drawn), records, candidates, np.array([1]), P, PRIORS)
    assert regions[0, 0].type_log_odds == 0.0


def test_overlap_is_the_covered_share_of_the_measurement() -> None:
    """Eq. (11), with two standard deviations of tolerance and no limit where the region is open."""
    m = mapped(ROOM, cov=1e-12)
    z = measured(
        RegionMeasurement("office", 3.0, 0, 4, 3, cov_xy=np.eye(2) * 1e-10, cov_wh=np.eye(2) * 1e-10, var_phi=1e-10)
    )
    pose = np.zeros(3)
    assert covered_share(z[0, 0], m, 0, pose)[0] == pytest.approx(0.25, abs=1e-4)  # [1, 2] of [1, 5]
    assert covered_share(z[0, 0], mapped(ROOM, cov=1e-12, open_edges=[2]), 0, pose)[0] == pytest.approx(1.0)
    assert covered_share(z[0, 0], mapped(ROOM, (9, 0), cov=1e-12), 0, pose)[0] == 0.0
    wide = measured(RegionMeasurement("office", 3.0, 0, 4, 3, cov_xy=np.eye(2) * 0.01, cov_wh=np.eye(2) * 1e-10))
    assert covered_share(wide[0, 0], m, 0, pose)[0] == pytest.approx((1 + 2 * 0.1) / 4, abs=1e-3)


def test_scans_of_a_thin_door_support_it_in_spite_of_noise() -> None:
    slam = RegionSLAM(SlamConfig(n_particles=1, confirmed_after=1), seed=0)
    rng = np.random.default_rng(0)
    for _ in range(10):
        x, y = (2, 0.5) + 0.05 * rng.standard_normal(2)
        w = 0.2 * (1 + 0.1 * rng.standard_normal())
        belief = slam.step(Odometry(0.0), Scan([RegionMeasurement("door", x, y, w, 0.9)]), pose=(0, 0, 0))
    assert len(belief.map.regions) == 1
    assert belief.features[0].type_log_odds > 3.0


@pytest.mark.parametrize("prior", [0.1, 0.3, 0.5, {"office": 0.1, "kitchen": 0.6}])
@pytest.mark.parametrize("seed", range(4))
def test_the_right_type_wins_over_twenty_percent_misclassification(seed: int, prior: PriorByType) -> None:
    rng = np.random.default_rng(seed)
    slam = RegionSLAM(SlamConfig(n_particles=1, prior_type=prior), seed=seed)
    for _ in range(60):
        x, y, w, h = (0.5, 0.2, 4, 3) + np.array([0.05, 0.05, 0.05, 0.05]) * rng.standard_normal(4)
        types = ["kitchen", "lobby", "storage"] if rng.random() < 0.2 else ["office"]
        z = RegionMeasurement(str(rng.choice(types)), x, y, w, h, 0.01 * rng.standard_normal())
        belief = slam.step(Odometry(0.0), Scan([z]))
    assert [m.type for m in belief.map.regions] == ["office"]
    assert belief.map.regions[0].type_log_odds > 2.0
    assert belief.map.region_at(0.5, 0.2).type == "office"
