import numpy as np
import pytest

from regionslam_env import tables
from regionslam_env.observations import LinkColumn as L
from regionslam_env.observations import RegionColumn as C
from slam.maps import INSIDE
from slam.region import b_index, u_index
from slam.rows import Row
from tests.env.believed import Believed

N_TYPES = 4


class Tables:
    """Slots and the tables written for them."""

    def __init__(self, n_slots=4, goal=3, types=(0, 1)):
        self.ids, self.places = np.full(n_slots, -1), np.full(n_slots, -1)
        self.goal, self.types = goal, np.array(types)

    def write(self, belief, heaviest=0):
        n = len(self.ids)
        self.rows = np.zeros((n, C.TYPES + N_TYPES), np.float32)
        self.mask, self.links_mask = np.zeros(n, np.int8), np.zeros(4 * n, np.int8)
        self.links = np.zeros((4 * n, 4), np.float32)
        s = belief.set
        tables.write_map(
            *(self.rows, self.mask, self.links, self.links_mask, self.ids, self.places),
            *(s.particles[heaviest]["pose"], heaviest, s.particles, tuple(s.maps)),
            *(self.types, N_TYPES, self.goal, 3),
        )
        return self

    @property
    def link_rows(self):
        return self.links[self.links_mask == 1].astype(float).round(4).tolist()


def test_a_row_of_three_rectangles_in_the_robots_frame():
    belief = Believed(pose=(1.0, 2.0, np.pi / 2))
    belief.put(
        0, 7, at=(3.0, 2.0), phi=np.pi / 2, u=(-4.0, -1.0, 1.0, 3.0), b=(-1.0, -2.0, 0.0), t=(0.0, 2.0, 1.0), main=1,
        p=0.75, existence=0.9, visited=1,
    )  # fmt: skip
    row = Tables().write(belief).rows[0]
    expected = [0.0, -2.0, 1.0, 0.0, 2.0, 4.0, 3.0, 1.0, -0.5, 2.0, 1.0, 0.5]
    assert row[C.X : C.OPEN_T] == pytest.approx(expected, abs=1e-6)
    assert not row[C.OPEN_T : C.EXISTENCE].any()
    assert row[C.EXISTENCE] == pytest.approx(0.9)
    assert row[C.TYPE_P] == pytest.approx(0.75)
    assert row[C.VISITED] == 1


def test_the_geometry_is_that_of_the_papers_parameters():
    rng = np.random.default_rng(3)
    for n, main in ((1, 0), (2, 0), (2, 1), (3, 1)):
        u = np.cumsum(rng.uniform(0.5, 3, n + 1))
        b, t = -rng.uniform(0.5, 2, n), rng.uniform(0.5, 2, n)
        x, y, phi = rng.normal(size=3)
        pose = rng.normal(size=3)
        row = Row(x, y, phi, u, b, t, main).parameters()
        belief = Believed(pose=pose).put(0, 1, at=(x, y), phi=phi, u=u, b=b, t=t, main=main)
        written = Tables().write(belief).rows[0]
        c, s = np.cos(pose[2]), np.sin(pose[2])
        dx, dy = row["x"] - pose[0], row["y"] - pose[1]
        assert written[C.X : C.COS] == pytest.approx([c * dx + s * dy, c * dy - s * dx], abs=1e-5)
        assert np.arctan2(written[C.SIN], written[C.COS]) == pytest.approx(
            np.arctan2(np.sin(phi - pose[2]), np.cos(phi - pose[2])), abs=1e-5
        )
        sides = [*(row["left"] or (0, 0, 0)), *(row["right"] or (0, 0, 0))]
        assert written[C.W : C.OPEN_T] == pytest.approx([row["w"], row["h"], *sides], abs=1e-5)


@pytest.mark.parametrize(
    ("index", "column"),
    [
        (u_index(0), C.OPEN_LL), (b_index(0) + 1, C.OPEN_TL), (b_index(0), C.OPEN_BL),
        (b_index(1) + 1, C.OPEN_T), (b_index(1), C.OPEN_B),
        (u_index(3), C.OPEN_RR), (b_index(2) + 1, C.OPEN_TR), (b_index(2), C.OPEN_BR),
    ],
)  # fmt: skip
def test_each_open_edge_has_its_flag(index, column):
    belief = Believed().put(0, 1, u=(-3.0, -1.0, 1.0, 3.0), b=(-1.0,) * 3, t=(1.0,) * 3, main=1)
    belief.region(0).closed[index] = 0
    flags = Tables().write(belief).rows[0, C.OPEN_T : C.EXISTENCE]
    assert np.nonzero(flags)[0].tolist() == [column - C.OPEN_T]


@pytest.mark.parametrize(("index", "column"), [(u_index(0), C.OPEN_L), (u_index(1), C.OPEN_R)])
def test_ends_of_a_single_rectangle(index, column):
    belief = Believed().put(0, 1)
    belief.region(0).closed[index] = 0
    flags = Tables().write(belief).rows[0, C.OPEN_T : C.EXISTENCE]
    assert np.nonzero(flags)[0].tolist() == [column - C.OPEN_T]


def test_a_region_keeps_its_slot_while_others_go_and_come():
    belief = Believed().put(0, 10).put(1, 11).put(2, 12)
    tables = Tables().write(belief)
    assert tables.ids.tolist() == [10, 11, 12, -1]
    tables.write(belief.remove(1))
    assert tables.mask.tolist() == [1, 0, 1, 0] and not tables.rows[1].any()
    tables.write(belief.put(1, 20))
    assert tables.ids.tolist() == [10, 11, 12, 20]
    tables.write(belief.put(3, 11))  # the lost one is found again, elsewhere in the map
    assert tables.ids.tolist() == [10, 11, 12, 20] and tables.mask.tolist() == [1, 1, 1, 1]


def test_the_slot_of_a_lost_region_is_used_before_another_is_evicted():
    belief = Believed().put(0, 10, at=(9.0, 0.0)).put(1, 11).put(2, 12).put(3, 13)
    tables = Tables().write(belief)
    tables.write(belief.remove(1).put(4, 20))
    assert tables.ids.tolist() == [10, 20, 12, 13]


def test_tentative_regions_are_not_shown():
    tables = Tables().write(Believed().put(0, 10, sightings=2).put(1, 11, sightings=3))
    assert tables.ids.tolist() == [11, -1, -1, -1]


def test_slots_follow_ids_through_a_change_of_the_heaviest_particle():
    belief = Believed(n_particles=2)
    belief.put(0, 10, at=(1.0, 0.0), particles=[0]).put(1, 11, at=(2.0, 0.0), particles=[0])
    belief.put(0, 10, at=(1.5, 0.0), particles=[1]).put(1, 11, at=(2.5, 0.0), particles=[1])
    tables = Tables().write(belief)
    assert tables.rows[:2, C.X].tolist() == [1.0, 2.0]
    tables.write(belief, heaviest=1)
    assert tables.ids.tolist()[:2] == [10, 11] and tables.rows[:2, C.X].tolist() == [1.5, 2.5]


def test_the_farthest_is_evicted_and_the_nearer_ones_stay():
    belief = Believed()
    for i, x in enumerate((10.0, 40.0, 20.0, 30.0)):
        belief.put(i, 100 + i, at=(x, 0.0))
    tables = Tables().write(belief)
    tables.write(belief.put(4, 104, at=(5.0, 0.0)))
    assert tables.ids.tolist() == [100, 104, 102, 103]
    tables.write(belief.put(5, 105, at=(50.0, 0.0)))
    assert tables.ids.tolist() == [100, 104, 102, 103]


def test_a_region_of_the_goal_type_outlasts_nearer_ones():
    belief = Believed().put(0, 100, "hallway", at=(40.0, 0.0))
    for i in range(1, 4):
        belief.put(i, 100 + i, at=(20.0 + i, 0.0))
    tables = Tables(goal=1).write(belief)
    tables.write(belief.put(4, 104, at=(5.0, 0.0)))
    assert tables.ids.tolist() == [100, 101, 102, 104]


def test_furniture_goes_first():
    belief = Believed()
    for i in range(4):
        belief.put(i, 100 + i, at=(10.0 + i, 0.0))
    belief.link(1, 0, INSIDE)
    tables = Tables().write(belief)
    tables.write(belief.put(4, 104, at=(5.0, 0.0)))
    assert tables.ids.tolist() == [100, 104, 102, 103]


def test_type_probabilities_sum_to_one_and_include_rivals():
    belief = Believed().put(0, 1, "office", p=0.7).put(1, 2, "hallway", p=0.2, rival=0).put(2, 3, "hallway", p=0.9)
    tables = Tables().write(belief)
    assert tables.mask.tolist() == [1, 1, 0, 0]  # the rival has no row of its own
    assert tables.rows[0, C.TYPES :] == pytest.approx([0.7, 0.2, 0.05, 0.05])
    assert tables.rows[1, C.TYPES :] == pytest.approx([0.1 / 3, 0.9, 0.1 / 3, 0.1 / 3])
    assert not tables.rows[2:].any()


def test_rivals_that_are_both_likely_share_what_there_is():
    belief = Believed().put(0, 1, "office", p=0.9).put(1, 2, "hallway", p=0.6, rival=0)
    assert Tables().write(belief).rows[0, C.TYPES :] == pytest.approx([0.6, 0.4, 0, 0])


def test_types_outside_the_vocabulary_share_a_column():
    belief = Believed(types=("office", "hallway", "cellar", "vault")).put(0, 1, "vault", p=0.7)
    row = Tables(types=(0, 1, 3, 3)).write(belief).rows[0]
    assert row[C.TYPES :] == pytest.approx([0.1, 0.1, 0.1, 0.7])


def test_p_contains_me_is_over_all_particles_and_their_own_maps():
    belief = Believed(n_particles=4).put(0, 1, at=(0.0, 0.0)).put(1, 2, at=(2.0, 0.0))
    belief.set.particles["log_weight"] = np.log([0.4, 0.3, 0.2, 0.1])
    belief.set.particles["expected"][:, 0] = [0.0, 0.5, 1.5, 9.0]
    belief.remove(0, particles=[1])  # this particle does not know the first region
    rows = Tables().write(belief).rows
    assert rows[:2, C.CONTAINS_ME] == pytest.approx([0.4, 0.2])


def test_p_contains_me_of_an_uncertain_pose():
    belief = Believed().put(0, 1, u=(0.0, 50.0), b=(-50.0,), t=(50.0,))
    belief.set.particles["spread"][0] = np.diag([0.04, 0.04, 0.01])
    assert Tables().write(belief).rows[0, C.CONTAINS_ME] == pytest.approx(0.5)  # the edge runs through the robot


def test_adjacency_stands_once_and_the_strongest_first():
    belief = Believed().put(0, 1).put(1, 2).put(2, 3)
    belief.link(0, 1, p=0.6).link(1, 0, p=0.8).link(2, 1, p=0.9).link(0, 2, p=0.05)
    assert Tables().write(belief).link_rows == [[1.0, 2.0, 0.9, 0.0], [0.0, 1.0, 0.8, 0.0]]
    assert [L.FIRST, L.SECOND, L.PROBABILITY, L.KIND] == [0, 1, 2, 3]


def test_of_a_containment_the_second_is_inside_the_first():
    belief = Believed().put(0, 1).put(1, 2).link(0, 1, INSIDE, p=0.7)
    assert Tables().write(belief).link_rows == [[1.0, 0.0, 0.7, 1.0]]


def test_stale_links_and_links_to_regions_without_a_slot_are_left_out():
    belief = Believed().put(0, 1).put(1, 2).put(2, 3, rival=0)
    belief.link(0, 1, target_id=99).link(0, 2)
    assert Tables().write(belief).link_rows == []


def test_more_links_than_rows_keep_the_strongest():
    rows = np.zeros((3, 4), np.float32)
    count = 0
    for i, p in enumerate((0.3, 0.9, 0.5, 0.7, 0.4, 0.9)):
        count = tables.insert_link(rows, count, i, i, p, 0)
    assert count == 3
    assert rows[:, 0].tolist() == [1.0, 5.0, 3.0]
