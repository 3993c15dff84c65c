"""Many environments in one process: what ``gymnasium.make_vec`` makes of an id."""

from typing import Any

from regionslam_env.envs.explore import ExploreEnv
from regionslam_env.envs.goto import GoToEnv
from regionslam_env.envs.mission import MissionEnv
from regionslam_env.vector.environment import NavigationVectorEnv

__all__ = ["NavigationVectorEnv", "explore", "goto", "mission"]


def goto(**kwargs: Any) -> NavigationVectorEnv:
    """Return copies of `GoToEnv`; for the arguments see `NavigationVectorEnv`."""
    return NavigationVectorEnv(GoToEnv, **kwargs)


def explore(**kwargs: Any) -> NavigationVectorEnv:
    """Return copies of `ExploreEnv`; for the arguments see `NavigationVectorEnv`."""
    return NavigationVectorEnv(ExploreEnv, **kwargs)


def mission(**kwargs: Any) -> NavigationVectorEnv:
    """Return copies of `MissionEnv`; for the arguments see `NavigationVectorEnv`."""
    return NavigationVectorEnv(MissionEnv, **kwargs)
