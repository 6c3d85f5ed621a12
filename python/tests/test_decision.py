"""Decisions: the same bits as the program's, and arrays that show them."""

import copy
import json
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import inbye
import numpy as np
import pytest

ROWS = [
    "################",
    "#..............#",
    "#......#.......#",
    "#..............#",
    "################",
]
CONFIG = {
    "robot": {
        "footprint": [{"x": 0.0, "y": 0.0, "radius": 0.3}],
        "limits": {"min_vel_x": 0.0, "max_vel_x": 1.0},
    },
    "local": {"vx_samples": 8, "vtheta_samples": 16},
}


def problem(**changes: object) -> inbye.Problem:
    world = inbye.Map.from_rows(ROWS, 0.5)
    inputs = {"velocity": (0.4, 0.0), "config": CONFIG} | changes
    return inbye.Problem(world, (1.0, 1.2, 0.0), (6.0, 1.2), **inputs)


def test_digest_is_that_of_the_program(tmp_path: Path) -> None:
    decision = inbye.evaluate(problem(), samples=True)
    settings = inbye.Config(CONFIG).to_dict()
    file = tmp_path / "problem.json"
    file.write_text(
        json.dumps(
            settings["local"]
            | {
                "map": {"rows": ROWS, "resolution_m": 0.5},
                "robot": {
                    "pose": [1.0, 1.2, 0.0],
                    "velocity": [0.4, 0.0],
                    "footprint": CONFIG["robot"]["footprint"],
                },
                "limits": settings["robot"]["limits"],
                "target": [6.0, 1.2],
            }
        )
    )
    command = [sys.executable, "-m", "inbye", "evaluate", "--problem", str(file), "--json"]
    run = subprocess.run([*command, "--engine", "cpu"], capture_output=True, check=True)
    said = json.loads(run.stdout)
    assert said["digest"] == decision.digest
    assert said["winner"]["index"] == decision.index
    assert (said["winner"]["vx"], said["winner"]["vtheta"]) == decision.command
    # A sample more is another digest: the comparison can fail.
    other = problem(config=CONFIG | {"local": {"vx_samples": 8, "vtheta_samples": 17}})
    assert inbye.evaluate(other, samples=True).digest != said["digest"]


def test_samples_are_a_structured_array() -> None:
    asked = problem()
    decision = inbye.evaluate(asked, samples=True)
    samples = decision.samples
    assert samples is not None
    assert len(samples) == len(asked)
    admissible = samples[samples["status"] == "ok"]
    assert len(admissible) == decision.admissible
    best = samples[decision.index]
    assert best["score"] == admissible["score"].max() == decision.score
    assert (best["vx"], best["vtheta"]) == decision.command
    path = asked.path(decision.index)
    assert path.shape[1] == 2
    assert np.abs(path[-1] - [best["x"], best["y"]]).max() < 0.02
    assert inbye.evaluate(asked).samples is None


def test_batch_equals_single_decisions_on_every_thread_count() -> None:
    obstacles = np.array([[3.0, 1.2, 0.2, -0.3, 0.0]])
    problems = [problem(velocity=(0.05 * step, 0.0), obstacles=obstacles) for step in range(8)]
    engine = inbye.Engine("cpu", threads=2)
    batch = inbye.evaluate_batch(problems, engine=engine, samples=True)
    single = [inbye.evaluate(one, samples=True) for one in problems]
    assert [one.digest for one in batch] == [one.digest for one in single]
    assert len({one.digest for one in single}) == 8


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"config": {"local": {"vx_sample": 8}}}, "did you mean `vx_samples`"),
        ({"config": {"local": {"vx_samples": 0}}}, "vx_samples"),
        ({"config": 3}, "settings are a Config"),
        ({"velocity": (float("nan"), 0.0)}, "finite"),
        ({"obstacles": np.zeros((1, 4))}, "five columns"),
        ({"obstacles": np.array([[0.0, 0.0, np.nan, 0.0, 0.0]])}, "obstacle"),
    ],
)
def test_bad_input_is_one_clear_error(changes: dict[str, object], message: str) -> None:
    with pytest.raises(inbye.InbyeError, match=message) as error:
        problem(**changes)
    assert "\n" not in str(error.value)


def test_arrays_have_any_real_type_or_are_lists() -> None:
    row = [[3.0, 1.25, 0.25, -0.5, 0.0]]
    digests = {
        inbye.evaluate(problem(obstacles=obstacles)).digest
        for obstacles in (np.array(row), np.array(row, np.float32), row)
    }
    assert len(digests) == 1
    assert inbye.evaluate(problem(obstacles=[])).digest == inbye.evaluate(problem()).digest
    cells = np.array([[100, 0, -1], [0, 0, 100]])
    for form in (cells, cells.astype(np.int16), cells.tolist()):
        assert np.array_equal(inbye.Map(form, 0.5).cells, cells)


@pytest.mark.parametrize(
    ("obstacles", "message"),
    [
        (np.array([["a"] * 5]), "^obstacles: real numbers are expected, not values of type <U1"),
        (np.zeros(5), "^obstacles: an array of dimension 2 is expected, not 1"),
        ([[1.0], [1.0, 2.0]], "^obstacles: rows of equal length"),
    ],
)
def test_array_that_is_none_is_one_line_with_its_argument(obstacles: object, message: str) -> None:
    with pytest.raises(inbye.InbyeError, match=message) as error:
        problem(obstacles=obstacles)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (np.full((2, 2), 255, np.uint8), "0 to 100"),
        (np.full((2, 2), 2**64 - 1, np.uint64), "0 to 100"),
        (np.zeros((2, 2), bool), "cells: integers are expected, not values of type bool"),
        (np.zeros((2, 2)), "cells: integers are expected, not values of type float64"),
        (np.zeros(4, np.int64), "cells: an array of dimension 2"),
        ([], "cells: a map needs at least one row of one cell"),
    ],
)
def test_cells_of_other_types_are_converted_or_rejected(cells: object, message: str) -> None:
    with pytest.raises(inbye.InbyeError, match=message):
        inbye.Map(cells, 0.5)


def test_numbers_and_engines_of_a_wrong_kind_are_errors_with_the_argument() -> None:
    room = inbye.Map(np.zeros((20, 20), np.int8), 0.5)
    one = inbye.Problem(room, [5, 5, 0], np.array([8.0, 5.0]))
    two = "^2 real numbers are expected\nwhile processing"
    with pytest.raises(TypeError, match=rf"{two} 'target'"):
        inbye.Problem(room, (5, 5, 0), (8, 5, 0))  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match=rf"{two} 'start'"):
        inbye.plan(room, (5, 5, 0), (8, 5))  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match=rf"{two} 'velocity'"):
        inbye.Problem(room, (5, 5, 0), (8, 5), velocity=(1j, 0))  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match=r"^engine: an Engine is expected.*not 'cpu'"):
        inbye.evaluate(one, engine="cpu")  # pyright: ignore[reportArgumentType]
    with pytest.raises(inbye.InbyeError, match=r"^threads is -1: it must be at least 0"):
        inbye.Engine("cpu", threads=-1)
    with pytest.raises(inbye.InbyeError, match=r"^threads is \d+: it must be below 2\^64"):
        inbye.Engine("cpu", threads=2**64)


def test_values_are_copied_and_pickled() -> None:
    config = inbye.Config(CONFIG)
    cells = np.array([[100, 0, -1], [0, 0, 100]], np.int8)
    speed = inbye.Map(np.array([[0, 40, 0], [0, 0, 0]], np.int8), 0.5, (1.0, 2.0, 0.5))
    world = inbye.Map(cells, 0.5, (1.0, 2.0, 0.5)).with_zones(speed=speed)
    for copied in (pickle.loads(pickle.dumps(config)), copy.copy(config), copy.deepcopy(config)):
        assert copied == config
    for copied in (pickle.loads(pickle.dumps(world)), copy.copy(world), copy.deepcopy(world)):
        assert np.array_equal(copied.cells, world.cells)
        assert np.array_equal(copied.zones, world.zones)
        assert (copied.resolution_m, copied.origin) == (world.resolution_m, world.origin)
    asked = problem()
    assert copy.deepcopy(asked) is asked
    mission = inbye.World(world, (1.2, 2.6, 0.0), (2.0, 2.6))
    assert copy.deepcopy({"mission": mission})["mission"] is mission


def test_fields_of_structured_arrays_are_read_at_their_places() -> None:
    def digest(obstacles: np.ndarray) -> str:
        return inbye.evaluate(problem(obstacles=obstacles), samples=True).digest

    rows = np.array([[6.0, 2.2, 0.25, -0.5, 0.0], [1.9, 1.25, 0.2, 0.0, 0.0]])
    # Records of 44 bytes: no multiple of the size of a number.
    records = np.zeros(2, [("id", "<i4"), ("row", "<f8", (5,))])
    records["row"] = rows
    digests = {digest(it) for it in (rows, records["row"])}
    assert len(digests) == 1
    assert digest(rows[:1]) not in digests
    # Strides are whole, but the start is not.
    shifted = np.zeros(81, np.uint8)[1:].view(np.float64).reshape(2, 5)
    shifted[:] = rows
    assert not shifted.flags.aligned
    assert digest(shifted) in digests


def test_masked_elements_are_errors() -> None:
    row = np.ma.masked_equal([[3.0, 1.25, 0.25, -0.5, 9.0]], 9.0)
    with pytest.raises(inbye.InbyeError, match=r"^obstacles: elements are masked: fill them"):
        problem(obstacles=row)
    problem(obstacles=row.filled(0.0))
    cells = np.ma.masked_equal(np.array([[100, 0, 7]], np.int8), 7)
    with pytest.raises(inbye.InbyeError, match=r"^cells: elements are masked"):
        inbye.Map(cells, 0.5)


def test_settings_are_given_back_and_nested() -> None:
    config = inbye.Config(CONFIG)
    settings = config.to_dict()
    assert inbye.Config(settings).to_dict() == settings
    assert inbye.Config({"navigator": {"deadline_s": None}}) == inbye.Config({"navigator": {}})
    # It overrides the settings of a world.
    assert inbye.Config({"robot": {"limits": {"max_vel_x": 1.0}}}) != inbye.Config()
    assert inbye.Config("local.vx_samples = 8") == inbye.Config({"local": {"vx_samples": 8}})
    with pytest.raises(inbye.InbyeError, match=r"local: a value of type set .*: give a number"):
        inbye.Config({"local": {1}})


def test_digest_without_samples_is_another_value() -> None:
    answer, all_samples = (inbye.evaluate(problem(), samples=it) for it in (False, True))
    assert answer.command == all_samples.command
    assert answer.digest != all_samples.digest


def test_all_public_members_have_a_docstring() -> None:
    assert inbye.__version__.count(".") == 2
    for name in set(inbye.__all__) - {"__version__"}:
        public = getattr(inbye, name)
        members = vars(public) if isinstance(public, type) else {}
        for member, value in {"": public, **members}.items():
            assert member.startswith("_") or value.__doc__, f"{name}.{member}"


def test_plan_does_not_ignore_a_program() -> None:
    config = {"global_planner": {"command": ["planner"]}}
    with pytest.raises(inbye.InbyeError, match=r"^global_planner\.command: .*leave it out"):
        inbye.plan(inbye.Map.from_rows(ROWS, 0.5), (1.0, 1.2), (6.0, 1.2), config=config)


def test_map_of_an_array_is_the_map_of_its_rows() -> None:
    cells = np.array([[100, 0, -1], [0, 0, 100]], np.int8)
    world = inbye.Map(cells, 0.5, (1.0, 2.0, 0.0))
    assert np.array_equal(world.cells, cells)
    assert np.array_equal(inbye.Map.from_rows(["..#", "#.?"], 0.5).cells, cells)
    # A view with other strides has the same cells.
    assert np.array_equal(inbye.Map(cells.T.copy().T, 0.5).cells, cells)
    assert (world.resolution_m, world.origin) == (0.5, (1.0, 2.0, 0.0))
    with pytest.raises(inbye.InbyeError, match="0 to 100"):
        inbye.Map(np.full((2, 2), 101, np.int8), 0.5)
    with pytest.raises(inbye.InbyeError, match=r"missing\.yaml"):
        inbye.Map.load("missing.yaml")
    with pytest.raises(inbye.InbyeError, match=r"0\.1: map\.yaml states its own: leave it out"):
        inbye.Map.load("map.yaml", 0.1)


def test_plan_leads_from_start_to_goal() -> None:
    cells = np.zeros((40, 80), np.int8)
    cells[:25, 40] = 100
    world = inbye.Map(cells, 0.1)
    path = inbye.plan(world, (1.0, 1.2), (6.5, 1.2))
    assert np.allclose(path[[0, -1]], [[1.0, 1.2], [6.5, 1.2]])
    assert path[:, 1].max() > 2.5
    cells[:, 40] = 100
    with pytest.raises(inbye.InbyeError, match="NO_VALID_PATH"):
        inbye.plan(inbye.Map(cells, 0.1), (1.0, 1.2), (6.5, 1.2))


def test_decision_respects_the_speed_limit_of_a_zone() -> None:
    world = inbye.Map(np.zeros((40, 80), np.int8), 0.1)
    slow = world.with_zones(speed=inbye.Map(np.full((40, 80), 70), 0.1))

    def speeds(on: inbye.Map, speed: float) -> np.ndarray:
        asked = inbye.Problem(on, (2.0, 2.0, 0.0), (6.0, 2.0), velocity=(speed, 0.0))
        samples = inbye.evaluate(asked, samples=True).samples
        assert samples is not None
        return samples["vx"]

    # The limit is 30 percent of 1 m/s. A faster robot brakes as fast as it can.
    assert speeds(world, 0.25).max() == pytest.approx(0.35)
    assert speeds(slow, 0.25).max() == pytest.approx(0.3)
    assert speeds(slow, 0.8).max() == pytest.approx(0.7)


def test_path_of_a_sample_that_does_not_exist_is_an_error() -> None:
    wrong: list[Any] = [-1, 128, 0.0]
    for index in wrong:
        expected = rf"^index is {index}: it must be a whole number, 0 to 127$"
        with pytest.raises(inbye.InbyeError, match=expected):
            problem().path(index)
