"""The environments: one for each task."""

from regionslam_env.envs.explore import ExploreEnv
from regionslam_env.envs.goto import GoToEnv
from regionslam_env.envs.mission import MissionEnv

__all__ = ["ExploreEnv", "GoToEnv", "MissionEnv"]
