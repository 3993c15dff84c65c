"""One moment in plain English: mission, belief, what was just seen, and what is known, line by line."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from regionslam_env.missions.mission import Mission
from regionslam_env.observations import (
    LinkColumn,
    LinkKind,
    Observation,
    ProgressColumn,
    RegionColumn,
    link_table,
    region_table,
)
from slam.belief import Belief
from slam.edges import distance_to
from slam.measurement import Scan
from slam.region import EdgeState, RegionFeature
from slam.region_map import RegionMap

DIRECTIONS = ("ahead", "ahead left", "left", "behind left", "behind", "behind right", "right", "ahead right")
"""Eighths of a turn, counter-clockwise, each about its middle."""

NORMALS = {"r": 0.0, "t": math.pi / 2, "l": math.pi, "b": -math.pi / 2}
"""Where the edges of a rectangle face in its own frame, by the first letter of their names, rad."""

MOST_SEEN = 12
"""Sightings that are told, the nearest ones."""


@dataclass(frozen=True, eq=False)
class Situation:
    """What there is to tell of one moment.

    Parameters
    ----------
    mission
        What is to be done.
    observation
        The padded one.
    belief
        About pose and map.
    scan
        What the region sensor measured last.
    slot_ids
        Id of the region in each row of the observation.
    types
        Semantic types in the order of the observation's columns.
    max_steps
        Of the episode.
    """

    mission: Mission
    observation: Observation
    belief: Belief
    scan: Scan
    slot_ids: NDArray[np.int64]
    types: Sequence[str]
    max_steps: int

    def lines(self) -> Iterator[str]:
        """Yield the lines, the most important ones first; those of regions begin with the number of their slot."""
        belief, observation = self.belief, self.observation
        x, y, heading = belief.pose_mean.tolist()
        speed, turn_rate = observation["velocity"].tolist()
        elapsed, completed, declared = observation["progress"][: ProgressColumn.GO_TO].tolist()
        end = ", arrival declared" if declared else ""
        yield f"Mission: {self.mission}."
        if now := self.mission.now(completed):
            yield f"Now: {now}."
        yield f"Progress: {round(elapsed * self.max_steps)} of {self.max_steps} steps{end}."
        yield f"Place: {belief.map.describe(belief.pose_mean, probabilities=belief.where())}"
        yield f"Certainty: {certainty(belief)}"
        yield f"Pose: {_place(x, y)} from the start, where I looked ahead; I have turned {bearing(heading)} since."
        yield f"Motion: {speed:.1f} m/s forward, {_turn(turn_rate)}."
        yield f"Obstacles: {obstacles(observation['lidar'])}."
        yield f"Just seen: {seen(self.scan)}."
        yield from self._regions()

    def _regions(self) -> Iterator[str]:
        """Yield a headline, and a line for every mapped region: those of the goal's type first, then the nearest."""
        belief, known = self.belief, self.belief.map
        slots = [int(s) for s in np.flatnonzero(self.observation["regions_mask"]) if int(self.slot_ids[s]) in known]
        if not slots:
            yield "Known regions: none yet."
            return
        goals = {self.types[k] for k in np.flatnonzero(self.observation["goal"]).tolist()}
        x, y = belief.pose_mean[:2].tolist()
        distance = {slot: distance_to(known[int(self.slot_ids[slot])].row, (x, y)) for slot in slots}
        yield f"Known regions ({len(slots)}; number, name, where from me; the goal's type first, then the nearest):"
        links = self._links({slot: known.name(int(self.slot_ids[slot])) for slot in slots})
        for slot in sorted(slots, key=lambda s: (known[int(self.slot_ids[s])].type not in goals, distance[s])):
            yield self._region(slot, known[int(self.slot_ids[slot])], known, distance[slot], links.get(slot, []))

    def _region(self, slot: int, region: RegionFeature, known: RegionMap, distance: float, links: Sequence[str]) -> str:
        """Return the line of a region."""
        x, y, heading = self.belief.pose_mean.tolist()
        row = region_table(self.observation)[slot]
        inside = float(row[RegionColumn.CONTAINS_ME])
        centre = region.row.centre
        at = math.hypot(centre[0] - x, centre[1] - y)
        parts = [f"I am in it ({100 * inside:.0f} %)" if inside > 0.5 else f"{distance:.1f} m away"]
        parts.append(f"centre {at:.1f} m, {bearing(math.atan2(centre[1] - y, centre[0] - x) - heading)}")
        length, width = region.row.u[-1] - region.row.u[0], region.row.t.max() - region.row.b.min()
        parts.append(f"{length:.1f} x {width:.1f} m")
        parts.append("been there" if row[RegionColumn.VISITED] > 0.5 else "not been there")
        for doubt, column in (("exists", RegionColumn.EXISTENCE), ("of this type", RegionColumn.TYPE_P)):
            if row[column] < 0.95:
                parts.append(f"{doubt} with {100 * row[column]:.0f} %")
        unseen = [
            direction(region.row.phi + NORMALS[name[0]] - heading)
            for name, state in region.edges.items()
            if state is EdgeState.OPEN
        ]
        if unseen:
            parts.append(f"may go on {' and '.join(dict.fromkeys(unseen))}")
        return f"[{slot}] {known.name(region)}: {', '.join([*parts, *links])}."

    def _links(self, names: Mapping[int, str]) -> dict[int, list[str]]:
        """Return what is said about the links of every slot."""
        found: dict[int, list[str]] = {}
        for row in link_table(self.observation)[self.observation["links_mask"] > 0]:
            first, second = int(row[LinkColumn.FIRST]), int(row[LinkColumn.SECOND])
            if first in names and second in names:
                there, back = (
                    ("contains", "inside") if row[LinkColumn.KIND] == LinkKind.CONTAINMENT else ("leads to",) * 2
                )
                chance = f"({100 * row[LinkColumn.PROBABILITY]:.0f} %)"
                found.setdefault(first, []).append(f"{there} [{second}] {names[second]} {chance}")
                found.setdefault(second, []).append(f"{back} [{first}] {names[first]} {chance}")
        return found


def certainty(belief: Belief) -> str:
    """Return how sure the pose is: standard deviations of the position in its worst direction, and of the heading."""
    if belief.lost:
        return "I have lost track of where on my map I am."
    position = math.sqrt(max(0.0, float(np.linalg.eigvalsh(belief.pose_cov[:2, :2])[-1])))
    heading = math.degrees(math.sqrt(max(0.0, float(belief.pose_cov[2, 2]))))
    return f"I know my position to within {position:.2f} m and my heading to within {heading:.0f} degrees."


def obstacles(ranges: NDArray[Any]) -> str:
    """Return the distance of the nearest obstacle in every direction; rays begin straight back, counter-clockwise."""
    angles = -math.pi + 2 * math.pi * np.arange(len(ranges)) / len(ranges)
    sectors = np.round(angles / (math.pi / 4)).astype(np.int64) % 8
    told = [
        f"{name} {float(ranges[sectors == k].min()):.1f} m" for k, name in enumerate(DIRECTIONS) if (sectors == k).any()
    ]
    return ", ".join(told)


def seen(scan: Scan) -> str:
    """Return what was measured last, the nearest first."""
    x, y, kinds = (scan.records[name].tolist() for name in ("x", "y", "type"))
    nearest = sorted(range(len(scan)), key=lambda k: math.hypot(x[k], y[k]))[:MOST_SEEN]
    told = [
        f"{scan.types[kinds[k]]} {math.hypot(x[k], y[k]):.1f} m, {bearing(math.atan2(y[k], x[k]))}" for k in nearest
    ]
    return "; ".join(told) or "nothing"


def direction(angle: float) -> str:
    """Return the name of a direction from the robot's heading, rad."""
    return DIRECTIONS[round(angle / (math.pi / 4)) % 8]


def bearing(angle: float) -> str:
    """Return an angle in whole degrees and the side it is on."""
    degrees = round(math.degrees(math.remainder(angle, 2 * math.pi)))
    return f"{abs(degrees)} degrees {'left' if degrees > 0 else 'right'}" if degrees else "0 degrees"


def _place(x: float, y: float) -> str:
    return f"{abs(x):.1f} m {'ahead' if x >= 0 else 'back'} and {abs(y):.1f} m {'left' if y >= 0 else 'right'}"


def _turn(rate: float) -> str:
    degrees = round(math.degrees(rate))
    side = "left" if degrees > 0 else "right"
    return f"turning {side} at {abs(degrees)} degrees per second" if degrees else "not turning"
