"""Comparison of measured and mapped rows against slow twins: all shapes, all edge states, all correspondences."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slam.comparison import CANDIDATE, compare, nearest_alignment
from slam.config import SlamConfig
from slam.edge_form import state_size
from slam.geometric_update import PUSH_SIGMAS, START_SIGMAS, fuse
from slam.innovation import correspond, innovate, is_admissible, log_likelihood, midpoint_distance, workspace
from slam.region import REGION
from slam.turning import turn
from tests.slam import naive
from tests.slam.drawn import P, mapped, particles, random_state, sense

POSE = np.array([0.8, -0.5, 0.3])
SHAPES = [(1, 0), (2, 0), (2, 1), (3, 1)]
"""Rectangles and the main one: alone, with a right one, with a left one, with both."""


def drawn_region(rng: np.random.Generator, shape: tuple[int, int], closed: list[bool]) -> np.record:
    """A mapped row of a shape; `closed` counts its outer edges off: first and last u, then every bottom and top."""
    n, main = shape
    u, bt = naive.u_places(n), naive.bt_places(n)
    outer = [u[0], u[-1], *(k for pair in bt for k in pair)]
    open_edges = [k for k, known in zip(outer, closed, strict=False) if not known]
    size = state_size(n)
    m = mapped(random_state(rng, n), rng.normal(0, 1, 2), naive.random_covariance(rng, size, 0.05), open_edges)
    m.main = main
    return m


def drawn_measurement(
    rng: np.random.Generator, m: np.record, shape: tuple[int, int], offset: int, closed: list[bool]
) -> np.record:
    """A measured row whose rectangle j is about where rectangle j + offset of m is, as seen from `POSE`."""
    z = drawn_region(rng, shape, closed)
    n, size = shape[0], state_size(shape[0])
    z.anchor[:] = 0.0
    lines = naive.seen_from(m.state[: state_size(m.n)], m.anchor, POSE)
    shift = lines[naive.u_places(m.n)[max(0, offset)]] - z.state[naive.u_places(n)[max(0, -offset)]]
    z.state[naive.u_places(n)] += shift
    z.state[np.ravel(naive.bt_places(n))] += lines[naive.bt_places(m.n)[max(0, offset)][0]] + 1.0
    for k in range(n + 1):
        if 0 <= k + offset <= m.n:
            z.state[naive.u_places(n)[k]] = lines[naive.u_places(m.n)[k + offset]] + rng.normal(0, 0.1)
    for i in range(n):
        if 0 <= i + offset < m.n:
            for ours, theirs in zip(naive.bt_places(n)[i], naive.bt_places(m.n)[i + offset], strict=True):
                z.state[ours] = lines[theirs] + rng.normal(0, 0.1)
    z.state[0] = lines[0] + rng.normal(0, 0.03)
    z.cov[:size, :size] = naive.random_covariance(rng, size, 0.1)
    return z


@st.composite
def pairs(draw: st.DrawFn) -> tuple[np.record, np.record, int]:
    """A measured and a mapped row, and an offset at which they share at least one rectangle."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shapes = st.sampled_from(SHAPES)
    states = st.lists(st.booleans(), min_size=8, max_size=8)
    m = drawn_region(rng, draw(shapes), draw(states))
    shape = draw(shapes)
    offset = draw(st.integers(1 - shape[0], int(m.n) - 1))
    return drawn_measurement(rng, m, shape, offset, draw(states)), m, offset


def naive_admissible(z: np.record, m: np.record, offset: int) -> bool:
    """Ends of both rows as numbers of rectangles of m: a closed end may not lie inside the other row."""
    ends_z, ends_m = (offset, int(z.n) + offset), (0, int(m.n))
    if max(ends_z[1], ends_m[1]) - min(ends_z[0], ends_m[0]) > 3:
        return False
    for ends, other, region in ((ends_z, ends_m, z), (ends_m, ends_z, m)):
        places = naive.u_places(int(region.n))
        if region.closed[places[0]] and other[0] < ends[0]:
            return False
        if region.closed[places[-1]] and other[1] > ends[1]:
            return False
    return True


def common_edges(z: np.record, m: np.record, offset: int) -> list[tuple[int, int, int, int]]:
    """(place in z, place in m, axis, outward side or 0 for a joint of both) of all edges of the common rectangles."""
    out = []
    common = [i for i in range(int(m.n)) if 0 <= i - offset < z.n]
    for k in range(common[0], common[-1] + 2):
        i, j = naive.u_places(int(z.n))[k - offset], naive.u_places(int(m.n))[k]
        side = 0
        if not z.closed[i]:
            side = -1 if k - offset == 0 else 1
        elif not m.closed[j]:
            side = -1 if k == 0 else 1
        out.append((i, j, 0, side))
    for k in common:
        for side, i, j in zip(
            (-1, 1), naive.bt_places(int(z.n))[k - offset], naive.bt_places(int(m.n))[k], strict=True
        ):
            out.append((i, j, 1, side))
    return out


def naive_correspondence(z: np.record, m: np.record, offset: int, slack: float) -> tuple[list, float]:
    """Pairs of places closed in both, and the squared violation of bounds by the edges that are open in one."""
    size = state_size(int(m.n))
    expected = naive.seen_from(m.state[:size], m.anchor, POSE)
    closed, violation = [(0, 0)], 0.0
    for i, j, _, side in common_edges(z, m, offset):
        r = z.state[i] - expected[j]
        if z.closed[i] and m.closed[j]:
            closed.append((i, j))
        elif z.closed[i] != m.closed[j]:
            beyond = side * r if m.closed[j] else -side * r  # the open edge lies farther out than the closed one
            variance = z.cov[i, i] + (m.cov[j, j] if m.closed[j] else 0.0) + slack
            violation += max(beyond, 0.0) ** 2 / variance
    for k in range(int(m.n)):
        if not 0 <= k - offset < z.n:
            continue
        spans = []
        for places in (naive.u_places, lambda n: [p for pair in naive.bt_places(n) for p in pair]):
            first_z, first_m = (k - offset, k) if places is naive.u_places else (2 * (k - offset), 2 * k)
            a, b = places(int(z.n))[first_z : first_z + 2], places(int(m.n))[first_m : first_m + 2]
            spans.append((a, b))
        for a, b in spans:
            shared = min(z.state[a[1]], expected[b[1]]) - max(z.state[a[0]], expected[b[0]])
            extents = [z.state[a[1]] - z.state[a[0]], expected[b[1]] - expected[b[0]]]
            if (
                not any(z.closed[i] and m.closed[j] for i, j in zip(a, b, strict=True))
                and shared < min(extents) / 2 - 0.3
            ):
                return closed, math.inf
            if shared < 0:
                violation += shared**2 / (2 * slack)
    return closed, violation


def by_name(work: object, rows: int) -> list[tuple[int, int]]:
    return sorted(zip(work.iz[:rows].tolist(), work.im[:rows].tolist(), strict=True))  # type: ignore[attr-defined]


@settings(max_examples=150, deadline=None)
@given(pairs())
def test_correspondence_innovation_and_likelihood_are_those_of_the_twin(pair: tuple[np.record, np.record, int]) -> None:
    z, m, offset = pair
    slack, work = 0.02, workspace()
    assert is_admissible(z, m, offset) == naive_admissible(z, m, offset)
    rows, violation = correspond(z, m, offset, POSE, slack, work, np.inf)
    closed, expected_violation = naive_correspondence(z, m, offset, slack)
    assert by_name(work, rows) == sorted(closed)
    assert violation == pytest.approx(expected_violation)
    order = list(zip(work.iz[:rows], work.im[:rows], strict=True))
    size = state_size(int(m.n))
    places = [j for _, j in order]
    pose_cov = naive.random_covariance(np.random.default_rng(0), 3, 0.1)
    h = naive.derivative(lambda x: naive.seen_from(x, m.anchor, POSE)[places], m.state[:size])
    h_pose = naive.derivative(lambda x: naive.seen_from(m.state[:size], m.anchor, x)[places], POSE)
    in_z = [i for i, _ in order]
    s = h @ m.cov[:size, :size] @ h.T + h_pose @ pose_cov @ h_pose.T + z.cov[np.ix_(in_z, in_z)]
    residual = z.state[in_z] - naive.seen_from(m.state[:size], m.anchor, POSE)[places]
    residual[0] = math.remainder(residual[0], 2 * math.pi)
    distance, log_det = innovate(z, m, rows, pose_cov, work)
    assert distance == pytest.approx(residual @ np.linalg.solve(s, residual), rel=1e-6)
    reference = -math.log(2 * math.pi) - (rows - 1) * math.log(8.0)
    likelihood = log_likelihood(distance, log_det, rows, -math.log(8.0))
    assert likelihood == pytest.approx(naive.log_density(residual, s) - reference, rel=1e-6, abs=1e-6)


def midpoint(z: np.record) -> np.ndarray:
    """Midpoint of the main rectangle along both axes."""
    u, bt = naive.u_places(int(z.n)), naive.bt_places(int(z.n))
    return np.array([z.state[u[z.main : z.main + 2]].mean(), z.state[list(bt[z.main])].mean()])


def naive_fuse(z: np.record, m: np.record, offset: int) -> dict[tuple[int, str], tuple[float, bool]]:
    """(value, closed) of the lines of the union by rectangle and side; bounds by their rule, NaN where closed."""
    first, last = min(0, offset), max(int(m.n), int(z.n) + offset)
    lines: dict[tuple[int, str], list] = {}
    for which, region, shift in (("m", m, 0), ("z", z, offset)):
        n = int(region.n)
        state = region.state[: state_size(n)]
        seen = naive.seen_from(state, region.anchor, POSE) if which == "m" else state
        for k, place in enumerate(naive.u_places(n)):
            lines.setdefault((k + shift, "u"), []).append((which, place, seen[place], bool(region.closed[place])))
        for i, pair in enumerate(naive.bt_places(n)):
            for side, place in zip("bt", pair, strict=True):
                lines.setdefault((i + shift, side), []).append((which, place, seen[place], bool(region.closed[place])))
    out = {}
    for (k, side), found in lines.items():
        z_line = next((f for f in found if f[0] == "z"), None)
        m_line = next((f for f in found if f[0] == "m"), None)
        outward = {"b": -1, "t": 1}.get(side, 1 if k == last else -1 if k == first else 0)
        if m_line is not None and (m_line[3] or z_line is None):
            out[k - first, side] = (math.nan if m_line[3] else m_line[2], m_line[3])  # closed: see the Kalman update
        elif z_line[3]:
            out[k - first, side] = (math.nan, True)
        else:
            sigma = math.sqrt(z.cov[z_line[1], z_line[1]])
            if m_line is None:
                out[k - first, side] = (z_line[2] - outward * START_SIGMAS * sigma, False)
            else:
                pushed = z_line[2] - outward * PUSH_SIGMAS * sigma
                out[k - first, side] = (max(outward * pushed, outward * m_line[2]) * outward, False)
    return out


@settings(max_examples=150, deadline=None)
@given(pairs())
def test_fusion_grows_rows_and_keeps_what_is_known(pair: tuple[np.record, np.record, int]) -> None:
    """Union of both rows, closed edges of either closed, bounds by their rule; re-rooted on the middle of three."""
    z, m, offset = pair
    if not naive_admissible(z, m, offset):
        return
    before, expected = m.copy(), naive_fuse(z, m, offset)
    first = min(0, offset)
    fuse(z, m, offset, POSE, workspace())
    n = max(int(before.n), int(z.n) + offset) - first
    assert m.n == n
    assert m.main == (1 if n == 3 else before.main - first)
    size = state_size(n)
    seen = naive.seen_from(m.state[:size], m.anchor, POSE)
    bounds = naive.seen_from(np.array([before.state[0], *m.state[1:size]]), m.anchor, POSE)
    for (k, side), (value, closed) in expected.items():
        place = naive.u_places(n)[k] if side == "u" else naive.bt_places(n)[k]["bt".index(side)]
        assert bool(m.closed[place]) == closed
        if not closed and np.all(np.diff(m.state[naive.u_places(n)]) > 0.02):
            assert bounds[place] == pytest.approx(value, abs=0.02) or abs(seen[place] - value) < 0.05
    cov = m.cov[:size, :size]
    np.testing.assert_array_equal(cov, cov.T)
    assert np.linalg.eigvalsh(cov / np.sqrt(np.outer(np.diag(cov), np.diag(cov)))).min() > 0


@settings(max_examples=100, deadline=None)
@given(pairs())
def test_fusion_of_what_both_know_is_the_textbook_update(pair: tuple[np.record, np.record, int]) -> None:
    """Kept exactly where only m knows it; elsewhere the Kalman update from a flat prior for what only z has closed."""
    z, m, offset = pair
    if not naive_admissible(z, m, offset):
        return
    first = min(0, offset)
    n = max(int(m.n), int(z.n) + offset) - first
    size = state_size(n)

    def place_of(region: np.record, shift: int) -> dict[int, int]:
        """Places in the union by places in a row."""
        count = int(region.n)
        out = {0: 0}
        out |= {p: naive.u_places(n)[k + shift] for k, p in enumerate(naive.u_places(count))}
        for i, bottom_top in enumerate(naive.bt_places(count)):
            out |= dict(zip(bottom_top, naive.bt_places(n)[i + shift], strict=True))
        return out

    of_m, of_z = place_of(m, -first), place_of(z, offset - first)
    known_m = {of_m[p]: p for p in of_m if m.closed[p]}
    known_z = {of_z[p]: p for p in of_z if z.closed[p]}
    mean, cov = np.zeros(size), np.eye(size) * 1e8
    mean[0] = m.state[0]
    for a, p in known_m.items():
        mean[a] = m.state[p]
        for b, q in known_m.items():
            cov[a, b] = m.cov[p, q]
    anchor = m.anchor.copy()
    places = sorted(known_z)
    residual = (np.zeros(size) + [z.state[known_z[a]] if a in known_z else 0.0 for a in range(size)])[places]
    for a in places:  # linearised about the measured lines where m knows none
        if a not in known_m:
            shift = naive.seen_from(np.array([m.state[0], *[0.0] * (size - 1)]), anchor, POSE)[a]
            mean[a] = z.state[known_z[a]] - shift
    h = naive.derivative(lambda x: naive.seen_from(x, anchor, POSE), mean)[places]
    residual = residual - naive.seen_from(mean, anchor, POSE)[places]
    residual[0] = math.remainder(residual[0], 2 * math.pi)
    middle = midpoint(z)
    c, s = math.cos(residual[0]), math.sin(residual[0])
    turned = np.array([[c, -s], [s, c]]) @ middle - middle - residual[0] * np.array([-middle[1], middle[0]])
    for r, a in enumerate(places[1:], 1):  # what turning z to the heading of m does beyond the linear lever of phi
        residual[r] += turned[0 if a in naive.u_places(n) else 1]
    in_z = [known_z[a] for a in places]
    mean, cov = naive.kalman(mean, cov, h, residual, z.cov[np.ix_(in_z, in_z)])
    fuse(z, m, offset, POSE, workspace())
    known = sorted(set(known_m) | set(known_z))
    u, bt = m.state[naive.u_places(n)], m.state[np.array(naive.bt_places(n))]
    if np.diff(u).min() > 0.02 and (bt[:, 1] - bt[:, 0]).min() > 0.02:  # else edges gave way to keep their order
        difference = m.state[known] - mean[known]
        difference[0] = math.remainder(difference[0], 2 * math.pi)
        np.testing.assert_allclose(difference, 0.0, atol=1e-4)
    np.testing.assert_allclose(m.cov[np.ix_(known, known)], cov[np.ix_(known, known)], atol=1e-5)


def candidate_of(z: np.record, m: np.record, settings: SlamConfig | None = None) -> tuple[bool, np.record]:
    descriptions, turned, out = np.zeros(4, REGION), np.zeros(1, REGION)[0], np.zeros(1, CANDIDATE)[0]
    for quarters in range(4):
        turn(z, quarters, descriptions[quarters])
    p = P if settings is None else settings.parameters()
    found = compare(descriptions, m, particles(POSE, 1e-4)[0], p, workspace(), turned, out)
    return bool(found), out


def naive_compare(z: np.record, m: np.record, gate: float) -> float:
    """The greatest likelihood over all alignments along the axis of m."""
    best, slack = -math.inf, 0.1**2 + 2e-4
    for quarters in range(4):
        other = np.zeros(1, REGION)[0]
        turn(z, quarters, other)
        if other.n == 0 or abs(math.remainder(other.state[0] + POSE[2] - m.state[0], 2 * math.pi)) > math.pi / 4:
            continue
        for offset in range(1 - int(other.n), int(m.n)):
            if not naive_admissible(other, m, offset):
                continue
            work = workspace()
            rows, violation = correspond(other, m, offset, POSE, slack, work, np.inf)
            distance, log_det = innovate(other, m, rows, np.eye(3) * 1e-4, work)
            if distance + violation <= gate:
                best = max(best, log_likelihood(distance + violation, log_det, rows, P.log_reference))
    return best


@settings(max_examples=150, deadline=None)
@given(pairs(), st.integers(0, 3))
def test_the_best_alignment_is_found_in_every_description(
    pair: tuple[np.record, np.record, int], quarters: int
) -> None:
    """Half turns for rows, quarter turns for rectangles, and rows along their other axis if that is better."""
    z, m, _ = pair
    other = np.zeros(1, REGION)[0]
    turn(z, quarters if z.n == 1 else 2 * (quarters // 2), other)
    found, out = candidate_of(other, m)
    best = naive_compare(z, m, P.gate_new)
    if found and out.turn_map == 0:
        assert out.log_likelihood == pytest.approx(best, abs=1e-6)
    elif not found:
        assert best == -math.inf
    else:
        assert out.log_likelihood >= best - 1e-6 or z.n == 1


# The claim about midpoints: narrow views of exact rows.


def narrow_view(rng: np.random.Generator, truth: np.ndarray, reach: float) -> tuple[np.record, int] | None:
    """What a sensor of a short range sees of a row, exactly; and the number of the first rectangle in view."""
    u, bt = truth[naive.u_places(3)], truth[np.array(naive.bt_places(3))]
    at_u = rng.uniform(u[0], u[-1])
    i = int(np.clip(np.searchsorted(u, at_u) - 1, 0, 2))
    at_v = rng.uniform(*bt[i])
    seen = [k for k in range(3) if u[k] < at_u + reach - 0.1 and u[k + 1] > at_u - reach + 0.1]
    seen = [k for k in seen if bt[k, 0] < at_v + reach - 0.1 and bt[k, 1] > at_v - reach + 0.1]
    if not seen or seen != list(range(seen[0], seen[-1] + 1)):
        return None
    first, last = seen[0], seen[-1]
    state, closed = [0.0, max(u[first], at_u - reach)], [1, int(first == 0 and u[0] > at_u - reach)]
    for k in seen:
        end = u[k + 1] if k < last else min(u[k + 1], at_u + reach)
        state += [end, max(bt[k, 0], at_v - reach), min(bt[k, 1], at_v + reach)]
        closed += [int(k < last or (last == 2 and u[3] < at_u + reach)), *(int(abs(v - at_v) < reach) for v in bt[k])]
    return sense(np.array(state), np.diag([0.03**2, *[0.15**2] * (len(state) - 1)]), closed), first


def wrong_alignments(correspondence: str, reach: float, count: int) -> float:
    """Share of views of that reach (m) that are taken for another rectangle, of those for which there is a choice."""
    rng, wrong, total = np.random.default_rng(0), 0, 0
    p = SlamConfig(correspondence=correspondence).parameters()  # type: ignore[arg-type]
    while total < count:
        u = np.cumsum([0, *np.exp(rng.uniform(0.0, np.log(20.0), 3))])
        b, t = rng.uniform(-2.5, -0.5, 3), rng.uniform(0.5, 2.5, 3)
        truth = np.array([0, u[0], u[1], b[0], t[0], u[2], b[1], t[1], u[3], b[2], t[2]])
        view = narrow_view(rng, truth, reach)
        if view is None:
            continue
        z, first = view
        m = mapped(truth, cov=1e-4)
        if sum(naive_admissible(z, m, offset) for offset in range(1 - int(z.n), 3)) < 2:
            continue
        descriptions, turned, out = np.zeros(4, REGION), np.zeros(1, REGION)[0], np.zeros(1, CANDIDATE)[0]
        for quarters in range(4):
            turn(z, quarters, descriptions[quarters])
        robot = particles((0, 0, 0), 1e-6)[0]
        out.offset = -9
        compare(descriptions, m, robot, p, workspace(), turned, out)
        wrong += out.offset != first
        total += 1
    return wrong / total


def test_midpoints_pick_the_wrong_rectangle_of_narrow_views_and_edges_do_not() -> None:
    assert 0.07 < wrong_alignments("paper", 0.5, 500) < 0.16  # 0.11 of 2,000
    assert wrong_alignments("edges", 0.5, 500) <= 0.002  # none of 2,000


def test_the_rule_of_the_paper_is_the_least_midpoint_distance() -> None:
    rng = np.random.default_rng(3)
    m = mapped(random_state(rng, 3), cov=0.01)
    z = sense(np.array([0.0, -0.5, 0.5, -0.4, 0.4]), np.eye(5) * 0.01, closed=[1, 0, 0, 0, 0])
    z.state[0] = m.state[0]
    distances = []
    for i, (bottom, top) in enumerate(naive.bt_places(3)):
        u = m.state[naive.u_places(3)[i : i + 2]].mean()
        distances.append(math.hypot(u, m.state[[bottom, top]].mean()))
        assert midpoint_distance(z, m, i, np.zeros(3)) == pytest.approx(distances[-1])
    assert nearest_alignment(z, m, np.zeros(3)) == int(np.argmin(distances))
