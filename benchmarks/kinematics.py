"""Kinematics against named peers in the same run: forward against pinocchio, inverse against TRAC-IK and others.

Run alone (`python benchmarks/kinematics.py`) it prints its rows; poses are drawn by a fresh seed, which it prints.
"""

from __future__ import annotations

import secrets
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pybullet_data
import virtualrobot_plugins
from numba import njit
from scipy.spatial.transform import Rotation
from trac_ik import TracIK
from virtualrobot_kernel.numeric.forest import FIXED, REVOLUTE, forward_forest, topological_order
from virtualrobot_plugins.chain.component import ChainKinematics
from virtualrobot_sdk.kinematics import InverseOptions, SerialChain

POSES = 1000
DATA = Path(pybullet_data.getDataPath())
MODELS = Path(virtualrobot_plugins.__file__).parent / "models"


class Arm(NamedTuple):
    """A serial arm in a URDF file, whose first `axes` joints move the link `tip`."""

    name: str
    urdf: Path
    tip: str
    axes: int


ARMS = (
    Arm("iiwa 14", DATA / "kuka_iiwa" / "model.urdf", "lbr_iiwa_link_7", 7),
    Arm("Panda", DATA / "franka_panda" / "panda.urdf", "panda_link8", 7),
    Arm("xArm6", DATA / "xarm" / "xarm6_robot.urdf", "link6", 6),
    Arm("Puma 560", MODELS / "puma560.urdf", "tool0", 6),
)


def chain_of(arm: Arm) -> SerialChain:
    """Return the arm as pinocchio reads it, so that both sides compute the same robot."""
    model = pinocchio.buildModelFromUrdf(str(arm.urdf))
    data = model.createData()
    pinocchio.computeJointJacobians(model, data, pinocchio.neutral(model))
    last = model.frames[model.getFrameId(arm.tip)]
    n = arm.axes
    # Rounded, since a zero that came out as 1e-40 makes the Robotics Toolbox turn the joint's frame.
    local = [pinocchio.getJointJacobian(model, data, i + 1, pinocchio.LOCAL)[3:, i].round(12) for i in range(n)]
    return SerialChain(
        pre=np.array([model.jointPlacements[i + 1].homogeneous for i in range(n)]),
        axis=np.array(local) + 0.0,
        joint_type=np.full(n, REVOLUTE, np.int8),
        q_index=np.arange(n, dtype=np.int32),
        multiplier=np.ones(n),
        offset=np.zeros(n),
        post=np.array(last.placement.homogeneous),
        lower=np.array(model.lowerPositionLimit[:n]),
        upper=np.array(model.upperPositionLimit[:n]),
        joint_names=tuple(f"joint {i + 1}" for i in range(n)),
    )


def row(name: str, ours: float, peer: float, peer_name: str, unit: str, budget: float | None) -> dict[str, Any]:
    """Return a result: two measured values, their ratio, and the largest ratio allowed (None: told, not judged)."""
    ratio = ours / peer if peer else float(ours > 0)
    return {
        "name": name,
        "ours": ours,
        "peer": peer,
        "peer_name": peer_name,
        "unit": unit,
        "ratio": ratio,
        "budget": budget,
    }


def skipped(name: str, peer_name: str, why: str) -> dict[str, Any]:
    """Return a row that says why nothing was measured."""
    return {
        "name": f"{name}: skipped, {why}",
        "ours": None,
        "peer": None,
        "peer_name": peer_name,
        "unit": "",
        "ratio": None,
        "budget": None,
    }


def microseconds(call: Callable[[], object], calls: int, repeats: int = 9) -> float:
    """Return the time of one call: the smallest mean of several series."""
    call()
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(calls):
            call()
        best = min(best, (time.perf_counter() - start) / calls)
    return float(best) * 1e6


def forest_of(chain: SerialChain, arms: int) -> tuple[np.ndarray, ...]:
    """Return the arguments of `forward_forest` for several equal arms, each with its tip as a fixed node."""
    n = len(chain.pre) + 1
    one = np.arange(-1, n - 1)
    parent = np.concatenate([np.where(one < 0, -1, one + n * i) for i in range(arms)]).astype(np.int32)
    joints = np.concatenate([np.append(np.arange(n - 1) + (n - 1) * i, -1) for i in range(arms)]).astype(np.int32)
    rows = n * arms
    return (
        topological_order(parent),
        parent,
        np.tile(np.append(chain.joint_type, np.int8(FIXED)), arms),
        np.tile(np.vstack([chain.axis, np.zeros(3)]), (arms, 1)),
        joints,
        np.ones(rows),
        np.zeros(rows),
        np.tile(np.concatenate([chain.pre, chain.post[None]]), (arms, 1, 1)),
        np.tile((chain.lower + chain.upper) / 2 + 0.1, arms),
        np.empty((rows, 4, 4)),
    )


def forward_rows() -> list[dict[str, Any]]:
    """Return forward kinematics of one iiwa, as one call and inside compiled code, and of the tick of 20 arms."""
    arm = ARMS[0]
    chain = chain_of(arm)
    model = pinocchio.buildModelFromUrdf(str(arm.urdf))
    data = model.createData()
    q = (chain.lower + chain.upper) / 2 + 0.1
    theirs = microseconds(lambda: pinocchio.forwardKinematics(model, data, q), 20000)

    def read_poses() -> list[np.ndarray]:
        pinocchio.forwardKinematics(model, data, q)
        return [data.oMi[i].homogeneous for i in range(1, arm.axes + 1)]

    read = microseconds(read_poses, 2000)
    one, twenty = forest_of(chain, 1), forest_of(chain, 20)
    called = microseconds(lambda: forward_forest(*one), 20000)
    compiled_pass = forward_forest.dispatcher

    @njit
    def loop(times: int, arrays: tuple) -> None:
        for _ in range(times):
            compiled_pass(*arrays)

    inside = microseconds(lambda: loop(1000, one), 20) / 1000.0
    tick = microseconds(lambda: forward_forest(*twenty), 2000)
    name = "forward kinematics, 7 axes"
    return [
        row(f"{name}, bare pass in compiled code", inside, theirs, "pinocchio.forwardKinematics", "µs", 1.5),
        row(f"{name}, from Python, poses as arrays", called, read, "pinocchio, poses as arrays", "µs", 1.5),
        row("forward pass of a tick, 20 arms of 7 axes", tick, 500.0, "budget of 0.5 ms", "µs", 1.0),
    ]


class Timing(NamedTuple):
    """What one solver made of the same poses."""

    median: float
    p99: float
    unsolved: int


Solver = Callable[[np.ndarray], np.ndarray | None]


def is_solution(kinematics: ChainKinematics, q: np.ndarray | None, target: np.ndarray) -> bool:
    """Tell whether q is within limits and puts the tip within 1 mm and 0.1 degrees of the target."""
    if q is None or not np.isfinite(q).all():
        return False
    if (q < kinematics.lower - 1e-6).any() or (q > kinematics.upper + 1e-6).any():
        return False
    reached = kinematics.forward(q)[-1]
    # Of a rotation by a, the Frobenius norm of R - I is 2 sqrt(2) sin(a / 2).
    chord = np.linalg.norm(reached[:3, :3] - target[:3, :3]) / (2 * np.sqrt(2))
    angle = 2 * np.arcsin(min(chord, 1.0))
    return bool(np.linalg.norm(reached[:3, 3] - target[:3, 3]) < 1e-3 and np.degrees(angle) < 0.1)


def time_solvers(kinematics: ChainKinematics, targets: np.ndarray, solvers: dict[str, Solver]) -> dict[str, Timing]:
    """Return median and p99 (µs) and the number of unsolved poses of each solver, one solver after the other."""
    results: dict[str, Timing] = {}
    for name, solve in solvers.items():
        solve(targets[0])
        times: list[float] = []
        answers: list[np.ndarray | None] = []
        for target in targets:
            start = time.perf_counter()
            answers.append(solve(target))
            times.append((time.perf_counter() - start) * 1e6)
        unsolved = sum(not is_solution(kinematics, q, target) for q, target in zip(answers, targets, strict=True))
        results[name] = Timing(float(np.median(times)), float(np.quantile(times, 0.99)), unsolved)
    return results


def bare_urdf(chain: SerialChain, path: Path) -> None:
    """Write the chain alone as a URDF file with links 0 .. n + 1, as every peer reads it right.

    TRAC-IK takes the limits of the Panda in pybullet_data, which has soft ones beside them, for 0.
    """
    n = len(chain.pre)
    lines = ["<robot name='arm'>", *(f"<link name='link{i}'/>" for i in range(n + 2))]
    for i, pose in enumerate([*chain.pre, chain.post]):
        kind = "revolute" if i < n else "fixed"
        xyz = " ".join(repr(float(value)) for value in pose[:3, 3])
        rpy = " ".join(repr(float(value)) for value in Rotation.from_matrix(pose[:3, :3]).as_euler("xyz"))
        lines += [f"<joint name='joint{i}' type='{kind}'>", f"<parent link='link{i}'/><child link='link{i + 1}'/>"]
        lines.append(f"<origin xyz='{xyz}' rpy='{rpy}'/>")
        if i < n:
            axis = " ".join(repr(float(value)) for value in chain.axis[i])
            limits = f"lower='{float(chain.lower[i])!r}' upper='{float(chain.upper[i])!r}'"
            lines.append(f"<axis xyz='{axis}'/><limit {limits} effort='100' velocity='10'/>")
        lines.append("</joint>")
    path.write_text("\n".join([*lines, "</robot>"]))


def tracik(urdf: Path, start: np.ndarray, timeout: float) -> Solver:
    """Return TRAC-IK in its mode Speed."""
    solver = TracIK("link0", f"link{len(start) + 1}", str(urdf), timeout=timeout, epsilon=1e-5, solver_type="Speed")
    return lambda target: solver.ik(target[:3, 3], target[:3, :3], start)


def toolbox(urdf: Path, start: np.ndarray) -> Solver | None:
    """Return the Levenberg-Marquardt solver of the Robotics Toolbox for Python, or None where it is not installed."""
    try:
        from roboticstoolbox.robot.Robot import Robot  # pyright: ignore[reportMissingImports]  an optional peer
    except ImportError:
        return None
    elements = Robot.URDF(str(urdf)).ets(start="link0", end=f"link{len(start) + 1}")

    def solve(target: np.ndarray) -> np.ndarray:
        # Its default tolerance of 1e-6 on the squared error misses 1 mm and 0.1 degrees in some per cent of cases.
        answer = elements.ik_LM(target, q0=start, tol=1e-8, joint_limits=True, ilimit=30, slimit=1000)
        return np.asarray(answer.q)

    return solve


def inverse_rows(arm: Arm, rng: np.random.Generator, folder: Path) -> list[dict[str, Any]]:
    """Return times and failures on poses drawn from joints within limits, every solver starting at mid-range."""
    chain = chain_of(arm)
    kinematics = ChainKinematics(chain)
    joints = rng.uniform(chain.lower, chain.upper, (POSES, arm.axes))
    targets = np.array([kinematics.forward(q)[-1] for q in joints])
    start = (chain.lower + chain.upper) / 2
    options = InverseOptions(seed=start)
    urdf = folder / f"{arm.tip}.urdf"
    bare_urdf(chain, urdf)

    def ours(target: np.ndarray) -> np.ndarray | None:
        solutions = kinematics.inverse(target, options).solutions
        return solutions[0] if len(solutions) else None

    solvers: dict[str, Solver] = {
        "ours": ours,
        "TRAC-IK, 5 ms": tracik(urdf, start, 0.005),
        "TRAC-IK, 50 ms": tracik(urdf, start, 0.05),
    }
    title = f"inverse kinematics, {arm.name}"
    rows: list[dict[str, Any]] = []
    peer = toolbox(urdf, start)
    if peer is None:
        rows.append(skipped(title, "roboticstoolbox ik_LM", "roboticstoolbox is not installed (extra `bench`)"))
    else:
        solvers["roboticstoolbox ik_LM"] = peer
    results = time_solvers(kinematics, targets, solvers)
    mine = results.pop("ours")
    rows.insert(0, row(f"{title}, unsolved", mine.unsolved, POSES, "poses drawn", "poses", 0.0))
    for name, theirs in results.items():
        judged = name.startswith("TRAC-IK")
        rows += [
            row(f"{title}, median", mine.median, theirs.median, name, "µs", 0.1 if judged else None),
            row(f"{title}, p99", mine.p99, theirs.p99, name, "µs", 1.0 if judged else None),
            row(f"{title}, unsolved of {POSES}", mine.unsolved, theirs.unsolved, name, "poses", None),
        ]
    return rows


def run() -> list[dict[str, Any]]:
    """Measure everything and return the rows."""
    seed = secrets.randbits(32)
    print(f"kinematics: poses drawn by seed {seed}")
    rng = np.random.default_rng(seed)
    rows = forward_rows()
    with tempfile.TemporaryDirectory() as folder:
        for arm in ARMS:
            rows += inverse_rows(arm, rng, Path(folder))
    return rows


if __name__ == "__main__":
    for result in run():
        if result["ours"] is None:
            print(result["name"])
        else:
            print(
                f"{result['name']:58s} ours {result['ours']:9.3f} | {result['peer_name']:28s} {result['peer']:9.3f} "
                f"{result['unit']:5s} | ratio {result['ratio']:7.3f}, budget {result['budget']}"
            )
