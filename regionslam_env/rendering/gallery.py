"""A picture of several worlds: a table of small floor plans with one legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from PIL import Image, ImageDraw

from regionslam_env.rendering.layers import draw_world
from regionslam_env.rendering.legend import draw_legend, legend_height
from regionslam_env.rendering.palette import FAINT, FLOOR, INK, MUTED, PAPER, font, picture_colours, reduced
from regionslam_env.rendering.panel import Panel, Viewport
from regionslam_env.rendering.shapes import shapes_of_world
from regionslam_env.worlds.world import World

MARGIN = 16
TITLE = 30


def draw_gallery(rows: Sequence[Sequence[World]], cell: tuple[int, int] = (420, 300)) -> Image.Image:
    """Return a picture of worlds in rows, in mode "P": a small file with the exact colours of the legend.

    Parameters
    ----------
    rows
        Worlds, row by row.
    cell
        Width and height of each plan, px.
    """
    width = MARGIN + max(len(row) for row in rows) * (cell[0] + MARGIN)
    top = len(rows) * (cell[1] + TITLE + 6) + MARGIN
    types = tuple(sorted({region.type for row in rows for world in row for region in world.regions}))
    picture = Image.new("RGB", (width, top + legend_height(width - 2 * MARGIN, types, ()) + 4), PAPER)
    draw = ImageDraw.Draw(picture)
    for i, row in enumerate(rows):
        for j, world in enumerate(row):
            x, y = MARGIN + j * (cell[0] + MARGIN), i * (cell[1] + TITLE + 6)
            panel = Panel(cell, FLOOR)
            # Without names: at this scale they would cover the rooms.
            shapes = [replace(shape, label="") for shape in shapes_of_world(world)]
            draw_world(panel, Viewport.fit(world.bounds, cell, 12), world, shapes, None)
            picture.paste(panel.finish(), (x, y + TITLE))
            draw.rectangle((x, y + TITLE, x + cell[0] - 1, y + TITLE + cell[1] - 1), outline=FAINT)
            x0, y0, x1, y1 = world.bounds
            draw.text((x, y + TITLE - 6), world.name, INK, font(16, world.name), anchor="ls")
            extent = f"{x1 - x0:.0f} x {y1 - y0:.0f} m"
            draw.text((x + cell[0], y + TITLE - 6), extent, MUTED, font(13), anchor="rs")
    draw_legend(picture, MARGIN, top, width - 2 * MARGIN, types, ())
    return reduced(picture, picture_colours(types))
