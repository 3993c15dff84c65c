"""From a drawn plan (room polygons and points where doors are) to a world. Every importer ends here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from regionslam_env.errors import WorldError, unknown
from regionslam_env.worlds.alignment import align
from regionslam_env.worlds.annotate import annotate, side_directions
from regionslam_env.worlds.floorplan import Opening, assemble
from regionslam_env.worlds.passages import fit_opening, jambs, straight_opening
from regionslam_env.worlds.refine import refine
from regionslam_env.worlds.world import Region, World
from slam.rows import MAX_RECTANGLES, Floats, Row

WELL = 0.95
"""IoU of rows that are left on the corners of their polygons."""

GAIN = 0.01
"""IoU that leaving the corners must bring."""

NEAR = 0.35
"""A room's walls stand on the edges of its row but where its polygon deviates by more than this, m."""

REACH = 6.0
"""Rooms farther than this (m) from a portal have no say in where its opening goes."""

OWN_HEADING = 0.03
"""IoU that a row of its own heading must gain over one parallel to the building."""


@dataclass(frozen=True, eq=False)
class Space:
    """A room as drawn: outline in metres."""

    id: str
    type: str
    name: str
    polygon: shapely.Polygon


@dataclass(frozen=True)
class Portal:
    """A door as drawn: a point (m) and the ids of the two spaces that it joins.

    `width` (m) and `direction` (rad, along the door) where they are known.
    """

    x: float
    y: float
    spaces: tuple[str, str]
    width: float | None = None
    direction: float | None = None


@dataclass(frozen=True)
class Layout:
    """Spaces and what became of them: their regions, and the outlines on which walls stand.

    `fits` are the IoU of space and region before edges were moved onto common walls.
    """

    name: str
    spaces: tuple[Space, ...]
    rooms: tuple[Region, ...]
    fits: tuple[float, ...]
    outlines: dict[str, Floats]

    def iou(self, i: int) -> float:
        """Return intersection over union of a space and its region."""
        shape = shapely.union_all(shapely.polygons(self.rooms[i].row.rectangles()))
        inside = shape.intersection(self.spaces[i].polygon).area
        return float(inside / (shape.area + self.spaces[i].polygon.area - inside))


def build(name: str, spaces: Sequence[Space], portals: Sequence[Portal], door_width: float = 0.9) -> World:
    """Return the world of a plan.

    Rooms become rows of at most three rectangles; edges of neighbours that lie close together are moved onto one line,
    on which the wall stands. A door is cut through both borders where they run side by side nearest to its point.

    Raises
    ------
    WorldError
        For a plan without spaces, or a door that names an unknown space.
    """
    layout = lay_out(name, spaces)
    openings, _ = place(layout, portals, door_width)
    return close(layout, openings)


def lay_out(name: str, spaces: Sequence[Space]) -> Layout:
    """Return the regions of a plan's spaces."""
    if not spaces:
        raise WorldError(f"plan {name!r}: no space with an outline, expected at least one")
    spaces = _without_overlaps(spaces)
    heading = building_heading(spaces)
    fitted = [_annotated(space.polygon, heading) for space in spaces]
    rows = [joined(row) for row in align([row for row, _ in fitted], heading)]
    rooms = tuple(Region(s.id, s.type, s.name, row) for s, row in zip(spaces, rows, strict=True))
    outlines = {s.id: wall_outline(row, s.polygon) for s, row in zip(spaces, rows, strict=True)}
    return Layout(name, tuple(spaces), rooms, tuple(iou for _, iou in fitted), outlines)


def close(layout: Layout, openings: Sequence[Opening], furniture: Sequence[Region] = (), level: str = "0") -> World:
    """Return the world of a layout: walls around every room but where the openings are."""
    extra = [segment for opening in openings for segment in jambs(opening)]
    return assemble(
        layout.name,
        layout.rooms,
        openings,
        furniture,
        borders=list(layout.outlines.values()),
        jambs=np.array(extra).reshape(-1, 4),
        level=level,
    )


def building_heading(spaces: Sequence[Space]) -> float:
    """Return the direction of most walls, modulo 90 degrees, rad."""
    rings = [shapely.get_coordinates(space.polygon.exterior) for space in spaces]
    sides = np.concatenate([np.diff(ring, axis=0) for ring in rings])
    lengths = np.hypot(sides[:, 0], sides[:, 1])
    turned = lengths * np.exp(4j * np.arctan2(sides[:, 1], sides[:, 0]))
    straight = [h for s in spaces for h in side_directions(s.polygon, most=1)]
    near = np.median(np.array(straight)) if straight else float(np.angle(turned.sum())) / 4
    return 0.0 if abs(near) < np.radians(1.0) else float(near)


def wall_outline(row: Row, polygon: shapely.Polygon) -> Floats:
    """Return where a room's walls stand: its row, corrected where the polygon deviates by more than `NEAR`, (k, 2)."""
    shape = shapely.Polygon(row.outline())
    beyond, missing = (_thick(a.difference(b)) for a, b in ((shape, polygon), (polygon, shape)))
    corrected = _largest(shape.difference(beyond).union(missing))
    outline = shapely.simplify(shapely.Polygon(corrected.exterior), 0.02)
    return np.asarray(shapely.get_coordinates(orient(outline).exterior)[:-1])


def _thick(shape: shapely.Geometry) -> shapely.Geometry:
    """Return the parts of a shape that are wider than `NEAR`."""
    return shape.buffer(-NEAR / 2, join_style="mitre").buffer(NEAR / 2 + 1e-3, join_style="mitre")


def joined(row: Row, tolerance: float = 0.1) -> Row:
    """Return a row whose neighbouring rectangles of equal bottom and top (m) are one."""
    u, b, t = list(row.u), list(row.b), list(row.t)
    i = 0
    while i + 1 < len(b):
        if abs(b[i] - b[i + 1]) < tolerance and abs(t[i] - t[i + 1]) < tolerance:
            longer = i if u[i + 1] - u[i] >= u[i + 2] - u[i + 1] else i + 1
            b[i : i + 2], t[i : i + 2] = [b[longer]], [t[longer]]
            del u[i + 1]
        else:
            i += 1
    if len(b) == row.n:
        return row
    main = 1 if len(b) == MAX_RECTANGLES else int(np.argmax(np.diff(u) * (np.array(t) - np.array(b))))
    return Row.from_parameters(**Row(row.x, row.y, row.phi, np.array(u), np.array(b), np.array(t), main).parameters())


def _annotated(polygon: shapely.Polygon, heading: float) -> tuple[Row, float]:
    """Return the row along the building, or along the room's own sides where that fits better, and its IoU.

    Where neither fits well, as with slanted walls, the lines leave the corners (`refine`).
    """
    row, iou = annotate(polygon, [heading])
    if iou < 1 - OWN_HEADING:
        own_row, own_iou = annotate(polygon)
        if own_iou > iou + OWN_HEADING:
            row, iou = own_row, own_iou
    if iou < WELL:
        for direction in (heading, *side_directions(polygon, most=2)):
            refined, better = refine(polygon, direction)
            if better > iou + GAIN:
                row, iou = refined, better
    return row, iou


def _without_overlaps(spaces: Sequence[Space]) -> list[Space]:
    """Take what a smaller space covers out of the larger one, where that leaves one piece without a hole."""
    polygons = [orient(_largest(shapely.make_valid(s.polygon))) for s in spaces]
    order = np.argsort([-p.area for p in polygons], kind="stable")
    for position, i in enumerate(order):
        for j in order[position + 1 :]:
            if polygons[i].intersection(polygons[j]).area < 0.05:
                continue
            rest = _largest(polygons[i].difference(polygons[j]))
            if not rest.is_empty and not rest.interiors and rest.area > 0.5 * polygons[i].area:
                polygons[i] = orient(rest)
    return [replace(s, polygon=p) for s, p in zip(spaces, polygons, strict=True)]


def _largest(shape: shapely.Geometry) -> shapely.Polygon:
    parts = [p for p in shapely.get_parts(shape) if isinstance(p, shapely.Polygon)]
    return max(parts, key=lambda p: p.area, default=shapely.Polygon())


def place(
    layout: Layout, portals: Sequence[Portal], width: float, first: int = 1
) -> tuple[list[Opening], list[Portal]]:
    """Return an opening for every portal that can have one, and the portals that cannot.

    Where the borders of its rooms do not run side by side, a portal of known direction is cut straight through them.
    Two of one pair of rooms within their width are the same. Openings are numbered from `first`.
    """
    openings: list[Opening] = []
    failed: list[Portal] = []
    rings = {key: shapely.LinearRing(outline) for key, outline in layout.outlines.items()}
    for portal in portals:
        for space in portal.spaces:
            if space not in rings:
                where = f"portal at ({portal.x:.2f}, {portal.y:.2f})"
                raise WorldError(f"plan {layout.name!r}: {where}: {unknown('space', space, rings)}")
        a, b = portal.spaces
        reach = shapely.box(portal.x - REACH, portal.y - REACH, portal.x + REACH, portal.y + REACH)
        others = [ring for key, ring in rings.items() if key not in portal.spaces and ring.intersects(reach)]
        number, pair, point = f"door {first + len(openings)}", (a, b), (portal.x, portal.y)
        outlines = (layout.outlines[a], layout.outlines[b])
        found = fit_opening(number, pair, outlines, point, others, portal.width or width)
        if found is None and portal.direction is not None:
            found = straight_opening(number, pair, outlines, point, portal.direction, others, portal.width or width)
        if found is None:
            failed.append(portal)
        elif not any(_same(found, other) for other in openings):
            openings.append(found)
    return openings, failed


def _same(first: Opening, second: Opening) -> bool:
    """Return whether two openings of one pair of rooms overlap."""
    if set(first.regions) != set(second.regions):
        return False
    gap = np.hypot(first.x0 + first.x1 - second.x0 - second.x1, first.y0 + first.y1 - second.y0 - second.y1) / 2
    return bool(gap < 1.2)
