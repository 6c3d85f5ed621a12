"""Drives: by inbye, by controllers in Python, tick by tick, and replayed."""

import gc
import json
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import inbye
import numpy as np
import pytest


def scene(name: str) -> inbye.World:
    (world,) = [world for world in inbye.bench.worlds(kind="scenes") if world.name == name]
    return world


def room(**options: object) -> inbye.World:
    cells = np.zeros((60, 100), np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    return inbye.World(inbye.Map(cells, 0.1), (1.0, 3.0, 0.0), (8.0, 3.0), **options)


def straight(seen: inbye.ControllerInput) -> tuple[float, float]:
    to_goal = np.hypot(seen.goal[0] - seen.pose[0], seen.goal[1] - seen.pose[1])
    return (0.4 if to_goal > 0.2 else 0.0, -0.5 * seen.pose[2])


class Recorded:
    """A controller with all methods, which records its inputs."""

    name = "recorded"

    def __init__(self) -> None:
        self.inputs: list[inbye.ControllerInput] = []
        self.plans: list[np.ndarray] = []

    def set_plan(self, path: np.ndarray) -> None:
        self.plans.append(path)

    def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float]:
        self.inputs.append(seen)
        return straight(seen)


def test_drive_has_the_digest_of_the_program() -> None:
    world = scene("dead_end")
    drive = world.drive(3)
    assert drive.reached
    assert drive.reason is None
    again = world.drive(3)
    assert again.digest == drive.digest != world.drive(4).digest
    command = [sys.executable, "-m", "inbye", "drive", "--scene", "dead_end", "--seed", "3"]
    run = subprocess.run([*command, "--json", "--engine", "cpu"], capture_output=True, check=True)
    assert json.loads(run.stdout)["trace_digest"] == drive.digest


def test_trace_and_figures_describe_the_drive() -> None:
    drive = room().drive()
    trace, figures = drive.trace, drive.figures
    assert len(trace) == figures["ticks"]
    assert trace["time_s"][-1] == drive.time_s == pytest.approx(figures["time_s"])
    assert trace["mode"][-1] == "arrived"
    assert trace["gap_m"].min() == pytest.approx(figures["min_clearance_m"])
    assert np.hypot(trace["x"][-1] - 8.0, trace["y"][-1] - 3.0) < 0.1
    assert [path.shape[1] for path in drive.paths] == [2] * figures["plans"]


def test_controller_in_python_drives() -> None:
    by_function, controller = room().drive(controller=straight), Recorded()
    by_object = room().drive(controller=controller)
    assert by_object.reached
    assert by_object.digest == by_function.digest != room().drive().digest
    assert by_object.figures["controller"] == "recorded"
    assert by_function.figures["controller"] == "straight"
    assert len(controller.plans) == by_object.figures["plans"]
    first = controller.inputs[0]
    assert first.ranges.shape == (360,)
    assert np.array_equal(first.path, controller.plans[0])
    assert first.goal == (8.0, 3.0, None)
    assert first.speed_limits[0] < 0.0 < first.speed_limits[1]


def test_object_of_a_controller_is_reset_before_each_drive() -> None:
    class Ramp:
        ticks = 7

        def reset(self) -> None:
            self.ticks = 0

        def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float]:
            self.ticks += 1
            return min(0.4, 0.01 * self.ticks), straight(seen)[1]

    ramp = Ramp()
    options = {"time_limit_s": 20.0}
    assert len({room(**options).drive(controller=it).digest for it in (ramp, ramp, Ramp())}) == 1
    plan = {"worlds": [{"kind": "scenes", "time_limit_s": 20.0}], "seeds": range(2)}
    rows = inbye.bench.run(plan, {"object": ramp, "class": Ramp})
    figures = [
        [(row["world"], row["seed"], row["travelled_m"]) for row in rows if row["config"] == name]
        for name in ("object", "class")
    ]
    assert len(figures[0]) == 6
    assert figures[0] == figures[1]


def test_path_of_a_controller_is_read_only() -> None:
    def controller(seen: inbye.ControllerInput) -> tuple[float, float]:
        path = seen.path
        path -= seen.pose[:2]
        return straight(seen)

    with pytest.raises(ValueError, match="read-only"):
        room().drive(controller=controller)


def test_navigator_that_its_controller_holds_is_freed() -> None:
    class Robot:
        def __init__(self) -> None:
            goals = [(6.0, 4.5)]
            self.navigator = inbye.Navigator(walls(), (2.0, 3.0), goals, controller=self.decide)

        def decide(self, _: inbye.ControllerInput) -> tuple[float, float]:
            return 0.3, 0.0

    robot = Robot()
    robot.navigator.step(0.0, (2.0, 3.0, 0.0), (0.0, 0.0), scan(2.0, 3.0), **ANGLES)
    gone = weakref.ref(robot)
    gc.collect()
    assert gone() is robot
    del robot
    gc.collect()
    assert gone() is None


def fails(_: inbye.ControllerInput) -> tuple[float, float]:
    raise KeyError("nothing here")


@pytest.mark.parametrize(
    ("controller", "error"),
    [
        (fails, KeyError),
        (lambda _: "fast", inbye.InbyeError),
        (lambda _: (1.0, 2.0, 3.0), inbye.InbyeError),
        (7, inbye.InbyeError),
        (type("Other", (), {})(), inbye.InbyeError),
    ],
)
def test_exception_of_a_controller_is_raised(
    controller: Callable[..., object], error: type[Exception]
) -> None:
    with pytest.raises(error):
        room().drive(controller=controller)


def test_controller_and_a_program_that_decides_are_an_error() -> None:
    config = {"controller": {"command": ["program"]}}
    world = inbye.Map(np.zeros((60, 100), np.int8), 0.1)
    with pytest.raises(inbye.InbyeError, match=r"^controller\.command: .*leave one of them out"):
        room().drive(config=config, controller=straight)
    with pytest.raises(inbye.InbyeError, match=r"^controller\.command: .*leave one of them out"):
        inbye.Navigator(world, (1.0, 3.0), [(8.0, 3.0)], config=config, controller=straight)


def test_unknown_engine_is_an_error_with_a_controller_too() -> None:
    with pytest.raises(inbye.InbyeError, match="`xpu` is not an engine"):
        room().drive(controller=straight, engine="xpu")


def test_answer_of_a_controller_is_any_sequence_of_two_numbers() -> None:
    def answers(form: Callable[[tuple[float, float]], object]) -> str | None:
        return room().drive(controller=lambda seen: form(straight(seen))).digest

    assert answers(tuple) == answers(list) == answers(np.array)
    message = r"^controller recorded: it returned \[1, 2, 3\]: return speed and turn rate, two"
    wrong = Recorded()
    wrong.compute_velocity = lambda _: [1, 2, 3]
    with pytest.raises(inbye.InbyeError, match=message):
        room().drive(controller=wrong)


def test_config_changes_the_settings_of_a_world_as_its_dictionary_does() -> None:
    # Worlds of this kind have settings of their own: the pose is that of scans.
    world = inbye.bench.worlds(kind="localization")[0]

    def digest(config: inbye.Config | dict[str, object] | None) -> str | None:
        return world.drive(config=config, controller=lambda _: None).digest

    changes = {"navigator": {"xy_goal_tolerance": 0.15}}
    own = digest(changes)
    assert own == digest(inbye.Config(changes)) == digest(inbye.Config(inbye.Config(changes)))
    assert own != digest({"pose_source": "fixes"})
    assert digest(inbye.Config()) == digest(None)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"people": 101}, "people is 101: it must be 0 to 100"),
        ({"people": -1}, "people is -1: it must be at least 0"),
        ({"time_limit_s": 0.0}, "time_limit_s is 0: it must be above zero"),
        ({"time_limit_s": float("nan")}, "time_limit_s is NaN: it must be above zero"),
    ],
)
def test_world_checks_its_ranges(options: dict[str, float], message: str) -> None:
    with pytest.raises(inbye.InbyeError, match=message):
        room(**options)


def test_seed_below_zero_is_an_error_with_its_name() -> None:
    with pytest.raises(inbye.InbyeError, match=r"^seed is -1: it must be at least 0"):
        room().drive(seed=-1)


def test_controller_that_sees_no_way_gives_up() -> None:
    drive = room(time_limit_s=200.0).drive(controller=lambda _: None)
    assert not drive.reached
    assert drive.figures["outcome"] == "failed"


def test_recording_of_the_program_replays(tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    command = [sys.executable, "-m", "inbye", "drive", "--scene", "dead_end", "--record"]
    subprocess.run([*command, str(file)], capture_output=True, check=True)
    answer = inbye.replay(file)
    assert answer["agrees"]
    assert answer["complete"]
    assert answer["ticks"] > 100
    assert answer["cpu_ticks"] in (None, 0)
    with pytest.raises(inbye.InbyeError, match="leave the global planner out"):
        inbye.replay(file, global_planner=["cat"])
    file.write_bytes(b"no recording")
    with pytest.raises(inbye.InbyeError, match=r"run\.mcap"):
        inbye.replay(file)


ANGLES = {"angle_min": -np.pi, "angle_increment": np.pi / 180, "range_max": 20.0}


def walls() -> inbye.Map:
    cells = np.zeros((80, 120), np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    return inbye.Map(cells, 0.1)


def scan(x: float, y: float, yaw: float = 0.0) -> np.ndarray:
    """Measure the distances to the walls."""
    angle = yaw - np.pi + np.arange(360) * np.pi / 180
    sine, cosine = np.sin(angle) + 1e-12, np.cos(angle) + 1e-12
    across = np.where(cosine > 0, 11.9 - x, x - 0.1) / np.abs(cosine)
    along = np.where(sine > 0, 7.9 - y, y - 0.1) / np.abs(sine)
    return np.minimum(across, along)


def drive_to_goal(
    navigator: inbye.Navigator, start: tuple[float, float], at_tick: Callable[[int], None]
) -> np.ndarray:
    """Return x, y, yaw, speed and turn rate of each tick of a robot that drives without error."""
    x, y, yaw, velocity, decision = *start, 0.0, (0.0, 0.0), None
    rows = []
    for tick in range(600):
        at_tick(tick)
        decision = navigator.step(0.1 * tick, (x, y, yaw), velocity, scan(x, y, yaw), **ANGLES)
        if decision.mode == "arrived":
            break
        velocity = decision.command
        rows.append((x, y, yaw, *velocity))
        x += 0.1 * velocity[0] * np.cos(yaw)
        y += 0.1 * velocity[0] * np.sin(yaw)
        yaw += 0.1 * velocity[1]
    assert decision is not None
    assert decision.mode == "arrived", decision.fault
    return np.array(rows)


def test_navigator_brings_a_robot_of_the_caller_to_its_goal() -> None:
    navigator = inbye.Navigator(walls(), (2.0, 3.0), [(6.0, 4.5)])
    assert np.allclose(navigator.path[[0, -1]], [[2.0, 3.0], [6.0, 4.5]])
    assert navigator.distance_left_m == pytest.approx(4.27, abs=0.1)
    x, y, yaw, *velocity = drive_to_goal(navigator, (2.0, 3.0), lambda _: None)[-1]
    assert np.hypot(x - 6.0, y - 4.5) < 0.25
    assert navigator.distance_left_m < 0.25
    assert navigator.goals_passed == 0
    blind = navigator.step(100.0, (x, y, yaw), velocity, np.full(360, np.nan), **ANGLES)
    assert blind.observation_fault is not None
    with pytest.raises(inbye.InbyeError, match="at least one"):
        inbye.Navigator(walls(), (2.0, 3.0), [])


def rectangle(left: int, low: int, right: int, high: int, value: int) -> inbye.Map:
    """Make a mask on the cells of ``walls``."""
    cells = np.zeros((80, 120), np.int8)
    cells[low:high, left:right] = value
    return inbye.Map(cells, 0.1)


def enters(mask: inbye.Map, path: np.ndarray) -> bool:
    legs = [np.linspace(*ends, 100) for ends in pairwise(path)]
    columns, rows = (np.concatenate(legs) / 0.1).astype(int).T
    return bool((mask.cells[rows, columns] == 100).any())


def test_zones_are_kept_by_paths_samples_drives_and_the_navigator() -> None:
    closed = rectangle(50, 0, 65, 50, 100)
    zoned = walls().with_zones(keepout=closed, speed=rectangle(70, 0, 90, 80, 40))
    assert zoned.zones is not None
    assert np.array_equal(np.unique(zoned.zones), [0, 60, 100])
    assert walls().zones is None
    start, goal = (2.0, 3.0), (10.0, 3.0)
    assert enters(closed, inbye.plan(walls(), start, goal))
    assert not enters(closed, inbye.plan(zoned, start, goal))
    assert not enters(closed, inbye.Navigator(zoned, start, [goal]).path)
    ahead = [
        inbye.evaluate(inbye.Problem(world, (4.4, 3.0, 0.0), goal, velocity=(0.5, 0.0)))
        for world in (walls(), zoned)
    ]
    assert ahead[1].admissible < ahead[0].admissible
    drive = inbye.World(zoned, (*start, 0.0), goal).drive()
    assert drive.reached
    assert drive.zones is not None
    assert drive.zones["intrusions"] == 0 < drive.zones["min_gap_m"]
    assert drive.zones["limited_ticks"] > 0
    free = inbye.World(walls(), (*start, 0.0), goal).drive()
    assert free.zones is None
    assert enters(closed, np.stack([free.trace["x"], free.trace["y"]], axis=1))
    with pytest.raises(inbye.InbyeError, match="keepout: no cell of the map is closed"):
        walls().with_zones(keepout=rectangle(0, 0, 0, 0, 0))
    with pytest.raises(inbye.InbyeError, match="speed: a cell is 100 percent"):
        walls().with_zones(speed=closed)
    # Zones of two calls are those of one.
    twice = walls().with_zones(keepout=closed).with_zones(speed=rectangle(70, 0, 90, 80, 40))
    assert np.array_equal(twice.zones, zoned.zones)


def test_speed_and_map_change_while_the_navigator_drives() -> None:
    start, goal = (3.0, 4.0), (9.0, 4.0)
    navigator = inbye.Navigator(walls(), start, [goal])
    closed = rectangle(50, 0, 65, 60, 100)
    assert enters(closed, navigator.path)

    def change(tick: int) -> None:
        if tick == 5:
            navigator.set_speed_limit(0.2)
            navigator.set_map(walls().with_zones(keepout=closed))
        if tick == 60:
            navigator.set_speed_limit(None)

    ticks = drive_to_goal(navigator, start, change)
    assert not enters(closed, ticks[:, :2])
    assert not enters(closed, navigator.path)
    assert ticks[20:60, 3].max() <= 0.2 < ticks[60:, 3].max()
    for limit in (-0.1, np.nan):
        with pytest.raises(inbye.InbyeError, match=r"^the speed limit is .*: it must be zero"):
            navigator.set_speed_limit(limit)


def test_goals_change_while_the_navigator_drives_and_after_it_arrived() -> None:
    start = (3.0, 4.0)
    navigator = inbye.Navigator(walls(), start, [(9.0, 4.0)])

    def change(tick: int) -> None:
        if tick == 10:
            for goals, why in (([(99.0, 4.0)], "is off the map"), ([], "at least one")):
                with pytest.raises(inbye.InbyeError, match=why):
                    navigator.set_goals(start, goals)
            navigator.set_goals(start, [(7.0, 4.0), (4.0, 4.0, 0.0)])

    ticks = drive_to_goal(navigator, start, change)
    assert ticks[:, 0].max() == pytest.approx(7.0, abs=0.2)
    assert ticks[-1, 0] == pytest.approx(4.0, abs=0.1)
    assert navigator.goals_passed == 1
    navigator.set_goals((4.0, 4.0), [(9.0, 4.0)])
    assert navigator.goals_passed == 0
    assert navigator.distance_left_m == pytest.approx(5.0, abs=0.1)


def test_map_without_a_path_ends_the_mission_within_a_second() -> None:
    navigator = inbye.Navigator(walls(), (3.0, 4.0), [(9.0, 4.0)])
    x, speed, fault = 3.0, 0.0, None
    for tick in range(16):
        if tick == 5:
            navigator.set_map(walls().with_zones(keepout=rectangle(60, 0, 65, 80, 100)))
        pose = (x, 4.0, 0.0)
        decision = navigator.step(0.1 * tick, pose, (speed, 0.0), scan(*pose), **ANGLES)
        fault = decision.fault
        if fault is not None:
            assert tick > 5
            break
        speed = decision.command[0]
        x += 0.1 * speed
        # Plans come from a thread of their own.
        time.sleep(0.05)
    assert fault is not None
    assert "NO_VALID_PATH" in fault


def test_localizer_corrects_a_wrong_start() -> None:
    localizer = inbye.Localizer(walls(), (3.1, 4.05, 0.0))
    for tick in range(30):
        x = 3.0 + 0.02 * tick
        localizer.predict(0.1 * tick, (x, 4.0, 0.0))
        localizer.update(0.1 * tick, scan(x, 4.0), **ANGLES)
    estimate = localizer.estimate
    assert estimate.status == "tracking"
    assert np.hypot(estimate.pose[0] - 3.58, estimate.pose[1] - 4.0) < 0.02
    assert estimate.covariance[0][0] < 0.01


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda it: it.predict(np.nan, (0.0, 0.0, 0.0)), "time_s is NaN: it must be finite"),
        (lambda it: it.predict(0.5, (0.0, 0.0, 0.0)), "time_s is 0.5: it must not be before"),
        (lambda it: it.predict(1.0, (1e300, 0.0, 0.0)), "odometry: a coordinate is above 1e9 m"),
        (lambda it: it.update(np.inf, scan(3.0, 4.0), **ANGLES), "time_s is inf"),
        (lambda it: it.update(0.5, scan(3.0, 4.0), **ANGLES), "time_s is 0.5: it must not be"),
        (lambda it: it.update(1.0, scan(3.0, 4.0), sweep_s=-1.0, **ANGLES), "sweep_s is -1: it"),
        (lambda it: it.update(1.0, scan(3.0, 4.0), sweep_s=np.nan, **ANGLES), "sweep_s is NaN"),
    ],
)
def test_localizer_checks_times_and_odometry(
    call: Callable[[inbye.Localizer], object], message: str
) -> None:
    localizer = inbye.Localizer(walls(), (3.0, 4.0, 0.0))
    localizer.predict(1.0, (0.0, 0.0, 0.0))
    localizer.update(1.0, scan(3.0, 4.0), **ANGLES)
    with pytest.raises(inbye.InbyeError, match=message):
        call(localizer)


def test_localizer_starts_on_the_map() -> None:
    with pytest.raises(inbye.InbyeError, match=r"^start \(13.00, 4.00\) is outside the map"):
        inbye.Localizer(walls(), (13.0, 4.0, 0.0))


def test_navigator_and_localizer_are_shared_between_threads() -> None:
    navigator = inbye.Navigator(walls(), (2.0, 3.0), [(6.0, 4.5)])
    localizer = inbye.Localizer(walls(), (2.0, 3.0, 0.0))
    errors: list[BaseException] = []
    is_over = threading.Event()

    def read() -> None:
        try:
            while not is_over.is_set():
                assert len(navigator.path) > 1
                assert localizer.estimate.pose
        except BaseException as error:
            errors.append(error)

    reader = threading.Thread(target=read)
    reader.start()
    try:
        for tick in range(100):
            seen = scan(2.0, 3.0)
            navigator.step(0.1 * tick, (2.0, 3.0, 0.0), (0.0, 0.0), seen, **ANGLES)
            localizer.update(0.1 * tick, seen, **ANGLES)
    finally:
        is_over.set()
        reader.join()
    assert not errors


def test_controller_that_uses_its_own_navigator_gets_an_error() -> None:
    def controller(_: inbye.ControllerInput) -> tuple[float, float]:
        return float(len(navigator.path)), 0.0

    navigator = inbye.Navigator(walls(), (2.0, 3.0), [(6.0, 4.5)], controller=controller)
    with pytest.raises(inbye.InbyeError, match="cannot use the object that calls it"):
        navigator.step(0.0, (2.0, 3.0, 0.0), (0.0, 0.0), scan(2.0, 3.0), **ANGLES)


def test_class_is_no_controller() -> None:
    with pytest.raises(
        inbye.InbyeError, match=r"Recorded is a class: .* object of it, Recorded\(\)"
    ):
        inbye.World(walls(), (2.0, 3.0, 0.0), (10.0, 3.0)).drive(controller=Recorded)
