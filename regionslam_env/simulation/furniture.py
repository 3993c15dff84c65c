"""Furniture that can be pushed: which obstacles of a world belong together, and where each piece stands now."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from regionslam_env.worlds.world import Region, World
from slam.rows import Row

Floats = NDArray[np.float64]

PLAY = 0.01
"""What a piece lacks on every side in the engine, m: what stands flush with it leaves it room to move, and only what
reaches farther into it holds it for good."""


@dataclass(frozen=True, eq=False)
class Piece:
    """One piece of furniture.

    Parameters
    ----------
    region
        Index of its region in `World.regions`.
    obstacles
        Indices in `World.obstacles` of what it consists of.
    centre
        Its centre of area, m: what it turns about.
    polygons
        Its obstacles about the centre, each of shape (k, 2), m.
    """

    region: int
    obstacles: tuple[int, ...]
    centre: tuple[float, float]
    polygons: tuple[Floats, ...]

    @cached_property
    def solids(self) -> tuple[Floats, ...]:
        """The polygons less `PLAY`."""
        inner = [shapely.Polygon(polygon).buffer(-PLAY, join_style="mitre") for polygon in self.polygons]
        return tuple(
            polygon if part.is_empty else shapely.get_coordinates(part.exterior)[:-1]
            for polygon, part in zip(self.polygons, inner, strict=True)
        )

    @cached_property
    def reach(self) -> float:
        """Distance of its farthest corner from the centre, m."""
        return max(float(np.hypot(*polygon.T).max()) for polygon in self.polygons)


def pieces_of(world: World) -> tuple[Piece, ...]:
    """Return the furniture of a world: obstacles in a region with a parent, unless they reach into something else."""
    shapes = [shapely.Polygon(obstacle) for obstacle in world.obstacles]
    inner = [shape.buffer(-PLAY) for shape in shapes]
    owners = _owners(world, shapes)
    tree = shapely.STRtree([*shapes, *map(shapely.LineString, world.walls.reshape(-1, 2, 2))])
    pieces = []
    for region in sorted(set(owners) - {-1}):
        own = tuple(k for k, owner in enumerate(owners) if owner == region)
        touched = {int(k) for part in own for k in tree.query(inner[part], predicate="intersects")}
        if touched <= set(own):
            middle = shapely.union_all([shapes[k] for k in own]).centroid
            about = tuple(world.obstacles[k] - (middle.x, middle.y) for k in own)
            pieces.append(Piece(region, own, (middle.x, middle.y), about))
    return tuple(pieces)


def _owners(world: World, shapes: list[shapely.Polygon]) -> list[int]:
    """Return for each obstacle the smallest region with a parent that contains its middle, -1 where there is none."""
    owners, areas = [-1] * len(shapes), [math.inf] * len(shapes)
    middles = np.array([(shape.centroid.x, shape.centroid.y) for shape in shapes]).reshape(-1, 2)
    for index, region in enumerate(world.regions):
        if region.parent is None or region.type == "door":
            continue
        for k in np.flatnonzero(region.row.contains(middles)):
            if region.row.area < areas[k]:
                owners[k], areas[k] = index, region.row.area
    return owners


def moved_row(row: Row, piece: Piece, pose: Floats) -> Row:
    """Return the row of a piece's region where the piece stands at a pose (x, y, theta): m, m, rad."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    dx, dy = row.x - piece.centre[0], row.y - piece.centre[1]
    return replace(row, x=pose[0] + c * dx - s * dy, y=pose[1] + s * dx + c * dy, phi=row.phi + pose[2])


def moved_polygons(piece: Piece, pose: Floats) -> list[Floats]:
    """Return the obstacles of a piece at a pose (x, y, theta), each of shape (k, 2), m."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    turn = np.array([[c, s], [-s, c]])
    return [polygon @ turn + pose[:2] for polygon in piece.polygons]


def without(world: World, pieces: tuple[Piece, ...]) -> World:
    """Return a world without some of its furniture."""
    gone = {world.regions[piece.region].id for piece in pieces}
    obstacles = {k for piece in pieces for k in piece.obstacles}

    def kept(region: Region) -> Region:
        return replace(region, parent=None) if region.parent in gone else region

    return replace(
        world,
        regions=tuple(kept(region) for region in world.regions if region.id not in gone),
        obstacles=tuple(o for k, o in enumerate(world.obstacles) if k not in obstacles),
        links=tuple(link for link in world.links if link.source not in gone and link.target not in gone),
    )
