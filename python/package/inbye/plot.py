"""Pictures with Matplotlib, which the extra ``inbye[plot]`` installs."""

# Matplotlib's types say little.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from inbye._native import Decision, Drive, Map, Problem

__all__ = ["decision", "map", "trace"]

# Most sampled paths of a picture: more cannot be distinguished.
_MOST_PATHS = 400
# The engines round positions: a sample of the same problem ends at most this far away.
_SAME_END_M = 0.05


def _axes(axes: Axes | None) -> Axes:
    axes = axes or plt.figure(layout="constrained").add_subplot()
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    return axes


def map(world: Map, *, axes: Axes | None = None) -> Axes:  # noqa: A001
    """Draw a map: walls black, unknown cells grey, closed zones red, speed limits orange."""
    axes = _axes(axes)
    cells = world.cells.astype(np.float64)
    x, y, yaw = world.origin
    corners = np.meshgrid(
        np.arange(cells.shape[1] + 1) * world.resolution_m,
        np.arange(cells.shape[0] + 1) * world.resolution_m,
    )
    sine, cosine = np.sin(yaw), np.cos(yaw)
    across = x + cosine * corners[0] - sine * corners[1]
    along = y + sine * corners[0] + cosine * corners[1]
    darkness = np.where(cells < 0, 30.0, cells)
    axes.pcolormesh(across, along, darkness, cmap="Greys", vmin=0.0, vmax=130.0, rasterized=True)
    if world.zones is not None:
        # The lower a limit is, the redder is its zone; a closed one has the limit zero.
        limits = np.where(world.zones == 100, 0, world.zones)
        shown = np.ma.masked_where(world.zones == 0, limits)
        axes.pcolormesh(
            across, along, shown, cmap="autumn", vmin=0.0, vmax=130.0, alpha=0.4, rasterized=True
        )
    return axes


def decision(
    problem: Problem, answer: Decision, world: Map | None = None, *, axes: Axes | None = None
) -> Axes:
    """Draw the sampled paths of a decision, coloured by score, grey if rejected, and the best one.

    The decision must have its samples: ``inbye.evaluate(problem, samples=True)``.
    """
    samples = answer.samples
    if samples is None:
        raise ValueError("the decision has no samples: evaluate with samples=True")
    if len(samples) != len(problem):
        raise ValueError(
            f"the decision has {len(samples)} samples and the problem {len(problem)}: "
            "give the decision of this problem"
        )
    shown = range(0, len(samples), -(-len(samples) // _MOST_PATHS))
    paths = [problem.path(index) for index in shown]
    ends = np.array([path[-1] for path in paths])
    away_m = np.abs(ends - np.column_stack([samples["x"], samples["y"]])[shown]).max()
    if away_m > _SAME_END_M:
        raise ValueError("the samples end elsewhere: give the decision of this problem")
    axes = _axes(axes) if world is None else map(world, axes=axes)
    scores = np.array([samples["score"][index] for index in shown])
    admissible = np.isfinite(scores)
    rejected = [path for path, is_good in zip(paths, admissible, strict=True) if not is_good]
    good = [path for path, is_good in zip(paths, admissible, strict=True) if is_good]
    axes.add_collection(LineCollection(rejected, colors="0.75", linewidths=0.6))
    lines = LineCollection(good, cmap="viridis", linewidths=0.9)
    lines.set_array(scores[admissible])
    axes.add_collection(lines)
    if good:
        axes.figure.colorbar(lines, ax=axes, label="score")
    if answer.index is not None:
        axes.plot(*problem.path(answer.index).T, color="tab:red", linewidth=2.0, label="best")
        axes.legend()
    axes.autoscale_view()
    return axes


def trace(drive: Drive, world: Map | None = None, *, axes: Axes | None = None) -> Axes:
    """Draw the path of a drive, coloured by speed, over its global paths."""
    axes = _axes(axes) if world is None else map(world, axes=axes)
    for number, path in enumerate(drive.paths):
        label = "global paths" if number == 0 else None
        axes.plot(*path.T, color="tab:blue", linestyle=":", linewidth=1.0, label=label)
    rows = drive.trace
    places = np.column_stack([rows["x"], rows["y"]])
    lines = LineCollection(list(np.stack([places[:-1], places[1:]], 1)), cmap="plasma")
    lines.set_array(rows["vx"][1:])
    axes.add_collection(lines)
    axes.figure.colorbar(lines, ax=axes, label="speed, m/s")
    axes.legend()
    axes.autoscale_view()
    return axes
