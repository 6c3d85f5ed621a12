"""Experiments with controllers in Python."""

import sqlite3
import subprocess
import sys
from contextlib import closing
from math import nan
from pathlib import Path
from types import MappingProxyType

import inbye
import numpy as np
import pytest
from inbye import planner_arena

PLAN = {
    "seeds": [0],
    "configs": {"inbye": {}, "slow": {"robot": {"limits": {"max_vel_x": 0.25}}}},
    "worlds": [{"kind": "scenes"}],
}


class Pursuit:
    """Follows a point of the path half a metre ahead; one object for each run."""

    runs = 0

    def __init__(self) -> None:
        Pursuit.runs += 1

    def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float]:
        x, y, yaw = seen.pose
        lengths = np.hypot(*np.diff(seen.path, axis=0).T).cumsum()
        ahead = min(np.searchsorted(lengths, seen.path_progress_m + 0.5) + 1, len(seen.path) - 1)
        to_x, to_y = seen.path[ahead] - (x, y)
        turn = np.arctan2(to_y, to_x) - yaw
        error = np.arctan2(np.sin(turn), np.cos(turn))
        return (0.3 if abs(error) < 0.5 else 0.0, float(error))


def test_comparison_ranks_planners_and_writes_its_page(tmp_path: Path) -> None:
    comparison = inbye.bench.compare(PLAN, {"pursuit": Pursuit}, jobs=2, report=tmp_path)
    assert {row["planner"] for row in comparison.ranked} == {"inbye", "slow", "pursuit"}
    assert len(comparison.rows) == 9
    assert [row["planner"] for row in comparison.rows[::3]] == ["inbye", "slow", "pursuit"]
    assert Pursuit.runs == 3
    assert [row["rank"] for row in comparison.ranked] == [1, 2, 3]
    assert "pursuit" in (tmp_path / "index.html").read_text()
    assert str(comparison).count("\n") == 2
    # The rows of the plan are those of a run without controllers.
    key = ("config", "world", "trace_digest")
    ours = [[row[name] for name in key] for row in inbye.bench.run(PLAN)]
    assert [[row[name] for name in key] for row in comparison.rows[:6]] == ours


def test_controller_drives_with_the_settings_of_the_world() -> None:
    def digests(configs: dict[str, object]) -> list[str]:
        plan = {"worlds": [{"kind": "scenes", "time_limit_s": 20.0}], "configs": configs}
        rows = inbye.bench.run(plan, {"mine": Pursuit})
        return [row["trace_digest"] for row in rows if row["config"] == "mine"]

    slow = {"robot": {"limits": {"max_vel_x": 0.1}}}
    own = digests({})
    assert len(own) == 3
    assert own == digests({"a": slow, "b": {}}) == digests({"a": {}, "b": slow})


def test_report_and_controllers_are_checked_before_the_first_run(tmp_path: Path) -> None:
    def controller(_: inbye.ControllerInput) -> None:
        raise AssertionError("a run began")

    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(inbye.InbyeError, match=r"^report .*file: cannot be a folder \("):
        inbye.bench.compare(PLAN, {"mine": controller}, report=file)

    class Broken:
        def __init__(self) -> None:
            raise KeyError("no model")

    for wrong, error in ((3, inbye.InbyeError), (object, inbye.InbyeError), (Broken, KeyError)):
        with pytest.raises(error):
            inbye.bench.run(PLAN, {"mine": controller, "wrong": wrong})
    plan = {"worlds": [{"kind": "scenes", "time_limit_s": 5.0}]}
    inbye.bench.compare(plan, {"first": Pursuit}, report=tmp_path / "new" / "folder")
    assert (tmp_path / "new" / "folder" / "index.html").exists()


def test_rows_before_an_exception_are_kept() -> None:
    class Late(Pursuit):
        """Raises in its second run."""

        made = 0

        def __init__(self) -> None:
            Late.made += 1
            self.number = Late.made

        def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float]:
            if self.number > 1:
                raise ZeroDivisionError
            return super().compute_velocity(seen)

    plan = {"worlds": [{"kind": "scenes", "time_limit_s": 5.0}]}
    whole = [row["trace_digest"] for row in inbye.bench.run(plan, {"first": Pursuit})]
    for function in (inbye.bench.run, inbye.bench.compare):
        Late.made = 0
        with pytest.raises(ZeroDivisionError) as error:
            function(plan, {"first": Pursuit, "late": Late})
        rows = inbye.bench.rows_before(error.value)
        assert [row["config"] for row in rows[3:]] == ["first", "first", "first", "late"]
        assert [row["trace_digest"] for row in rows[:6]] == whole
    assert inbye.bench.rows_before(ValueError("another one")) == []


def test_a_run_with_an_exception_can_count_as_a_failure() -> None:
    class Raising(Pursuit):
        """Raises in each method, in its second and third run."""

        made = 0

        def __init__(self) -> None:
            Raising.made += 1
            self.number = Raising.made

        def reset(self) -> None:
            if self.number > 2:
                raise LookupError("no model")

        def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float]:
            if self.number > 1:
                raise ZeroDivisionError("no speed")
            return super().compute_velocity(seen)

    class Leaving(Pursuit):
        def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float]:
            raise SystemExit(3)

    plan = {"worlds": [{"kind": "scenes", "time_limit_s": 5.0}]}
    controllers = {"raising": Raising, "last": Pursuit}
    found = inbye.bench.compare(plan, controllers, on_exception="fail")
    rows = [row for row in found.rows if row["config"] == "raising"]
    assert [row["outcome"] for row in rows] == ["timeout", "failed", "failed"]
    assert "no speed" in rows[1]["reason"]
    assert "no model" in rows[2]["reason"]
    assert [row["outcome"] for row in found.rows if row["config"] == "last"] == ["timeout"] * 3
    with pytest.raises(SystemExit):
        inbye.bench.run(plan, {"leaving": Leaving}, on_exception="fail")
    with pytest.raises(inbye.InbyeError, match=r"^on_exception is ignore: it must be"):
        inbye.bench.run(plan, controllers, on_exception="ignore")  # type: ignore[arg-type]


def test_page_of_another_program_is_not_replaced(tmp_path: Path) -> None:
    page = tmp_path / "index.html"
    page.write_text("<p>mine</p>")
    with pytest.raises(inbye.InbyeError, match=r"^report .*was not written by this command"):
        inbye.bench.compare(PLAN, report=tmp_path)
    assert page.read_text() == "<p>mine</p>"


@pytest.mark.parametrize(
    ("plan", "name", "message"),
    [
        (PLAN, "slow", "settings of the plan have the name slow too"),
        (PLAN | {"configs": {}}, "inbye", "settings of the plan have the name inbye too"),
        (PLAN, "", "a name is empty"),
        (PLAN, 3, "a name is empty or no text"),
    ],
)
def test_name_of_a_controller_is_its_own(
    plan: dict[str, object], name: object, message: str
) -> None:
    before = Pursuit.runs
    for function in (inbye.bench.run, inbye.bench.compare):
        with pytest.raises(inbye.InbyeError, match=message):
            function(plan, {name: Pursuit})
    assert Pursuit.runs == before


def test_plan_has_paths_scalars_of_numpy_and_any_mapping(tmp_path: Path) -> None:
    rows = ["#" * 20, *["#" + 18 * "." + "#"] * 8, "#" * 20]
    (tmp_path / "room.txt").write_text("\n".join(rows))
    route = {"start": np.array([1.6, 2.0, 0.0]), "goal": (np.float32(6.0), 2)}
    world = {"kind": "map", "path": tmp_path / "room.txt", "resolution_m": np.float64(0.4)}
    settings = MappingProxyType({"local": MappingProxyType({"vx_samples": np.int64(32)})})
    plan = {"worlds": [world | {"routes": [route]}], "configs": {"more": settings}}
    (row,) = inbye.bench.run(MappingProxyType(plan))
    assert (row["outcome"], row["config"], row["vx_samples"]) == ("reached", "more", 32)
    more = inbye.Config({"local": settings["local"]})
    (plain,) = inbye.bench.run(plan | {"configs": {"more": more}})
    assert plain["trace_digest"] == row["trace_digest"]
    with pytest.raises(inbye.InbyeError, match=r"worlds\.0\.path is missing"):
        inbye.bench.worlds({"worlds": [{"kind": "map", "path": None}]})
    endless: dict[str, object] = {}
    endless["local"] = endless
    with pytest.raises(inbye.InbyeError, match="more than 32 levels"):
        inbye.Config(endless)


def test_worlds_are_those_of_a_plan_or_of_a_kind() -> None:
    with pytest.raises(inbye.InbyeError, match=r"give a plan, or a kind .* not both: kind"):
        inbye.bench.worlds(PLAN, kind="scenes")


def test_plan_of_a_file_is_relative_to_it(tmp_path: Path) -> None:
    (tmp_path / "room.txt").write_text("\n".join(["#" * 20, *["#" + 18 * "." + "#"] * 8, "#" * 20]))
    plan = tmp_path / "plan.toml"
    plan.write_text(
        '[[worlds]]\nkind = "map"\npath = "room.txt"\nresolution_m = 0.4\n'
        "routes = [{ start = [1.6, 2.0, 0.0], goal = [6.0, 2.0] }]\n"
    )
    (row,) = inbye.bench.run(plan)
    assert row["outcome"] == "reached"
    (world,) = inbye.bench.worlds(plan)
    assert (world.kind, world.drive().digest) == ("map", row["trace_digest"])
    plan.write_text("seed = 3\n")
    with pytest.raises(inbye.InbyeError, match=r"plan\.toml.*did you mean `seeds`"):
        inbye.bench.run(plan)


def test_database_for_planner_arena_has_a_run_for_each_row(tmp_path: Path) -> None:
    rows = inbye.bench.run(PLAN)
    file = tmp_path / "arena.db"
    planner_arena.write(rows, file)
    with closing(sqlite3.connect(file)) as database:
        runs = database.execute(
            "SELECT p.name, e.name, r.time, r.solved, s.description FROM runs r "
            "JOIN plannerConfigs p ON p.id = r.plannerid "
            "JOIN experiments e ON e.id = r.experimentid "
            "JOIN enums s ON s.name = 'status' AND s.value = r.status ORDER BY r.id"
        ).fetchall()
        experiments = database.execute("SELECT name, runcount FROM experiments").fetchall()
        (progress,) = database.execute("SELECT count(*) FROM progress").fetchone()
    assert runs == [
        (
            row["config"],
            f"scenes {row['world']}",
            row["time_s"],
            row["outcome"] == "reached",
            row["outcome"],
        )
        for row in rows
    ]
    assert experiments == [(f"scenes {name}", 2) for name in ("roadway", "crossing", "dead_end")]
    assert progress == 0
    # A table of pandas has NaN where a row has no figure.
    filled = [{key: nan if value is None else value for key, value in row.items()} for row in rows]
    planner_arena.write(filled, tmp_path / "filled.db")
    assert (tmp_path / "filled.db").read_bytes() == file.read_bytes()
    with pytest.raises(FileExistsError):
        planner_arena.write(rows, file)
    with pytest.raises(ValueError, match="no rows"):
        planner_arena.write([], tmp_path / "empty.db")
    half = tmp_path / "half.db"
    with pytest.raises(ValueError, match="not in tuple"):
        planner_arena.write([*rows, rows[0] | {"outcome": "unknown"}], half)
    assert not half.exists()


def test_planner_arena_and_ranking_name_planners_alike(tmp_path: Path) -> None:
    plan = PLAN | {"configs": {"one": {}}, "weights": {"fast": {"velocity": 0.6}, "shy": {}}}
    comparison = inbye.bench.compare(plan)
    names = {row["planner"] for row in comparison.ranked}
    assert names == {"one, fast", "one, shy"}
    # Three worlds are too few.
    assert {row["verdict"] for row in comparison.ranked} == {"best", "too_few_worlds"}
    assert "too few worlds" in str(comparison)
    planner_arena.write(comparison.rows, tmp_path / "arena.db")
    with closing(sqlite3.connect(tmp_path / "arena.db")) as database:
        stored = {name for (name,) in database.execute("SELECT name FROM plannerConfigs")}
    assert stored == names


def test_each_name_of_equal_settings_has_its_rows() -> None:
    worlds = [{"kind": "scenes", "time_limit_s": 5.0}]
    configs = {"a": {}, "b": {}, "c": {"local": {"vx_samples": 32}}}
    comparison = inbye.bench.compare({"worlds": worlds, "configs": configs}, {"mine": Pursuit})
    assert {row["planner"] for row in comparison.ranked} == {"a", "b", "c", "mine"}
    # Equal settings are driven once.

    def results_of(name: str) -> list[tuple[str, str]]:
        rows = [row for row in comparison.rows if row["config"] == name]
        return [(row["key"], row["trace_digest"]) for row in rows]

    results = {name: results_of(name) for name in ("a", "b", "c", "mine")}
    assert [len(result) for result in results.values()] == [3, 3, 3, 3]
    assert results["a"] == results["b"] != results["c"]
    # A key names one result: those of a controller are not those of inbye or of another controller.
    others = inbye.bench.run({"worlds": worlds}, {"other": Pursuit, "mine": Pursuit})
    keys = {name: [key for key, _ in result] for name, result in results.items()}
    assert [row["key"] for row in others[:3]] == keys["a"]
    assert [row["key"] for row in others[6:]] == keys["mine"]
    assert len({row["key"] for row in others}) == 9


@pytest.mark.parametrize("jobs", [0, 1025])
def test_number_of_jobs_has_limits(jobs: int) -> None:
    for function in (inbye.bench.run, inbye.bench.compare):
        with pytest.raises(inbye.InbyeError, match=rf"^jobs is {jobs}: it must be 1 to 1024"):
            function(PLAN, jobs=jobs)


def test_package_has_planner_arena() -> None:
    program = "import inbye; inbye.planner_arena.write"
    subprocess.run([sys.executable, "-c", program], check=True)
