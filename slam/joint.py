"""The joint posterior: association hypotheses, each with one Gaussian over its pose and all its regions.

FastSLAM draws poses and forgets what their errors have in common with the map's; with few particles it grows
overconfident (Bailey, Nieto and Nebot 2006). Here a particle is a hypothesis about what was measured, and given that,
pose and map are an EKF in edge form: slower, quadratic in the size of the map, and calibrated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slam.association import ASSOCIATION, CANDIDATES_PER_MEASUREMENT, associate
from slam.comparison import CANDIDATE
from slam.config import Parameters, SlamConfig
from slam.duplicates import find_twins, is_due, settle_rivals
from slam.existence import update_existence
from slam.hypotheses import NEGLIGIBLE, alternatives, copy_hypotheses, keep_hypotheses
from slam.innovation import LOG_REFERENCE_HEADING, log_likelihood
from slam.jit import Array, Record, njit
from slam.joint_gaussian import POSE, JointGaussian, move, place_pose
from slam.joint_geometry import explain, forget_absent, merge_twins, mirror, see_from_pose
from slam.joint_update import Rows, condition
from slam.maps import FREE_LINKS, USED_SLOTS
from slam.measurement import Scan
from slam.motion import MotionNoise
from slam.near import count_links
from slam.particles import ParticleSet
from slam.region import MAX_STATE
from slam.rows import Floats
from slam.scan_update import look_up
from slam.semantic_update import begin_types, update_semantics
from slam.topology_update import update_topology
from slam.weights import normalise


@dataclass
class Findings:
    """What a scan is to each hypothesis; the first axis of every array counts hypotheses."""

    near: Array
    n_near: Array
    associations: Array
    candidates: Array
    n_candidates: Array

    def take(self, hypotheses: NDArray[np.int64]) -> Findings:
        """Return those of the hypotheses, copied."""
        return Findings(*(array[hypotheses] for array in vars(self).values()))


class JointPosterior:
    """The Gaussians of all hypotheses, and the particles that mirror them.

    Parameters
    ----------
    cloud
        One particle for each hypothesis.
    gaussians
        In the same order.
    config
        Settings; `n_particles` hypotheses are kept at most.
    """

    def __init__(self, cloud: ParticleSet, gaussians: list[JointGaussian], config: SlamConfig) -> None:
        self.cloud, self.gaussians = cloud, gaussians
        self.ess = float(len(gaussians))
        self._most, self._parameters, self._priors = config.n_particles, config.parameters(), config.priors()

    @classmethod
    def at(cls, pose: Floats, config: SlamConfig) -> JointPosterior:
        """Return one hypothesis without regions, at a pose (x, y, theta) known for certain."""
        most = config.n_particles
        cloud = ParticleSet.at(pose, 2 * most)  # room in the table of maps: branches of a scan are pruned after it
        cloud.particles = cloud.particles[:1].copy()
        cloud.particles["log_weight"] = 0.0
        return cls(cloud, [JointGaussian.at(pose)], config)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of all Gaussians and what mirrors them, by name."""
        gaussians = {
            f"{name}_{i}": array for i, joint in enumerate(self.gaussians) for name, array in joint._asdict().items()
        }
        return {**self.cloud.to_arrays(), **gaussians}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], config: SlamConfig) -> JointPosterior:
        """Return the posterior of which `to_arrays` gave the arrays."""
        cloud = ParticleSet.from_arrays(arrays)
        gaussians = [
            JointGaussian(*(arrays[f"{name}_{i}"] for name in JointGaussian._fields))
            for i in range(len(cloud.particles))
        ]
        return cls(cloud, gaussians, config)

    def resample(self) -> None:
        """Do nothing: unlikely hypotheses are dropped after every scan."""

    def predict(self, motion: tuple[float, float, float], noise: MotionNoise) -> None:
        """Move every hypothesis by odometry: distance, lateral (m), rotation (rad)."""
        for joint in self.gaussians:
            move(joint, motion, (noise.distance, noise.heading_per_metre, noise.heading_per_radian))
        self._report()

    def place(self, pose: Floats) -> None:
        """Put every hypothesis at a pose (x, y, theta) known for certain."""
        for joint in self.gaussians:
            place_pose(joint, pose)
        self._report()

    def update(self, scan: Scan, types: Array, view: Array, scan_number: int, watchful: bool) -> float:
        """Take one scan, its types numbered, through all hypotheses; return 0: none watches out for contradictions."""
        cloud, p = self.cloud, self._parameters
        measured, relations, near, n_near, _ = look_up(
            cloud.particles, tuple(cloud.maps), scan.records, types, scan.links, scan.level, p
        )
        self._make_room(measured, relations)
        for i, joint in enumerate(self.gaussians):
            see_from_pose(joint, cloud.maps, i, near[i], n_near[i])
        cloud.particles["cov"] = 0.0  # it is in the records now
        found = Findings(near, n_near, *look(cloud.particles, cloud.maps, near, n_near, measured, p, self._priors))
        found = self._branch(found, measured, p)
        born = np.full(len(measured), -1)
        for i in range(len(self.gaussians)):
            cloud.particles["log_weight"][i] += self._explain(i, found, measured, born, scan_number, p)
        found = self._prune(found)
        self._report()
        begin_types(cloud.maps, measured, found.associations, self._priors)
        update_topology(cloud.particles, cloud.maps, found.associations, relations, p, self._priors)
        update_existence(
            cloud.particles,
            cloud.maps,
            found.near,
            found.n_near,
            found.associations,
            found.candidates,
            found.n_candidates,
            view,
            p,
        )
        self._merge(found, scan_number, p)
        self.ess = float(normalise(cloud.particles))
        return 0.0

    def _branch(self, found: Findings, measured: Array, p: Parameters) -> Findings:
        """Copy hypotheses that could as well take the scan for something else."""
        cloud, branches = self.cloud, []
        if self._most > 1:
            for i in range(len(self.gaussians)):
                candidates = found.candidates[i, : found.n_candidates[i]]
                others, lacks = alternatives(
                    candidates, found.associations[i], measured, cloud.maps.marks, self._most, p
                )
                weight = cloud.particles["log_weight"][i]
                branches += [(weight - lack, i, other) for lack, other in zip(lacks, others, strict=True)]
        if not branches:
            return found
        branches = sorted(branches, key=lambda branch: -branch[0])[: self._most]
        branches.sort(key=lambda branch: branch[1])
        parents = np.array([parent for _, parent, _ in branches])
        first = len(self.gaussians)
        copy_hypotheses(cloud, parents)
        self.gaussians += [self.gaussians[parent].copy() for parent in parents]
        found = found.take(np.concatenate((np.arange(first), parents)))
        for i, (_, _, associations) in enumerate(branches, first):
            found.associations[i] = associations
        return found

    def _explain(self, i: int, found: Findings, measured: Array, born: Array, scan_number: int, p: Parameters) -> float:
        """Update a hypothesis with what it takes the scan for; return the scan's log likelihood."""
        joint, maps = self.gaussians[i], self.cloud.maps
        rows = Rows.empty(MAX_STATE * len(measured))
        count, explained = explain(
            joint, maps, i, found.near, found.n_near, measured, found.associations[i], born, scan_number, rows, p
        )
        distance, log_det, known = condition(joint, rows.first(count)) if count else (0.0, 0.0, 0)
        mirror(joint, maps, i, p.tolerance)
        headings = LOG_REFERENCE_HEADING - p.log_reference  # of all measurements but one; the last is counted as one
        return float(log_likelihood(distance, log_det, known, p.log_reference) - (explained - 1) * headings)

    def _prune(self, found: Findings) -> Findings:
        """Keep the most likely hypotheses."""
        log_weights = self.cloud.particles["log_weight"]
        kept = np.argsort(-log_weights, kind="stable")[: self._most]
        kept = np.sort(kept[log_weights[kept] > log_weights.max() - NEGLIGIBLE])
        if len(kept) == len(log_weights):
            return found
        places = keep_hypotheses(self.cloud, kept)
        self.gaussians = [self.gaussians[i] for i in places]
        return found.take(places)

    def _merge(self, found: Findings, scan_number: int, p: Parameters) -> None:
        """Merge twins, rank rivals, and forget what was dropped."""
        maps = self.cloud.maps
        for i, joint in enumerate(self.gaussians):
            for z, slot in enumerate(found.associations["slot"][i].tolist()):
                if is_due(maps, i, found.associations, z, scan_number, p):
                    twins = find_twins(maps, i, slot, found.near, found.n_near, scan_number, p)
                    for younger, older in twins:
                        merge_twins(joint, maps, i, younger, older, p)
            settle_rivals(maps, i, found.near, found.n_near, p)
            forget_absent(joint, maps, i)
        self._report()

    def _report(self) -> None:
        """Write the Gaussians' poses into the particles."""
        particles = self.cloud.particles
        for i, joint in enumerate(self.gaussians):
            particles["pose"][i] = particles["expected"][i] = joint.mean[:POSE]
            particles["cov"][i] = particles["spread"][i] = joint.cov[:POSE, :POSE]

    def _make_room(self, measured: Array, relations: Array) -> None:
        """Make room for a scan that every hypothesis takes for something else, on records of its own."""
        maps, most = self.cloud.maps, 2 * self._most
        records = int(maps.counts[USED_SLOTS]) + len(measured)
        links = len(maps.links) - int(maps.counts[FREE_LINKS]) + int(count_links(relations))
        self.cloud.make_room(slots=len(measured), records=most * records, links=most * links)
        slots = len(self.cloud.maps.slots)
        self.gaussians = [joint.with_room(MAX_STATE * len(measured), slots) for joint in self.gaussians]


@njit
def look(particles: Array, maps: Record, near: Array, n_near: Array, measured: Array, p: Record, priors: Record) -> Any:
    """Associate a scan for all hypotheses and update their types; return associations, candidates and their numbers."""
    n = len(measured)
    associations = np.empty((len(particles), n), ASSOCIATION)
    candidates = np.empty((len(particles), n * CANDIDATES_PER_MEASUREMENT), CANDIDATE)
    n_candidates = np.zeros(len(particles), np.int64)
    associate(particles, maps, near, n_near, measured, p, associations, candidates, n_candidates)
    update_semantics(particles, maps, near, n_near, measured, candidates, n_candidates, p, priors)
    return associations, candidates, n_candidates
