"""The task `Explore`: map the floor. What has been mapped is judged by the truth, which no agent sees."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from regionslam_env.errors import ConfigError, WorldError
from regionslam_env.missions.mission import Explore
from regionslam_env.tasks.rewards import EXPLORE_REWARD_SETS, explore_reward
from regionslam_env.tasks.task import DrawnMission, Moment, Pose, Task, TaskSettings, Verdict, distance_from
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.reachability import largest_part
from regionslam_env.worlds.world import World
from slam.belief import Belief
from slam.evaluation.matching import match_pairs, moved, overlapping_pairs
from slam.region import EdgeState

ASSESSED_EVERY = 2.0
"""How often the map is compared with the truth, s: what it has gained is paid then."""

OVERLAP, TOLERANCE = 0.5, 1.0
"""When a mapped region stands for a true one, m: as in `slam.evaluation.map_quality`."""


class ExploreTask(Task):
    """Map a share of the regions that the robot can get into, furniture left out.

    Without declarations the mission is done once that is so; with them, once the robot says so.

    Parameters
    ----------
    world, geodesic, settings
        As in `Task`.

    Raises
    ------
    ConfigError
        For a world whose regions cannot be entered.
    """

    takes_goal = False
    reward_sets = EXPLORE_REWARD_SETS

    def __init__(self, world: World, geodesic: Geodesic, settings: TaskSettings) -> None:
        super().__init__(world, geodesic, settings)
        reachable = largest_part(geodesic)
        if not reachable:
            raise ConfigError(f"world {world.name!r} has no region that the robot can be in")
        self._floor = geodesic.field(reachable[:1])
        self.wanted = frozenset(world.regions[i].id for i in reachable)
        self._period = max(1, round(ASSESSED_EVERY / settings.step))
        self._steps, self._shares = 0, (0.0, 0.0)

    def draw(
        self,
        rng: np.random.Generator,
        goal: str | None = None,
        start: Sequence[float] | None = None,
        standing: bool = False,
    ) -> DrawnMission:
        """Draw a start in the largest connected part of the floor, or check the one given; a goal is refused."""
        if goal is not None:
            raise ConfigError(f"goal is {goal!r}, expected none: this task looks for no type of region")
        if start is None:
            try:
                x, y = self.geodesic.sample_free(rng, self._floor)
            except WorldError as error:
                raise ConfigError(str(error)) from error
            pose: Pose = (x, y, float(rng.uniform(-math.pi, math.pi)))
        else:
            pose = self.checked(start, standing)
        if not math.isfinite(distance_from(self._floor, pose, standing)):
            raise ConfigError(
                f"world {self.world.name!r}: no way from ({pose[0]:.2f}, {pose[1]:.2f}) "
                "to the largest connected part of the floor"
            )
        self._steps, self._shares = 0, (0.0, 0.0)
        return DrawnMission(str(Explore()), pose, None, None)

    def verdict(self, moment: Moment) -> Verdict:
        """Judge a step: compare the map with the truth when due, and pay for what it has gained since."""
        self._steps += 1
        before = self._shares
        if self._steps % self._period == 1 % self._period or moment.declared or moment.last:
            self._shares = shares(moment.belief, moment.origin, self.world, self.wanted)
        if self._steps == 1:  # what was mapped in an earlier episode has been paid
            before = self._shares
        recall, edges = (now - then for now, then in zip(self._shares, before, strict=True))
        enough = self._shares[0] >= self.settings.map_share - 1e-9
        success = enough and (moment.declared or not self.settings.declares)
        wrong = moment.declared and not enough
        terms = explore_reward(self.rewards, recall, edges, success, moment.collided, wrong)
        return Verdict(terms, success, success or wrong)

    @property
    def figures(self) -> Mapping[str, float | None]:
        """Shares of the wanted regions that are mapped, and of their edges that are closed."""
        return {"explored": self._shares[0], "closed_edges": self._shares[1]}


def shares(belief: Belief, origin: Pose, world: World, wanted: frozenset[str]) -> tuple[float, float]:
    """Return the shares of wanted regions on the believed map and of their edges that are closed, each in [0, 1].

    A region that is not mapped has no closed edge; joints of rectangles are no edges.

    Parameters
    ----------
    belief
        About the map.
    origin
        Pose of the map frame in the world frame.
    world
        The truth.
    wanted
        Ids of its regions, at least one.
    """
    rooms = [region for region in world.regions if region.parent is None]
    furniture = set(world.types) - {region.type for region in rooms}  # inside of rooms, which it could be taken for
    mapped = [feature for feature in belief.map.regions if feature.type not in furniture]
    features = {feature.id: feature for feature in mapped}
    rows = [moved(feature.row, origin) for feature in mapped]
    pairs = overlapping_pairs(mapped, rows, rooms, OVERLAP, TOLERANCE)
    matches = match_pairs(pairs, mapped, rows, rooms, OVERLAP)
    found = [features[match.mapped] for match in matches if match.true in wanted]
    closed = 0.0
    for feature in found:
        edges = [state for state in feature.edges.values() if state is not EdgeState.SUBRECT]
        closed += sum(state is EdgeState.CLOSED for state in edges) / len(edges)
    return len(found) / len(wanted), closed / len(wanted)
