"""A picture of a believed map alone: regions shaded by type, links, the path and the pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw

from regionslam_env.rendering.layers import draw_ellipse, draw_links, draw_path, draw_regions, draw_robot, draw_world
from regionslam_env.rendering.legend import SIGNS, NamedSign, draw_legend, legend_height
from regionslam_env.rendering.palette import BELIEF, FAINT, FLOOR, INK, MUTED, PAPER, UNSEEN, font
from regionslam_env.rendering.panel import Panel, Viewport
from regionslam_env.rendering.shapes import Shape, main_direction, shapes_of_world
from regionslam_env.worlds.world import World
from slam.rows import Floats

MARGIN = 16
HEADER = 50
MAP_SIGNS = tuple(sign for sign in SIGNS if sign[0] not in ("lidar", "true path"))


def draw_map(
    shapes: Sequence[Shape],
    pose: ArrayLike | None = None,
    covariance: Floats | None = None,
    path: ArrayLike = (),
    goal: str | None = None,
    title: str = "Believed map",
    width: int = 1280,
    robot_radius: float = 0.2,
) -> Image.Image:
    """Return a picture of believed regions, turned so that most walls run along its sides.

    Parameters
    ----------
    shapes
        Regions in the map frame (`shapes_of_map`).
    pose, covariance, path
        Believed pose, its covariance and the path so far in the map frame, shapes (3,), (3, 3) and (k, 2 or more).
    goal
        Semantic type to highlight.
    """
    inner = width - 2 * MARGIN
    points = [s.row.outline() for s in shapes]
    if len(np.asarray(path)):
        points.append(np.asarray(path, dtype=np.float64)[:, :2])
    frame, (x0, y0, x1, y1) = _upright(
        np.concatenate(points) if points else np.array([[-5.0, -3.0], [5.0, 3.0]]), main_direction(shapes)
    )
    panel = Panel((inner, _height(inner, x1 - x0, y1 - y0)), UNSEEN)
    view = Viewport.fit((x0, y0, x1, y1), panel.size, 20).seen_from(frame)
    draw_regions(panel, view, shapes, goal, edge=1.8)
    draw_links(panel, view, shapes)
    draw_path(panel, view, path, BELIEF)
    if pose is not None:
        draw_robot(panel, view, pose, robot_radius, BELIEF, 7.0)
        if covariance is not None:
            draw_ellipse(panel, view, pose, covariance)
    return _compose(panel, view.scale, shapes, title)


def draw_truth(world: World, goal: str | None = None, width: int = 1280) -> Image.Image:
    """Return a picture of a true floor: regions shaded by type, walls, doors, furniture and links.

    Parameters
    ----------
    goal
        Semantic type to highlight.
    """
    inner = width - 2 * MARGIN
    x0, y0, x1, y1 = world.bounds
    panel = Panel((inner, _height(inner, x1 - x0, y1 - y0)), FLOOR)
    shapes = shapes_of_world(world)
    draw_world(panel, Viewport.fit(world.bounds, panel.size, 20), world, shapes, goal)
    signs = tuple(sign for sign in SIGNS if sign[0] == "goal" and goal is not None)
    return _compose(panel, Viewport.fit(world.bounds, panel.size, 20).scale, shapes, world.name, signs)


def _height(width: int, extent_x: float, extent_y: float) -> int:
    """Return the height (px) of a panel of a width (px) that shows a part of the world (m)."""
    return round(min(max(40 + width * extent_y / max(extent_x, 1e-6), 0.25 * width), 1.1 * width))


def _compose(
    panel: Panel, scale: float, shapes: Sequence[Shape], title: str, signs: Sequence[NamedSign] = MAP_SIGNS
) -> Image.Image:
    """Add title, scale and legend."""
    types = tuple(sorted({shape.type for shape in shapes}))
    inner = panel.size[0]
    top = HEADER + panel.size[1] + 10
    picture = Image.new("RGB", (inner + 2 * MARGIN, top + legend_height(inner, types, signs) + 4), PAPER)
    picture.paste(panel.finish(), (MARGIN, HEADER))
    draw = ImageDraw.Draw(picture)
    draw.rectangle((MARGIN, HEADER, MARGIN + inner - 1, HEADER + panel.size[1] - 1), outline=FAINT)
    draw.text((MARGIN, HEADER // 2), title, INK, font(22, title), anchor="lm")
    metres = next((m for m in (1, 2, 5, 10, 20, 50) if m * scale > 60), 100)
    right = MARGIN + inner
    draw.line((right - metres * scale, HEADER - 14, right, HEADER - 14), MUTED, 2)
    for x in (right - metres * scale, right):
        draw.line((x, HEADER - 18, x, HEADER - 10), MUTED, 2)
    draw.text((right - metres * scale / 2, HEADER - 26), f"{metres} m", MUTED, font(13), anchor="mm")
    draw_legend(picture, MARGIN, top, inner, types, signs)
    return picture


def _upright(points: Floats, direction: float) -> tuple[Floats, tuple[float, float, float, float]]:
    """Return the map frame as a pose in a frame in which the points are wider than high, and their bounds there."""
    for turn in (-direction, np.pi / 2 - direction):
        frame = np.array([0.0, 0.0, turn])
        corners = np.array(Viewport(np.eye(2), np.zeros(2), 1.0).seen_from(frame).pixels(points))
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        if x1 - x0 >= y1 - y0:
            break
    return frame, (float(x0), float(y0), float(x1), float(y1))
