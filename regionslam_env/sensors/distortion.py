"""What a real region sensor gets wrong beyond noise: types, missed regions, and regions that are not there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from regionslam_env.config import NoiseConfig
from slam.measurement import LINK, MEASUREMENT, Scan
from slam.region import EdgeState

_INVENTED_SIZES = (0.8, 5.0)  # m


def distort(
    scan: Scan, noise: NoiseConfig, confidence: float, rng: np.random.Generator
) -> tuple[Scan, NDArray[np.int64]]:
    """Return the scan with each region missed, or given a wrong type, by chance, and with invented regions.

    Beside it come the numbers that its measurements had in the scan given, shape (M,), -1 for invented ones.

    Parameters
    ----------
    scan
        With a view; it is not changed.
    noise
        Probabilities of misses and wrong types, expected number of invented regions, told standard deviations.
    confidence
        Stated with an invented region.
    rng
        The sensor's own generator.
    """
    kept = rng.random(len(scan)) >= noise.misses
    records = scan.records[kept]
    wrong = rng.random(len(records)) < noise.misclassification
    if len(scan.types) > 1:
        shift = rng.integers(1, len(scan.types), int(wrong.sum()))
        records["type"][wrong] = (records["type"][wrong] + shift) % len(scan.types)
    count = rng.poisson(noise.false_positives) if scan.view is not None and scan.types else 0
    invented = [_invent(scan, noise, confidence, rng) for _ in range(count)]
    if invented:
        records = np.concatenate([records, *invented])
    numbers = np.concatenate([np.flatnonzero(kept), np.full(count, -1)])
    return Scan.from_records(records, scan.types, _links_among(scan.links, kept), scan.view), numbers


def _invent(scan: Scan, noise: NoiseConfig, confidence: float, rng: np.random.Generator) -> NDArray[np.void]:
    """Return a closed rectangle of random type and size somewhere in view, shape (1,)."""
    told, record = noise.regions, np.zeros(1, MEASUREMENT)
    view = np.asarray(scan.view)
    place = math.sqrt(rng.random()) * view[rng.integers(len(view))]
    width, height = rng.uniform(_INVENTED_SIZES[0], _INVENTED_SIZES[1], 2).tolist()
    record["type"], record["n"], record["confidence"] = rng.integers(len(scan.types)), 1, confidence
    record["x"], record["y"], record["w"], record["h"] = place[0], place[1], width, height
    record["phi"] = rng.uniform(-math.pi / 2, math.pi / 2)
    record["edges"][:, :4] = EdgeState.CLOSED
    record["cov_xy"] = np.eye(2) * told.sigma_xy**2
    record["cov_wh"] = np.diag([told.variance_of_size(width), told.variance_of_size(height)])
    record["var_phi"] = told.sigma_phi**2
    return record


def _links_among(links: NDArray[np.void], kept: NDArray[np.bool_]) -> NDArray[np.void]:
    """Return the links between kept measurements, renumbered."""
    number = np.cumsum(kept) - 1
    both = links[kept[links["source"]] & kept[links["target"]]]
    renumbered = np.empty(len(both), LINK)
    renumbered["source"], renumbered["target"] = number[both["source"]], number[both["target"]]
    renumbered["confidence"] = both["confidence"]
    return renumbered
