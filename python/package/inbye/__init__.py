"""Exact local planning and navigation for inspection robots.

Units are metres, seconds and radians. Axes are those of REP-103: x forward, y left, yaw
counter-clockwise. A pose is ``(x, y, yaw)``, a velocity ``(vx, vtheta)``. Every function that
takes a ``config`` accepts a :class:`Config`, a dictionary with the keys of a configuration file,
or the text of such a file.
"""

from collections.abc import Sequence

from inbye import bench, planner_arena
from inbye._native import (
    Config,
    ControllerInput,
    Decision,
    Drive,
    Engine,
    InbyeError,
    Localizer,
    Map,
    Navigator,
    NavigatorDecision,
    PoseEstimate,
    Problem,
    World,
    __version__,
    plan,
    replay,
)

__all__ = [
    "Config",
    "ControllerInput",
    "Decision",
    "Drive",
    "Engine",
    "InbyeError",
    "Localizer",
    "Map",
    "Navigator",
    "NavigatorDecision",
    "PoseEstimate",
    "Problem",
    "World",
    "__version__",
    "bench",
    "evaluate",
    "evaluate_batch",
    "plan",
    "planner_arena",
    "replay",
]

_cpu = Engine("cpu")


def evaluate(problem: Problem, *, engine: Engine | None = None, samples: bool = False) -> Decision:
    """Take one decision, on one thread of the CPU unless an engine is given.

    With ``samples`` the decision has every sample.
    """
    return _chosen(engine).evaluate(problem, samples=samples)


def evaluate_batch(
    problems: Sequence[Problem], *, engine: Engine | None = None, samples: bool = False
) -> list[Decision]:
    """Take the decisions of many robots; the bits are those of :func:`evaluate`."""
    return _chosen(engine).evaluate_batch(problems, samples=samples)


def _chosen(engine: object) -> Engine:
    """Return the given engine, or one thread of the CPU."""
    if engine is None:
        return _cpu
    if not isinstance(engine, Engine):
        raise TypeError(
            f"engine: an Engine is expected, such as inbye.Engine('cpu'), not {engine!r}"
        )
    return engine
