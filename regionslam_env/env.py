"""The environment: composition of world, robot, sensors, filter and task, in the order of one step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from functools import partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from regionslam_env.actions import ARRIVALS, Arrival, action_space, read_action
from regionslam_env.arguments import (
    CommonArguments,
    ResetOptions,
    one_of,
    read_options,
    robot_config,
    sensor_config,
    whole_number,
    yes_or_no,
)
from regionslam_env.belief import LOCALIZATIONS, Localization, Localizer
from regionslam_env.config import (
    SEMANTIC_TYPES,
    DynamicsConfig,
    NoiseConfig,
    RobotConfig,
    dynamics_set,
    noise_set,
)
from regionslam_env.errors import ConfigError, unknown
from regionslam_env.fused.copies import Copies, can_be_fused
from regionslam_env.fused.kernels import OBSERVED
from regionslam_env.missions.mission import Mission, goal_of
from regionslam_env.observations import Observation, Observer, observed_types
from regionslam_env.registration import id_of, misplaced
from regionslam_env.sensors.lidar import Lidar
from regionslam_env.sensors.odometry import OdometrySensor
from regionslam_env.sensors.region_sensor import RegionSensor
from regionslam_env.simulation.dynamic import DynamicSimulation
from regionslam_env.simulation.movers import Movers, Scene
from regionslam_env.simulation.physics import Simulation
from regionslam_env.tasks.drawing import MissionSource
from regionslam_env.tasks.episode import Episode
from regionslam_env.tasks.metrics import MAP_METRICS
from regionslam_env.tasks.start import checked_start
from regionslam_env.tasks.task import Moment, Task, TaskSettings
from regionslam_env.worlds.generate.options import WorldOptions
from regionslam_env.worlds.geodesic import shared_geodesic
from regionslam_env.worlds.source import SPLITS, WorldSource
from regionslam_env.worlds.world import World
from slam.belief import Belief
from slam.config import SlamConfig
from slam.evaluation.map_quality import map_quality
from slam.measurement import Scan
from slam.motion import Odometry

if TYPE_CHECKING:
    from regionslam_env.rendering.renderer import Renderer
    from regionslam_env.rendering.text_picture import TextRenderer

Floats = NDArray[np.float64]
Info = dict[str, Any]

FIRST = np.zeros(1, np.int64)
"""The one among the copies of an environment that is alone."""

MOST_SLOTS, MOST_PARTICLES = 10_000, 100_000
"""Rows for regions, and particles: more would not fit into memory."""


class SemanticNavigationEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """What all environments share: a floor that is not known, a robot that only believes where it is, and a task.

    The environments themselves are `GoToEnv`, `ExploreEnv` and `MissionEnv`; each adds the sections of its own.

    ## Description

    A round robot with two driven wheels stands somewhere on an annotated floor. It never learns where it is: its
    odometry drifts, and a region-based FastSLAM 2.0 filter (Oberländer et al. 2008) turns noisy and partial
    measurements of rooms, hallways, doors and furniture into a belief about pose and semantic map. That belief is the
    observation. Success is judged on the truth.

    ## Action Space

    `Box(-1, 1, (2,), float32)`: forward speed and turn rate, as shares of the robot's largest (1 m/s and 2 rad/s).
    With `arrival="declare"` it is `Box(-1, 1, (3,), float32)`, and a third component above 0 declares that the robot
    has done what it was told.

    ## Observation Space

    A `Dict`; lengths are clipped to 1000 m, and S = 32 (`max_regions`), T = 24 (`semantic_types`). Tables are flattened
    row by row; `regionslam_env.region_table` and `link_table` give back the rows, `RegionColumn` and `LinkColumn` name
    the columns.

    | Key | Space | Shape | Content |
    | --- | --- | --- | --- |
    | pose | Box | (4,) | mean x, y (m), cos and sin of the heading, in the map frame: the start pose is its origin |
    | pose_cov | Box | (9,) | covariance of x, y (m), heading (rad), row by row |
    | velocity | Box | (2,) | forward speed (m/s) and turn rate (rad/s) by odometry |
    | regions | Box | (1600,) | S rows of 26 + T: geometry in the robot's frame, open edges, probabilities |
    | regions_mask | MultiBinary | (32,) | which rows hold a region; a region keeps its row until it is evicted |
    | links | Box | (512,) | 4 S rows, strongest first: row, row, probability, kind (0 passage, 1 second in first) |
    | links_mask | MultiBinary | (128,) | which rows hold a link |
    | lidar | Box | (180,) | distance (m) along rays all around, counter-clockwise from straight back |
    | goal | Box | (24,) | one-hot over the T semantic types: where to go now; zeros where no type is looked for |
    | progress | Box | (6,) | shares of steps passed and of instructions done, declared, now: go to, explore, return |

    ## Rewards

    The sum of named terms, which stand in `info["reward_terms"]`; `reward` changes their weights.

    ## Starting State

    At rest, in any direction, where the robot fits. `reset(options={"start": (x, y, theta)})` sets the start of one
    episode (world frame, m and rad).

    `reset(options={"keep_map": True})` goes on with the map of the episode before, in the same world: map frame, map
    and rows stay, and so does the robot, unless a `start` is given. Then it has been carried, and the filter has to
    find it again on its map; the oracle is told, and dead reckoning refuses.

    With the kind of world "office", "apartment", "school", "hospital" or "campus", every reset draws a new one, whose
    number is in `info["world_seed"]`; `reset(options={"world_seed": 3})` enters a certain one of the split.

    ## Episode End

    * Truncation: after `max_steps` steps.

    The last `info` holds the metrics of `regionslam_env.tasks.metrics.METRICS`; None where one has no meaning.

    ## Arguments

    | Argument | Default | Meaning |
    | --- | --- | --- |
    | world | "institute" | a built-in floor, the path of a world file, a `World`, or a kind (above) |
    | world_options | None | of a kind's worlds: keys of `WorldOptions` (`size`, `clutter`, `ambiguity`) |
    | split | "train" | "train", "val" or "test": disjoint seeds of worlds, missions and noise |
    | localization | "slam" | "slam", "oracle" (true pose) or "odometry" (dead reckoning); same seed, same noise |
    | arrival | "stay" | "stay" or "declare" |
    | n_particles | 4 | particles of the filter |
    | sensor_range | 8.0 | range of the region sensor, m |
    | occlusion | True | whether walls hide regions |
    | sensors | None | other keys of `SensorConfig` |
    | robot | "standard" | keys of `RobotConfig` |
    | noise | "standard" | "standard", "heavy", "none", or keys of `NoiseConfig` |
    | dynamics | None | "people", "doors", "furniture", "all", or keys of `DynamicsConfig`: what moves; None: nothing |
    | max_regions | 32 | rows for regions in an observation |
    | semantic_types | `SEMANTIC_TYPES` | types an observation tells apart; all others count as "other" |
    | reveal_truth | False | puts the true pose and distance into `info["truth"]` |
    | render_mode | None | "rgb_array" or "ansi" (the belief as text); with `gymnasium.make` also "human", a window |

    ## Version History

    * v0: first version.
    """

    metadata = {  # noqa: RUF012 - declared by Gymnasium as it is
        "render_modes": ["rgb_array", "ansi"],
        "render_fps": 10,
    }
    task_type: ClassVar[type[Task]]
    """What is done."""

    def __init__(
        self,
        task_arguments: Mapping[str, Any],
        wanted: Any,
        max_steps: int,
        *,
        world: str | Path | World = "institute",
        world_options: Mapping[str, Any] | WorldOptions | None = None,
        split: str = "train",
        localization: Localization = "slam",
        arrival: Arrival = "stay",
        n_particles: int = 4,
        sensor_range: float = 8.0,
        occlusion: bool = True,
        sensors: Mapping[str, Any] | None = None,
        robot: str | Mapping[str, Any] | RobotConfig = "standard",
        noise: str | Mapping[str, Any] | NoiseConfig = "standard",
        dynamics: str | Mapping[str, Any] | DynamicsConfig | None = None,
        max_regions: int = 32,
        semantic_types: Sequence[str] = SEMANTIC_TYPES,
        reveal_truth: bool = False,
        render_mode: str | None = None,
        **others: object,
    ) -> None:
        for name, value in others.items():
            line = misplaced(id_of(type(self)), self.task_type.option, name, value)
            if line is not None:
                raise ConfigError(line)
            own = (p.name for p in signature(type(self)).parameters.values() if p.kind is p.KEYWORD_ONLY)
            raise ConfigError(unknown("argument", name, [*own, *CommonArguments.__annotations__]))
        self._split = one_of("split", split, SPLITS)
        self.localization = one_of("localization", localization, LOCALIZATIONS)
        self.arrival = one_of("arrival", arrival, ARRIVALS)
        if render_mode is not None:
            one_of("render_mode", render_mode, self.metadata["render_modes"])
        self.max_steps = whole_number("max_steps", max_steps)
        n_slots = whole_number("max_regions", max_regions, MOST_SLOTS)
        n_particles = whole_number("n_particles", n_particles, MOST_PARTICLES)
        self.robot = robot_config(robot)
        self.sensors = sensor_config(sensor_range, occlusion, sensors)
        self.noise, self.dynamics = noise_set(noise), dynamics_set(dynamics)
        self.semantic_types = observed_types(semantic_types)
        self.reveal_truth, self.render_mode = yes_or_no("reveal_truth", reveal_truth), render_mode

        self.localizer = Localizer(self.localization, self._slam_config(n_particles))
        settings = TaskSettings(self.semantic_types, self.robot.step, self.arrival == "declare")
        task_in = partial(_task_in, self.task_type, self.robot.radius, settings, task_arguments)
        mission = None if wanted is None else self.task_type.read(wanted, self.semantic_types)
        self._missions = MissionSource(WorldSource(world, world_options, self._split), task_in, mission)
        self._enter(self._missions.task)
        self.observer = Observer(
            self.semantic_types, n_slots, self.robot, self.sensors.n_lidar_rays, self.sensors.lidar_range
        )
        self.observation_space: spaces.Dict = self.observer.space  # type: ignore[assignment]
        self.action_space: spaces.Box = action_space(self.arrival)  # type: ignore[assignment]
        self._n_actions = len(self.action_space.low)
        self._running = False
        self.fusible = can_be_fused(self)
        self.known_to: Copies | None = None  # who holds the arrays of the parts; nobody once any may be replaced
        self._fused: Copies | None = None
        self._renderer: Renderer | TextRenderer | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, Info]:
        """Begin an episode.

        Parameters
        ----------
        seed
            Of every random number to come; the same one gives the same episodes. With ``keep_map``, the filter and what
            moves go on with their own.
        options
            ``goal``: semantic type to go to, or ``mission``: what to do, in words or as a `Mission`, whichever the task
            takes; ``start``: true pose (x, y, theta) in the world frame, m and rad;
            ``world_seed``: number of the world to enter, for an environment with a kind of worlds; ``keep_map``:
            whether the filter keeps its map, and the robot stays where it is unless ``start`` is given.

        Raises
        ------
        ConfigError
            For an unknown option, goal or mission, a start that is not free, a goal that cannot be reached from it, or
            a map that cannot be kept. The episode before goes on then.
        """
        generator = deepcopy(self._np_random), self._np_random_seed
        super().reset(seed=seed)
        try:
            return self._reset(read_options(options))
        except ConfigError:  # as if nobody had asked
            self._np_random, self._np_random_seed = generator
            raise

    def _reset(self, chosen: ResetOptions) -> tuple[Observation, Info]:
        """Begin an episode, the seed being set."""
        self.known_to = None
        mission_rng, odometry_rng, lidar_rng, region_rng, filter_rng, world_rng, movers_rng = self._generators()
        if chosen.keep_map:
            number = self._go_on(mission_rng, chosen)
        else:
            number = self._begin(mission_rng, world_rng, filter_rng, chosen)
        self._aim()
        if self.movers is not None:
            self.movers.begin(movers_rng, self.mission.start, chosen.keep_map)
        self.simulation.reset(*self.mission.start)
        self.odometry_sensor.reset(odometry_rng)
        self.lidar.reset(lidar_rng)
        self.region_sensor.reset(region_rng, keep_sightings=chosen.keep_map)
        self.episode = Episode(self.mission, self._origin)
        self._running = True
        self._true_path: list[Floats] = []
        self._path: list[Floats] = []
        self._renderer = None
        standing, pose = Odometry(0.0), self.simulation.pose
        self._perceive(standing, pose, self.episode.in_map(pose))
        observation = self.observe(standing, False)
        info: Info = {"mission": self.mission_text}
        if number is not None:
            info["world_seed"] = number
        if self.reveal_truth:
            info["truth"] = self.truth()
        return observation, info

    def _begin(
        self,
        mission_rng: np.random.Generator,
        world_rng: np.random.Generator,
        filter_rng: np.random.Generator,
        chosen: ResetOptions,
    ) -> int | None:
        """Draw world and mission and forget every map; return the number of the world, if it has one."""
        self.mission, number = self._missions.draw(
            mission_rng, world_rng, self._wanted(chosen), chosen.start, chosen.world_seed
        )
        if self._missions.task is not self.task:
            self._enter(self._missions.task)
        self._origin = self.mission.start
        self.localizer.reset(filter_rng)
        self.observer.reset()
        return number

    def _go_on(self, mission_rng: np.random.Generator, chosen: ResetOptions) -> int | None:
        """Draw a mission in the same world and keep the map; return the number of the world, if it has one."""
        if not hasattr(self, "mission"):
            raise ConfigError("keep_map is True, expected False in the first reset: there is no map yet")
        if chosen.start is not None and self.localization == "odometry":
            raise ConfigError(
                f"start is {chosen.start!r}, expected none with keep_map and localization='odometry': "
                "dead reckoning cannot find a robot that was carried"
            )
        if chosen.start is not None and self.movers is not None:
            x, y, _ = checked_start(self.task.geodesic, chosen.start, standing=False)
            if self.movers.blocks(x, y):
                raise ConfigError(f"start ({x:g}, {y:g}) is not free: furniture or a closed door is there now")
        self.mission, number = self._missions.stay(
            mission_rng,
            self.true_pose.tolist(),
            self._origin,
            self._wanted(chosen),
            chosen.start,
            chosen.world_seed,
        )
        if chosen.start is not None:
            self.localizer.carry()
        return number

    def _wanted(self, chosen: ResetOptions) -> Mission | None:
        """Return the mission that is asked for, if one is."""
        value = chosen.wanted(self.task_type.option)
        return None if value is None else self.task_type.read(value, self.semantic_types)

    def _aim(self) -> None:
        """Let observations tell what is to be done now."""
        self._completed, self._instruction = self.task.completed, self.task.instruction
        self.observer.aim(self._instruction)

    def _enter(self, task: Task) -> None:
        """Put robot and sensors into a task's world."""
        self.task, self.world = task, task.world
        self.movers = None if self.dynamics.still else Movers(self.world, self.dynamics, self.robot)
        if self.movers is None:
            self.simulation, arrays = Simulation(self.world, self.robot), self.world.arrays
        else:
            self.simulation, arrays = DynamicSimulation(self.movers, self.robot), self.movers.fixed
        idle = np.random.default_rng(0)
        self.odometry_sensor = OdometrySensor(self.noise, idle)
        self.lidar = Lidar(self.sensors, self.noise, arrays, idle, self.movers)
        self.region_sensor = RegionSensor(self.sensors, self.noise, arrays, idle, self.movers)

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, Info]:
        """Drive for one step, measure, update the belief, and judge what happened.

        Raises
        ------
        ValueError
            For an action of another shape or with a component that is not a number.
        ResetNeeded
            Before the first reset and after the end of an episode.
        """
        if not self._running:
            raise ResetNeeded("there is no running episode: call env.reset() first")
        forward, turn, declared = read_action(action, self._n_actions)
        speed, turn_rate = forward * self.robot.max_speed, turn * self.robot.max_turn_rate
        if self.fusible and self.is_under_way:
            return self._step_fused(speed, turn_rate, declared)
        self.known_to = None
        before = self.simulation.pose
        self.simulation.step(speed, turn_rate)
        pose, collided = self.simulation.pose, self.simulation.collided
        odometry = self.odometry_sensor.measure(before, pose)
        true_pose = self.episode.in_map(pose)
        self._perceive(odometry, pose, true_pose)
        self.note(odometry, true_pose)
        reward, terminated, truncated, info = self.judge(pose, collided, declared)
        observation = self.observe(odometry, declared)
        return observation, reward, terminated, truncated, info

    @property
    def is_under_way(self) -> bool:
        """Whether an episode is running and the filter knows where on its map the robot is."""
        return self._running and not self.localizer.filter.lost

    def _step_fused(
        self, speed: float, turn_rate: float, declared: bool
    ) -> tuple[Observation, float, bool, bool, Info]:
        """Do the same in one compiled call, for all that it knows."""
        if self._fused is None:
            self._fused = Copies([self])
        fused = self._fused
        fused.step(FIRST, np.array(((speed, turn_rate),)), np.array((declared,)))
        if fused.stage[0] == OBSERVED:
            verdict = self._quiet_verdict(fused.progress[0], fused.collided[0])
        else:
            verdict = fused.settle(0)
        if self.render_mode == "rgb_array":
            self._remember(self.simulation.pose, self.belief)
        return (fused.observation(0), *verdict)

    def _quiet_verdict(self, progress: float, collided: bool) -> tuple[float, bool, bool, Info]:
        """Return the verdict of a step that ends nothing: progress (m), and whether something held the robot back."""
        terms = self.task.quiet_terms(float(progress), bool(collided))
        return sum(terms.values()), False, False, self._told(terms)

    def _told(self, terms: dict[str, float]) -> Info:
        """Return what every info of a step holds."""
        truth = {"truth": self.truth()} if self.reveal_truth else {}
        return {"reward_terms": terms, **truth}

    def note(self, odometry: Odometry, true_pose: Floats) -> None:
        """Write a step into the book of the episode; the true pose is in the map frame."""
        belief = self.belief
        self.episode.add(odometry, self.simulation.collided, true_pose, belief.pose_mean, belief.pose_cov)

    def judge(self, pose: Floats, collided: bool, declared: bool) -> tuple[float, bool, bool, Info]:
        """Judge a step that ends at a true pose: reward, terminated, truncated and info."""
        last = self.episode.steps >= self.max_steps
        moment = Moment(pose, collided, declared, lambda: self.belief, self._origin, last)
        terms, success, terminated = self.task.verdict(moment)
        if self.task.completed != self._completed:
            self._aim()
        truncated = last and not terminated
        info = self._told(terms)
        if terminated or truncated:
            self._running = False
            info |= self._metrics(success, terminated, declared)
        return sum(terms.values()), terminated, truncated, info

    def _perceive(self, odometry: Odometry, pose: Floats, true_pose: Floats) -> Belief:
        """Measure from a true pose (world frame; `true_pose` in the map frame) and return the updated belief."""
        self.lidar.measure(pose)
        belief = self.localizer.step(odometry, self.region_sensor.measure(pose), true_pose)
        if self.render_mode == "rgb_array":
            self._remember(pose, belief)
        return belief

    def _remember(self, pose: Floats, belief: Belief) -> None:
        """Keep the true and the believed pose for the pictures."""
        self._true_path.append(pose)
        self._path.append(belief.pose_mean)

    def observe(self, odometry: Odometry, declared: bool) -> Observation:
        """Return the observation of this moment."""
        elapsed = self.episode.steps / self.max_steps
        return self.observer.observe(
            self.localizer.belief, odometry, self.lidar.ranges, elapsed, self.task.completed, declared
        )

    def render(self) -> Any:
        """Return the picture of this moment, (H, W, 3) uint8, or the belief in words and signs, by `render_mode`."""
        if self.render_mode is None or not hasattr(self, "mission"):
            return None
        if self.render_mode == "ansi":
            return self._write()
        return self._draw()

    def close(self) -> None:
        """Forget the pictures; the environment holds nothing else to be closed."""
        self._renderer = None

    @property
    def belief(self) -> Belief:
        """What the robot believes after the last step."""
        return self.localizer.belief

    @property
    def ranges(self) -> Floats:
        """Distances along the rays of the lidar after the last step, m, a copy."""
        return self.lidar.ranges.copy()

    @property
    def scan(self) -> Scan:
        """Regions measured in the last step, in the robot's frame."""
        return self.region_sensor.scan

    @property
    def slot_ids(self) -> NDArray[np.int64]:
        """Ids of the regions in the rows of the last observation, -1 where there never was one, shape (S,)."""
        return self.observer.slot_ids

    @property
    def true_pose(self) -> Floats:
        """True pose (x, y, theta) in the world frame, m and rad."""
        return self.simulation.pose

    @property
    def fixed_world(self) -> World:
        """The world without the furniture that may move."""
        return self.world if self.movers is None else self.movers.fixed_world

    @property
    def scene(self) -> Scene | None:
        """What moves in the world, where it is now; None where nothing does."""
        return None if self.movers is None else self.movers.scene

    @property
    def goal(self) -> str | None:
        """Semantic type to go to now; None where none is looked for."""
        return goal_of(self._instruction)

    @property
    def mission_text(self) -> str:
        """The running mission in words."""
        return str(self.mission.mission)

    @property
    def instruction_text(self) -> str:
        """What of the mission is to be done now, in words; nothing for a mission of one instruction."""
        return self.mission.mission.now(self.task.completed)

    def __getstate__(self) -> dict[str, Any]:
        """Pickle everything but pictures and addresses, so that an episode continues identically elsewhere."""
        return self.__dict__ | {"_renderer": None, "_fused": None, "known_to": None}

    def _generators(self) -> list[np.random.Generator]:
        """Return the episode's own generators: of mission, every sensor, filter, world, and what moves.

        Each is spawned from the episode's seed, so that none depends on how much another one draws: the rungs of the
        ladder and the noise sets share world, mission and start.
        """
        seed = int(self.np_random.integers(2**63, dtype=np.uint64))
        sequence = np.random.SeedSequence([seed, SPLITS.index(self._split)])
        return [np.random.default_rng(child) for child in sequence.spawn(7)]

    def _slam_config(self, n_particles: int) -> SlamConfig:
        particles = n_particles if self.localization == "slam" else 1
        return SlamConfig(
            n_particles=particles,
            motion_noise=self.noise.odometry,
            measurement_noise=self.noise.regions,
            sensor_range=self.sensors.range,
        )

    def truth(self) -> Info:
        """Return what no agent may see: true poses (world frame and map frame), distance to the goal (m) or None."""
        pose = self.simulation.pose
        moving = {} if self.movers is None else self.movers.truth
        pose_in_map = self.episode.in_map(pose)
        return {"pose": pose, "pose_in_map": pose_in_map, "distance_to_goal": self.task.remaining, **moving}

    def _metrics(self, success: bool, over: bool, declared: bool) -> Info:
        """Return the metrics of the episode that ends here."""
        # What was in view less often than a region needs to be confirmed, the map cannot be asked for.
        seen = self.region_sensor.sightings >= self.belief.confirmed_after
        quality = map_quality(
            self.belief.map.regions,
            self.world.regions if self.movers is None else self.movers.true_regions,
            [(link.source, link.target) for link in self.world.links],
            {self.world.regions[i].id for i in np.flatnonzero(seen)},
            self._origin,
        )
        figures = {name: getattr(quality, name.removeprefix("region_")) for name in MAP_METRICS}
        return self.episode.metrics(
            success,
            over,
            declared if self.arrival == "declare" else None,
            self.task.believed(self.belief),
            self.task.remaining,
            self.simulation.path_length,
            figures | {"completed": self.task.completed} | dict(self.task.figures),
        )

    def _write(self) -> str:
        """Return the robot's own words about its place, and the believed map in characters."""
        from regionslam_env.rendering.shapes import shapes_of_map
        from regionslam_env.rendering.text_picture import TextRenderer

        if not isinstance(self._renderer, TextRenderer):
            self._renderer = TextRenderer()
        belief = self.belief
        words = f"{self.mission_text}: {belief.map.describe(belief.pose_mean)}"
        return f"{words}\n{self._renderer.frame(shapes_of_map(belief.map), belief.pose_mean, self.goal)}"

    def _draw(self) -> NDArray[np.uint8]:
        """Draw truth and belief; what draws is imported here, so that nothing else needs it."""
        from regionslam_env.rendering.renderer import Renderer, Snapshot
        from regionslam_env.rendering.shapes import shapes_of_map

        if not isinstance(self._renderer, Renderer):
            self._renderer = Renderer(
                self.fixed_world,
                self._origin,
                robot_radius=self.robot.radius,
                lidar_range=self.sensors.lidar_range,
                scene=self.scene,
            )
        belief = self.belief
        snapshot = Snapshot(
            true_pose=self.true_pose,
            pose=belief.pose_mean,
            covariance=belief.pose_cov,
            shapes=shapes_of_map(belief.map),
            true_path=self._true_path,
            path=self._path,
            lidar=self.ranges,
            title=self.mission_text,
            now=self.instruction_text,
            goal=self.goal,
            caption=belief.map.describe(belief.pose_mean),
            seconds=self.episode.steps * self.robot.step,
            driven=self.simulation.path_length,
            scene=self.scene,
        )
        return self._renderer.frame(snapshot)


def _task_in(
    task_type: type[Task], radius: float, settings: TaskSettings, arguments: Mapping[str, Any], world: World
) -> Task:
    """Return the task in a world, for a robot of this radius, m."""
    return task_type(world, shared_geodesic(world, radius), settings, **arguments)
