"""Gymnasium environments: one simulated robot, or many that are stepped together in Rust.

The agent sees the ranges of the lidar (nothing within range reads as the longest one, no
measurement as zero), the goal in the robot's frame, and the velocity. The ranges are those of the
beams from the place of the lidar, counter-clockwise, with the lidar's noise. Goal and velocity are
the true ones of the simulation, not the robot's estimates. Its action is speed and turn rate, which
the base clamps to its limits; the protective layer of the simulation stays below it. The reward is
the progress along the first global path, metres, plus 10 at the goal and minus 10 at contact.

An observation is made at the end of a step. ``info["command"]`` is what the robot was commanded
during that step, within the limits of the base, and ``info["protected"]`` says whether the
protective layer then changed it: the command belongs to the observation before.

With ``render_mode="rgb_array"``, ``render`` returns a picture.

A mission is truncated at the time limit of its world: 3600 s, which is 36,000 steps of 0.1 s, for
the scenes. ``time_limit_s`` of :func:`make` and of ``inbye.bench.worlds`` sets it.

A goal with a yaw is reached only when the robot stands in that direction too. The observation does
not have this yaw: give goals without one, or add it, for example with a wrapper.

All worlds of an environment must have the same lidar (beams, field of view, range, mount), control
period and speed limits, because they share one observation space and one action space. Worlds of
different kinds may differ in these settings: then set them alike with ``config``.

Importing this module registers ``inbye/Scene-v0``, the built-in scenes, and ``inbye/Barn-v0`` and
``inbye/DynaBarn-v0``, which need ``path``, the folder of the benchmark's worlds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, SupportsIndex

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from inbye import _native, bench

if TYPE_CHECKING:
    from collections.abc import Sequence

    from inbye._native import Settings, World

__all__ = ["Env", "VectorEnv", "make", "make_vector"]

Observation = dict[str, NDArray[Any]]
Action = NDArray[np.float64]
Picture = NDArray[np.uint8]

# The only mode of rendering.
_PICTURES = "rgb_array"

# What is known of a mission that has ended.
_ENDED = ("outcome", "world", "seed", "time_s", "digest", "reason")


def _observation(seen: _native.SeenArrays) -> Observation:
    ranges, goals, velocities = seen
    return {"ranges": ranges, "goal": goals, "velocity": velocities}


def _first(seen: _native.SeenArrays) -> Observation:
    return {name: values[0] for name, values in _observation(seen).items()}


def _spaces(
    native: _native.Environments,
) -> tuple[spaces.Space[Observation], spaces.Space[Action]]:
    least, fastest, turn = native.speed_limits
    far = np.full(2, np.inf)
    # Gymnasium's own types say less: any arrays.
    observation: Any = spaces.Dict(
        {
            "ranges": spaces.Box(0.0, native.range_max, (native.beams,), np.float32),
            "goal": spaces.Box(-far, far, dtype=np.float64),
            "velocity": spaces.Box(-far, far, dtype=np.float64),
        }
    )
    action: Any = spaces.Box(np.array([least, -turn]), np.array([fastest, turn]), dtype=np.float64)
    return observation, action


def _check_options(options: dict[str, Any] | None) -> None:
    if options:
        keys = ", ".join(map(str, options))
        raise _native.InbyeError(f"options: {keys} has no effect here: leave it out")


def _metadata(native: _native.Environments, mode: str | None) -> dict[str, Any]:
    """Return what Gymnasium wants to know about pictures."""
    if mode not in (None, _PICTURES):
        raise _native.InbyeError(f'render_mode is {mode}: only "{_PICTURES}" is possible')
    return {"render_modes": [_PICTURES], "render_fps": round(1.0 / native.period_s)}


def _pictures(native: _native.Environments, mode: str | None) -> list[Picture]:
    if mode is None:
        raise _native.InbyeError(f'render: make the environment with render_mode="{_PICTURES}"')
    return native.pictures()


class VectorEnv(gymnasium.vector.VectorEnv[Observation, Action, NDArray[Any]]):
    """Many robots on the missions of all worlds and seeds in turn.

    With ``navigator`` inbye drives and the actions count for nothing: ``info["command"]`` has its
    velocities, which it decided from the scan of the observation before. It knows pose and velocity
    only by its estimates, while goal and velocity of an observation are the true ones.

    A robot whose mission ends begins the next one in the same step; what it saw last is in
    ``info["final_obs"]``, and ``info["final_info"]`` has the outcome, world, seed, time and, for
    inbye, the digest of its trace and the reason of a failure, which are those of a single run.
    ``info["world"]`` and ``info["seed"]`` of ``reset`` and of such a step are those of the missions
    that go on. On a GPU, ``engine="gpu"``, the decisions of all robots are evaluated in batches. A
    mission that cannot start ends in its first step, with the outcome "failed" or "error"; if none
    can, ``reset`` or ``step`` raises.

    ``max_episode_steps`` truncates missions after this many steps. ``threads`` is 1 by default, and
    on a GPU the number of robots, up to 256. An environment with several threads works only in the
    process that made it, not in one that ``os.fork`` makes later.
    """

    def __init__(
        self,
        worlds: Sequence[World],
        num_envs: int,
        *,
        seeds: Sequence[SupportsIndex] = range(1),
        config: Settings | None = None,
        navigator: bool = False,
        engine: str = "cpu",
        threads: int | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        self._native = _native.Environments(
            list(worlds),
            num_envs,
            seeds=list(seeds),
            config=config,
            navigator=navigator,
            engine=engine,
            threads=threads,
            max_steps=max_episode_steps,
        )
        self.num_envs = num_envs
        self.render_mode = render_mode
        autoreset = {"autoreset_mode": AutoresetMode.SAME_STEP}
        self.metadata = _metadata(self._native, render_mode) | autoreset
        observation, action = _spaces(self._native)
        batch = gymnasium.vector.utils.batch_space
        self.single_observation_space, self.single_action_space = observation, action
        self.observation_space = batch(observation, num_envs)
        self.action_space = batch(action, num_envs)
        self._jobs = len(worlds) * len(seeds)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Start the missions from the first one on, or from one that the seed draws.

        Of a list of seeds the first one counts. There are no options: all robots are reset.
        """
        _check_options(options)
        if isinstance(seed, list):
            if len(seed) != self.num_envs:
                raise _native.InbyeError(
                    f"seed has {len(seed)} numbers: give one for each of the {self.num_envs} robots"
                )
            seed = seed[0]
        super().reset(seed=seed)
        first = 0 if seed is None else int(self.np_random.integers(self._jobs))
        return _observation(self._native.reset(first)), self._info() | self._missions()

    def step(
        self, actions: Action
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Drive every robot for one control period."""
        seen, rewards, ends, finished = self._native.step(actions)
        info = self._info()
        if finished:
            info |= self._missions()
            self._add_final(info, ends > 0, finished)
        return _observation(seen), rewards, ends == 1, ends == 2, info

    def render(self) -> tuple[Picture, ...]:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Draw each robot on its mission from above, as :meth:`Env.render` does."""
        return tuple(_pictures(self._native, self.render_mode))

    def _info(self) -> dict[str, Any]:
        commands, is_protected = self._native.commands
        return {"command": commands, "protected": is_protected}

    def _missions(self) -> dict[str, Any]:
        worlds, seeds = zip(*self._native.missions, strict=True)
        return {"world": np.array(worlds, object), "seed": np.array(seeds, np.uint64)}

    def _add_final(
        self,
        info: dict[str, Any],
        over: NDArray[np.bool_],
        finished: Sequence[_native.Finished],
    ) -> None:
        """Add how missions ended, in the arrays of Gymnasium's convention."""
        final = np.full(self.num_envs, None, object)
        columns: dict[str, NDArray[Any]] = {
            name: np.full(self.num_envs, None, object) for name in _ENDED
        }
        for index, ended, last in finished:
            final[index] = _first(last)
            for name, value in zip(_ENDED, ended, strict=True):
                columns[name][index] = value
        info["final_obs"], info["_final_obs"] = final, over
        masks = {f"_{name}": over for name in _ENDED}
        info["final_info"], info["_final_info"] = columns | masks, over


class Env(gymnasium.Env[Observation, Action]):
    """One robot on the missions of all worlds and seeds in turn, a new one at each reset.

    A mission that cannot start ends in its first step, with the outcome "failed" or "error".
    """

    def __init__(
        self,
        worlds: Sequence[World],
        *,
        seeds: Sequence[SupportsIndex] = range(1),
        config: Settings | None = None,
        render_mode: str | None = None,
    ) -> None:
        self._native = _native.Environments(
            list(worlds), 1, seeds=list(seeds), config=config, autoreset=False
        )
        self.render_mode = render_mode
        self.metadata = _metadata(self._native, render_mode)
        self.observation_space, self.action_space = _spaces(self._native)
        self._jobs, self._next = len(worlds) * len(seeds), 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start the next mission, or one that the seed draws. There are no options."""
        _check_options(options)
        super().reset(seed=seed)
        if seed is not None:
            self._next = int(self.np_random.integers(self._jobs))
        seen = self._native.reset(self._next)
        self._next += 1
        world, mission_seed = self._native.missions[0]
        return _first(seen), {"world": world, "seed": mission_seed}

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for one control period. Raises after the end of an episode."""
        seen, rewards, ends, finished = self._native.step(np.reshape(action, (1, -1)))
        end = int(ends[0])
        commands, is_protected = self._native.commands
        info: dict[str, Any] = {"command": commands[0], "protected": bool(is_protected[0])}
        for _, ended, _ in finished:
            info |= zip(_ENDED, ended, strict=True)
        return _first(seen), float(rewards[0]), end == 1, end == 2, info

    def render(self) -> Picture:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Draw the robot on its mission from above: rows of pixels, the longest side has 512.

        The first global path is light blue, the goal green, the robot blue with a yellow nose, and
        what the lidar sees red.
        """
        (picture,) = _pictures(self._native, self.render_mode)
        return picture


def _worlds(kind: str, path: str | None, time_limit_s: float | None) -> list[World]:
    group = {"kind": kind, "path": path, "time_limit_s": time_limit_s}
    given: dict[str, Any] = {key: value for key, value in group.items() if value is not None}
    return bench.worlds(**given)


def make(
    kind: str,
    path: str | None = None,
    *,
    time_limit_s: float | None = None,
    **options: Any,  # noqa: ANN401
) -> Env:
    """Make an environment in worlds of a kind, with the folder of their files.

    ``time_limit_s`` is for the kinds that have no limit of their own. Give ``seeds`` as a list for
    ``env.spec.to_json()``, because JSON has no ranges.
    """
    return Env(_worlds(kind, path, time_limit_s), **options)


def make_vector(
    kind: str,
    path: str | None = None,
    num_envs: int = 1,
    *,
    time_limit_s: float | None = None,
    **options: Any,  # noqa: ANN401
) -> VectorEnv:
    """Make many environments in worlds of a kind, as :func:`make` does."""
    return VectorEnv(_worlds(kind, path, time_limit_s), num_envs, **options)


for _name, _kind in (("Scene", "scenes"), ("Barn", "barn"), ("DynaBarn", "dynabarn")):
    gymnasium.register(  # pyright: ignore[reportUnknownMemberType]
        id=f"inbye/{_name}-v0",
        entry_point="inbye.gym:make",
        vector_entry_point="inbye.gym:make_vector",
        kwargs={"kind": _kind},
    )
