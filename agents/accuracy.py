"""How accurate is the filter? A tour with the simulated sensors and no agent, many seeds, errors in the map frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.recording import Recording, institute, record
from slam import RegionMap, RegionSLAM, SlamConfig
from slam.evaluation.consistency import pose_nees
from slam.evaluation.map_quality import MapQuality, map_quality
from slam.evaluation.region_consistency import region_nees
from slam.evaluation.trajectory import ape
from slam.rows import Floats

REGULAR = 1e-6
"""Added to pose variances (m², rad²): a robot that has not moved yet is certain of its pose."""
WARM_UP = 20
"""Steps of a tour that run every kernel once."""


@dataclass(frozen=True)
class Tour:
    """What the filter made of one tour.

    Attributes
    ----------
    estimated, covariances, true
        Of the poses in the map frame, which is the start pose: shapes (T, 3), (T, 3, 3), (T, 3).
    map
        The filter's, after the last step.
    features
        The regions of its heaviest particle in edge form, an array of `REGION`.
    seen
        Ids of the true regions measured often enough to be confirmed.
    """

    estimated: Floats
    covariances: Floats
    true: Floats
    map: RegionMap
    features: NDArray[np.void]
    seen: list[str]


def warm_up() -> None:
    """Compile all that a tour runs."""
    drive(0, steps=WARM_UP)


def drive(
    seed: int,
    n_particles: int = 4,
    noise: str = "standard",
    occlusion: bool = False,
    misclassification: float = 0.0,
    steps: int | None = None,
) -> Tour:
    """Run the filter along the tour of the institute, or its first steps, with unknown correspondence."""
    recording = record(seed, noise, occlusion, misclassification, steps=steps)
    return follow(recording, SlamConfig(n_particles, **told(recording)))


def told(recording: Recording) -> dict[str, Any]:
    """Return the settings of a filter that knows the noise of the sensors."""
    return {"motion_noise": recording.noise.odometry, "measurement_noise": recording.noise.regions}


def follow(recording: Recording, config: SlamConfig) -> Tour:
    """Run a filter on recorded data."""
    slam = RegionSLAM(config, np.random.default_rng(recording.filter_seed))
    estimated, covariances = np.empty_like(recording.true), np.empty((len(recording.true), 3, 3))
    for k, (move, scan) in enumerate(zip(recording.moves, recording.scans, strict=True)):
        belief = slam.step(move, scan)
        estimated[k], covariances[k] = belief.pose_mean, belief.pose_cov
    regions = zip(recording.world.regions, recording.sightings, strict=True)
    seen = [region.id for region, n in regions if n >= config.confirmed_after]
    belief = slam.belief
    return Tour(estimated, covariances, recording.true, belief.map, belief.features.copy(), seen)


def tour(
    seed: int,
    n_particles: int = 4,
    noise: str = "standard",
    occlusion: bool = False,
    misclassification: float = 0.0,
) -> dict[str, Any]:
    """Return the figures of one tour.

    Returns
    -------
    dict
        `ape_max`, `ape_rmse`, `ape_end` (m, raw: the map frame is the start pose), `pose_nees` (mean over the course,
        divided by 3), and of the map `regions_seen` (true regions measured often enough to be confirmed),
        `regions_mapped`, `duplicates`, `spurious`, `missed`, `type_accuracy`, `region_iou`,
        `region_nees` (of headings and closed edges, per degree of freedom), `link_f1` and `containment_f1`.
    """
    return {"seed": seed, **figures(drive(seed, n_particles, noise, occlusion, misclassification))}


def figures(run: Tour) -> dict[str, Any]:
    """Return the figures of a tour that was driven, as in `tour`."""
    error, quality = ape(run.estimated, run.true).position, quality_of(run)
    regions = normalised_regions(run, quality)
    freedom = sum(n for _, n in regions)
    return {
        "ape_max": error.max,
        "ape_rmse": error.rmse,
        "ape_end": error.end,
        "pose_nees": mean_pose_nees(run.estimated, run.covariances, run.true),
        "regions_seen": len(run.seen),
        "regions_mapped": len(run.map.regions),
        "duplicates": len(quality.duplicates),
        "spurious": len(quality.spurious),
        "missed": len(quality.missed),
        "type_accuracy": quality.type_accuracy,
        "region_iou": quality.iou,
        "region_nees": sum(value for value, _ in regions) / freedom if freedom else None,
        "link_f1": quality.link_f1,
        "containment_f1": quality.containment_f1,
    }


def quality_of(run: Tour) -> MapQuality:
    """Compare the filter's map with the institute."""
    world, poses = institute()
    links = [(link.source, link.target) for link in world.links]
    return map_quality(run.map.regions, world.regions, links, run.seen, pose=poses[0])


def normalised_regions(run: Tour, quality: MapQuality) -> list[tuple[float, int]]:
    """Return for each matched region the NEES of its heading and closed edges, and how many they are."""
    world, poses = institute()
    records = {int(record.id): record for record in run.features}
    truth = {region.id: region.row for region in world.regions}
    return [region_nees(records[match.mapped], truth[match.true], poses[0]) for match in quality.matches]


def mean_pose_nees(estimated: Floats, covariances: Floats, true: Floats) -> float:
    """Return the mean NEES of the poses of a course, divided by 3: ideally 1."""
    return float(np.mean(pose_nees(estimated, covariances + REGULAR * np.eye(3), true))) / 3
