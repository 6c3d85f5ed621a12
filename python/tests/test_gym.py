"""Gymnasium's environments."""

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
    with pytest.raises(inbye.InbyeError, match="finite"):
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


def test_threads_and_seeds_repeat_every_step() -> None:
    def steps(threads: int, seed: int) -> list[np.ndarray]:
        env = inbye.gym.VectorEnv(WORLDS, 4, seeds=range(3), threads=threads)
        env.reset(seed=seed)
        actions = np.random.default_rng(1).uniform(-0.5, 0.5, (40, 4, 2))
        return [env.step(action)[0]["ranges"] for action in actions]

    one, two, other = steps(1, 7), steps(2, 7), steps(1, 8)
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)
