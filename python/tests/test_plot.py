"""Pictures, as far as a program can judge them."""

from pathlib import Path

import inbye
import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

from inbye import plot


def world() -> inbye.Map:
    cells = np.zeros((60, 100), np.int8)
    cells[[0, -1]] = 100
    cells[20:40, 50:55] = 100
    cells[:10, -20:] = -1
    return inbye.Map(cells, 0.1, (1.0, 2.0, 0.3))


def test_decision_is_drawn_with_its_best_path(tmp_path: Path) -> None:
    settings = {"local": {"vx_samples": 8, "vtheta_samples": 32}}
    pose = (3.0, 5.5, 0.3)
    problem = inbye.Problem(world(), pose, (6.0, 6.0), velocity=(0.5, 0.0), config=settings)
    answer = inbye.evaluate(problem, samples=True)
    axes = plot.decision(problem, answer, world())
    (best,) = axes.get_lines()
    assert np.array_equal(np.array(best.get_data()).T, problem.path(answer.index))
    drawn = sum(
        len(lines.get_segments()) for lines in axes.collections if hasattr(lines, "get_segments")
    )
    assert drawn == len(problem)
    axes.figure.savefig(tmp_path / "decision.png")
    with pytest.raises(ValueError, match="samples=True"):
        plot.decision(problem, inbye.evaluate(problem))
    other = inbye.Problem(world(), pose, (6.0, 6.0), velocity=(0.5, 0.0))
    with pytest.raises(ValueError, match="256 samples and the problem"):
        plot.decision(other, answer)
    turned = inbye.Problem(world(), (3.0, 5.5, 0.9), (6.0, 6.0), config=settings)
    with pytest.raises(ValueError, match="the samples end elsewhere"):
        plot.decision(turned, answer)


def test_zones_of_a_map_are_drawn() -> None:
    mask = np.zeros((60, 100), np.int8)
    mask[10:20, 10:20] = 100
    zoned = world().with_zones(keepout=inbye.Map(mask, 0.1, (1.0, 2.0, 0.3)))
    assert len(plot.map(world()).collections) == 1
    _, zones = plot.map(zoned).collections
    assert np.ma.count(zones.get_array()) == 100


def test_trace_is_drawn_over_its_paths(tmp_path: Path) -> None:
    level = inbye.Map(world().cells, 0.1)
    drive = inbye.World(level, (1.0, 3.0, 0.0), (8.0, 4.0)).drive()
    assert drive.reached
    axes = plot.trace(drive, level)
    assert len(axes.get_lines()) == len(drive.paths)
    axes.figure.savefig(tmp_path / "trace.png")
