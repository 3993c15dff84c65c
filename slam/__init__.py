"""Region-based FastSLAM 2.0 (Oberländer et al. 2008) as a library of its own."""

from slam.belief import Belief
from slam.config import SlamConfig
from slam.fastslam import RegionSLAM
from slam.measurement import MeasurementNoise, RegionMeasurement, Scan
from slam.motion import MotionNoise, Odometry
from slam.region import EdgeState, RegionFeature, Subrectangle
from slam.region_map import RegionMap

__all__ = [
    "Belief",
    "EdgeState",
    "MeasurementNoise",
    "MotionNoise",
    "Odometry",
    "RegionFeature",
    "RegionMap",
    "RegionMeasurement",
    "RegionSLAM",
    "Scan",
    "SlamConfig",
    "Subrectangle",
]
