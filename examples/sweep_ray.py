#!/usr/bin/env python3
"""Runs the cells of an inbye sweep on a Ray cluster.

    pip install ray
    python examples/sweep_ray.py sweep.toml --out cells            # a cluster of this machine's cores
    python examples/sweep_ray.py sweep.toml --out cells --address auto
    inbye sweep merge cells

Every node needs the program (--inbye) and the plan with its worlds under the same paths; --ship FOLDER sends a folder
along, from which relative paths count on every node. Results come back to this machine, which writes them; with --shared
the nodes write them into --out themselves, a folder that all of them see.

A task whose worker is lost is given to another one. The script may be killed and started again: cells that have their
result are not run again. A latency cell takes all CPUs of a node, and runs after the others.
"""

import argparse
import json
import os
import subprocess
import sys

import ray


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("plan", help="the plan, TOML")
    parser.add_argument("--out", required=True, help="folder of the results")
    parser.add_argument("--inbye", default="inbye", help="the program, on every node [default: inbye]")
    parser.add_argument("--address", help="of the cluster, as `ray.init` has it [default: a cluster here]")
    parser.add_argument("--cpus", type=int, help="cells at a time in a cluster here [default: all cores]")
    parser.add_argument("--ship", metavar="FOLDER", help="send this folder to all nodes")
    parser.add_argument("--shared", action="store_true", help="all nodes see --out, and write there")
    parser.add_argument("--retries", type=int, default=5, help="how often a lost cell is begun again [default: 5]")
    return parser.parse_args()


def run_cell(inbye, plan, key, out):
    """Runs one cell. Returns the content of its file, or nothing if the folder has it already."""
    command = [inbye, "sweep", plan, "--cell", key]
    if out is not None:
        command += ["--out", out, "--quiet"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if done.returncode != 0:
        said = (done.stderr or done.stdout).decode(errors="replace").strip()
        raise RuntimeError(f"cell {key}: exit status {done.returncode}: {said}")
    return None if out is not None else done.stdout


def keep(out, key, held):
    """Writes a cell's file as a whole or not at all."""
    file = os.path.join(out, "cells", f"{key}.json")
    with open(file + ".part", "wb") as part:
        part.write(held)
        part.flush()
        os.fsync(part.fileno())
    os.replace(file + ".part", file)


class Progress:
    """One line on a terminal, some lines elsewhere."""

    def __init__(self, total, done):
        self.total, self.done, self.every = total, done, max(1, total // 10)
        self.tell(True)

    def step(self):
        self.done += 1
        self.tell(self.done % self.every == 0 or self.done == self.total)

    def tell(self, is_due):
        if sys.stderr.isatty():
            filled = 40 * self.done // max(1, self.total)
            bar = "=" * filled + " " * (40 - filled)
            end = "\n" if self.done == self.total else ""
            print(f"\r[{bar}] {self.done}/{self.total} cells", end=end, file=sys.stderr, flush=True)
        elif is_due:
            print(f"{self.done}/{self.total} cells", file=sys.stderr, flush=True)


def run_all(cells, task, window, given, progress):
    """Runs cells, at most `window` at a time. Returns the errors of those without a result."""
    waiting, running, wrong = list(reversed(cells)), {}, []
    while waiting or running:
        while waiting and len(running) < window:
            key = waiting.pop()["key"]
            running[task.remote(given.inbye, given.plan, key, given.nodes_out)] = key
        ready, _ = ray.wait(list(running), num_returns=1)
        for one in ready:
            key = running.pop(one)
            try:
                held = ray.get(one)
            except Exception as error:  # Whatever it is, the other cells are run.
                wrong.append(str(error).strip().splitlines()[-1])
                continue
            if held is not None:
                keep(given.out, key, held)
            progress.step()
    return wrong


def main():
    given = arguments()
    given.out = os.path.abspath(given.out)
    if given.ship:
        os.chdir(given.ship)
    else:
        given.plan = os.path.abspath(given.plan)
    given.nodes_out = given.out if given.shared else None
    command = [given.inbye, "sweep", given.plan, "--list", "--out", given.out]
    listed = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if listed.returncode != 0:
        return listed.returncode
    cells = [json.loads(line) for line in listed.stdout.splitlines()]
    open_cells = [cell for cell in cells if not cell["done"]]
    progress = Progress(len(cells), len(cells) - len(open_cells))
    if not open_cells:
        return 0

    runtime = {"working_dir": "."} if given.ship else None
    here = {"num_cpus": given.cpus} if given.address is None else {}
    ray.init(
        address=given.address,
        runtime_env=runtime,
        include_dashboard=False if given.address is None else None,
        log_to_driver=False,
        logging_level="ERROR",
        **here,
    )
    cpus = [node["Resources"].get("CPU", 0) for node in ray.nodes() if node["Alive"]]
    # A worker that is lost is no error of the cell; an exit status is, and would be the same again.
    task = ray.remote(max_retries=given.retries, num_cpus=1)(run_cell)
    alone = ray.remote(max_retries=given.retries, num_cpus=max(cpus))(run_cell)
    among_others = [cell for cell in open_cells if not cell["latency"]]
    by_themselves = [cell for cell in open_cells if cell["latency"]]
    wrong = run_all(among_others, task, 2 * int(sum(cpus)), given, progress)
    wrong += run_all(by_themselves, alone, len(cpus), given, progress)
    ray.shutdown()
    for said in wrong[:5]:
        print(said, file=sys.stderr)
    if wrong:
        print(f"{len(wrong)} cells have no result; run this again for them", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
