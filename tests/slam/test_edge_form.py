from __future__ import annotations

import numpy as np
import pytest

from slam.edge_form import bounding_radius, edge_form, state_size
from slam.measurement import RegionMeasurement, Scan
from slam.region import Subrectangle
from tests.slam import naive
from tests.slam.drawn import CLOSED, OPEN, mapped, random_measurement, random_state

SHAPES = [(1, False), (2, True), (2, False), (3, True)]


def parameters(z: RegionMeasurement) -> tuple[np.ndarray, np.ndarray]:
    """Mean and block-diagonal covariance of the paper's parameters."""
    mean, blocks = [z.x, z.y, z.w, z.h, z.phi], [z.cov_xy, z.cov_wh, [[z.var_phi]]]
    for sub in (z.left, z.right):
        if sub is not None:
            mean += [sub.w, sub.h, sub.y]
            blocks += [sub.cov_wh, [[sub.var_y]]]
    cov = np.zeros((len(mean), len(mean)))
    at = 0
    for block in blocks:
        block = np.atleast_2d(block)
        cov[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return np.array(mean), cov


@pytest.mark.parametrize(("n", "left"), SHAPES)
def test_edges_and_their_covariance_are_those_of_the_parametrisation(n: int, left: bool) -> None:
    for seed in range(5):
        z = random_measurement(np.random.default_rng(seed), n, left)
        mean, q = parameters(z)
        m = edge_form(Scan([z]).records[0])

        def edges(p: np.ndarray, z: RegionMeasurement = z) -> np.ndarray:
            return naive.edges_from_parameters(p, z.left is not None, z.right is not None)

        size = state_size(n)
        g = naive.derivative(edges, mean)
        np.testing.assert_allclose(m.state[:size], edges(mean), atol=1e-12)
        np.testing.assert_allclose(m.cov[:size, :size], g @ q @ g.T, rtol=1e-6, atol=1e-9)
        assert m.n == n
        assert not m.cov[size:].any()


def test_edge_states_keep_their_place() -> None:
    left = Subrectangle(1, 1, 0, t=OPEN, b=CLOSED, end=OPEN)
    right = Subrectangle(1, 1, 0, t=CLOSED, b=OPEN, end=CLOSED)
    z = RegionMeasurement("hallway", 0, 0, 2, 2, t=CLOSED, b=OPEN, left=left, right=right)
    m = edge_form(Scan([z]).records[0])
    #                       phi u0 u1 b0 t0 u2 b1 t1 u3 b2 t2
    assert m.closed.tolist() == [1, 0, 1, 1, 0, 1, 0, 1, 1, 0, 1]
    assert m.main == 1
    one = edge_form(Scan([RegionMeasurement("office", 0, 0, 2, 2, l=OPEN, t=OPEN)]).records[0])
    assert one.closed[:5].tolist() == [1, 0, 1, 1, 0]


def test_bounding_radius_holds_every_corner() -> None:
    for seed in range(10):
        m = mapped(random_state(np.random.default_rng(seed), 1 + seed % 3), (3.0, 4.0))
        corners = naive.corners(m.state[: state_size(m.n)], m.anchor).reshape(-1, 2)
        assert bounding_radius(m) >= np.linalg.norm(corners - m.anchor, axis=1).max() - 1e-12
    assert bounding_radius(mapped([0.7, -3, 2, -1, 4])) == pytest.approx(5.0)
