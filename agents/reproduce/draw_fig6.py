"""Draws Fig. 6: the path on the floor, a detail of the region map, the errors over time, and the paper's statements."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.accuracy import institute
from agents.reproduce.fig6 import AT_THE_END, BELOW, Course, comparison, course_length, median_course
from agents.reproduce.style import BELIEF, FAINT, INK, MUTED, TRUTH, colour, new_figure, plain_axes, save
from regionslam_env.rendering.palette import type_colour
from slam.evaluation.matching import moved
from slam.region import RegionFeature
from slam.rows import Floats, Row
from slam.se2 import compose

DETAIL = (5.7, -0.4, 24.3, 12.6)
"""Part of the floor whose map is shown: x0, y0, x1, y1, m."""

LETTER = 0.25
"""Width of a letter on the map, m: what is too narrow in the detail for its name stays without."""

STRIP = 6.0
"""Height of the strip below the floor for legend and enlargement, m."""

AVERAGED = 20
"""Scans over which the heading error is averaged for the eye."""

FURNITURE = ("desk", "cupboard", "table")


def draw_fig6(courses: Sequence[Course], result: dict[str, Any], path: Path) -> None:
    """Draw all runs into a PNG; path and map are those of the run with the median largest error."""
    shown = median_course(courses)
    figure = new_figure(15, 8.6)
    grid = figure.add_gridspec(
        2, 2, width_ratios=(1.5, 1), height_ratios=(1.3, 1), left=0.035, right=0.985, bottom=0.07, top=0.9, wspace=0.13
    )
    figure.suptitle(
        f"Region-based FastSLAM 2.0 with {result['n_particles']} particles, unknown correspondence (Fig. 6 of "
        "Oberländer et al. 2008, with our data)",
        x=0.035,
        ha="left",
        color=INK,
        fontsize=15,
    )
    _draw_path(figure.add_subplot(grid[0, 0]), shown)
    _draw_map(figure.add_subplot(grid[0, 1]), shown)
    _draw_table(figure.add_subplot(grid[1, 0]), comparison(result, course_length(shown)))
    errors = grid[1, 1].subgridspec(2, 1, hspace=0.12)
    position = figure.add_subplot(errors[0])
    _draw_errors(position, figure.add_subplot(errors[1], sharex=position), courses, shown)
    save(figure, path)


def _draw_path(axes: Any, course: Course) -> None:
    """Draw the true and the estimated path on the floor, and enlarge where they are farthest apart."""
    world, poses = institute()
    true, estimated = poses[1:], compose(poses[0], course.tour.estimated)
    _draw_floor(axes)
    worst = int(np.argmax(course.position_errors))
    detail = axes.inset_axes((0.85, 0.015, 0.14, 0.18))
    for target, width in ((axes, 1.2), (detail, 1.8)):
        target.plot(*true[:, :2].T, color=TRUTH, linewidth=width, label="true path")
        target.plot(*estimated[:, :2].T, color=BELIEF, linewidth=width, linestyle=(0, (4, 1.5)), label="estimated path")
    axes.plot(*true[0, :2], "o", color=INK, markersize=5)
    axes.annotate("start", true[0, :2], (5, 5), textcoords="offset points", fontsize=9, color=INK)
    middle = (true[worst, :2] + estimated[worst, :2]) / 2
    detail.plot(*np.array([true[worst, :2], estimated[worst, :2]]).T, color=INK, linewidth=1)
    error = course.position_errors[worst]
    half = max(0.4, 0.8 * error)
    detail.set_xlim(middle[0] - 1.4 * half, middle[0] + 1.4 * half)
    detail.set_ylim(middle[1] - half, middle[1] + half)
    plain_axes(detail)
    note = {"transform": axes.transAxes, "fontsize": 9, "ha": "right", "va": "center", "color": INK}
    axes.text(0.84, 0.1, f"farthest apart: {error:.2f} m", **note)
    axes.indicate_inset_zoom(detail, edgecolor=INK)
    x0, y0, x1, y1 = world.bounds
    axes.set_xlim(x0 - 0.5, x1 + 0.5)
    axes.set_ylim(y0 - STRIP, y1 + 0.5)
    plain_axes(axes)
    axes.set_title(
        f"Path of the median run (seed {course.seed}) on a floor of {x1 - x0:.0f} × {y1 - y0:.0f} m",
        fontsize=11,
        loc="left",
        color=INK,
    )
    axes.legend(loc="lower left", fontsize=9, ncols=2, framealpha=0.9)


def _draw_floor(axes: Any) -> None:
    """Draw walls and rooms of the truth, faintly."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Polygon

    world, _ = institute()
    for region in world.regions:
        if region.type == "hallway":
            axes.add_patch(Polygon(region.row.outline(), facecolor="#f3f1ea", edgecolor="none"))
    axes.add_collection(LineCollection(world.arrays.walls.reshape(-1, 2, 2), colors=[MUTED], linewidths=0.9))


def _draw_map(axes: Any, course: Course) -> None:
    """Draw a detail of the believed map in the frame of the truth: types, subregions, adjacency."""
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch, Polygon

    world, poses = institute()
    x0, y0, x1, y1 = DETAIL
    rows = {feature.id: moved(feature.row, poses[0]) for feature in course.tour.map.regions}
    inside = [f for f in course.tour.map.regions if _touches(rows[f.id], DETAIL)]
    for feature in sorted(inside, key=lambda f: -rows[f.id].area):
        axes.add_patch(
            Polygon(rows[feature.id].outline(), facecolor=colour(type_colour(feature.type)), edgecolor=INK, lw=0.8)
        )
    axes.add_collection(
        LineCollection(world.arrays.walls.reshape(-1, 2, 2), colors=[TRUTH], linewidths=0.8, linestyles="dotted")
    )
    shown = {feature.id for feature in inside}
    _draw_relations(axes, course, rows, shown)
    for feature in inside:
        if feature.type != "door" and feature.type not in FURNITURE:
            _name(axes, feature, rows[feature.id])
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)
    plain_axes(axes)
    axes.set_title("Detail of the region map that it made", fontsize=11, loc="left", color=INK)
    types = [t for t in ("door", *FURNITURE) if any(f.type == t for f in inside)]
    handles = [Patch(facecolor=colour(type_colour(t)), edgecolor=INK, label=t) for t in types]
    handles += [
        Line2D([], [], color=MUTED, label="adjacent"),
        Line2D([], [], color=INK, linestyle="dashed", label="subregion of"),
        Line2D([], [], color=TRUTH, linestyle="dotted", label="true walls"),
    ]
    axes.legend(
        handles=handles,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        ncols=len(handles),
        fontsize=8,
        frameon=False,
        columnspacing=1.0,
        handlelength=1.5,
    )


def _draw_relations(axes: Any, course: Course, rows: dict[int, Row], shown: set[int]) -> None:
    """Draw grey arrows between adjacent regions and dashed ones from a subregion to the region around it."""
    region_map = course.tour.map
    for edge in region_map.graph().edges:
        if edge.source not in shown or edge.target not in shown:
            continue
        a, b = _inner_point(rows[edge.source]), _inner_point(rows[edge.target])
        if edge.kind == "adjacent":
            # The arrow of a door ends beside it, not far along a hallway.
            if rows[edge.source].area < rows[edge.target].area:
                b = _nearest_inside(rows[edge.target], a)
            else:
                a = _nearest_inside(rows[edge.source], b)
            style: dict[str, Any] = {"arrowstyle": "<|-|>", "color": MUTED, "lw": 1.3}
        else:
            a, b = b, a
            style = {"arrowstyle": "-|>", "color": INK, "lw": 1.1, "linestyle": (0, (3, 2))}
        arrow = axes.annotate("", b, a, arrowprops={**style, "mutation_scale": 8, "shrinkA": 0, "shrinkB": 0})
        arrow.arrow_patch.set_clip_path(axes.patch)


def _name(axes: Any, feature: RegionFeature, row: Row) -> None:
    x0, y0, x1, y1 = DETAIL
    x, y = _inner_point(row)
    width, height = np.ptp(row.rectangles()[row.main].clip((x0, y0), (x1, y1)), axis=0)
    if width > LETTER * len(feature.type) and height > 4 * LETTER:
        axes.text(x, y - 0.25, feature.type, fontsize=8, ha="center", va="top", color=INK, clip_on=True)


def _draw_errors(position: Any, heading: Any, courses: Sequence[Course], shown: Course) -> None:
    """Draw position and heading error of all runs over time, the shown one bold."""
    for course in courses:
        bold = course is shown
        style = {"color": BELIEF if bold else FAINT, "linewidth": 1.6 if bold else 0.5, "zorder": 3 if bold else 1}
        position.plot(course.position_errors, **style)
        averaged = np.sqrt(np.convolve(course.heading_errors**2, np.full(AVERAGED, 1 / AVERAGED), "valid"))
        heading.plot(np.arange(len(averaged)) + AVERAGED / 2, np.degrees(averaged), **style)
    steps = len(shown.position_errors)
    position.axhline(BELOW, color=INK, linestyle="dashed", linewidth=1)
    position.text(steps * 0.01, BELOW, "paper: below 1 m at all times", fontsize=8, va="bottom", color=INK)
    position.plot([steps], [AT_THE_END], marker="<", color=INK, markersize=7, clip_on=False, zorder=4)
    position.annotate(
        "paper: about\n10 cm at the end",
        (steps, AT_THE_END),
        (steps * 0.985, 0.58),
        fontsize=8,
        ha="right",
        color=INK,
        arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.7},
    )
    position.set_ylim(0, max(1.15, 1.05 * max(course.position_errors.max() for course in courses)))
    position.set_ylabel("position error (m)", fontsize=9)
    heading.set_ylabel(f"heading error (°)\n(RMS of {AVERAGED} scans)", fontsize=9)
    heading.set_ylim(bottom=0)
    heading.set_xlabel("time (scans)", fontsize=9)
    heading.set_xlim(0, steps)
    position.tick_params(labelbottom=False, labelsize=8)
    heading.tick_params(labelsize=8)
    others = f"; thin: all {len(courses)} runs" if len(courses) > 1 else ""
    position.set_title(f"Errors over time (bold: the run shown{others})", fontsize=11, loc="left", color=INK)


def _draw_table(axes: Any, rows: list[tuple[str, str, str]]) -> None:
    """Draw what the paper says beside what we measure."""
    axes.set_axis_off()
    table = axes.table(
        cellText=rows,
        colLabels=("", "the paper says", "we measure"),
        colWidths=(0.28, 0.24, 0.48),
        cellLoc="left",
        colLoc="left",
        loc="upper left",
        edges="horizontal",
    )
    table.auto_set_font_size(False)
    table.set_fontsize(10)
    table.scale(1, 1.75)
    for (row, column), cell in table.get_celld().items():
        cell.set_edgecolor(FAINT)
        cell.set_text_props(color=MUTED if column == 0 else INK, weight="bold" if row == 0 else "normal")


def _touches(row: Row, box: tuple[float, float, float, float]) -> bool:
    x, y = row.outline().T
    return bool(x.max() > box[0] and x.min() < box[2] and y.max() > box[1] and y.min() < box[3])


def _inner_point(row: Row) -> Floats:
    """Return the middle of the part of a row's main rectangle that is in the detail, shape (2,)."""
    x0, y0, x1, y1 = DETAIL
    corners = row.rectangles()[row.main].reshape(-1, 2).clip((x0, y0), (x1, y1))
    return np.asarray((corners.min(axis=0) + corners.max(axis=0)) / 2)


def _nearest_inside(row: Row, point: Floats) -> Floats:
    """Return the point of a row's main rectangle, half a metre inside it, that is nearest to a point."""
    local = row.to_local([point])[0]
    i = row.main
    low, high = np.array([row.u[i], row.b[i]]), np.array([row.u[i + 1], row.t[i]])
    margin = np.minimum(0.8, (high - low) / 2)
    return np.asarray(row.to_world([local.clip(low + margin, high - margin)])[0])
