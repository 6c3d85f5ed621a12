"""Ctrl-C while Rust works."""

import signal
import subprocess
import sys
import time

import pytest

# A drive of minutes: the goal is far, and each decision has a million samples.
DRIVE = """
cells = np.zeros((40, 8000), np.int8)
cells[[0, -1]] = 100
cells[:, [0, -1]] = 100
slow = {"local": {"vx_samples": 1024, "vtheta_samples": 1024}}
world = inbye.World(inbye.Map(cells, 0.1), (1.0, 2.0, 0.0), (799.0, 2.0))
started()
world.drive(config=slow)
"""
BENCH = """
started()
inbye.bench.{function}({{"seeds": list(range(1000)), "worlds": [{{"kind": "scenes"}}]}}, jobs=2)
"""
# Programs that never answer.
SILENT = """
scene, *_ = inbye.bench.worlds(kind="scenes")
silent = {{"controller": {{"command": ["sleep", "60"]}}}}
started()
{call}
"""
RESET = """
import inbye.gym
robots = inbye.gym.VectorEnv(inbye.bench.worlds(kind="scenes"), 5000)
started()
robots.reset()
"""
PROGRAM = """
import inbye
import numpy as np

def started() -> None:
    print("started", flush=True)

"""


@pytest.mark.parametrize(
    "action",
    [
        DRIVE,
        BENCH.format(function="run"),
        BENCH.format(function="compare"),
        SILENT.format(call="scene.drive(config=silent)"),
        SILENT.format(call='inbye.bench.run({"configs": {"silent": silent}})'),
        RESET,
    ],
)
def test_ctrl_c_ends_a_drive_and_an_experiment_at_once(action: str) -> None:
    program = subprocess.Popen(
        [sys.executable, "-c", PROGRAM + action],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert program.stdout is not None
        assert program.stdout.readline() == "started\n"
        time.sleep(1.0)
        assert program.poll() is None
        program.send_signal(signal.SIGINT)
        _, error = program.communicate(timeout=30)
    finally:
        program.kill()
    assert error.rstrip().endswith("KeyboardInterrupt")
