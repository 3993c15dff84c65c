"""Motion, and the pose proposal of FastSLAM 2.0 (Montemerlo et al. 2003).

Between two scans a particle keeps the motion as a Gaussian. The scan's associated measurements condition it; a share of
the result is then *drawn*, the rest stays Gaussian. In edge form the innovation is linear in the pose, so the proposal
is exact for given regions, and the product of the innovations' densities is the particle's importance weight,
p(z_t | x^{t-1}, z^{t-1}).
"""

from __future__ import annotations

import numpy as np

from slam.innovation import condition, correspond, log_likelihood, workspaces, wrap
from slam.jit import Array, Record, lean, njit
from slam.maps import region_of
from slam.paper_innovation import innovate_as_set
from slam.turning import turn


@lean
def predict(
    particles: Array,
    distance: float,
    lateral: float,
    rotation: float,
    noise_distance: float,
    noise_per_metre: float,
    noise_per_radian: float,
) -> None:
    """Move every particle by odometry (in the robot's frame at its start) and let its covariance grow."""
    driven = np.sqrt(distance * distance + lateral * lateral)
    var_distance = noise_distance * driven
    var_rotation = noise_per_metre * driven + noise_per_radian * abs(rotation)
    for i in range(len(particles)):
        pose, cov = particles[i].pose, particles[i].cov
        c, s = np.cos(pose[2]), np.sin(pose[2])
        dx, dy = c * distance - s * lateral, s * distance + c * lateral
        # F = I + [0 0 -dy; 0 0 dx; 0 0 0], G = [c 0; s 0; 0 1]
        xt, yt, tt = cov[0, 2], cov[1, 2], cov[2, 2]
        cov[0, 0] += -2 * dy * xt + dy * dy * tt + c * c * var_distance
        cov[0, 1] += -dy * yt + dx * xt - dx * dy * tt + c * s * var_distance
        cov[1, 1] += 2 * dx * yt + dx * dx * tt + s * s * var_distance
        cov[0, 2] += -dy * tt
        cov[1, 2] += dx * tt
        cov[2, 2] += var_rotation
        cov[1, 0], cov[2, 0], cov[2, 1] = cov[0, 1], cov[0, 2], cov[1, 2]
        pose[0] += dx
        pose[1] += dy
        pose[2] = wrap(pose[2] + rotation)
        for a in range(3):
            particles[i].expected[a] = pose[a]
            for b in range(3):
                particles[i].spread[a, b] = cov[a, b]


@njit
def propose(particles: Array, maps: Record, measured: Array, associations: Array, p: Record) -> None:
    """Condition every particle's motion on its associated measurements and weigh it.

    What a measurement says counts relative to a reference density, and one without region counts nothing, so that
    particles that explain more weigh more.
    """
    work = workspaces(p.tolerance)
    turned = np.zeros_like(measured[:1, 0])
    for i in range(len(particles)):
        particle = particles[i]
        for j in range(len(measured)):
            a = associations[i, j]
            if a.slot < 0:
                continue
            z, m = measured[j, a.turn], region_of(maps, i, a.slot)
            if a.turn_map:
                turn(m, 1, turned[0])
                m = turned[0]
            rows, _ = correspond(z, m, a.offset, particle.pose, work[0].tolerance ** 2, work[0], np.inf)
            rows, distance, log_det = innovate_as_set(z, m, rows, particle.cov, work[0], p)
            particle.log_weight += log_likelihood(distance, log_det, rows, p.log_reference)
            for r in range(rows):
                for b in range(3):
                    work[0].gain[r, b] = work[0].by_pose[r, b]
            condition(particle.pose, particle.cov, 3, rows, work[0])
            particle.pose[2] = wrap(particle.pose[2])
        for a in range(3):
            particle.expected[a] = particle.pose[a]
            for b in range(3):
                particle.spread[a, b] = particle.cov[a, b]


@lean
def draw(particles: Array, normals: Array, share: float) -> None:
    """Draw a share of every proposal's covariance with standard normal numbers, shape (P, 3); the rest stays Gaussian.

    N(mean, C) is the mixture of all N(x, (1 - share) C) with x drawn from N(mean, share C). A share of 1: the pose.
    The numbers count along the robot's axes, so that the results do not depend on how the map frame lies.
    """
    root = np.sqrt(share)
    for i in range(len(particles)):
        pose, cov = particles[i].pose, particles[i].cov
        c, s = np.cos(pose[2]), np.sin(pose[2])
        xx, xy, yy = cov[0, 0], cov[1, 0], cov[1, 1]
        l00 = np.sqrt(max(c * c * xx + 2 * c * s * xy + s * s * yy, 0.0))
        scale = 1.0 / l00 if l00 > 0.0 else 0.0
        l10 = (c * s * (yy - xx) + (c * c - s * s) * xy) * scale
        l20 = (c * cov[2, 0] + s * cov[2, 1]) * scale
        l11 = np.sqrt(max(s * s * xx - 2 * c * s * xy + c * c * yy - l10 * l10, 0.0))
        l21 = (c * cov[2, 1] - s * cov[2, 0] - l20 * l10) / l11 if l11 > 0.0 else 0.0
        l22 = np.sqrt(max(cov[2, 2] - l20 * l20 - l21 * l21, 0.0))
        n0, n1, n2 = root * normals[i, 0], root * normals[i, 1], root * normals[i, 2]
        forward, left = l00 * n0, l10 * n0 + l11 * n1
        pose[0] += c * forward - s * left
        pose[1] += s * forward + c * left
        pose[2] = wrap(pose[2] + l20 * n0 + l21 * n1 + l22 * n2)
        for a in range(3):
            for b in range(3):
                cov[a, b] *= 1.0 - share


@lean
def place(particles: Array, pose: Array) -> None:
    """Put every particle at a pose known for certain."""
    for i in range(len(particles)):
        for a in range(3):
            particles[i].pose[a] = particles[i].expected[a] = pose[a]
        particles[i].cov[:] = 0.0
        particles[i].spread[:] = 0.0
