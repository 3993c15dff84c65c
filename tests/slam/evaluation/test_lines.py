"""Line factors: rows that vanish at the truth, exact Jacobians, and the information of the edge form's own rows."""

from __future__ import annotations

import numpy as np
import pytest

from regionslam_env.sensors.region_sensor import SOURCE
from slam.edge_form import edge_form
from slam.evaluation.lines import IS_U, jacobians, lines_of, residuals
from slam.measurement import Scan
from slam.region import MAX_STATE
from slam.se2 import between, wrap_angles
from tests.slam.drawn import random_measurement


def sources(*rows):
    return np.array(list(rows), SOURCE)


def scan_of(rng, *sizes):
    return Scan([random_measurement(rng, n) for n in sizes]).records


@pytest.fixture
def drawn():
    """Lines of three measurements, a pose, and headings, anchors and edges of their regions, all at random."""
    rng = np.random.default_rng(3)
    lines = lines_of(scan_of(rng, 1, 2, 3), sources((4, 0, 0), (7, 1, 1), (2, 0, 1)))
    return (
        lines,
        rng.normal(0, 2, 3),
        rng.uniform(-3, 3, 3),
        rng.normal(0, 3, (3, 2)),
        rng.normal(0, 3, len(lines.owner)),
    )


def test_which_entries_are_boundaries_along_the_row():
    assert np.flatnonzero(IS_U).tolist() == [1, 2, 5, 8]


def test_edges_are_named_by_those_of_the_true_region(drawn):
    lines = drawn[0]
    assert lines.region.tolist() == [4, 7, 2]
    assert lines.edge[lines.owner == 0].tolist() == [1, 2, 3, 4]
    assert lines.edge[lines.owner == 1].tolist() == [2, 5, 6, 7, 8, 9, 10]  # the second and third rectangle of three
    assert lines.edge[lines.owner == 2].tolist() == list(range(1, MAX_STATE))


def test_measurements_without_origin_and_open_edges_are_left_out():
    records = scan_of(np.random.default_rng(5), 1, 1)
    records[1].edges[0] = 0  # top
    lines = lines_of(records, sources((-1, 0, 0), (3, 0, 0)))
    assert lines.region.tolist() == [3]
    assert lines.edge.tolist() == [1, 2, 3]
    nothing = lines_of(records, sources((-1, 0, 0), (-1, 0, 0)))
    assert (len(nothing.region), len(nothing.owner)) == (0, 0)


@pytest.mark.parametrize("turned", [0, 1])
def test_an_exact_measurement_leaves_no_residual(turned):
    rng = np.random.default_rng(8)
    records = scan_of(rng, 3)
    lines = lines_of(records, sources((0, 0, turned)))
    pose, anchor = rng.normal(0, 2, 3), rng.normal(0, 3, 2)
    seen = between(pose, (*anchor, 0.0))[:2]
    phi = records[0].phi + turned * np.pi
    c, s = np.cos(phi), np.sin(phi)
    rho = edge_form(records[0]).state[1:]
    if turned:  # the same row read from its other end
        rho = -rho[[7, 4, 9, 8, 1, 6, 5, 0, 3, 2]]
    normals = np.where(IS_U[1:, None], [c, s], [-s, c])
    r_phi, r_edges = residuals(lines, pose, np.array([phi + pose[2]]), anchor[None], rho - normals @ seen)
    assert np.allclose(wrap_angles(r_phi), 0)
    assert np.allclose(r_edges, 0)


def test_jacobians_by_finite_differences(drawn):
    lines, pose, phi, anchor, edges = drawn
    by_pose, by_phi = jacobians(lines, pose, phi, anchor)
    h = 1e-6
    for k in range(3):
        step = h * np.eye(3)[k]
        forth, back = (residuals(lines, pose + d, phi, anchor, edges) for d in (step, -step))
        assert np.allclose(-(forth[1] - back[1]) / (2 * h), by_pose[:, k], atol=1e-7)
        assert np.allclose(-wrap_angles(forth[0] - back[0]) / (2 * h), -(k == 2), atol=1e-7)
    forth, back = (residuals(lines, pose, phi + d, anchor, edges) for d in (h, -h))
    assert np.allclose(-(forth[1] - back[1]) / (2 * h), by_phi, atol=1e-7)
    assert np.allclose(-wrap_angles(forth[0] - back[0]) / (2 * h), 1, atol=1e-7)
    forth, back = (residuals(lines, pose, phi, anchor, edges + d) for d in (h, -h))
    assert np.allclose(-(forth[1] - back[1]) / (2 * h), 1, atol=1e-7)


def test_rows_carry_the_information_of_rho_and_alpha_used_jointly():
    """Both ways of writing the rows of one measurement give the same information about pose, heading and edges."""
    records = scan_of(np.random.default_rng(13), 3)
    lines, z = lines_of(records, sources((0, 0, 0))), edge_form(records[0])
    pose, anchor = np.array([0.3, -0.2, 0.7]), np.array([1.0, 2.0])
    phi = z.state[0] + pose[2]
    c, s = np.cos(phi), np.sin(phi)
    dx, dy = anchor - pose[:2]
    along = IS_U[1:]
    joint = np.zeros((MAX_STATE, 4 + MAX_STATE - 1))  # x, y, theta, phi, edges
    joint[0, 2], joint[0, 3] = -1, 1
    joint[1:, 0], joint[1:, 1] = np.where(along, -c, s), np.where(along, -s, -c)
    joint[1:, 3] = np.where(along, -s * dx + c * dy, -c * dx - s * dy)
    joint[1:, 4:] = np.eye(MAX_STATE - 1)
    own = np.zeros_like(joint)
    by_pose, by_phi = jacobians(lines, pose, np.array([phi]), anchor[None])
    own[0, 2], own[0, 3] = -1, 1
    own[1:, :3], own[1:, 3], own[1:, 4:] = by_pose, by_phi, np.eye(MAX_STATE - 1)
    noise = np.zeros((MAX_STATE, MAX_STATE))
    noise[0, 0], noise[1:, 1:] = lines.var_phi[0], lines.covariance
    expected = joint.T @ np.linalg.solve(z.cov, joint)
    assert np.allclose(own.T @ np.linalg.solve(noise, own), expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
