"""Free paths of an arm between the compartments of a shelf: time and length against the straight way of the joints.

The kernel runs in a process of its own, and its search in another one; the calls go over TCP.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from itertools import pairwise, product

import numpy as np
import virtualrobot
from virtualrobot import Client, FreePath, Robot

from benchmarks.processes import kernel
from benchmarks.rows import Row, row

ARMS = {
    "iiwa": "package://pybullet_data/kuka_iiwa/model.urdf",
    "panda": "package://pybullet_data/franka_panda/panda.urdf",
}
QUERIES = 20
DEPTH, FRONT = 0.4, 0.42
"""How deep the shelf is, and how far before the robot it begins, in m."""
LEVELS = (0.0, 0.4, 0.8, 1.2)
WIDTH = 0.55
"""Of a compartment; there are two on each level."""
BOARD = 0.02
LIMIT_SECONDS = 60.0
BUDGET = 2.0
"""A path may be twice as long as the straight way, which passes through the boards."""
MEDIAN_MILLISECONDS, WORST_MILLISECONDS = 40.0, 250.0


def run() -> list[Row]:
    """Measure."""
    rows = []
    for name, uri in ARMS.items():
        with kernel("--headless") as (address, _), virtualrobot.connect(address, token="") as client:
            arm = client.load_robot(uri, name="arm")
            build(client)
            if name == "panda":
                arm.move_joints({"panda_finger_joint1": 0.02})
            rows += measured(client, arm, name)
    return rows


def build(client: Client) -> None:
    """Put a shelf before the robot."""
    middle, height = FRONT + DEPTH / 2.0, LEVELS[-1]
    for number, z in enumerate(LEVELS):
        board = virtualrobot.box(DEPTH, 2.0 * WIDTH, BOARD)
        client.scene.add_object(f"board {number}", board, pose=virtualrobot.pose(x=middle, z=z))
    for number, y in enumerate((-WIDTH, 0.0, WIDTH)):
        side = virtualrobot.box(DEPTH, BOARD, height)
        client.scene.add_object(f"side {number}", side, pose=virtualrobot.pose(x=middle, y=y, z=height / 2.0))


def inside(client: Client, arm: Robot, rng: np.random.Generator) -> Iterator[Mapping[str, float]]:
    """Yield configurations with the hand in one compartment after the other, which touch nothing."""
    places = [(side * WIDTH / 2.0, (low + high) / 2.0) for side, (low, high) in product((-1, 1), levels())]
    names = arm.chain_joint_names
    while True:
        for place in rng.permutation(len(places)).tolist():
            y, z = np.array(places[place]) + rng.uniform(-0.05, 0.05, 2)
            x = FRONT + rng.uniform(0.0, 0.08)
            pose = virtualrobot.pose(x, y, z, pitch=np.pi / 2.0)
            for solution in arm.solve_inverse(pose).solutions:
                found = dict(zip(names, np.asarray(solution).tolist(), strict=True))
                if not client.collisions.check({arm.name: found}, detail="first", robots=[arm.name]):
                    yield found
                    break


def levels() -> list[tuple[float, float]]:
    """Return below and above of each level."""
    return list(pairwise(LEVELS))


def measured(client: Client, arm: Robot, name: str) -> list[Row]:
    """Return rows of one arm: each query begins in another compartment than it ends in."""
    there = inside(client, arm, np.random.default_rng(20061))
    # The first search starts its process.
    client.paths.find(arm.name, next(there), start=next(there), time_limit=LIMIT_SECONDS)
    found: list[FreePath] = []
    calls, straight = [], []
    for seed in range(QUERIES):
        start, goal = next(there), next(there)
        began = time.perf_counter()
        found.append(client.paths.find(arm.name, goal, start=start, seed=seed, time_limit=LIMIT_SECONDS))
        calls.append(1e3 * (time.perf_counter() - began))
        client.scene.set_joint_positions(arm.name, start)
        began = time.perf_counter()
        plan = arm.plan(arm.ptp(goal))
        straight.append((1e3 * (time.perf_counter() - began), plan.duration))
    lengths = [(path.length, path.straight_length) for path in found]
    durations = [(path.duration, one[1]) for path, one in zip(found, straight, strict=True)]
    free = sum(path.straight for path in found)
    note = f"median of {QUERIES}, of which {free} straight"
    title, ptp = f"path in a shelf, {name}", "a straight PTP"
    planning = float(np.median([one[0] for one in straight]))
    length, straight_length = np.mean(lengths, axis=0).tolist()
    motion, straight_motion = np.mean(durations, axis=0).tolist()
    median, worst = float(np.median(calls)), max(calls)
    return [
        row(f"{title}: finding it", median, MEDIAN_MILLISECONDS, "the budget", "ms", 1.0, note),
        row(f"{title}: finding it", worst, WORST_MILLISECONDS, "the budget", "ms", 1.0, f"the longest of {QUERIES}"),
        row(f"{title}: finding it", median, planning, f"planning {ptp}", "ms", None, note),
        row(f"{title}: its length, mean", length, straight_length, ptp, "rad", BUDGET),
        row(f"{title}: the motion, mean", motion, straight_motion, ptp, "s", None),
    ]


if __name__ == "__main__":
    for result in run():
        print(result)
