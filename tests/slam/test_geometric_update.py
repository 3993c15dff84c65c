from __future__ import annotations

import numpy as np
import pytest

from slam.association import NEW
from slam.edge_form import FLAT_VARIANCE, state_size
from slam.geometric_update import doubt_pose, fuse, start, update_geometry
from slam.growth import grow, shift_right
from slam.innovation import workspace
from slam.measurement import RegionMeasurement
from slam.region import REGION, is_u
from tests.slam import naive
from tests.slam.drawn import (
    CLOSED,
    OPEN,
    P,
    links_to,
    mapped,
    maps,
    measured,
    near,
    particles,
    random_state,
    sense,
    stored,
)

ORIGIN = np.zeros(3)


def blank() -> np.record:
    return np.zeros(1, REGION)[0]


def test_a_new_region_lies_where_it_was_measured() -> None:
    z = measured(RegionMeasurement("office", 2.0, 1.0, 4.0, 3.0, 0.3))[0, 0]
    pose = np.array([5.0, -1.0, 1.1])
    m = blank()
    start(z, pose, m, P)
    c, s = np.cos(1.1), np.sin(1.1)
    np.testing.assert_allclose(m.anchor, [5 + c * 2 - s * 1, -1 + s * 2 + c * 1])
    np.testing.assert_allclose(m.state[:5], [1.4, -2, 2, -1.5, 1.5], atol=1e-12)
    assert (m.n, m.rival, m.sightings) == (1, -1, 1)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_covariance_of_a_new_region_is_that_of_its_lines_about_the_anchor(n: int) -> None:
    rng = np.random.default_rng(n)
    size = state_size(n)
    z = sense(random_state(rng, n), naive.random_covariance(rng, size))
    z.state[1:size] += 3.0
    z.main = n // 2
    pose = np.array([1.0, 2.0, -0.4])
    m = blank()
    start(z, pose, m, P)
    anchor = m.anchor.copy()

    def lines_about_anchor(lines: np.ndarray) -> np.ndarray:
        about = lines.copy()
        about[0] = lines[0] + pose[2]
        shift = naive.seen_from(np.array([about[0], *[0.0] * (size - 1)]), anchor, pose)
        about[1:] = lines[1:] - shift[1:]
        return about

    j = naive.derivative(lines_about_anchor, z.state[:size])
    np.testing.assert_allclose(m.cov[:size, :size], j @ z.cov[:size, :size] @ j.T, atol=1e-8)
    np.testing.assert_allclose(m.state[1:size], lines_about_anchor(z.state[:size])[1:], atol=1e-12)
    np.testing.assert_allclose(naive.seen_from(m.state[:size], anchor, pose)[1:], z.state[1:size], atol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_new_region_is_as_uncertain_as_the_pose_it_was_seen_from(n: int) -> None:
    """Seen from a pose that is off, the same measurement lies elsewhere: finite differences give the derivative."""
    rng = np.random.default_rng(n)
    size, pose, step = state_size(n), np.array([1.0, 2.0, -0.4]), 1e-6
    pose_cov = naive.random_covariance(rng, 3, 0.1)
    z = sense(random_state(rng, n), naive.random_covariance(rng, size))
    z.main = n // 2
    m = blank()
    start(z, pose, m, P)
    derivative = np.empty((size, 3))
    for k in range(3):
        moved = blank()
        start(z, pose + step * np.eye(3)[k], moved, P)
        state = moved.state[:size].copy()
        apart, phi = moved.anchor - m.anchor, moved.state[0]
        for j in range(1, size):
            normal = (np.cos(phi), np.sin(phi)) if is_u(j) else (-np.sin(phi), np.cos(phi))
            state[j] += np.dot(normal, apart)
        derivative[:, k] = (state - m.state[:size]) / step
    before = m.cov[:size, :size].copy()
    doubt_pose(m, pose, pose_cov)
    np.testing.assert_allclose(m.cov[:size, :size] - before, derivative @ pose_cov @ derivative.T, atol=1e-4, rtol=1e-4)


def test_an_uncertain_pose_counts_as_noise_of_the_measurement() -> None:
    """Of a region whose heading is known, seen from a pose that is off along x alone, both lines along u say less."""
    before, after = np.diag([1e-9, 0.04, 0.04, 0.04, 0.04]), np.diag([1e-9, 0.02, 0.02, 0.02, 0.02])
    m = mapped(np.array([0.0, -2, 2, -1, 1]), np.zeros(2), before)
    z = sense(np.array([0.0, -1.9, 2.1, -1, 1]), np.diag([1e-9, 0.01, 0.01, 0.04, 0.04]))
    work = workspace()
    work.pose_cov[0, 0] = 0.03
    fuse(z, m, 0, ORIGIN, work)
    # S = 0.04 + 0.01 on the diagonal, and the pose's 0.03 in all of it: r = 0.1 twice.
    gain = 0.04 * np.linalg.inv(np.array([[0.08, 0.03], [0.03, 0.08]]))
    np.testing.assert_allclose(m.state[1:3], np.array([-2, 2]) + gain @ [0.1, 0.1], atol=1e-6)
    np.testing.assert_allclose(m.cov[1:3, 1:3], 0.04 * np.eye(2) - 0.04 * gain, atol=1e-6)
    np.testing.assert_allclose(np.diag(m.cov)[3:5], np.diag(after)[3:5], atol=1e-6)


def test_an_open_edge_begins_inside_the_view_and_knows_nothing() -> None:
    z = measured(RegionMeasurement("office", 0.0, 0.0, 4.0, 3.0, r=OPEN, b=OPEN))[0, 0]
    m = blank()
    start(z, ORIGIN, m, P)
    sigma = np.sqrt(0.1**2 + 0.15**2 / 4)
    np.testing.assert_allclose(m.state[:5], [0, -2, 2 - sigma, -1.5 + sigma, 1.5])
    assert m.closed[:5].tolist() == [1, 1, 0, 0, 1]
    assert m.cov[2, 2] == m.cov[3, 3] == pytest.approx(FLAT_VARIANCE * sigma**2)
    assert not np.any(m.cov[2, [0, 1, 3, 4]])


def bent(z: np.record, turn: float) -> np.ndarray:
    """How far the lines of z move when its main rectangle turns about the robot, less the part linear in the turn."""
    k, i = naive.u_places(z.n)[z.main], naive.bt_places(z.n)[z.main][0]
    k1 = naive.u_places(z.n)[z.main + 1]
    middle = np.array([z.state[k] + z.state[k1], z.state[i] + z.state[i + 1]]) / 2
    along, across = naive.axes(turn)
    du, dv = along @ middle - middle[0] - turn * middle[1], across @ middle - middle[1] + turn * middle[0]
    out = np.full(state_size(z.n), dv)
    out[naive.u_places(z.n)] = du
    out[0] = 0.0
    return out


@pytest.mark.parametrize("n", [1, 2, 3])
def test_fusing_closed_edges_is_the_textbook_update(n: int) -> None:
    rng = np.random.default_rng(n)
    size = state_size(n)
    pose = np.array([0.3, 0.4, -0.2])
    m = mapped(random_state(rng, n), (1.0, -0.5), naive.random_covariance(rng, size, 0.05))
    anchor = m.anchor.copy()
    lines = naive.seen_from(m.state[:size], anchor, pose) + rng.normal(0, 0.03, size)
    noise = naive.random_covariance(rng, size, 0.05)
    h = naive.derivative(lambda x: naive.seen_from(x, anchor, pose), m.state[:size])
    residual = lines - naive.seen_from(m.state[:size], anchor, pose)
    z = sense(lines, noise)
    residual += bent(z, m.state[0] - pose[2] - lines[0])
    mean, cov = naive.kalman(m.state[:size].copy(), m.cov[:size, :size].copy(), h, residual, noise)
    fuse(z, m, 0, pose, workspace())
    np.testing.assert_allclose(m.state[:size], mean, atol=1e-9)
    np.testing.assert_allclose(m.cov[:size, :size], cov, atol=1e-9)
    np.testing.assert_array_equal(m.cov, m.cov.T)


def test_the_first_closed_observation_sets_an_edge_with_its_own_covariance() -> None:
    m = mapped([0, -2, 1.2, -1, 1], cov=np.diag([1e-10, 0.01, 0.01, 0.01, 0.01]), open_edges=[2])
    noise = np.diag([0.001, 0.02, 0.03, 0.02, 0.02])
    fuse(sense(np.array([0.0, -2, 2.4, -1, 1]), noise), m, 0, ORIGIN, workspace())
    assert m.closed[2] == 1
    assert m.state[2] == pytest.approx(2.4, abs=1e-5)
    assert m.cov[2, 2] == pytest.approx(0.03, rel=1e-4)
    assert m.state[1] == pytest.approx(-2.0)


def test_the_first_closed_observation_brings_the_lever_of_the_heading() -> None:
    """An anchor off the edge's normal: the uncertain heading of the region moves the line."""
    m = mapped([0, -2, 1.2, -1, 1], anchor=(0, 3), cov=np.diag([0.01, 0.01, 0.01, 0.01, 0.01]), open_edges=[2])
    fuse(sense(np.array([0.0, -2, 2, 2, 4]), np.diag([1e6, 0.02, 0.03, 0.02, 0.02])), m, 0, ORIGIN, workspace())
    assert m.cov[2, 2] == pytest.approx(0.03 + 3**2 * m.cov[0, 0], rel=1e-3)


def test_an_edge_open_in_the_scan_says_nothing_of_a_closed_one() -> None:
    m = mapped([0, -2, 2, -1, 1], cov=0.01)
    z = sense(np.array([0.0, -1, 1, -1, 1]), np.eye(5) * 0.01, closed=[1, 0, 0, 1, 1])
    fuse(z, m, 0, ORIGIN, workspace())
    assert m.state[1:3].tolist() == [-2, 2]
    assert m.cov[1, 1] == m.cov[2, 2] == 0.01
    assert m.cov[3, 3] == pytest.approx(0.005)
    assert m.closed.tolist()[:5] == [1] * 5


def test_a_shorter_view_does_not_pull_a_bound_in() -> None:
    m = mapped([0, -2, 5, -1, 1], cov=0.01, open_edges=[2])
    z = sense(np.array([0.0, -2, 3, -1, 1]), np.eye(5) * 0.01, closed=[1, 1, 0, 1, 1])
    fuse(z, m, 0, ORIGIN, workspace())
    assert (m.state[2], m.closed[2]) == (5.0, 0)
    fuse(sense(np.array([0.0, -2, 7, -1, 1]), np.eye(5) * 0.01, closed=[1, 1, 0, 1, 1]), m, 0, ORIGIN, workspace())
    assert m.state[2] == pytest.approx(6.6)  # four standard deviations inside the view


def test_standing_still_does_not_push_an_open_edge() -> None:
    moved = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        truth, sigma = np.array([0.0, -2.0, 3.0, -1.0, 1.0]), np.array([0.01, 0.1, 0.1, 0.1, 0.1])
        m, work = blank(), workspace()
        start(sense(truth, np.diag(sigma**2), [1, 1, 0, 1, 1]), ORIGIN, m, P)
        first = m.anchor[0] + m.state[2]
        for _ in range(1000):
            z = sense(truth + sigma * rng.standard_normal(5), np.diag(sigma**2), [1, 1, 0, 1, 1])
            fuse(z, m, 0, ORIGIN, work)
        last = m.anchor[0] + m.state[2]
        assert first == pytest.approx(2.9)
        assert 2.9 <= last < 3.15
        moved.append(last - 3.0)
        assert abs(m.anchor[0] + m.state[1] + 2) < 0.02
    assert np.mean(moved) < 0.06  # a naive maximum moves by 0.32


def test_headings_off_to_either_side_do_not_lengthen_a_region() -> None:
    """A hallway's two ends, each seen from before it with an error of the heading, and then with the opposite one."""
    m = mapped([0.0, -9, 9, -1, 1], cov=np.diag([1e-12, 1, 1, 1, 1]))
    work = workspace()
    noise = np.diag([0.1**2, 0.1, 0.1, 0.1, 0.1])
    for x, y, closed in ((-6.0, 1.0, [1, 1, 0, 1, 1]), (6.0, 1.0, [1, 0, 1, 1, 1])):
        for error in (0.1, -0.1):
            pose, middle = np.array([x, y, 0.0]), np.array([-np.sign(x) * 4.0, -y])
            along, across = naive.axes(error)
            u, v = along @ middle, across @ middle
            lines = np.array([error, u - 7, u + 7, v - 1, v + 1])
            z = sense(lines, noise)
            lever = np.array([1.0, v, v, -u, -u])  # the lines are drawn along the noisy heading
            z.cov[:5, :5] = np.outer(lever, lever) * 0.01 + np.diag([0, 0.1, 0.1, 0.1, 0.1])
            z.closed[:5] = closed
            fuse(z, m, 0, pose, work)
    assert m.state[2] - m.state[1] == pytest.approx(18.0, abs=1e-3)


def glimpse(right: float, closed: int = 0) -> np.record:
    """A hallway from -2 to `right`, seen from the origin."""
    return sense(np.array([0.0, -2, right, -1, 1]), np.eye(5) * 0.01, closed=[1, 1, closed, 1, 1])


def test_an_edge_closed_by_mistake_reopens_when_views_keep_ending_beyond_it() -> None:
    m, work = mapped([0, -2, 2, -1, 1], cov=0.01), workspace()
    for _ in range(3):
        fuse(glimpse(3.0), m, 0, ORIGIN, work)
    assert m.closed[2] == 1
    assert m.state[2] == pytest.approx(2.0)
    fuse(glimpse(3.0), m, 0, ORIGIN, work)
    assert (m.closed[2], m.contrary[2]) == (0, 0)
    assert m.state[2] == pytest.approx(3.0 - 0.4)  # a bound from here on, as if never closed
    fuse(glimpse(6.0, closed=1), m, 0, ORIGIN, work)
    assert m.closed[2] == 1
    assert m.state[2] == pytest.approx(6.0, abs=1e-3)


def test_single_outliers_do_not_open_an_edge() -> None:
    """Every other view ends beyond the edge: for each, another one sees the edge or ends before it."""
    m, work = mapped([0, -2, 2, -1, 1], cov=0.01), workspace()
    for k in range(50):
        fuse(glimpse(3.0), m, 0, ORIGIN, work)
        fuse(glimpse(2.0, closed=1) if k % 2 else glimpse(1.0), m, 0, ORIGIN, work)
    assert m.closed[2] == 1
    assert m.state[2] == pytest.approx(2.0, abs=1e-3)


def test_a_view_that_ends_inside_a_rectangle_says_nothing_against_its_joint() -> None:
    m, work = mapped([0, -2, 2, -1, 1, 6, -2, 2], cov=0.01), workspace()
    before = m.state.copy()
    for _ in range(10):
        fuse(glimpse(0.0), m, 0, ORIGIN, work)
    assert m.closed[:8].all()
    np.testing.assert_allclose(m.state, before, atol=1e-9)


def bare(m: np.record, places: list[int]) -> bool:
    return all(not m.closed[k] and m.cov[k, k] >= 1e4 * m.cov[2, 2] > 0 and not m.cov[k, 0] for k in places)


@pytest.mark.parametrize("n", [1, 2])
def test_a_rectangle_on_the_left_moves_everything_else_exactly(n: int) -> None:
    rng = np.random.default_rng(n)
    size = state_size(n)
    m = mapped(random_state(rng, n), cov=naive.random_covariance(rng, size))
    m.closed[:size] = rng.integers(0, 2, size)
    m.main = 0
    before = m.copy()
    shift_right(m)
    old = [0, *naive.u_places(n), *np.ravel(naive.bt_places(n))]
    new = [0, *naive.u_places(n + 1)[1:], *np.ravel(naive.bt_places(n + 1)[1:])]
    np.testing.assert_array_equal(m.state[new], before.state[old])
    np.testing.assert_array_equal(m.closed[new], before.closed[old])
    np.testing.assert_array_equal(m.cov[np.ix_(new, new)], before.cov[np.ix_(old, old)])
    np.testing.assert_array_equal(m.cov, m.cov.T)
    assert (m.n, m.main) == (n + 1, 1)
    assert bare(m, [1, 3, 4])


def test_a_row_grows_to_the_right_and_is_rooted_on_its_middle() -> None:
    m = mapped(random_state(np.random.default_rng(0), 1), open_edges=[2])
    before = m.copy()
    z = mapped(random_state(np.random.default_rng(1), 3))
    assert grow(z, m, 0) == 0
    assert (m.n, m.main) == (3, 1)
    np.testing.assert_array_equal(m.state[[0, 1, 2, 3, 4]], before.state[[0, 1, 2, 3, 4]])
    np.testing.assert_array_equal(m.cov[:5, :5], before.cov[:5, :5])
    assert bare(m, [5, 6, 7, 8, 9, 10])


def test_re_rooting_keeps_the_old_rectangle_where_it_was() -> None:
    """L and M are mapped, M and R measured: M becomes the main one."""
    m = mapped([0.0, -4, -1, -1, 1, 2, -2, 2], cov=1e-6, open_edges=[5])
    m.main = 0
    z = sense(np.array([0.0, -1, 2, -2, 2, 5, -1.5, 1.5]), np.eye(8) * 1e-6, closed=[1, 1, 1, 1, 1, 1, 1, 1])
    fuse(z, m, 1, ORIGIN, workspace())
    assert (m.n, m.main) == (3, 1)
    np.testing.assert_allclose(m.state, [0, -4, -1, -1, 1, 2, -2, 2, 5, -1.5, 1.5], atol=1e-6)
    assert m.closed.all()


def test_a_first_view_of_a_further_rectangle_takes_its_bounds() -> None:
    m = mapped([0, -2, 2, -1, 1], cov=0.01, open_edges=[1])
    z = sense(np.array([0.0, -5, -2, -3, 0.5, 2, -1, 1]), np.eye(8) * 0.01, closed=[1, 0, 1, 0, 1, 1, 1, 1])
    fuse(z, m, -1, ORIGIN, workspace())
    assert m.n == 2
    np.testing.assert_allclose(m.state[:8], [0, -4.9, -2, -2.9, 0.5, 2, -1, 1], atol=1e-5)
    assert m.closed[:8].tolist() == [1, 0, 1, 0, 1, 1, 1, 1]


def test_sides_of_a_thin_region_do_not_cross() -> None:
    """A door's far side, seen for the first time, lies by noise before its near side."""
    m = mapped([0, -0.5, 0.5, 0.08, 0.3], cov=0.01, open_edges=[4])
    m.state[3] = 0.08
    z = sense(np.array([0.0, -0.5, 0.5, -0.3, -0.1]), np.eye(5) * 0.01, closed=[1, 1, 1, 0, 1])
    fuse(z, m, 0, ORIGIN, workspace())
    assert m.closed[4] == 1
    assert m.state[4] - m.state[3] >= 0.01 - 1e-12


def test_any_sequence_of_views_leaves_a_sound_region() -> None:
    """Rows of one to three rectangles with edges open at random: finite, ascending, symmetric, positive."""
    rng = np.random.default_rng(0)
    truth = np.array([0.2, -4.0, -1.5, -1.0, 1.0, 1.5, -2.0, 2.0, 4.0, -1.2, 0.8])
    u, bt = naive.u_places(3), naive.bt_places(3)
    for _ in range(20):
        m, work = blank(), workspace()
        first = -1  # true number of the map's first rectangle
        for step in range(12):
            i, j = sorted(rng.choice(4, 2, replace=False))
            pose = np.array([*rng.normal(0, 1, 2), rng.normal(0, 0.2)])
            seen = naive.seen_from(truth, (1.0, 1.0), pose) + rng.normal(0, 0.02, 11)
            places = [0, u[i]]
            closed = [1, int(i == 0)]
            for k in range(i, j):
                places += [u[k + 1], *bt[k]]
                closed += [int(k + 1 < j or j == 3), *rng.integers(0, 2, 2)]
            order = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10][: len(places)]
            z = sense(np.zeros(len(order)), np.eye(len(order)) * 0.02**2)
            z.state[order], z.closed[order] = seen[places], closed
            z.closed[1] = i == 0
            if step == 0:
                start(z, pose, m, P)
                first = i
            else:
                if i > first + m.n or j < first:
                    continue
                if i == first + m.n or j == first:
                    continue  # no common rectangle
                fuse(z, m, i - first, pose, work)
                first = min(first, i)
            size = state_size(m.n)
            assert np.all(np.isfinite(m.state[:size]))
            assert np.all(np.diff(m.state[naive.u_places(m.n)]) > 0)
            assert all(m.state[t] > m.state[b] for b, t in naive.bt_places(m.n))
            np.testing.assert_array_equal(m.cov[:size, :size], m.cov[:size, :size].T)
            assert np.linalg.eigvalsh(m.cov[:size, :size]).min() > 0
            assert m.main == (1 if m.n == 3 else m.main)
            assert m.main < m.n


def test_new_regions_get_slots_and_ids_and_known_ones_are_counted() -> None:
    scan = measured(RegionMeasurement("office", 0, 0, 4, 4), RegionMeasurement("office", 9, 0, 4, 4))
    regions = maps(mapped([0, -2, 2, -2, 2]))
    drawn = stored(regions)
    nearby, n_near = near(drawn)
    links = links_to((0, 0, 0, 0), (NEW, 0, 0, 0))
    update_geometry(particles(), drawn, nearby, n_near, scan, links, 7, P)
    assert links["slot"].tolist() == [[0, 1]]
    assert (regions[0, 0].sightings, regions[0, 0].last_seen, regions[0, 0].id) == (2, 7, 100)
    assert (regions[0, 1].id, regions[0, 1].last_seen) == (7 * 4096 + 1, 7)
    assert nearby[0, : n_near[0]].tolist() == [0, 1]
    assert [drawn.slots[s].id for s in (0, 1)] == [100, 7 * 4096 + 1]


def test_a_reused_slot_forgets_the_region_before() -> None:
    regions = maps(mapped([0.3, -3, -1, -2, 2, 1, -1, 1, 3, -2, 2], cov=0.5))
    regions["n"] = 0
    for field, value in (("rival", 2), ("visited", 1), ("sightings", 50), ("existence", 5.0)):
        regions[field] = value
    scan = measured(RegionMeasurement("office", 0, 0, 4, 4, t=CLOSED, r=OPEN))
    drawn = stored(regions)
    update_geometry(particles(), drawn, *near(drawn), scan, links_to((NEW, 0, 0, 0)), 3, P)
    m = regions[0, 0]
    assert (m.n, m.first_link, m.rival, m.visited, m.sightings, m.existence) == (1, -1, -1, 0, 1, 0.0)
    assert not m.cov[5:].any()
    assert not m.cov[0, 5:].any()


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 3])
def test_errors_of_a_region_seen_twenty_times_match_its_covariance(n: int) -> None:
    """NEES over 100 runs: chi-square with 100 x (2 + 3 n) degrees of freedom, normal for so many, 99.9 % band."""
    size, runs, total = state_size(n), 100, 0.0
    truth = random_state(np.random.default_rng(n), n)
    sigma = np.array([0.02, *[0.1] * (size - 1)])
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        m, work = blank(), workspace()
        noise = naive.random_covariance(rng, size, 1.0) * np.outer(sigma, sigma)
        root = np.linalg.cholesky(noise)
        for step in range(20):
            pose = np.array([*rng.normal(0, 2, 2), rng.normal(0, 0.3)])
            lines = naive.seen_from(truth, (1.0, 2.0), pose) + root @ rng.standard_normal(size)
            z = sense(lines, noise)
            if step == 0:
                start(z, pose, m, P)
            else:
                fuse(z, m, 0, pose, work)
        # The truth about the filter's own anchor.
        expected = naive.seen_from(truth, (1.0, 2.0), np.array([*m.anchor, 0.0]))
        error = m.state[:size] - expected
        error[0] = np.remainder(error[0] + np.pi, 2 * np.pi) - np.pi
        total += float(error @ np.linalg.solve(m.cov[:size, :size], error))
    degrees = runs * size
    assert abs(total - degrees) < 3.3 * np.sqrt(2 * degrees)


def test_a_hallway_of_sixty_metres_grows_step_by_step() -> None:
    """Range 8 m, known pose: both ends are bounds until the robot gets there."""
    rng = np.random.default_rng(5)
    sigma = np.array([0.03, 0.14, 0.14, 0.1, 0.1])
    m, work = blank(), workspace()
    for x in np.arange(30.0, 60.0, 0.2).tolist() + np.arange(60.0, 0.0, -0.2).tolist():
        pose = np.array([x, 0.2, 0.0])
        left, right = max(0.0, x - 8.0), min(60.0, x + 8.0)
        lines = np.array([0.0, left - x, right - x, -1.4, 1.0]) + sigma * rng.standard_normal(5)
        z = sense(lines, np.diag(sigma**2), closed=[1, left == 0.0, right == 60.0, 1, 1])
        if m.n == 0:
            start(z, pose, m, P)
        else:
            fuse(z, m, 0, pose, work)
        near, far = m.anchor[0] + m.state[1], m.anchor[0] + m.state[2]
        assert near >= 0.0 - 0.6  # never farther than a view's own error
        assert far <= 60.0 + 0.6
    assert m.closed[:5].all()
    error = np.array([near, far - 60.0])
    assert np.all(np.abs(error) < 4 * np.sqrt(np.diag(m.cov)[1:3]))
    assert np.abs(error).max() < 0.1


def test_standing_still_for_a_thousand_scans_shrinks_nothing() -> None:
    """Noise of 1.2 times the told covariance: closed edges stay, open ones stay within a view's error of its end."""
    rng = np.random.default_rng(6)
    truth, sigma = np.array([0.0, -2, 3, -1.5, 1.5]), np.array([0.03, 0.14, 0.14, 0.14, 0.14])
    m, work = blank(), workspace()
    for step in range(1000):
        lines = truth + np.sqrt(1.2) * sigma * rng.standard_normal(5)
        z = sense(lines, np.diag(sigma**2), closed=[1, 1, 0, 1, 0])
        if step == 0:
            start(z, ORIGIN, m, P)
        else:
            fuse(z, m, 0, ORIGIN, work)
    ends = naive.seen_from(m.state[:5], m.anchor, ORIGIN)
    assert m.closed[:5].tolist() == [1, 1, 0, 1, 0]
    assert np.abs(ends - truth)[[1, 3]].max() < 0.03
    assert np.all((ends - truth > -0.14)[[2, 4]])
    assert np.all((ends - truth < 0.07)[[2, 4]])
