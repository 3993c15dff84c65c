"""Region features, edge states, and the places of edges in the state vector."""

from __future__ import annotations

import numpy as np
import pytest

from slam.jit import njit
from slam.region import EDGE_NAMES, MAX_STATE, REGION, EdgeState, RegionFeature, Subrectangle, b_index, u_index

OPEN, CLOSED, SUBRECT = EdgeState


def test_state_vector_of_n_rectangles_is_a_prefix() -> None:
    """phi, u0, u1, b0, t0, u2, b1, t1, u3, b2, t2."""
    names = ["phi", *[""] * (MAX_STATE - 1)]
    for k in range(4):
        names[u_index(k)] += f"u{k}"
    for i in range(3):
        names[b_index(i)] += f"b{i}"
        names[b_index(i) + 1] += f"t{i}"
    assert names == ["phi", "u0", "u1", "b0", "t0", "u2", "b1", "t1", "u3", "b2", "t2"]


def test_kernels_read_records_by_name() -> None:
    regions = np.zeros(2, REGION)
    regions["anchor"][1] = (3.0, 4.0)
    regions["cov"][1, 2, 3] = 7.0
    regions["n"][1] = 2

    def read(m: np.record) -> float:
        return float(m.anchor[1] + m.cov[2, 3] + m.n)

    assert read(regions[1]) == njit(read)(regions[1]) == 13.0


def test_no_field_hides_behind_a_method_of_records() -> None:
    """With the JIT off `m.mean` would be NumPy's method, not the field."""
    record = np.zeros(1, REGION)[0]
    hidden = [name for name in REGION.names if hasattr(np.record, name)]
    assert hidden == []
    assert all(not callable(getattr(record, name)) for name in REGION.names)


def test_edges_of_a_rectangle() -> None:
    feature = RegionFeature(1, "office", 0.0, 1, 2, 4, 3, 0.5, t=OPEN, r=OPEN)
    assert feature.edges == {"t": OPEN, "b": CLOSED, "l": CLOSED, "r": OPEN}
    assert feature.open_edges == ("t", "r")
    assert feature.row.parameters()["w"] == 4


def test_edges_of_a_row_come_by_the_names_of_fig_1() -> None:
    left, right = Subrectangle(2, 1, 0.5, OPEN, CLOSED, OPEN), Subrectangle(3, 1, -0.5, CLOSED, OPEN, CLOSED)
    feature = RegionFeature(1, "hallway", 0.0, 0, 0, 4, 2, 0.0, l=SUBRECT, r=SUBRECT, left=left, right=right)
    assert tuple(feature.edges) == EDGE_NAMES
    states = [CLOSED, CLOSED, SUBRECT, SUBRECT, OPEN, CLOSED, OPEN, CLOSED, OPEN, CLOSED]
    assert list(feature.edges.values()) == states
    assert feature.open_edges == ("tl", "ll", "br")
    np.testing.assert_allclose(feature.row.u, [-4, -2, 2, 5])


def test_features_share_no_defaults() -> None:
    a, b = (RegionFeature(i, "office", 0.0, 0, 0, 1, 1, 0.0) for i in (1, 2))
    assert a.cov_xy is not b.cov_xy and a.neighbours is not b.neighbours


def test_features_are_frozen() -> None:
    with pytest.raises(AttributeError):
        RegionFeature(1, "office", 0.0, 0, 0, 1, 1, 0.0).x = 2.0  # type: ignore[misc]
