"""The parts of inbye that are written in Rust."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import (
    Any,
    Literal,
    NoReturn,
    Protocol,
    SupportsFloat,
    SupportsIndex,
    TypeAlias,
    final,
    type_check_only,
)

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]
Settings: TypeAlias = Config | Mapping[str, Any] | str
PlanSource: TypeAlias = str | os.PathLike[str] | Mapping[str, Any]
SeenArrays: TypeAlias = tuple[NDArray[np.float32], Floats, Floats]
# Index of the robot; outcome, world, seed, time, digest and reason; what the robot saw last.
Finished: TypeAlias = tuple[int, tuple[str, str, int, float, str | None, str | None], SeenArrays]
# Numbers: a sequence of any real type, or an array.
Vector: TypeAlias = Sequence[SupportsFloat] | NDArray[np.floating[Any] | np.integer[Any]]
Velocity: TypeAlias = Vector | None

@type_check_only
class ControllerObject(Protocol):
    """A controller. It may also have ``set_plan(path)``, ``reset()`` and ``name``.

    ``reset`` is called when a drive begins and when another goal begins, ``set_plan`` for each new
    path.
    """

    def compute_velocity(self, seen: ControllerInput, /) -> Velocity:
        """Return speed and turn rate, or None to brake."""

Controller: TypeAlias = Callable[[ControllerInput], Velocity] | ControllerObject

class InbyeError(ValueError):
    """An input that cannot be used; the message says what is wrong with it."""

__version__: str

def run_program(program: Sequence[str], arguments: Sequence[str]) -> NoReturn:
    """Run the program ``inbye`` and end the process."""

@final
class Config:
    """All settings of a robot, its navigation and its simulation.

    ``inbye config`` prints them with their units and ranges. A world applies the changes to its
    own settings, as those of a dictionary.
    """

    def __new__(cls, changes: Settings | None = None) -> Config:
        """Make the defaults with changes.

        A key with the value None counts as left out. Two are equal if their settings and their
        changes are: a change to a default value overrides the settings of a world.
        """
    def to_dict(self) -> dict[str, Any]:
        """Return every setting."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class Map:
    """An occupancy grid."""

    def __new__(
        cls,
        cells: ArrayLike,
        resolution_m: float,
        origin: Vector = ...,
    ) -> Map:
        """Make a map of rows of cells, the lowest row first.

        A cell has its occupancy in percent, an integer, or -1 if it is unknown. ``origin`` is the
        pose of the lower left corner, zeros by default.
        """
    @staticmethod
    def load(path: str | os.PathLike[str], resolution_m: float | None = None) -> Map:
        """Read a map_server YAML file, a MovingAI map or rows of text.

        The side of a cell, one metre by default, is for the last two. With a YAML file it is an
        error.
        """
    @staticmethod
    def from_rows(rows: Sequence[str], resolution_m: float, origin: Vector = ...) -> Map:
        """Make a map of rows of text, the highest row first: # wall, . free, ? unknown."""
    def with_zones(self, *, keepout: Map | None = None, speed: Map | None = None) -> Map:
        """Return this map with zones in which the robot must not drive, or only slowly.

        The masks are those of Nav2's costmap filters: occupied cells of ``keepout`` are closed,
        and a value of 30 in ``speed`` limits the speed to 70 percent of the largest. They may
        have another size and resolution than the map. A lidar sees through zones. Zones that the
        map has already are kept: of two limits the lower counts.
        """
    @property
    def cells(self) -> NDArray[np.int8]:
        """A copy of the cells, the lowest row first."""
    @property
    def zones(self) -> NDArray[np.int8] | None:
        """A copy of the zones on the cells of the map, if it has any.

        0 is no zone, 1 to 99 a speed limit in percent, and 100 a closed cell.
        """
    @property
    def resolution_m(self) -> float:
        """Side of a cell."""
    @property
    def origin(self) -> tuple[float, float, float]:
        """Pose of the lower left corner."""

def _map_of_parts(
    cells: ArrayLike,
    resolution_m: float,
    origin: Vector,
    zones: ArrayLike | None,
) -> Map:
    """Make a map of the parts that it was pickled as."""

def plan(
    map: Map,
    start: Vector,
    goal: Vector,
    *,
    config: Settings | None = None,
) -> Floats:
    """Plan a smooth path that the robot of the configuration can follow; rows of x and y."""

@final
class Problem:
    """All inputs of one decision.

    The limits, the footprint and the settings of the samples are those of ``config``. Rows of
    ``obstacles`` are x, y, radius, vx and vy of moving obstacles.
    """

    def __new__(
        cls,
        map: Map,
        pose: Vector,
        target: Vector,
        *,
        velocity: Vector = ...,
        last_command: Vector | None = None,
        key_node: Vector | None = None,
        obstacles: ArrayLike | None = None,
        config: Settings | None = None,
    ) -> Problem:
        """Make a problem.

        If left out, the velocity is zero, the key node the target, and the last command the
        velocity.
        """
    def __len__(self) -> int:
        """Return the number of samples."""
    def path(self, index: int) -> Floats:
        """Return the positions of a sample after each step of the horizon."""
    def __copy__(self) -> Problem: ...
    def __deepcopy__(self, _memo: dict[int, Any]) -> Problem: ...

@final
class Decision:
    """The answer to one problem."""

    @property
    def command(self) -> tuple[float, float] | None:
        """Velocity of the best sample; None if the robot must stop."""
    @property
    def index(self) -> int | None:
        """Index of the best sample."""
    @property
    def score(self) -> float | None:
        """Its score."""
    @property
    def admissible(self) -> int:
        """Number of admissible samples."""
    @property
    def rejected(self) -> tuple[int, int, int]:
        """Numbers of samples that collide, cannot stop in time, and leave the map."""
    @property
    def digest(self) -> str:
        """SHA-256 of the exact bits.

        With ``samples=True`` it covers all samples and is the digest of ``inbye evaluate``.
        Without, it covers the answer only and is another value.
        """
    @property
    def samples(self) -> NDArray[np.void] | None:
        """A record of every sample, if they were asked for.

        The fields are vx, vtheta, status, x, y, yaw, heading, clearance, velocity, path and score.
        """
    def __copy__(self) -> Decision: ...
    def __deepcopy__(self, _memo: dict[int, Any]) -> Decision: ...

@final
class Engine:
    """Evaluates problems on the CPU or on a GPU, with the same bits."""

    def __new__(cls, name: str = "auto", *, threads: int = 1) -> Engine:
        """Open "auto", "cpu", "gpu" or "gpu:NAME", with up to 1024 threads; 0 counts as 1."""
    @property
    def name(self) -> str:
        """The processor."""
    def evaluate(self, problem: Problem, *, samples: bool = False) -> Decision:
        """Take one decision."""
    def evaluate_batch(
        self, problems: Sequence[Problem], *, samples: bool = False
    ) -> list[Decision]:
        """Take the decisions of many robots in one submission."""

@final
class ControllerInput:
    """What a controller decides from."""

    @property
    def time_s(self) -> float:
        """Time of the tick."""
    @property
    def period_s(self) -> float:
        """Control period."""
    @property
    def pose(self) -> tuple[float, float, float]:
        """Estimated pose at the time of the odometry."""
    @property
    def twist(self) -> tuple[float, float]:
        """Measured velocity at that time."""
    @property
    def odometry_s(self) -> float:
        """That time."""
    @property
    def predicted_pose(self) -> tuple[float, float, float]:
        """Pose when a command of this tick takes effect."""
    @property
    def predicted_twist(self) -> tuple[float, float]:
        """Velocity at that time."""
    @property
    def last_command(self) -> tuple[float, float]:
        """The command of the last tick."""
    @property
    def speed_limits(self) -> tuple[float, float, float]:
        """Least speed, largest speed, largest turn rate."""
    @property
    def acceleration_limits(self) -> tuple[float, float, float, float]:
        """Acceleration and braking, the latter below zero: of the speed, then of the turn rate."""
    @property
    def footprint(self) -> Floats:
        """Discs of the robot: rows of x, y and radius in its own frame."""
    @property
    def ranges(self) -> Floats:
        """Newest scan: infinite for nothing within range, NaN for no measurement."""
    @property
    def lidar_position(self) -> tuple[float, float]:
        """Position of the lidar in the robot's frame, from which the ranges are."""
    @property
    def angle_min(self) -> float:
        """Direction of the first beam in the robot's frame."""
    @property
    def angle_increment(self) -> float:
        """Angle between beams."""
    @property
    def range_max(self) -> float:
        """Longest range."""
    @property
    def scan_s(self) -> float:
        """Time of the scan."""
    @property
    def moving_obstacles(self) -> Floats:
        """Tracked moving obstacles: rows of x, y, radius, vx and vy."""
    @property
    def path(self) -> Floats:
        """The global path: rows of x and y. All ticks share this array, and it is read-only."""
    @property
    def path_progress_m(self) -> float:
        """Length of the path behind the robot."""
    @property
    def local_target(self) -> tuple[float, float]:
        """The key node that inbye would drive to."""
    @property
    def goal(self) -> tuple[float, float, float | None]:
        """The goal, with its yaw if it has one."""

@final
class Drive:
    """A drive in a simulated world."""

    @property
    def reached(self) -> bool:
        """Whether the robot reached its goal without contact."""
    @property
    def time_s(self) -> float:
        """Time of the drive."""
    @property
    def reason(self) -> str | None:
        """Why the goal was not reached."""
    @property
    def figures(self) -> dict[str, Any]:
        """All figures of the run, as in the records of experiments."""
    @property
    def digest(self) -> str | None:
        """SHA-256 of the exact bits of the trace, as ``inbye drive`` prints it."""
    @property
    def zones(self) -> dict[str, Any] | None:
        """How the robot kept the zones of the map, if it has any, as ``inbye drive`` says it.

        ``min_gap_m`` of the body from closed zones, None without any; ``intrusions`` into them and
        ``limited_ticks`` with a speed limit, in ticks; ``max_excess`` above a limit, m/s.
        """
    @property
    def trace(self) -> NDArray[np.void]:
        """A record of every tick.

        The fields are time_s, x, y, yaw, believed_x, believed_y, believed_yaw, vx, vtheta,
        command_vx, command_vtheta, target_x, target_y, gap_m, admissible, samples, mode and path.
        """
    @property
    def paths(self) -> list[Floats]:
        """The global paths that the robot followed."""
    def __copy__(self) -> Drive: ...
    def __deepcopy__(self, _memo: dict[int, Any]) -> Drive: ...

@final
class World:
    """A world to drive in."""

    def __new__(
        cls,
        map: Map,
        start: Vector,
        goal: Vector,
        *,
        people: int = 0,
        time_limit_s: float | None = None,
        name: str = "map",
    ) -> World:
        """Make a mission on a map, among people who walk across the path.

        ``people`` is 0 to 100. The default time limit is 30 s and 10 s for each metre of the path.
        """
    @property
    def name(self) -> str:
        """Its name in tables."""
    @property
    def kind(self) -> str:
        """Its kind, as plans name it."""
    def drive(
        self,
        seed: SupportsIndex = 0,
        *,
        config: Settings | None = None,
        controller: Controller | None = None,
        engine: str = "cpu",
    ) -> Drive:
        """Drive the mission of a seed, with inbye's behaviours or with a controller.

        The settings change those of the world. A controller uses no engine. Its exception ends the
        drive and is raised here.
        """
    def __copy__(self) -> World: ...
    def __deepcopy__(self, _memo: dict[int, Any]) -> World: ...

def replay(
    path: str | os.PathLike[str],
    *,
    engine: str = "cpu",
    global_planner: Sequence[str] | None = None,
) -> dict[str, Any]:
    """Repeat the decisions of a recording and compare every bit.

    ``global_planner`` is the program that planned the paths of the drive, with its arguments, if a
    program did. The command in the recording never runs.

    Returns ``ticks``, ``agrees``, ``complete``, ``cpu_ticks`` and ``first_difference``: tick,
    field, recorded and replayed value. ``cpu_ticks`` is the number of decisions that the CPU took
    in place of a GPU; None for an engine without a fallback. Raises ``InbyeError`` for a recording
    without ticks.
    """

def read_worlds(plan: PlanSource) -> list[World]:
    """Read the worlds of a plan."""

def run(
    plan: PlanSource,
    controllers: Mapping[str, Controller | type[ControllerObject]] | None = None,
    *,
    jobs: int = 1,
    on_exception: Literal["raise", "fail"] = "raise",
) -> list[dict[str, Any]]:
    """Run the cells of a plan, and its tasks with controllers."""

def compare(
    plan: PlanSource,
    controllers: Mapping[str, Controller | type[ControllerObject]] | None = None,
    *,
    jobs: int = 1,
    on_exception: Literal["raise", "fail"] = "raise",
    report: str | os.PathLike[str] | None = None,
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Run the cells of a plan and rank the planners; the ranking and the rows."""

def planner_names(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the name of each row's planner."""

@final
class PoseEstimate:
    """The pose after a revolution of the lidar."""

    @property
    def time_s(self) -> float:
        """Time of the pose."""
    @property
    def pose(self) -> tuple[float, float, float]:
        """The pose."""
    @property
    def covariance(self) -> list[list[float]]:
        """Covariance of x, y and yaw."""
    @property
    def rms_m(self) -> float:
        """Mean distance of beam ends from the surfaces of the map."""
    @property
    def status(self) -> Literal["tracking", "uncertain", "lost"]:
        """How reliable it is."""
    @property
    def reason(self) -> str | None:
        """Why the pose is lost."""

@final
class Localizer:
    """Estimates the pose from odometry, and from scans that are matched to the map."""

    def __new__(cls, map: Map, start: Vector, *, config: Settings | None = None) -> Localizer:
        """Start at a pose on the map."""
    def predict(self, time_s: float, odometry: Vector) -> None:
        """Predict by a pose of the odometry. The first one is the reference.

        The times of predictions must not go back, and neither must those of revolutions.
        """
    def update(
        self,
        time_s: float,
        ranges: ArrayLike,
        *,
        angle_min: float,
        angle_increment: float,
        range_max: float,
        lidar_position: tuple[float, float] | None = None,
        sweep_s: float = 0.0,
    ) -> PoseEstimate:
        """Match a revolution that ended at a time and lasted ``sweep_s``, at most 1 s.

        The ranges are from the lidar's position in the robot's frame; none is the origin.
        """
    @property
    def estimate(self) -> PoseEstimate:
        """The latest estimate."""
    @property
    def odometry_scale(self) -> tuple[float, float]:
        """Learned scales of odometry's distances and turns."""

@final
class NavigatorDecision:
    """The decision of a tick."""

    @property
    def command(self) -> tuple[float, float]:
        """The velocity to drive."""
    @property
    def mode(self) -> str:
        """What the navigator does, such as "driving" or "arrived"."""
    @property
    def local_target(self) -> tuple[float, float]:
        """The key node that the robot drives to."""
    @property
    def observation_fault(self) -> str | None:
        """What is wrong with the observation."""
    @property
    def fault(self) -> str | None:
        """Why the mission failed."""

@final
class Navigator:
    """Follows global paths to its goals among obstacles that are not in the map."""

    def __new__(
        cls,
        map: Map,
        start: Vector,
        goals: Sequence[Vector],
        *,
        config: Settings | None = None,
        controller: Controller | None = None,
        engine: str = "cpu",
    ) -> Navigator:
        """Plan a path to every goal: ``(x, y)`` or ``(x, y, yaw)``."""
    def step(
        self,
        time_s: float,
        pose: Vector,
        velocity: Vector,
        ranges: ArrayLike,
        *,
        angle_min: float,
        angle_increment: float,
        range_max: float,
        lidar_position: tuple[float, float] | None = None,
        pose_s: float | None = None,
        odometry_s: float | None = None,
        scan_s: float | None = None,
    ) -> NavigatorDecision:
        """Decide what to do now. Times of measurements that are left out are that of the tick.

        The ranges are from the lidar's position in the robot's frame; none is the origin.
        """
    def set_speed_limit(self, limit: float | None) -> None:
        """Limit the speed from the next step on, m/s; None for no limit.

        A robot that is faster brakes. With a limit of zero it stands or turns on the spot, and
        this time does not count as time without progress. Limits of zones count too.
        """
    def set_goals(self, start: Vector, goals: Sequence[Vector]) -> None:
        """Replace the goals while the robot drives, or after it arrived or failed.

        A path to each of them is planned on the present map, and the next step drives to the first.
        ``start`` is where the robot is. What the scans showed is kept. The call takes as long as
        the plans: on a large map stop the robot before, with a speed limit of zero. If a goal has
        no path, InbyeError is raised, and the goals so far remain.
        """
    def set_map(self, map: Map) -> None:
        """Replace the map, in the same frame, while the robot drives.

        The next step avoids its obstacles and zones, and a path on it is planned at once. Obstacles
        that only the lidar saw remain. Where the map has no path even without them, the mission
        fails within a second by the default settings: ``fault`` has NO_VALID_PATH. It takes time in
        proportion to the map's area.
        """
    @property
    def distance_left_m(self) -> float:
        """Length of the path ahead, to the last goal, metres."""
    @property
    def goals_passed(self) -> int:
        """Number of goals that the robot has left behind."""
    @property
    def path(self) -> Floats:
        """The global path that the robot follows."""

@final
class Environments:
    """Robots on missions in worlds, stepped together; :mod:`inbye.gym` makes use of it."""

    def __new__(
        cls,
        worlds: Sequence[World],
        count: int,
        *,
        seeds: Sequence[SupportsIndex],
        config: Settings | None = None,
        navigator: bool = False,
        autoreset: bool = True,
        engine: str = "cpu",
        threads: int | None = None,
        max_steps: int | None = None,
    ) -> Environments:
        """Make ``count`` environments that take the missions of all seeds and worlds in turn.

        ``threads`` is 1 to 1024. With several, they work only in the process that made them. After
        ``max_steps`` the time of a mission is up; None and -1 are no limit.

        Without ``autoreset`` a robot whose mission has ended stays there until the next reset.
        """
    @property
    def beams(self) -> int:
        """Number of beams of the lidar."""
    @property
    def range_max(self) -> float:
        """Longest range of the lidar."""
    @property
    def speed_limits(self) -> tuple[float, float, float]:
        """Least speed, largest speed, largest turn rate."""
    @property
    def missions(self) -> list[tuple[str, int]]:
        """World and seed of each robot's mission."""
    @property
    def period_s(self) -> float:
        """Control period."""
    def pictures(self) -> list[NDArray[np.uint8]]:
        """Draw each robot on its mission: rows of pixels, red, green and blue."""
    @property
    def commands(self) -> tuple[Floats, NDArray[np.bool_]]:
        """Velocities that the robots were commanded in the last step, and where they were changed.

        The velocities are within the limits of the base. The protective layer then changed some.
        """
    def reset(self, first_job: int) -> SeenArrays:
        """Start missions; return what the robots see: ranges, goals and velocities."""
    def step(
        self, actions: ArrayLike
    ) -> tuple[SeenArrays, Floats, NDArray[np.uint8], list[Finished]]:
        """Drive every robot for a control period; return what they see, rewards and ends.

        An end is 1, or 2 where the time was up. Those robots start the next mission.
        """
