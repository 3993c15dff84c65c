"""What the panels are made of: regions, walls, robot, lidar, paths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from regionslam_env.rendering.palette import (
    BELIEF,
    FLOOR,
    GOAL,
    INK,
    LIDAR,
    LIDAR_SHARE,
    LINK,
    PAPER,
    PERSON,
    SHUT,
    Colour,
    blend,
    text_width,
    type_colour,
)
from regionslam_env.rendering.panel import Panel, Viewport
from regionslam_env.rendering.shapes import Shape, shape_of
from regionslam_env.simulation.movers import Scene
from regionslam_env.worlds.world import World
from slam.rows import Floats

SMALL = frozenset({"door", "desk", "cupboard", "table", "bed", "sofa"})
"""Types that go without a label: their colour says it."""

MAX_PATH_POINTS = 400


def draw_regions(panel: Panel, view: Viewport, shapes: Sequence[Shape], goal: str | None, edge: float = 1.5) -> None:
    """Shade regions by type, large ones first; seen edges solid, open edges dashed, regions of the goal type outlined.

    Parameters
    ----------
    edge
        Line width of edges, px; 0 leaves them to the walls of the true world.
    """
    shapes = [shape for shape in shapes if _visible(panel, view, shape)]
    for shape in sorted(shapes, key=lambda s: -s.area):
        fill = _fill(shape)
        corners = view.pixels(shape.rectangles.reshape(-1, 2))
        for i in range(0, len(corners), 4):
            panel.polygon(corners[i : i + 4], fill)
        if shape.type == goal:
            outline = view.pixels(shape.row.outline())
            panel.line([*outline, outline[0], outline[1]], GOAL, max(edge, wall_width(view)) + 3.5)
        if edge > 0:
            _draw_edges(panel, view, shape, edge)
    for shape in shapes:
        if shape.type not in SMALL:
            _label(panel, view, shape, goal)


def wall_width(view: Viewport) -> float:
    """Return the width of true walls, px: 0.1 m as in the physics, but never too thin to see."""
    return max(1.6, 0.1 * view.scale)


def _draw_edges(panel: Panel, view: Viewport, shape: Shape, width: float) -> None:
    colour = blend(INK, type_colour(shape.type), 0.35 if shape.type in SMALL else 0.0)
    width = 0.6 * width if shape.type in SMALL else width
    segments, states = shape.edges
    ends = view.pixels(segments.reshape(-1, 2))
    for start, end, closed in zip(ends[::2], ends[1::2], states, strict=True):
        if closed:
            panel.line([start, end], colour, width)
        else:
            panel.dashes(start, end, blend(colour, PAPER, 0.25), max(1.0, 0.8 * width))


def _visible(panel: Panel, view: Viewport, shape: Shape) -> bool:
    """Return whether a circle around the region meets the panel."""
    x0, y0, x1, y1 = shape.extent
    x, y = view.pixels([((x0 + x1) / 2, (y0 + y1) / 2)])[0]
    reach = view.scale * (x1 - x0 + y1 - y0) / 2
    return -reach <= x <= panel.size[0] + reach and -reach <= y <= panel.size[1] + reach


def _label(panel: Panel, view: Viewport, shape: Shape, goal: str | None) -> None:
    """Write a region's name into the widest visible part of it, above furniture and links, if it fits."""
    corners = np.array(view.pixels(shape.rectangles.reshape(-1, 2))).reshape(-1, 4, 2)
    lows = np.maximum(corners.min(axis=1), 0)
    highs = np.minimum(corners.max(axis=1), panel.size)
    widest = int(np.argmax(highs[:, 0] - lows[:, 0]))
    (left, top), (right, bottom) = lows[widest], highs[widest]
    size = 11 if view.scale < 20 else 14
    while size > 9 and text_width(shape.label, size) > right - left - 4:
        size -= 1
    if text_width(shape.label, size) > right - left - 2 or size + 3 > bottom - top:
        return
    colour = blend(GOAL, INK, 0.5) if shape.type == goal else INK
    height = max(size + 5, min(bottom - top, 0.5 * (bottom - top)))
    panel.text(float(left + right) / 2, float(top + height / 2), shape.label, colour, size, halo=_fill(shape))


def _fill(shape: Shape) -> Colour:
    """Return the colour of a region: its type's, paler the less certain it is."""
    return blend(PAPER, type_colour(shape.type), 0.35 + 0.65 * shape.certainty)


def draw_links(panel: Panel, view: Viewport, shapes: Sequence[Shape]) -> None:
    """Draw adjacency as a line from the smaller region into the larger one, containment dashed to the parent."""
    shapes = [shape for shape in shapes if _visible(panel, view, shape)]
    by_id = {shape.id: shape for shape in shapes}
    drawn: set[frozenset[int | str]] = set()
    for shape in shapes:
        for other in shape.neighbours:
            pair = frozenset((shape.id, other))
            if other in by_id and pair not in drawn:
                drawn.add(pair)
                small, large = sorted((shape, by_id[other]), key=lambda s: s.area)
                here, there = view.pixels(np.array([small.centre, _nearest_inside(large, small.centre)]))
                panel.line([here, there], LINK, 1.4)
                panel.disc(here, 2.4, LINK)
                panel.disc(there, 2.4, LINK)
        if shape.parent in by_id:
            here, there = view.pixels([shape.centre, by_id[shape.parent].centre])
            panel.dashes(here, there, blend(LINK, PAPER, 0.2), 1.0)


def _nearest_inside(shape: Shape, point: tuple[float, float], depth: float = 0.7) -> Floats:
    """Return the point nearest to `point` that lies `depth` m (or to the middle) inside one of the rectangles."""
    row = shape.row
    u, v = row.to_local([point])[0]
    best = None
    for i in range(row.n):
        half_u, half_v = (row.u[i + 1] - row.u[i]) / 2, (row.t[i] - row.b[i]) / 2
        du, dv = min(depth, half_u), min(depth, half_v)
        candidate = (np.clip(u, row.u[i] + du, row.u[i + 1] - du), np.clip(v, row.b[i] + dv, row.t[i] - dv))
        distance = np.hypot(candidate[0] - u, candidate[1] - v)
        if best is None or distance < best[0]:
            best = distance, candidate
    assert best is not None
    return row.to_world([best[1]])[0]


def draw_world(panel: Panel, view: Viewport, world: World, shapes: Sequence[Shape], goal: str | None) -> None:
    """Draw the true floor: regions, furniture, walls."""
    draw_regions(panel, view, shapes, goal, edge=0.0)
    _draw_obstacles(panel, view, world.obstacles)
    thickness = wall_width(view)
    ends = view.pixels(world.walls.reshape(-1, 2))
    for a, b in zip(ends[::2], ends[1::2], strict=True):
        if not panel.shows(a, b):
            continue
        panel.line([a, b], INK, thickness)
        for end in (a, b):
            panel.disc(end, thickness / 2, INK)


def draw_scene(panel: Panel, view: Viewport, scene: Scene, goal: str | None, smallest: float) -> None:
    """Draw what moves: furniture where it stands now, closed doors, people at least `smallest` px in radius."""
    draw_regions(panel, view, [shape_of(region) for region in scene.furniture], goal, edge=0.0)
    _draw_obstacles(panel, view, scene.obstacles)
    for ends in scene.door_segments.reshape(-1, 2, 2):
        panel.line(view.pixels(ends), SHUT, 2 * wall_width(view))
    for pose in scene.people:
        draw_robot(panel, view, pose, scene.person_radius, PERSON, smallest)


def _draw_obstacles(panel: Panel, view: Viewport, obstacles: Sequence[Floats]) -> None:
    for obstacle in obstacles:
        corners = view.pixels(obstacle)
        panel.line([*corners, corners[0], corners[1]], blend(INK, FLOOR, 0.35), 1.0)


def draw_lidar(
    panel: Panel, view: Viewport, pose: ArrayLike, ranges: NDArray[np.floating], max_range: float, dots: bool = True
) -> None:
    """Draw what the lidar swept, shape (n,) ranges in m, the first beam straight back and then counter-clockwise."""
    angles = -np.pi + 2 * np.pi * np.arange(len(ranges)) / len(ranges)
    points = np.stack([np.cos(angles), np.sin(angles)], axis=1) * np.asarray(ranges)[:, None]
    pixels = view.seen_from(pose).pixels(points)
    panel.polygon(pixels, LIDAR, LIDAR_SHARE)
    if dots:
        panel.dots([p for p, distance in zip(pixels, ranges, strict=True) if distance < 0.999 * max_range], LIDAR)


def draw_path(panel: Panel, view: Viewport, path: ArrayLike, colour: Colour, width: float = 2.0) -> None:
    """Draw a path, shape (k, 2 or more) in m."""
    points = np.asarray(path, dtype=np.float64)
    if len(points) > MAX_PATH_POINTS:
        points = points[np.linspace(0, len(points) - 1, MAX_PATH_POINTS).round().astype(np.intp)]
    if len(points) > 1:
        panel.line(view.pixels(points[:, :2]), colour, width)


def draw_robot(panel: Panel, view: Viewport, pose: ArrayLike, radius: float, colour: Colour, smallest: float) -> None:
    """Draw the robot as a disc with a heading, to scale but never smaller than `smallest` px in radius."""
    size = max(radius, smallest / view.scale)
    local = view.seen_from(pose)
    centre = local.pixels([(0.0, 0.0)])[0]
    panel.keep_clear(centre, size * view.scale + 2)
    panel.disc(centre, size * view.scale + 1.5, PAPER)
    panel.disc(centre, size * view.scale, colour)
    nose = np.array([[0.78, 0.0], [-0.42, 0.55], [-0.15, 0.0], [-0.42, -0.55]]) * size
    panel.polygon(local.pixels(nose), PAPER)


def draw_ellipse(panel: Panel, view: Viewport, pose: ArrayLike, covariance: Floats, sigmas: float = 2.0) -> None:
    """Draw where the robot thinks it is: the ellipse of so many sigmas of the pose covariance, shape (3, 3)."""
    values, vectors = np.linalg.eigh(np.asarray(covariance, dtype=np.float64)[:2, :2])
    turn = np.linspace(0, 2 * np.pi, 37)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1) * np.sqrt(np.maximum(values, 0)) * sigmas
    points = view.pixels(circle @ vectors.T + np.asarray(pose, dtype=np.float64)[:2])
    panel.polygon(points, BELIEF, 0.22)
    panel.line(points, BELIEF, 1.2)
