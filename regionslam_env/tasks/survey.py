"""How much of a floor is mapped: the believed map is compared with the truth from time to time."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

from regionslam_env.errors import ConfigError
from regionslam_env.tasks.start import Pose
from regionslam_env.tasks.task import Moment, TaskSettings
from regionslam_env.worlds.geodesic import Geodesic
from regionslam_env.worlds.reachability import largest_part
from regionslam_env.worlds.world import Region, World
from slam.belief import Belief
from slam.evaluation.matching import moved, one_to_one, overlapping_pairs
from slam.region import EdgeState
from slam.se2 import inverse

ASSESSED_EVERY = 2.0
"""How often the map is compared with the truth, s: what it has gained is paid then."""

OVERLAP, TOLERANCE = 0.5, 1.0
"""When a mapped region stands for a true one, m: as in `slam.evaluation.map_quality`."""

FOUND = 0.5
"""Least share of a true region's area that has to be on the map: a piece seen through a door is no room yet."""


class Gain(NamedTuple):
    """What one step has brought.

    Parameters
    ----------
    recall, edges
        Increase of the shares of regions mapped and of edges closed.
    success, false_arrival
        The survey ends with this step, well or with a wrong declaration.
    """

    recall: float
    edges: float
    success: bool
    false_arrival: bool


class Survey:
    """Judges how much is mapped of the regions that a robot can get into, furniture left out.

    Parameters
    ----------
    geodesic
        Of the world.
    settings
        Duration of a step, and whether the robot declares that it is done.
    map_share
        Share of these regions that has to be mapped.

    Attributes
    ----------
    reachable
        Indices of these regions: those of the largest connected part of the floor.
    wanted
        Their ids.
    shares
        Of the regions that are mapped, and of their edges that are closed, when it was last looked.

    Raises
    ------
    ConfigError
        For a world whose regions cannot be entered, or a share that is none.
    """

    def __init__(self, geodesic: Geodesic, settings: TaskSettings, map_share: float) -> None:
        number = isinstance(map_share, int | float) and not isinstance(map_share, bool)
        if not number or not 0 < map_share <= 1:
            raise ConfigError(f"map_share is {map_share!r}, expected a share above 0 and up to 1")
        self._world, self._settings, self._map_share = geodesic.world, settings, map_share
        self.reachable = largest_part(geodesic)
        if not self.reachable:
            raise ConfigError(f"world {self._world.name!r} has no region that the robot can be in")
        self.wanted = frozenset(self._world.regions[i].id for i in self.reachable)
        self._period = max(1, round(ASSESSED_EVERY / settings.step))
        self.begin()

    def begin(self) -> None:
        """Set off."""
        self._steps, self.shares = 0, (0.0, 0.0)

    def step(self, moment: Moment) -> Gain:
        """Judge a step: compare the map with the truth when due."""
        self._steps += 1
        before = self.shares
        if self._steps % self._period == 1 % self._period or moment.declared or moment.last:
            self.shares = shares(moment.believe(), moment.origin, self._world, self.wanted)
        if self._steps == 1:  # what was mapped earlier has been paid
            before = self.shares
        recall, edges = (now - then for now, then in zip(self.shares, before, strict=True))
        enough = self.shares[0] >= self._map_share - 1e-9
        success = enough and (moment.declared or not self._settings.declares)
        return Gain(recall, edges, success, moment.declared and not enough)


def shares(belief: Belief, origin: Pose, world: World, wanted: frozenset[str]) -> tuple[float, float]:
    """Return the shares of wanted regions on the believed map and of their edges that are closed, each in [0, 1].

    Mapped is a region for which one of the map stands, as in `slam.evaluation.map_quality`, with `FOUND` of its area at
    least. One that is not mapped has no closed edge; joints of rectangles are no edges.

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
    rooms, furniture = _rooms(world, origin)
    mapped = [feature for feature in belief.map.regions if feature.type not in furniture]
    rows = [feature.row for feature in mapped]
    pairs = one_to_one(overlapping_pairs(mapped, rows, rooms, OVERLAP, TOLERANCE), OVERLAP)
    found = [mapped[pair.mapped] for pair in pairs if pair.found >= FOUND and rooms[pair.true].id in wanted]
    closed = 0.0
    for feature in found:
        edges = [state for state in feature.edges.values() if state is not EdgeState.SUBRECT]
        closed += sum(state is EdgeState.CLOSED for state in edges) / len(edges)
    return len(found) / len(wanted), closed / len(wanted)


@lru_cache(maxsize=8)
def _rooms(world: World, origin: Pose) -> tuple[tuple[Region, ...], frozenset[str]]:
    """Return the rooms of a world in the map frame, and the types of what stands in them and could be taken for one."""
    rooms = [region for region in world.regions if region.parent is None]
    there = inverse(origin)
    moved_rooms = tuple(replace(region, row=moved(region.row, there)) for region in rooms)
    return moved_rooms, frozenset(world.types) - {region.type for region in rooms}
