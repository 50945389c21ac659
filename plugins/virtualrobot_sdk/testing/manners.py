"""Laws about how a component treats its caller: refusals, equal answers to equal questions, arguments, memory."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from virtualrobot_sdk.errors import ArgumentError, ComponentFault
from virtualrobot_sdk.kinematics import Floats, InverseOptions, InverseResult, SerialChain
from virtualrobot_sdk.selfcheck import POSE_TOLERANCE, random_posture
from virtualrobot_sdk.testing.bench import Bench
from virtualrobot_sdk.testing.laws import LawBroken, Measured

MEMORY_SECONDS = 1.5
"""Longest time (s) for which the component is called while its memory is watched."""
_BLOCKS = 12
_ROUNDS_A_BLOCK = 500
LEAK_BYTES = 40.0
"""Growth a round of calls that counts as a leak, where it also makes up LEAK_TOTAL."""
LEAK_TOTAL = 256 << 10
COST_POSTURES = 300
_REPEATED = 5


def refusals(bench: Bench, rng: np.random.Generator) -> Measured:
    """Arguments that make no sense are refused by an ArgumentError, and the next call is answered rightly."""
    q = random_posture(bench.chain, rng)
    before = bench.forward(q)[-1]
    accepted = []
    tried = 0
    for method, arguments, what in _nonsense(bench.chain, q, bench.tip(q)):
        tried += 1
        try:
            bench.call(method, *arguments)
        except ArgumentError:
            continue
        except ComponentFault as fault:
            accepted.append(f"{method} of {what}: {fault}")
            if bench.has_ended:
                break
            continue
        accepted.append(f"{method} of {what} was answered")
    if accepted:
        raise LawBroken(f"these must raise ArgumentError: {'; '.join(accepted)}")
    # Whether forward is right is another law's business.
    off = np.abs(bench.forward(q)[-1] - before).max()
    if off > POSE_TOLERANCE:
        raise LawBroken(f"after refusals forward answers otherwise than before them, by {off:.3g}")
    return Measured(tried)


def determinism(bench: Bench, rng: np.random.Generator) -> Measured:
    """The same call gives the same bits: twice in a row, and in another process."""
    with bench.twin() as twin:
        for _ in range(_REPEATED):
            q, seed = random_posture(bench.chain, rng), random_posture(bench.chain, rng)
            target, options = bench.tip(q), InverseOptions(seed=seed)
            for method, arguments in (("forward", (q,)), ("jacobian", (q,)), ("inverse", (target, options))):
                first = _bits(getattr(bench, method)(*arguments))
                for where, other in (("", bench), (" in another process", twin)):
                    if _bits(getattr(other, method)(*arguments)) != first:
                        raise LawBroken(f"{method} gives another answer to the same question{where}")
    return Measured(_REPEATED)


def arguments(bench: Bench, rng: np.random.Generator) -> Measured:
    """Arguments are not written to, and may be arrays that cannot be."""
    for _ in range(_REPEATED):
        q, seed = random_posture(bench.chain, rng), random_posture(bench.chain, rng)
        if changed := bench.look("written", q, bench.tip(q), seed):
            raise LawBroken(", ".join(changed))
    return Measured(_REPEATED)


def answers(bench: Bench, rng: np.random.Generator) -> Measured:
    """Each answer is an array of its own: no call changes an earlier answer, and who writes to one harms nobody."""
    for _ in range(_REPEATED):
        first, second = random_posture(bench.chain, rng), random_posture(bench.chain, rng)
        if found := bench.look("shared", first, second, bench.tip(first), bench.tip(second)):
            raise LawBroken("; ".join(found))
    return Measured(_REPEATED)


def memory(bench: Bench, rng: np.random.Generator) -> Measured:
    """The process does not grow with the calls: the median slope between any two of a dozen looks (Theil and Sen)."""
    postures = np.array([random_posture(bench.chain, rng) for _ in range(50)])
    targets = np.array([bench.tip(q) for q in postures])
    rounds, sizes = bench.look("memory", postures, targets, _BLOCKS, _ROUNDS_A_BLOCK, MEMORY_SECONDS)
    looks = itertools.combinations(zip(rounds, sizes, strict=True), 2)
    slope = float(np.median([(b - a) / (n - m) for (m, a), (n, b) in looks]))
    calls = 3 * rounds[-1]
    if slope > LEAK_BYTES and slope * rounds[-1] > LEAK_TOTAL:
        raise LawBroken(f"its process grows by {slope / 3:,.0f} bytes a call (over {calls:,} calls)")
    return Measured(calls, {"bytes a call": max(0.0, slope / 3)})


def cost(bench: Bench, rng: np.random.Generator) -> dict[str, tuple[Floats, Floats]]:
    """Return for each method how long a call takes (s): in the component's process, and through a worker process."""
    postures = np.array([random_posture(bench.chain, rng) for _ in range(COST_POSTURES)])
    targets = np.array([bench.tip(q) for q in postures])
    inside = bench.look("seconds", postures, targets)
    through = bench.seconds(postures, targets)
    return {method: (np.array(inside[method]), np.array(through[method])) for method in inside}


def _bits(answer: Floats | InverseResult) -> bytes:
    return (answer.solutions if isinstance(answer, InverseResult) else answer).tobytes()


def _nonsense(chain: SerialChain, q: Floats, target: Floats) -> Iterator[tuple[str, tuple[object, ...], str]]:
    """Yield calls that must be refused: the method, its arguments, and what is wrong about them in words."""
    wrong = {"NaN": _with(q, np.nan), "infinity": _with(q, np.inf), "too many values": np.append(q, 0.0)}
    wrong |= {"too few values": q[:-1], "a matrix": q[None]}
    for what, value in wrong.items():
        yield "forward", (value,), f"q with {what}"
        yield "jacobian", (value,), f"q with {what}"
        yield "inverse", (target, InverseOptions(seed=value)), f"a seed with {what}"
    poses = {"NaN": _with(target, np.nan), "infinity": _with(target, np.inf), "the shape (3, 4)": target[:3]}
    poses["a rotation twice as large"] = target @ np.diag([2.0, 2.0, 2.0, 1.0])
    poses["a reflection"] = target @ np.diag([1.0, 1.0, -1.0, 1.0])
    poses["a last row of 0 0 1 1"] = np.vstack([target[:3], [0.0, 0.0, 1.0, 1.0]])
    for what, value in poses.items():
        yield "inverse", (value, InverseOptions(seed=q)), f"a target with {what}"
    yield "inverse", (target, InverseOptions(seed=q, position_tolerance=-1.0)), "a negative position_tolerance"
    yield "inverse", (target, InverseOptions(seed=q, rotation_tolerance=float("nan"))), "a rotation_tolerance of NaN"
    yield "inverse", (target, InverseOptions(seed=q, arm_angle=float("nan"))), "an arm angle of NaN"


def _with(array: Floats, value: float) -> Floats:
    changed = array.copy()
    changed.flat[0] = value
    return changed
