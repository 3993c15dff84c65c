"""One picture of a whole mission: what was driven on the true floor, beside what the robot believes it has driven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw

from regionslam_env.rendering.layers import draw_path, draw_regions, draw_robot, draw_world
from regionslam_env.rendering.legend import SIGNS, draw_legend, legend_height
from regionslam_env.rendering.palette import BELIEF, FAINT, FLOOR, INK, MUTED, PAPER, TRUTH, UNSEEN, Colour, font
from regionslam_env.rendering.panel import Panel, Viewport
from regionslam_env.rendering.renderer import Snapshot
from regionslam_env.rendering.shapes import shapes_of_world
from regionslam_env.worlds.world import World

MARGIN = 20
HEADER = 58
TITLE = 30
CAPTION = 44
MARK = 11
"""Radius of a numbered mark, px."""

MISSION_SIGNS = tuple(sign for sign in SIGNS if sign[0] in ("goal", "edge seen", "edge still open", "paler: less sure"))


@dataclass(frozen=True, eq=False)
class Stop:
    """Where an instruction was done.

    Parameters
    ----------
    label
        The instruction in words.
    true_pose, pose
        True pose in the world frame and believed pose in the map frame, shape (3,).
    """

    label: str
    true_pose: ArrayLike
    pose: ArrayLike


def draw_mission(
    world: World, start: ArrayLike, end: Snapshot, stops: Sequence[Stop], width: int = 1600, robot_radius: float = 0.2
) -> Image.Image:
    """Return the picture of a mission.

    Parameters
    ----------
    world
        The true floor.
    start
        Pose (x, y, theta) of the map frame in the world frame, m and rad.
    end
        The last moment, with the paths of the whole mission.
    stops
        In the order of the mission; both sides show their numbers.
    width
        px; the height follows from the floor's shape.
    robot_radius
        m.
    """
    x0, y0, x1, y1 = world.bounds
    inner = (width - 3 * MARGIN) // 2
    height = 24 + (inner - 24) * (y1 - y0) / max(x1 - x0, 1e-6)
    size = (inner, round(min(max(height, 0.35 * inner), 1.2 * inner)))
    view = Viewport.fit(world.bounds, size, 12)

    truth, shapes = Panel(size, FLOOR), shapes_of_world(world)
    draw_world(truth, view, world, shapes, end.goal)
    draw_path(truth, view, end.true_path, TRUTH, 3.0)
    _draw_marks(truth, view, TRUTH, end.true_path, end.true_pose, [stop.true_pose for stop in stops], robot_radius)

    belief, map_view = Panel(size, UNSEEN), view.seen_from(start)
    draw_regions(belief, map_view, end.shapes, end.goal, 1.8)
    draw_path(belief, map_view, end.path, BELIEF, 3.0)
    _draw_marks(belief, map_view, BELIEF, end.path, end.pose, [stop.pose for stop in stops], robot_radius)

    types = tuple(dict.fromkeys(shape.type for shape in shapes))
    signs = MISSION_SIGNS if end.goal is not None else MISSION_SIGNS[1:]
    caption_y = HEADER + TITLE + size[1]
    foot = legend_height(width - 2 * MARGIN, types, signs)
    picture = Image.new("RGB", (width, caption_y + CAPTION + foot + MARGIN // 2), PAPER)
    draw = ImageDraw.Draw(picture)
    draw.text((MARGIN, HEADER // 2), end.title, INK, font(28, end.title), anchor="lm")
    numbers = f"{end.seconds:.0f} s    {end.driven:.0f} m driven"
    draw.text((width - MARGIN, HEADER // 2), numbers, MUTED, font(18), anchor="rm")
    columns = (
        (MARGIN, truth, "What is there", "the robot never sees this", TRUTH),
        (2 * MARGIN + inner, belief, "What the robot believes", "from noisy, partial measurements", BELIEF),
    )
    for x, panel, title, explanation, colour in columns:
        draw.text((x, HEADER + TITLE // 2 - 3), title, colour, font(20), anchor="lm")
        left = x + font(20).getlength(title) + 12
        draw.text((left, HEADER + TITLE // 2 - 2), explanation, MUTED, font(15), anchor="lm")
        picture.paste(panel.finish(), (x, HEADER + TITLE))
        draw.rectangle((x, HEADER + TITLE, x + inner - 1, HEADER + TITLE + size[1] - 1), outline=FAINT)
    done = "    ".join(f"{k}  {stop.label}" for k, stop in enumerate(stops, 1))
    draw.text((MARGIN, caption_y + CAPTION // 2), done, INK, font(18, done), anchor="lm")
    draw.text((width - MARGIN, caption_y + CAPTION // 2), end.caption, INK, font(18, end.caption), anchor="rm")
    draw_legend(picture, MARGIN, caption_y + CAPTION, width - 2 * MARGIN, types, signs)
    return picture


def _draw_marks(
    panel: Panel,
    view: Viewport,
    colour: Colour,
    path: ArrayLike,
    pose: ArrayLike,
    stops: Sequence[ArrayLike],
    robot_radius: float,
) -> None:
    """Draw where the path began, the numbers of the stops, and the robot where it ended unless that is a stop."""
    points = np.asarray(path, dtype=np.float64)
    starts = view.pixels(points[:1, :2]) if len(points) else []
    for start in starts:
        panel.disc(start, MARK - 3, colour)
        panel.disc(start, MARK - 6, PAPER)
        panel.keep_clear(start, MARK - 3)
    for number, stop in enumerate(stops, 1):
        (x, y), *_ = view.pixels(np.asarray(stop, dtype=np.float64)[None, :2])
        panel.disc((x, y), MARK + 1.5, PAPER)
        panel.disc((x, y), MARK, colour)
        panel.keep_clear((x, y), MARK)
        panel.text(x, y, str(number), PAPER, 15)
    if not stops or np.hypot(*(np.asarray(stops[-1])[:2] - np.asarray(pose)[:2])) > 2 * robot_radius:
        draw_robot(panel, view, pose, robot_radius, colour, MARK)
    for start in starts:  # last, when all other texts have come to lie where they stay
        panel.text_beside(start, MARK - 2, "start", colour, 15, halo=PAPER)
