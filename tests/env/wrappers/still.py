"""An environment that shows one hand-made observation and takes note of the actions."""

from __future__ import annotations

import gymnasium
import numpy as np

from regionslam_env.actions import action_space
from regionslam_env.config import RobotConfig
from regionslam_env.missions.mission import GoTo
from regionslam_env.observations import Observer
from slam.belief import Belief
from slam.motion import Odometry

TYPES = ("office", "hallway", "kitchen", "door", "other")


def observer(n_slots=6, goal="kitchen", n_rays=72):
    made = Observer(TYPES, n_slots, RobotConfig(), n_lidar_rays=n_rays, lidar_range=10.0)
    made.reset()
    made.aim(GoTo(goal))
    return made


def belief_of(built):
    particles = built.set.particles
    return Belief(
        pose_mean=particles[0]["pose"].copy(), pose_cov=np.diag([0.04, 0.01, 0.001]), ess=1.0,
        pose=particles[0]["pose"].copy(), heaviest=0, types=built.types, particles=particles, maps=built.maps,
        confirmed_after=3,
    )  # fmt: skip


class Still(gymnasium.Env):
    def __init__(self, built, made=None, ranges=None):
        made = made or observer()
        self.observation_space, self.action_space = made.space, action_space("stay")
        ranges = np.linspace(1.0, 8.0, len(made.space["lidar"].low)) if ranges is None else ranges
        self.shown = made.observe(belief_of(built), Odometry(0.05, 0.0, 0.02), ranges, 0.25, 0.0, False)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return self.shown, {}

    def step(self, action):
        return self.shown, 0.0, False, False, {}
