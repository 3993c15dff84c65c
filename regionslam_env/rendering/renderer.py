"""The picture of one moment: the truth on the left, the belief on the right, whole floor above, close-up below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from regionslam_env.rendering.layers import (
    draw_ellipse,
    draw_lidar,
    draw_links,
    draw_path,
    draw_regions,
    draw_robot,
    draw_scene,
    draw_world,
)
from regionslam_env.rendering.legend import MOVING_SIGNS, SIGNS, draw_legend, legend_height
from regionslam_env.rendering.palette import (
    BELIEF,
    FAINT,
    FLOOR,
    INK,
    MUTED,
    PAPER,
    TRUTH,
    UNSEEN,
    Colour,
    font,
    picture_colours,
)
from regionslam_env.rendering.panel import Panel, Viewport
from regionslam_env.rendering.shapes import Shape, shapes_of_world
from regionslam_env.simulation.movers import Scene
from regionslam_env.worlds.world import World
from slam.rows import Floats

MARGIN = 14
HEADER = 44
TITLE = 24
CAPTION = 30


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Everything that one picture shows, as plain data.

    Parameters
    ----------
    true_pose
        x, y, theta in the world frame, m and rad.
    pose, covariance
        Believed pose in the map frame and its covariance, shapes (3,) and (3, 3).
    shapes
        Believed regions in the map frame.
    true_path, path
        Poses or positions so far, shapes (k, 2 or more), in the world frame and in the map frame.
    lidar
        Ranges, shape (n,), m.
    title
        The mission.
    caption
        One line at the bottom, e.g. the robot's own words.
    seconds, driven
        Time and distance since the start.
    now
        What of the mission is to be done now, where it has several parts.
    goal
        Semantic type to highlight.
    scene
        What moves in the world, where it is now.
    """

    true_pose: ArrayLike
    pose: ArrayLike
    covariance: Floats
    shapes: Sequence[Shape] = ()
    true_path: ArrayLike = ()
    path: ArrayLike = ()
    lidar: NDArray[np.floating] | None = None
    title: str = ""
    caption: str = ""
    seconds: float = 0.0
    driven: float = 0.0
    now: str = ""
    goal: str | None = None
    scene: Scene | None = None


class Renderer:
    """Draws truth and belief of one episode.

    Parameters
    ----------
    world
        The true floor without furniture that moves.
    start
        True start pose: where the map frame lies in the world, so that both sides show the same part of the floor.
    width
        Of the picture, px; its height follows from the floor's shape. Both are rounded up to even numbers, without
        which video codecs cannot halve the colours.
    robot_radius, lidar_range
        m.
    close_up
        Width of the part that the lower panels show, m.
    scene
        What moves in the world, at any time: the legend explains it.
    """

    def __init__(
        self,
        world: World,
        start: ArrayLike = (0.0, 0.0, 0.0),
        width: int = 1280,
        robot_radius: float = 0.2,
        lidar_range: float = 10.0,
        close_up: float = 18.0,
        scene: Scene | None = None,
    ) -> None:
        self.world = world
        self.start = np.asarray(start, dtype=np.float64)
        self.robot_radius, self.lidar_range = robot_radius, lidar_range
        width += width % 2
        panel_width = (width - 3 * MARGIN) // 2
        x0, y0, x1, y1 = world.bounds
        ideal = 20 + (panel_width - 20) * (y1 - y0) / max(x1 - x0, 1e-6)
        self.overview_size = (panel_width, round(min(max(ideal, 0.3 * panel_width), 0.75 * panel_width)))
        self.close_size = (panel_width, round(0.42 * panel_width))
        self.close_scale = panel_width / close_up
        self.overview = Viewport.fit(world.bounds, self.overview_size)
        self.shapes = shapes_of_world(world)
        self._floors: dict[str | None, Panel] = {}
        moving = () if scene is None else tuple(region.type for region in scene.furniture)
        self._legend_types = tuple(dict.fromkeys((*(s.type for s in self.shapes), *moving)))
        self._signs = SIGNS if scene is None else MOVING_SIGNS
        self.columns = (MARGIN, 2 * MARGIN + panel_width)
        self.rows = (HEADER + TITLE, HEADER + TITLE + self.overview_size[1] + MARGIN)
        self._caption_y = self.rows[1] + self.close_size[1]
        foot = legend_height(width - 2 * MARGIN, self._legend_types, self._signs)
        height = self._caption_y + CAPTION + foot + MARGIN // 2
        self.size = (width, height + height % 2)
        self._background = self._draw_background()

    @property
    def colours(self) -> list[Colour]:
        """Colours of its pictures, for the palette of a `GifWriter`."""
        return picture_colours(self._legend_types)

    def frame(self, snapshot: Snapshot) -> NDArray[np.uint8]:
        """Return the picture as an array of shape (height, width, 3)."""
        return np.asarray(self.picture(snapshot))

    def picture(self, snapshot: Snapshot) -> Image.Image:
        """Return the picture as a Pillow image."""
        picture = self._background.copy()
        panels = (
            (self._truth_overview(snapshot), self._belief_overview(snapshot)),
            (self._truth_close_up(snapshot), self._belief_close_up(snapshot)),
        )
        draw = ImageDraw.Draw(picture)
        for y, row in zip(self.rows, panels, strict=True):
            for x, panel in zip(self.columns, row, strict=True):
                picture.paste(panel.finish(), (x, y))
                draw.rectangle((x, y, x + panel.size[0] - 1, y + panel.size[1] - 1), outline=FAINT)
        draw.text((MARGIN, HEADER // 2 + 1), snapshot.title, INK, font(22, snapshot.title), anchor="lm")
        now = MARGIN + font(22, snapshot.title).getlength(snapshot.title) + 14
        draw.text((now, HEADER // 2 + 3), snapshot.now, MUTED, font(15, snapshot.now), anchor="lm")
        numbers = f"{snapshot.seconds:.1f} s    {snapshot.driven:.1f} m driven"
        draw.text((self.size[0] - MARGIN, HEADER // 2 + 1), numbers, MUTED, font(15), anchor="rm")
        draw.text(
            (MARGIN, self._caption_y + CAPTION // 2), snapshot.caption, INK, font(16, snapshot.caption), anchor="lm"
        )
        self._draw_errors(draw, snapshot)
        return picture

    def _draw_errors(self, draw: ImageDraw.ImageDraw, snapshot: Snapshot) -> None:
        believed = self._in_world(snapshot.pose)
        error = float(np.hypot(*(believed[:2] - np.asarray(snapshot.true_pose)[:2])))
        spread = float(np.sqrt(max(np.trace(np.asarray(snapshot.covariance)[:2, :2]), 0.0)))
        text = f"believed to within {100 * spread:.0f} cm, truly off by {100 * error:.0f} cm"
        draw.text((self.size[0] - MARGIN, HEADER + TITLE // 2), text, MUTED, font(13), anchor="rm")

    def _truth_overview(self, snapshot: Snapshot) -> Panel:
        panel = Panel(self.overview_size, self._floor(snapshot.goal))
        self._draw_true_robot(panel, self.overview, snapshot, dots=False, smallest=6.0)
        return panel

    def _floor(self, goal: str | None) -> Panel:
        """Return the true floor with this type highlighted; it is drawn once."""
        if goal not in self._floors:
            panel = self._floors[goal] = Panel(self.overview_size, FLOOR)
            draw_world(panel, self.overview, self.world, self.shapes, goal)
        return self._floors[goal]

    def _belief_overview(self, snapshot: Snapshot) -> Panel:
        panel = Panel(self.overview_size, UNSEEN)
        self._draw_belief(panel, self.overview, snapshot, edge=1.4, dots=False, smallest=6.0)
        return panel

    def _truth_close_up(self, snapshot: Snapshot) -> Panel:
        panel = Panel(self.close_size, FLOOR)
        view = self._close_view(np.asarray(snapshot.true_pose))
        draw_world(panel, view, self.world, self.shapes, snapshot.goal)
        self._draw_true_robot(panel, view, snapshot, dots=True, smallest=7.0)
        return panel

    def _belief_close_up(self, snapshot: Snapshot) -> Panel:
        panel = Panel(self.close_size, UNSEEN)
        view = self._close_view(self._in_world(snapshot.pose))
        self._draw_belief(panel, view, snapshot, edge=2.0, dots=True, smallest=7.0, links=True)
        return panel

    def _close_view(self, pose: Floats) -> Viewport:
        return Viewport.centred(float(pose[0]), float(pose[1]), self.close_scale, self.close_size)

    def _draw_true_robot(self, panel: Panel, view: Viewport, snapshot: Snapshot, dots: bool, smallest: float) -> None:
        if snapshot.scene is not None:
            draw_scene(panel, view, snapshot.scene, snapshot.goal, 0.75 * smallest)
        draw_path(panel, view, snapshot.true_path, TRUTH)
        if snapshot.lidar is not None:
            draw_lidar(panel, view, snapshot.true_pose, snapshot.lidar, self.lidar_range, dots)
        draw_robot(panel, view, snapshot.true_pose, self.robot_radius, TRUTH, smallest)

    def _draw_belief(
        self,
        panel: Panel,
        view: Viewport,
        snapshot: Snapshot,
        edge: float,
        dots: bool,
        smallest: float,
        links: bool = False,
    ) -> None:
        view = view.seen_from(self.start)
        draw_regions(panel, view, snapshot.shapes, snapshot.goal, edge)
        if links:
            draw_links(panel, view, snapshot.shapes)
        draw_path(panel, view, snapshot.path, BELIEF)
        if snapshot.lidar is not None:
            draw_lidar(panel, view, snapshot.pose, snapshot.lidar, self.lidar_range, dots)
        draw_robot(panel, view, snapshot.pose, self.robot_radius, BELIEF, smallest)
        draw_ellipse(panel, view, snapshot.pose, snapshot.covariance)

    def _in_world(self, pose: ArrayLike) -> Floats:
        """Return a pose of the map frame in the world frame."""
        x, y, theta = np.asarray(pose, dtype=np.float64)
        c, s = np.cos(self.start[2]), np.sin(self.start[2])
        return np.array([self.start[0] + c * x - s * y, self.start[1] + s * x + c * y, self.start[2] + theta])

    def _draw_background(self) -> Image.Image:
        """Draw what stays the same: titles and legend."""
        background = Image.new("RGB", self.size, PAPER)
        draw = ImageDraw.Draw(background)
        titles = (("Truth", "the robot never sees this", TRUTH), ("Belief", "all that the robot knows", BELIEF))
        for x, (title, explanation, colour) in zip(self.columns, titles, strict=True):
            y = HEADER + TITLE // 2
            draw.text((x, y), title, colour, font(17), anchor="lm")
            draw.text((x + font(17).getlength(title) + 10, y + 1), explanation, MUTED, font(13), anchor="lm")
        top = self._caption_y + CAPTION
        draw.line((MARGIN, top, self.size[0] - MARGIN, top), FAINT)
        draw_legend(background, MARGIN, top + 6, self.size[0] - 2 * MARGIN, self._legend_types, self._signs)
        return background
