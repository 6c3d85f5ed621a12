"""A database of runs for Planner Arena, the page that compares benchmarks of planners.

The tables are those of OMPL's benchmark databases: an experiment for each world, a planner
configuration for each planner, and a run for each drive.
"""

from __future__ import annotations

import math
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from inbye import _native

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Mapping

__all__ = ["write"]

# Columns of rows that become measured values of a run.
_MEASURED = (
    "time_s",
    "travelled_m",
    "min_clearance_m",
    "time_weighted_success",
    "path_weighted_success",
    "speed_change_m_s2",
    "jerk_rms_m_s3",
    "control_effort_m_s2",
    "drive_work_j_per_kg",
    "angle_per_m",
    "curvature_per_m",
    "omega_sign_changes_per_m",
    "off_path_rms_m",
    "near_share",
    "tick_p50_ms",
    "tick_p99_ms",
    "score",
)
# Columns of rows that distinguish planners.
_NAMING = ("kind", "config", "weights", "vx_samples", "vtheta_samples", "engine")
# The numbers of the outcomes are those of the enum that the database describes.
_OUTCOMES = ("reached", "contact", "timeout", "failed", "error")

_TABLES = """
CREATE TABLE experiments (id INTEGER PRIMARY KEY AUTOINCREMENT, name VARCHAR(512),
    totaltime REAL, timelimit REAL, memorylimit REAL, runcount INTEGER, version VARCHAR(128),
    hostname VARCHAR(1024), cpuinfo TEXT, date DATETIME, seed INTEGER, setup TEXT);
CREATE TABLE plannerConfigs (id INTEGER PRIMARY KEY AUTOINCREMENT,
    name VARCHAR(512) NOT NULL, settings TEXT);
CREATE TABLE enums (name VARCHAR(512), value INTEGER, description TEXT,
    PRIMARY KEY (name, value));
CREATE TABLE runs (id INTEGER PRIMARY KEY AUTOINCREMENT, experimentid INTEGER,
    plannerid INTEGER, {columns}, solved BOOLEAN, status ENUM,
    FOREIGN KEY (experimentid) REFERENCES experiments(id) ON DELETE CASCADE,
    FOREIGN KEY (plannerid) REFERENCES plannerConfigs(id) ON DELETE CASCADE);
CREATE TABLE progress (runid INTEGER, time REAL, PRIMARY KEY (runid, time),
    FOREIGN KEY (runid) REFERENCES runs(id) ON DELETE CASCADE);
"""


def write(
    rows: Iterable[Mapping[str, Any]], path: str | os.PathLike[str], *, date: str = ""
) -> None:
    """Write rows of experiments, as :func:`inbye.bench.run` returns them, into a new database.

    ``date`` goes into the table of experiments; there is no clock here, so that the same rows give
    the same file.
    """
    rows = list(rows)
    if not rows:
        raise ValueError("there are no rows to write")
    if Path(path).exists():
        raise FileExistsError(f"{path} is there already: remove it, or give another name")
    try:
        _write(rows, path, date)
    except BaseException:
        # Half a database looks like a whole one.
        Path(path).unlink(missing_ok=True)
        raise


def _write(rows: list[Mapping[str, Any]], path: str | os.PathLike[str], date: str) -> None:
    # The name that Planner Arena shows for the time of a run.
    columns = ["time" if name == "time_s" else name for name in _MEASURED]
    with closing(sqlite3.connect(path)) as database, database:
        kinds = ", ".join(f'"{name}" REAL' for name in columns)
        database.executescript(_TABLES.format(columns=kinds))
        outcomes = [("status", value, name) for value, name in enumerate(_OUTCOMES)]
        database.executemany("INSERT INTO enums VALUES (?, ?, ?)", outcomes)
        worlds = _numbers(f"{row['kind']} {row['world']}" for row in rows)
        names = _planner_names(rows)
        planners = _numbers(names)
        for world, number in worlds.items():
            mine = [row for row in rows if f"{row['kind']} {row['world']}" == world]
            total_s, seed = sum(row["time_s"] for row in mine), mine[0]["seed"]
            database.execute(
                "INSERT INTO experiments VALUES (?, ?, ?, 0, 0, ?, 'inbye', '', '', ?, ?, '')",
                (number, world, total_s, len(mine), date, seed),
            )
        for planner, number in planners.items():
            database.execute("INSERT INTO plannerConfigs VALUES (?, ?, '')", (number, planner))
        places = ", ".join("?" * (len(columns) + 4))
        quoted = ", ".join(f'"{name}"' for name in columns)
        for row, planner in zip(rows, names, strict=True):
            world = f"{row['kind']} {row['world']}"
            measured = [_value(row, name) for name in _MEASURED]
            status = _OUTCOMES.index(row["outcome"])
            database.execute(
                f"INSERT INTO runs (experimentid, plannerid, {quoted}, solved, status) "
                f"VALUES ({places})",
                [worlds[world], planners[planner], *measured, row["outcome"] == "reached", status],
            )


def _planner_names(rows: list[Mapping[str, Any]]) -> list[str]:
    """Return the name of each row's planner, as the ranking has it."""
    return _native.planner_names(
        [{key: row[key] for key in _NAMING if _value(row, key) is not None} for row in rows]
    )


def _value(row: Mapping[str, Any], name: str) -> object:
    """Return a figure of a row, or None where it has none: a table of pandas has NaN there."""
    value = row.get(name)
    return None if isinstance(value, float) and math.isnan(value) else value


def _numbers(names: Iterable[str]) -> dict[str, int]:
    """Return a number for each name, in the order of their first occurrence."""
    numbers: dict[str, int] = {}
    for name in names:
        numbers.setdefault(name, len(numbers) + 1)
    return numbers
