"""Environments of one kind as kernels see them: a record and a row of addresses each.

Everything that changes from step to step stands in arrays that the parts of an environment share with the kernels: a
step by kernels and one by Python follow each other as they like. Arrays are replaced, too (a new world, a map that has
outgrown its own): whoever does that, or may have done it, sets `known_to` of the environment to None, and `Copies` take
hold of the arrays again before the next step. So do other `Copies` of the same environment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numba
import numpy as np
from numpy.typing import NDArray

from regionslam_env.fused import kernels
from regionslam_env.fused.addresses import Addresses
from regionslam_env.fused.kernels import COPY, JUDGED, MOVED, SCANNED, STANDING, UPDATED
from regionslam_env.observations import LINK_COLUMNS, Observation
from regionslam_env.simulation.dynamic import DynamicSimulation
from slam.motion import Odometry
from slam.resampling import SCHEMES
from slam.sampled import SampledPosterior

if TYPE_CHECKING:
    from regionslam_env.env import SemanticNavigationEnv

Ints = NDArray[np.int64]

MOST_STEPS = 2**63 - 1
"""More steps than a kernel can count are as good as without end."""


def can_be_fused(env: SemanticNavigationEnv) -> bool:
    """Say whether the kernels do all that a step of an environment does.

    They know particles that the filter itself draws, a world that stands still, and a sensor that sees all around and
    makes no mistakes.
    """
    if numba.config.DISABLE_JIT or isinstance(env.simulation, DynamicSimulation) or env.localization != "slam":
        return False
    sampled = env.localizer.filter.config.posterior == "fastslam2"
    return sampled and env.region_sensor.is_exact and env.region_sensor.sees_all_around


class Copies:
    """Environments that take their steps together, or one that takes its own.

    Parameters
    ----------
    envs
        Of the same arguments, each reset before its first step.
    out
        Where their observations are written, an array of shape (N, size) for every key; None: arrays of their own.

    Attributes
    ----------
    records
        What is said of each before a step, and what its step brings: `COPY`.
    stage, progress, collided
        Columns of it, each of shape (N,).
    out
        Their observations.
    """

    def __init__(self, envs: Sequence[SemanticNavigationEnv], out: Mapping[str, NDArray[Any]] | None = None) -> None:
        self.envs, first = envs, envs[0]
        n, config = len(envs), first.localizer.filter.config
        self.records = np.zeros(n, COPY)
        self.stage, self.progress, self.collided = (self.records[name] for name in ("stage", "progress", "collided"))
        self.out = out or {
            key: np.zeros((n, *(space.shape or ())), space.dtype) for key, space in first.observation_space.items()
        }
        self._addresses = Addresses(n, kernels.ARRAYS)
        self._pose_normals = list(np.zeros((n, config.n_particles, 3)))
        self._uniforms = list(np.zeros((n, config.n_particles)))
        self._generators: list[Any] = [None] * n
        self._sample_sizes: list[Any] = [None] * n
        self._resample_below = config.resample_below * config.n_particles
        noise, robot, observer = config.motion_noise, first.simulation, first.observer
        self._settings: tuple[Any, ...] = (
            robot.settings,
            first.odometry_sensor.variances,
            first.lidar.settings,
            first.region_sensor.settings,
            (
                (noise.distance, noise.heading_per_metre, noise.heading_per_radian),
                (self._resample_below, SCHEMES.index(config.resampling)),
                config.relocalise,
                tuple(config.parameters()),
                tuple(config.priors()),
            ),
            (observer.limits, len(observer.types), config.confirmed_after),
        )

    def _take_hold(self, i: int) -> None:
        """Take hold of the arrays of an environment, and of what it has to do."""
        env, put = self.envs[i], self._addresses.put
        robot, episode, slam = env.simulation, env.episode, env.localizer.filter
        posterior = cast(SampledPosterior, slam.posterior)
        noises = env.odometry_sensor.normals, env.lidar.normals, env.region_sensor.normals
        noise = [array for normals in noises for array in (normals.numbers, normals.used)]
        cloud, sensor, observer = posterior.cloud, env.region_sensor, env.observer
        put(i, kernels.STATE, robot.arrays)
        put(i, kernels.FRAME, (episode.frame, episode.book, episode.pose_errors.sums))
        put(i, kernels.MOTION_NORMALS, (*noise, self._pose_normals[i], self._uniforms[i]))
        put(i, kernels.SEGMENTS, (*env.lidar.surroundings, env.lidar.ranges))
        put(i, kernels.WALLS, (*sensor.surroundings, *sensor.room, slam.type_numbers(sensor.types)))
        put(i, kernels.PARTICLES, (cloud.particles, *cloud.maps, slam.progress, posterior.sample_size))
        put(i, kernels.IDS, observer.slots(env.belief.types))
        self._put_observation(i)
        self._generators[i], self._sample_sizes[i] = slam.rng, posterior.sample_size
        self._aim(i)
        env.known_to = self

    def _put_observation(self, i: int) -> None:
        out, columns = self.out, LINK_COLUMNS
        n_slots = out["regions_mask"].shape[1]
        senses = [out[key][i] for key in ("pose", "pose_cov", "velocity", "lidar", "goal", "progress")]
        regions, links = out["regions"][i].reshape(n_slots, -1), out["links"][i].reshape(-1, columns)
        put = (*senses, regions, out["regions_mask"][i], links, out["links_mask"][i])
        self._addresses.put(i, kernels.POSE, put)

    def _aim(self, i: int) -> None:
        """Take over what an environment has to do now."""
        env, copy = self.envs[i], self.records[i]
        copy.goal, copy.kind, copy.completed = *env.observer.aimed, env.task.completed
        approach = env.task.approach
        copy.approaches = approach is not None
        if approach is not None:
            copy.is_last = approach.is_last
            ways = (*approach.field.arrays, *approach.place.arrays, approach.state)
            self._addresses.put(i, kernels.WAY, ways)

    def step(self, which: Ints, commands: NDArray[np.float64], declared: NDArray[np.bool_]) -> None:
        """Let some of them take a step; commands (N, 2), m/s and rad/s, and declarations (N,) are those of all.

        Whose `stage` is `UPDATED` then, instead of `OBSERVED`, has to be judged by `settle`.
        """
        records = self.records
        records["command"], records["declared"] = commands, declared
        self.stage[which] = STANDING
        for i in which.tolist():
            env = self.envs[i]
            if env.known_to is not self:
                self._take_hold(i)
            generator = self._generators[i]
            if self._sample_sizes[i][0] < self._resample_below:
                generator.random(out=self._uniforms[i])
            generator.standard_normal(out=self._pose_normals[i])
            env.localizer.forget_belief()
        self._go_on(which)

    def _go_on(self, which: Ints) -> None:
        """Take some of them through the rest of their steps, with whatever help they need."""
        settings = (*self._settings, min(self.envs[0].max_steps, MOST_STEPS))
        helped: dict[int, int] = {}
        while len(which):
            kernels.step_all(which, self.records, self._addresses.table, *settings)
            which = which[self.stage[which] < UPDATED]
            for i in which.tolist():
                stage = int(self.stage[i])
                if helped.get(i) == stage:
                    raise RuntimeError(f"copy {i} doesn't get beyond stage {stage} of its step, whatever it is given")
                helped[i] = stage
                self._help(i)

    def _help(self, i: int) -> None:
        """Do for a copy what it has stopped for in its step."""
        env, stage = self.envs[i], self.stage[i]
        if stage == STANDING:
            env.simulation.touch()
            self.stage[i] = MOVED
        elif stage == MOVED:
            for sensor in (env.odometry_sensor, env.lidar, env.region_sensor):
                sensor.normals.refill()
        elif stage == SCANNED:
            cloud, demand = env.localizer.filter.posterior.cloud, self.records[i].demand
            cloud.make_room(env.region_sensor.measured, int(demand[0]), int(demand[1]))
            self._addresses.put(i, kernels.MAPS, tuple(cloud.maps))

    def settle(self, i: int) -> tuple[float, bool, bool, dict[str, Any]]:
        """Let an environment itself judge the step of its copy, and write the observation; return the verdict."""
        env, copy = self.envs[i], self.records[i]
        odometry, declared = Odometry(*copy.odometry.tolist()), bool(copy.declared)
        lost = env.localizer.notice_loss()
        if lost:
            env.note(odometry, copy.true_pose.copy())
        verdict = env.judge(copy.pose.copy(), bool(copy.collided), declared)
        if lost:
            for key, value in env.observe(odometry, declared).items():
                self.out[key][i] = value
        else:
            self._aim(i)
            copy.stage = JUDGED
            self._go_on(np.array([i]))
        return verdict

    def observation(self, i: int) -> Observation:
        """Return a copy of the observation of a copy."""
        return {key: rows[i].copy() for key, rows in self.out.items()}
