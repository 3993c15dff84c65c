"""From rooms and openings to a world: shared borders become walls, openings become doors with regions and links."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from regionslam_env.worlds.walls import cut, merge_collinear
from regionslam_env.worlds.world import Door, Link, Region, World
from slam.rows import Floats, Row

DOOR_DEPTH = 0.2
"""Extent of a door region across its wall, m."""


@dataclass(frozen=True)
class Opening:
    """A gap in the wall between two regions, from (x0, y0) to (x1, y1), m.

    `depth` is the extent across the wall: more than `DOOR_DEPTH` where the regions' borders do not coincide. Where
    there is no door, two rooms merely stand open to each other.
    """

    id: str
    regions: tuple[str, ...]
    x0: float
    y0: float
    x1: float
    y1: float
    depth: float = DOOR_DEPTH
    name: str = "door"
    door: bool = True

    @property
    def row(self) -> Row:
        """Geometry of the door's region: as wide as the opening, straddling the wall."""
        width = float(np.hypot(self.x1 - self.x0, self.y1 - self.y0))
        phi = float(np.arctan2(self.y1 - self.y0, self.x1 - self.x0))
        return Row.from_parameters((self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2, width, self.depth, phi)


def assemble(
    name: str,
    rooms: Sequence[Region],
    openings: Sequence[Opening],
    furniture: Sequence[Region] = (),
    borders: Iterable[Floats] | None = None,
    jambs: Floats | None = None,
    level: str = "0",
    spawn: tuple[float, float, float] | None = None,
) -> World:
    """Build a world from rooms, the openings between them and furniture.

    Parameters
    ----------
    rooms
        Regions enclosed by walls.
    openings
        Gaps between two rooms; each becomes a `Door`, a region of type "door" and a link to each of its rooms, or just
        a link of its two rooms where it is no door.
    furniture
        Regions that are obstacles as well; `parent` names the room.
    borders
        Outlines (k, 2) to stand walls on; default: the outlines of the rooms.
    jambs
        Further walls (k, 4), which no opening cuts.
    """
    outlines = [room.row.outline() for room in rooms] if borders is None else borders
    sides = [_sides(ring) for ring in outlines]
    walls = merge_collinear(np.concatenate(sides) if sides else np.empty((0, 4)))
    by_id = {room.id: room for room in rooms}
    doors, door_regions, links = [], [], []
    for gap in openings:
        ends = (gap.x0, gap.y0, gap.x1, gap.y1)
        walls = cut(walls, ends, gap.depth + 2e-3)
        if not gap.door:
            links.append(link_through(gap, by_id[gap.regions[0]], by_id[gap.regions[1]]))
            continue
        doors.append(Door(gap.id, *ends, regions=gap.regions))
        region = Region(gap.id, "door", gap.name, gap.row)
        door_regions.append(region)
        for room_id in gap.regions:
            links.append(link_between(region, by_id[room_id]))
    if jambs is not None:
        walls = np.concatenate([walls, jambs])
    obstacles = tuple(corners for item in furniture for corners in item.row.rectangles())
    regions = (*rooms, *door_regions, *furniture)
    once = {(link.source, link.target): link for link in links}
    return World(name, regions, walls, tuple(doors), obstacles, tuple(once.values()), level, spawn)


def link_between(door: Region, room: Region) -> Link:
    """Return the link of a door and a room: the door's long edge that faces the room, the room's edge nearest to it."""
    row = door.row
    faces = row.to_world([[0.0, row.t[0]], [0.0, row.b[0]]])
    outside = row.to_world([[0.0, row.t[0] + DOOR_DEPTH], [0.0, row.b[0] - DOOR_DEPTH]])
    inside = room.row.contains(outside)
    if inside[0] != inside[1]:
        side = 0 if inside[0] else 1
    else:
        side = int(np.argmin([distance_to_edges(room.row, *point)[1] for point in faces]))
    return Link(door.id, room.id, "tb"[side], distance_to_edges(room.row, *faces[side])[0])


def link_through(gap: Opening, first: Region, second: Region) -> Link:
    """Return the link of two rooms that stand open to each other: of each the edge nearest to the gap's middle."""
    x, y = (gap.x0 + gap.x1) / 2, (gap.y0 + gap.y1) / 2
    edges = (distance_to_edges(room.row, x, y)[0] for room in (first, second))
    return Link(first.id, second.id, *edges)


def distance_to_edges(row: Row, x: float, y: float) -> tuple[str, float]:
    """Return the name (`EDGE_NAMES`) of the row's edge nearest to a point, and its distance, m.

    What sticks out of a rectangle at its joint with the next one counts as the main rectangle's edge "l" or "r".
    """
    along, across = row.to_local([[x, y]])[0]
    candidates: list[tuple[float, str]] = []
    for i in range(row.n):
        suffix = "" if i == row.main else "l" if i < row.main else "r"
        gap = max(row.u[i] - along, along - row.u[i + 1], 0.0)
        candidates.append((float(np.hypot(gap, across - row.t[i])), "t" + suffix))
        candidates.append((float(np.hypot(gap, across - row.b[i])), "b" + suffix))
    for k in range(row.n + 1):
        touching = [i for i in (k - 1, k) if 0 <= i < row.n]
        bottoms, tops = [row.b[i] for i in touching], [row.t[i] for i in touching]
        if len(touching) == 1:
            name = ("l" if row.main == 0 else "ll") if k == 0 else ("r" if row.main == row.n - 1 else "rr")
            spans = [(bottoms[0], tops[0])]
        else:
            name = "l" if k <= row.main else "r"
            spans = [(min(ends), max(ends)) for ends in (bottoms, tops) if min(ends) < max(ends)]
        for low, high in spans:
            gap = max(low - across, across - high, 0.0)
            candidates.append((float(np.hypot(gap, along - row.u[k])), name))
    distance, name = min(candidates, key=lambda candidate: round(candidate[0], 9))
    return name, distance


def _sides(ring: Floats) -> Floats:
    """Return the sides of a closed ring (k, 2) as segments (k, 4)."""
    return np.concatenate([ring, np.roll(ring, -1, axis=0)], axis=1)
