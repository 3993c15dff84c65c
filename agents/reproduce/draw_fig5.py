"""The drawing of Fig. 5: the region with course and range above, error and stated uncertainty over time below."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from agents.reproduce.fig5 import PASSES, PLACE, POSITIONS, RANGE, Track, course
from agents.reproduce.style import MUTED, new_figure, save
from slam.config import GEOMETRIC_UPDATES

LOOKS = {"edges": ("edge form (default)", "#1f5fa8"), "paper": ("the paper's update", "#c8511b")}

LIMITS = 3e-5, 1e5
"""Range of the lower picture, m² and rad²."""


def draw_fig5(runs: Sequence[dict[str, Track]], path: Path) -> None:
    """Draw the experiment, and means over all seeds' runs over time, into an image file; needs matplotlib."""
    figure = new_figure(9.0, 8.4)
    figure.set_layout_engine("constrained")
    top, bottom = figure.subplots(2, 1, height_ratios=[2, 3])
    _draw_region(top)
    _draw_errors(bottom, runs)
    save(figure, path, dpi=150)


def _draw_region(axes: Any) -> None:
    """Draw the true region, the course, and what the sensor can reach from its start."""
    poses = course()
    outline = np.concatenate([PLACE.outline(), PLACE.outline()[:1]])
    axes.fill(*outline.T, color="#f1f1ee", zorder=0)
    axes.plot(*outline.T, color="black", lw=1.8, label=f"true region, {PLACE.u[-1] - PLACE.u[0]:.0f} m long")
    for i in range(1, PLACE.n):
        joint = max(PLACE.b[i - 1], PLACE.b[i]), min(PLACE.t[i - 1], PLACE.t[i])
        axes.plot([PLACE.u[i]] * 2, joint, color="black", lw=0.8, ls=":")
    x, y = poses[:POSITIONS, 0], poses[:POSITIONS, 1]
    axes.plot(x, y, color=MUTED, ls="--", lw=1.2, label=f"course, {PASSES} passes of {POSITIONS} positions")
    axes.plot(x[:1], y[:1], marker="o", color="black", ms=5, ls="", label="first position")
    angles = np.linspace(0, 2 * np.pi, 200)
    circle = x[0] + RANGE * np.cos(angles), y[0] + RANGE * np.sin(angles)
    axes.fill(*circle, color="#9a9a9a", alpha=0.25, lw=0, label=f"sensor range, {RANGE:.0f} m")
    for i, name in enumerate(("left subrectangle", "main rectangle", "right subrectangle")):
        place = (PLACE.u[i] + PLACE.u[i + 1]) / 2, PLACE.b[i]
        axes.annotate(name, place, (0, -13), textcoords="offset points", ha="center", fontsize=9, color=MUTED)
    axes.set(xlim=(-12, 12), ylim=(-5.3, 5.3), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.set_title("One region, never seen whole, measured in parts from known poses", fontsize=11)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=4, fontsize=9, frameon=False)


def _draw_errors(axes: Any, runs: Sequence[dict[str, Track]]) -> None:
    """Draw squared error and trace of the covariance over time, means over all seeds."""
    steps = np.arange(1, len(runs[0]["edges"].trace) + 1)
    for update in GEOMETRIC_UPDATES:
        name, color = LOOKS[update]
        error = np.mean([run[update].squared_error for run in runs], axis=0)
        trace = np.mean([run[update].trace for run in runs], axis=0)
        axes.plot(steps, error, color=color, lw=1.3, label=f"{name}: squared error")
        axes.plot(steps, trace, color=color, lw=1.6, ls="--", label=f"{name}: trace of its covariance")
    complete = float(np.mean([run["edges"].complete for run in runs])) + 1
    axes.axvline(complete, color=MUTED, lw=1.0, ls=":")
    note = f"all edges closed, t = {complete:.0f}\n(in the paper's own run: about 150)"
    axes.annotate(note, (complete, 30.0), (8, 0), textcoords="offset points", fontsize=9, color="#333333")
    note = "while an edge is open, the edge form knows a bound only:\nits variance is practically unlimited"
    axes.annotate(note, (1.1, 1.5e4), fontsize=9, color=LOOKS["edges"][1], va="top")
    seeds = f"mean of {len(runs)} seeds" if len(runs) > 1 else "one seed"
    axes.set(xscale="log", yscale="log", xlim=(1, len(steps)), ylim=LIMITS)
    axes.set(xlabel="number of measurements, t", ylabel="sum over all parameters of the region (m², rad²)")
    axes.set_title(f"An honest estimate's error (solid) follows what it claims (dashed): {seeds}", fontsize=11)
    axes.grid(True, which="major", color="#dddddd", lw=0.6)
    axes.legend(loc="lower left", fontsize=9, frameon=False)
