"""Experiments: plans of worlds, settings and seeds, with controllers in Python.

A plan is the path of a TOML file, as for ``inbye sweep``, or a dictionary with the same keys.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from inbye import _native

if TYPE_CHECKING:
    import os

    from inbye._native import Controller, ControllerObject, PlanSource

    Controllers: TypeAlias = "Mapping[str, Controller | type[ControllerObject]]"

__all__ = ["Comparison", "compare", "rows_before", "run", "worlds"]


def worlds(plan: PlanSource | None = None, **group: Any) -> list[_native.World]:  # noqa: ANN401
    """Read the worlds of a plan, or those of one kind: ``worlds(kind="barn", path="barn")``."""
    if plan is not None and group:
        keys = ", ".join(group)
        raise _native.InbyeError(f"worlds: give a plan, or a kind with its keys, not both: {keys}")
    return _native.read_worlds({"worlds": [group]} if plan is None else plan)


def run(
    plan: PlanSource,
    controllers: Controllers | None = None,
    *,
    jobs: int = 1,
    on_exception: Literal["raise", "fail"] = "raise",
) -> list[dict[str, Any]]:
    """Run the cells of a plan, ``jobs`` (1 to 1024) at a time, and return the figures of each run.

    Each of ``controllers``, by its name, also drives every world and seed of the plan: a callable,
    an object with ``compute_velocity``, or a class of such objects, with one for each run. An
    object is reset before each run. Controllers drive with each world's own settings and the
    changes of the plan's ``config``: ``configs``, ``weights`` and ``sampling`` are not for them.

    An exception of a controller, and Ctrl-C, ends all runs: :func:`rows_before` returns the figures
    of the runs before it. With ``on_exception="fail"`` an exception of a controller ends its run
    only, which counts as a failure: its row has the exception as ``reason``.
    """
    return _native.run(plan, controllers, jobs=jobs, on_exception=on_exception)


def rows_before(error: BaseException) -> list[dict[str, Any]]:
    """Return the figures of the runs that had ended when :func:`run` or :func:`compare` raised.

    The list is empty if no run had ended, and for any other exception::

        try:
            rows = inbye.bench.run(plan, controllers)
        except RuntimeError as error:
            rows = inbye.bench.rows_before(error)
    """
    rows: list[dict[str, Any]] = getattr(error, "_inbye_rows", [])
    return rows


@dataclass(frozen=True)
class Comparison:
    """Planners that drove the same worlds with the same seeds."""

    ranked: list[dict[str, Any]]
    """A row for each planner, the best first; the difference to the best one is paired."""
    rows: list[dict[str, Any]]
    """A row for each run."""

    def __str__(self) -> str:
        """Return a line for each planner: its mean success weighted by time, and its difference.

        The interval of the difference to the best planner has 95 % confidence. Where it contains
        zero, the difference may be chance. With fewer than 6 worlds there is no interval.
        """

        def line(planner: dict[str, Any]) -> str:
            text = (
                f"{planner['rank']}. {planner['planner']}: {planner['time_weighted_success']:.3f}"
            )
            if planner["difference"] is None:
                return text
            low, high = planner["difference_low"], planner["difference_high"]
            difference = f"{planner['difference']:+.3f}"
            if low is None:
                return f"{text}, difference {difference}, too few worlds to tell"
            difference = f"{difference} ({low:+.3f} to {high:+.3f})"
            return f"{text}, {planner['verdict'].replace('_', ' ')} by {difference}"

        return "\n".join(line(planner) for planner in self.ranked)


def compare(
    plan: PlanSource,
    controllers: Controllers | None = None,
    *,
    jobs: int = 1,
    on_exception: Literal["raise", "fail"] = "raise",
    report: str | os.PathLike[str] | None = None,
) -> Comparison:
    """Run a plan as :func:`run` does and rank the planners.

    With ``report`` the page of the comparison and its tables are written into that folder, which is
    created before the first run. An exception has the rows of the runs before it, as that of
    :func:`run`.
    """
    ranked, rows = _native.compare(
        plan, controllers, jobs=jobs, on_exception=on_exception, report=report
    )
    return Comparison(ranked, rows)
