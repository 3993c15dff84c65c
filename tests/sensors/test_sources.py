"""Where simulated measurements come from: only with the right source does an exact measurement fit its true region."""

from __future__ import annotations

import dataclasses

import numba
import numpy as np
import pytest

from regionslam_env.config import NOISE_SETS
from regionslam_env.worlds.loading import load
from slam.evaluation.lines import lines_of, residuals, state_of
from tests.floors import two_rooms
from tests.sensors.reading import sensor


@pytest.mark.parametrize("occlusion", [True, False])
@pytest.mark.parametrize("distortion", [{}, {"misses": 0.3, "false_positives": 2.0, "misclassification": 0.2}])
def test_every_measured_edge_is_that_edge_of_its_source(occlusion, distortion):
    world = load("institute")
    origins = np.array([(region.row.x, region.row.y) for region in world.regions])
    truth = np.array([state_of(region.row, origin) for region, origin in zip(world.regions, origins, strict=True)])
    noise = dataclasses.replace(NOISE_SETS["none"], **distortion)
    eye, rng = sensor(world, noise, occlusion=occlusion), np.random.default_rng(10)
    xmin, ymin, xmax, ymax = world.bounds
    turned = invented = later = 0
    for _ in range(3 if numba.config.DISABLE_JIT else 60):
        pose = np.array([*rng.uniform((xmin, ymin), (xmax, ymax)), rng.uniform(-3, 3)])
        scan, sources = eye.measure(pose), eye.sources
        assert len(sources) == len(scan)
        invented += np.count_nonzero(sources["region"] < 0)
        turned += np.count_nonzero(sources["turned"])
        later += np.count_nonzero(sources["first"])
        lines = lines_of(scan.records, sources)
        edges = truth[lines.region[lines.owner], lines.edge]
        rows = residuals(lines, pose, truth[lines.region, 0], origins[lines.region], edges)
        assert np.allclose(rows[0], 0, atol=1e-9)
        assert np.allclose(rows[1], 0, atol=1e-9)
    assert turned > 0
    if not numba.config.DISABLE_JIT:
        assert later > 0
        assert (invented > 0) == bool(distortion)


def test_sources_are_a_copy():
    eye = sensor(two_rooms())
    eye.measure(np.array([5.0, 2, 0]))
    first = eye.sources
    before = first.copy()
    eye.measure(np.array([3.0, 1, 2]))
    assert np.array_equal(first, before)
