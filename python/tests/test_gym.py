"""Gymnasium's environments."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import gymnasium
import inbye.gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

WORLDS = inbye.bench.worlds(kind="scenes")


@pytest.mark.filterwarnings("ignore:.*Box")
def test_environment_passes_gymnasiums_check() -> None:
    check_env(gymnasium.make("inbye/Scene-v0").unwrapped)


def test_episode_ends_with_its_outcome() -> None:
    env = gymnasium.make("inbye/Scene-v0", seeds=[5])
    seen, info = env.reset()
    assert (info["world"], info["seed"]) == ("roadway", 5)
    assert seen["ranges"].shape == (360,)
    total, over = 0.0, False
    first = float(np.hypot(*seen["goal"]))
    while not over:
        seen, reward, done, cut, info = env.step(np.array([0.5, 0.0]))
        total, over = total + float(reward), done or cut
    assert info["outcome"] in ("contact", "timeout", "reached")
    assert total < first + 20.0
    with pytest.raises(inbye.InbyeError, match="the episode has ended: call reset"):
        env.unwrapped.step(np.array([0.5, 0.0]))
    env.reset()
    with pytest.raises(inbye.InbyeError, match="row 0 is not finite"):
        env.unwrapped.step(np.array([np.nan, 0.0]))


@pytest.mark.parametrize("engine", ["cpu", "gpu"])
def test_vector_of_robots_equals_single_ones_and_declares_its_autoreset(engine: str) -> None:
    config = {"simulation": {"lidar": {"beams": 90}}}
    threads = 2 if engine == "cpu" else None
    try:
        env = inbye.gym.VectorEnv(
            WORLDS[1:],
            3,
            seeds=[0, 1],
            config=config,
            navigator=True,
            engine=engine,
            threads=threads,
        )
        env.reset()
    except inbye.InbyeError as error:
        if engine == "gpu" and "adapter" in str(error):
            pytest.skip(str(error))
        raise
    assert env.metadata["autoreset_mode"] == gymnasium.vector.AutoresetMode.SAME_STEP
    env.reset()
    ended: dict[tuple[str, int], str] = {}
    while len(ended) < 4:
        seen, _, done, cut, info = env.step(np.zeros((3, 2)))
        assert seen["ranges"].shape == (3, 90)
        for index in np.flatnonzero(done | cut):
            final = {name: column[index] for name, column in info["final_info"].items()}
            ended[final["world"], final["seed"]] = final["digest"]
            assert info["final_obs"][index]["ranges"].shape == (90,)
            assert final["outcome"] == "reached"
    single = {
        (world.name, seed): world.drive(seed, config=config).digest
        for world in WORLDS[1:]
        for seed in (0, 1)
    }
    assert ended == single


def test_progress_of_a_callers_robot_counts_along_a_path_that_keeps_out_of_zones() -> None:
    room = np.zeros((40, 80), np.int8)
    closed = np.zeros_like(room)
    closed[:30, 38:42] = 100
    open_map = inbye.Map(room, 0.1)
    zoned = open_map.with_zones(keepout=inbye.Map(closed, 0.1))

    def top_of_path(world_map: inbye.Map) -> int:
        world = inbye.World(world_map, (1.0, 2.0, 0.0), (7.0, 2.0))
        env = inbye.gym.Env([world], seeds=[0], render_mode="rgb_array")
        env.reset()
        picture = env.render()
        assert picture is not None
        return int(np.flatnonzero((picture == (80, 140, 220)).all(axis=2).any(axis=1))[0])

    # The first row of a picture is the highest one.
    assert top_of_path(zoned) < top_of_path(open_map) - 40


def test_threads_and_seeds_repeat_every_step() -> None:
    def steps(threads: int, seed: int) -> list[np.ndarray]:
        env = inbye.gym.VectorEnv(WORLDS, 4, seeds=range(3), threads=threads)
        env.reset(seed=seed)
        actions = np.random.default_rng(1).uniform(-0.5, 0.5, (40, 4, 2))
        return [env.step(action)[0]["ranges"] for action in actions]

    one, two, other = steps(1, 7), steps(2, 7), steps(1, 8)
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)


def test_no_robot_is_stepped_when_an_action_is_not_finite() -> None:
    good = np.tile([0.8, 0.1], (3, 1))
    bad = good.copy()
    bad[2] = np.nan
    env, same = (inbye.gym.VectorEnv(WORLDS, 3) for _ in range(2))
    env.reset()
    same.reset()
    with pytest.raises(inbye.InbyeError, match=r"actions: row 2 is not finite: no robot was step"):
        env.step(bad)
    assert np.array_equal(env.step(good)[0]["goal"], same.step(good)[0]["goal"])
    with pytest.raises(inbye.InbyeError, match=r"actions: real numbers are expected, not .*U"):
        env.step(np.full((3, 2), "fast"))


FORKED = """
import os, sys
import inbye.gym
import numpy as np

worlds = inbye.bench.worlds(kind="scenes")
env = inbye.gym.Env(worlds)
robots = inbye.gym.VectorEnv(worlds, 2, threads=2)
env.reset()
robots.reset()
if os.fork() == 0:
    env.reset()
    env.step(np.zeros(2))
    for call in (robots.reset, lambda: robots.step(np.zeros((2, 2)))):
        try:
            call()
        except inbye.InbyeError as error:
            assert "made in another process" in str(error)
        else:
            os._exit(1)
    os._exit(0)
_, status = os.wait()
sys.exit(os.waitstatus_to_exitcode(status))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_environment_works_or_raises_after_a_fork() -> None:
    subprocess.run([sys.executable, "-c", FORKED], check=True, timeout=60)


@pytest.mark.parametrize("threads", [0, 1025])
def test_number_of_threads_has_limits(threads: int) -> None:
    with pytest.raises(inbye.InbyeError, match=rf"threads is {threads}: it must be 1 to 1024"):
        inbye.gym.VectorEnv(WORLDS, 2, threads=threads)


def test_seeds_and_numbers_of_robots_are_at_least_zero() -> None:
    with pytest.raises(inbye.InbyeError, match=r"^seed is -1: it must be at least 0"):
        inbye.gym.VectorEnv(WORLDS, 2, seeds=[-1])
    with pytest.raises(inbye.InbyeError, match=r"^num_envs is -1: it must be at least 0"):
        inbye.gym.VectorEnv(WORLDS, -1)


def test_reset_raises_for_what_it_does_not_use() -> None:
    robots = inbye.gym.VectorEnv(WORLDS, 2)
    mask = {"reset_mask": np.array([True, False])}
    for env in (robots, inbye.gym.Env(WORLDS)):
        with pytest.raises(inbye.InbyeError, match=r"^options: reset_mask has no effect here"):
            env.reset(options=mask)
    with pytest.raises(inbye.InbyeError, match="seed has 0 numbers: give one for each of the 2"):
        robots.reset(seed=[])
    robots.reset(seed=[3, None], options={})


def box(name: str, *, is_blocked: bool = False) -> inbye.World:
    cells = np.zeros((50, 80), np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    if is_blocked:
        cells[:, 60] = 100
    return inbye.World(inbye.Map(cells, 0.1), (1.0, 1.0, 0.0), (7.0, 4.0), name=name)


def outcomes(env: inbye.gym.VectorEnv, missions: int) -> list[tuple[str, str, bool, bool]]:
    """World, outcome, terminated and truncated of the first missions of one robot."""
    ends = []
    while len(ends) < missions:
        _, _, done, cut, info = env.step(np.zeros((1, 2)))
        if done[0] or cut[0]:
            final = info["final_info"]
            ends.append((final["world"][0], final["outcome"][0], bool(done[0]), bool(cut[0])))
            if final["outcome"][0] == "failed":
                assert final["reason"][0]
    return ends


def test_failed_mission_has_the_outcome_of_a_single_run() -> None:
    answers = "import sys\nfor index, _ in enumerate(sys.stdin):\n"
    answers += " print('{\"protocol\":1}' if index == 0 else 'x', flush=True)"
    config = {"controller": {"command": [sys.executable, "-c", answers]}}
    env = inbye.gym.VectorEnv([box("box")], 1, navigator=True, config=config)
    env.reset()
    assert box("box").drive(config=config).figures["outcome"] == "failed"
    assert outcomes(env, 1) == [("box", "failed", True, False)]


def test_mission_without_a_path_fails_and_the_next_one_starts() -> None:
    worlds = [box("open"), box("blocked", is_blocked=True)]
    assert worlds[1].drive().figures["outcome"] == "failed"
    env = inbye.gym.VectorEnv(worlds, 1, navigator=True)
    env.reset()
    reached, failed = ("open", "reached", True, False), ("blocked", "failed", True, False)
    assert outcomes(env, 3) == [reached, failed, reached]
    env = inbye.gym.VectorEnv(worlds[1:], 2, navigator=True)
    with pytest.raises(inbye.InbyeError, match=r"no mission can start.*blocked.*NO_VALID_PATH"):
        env.reset()


def test_environment_is_shared_between_threads() -> None:
    env = inbye.gym.VectorEnv(WORLDS, 3)
    env.reset()
    errors: list[BaseException] = []

    def step() -> None:
        try:
            for _ in range(30):
                env.step(np.zeros((3, 2)))
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=step) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors


def test_environment_applies_a_config_to_the_settings_of_its_worlds() -> None:
    # Worlds of this kind have settings of their own: the pose is that of scans.
    worlds = inbye.bench.worlds(kind="localization")[:1]

    def goal(config: inbye.Config | dict[str, object]) -> list[list[float]]:
        env = inbye.gym.VectorEnv(worlds, 1, config=config, navigator=True)
        env.reset()
        steps = [env.step(np.zeros((1, 2)))[0]["goal"] for _ in range(20)]
        return steps[-1].tolist()

    changes = {"simulation": {"lidar": {"beams": 90}}}
    assert goal(inbye.Config(changes)) == goal(changes)
    assert goal(changes) != goal(changes | {"pose_source": "fixes"})


@pytest.mark.parametrize("navigator", [False, True])
def test_ranges_of_a_mounted_lidar_are_those_from_its_place(*, navigator: bool) -> None:
    mounting = {"mount_x_m": 0.25, "mount_yaw_rad": np.pi / 4}
    config = {"simulation": {"lidar": mounting | {"range_sigma_m": 0.0, "dropout": 0.0}}}
    env = inbye.gym.VectorEnv([box("room")], 1, config=config, navigator=navigator)
    env.reset()
    ranges = env.step(np.zeros((1, 2)))[0]["ranges"][0]
    assert env.single_observation_space["ranges"].high[0] == np.float32(10.0)
    # To the right, ahead, and to the left of the robot.
    np.testing.assert_allclose(ranges[[45, 135, 225]], [0.9, 6.65, 3.9], atol=0.02)


def barn_worlds(folder: Path) -> list[inbye.World]:
    """Return a world of BARN with one post, whose robot is another one than that of the scenes."""
    columns = "dwa_success,dwa_collision,dwa_timeout,dwa_metric"
    row = "3,1,10.0,5.0,0.90,0.10,0.00,0.1500"
    text = f"world,official50,path_length_m,optimal_time_s,{columns}\n{row}\n"
    (folder / "worlds.csv").write_text(text)
    (folder / "worlds").mkdir()
    post = "x_m,y_m,radius_m,kind\n-1.5,6.0,0.075,obstacle\n"
    (folder / "worlds" / "world_003.csv").write_text(post)
    return inbye.bench.worlds(kind="barn", path=folder)


def test_worlds_of_an_environment_have_one_robot(tmp_path: Path) -> None:
    worlds = [WORLDS[0], *barn_worlds(tmp_path)]
    config: dict[str, dict[str, object]] = {}
    alike = [
        ("simulation", "lidar", {"beams": 90, "field_of_view_rad": 4.7, "range_max_m": 10.0}),
        ("local", "control_period_s", 0.1),
        ("robot", "limits", {"min_vel_x": -0.2, "max_vel_x": 0.8, "max_vel_theta": 1.0}),
    ]
    expected = [
        r"simulation\.lidar\.beams is 360 in scenes roadway and 720 in barn 3, .* set it in config",
        r"local\.control_period_s is 0\.1 in scenes roadway and 0\.05 in barn 3",
        r"robot\.limits\.m.* in scenes roadway and .* in barn 3",
    ]
    for (table, key, value), message in zip(alike, expected, strict=True):
        with pytest.raises(inbye.InbyeError, match=rf"^worlds: {message}"):
            inbye.gym.VectorEnv(worlds, 2, config=config)
        config[table] = {key: value}
    inbye.gym.VectorEnv(worlds, 2, config=config).reset()


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"deadline_s": 0.05}, r"navigator\.deadline_s"),
        ({"wait_for_plans": False}, r"navigator\.wait_for_plans = false"),
    ],
)
def test_steps_do_not_depend_on_the_wall_clock(changes: dict[str, object], key: str) -> None:
    with pytest.raises(inbye.InbyeError, match=rf"^{key} makes a mission depend on the wall clock"):
        inbye.gym.VectorEnv(WORLDS, 2, config={"navigator": changes}, navigator=True)


@pytest.mark.parametrize("key", ["simulator", "global_planner", "controller"])
def test_programs_that_environments_do_not_use_are_errors(key: str) -> None:
    config = {key: {"command": ["program"]}}
    with pytest.raises(inbye.InbyeError, match=rf"^{key}\.command: .*leave it out, or"):
        inbye.gym.VectorEnv(WORLDS, 1, config=config)
    with pytest.raises(inbye.InbyeError, match=rf"^{key}\.command: .*leave it out, or"):
        inbye.gym.Env(WORLDS, config=config)


def relative_goal(trace: np.ndarray, tick: int, goal: tuple[float, float]) -> np.ndarray:
    """Return the goal in the frame of the true pose."""
    row = trace[tick]
    away = np.array(goal) - [row["x"], row["y"]]
    sine, cosine = np.sin(row["yaw"]), np.cos(row["yaw"])
    return np.array([[cosine, sine], [-sine, cosine]]) @ away


def test_commands_of_the_navigator_belong_to_the_observation_before() -> None:
    trace = box("box").drive().trace
    env = inbye.gym.VectorEnv([box("box")], 1, navigator=True)
    seen, info = env.reset()
    assert (seen["ranges"] > 0.0).mean() > 0.9
    caller, _ = inbye.gym.VectorEnv([box("box")], 1).reset()
    np.testing.assert_allclose(seen["ranges"], caller["ranges"], atol=0.2)
    np.testing.assert_array_equal(info["command"], np.zeros((1, 2)))
    for tick in range(len(trace) - 1):
        np.testing.assert_allclose(seen["goal"][0], relative_goal(trace, tick, (7.0, 4.0)))
        seen, _, done, _, info = env.step(np.zeros((1, 2)))
        command = (trace["command_vx"][tick], trace["command_vtheta"][tick])
        np.testing.assert_array_equal(info["command"][0], command)
    assert done[0]
    last = relative_goal(trace, len(trace) - 1, (7.0, 4.0))
    np.testing.assert_allclose(info["final_obs"][0]["goal"], last)
    # The next mission has begun, with its first scan.
    assert (seen["ranges"] > 0.0).mean() > 0.9


def test_info_has_the_mission_and_the_command_within_the_limits() -> None:
    env = inbye.gym.VectorEnv([box("a"), box("b")], 3, seeds=[4, 5])
    _, info = env.reset()
    assert info["world"].tolist() == ["a", "b", "a"]
    assert info["seed"].tolist() == [4, 4, 5]
    info = env.step(np.full((3, 2), 100.0))[4]
    np.testing.assert_array_equal(info["command"], np.tile([1.0, 1.0], (3, 1)))
    assert not info["protected"].any()
    single = inbye.gym.Env([box("a")])
    single.reset()
    infos = [single.step(np.array([9.0, 0.0]))[4] for _ in range(100)]
    assert infos[0]["command"].tolist() == [1.0, 0.0]
    # The layer stops the robot before the wall.
    assert [infos[0]["protected"], infos[-1]["protected"]] == [False, True]


def truncated_after(env: gymnasium.Env | gymnasium.vector.VectorEnv, action: np.ndarray) -> int:
    env.reset()
    for step in range(1, 100):
        if np.any(env.step(action)[3]):
            return step
    return 0


def test_missions_are_truncated_at_a_time_and_after_steps() -> None:
    action = np.zeros((2, 2))
    name, number = "inbye/Scene-v0", 2
    short = gymnasium.make(name, time_limit_s=3.0)
    assert truncated_after(short, action[0]) == 30
    assert truncated_after(gymnasium.make(name, max_episode_steps=20), action[0]) == 20
    assert truncated_after(gymnasium.make_vec(name, number, time_limit_s=3.0), action) == 30
    assert truncated_after(gymnasium.make_vec(name, number, max_episode_steps=20), action) == 20
    with pytest.raises(inbye.InbyeError, match="max_episode_steps is 0: it must be at least 1"):
        gymnasium.make_vec(name, number, max_episode_steps=0)
    made = gymnasium.make(name, time_limit_s=3.0, seeds=[0, 1])
    assert '"time_limit_s": 3.0' in made.spec.to_json()


def test_picture_shows_walls_goal_and_robot() -> None:
    env = inbye.gym.Env([box("a")], render_mode="rgb_array")
    robots = inbye.gym.VectorEnv([box("a")], 2, render_mode="rgb_array")
    for unready in (env, robots):
        with pytest.raises(inbye.InbyeError, match="call reset first"):
            unready.render()
    env.reset()
    picture = env.render()
    # The map has 8 m by 5 m, and the robot starts in the lower left.
    assert picture.shape == (320, 512, 3)
    assert picture.dtype == np.uint8
    assert picture[1, 256].tolist() == [0, 0, 0]
    assert picture[160, 100].tolist() == [255, 255, 255]
    robot, goal = picture[319 - 64, 64], picture[319 - 256, 448]
    assert robot[2] > robot[0]
    assert goal[1] > max(goal[0], goal[2])
    before = picture.copy()
    env.step(np.array([1.0, 0.0]))
    env.step(np.array([1.0, 0.0]))
    assert not np.array_equal(before, env.render())
    robots.reset()
    assert [frame.shape for frame in robots.render()] == [(320, 512, 3)] * 2
    with pytest.raises(inbye.InbyeError, match='make the environment with render_mode="rgb_array"'):
        inbye.gym.Env([box("a")]).render()
    with pytest.raises(inbye.InbyeError, match="render_mode is human: only"):
        gymnasium.make("inbye/Scene-v0", render_mode="human")
