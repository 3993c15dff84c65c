"""Many environments seen as one: their numbers in one table, their arrays by address."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.env import SemanticNavigationEnv
from regionslam_env.observations import LINK_COLUMNS, Observation
from regionslam_env.simulation.dynamic import DynamicSimulation
from regionslam_env.tasks.goto import GoToTask
from regionslam_env.vector import kernels
from regionslam_env.vector.addresses import Addresses
from regionslam_env.vector.errands import Errands, Terms
from regionslam_env.vector.kernels import COPY, MOVED, SCANNED, STANDING, UPDATED
from slam.lost import LOST
from slam.measurement import LINK, MEASUREMENT, Scan
from slam.motion import Odometry
from slam.resampling import SCHEMES

Ints = NDArray[np.int64]


def can_step_together(envs: Sequence[SemanticNavigationEnv]) -> bool:
    """Say whether the kernels do all that a step of such environments does, and these are alike.

    They know the filter, one world that stands still, and a sensor that sees all around and makes no mistakes.
    """
    return all(map(_known, envs)) and len({(env.max_steps, env.reveal_truth) for env in envs}) == 1


def _known(env: SemanticNavigationEnv) -> bool:
    noise = env.noise
    mistaken = noise.misclassification or noise.misses or noise.false_positives
    still = not isinstance(env.simulation, DynamicSimulation)
    sees_all = env._region_sensor._sighted is None
    return env.localization == "slam" and still and sees_all and not mistaken and env.render_mode != "rgb_array"


class Copies:
    """Environments of one kind, that take their steps together.

    Each remains whole: `store` brings it up to date before something else looks at it or steps it, and `load` takes
    over what that has changed.

    Parameters
    ----------
    envs
        Of the same arguments, each reset once.
    """

    def __init__(self, envs: Sequence[SemanticNavigationEnv]) -> None:
        self.envs, first = envs, envs[0]
        n, config = len(envs), first._localizer.filter.config
        self.records = np.zeros(n, COPY)
        self._addresses = Addresses(n, kernels.ARRAYS)
        self._stepped = np.zeros(n, np.bool_)
        self._normals = (
            np.zeros((n, 2)),
            np.zeros((n, first.sensors.n_lidar_rays)),
            np.zeros((n, config.n_particles, 3)),
        )
        self._uniforms = np.zeros((n, config.n_particles))
        self._rays = np.zeros(first.sensors.n_view_rays)  # scratch, for one copy after the other
        self._generators: list[Any] = [None] * n
        self._scans: list[Any] = [None] * n
        self._resample_below = config.resample_below * config.n_particles
        noise, sensor = config.motion_noise, first._region_sensor
        directions, open_rays, limits, told, gain, confidence = sensor._given[2:8]
        self._settings = (
            first._odometry_sensor.variances,
            (first._lidar._range, first._lidar._sigma, first._lidar._directions),
            (directions, open_rays, limits, told, gain, confidence, sensor._given[10]),
            (noise.distance, noise.heading_per_metre, noise.heading_per_radian),
            (self._resample_below, SCHEMES.index(config.resampling)),
            tuple(config.parameters()),
            tuple(config.priors()),
        )
        alike = isinstance(first.task, GoToTask) and not first.reveal_truth
        self._errands = Errands(envs) if alike else None
        for i in range(n):
            self.load(i)

    def load(self, i: int) -> None:
        """Take over the state of an environment."""
        env, copy, put = self.envs[i], self.records[i], self._addresses.put
        robot, lidar, sensor, observer = env.simulation, env._lidar, env._region_sensor, env._observer
        slam, episode = env._localizer.filter, env._episode
        self._scans[i] = view, records, links, ranges = self._scan_of(i)
        put(i, kernels.STATE, (robot.state, robot._velocities, robot._engine, robot._grid[3]))
        put(i, kernels.FRAME, (episode.frame, episode.book, episode.pose_errors.sums))
        put(i, kernels.SEGMENTS, (lidar._segments, *lidar._nearby.cells))
        put(i, kernels.WALLS, (sensor._walls, *sensor._near_walls.cells, sensor._rows, *sensor._near_rows.cells))
        put(i, kernels.STARTS, (*sensor._given[8:10], self._rays, *sensor._room[1:], sensor._normals, sensor.sightings))
        put(i, kernels.VIEW, (view, records, links, ranges, slam.type_numbers(sensor._types)))
        put(i, kernels.IDS, (observer._ids, observer._places, observer._type_columns, slam.posterior.cloud.particles))
        put(i, kernels.MAPS, tuple(slam.posterior.cloud.maps))
        self._generators[i] = env._odometry_sensor._rng, lidar._rng, slam.rng
        copy.grid = robot._grid[:3]
        copy.scan_number, copy.doubt = slam.progress()
        copy.ess, copy.drawn = slam.posterior.ess, sensor._drawn
        if isinstance(env.task, GoToTask):
            roots = env.task.approach.field.roots
            put(i, kernels.WAY, (roots.grid.clearance, *roots[1:]))
            copy.way_grid = roots.grid[:3]
        self.aim(i)
        self._stepped[i] = False

    def aim(self, i: int) -> None:
        """Take over what an environment has to do now, and how far it has come."""
        env, copy = self.envs[i], self.records[i]
        if self._errands is not None:
            self._errands.load(i)
        copy.goal, copy.kind, copy.completed = env._observer._goal, env._observer._kind, env.task.completed

    def _scan_of(self, i: int) -> tuple[NDArray[Any], ...]:
        """Return room for a scan: its view, measurements and links, and the ranges of the lidar."""
        sensor, lidar = self.envs[i]._region_sensor, self.envs[i]._lidar
        size, most_links = len(sensor._rows), len(sensor._rows) * sensor._most_links
        room = self._scans[i]
        if room is not None and (len(room[1]), len(room[2])) == (size, most_links):
            return room
        view = np.zeros((sensor._n_rays, 2))
        return view, np.zeros(size, MEASUREMENT), np.zeros(most_links, LINK), np.zeros(len(lidar.angles))

    def store(self, i: int) -> None:
        """Bring an environment up to date."""
        if not self._stepped[i]:
            return
        self._stepped[i] = False
        env, copy = self.envs[i], self.records[i]
        view, records, links, ranges = self._scans[i]
        sensor, count = env._region_sensor, int(copy.measurements)
        env.ranges = ranges.copy()
        env.scan = Scan.from_records(records[:count].copy(), sensor._types, links[: copy.links].copy(), view.copy())
        sensor._drawn, sensor._measured = int(copy.drawn), sensor._numbers[:count]
        env._localizer.filter.resume(int(copy.scan_number), float(copy.doubt), float(copy.ess))
        if self._errands is not None:
            self._errands.store(i)
        env._localizer.forget_belief()

    def step(self, which: Ints, commands: NDArray[np.float64]) -> None:
        """Let some of them drive by their commands (N, 2), m/s and rad/s, measure, and update their filters."""
        first, copies, table = self.envs[0], self.records, self._addresses.table
        kernels.drive_all(which, copies, table, commands, first.simulation._drive, first.simulation._margin)
        for i in which[copies["stage"][which] == STANDING]:
            self.envs[i].simulation.touch()
            copies[i].stage = MOVED
        self._draw(which)
        waiting = which
        while len(waiting):
            kernels.perceive_all(waiting, copies, table, (*self._normals, self._uniforms), *self._settings)
            waiting = waiting[copies["stage"][waiting] != UPDATED]
            for i in waiting:
                self._make_room(i)
        self._stepped[which] = True
        for i in which:
            self.envs[i]._localizer.forget_belief()

    def _draw(self, which: Ints) -> None:
        """Draw all random numbers of a step, in each environment as many as its own parts do."""
        motion, lidar, poses = self._normals
        noisy, low = self._settings[1][1] > 0, self.records["ess"] < self._resample_below
        for i in which.tolist():
            of_motion, of_lidar, of_filter = self._generators[i]
            of_motion.standard_normal(out=motion[i])
            if noisy:
                of_lidar.standard_normal(out=lidar[i])
            if low[i]:
                of_filter.random(out=self._uniforms[i])
            of_filter.standard_normal(out=poses[i])

    def _make_room(self, i: int) -> None:
        """Make the room for which a copy has stopped in its step."""
        env, copy = self.envs[i], self.records[i]
        if copy.stage == SCANNED:
            cloud = env._localizer.filter.posterior.cloud
            cloud.make_room(int(copy.measurements), int(copy.demand[0]), int(copy.demand[1]))
            self._addresses.put(i, kernels.MAPS, tuple(cloud.maps))
        else:
            sensor = env._region_sensor
            sensor._rng.standard_normal(out=sensor._normals)
            copy.drawn = 0

    def judge(self, which: Ints, declared: NDArray[np.bool_]) -> tuple[Ints, NDArray[np.float64], Terms | None]:
        """Judge the steps that the kernels can judge; return whose these are, rewards (N,) and their terms.

        The others have to be judged by their environments, whose tasks are brought up to date for it.
        """
        judged, rewards, terms = np.zeros(0, np.int64), np.zeros(len(self.envs)), None
        if self._errands is not None:
            kernels.look_ahead(which, self.records, self._addresses.table)
            judged, rewards, terms = self._errands.judge(which, self.records, declared)
            for i in np.setdiff1d(which, judged).tolist():
                self._errands.store(i)
        return judged, rewards, terms

    def lost(self, which: Ints) -> Ints:
        """Return those whose filters got lost in this step; their beliefs have to be asked for."""
        return which[self.records["doubt"][which] > LOST]

    def note(self, i: int) -> None:
        """Write the step of a copy that got lost into the book of its episode."""
        env, copy = self.envs[i], self.records[i]
        belief = env.belief
        collided = env.simulation.collided
        env._episode.add(self.odometry(i), collided, copy.true_pose.copy(), belief.pose_mean, belief.pose_cov)

    def odometry(self, i: int) -> Odometry:
        """Return the odometry of the last step."""
        return Odometry(*self.records[i].odometry.tolist())

    def observe(self, which: Ints, declared: NDArray[np.bool_], out: Observation) -> None:
        """Write the observations of some copies into the rows of `out`."""
        first = self.envs[0]
        observer, n = first._observer, len(self.envs)
        senses = tuple(out[key] for key in ("pose", "pose_cov", "velocity", "lidar", "goal", "progress"))
        n_slots = out["regions_mask"].shape[1]
        maps = (
            out["regions"].reshape(n, n_slots, -1),
            out["regions_mask"],
            out["links"].reshape(n, -1, LINK_COLUMNS),
            out["links_mask"],
        )
        kernels.observe_all(
            which,
            self.records,
            self._addresses.table,
            declared,
            senses,
            maps,
            observer._limits,
            len(observer.types),
            first.max_steps,
            first._localizer.filter.config.confirmed_after,
        )
