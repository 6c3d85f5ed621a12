"""A user's program for type checkers: `python/check` runs mypy in strict mode on it."""

from __future__ import annotations

from pathlib import Path

import gymnasium
import inbye
import inbye.gym
import inbye.planner_arena
import inbye.plot
import numpy as np
import numpy.typing as npt


class Mine:
    name = "mine"

    def set_plan(self, path: npt.NDArray[np.float64]) -> None:
        self.points = len(path)

    def compute_velocity(self, seen: inbye.ControllerInput) -> tuple[float, float] | None:
        return 0.3, float(seen.ranges.min())


def straight(seen: inbye.ControllerInput) -> tuple[float, float]:
    return 0.1 * seen.period_s, 0.0


def scalars(seen: inbye.ControllerInput) -> tuple[np.float64, np.float32]:
    return np.float64(0.1), np.float32(0.0)


def whole_numbers(seen: inbye.ControllerInput) -> npt.NDArray[np.int64]:
    return np.array([0, 0])


world = inbye.Map.load(Path("examples/mine.yaml"))
moved = inbye.Map(world.cells, 0.1, np.zeros(3))
path = inbye.plan(moved, np.array([1.0, 2.0]), np.array([3, 4]))
inbye.World(moved, np.array([1.0, 2.0, 0.0]), (np.float32(3.0), 4)).drive(np.int64(3))
path = inbye.plan(world, (10.0, 5.0), (80.0, 40.0))
obstacles = np.zeros((0, 5))
problem = inbye.Problem(world, (10.0, 5.0, 0.6), (13.0, 7.0), obstacles=obstacles)
decision = inbye.evaluate(problem, samples=True)
if decision.samples is not None:
    print(decision.samples["score"].max())
inbye.evaluate_batch((problem, problem))

mission = inbye.World(world, (10.0, 5.0, 0.6), (80.0, 40.0), people=4)
drive = mission.drive(seed=1, controller=Mine(), config={"local": {"vx_samples": 32}})
drive = mission.drive(seed=1, controller=straight)
drive = mission.drive(seed=1, controller=scalars)
drive = mission.drive(seed=1, controller=whole_numbers)
comparison = inbye.bench.compare(
    {"seeds": [0]},
    {"mine": Mine, "straight": straight, "object": Mine()},
    jobs=2,
    report=Path("comparison"),
)
try:
    rows = inbye.bench.run(Path("plan.toml"), {"mine": Mine})
except KeyboardInterrupt as error:
    rows = inbye.bench.rows_before(error)
inbye.planner_arena.write(rows, "arena.db")

worlds = inbye.bench.worlds(kind="scenes")
many = inbye.gym.VectorEnv(worlds, 64, seeds=range(100), threads=2)
seen, info = many.reset(seed=3)
seen, rewards, ended, cut, info = many.step(np.zeros((64, 2)))
env = inbye.gym.Env(worlds)
one, about = env.reset()
one, reward, is_over, is_cut, about = env.step(np.zeros(2))
gymnasium.make("inbye/Scene-v0")

config = inbye.Config({"local": {"vx_samples": 3}})
navigator = inbye.Navigator(world, (1.0, 1.0), [(2.0, 3.0)], controller=Mine(), config=config)
inbye.plot.trace(drive, world)
inbye.plot.decision(problem, decision)
