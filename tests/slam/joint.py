"""Joint Gaussians drawn at random."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slam.joint_gaussian import JointGaussian, allocate
from tests.slam import naive

Floats = NDArray[np.float64]


def joint_of(
    rng: np.random.Generator,
    *states: Floats,
    pose: ArrayLike = (0.3, -0.2, 0.1),
    anchors: Sequence[ArrayLike] = ((2.0, 1.0), (-4.0, 3.0), (1.0, -5.0)),
    open_edges: Sequence[int] = (),
    scale: float = 0.1,
) -> JointGaussian:
    """A pose and regions with a covariance without structure; the first region has open edges."""
    joint = JointGaussian.at(np.asarray(pose, float)).with_room(64, 8)
    for slot, state in enumerate(states):
        joint.anchors[slot] = anchors[slot]
        for k, value in enumerate(state):
            if slot > 0 or k not in open_edges:
                joint.entries[slot, k] = allocate(joint, value, 1.0)
    n = joint.used
    joint.cov[:n, :n] = naive.random_covariance(rng, n, scale)
    return joint
