import numpy as np
import pytest
from gymnasium import spaces

from regionslam_env.config import SEMANTIC_TYPES, RobotConfig
from regionslam_env.missions.mission import GoTo
from regionslam_env.observations import (
    COVARIANCE_LIMIT,
    Observer,
    RegionColumn,
    link_table,
    observation_space,
    observed_types,
    region_table,
)
from regionslam_env.tables import LENGTH_LIMIT
from slam.belief import Belief
from slam.motion import Odometry
from slam.region import EDGE_NAMES
from tests.env.believed import Believed

ROBOT = RobotConfig()
TYPES = ("office", "hallway", "other")


def observer(n_slots=4, types=TYPES):
    made = Observer(types, n_slots, ROBOT, n_lidar_rays=6, lidar_range=5.0)
    made.reset()
    made.aim(GoTo("hallway"))
    return made


def belief_of(built, pose_mean=(0.0, 0.0, 0.0), pose_cov=None):
    s = built.set
    return Belief(
        pose_mean=np.array(pose_mean, dtype=float),
        pose_cov=np.zeros((3, 3)) if pose_cov is None else np.array(pose_cov, dtype=float),
        ess=1.0,
        pose=s.particles[0]["pose"].copy(),
        heaviest=0,
        types=built.types,
        particles=s.particles,
        maps=s.maps,
        confirmed_after=3,
    )


def observe(made, belief=None, odometry=Odometry(0.0), ranges=(1.0,) * 6, **told):  # noqa: B008 - frozen
    told = {"elapsed": 0.0, "completed": 0.0, "declared": False} | told
    return made.observe(belief or belief_of(Believed()), odometry, np.array(ranges), **told)


def test_pose_and_covariance():
    covariance = [[4.0, 0.5, 0.1], [0.5, 2.0, 0.2], [0.1, 0.2, 0.3]]
    observation = observe(observer(), belief_of(Believed(), (1.0, -2.0, np.pi / 2), covariance))
    assert observation["pose"] == pytest.approx([1.0, -2.0, 0.0, 1.0], abs=1e-6)
    assert observation["pose_cov"] == pytest.approx(np.ravel(covariance))


def test_velocity_is_odometry_over_the_step():
    observation = observe(observer(), odometry=Odometry(0.05, 0.3, -0.1))
    assert observation["velocity"] == pytest.approx([0.5, -1.0])


def test_lidar_goal_and_progress():
    told = {"elapsed": 0.25, "completed": 0.5, "declared": True}
    observation = observe(observer(), ranges=(0.0, 1.0, 2.0, 5.0, 7.0, -1.0), **told)
    assert observation["lidar"].tolist() == [0.0, 1.0, 2.0, 5.0, 5.0, 0.0]
    assert observation["goal"].tolist() == [0.0, 1.0, 0.0]
    assert observation["progress"].tolist() == [0.25, 0.5, 1.0, 1.0, 0.0, 0.0]


def test_what_is_beyond_all_bounds_is_clipped_to_them():
    made = observer()
    built = Believed().put(0, 1, at=(1e7, -1e7), u=(-1e6, 1e6))
    observation = observe(made, belief_of(built, (1e9, -1e9, 0.0), np.full((3, 3), -1e9)), Odometry(99.0, 0.0, -99.0))
    assert observation in made.space
    assert observation["pose"][:2].tolist() == [LENGTH_LIMIT, -LENGTH_LIMIT]
    assert observation["pose_cov"][0] == -COVARIANCE_LIMIT
    assert observation["velocity"].tolist() == [2.0, -4.0]
    assert region_table(observation)[0, : RegionColumn.COS].tolist() == [LENGTH_LIMIT, -LENGTH_LIMIT]
    assert region_table(observation)[0, RegionColumn.W] == LENGTH_LIMIT


def test_tables_give_the_rows_back():
    built = Believed().put(0, 1, at=(3.0, 0.0)).put(1, 2, "hallway", at=(0.0, 4.0)).link(0, 1, p=0.75)
    observation = observe(observer(), belief_of(built))
    assert observation["regions"].shape == (4 * (RegionColumn.TYPES + 3),)
    assert region_table(observation)[:2, : RegionColumn.COS].tolist() == [[3.0, 0.0], [0.0, 4.0]]
    assert link_table(observation)[0].tolist() == [0.0, 1.0, 0.75, 0.0]
    assert np.shares_memory(region_table(observation), observation["regions"])


def test_types_that_the_filter_meets_later_get_their_column():
    made = observer()
    built = Believed(types=("office",)).put(0, 1, "office", p=0.9)
    observe(made, belief_of(built))
    built.types += ["cellar", "hallway"]
    built.put(1, 2, "cellar", p=0.9).put(2, 3, "hallway", p=0.9)
    rows = region_table(observe(made, belief_of(built)))
    assert rows[:3, RegionColumn.TYPES :].argmax(axis=1).tolist() == [0, 2, 1]


def test_a_reset_frees_every_slot():
    made = observer()
    observe(made, belief_of(Believed().put(0, 1).put(1, 2)))
    assert made.slot_ids.tolist() == [1, 2, -1, -1]
    made.reset()
    made.aim(GoTo("office"))
    observation = observe(made, belief_of(Believed().put(0, 7)))
    assert made.slot_ids.tolist() == [7, -1, -1, -1] and observation["goal"].tolist() == [1.0, 0.0, 0.0]


def test_open_edges_stand_in_the_order_of_the_papers_names():
    names = [column.name.removeprefix("OPEN_").lower() for column in RegionColumn if column.name.startswith("OPEN_")]
    assert tuple(names) == EDGE_NAMES


def test_the_space_is_flat_and_bounded():
    space = observation_space(8, len(SEMANTIC_TYPES), ROBOT, 180, 10.0)
    for part in space.values():
        assert isinstance(part, spaces.Box | spaces.MultiBinary) and len(part.shape) == 1
        if isinstance(part, spaces.Box):
            assert part.dtype == np.float32 and np.isfinite(part.low).all() and np.isfinite(part.high).all()
            assert (part.low < part.high).all()


def test_other_is_always_the_last_type():
    assert observed_types(("a", "b")) == ("a", "b", "other")
    assert observed_types(("other", "a")) == ("a", "other")
    assert observed_types(SEMANTIC_TYPES) == SEMANTIC_TYPES


@pytest.mark.parametrize("types", ["office", (), ("other",), ("a", "a"), ("a", ""), (1, 2)])
def test_what_are_no_types_is_refused(types):
    with pytest.raises(ValueError, match="semantic_types is"):
        observed_types(types)
