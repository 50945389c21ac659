"""The component `closed_form` against bare EAIK on the same arms and poses: all branches, checked, named and turned.

Bare means what a Python program gets from the library: `calculate_IK` and the arrays `Q` and `is_LS` of its answer.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from eaik.pybindings.EAIK import Robot
from virtualrobot_plugins.closed_form.component import ClosedFormKinematics
from virtualrobot_plugins.closed_form.geometry import axes_of
from virtualrobot_sdk.kinematics import Floats, InverseOptions, SerialChain
from virtualrobot_sdk.testing.chains import puma560, ur5

from benchmarks.rows import Row, row

POSES = 500
ROUNDS = 7
BUDGET = 2.0


def microseconds(call: Callable[[Floats], object], targets: list[Floats]) -> float:
    """Return the time of a call: the mean over the poses, the best of some rounds."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for target in targets:
            call(target)
        times.append(time.perf_counter() - start)
    return min(times) / len(targets) * 1e6


def bare(chain: SerialChain) -> Callable[[Floats], object]:
    """Return the library's own answer to a pose of an arm."""
    axes = axes_of(chain)
    offsets = np.diff(np.vstack([np.zeros(3), axes.point, axes.base_t_tip[:3, 3]]), axis=0)
    robot = Robot(axes.direction.T, offsets.T, axes.base_t_tip[:3, :3], [], True)

    def solve(target: Floats) -> object:
        found = robot.calculate_IK(target)
        return found.Q, found.is_LS

    return solve


def run() -> list[Row]:
    """Measure and return the rows."""
    rng = np.random.default_rng()
    without = np.full(6, -np.inf), np.full(6, np.inf)
    arms = {
        "Puma 560": puma560(),
        "Puma 560, no limits": puma560()._replace(lower=without[0], upper=without[1]),
        "UR5, no limits": ur5(np.inf),
    }
    rows = []
    for name, chain in arms.items():
        kinematics = ClosedFormKinematics(chain)
        lower, upper = np.maximum(chain.lower, -np.pi), np.minimum(chain.upper, np.pi)
        targets = [kinematics.forward(q)[-1] for q in rng.uniform(lower, upper, (POSES, 6))]
        ours, peer = microseconds(kinematics.inverse, targets), microseconds(bare(chain), targets)
        rows.append(row(f"all branches, {name}", ours, peer, "bare EAIK", "µs", BUDGET))
    return [*rows, _turned(rng)]


def _turned(rng: np.random.Generator) -> Row:
    """Return what 512 solutions cost: a UR5 with a whole turn to both sides, nearest to a seed first."""
    chain = ur5()
    kinematics = ClosedFormKinematics(chain)
    options = InverseOptions(seed=rng.uniform(-1.0, 1.0, 6))
    targets = [kinematics.forward(q)[-1] for q in rng.uniform(chain.lower, chain.upper, (POSES // 5, 6))]
    ours = microseconds(lambda target: kinematics.inverse(target, options), targets)
    return row("all branches with all turns, UR5", ours, microseconds(bare(chain), targets), "bare EAIK", "µs", None)
