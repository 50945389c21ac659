"""Laws that every kinematics component keeps, about its answers: each is tried at random postures of one chain.

A law is a function of a bench and a generator of random numbers. It returns what it measured, or raises LawBroken with
the posture and the numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from virtualrobot_sdk.answers import pose_distance
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import PRISMATIC, Floats, InverseOptions, InverseResult, InverseStatus, SerialChain
from virtualrobot_sdk.selfcheck import JACOBIAN_TOLERANCE, POSE_TOLERANCE, finite_differences, random_posture
from virtualrobot_sdk.testing.bench import Bench
from virtualrobot_sdk.testing.branches import SAME, all_solutions, is_redundant, same

POSTURES = 25
"""Number of random postures that most laws try."""
BRANCH_POSES = 4
"""Number of poses for which all solutions are looked for."""
RETURNED, EXISTING = "solutions returned", "solutions that there are"
_BEYOND = 0.3
"""Distance of a tried position past its limit (rad, m)."""


class LawBroken(AssertionError):
    """A component breaks a law; the message says where and by how much."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Result of a law that holds.

    Attributes:
        tried: number of postures or cases.
        worst: the worst deviations by their unit, or what else was counted.
        note: a remark in words.
    """

    tried: int
    worst: Mapping[str, float] = field(default_factory=dict)
    note: str = ""


def forward(bench: Bench, rng: np.random.Generator) -> Measured:
    """The tip is where the chain has it; the number of frames is always the same."""
    worst = np.zeros(2)
    counts = set()
    for _ in range(POSTURES):
        q = random_posture(bench.chain, rng)
        frames, expected = bench.forward(q), bench.tip(q)
        counts.add(len(frames))
        off = pose_distance(frames[-1], expected)
        if max(off) > POSE_TOLERANCE:
            raise LawBroken(
                f"at q = {_numbers(q)} forward puts the tip {off[0]:.3g} m and {off[1]:.3g} rad from where the chain "
                f"has it: at {_numbers(frames[-1, :3, 3])}, which should be {_numbers(expected[:3, 3])}"
            )
        worst = np.maximum(worst, off)
    if len(counts) > 1:
        raise LawBroken(
            f"forward returned {' or '.join(map(str, sorted(counts)))} frames; it must always be one number"
        )
    return Measured(POSTURES, {"m": worst[0], "rad": worst[1]})


def jacobian(bench: Bench, rng: np.random.Generator) -> Measured:
    """The Jacobian is the derivative of the chain's forward pass, by central differences."""
    worst = 0.0
    for _ in range(POSTURES):
        q = random_posture(bench.chain, rng)
        found, expected = bench.jacobian(q), finite_differences(bench.tip, q)
        difference = np.abs(found - expected)
        off = difference.max() / max(1e-3, np.abs(expected).max())
        if off > JACOBIAN_TOLERANCE:
            row, column = np.unravel_index(difference.argmax(), difference.shape)
            raise LawBroken(
                f"at q = {_numbers(q)} the Jacobian's entry in row {row}, column {column} "
                f"({bench.chain.joint_names[column]!r}) is {found[row, column]:.6g}; finite differences give "
                f"{expected[row, column]:.6g}"
            )
        worst = max(worst, off)
    return Measured(POSTURES, {"of the largest entry": worst})


def inverse(bench: Bench, rng: np.random.Generator) -> Measured:
    """Solutions put the tip at the target, within limits; a pose is solved from the posture that reaches it.

    That posture itself comes first, full turns included, unless the arm is redundant. How often a pose is solved from
    elsewhere is only counted.
    """
    worst = np.zeros(2)
    elsewhere = 0
    for _ in range(POSTURES):
        q = random_posture(bench.chain, rng)
        target = bench.tip(q)
        worst = np.maximum(worst, _solved(bench, target, q))
        first = bench.inverse(target, InverseOptions(seed=q)).solutions[0]
        if np.abs(first - q).max() > SAME and not is_redundant(bench.chain, q):
            raise LawBroken(
                f"from the seed {_numbers(q)}, which solves the pose, inverse returned {_numbers(first)} first"
            )
        for seed in (random_posture(bench.chain, rng), None):
            result = bench.inverse(target, InverseOptions(seed=seed))
            worst = np.maximum(worst, _closing(bench, target, result))
            elsewhere += result.status is InverseStatus.SOLVED
    note = f"{elsewhere} of {2 * POSTURES} solved from elsewhere"
    return Measured(POSTURES, {"m": worst[0], "rad": worst[1]}, note)


def limits(bench: Bench, rng: np.random.Generator) -> Measured:
    """A pose is solved too where one joint is at its limit; past it, only when limits do not count."""
    chain = bench.chain
    worst = np.zeros(2)
    tried = 0
    for i, bounds in enumerate(np.stack([chain.lower, chain.upper], axis=1)):
        for bound, outward in zip(bounds, (-1.0, 1.0), strict=True):
            if not np.isfinite(bound):
                continue
            q = random_posture(chain, rng)
            q[i] = bound
            worst = np.maximum(worst, _solved(bench, bench.tip(q), q))
            tried += 1
            if (chain.joint_type[chain.q_index == i] == PRISMATIC).any():
                continue
            q[i] = bound + outward * _BEYOND
            worst = np.maximum(worst, _solved(bench, bench.tip(q), q, respect_limits=False))
            seed = np.clip(q, chain.lower, chain.upper)
            # Solutions outside are found by the check of every answer.
            result = bench.inverse(bench.tip(q), InverseOptions(seed=seed))
            worst = np.maximum(worst, _closing(bench, bench.tip(q), result))
            tried += 1
    return Measured(tried, {"m": worst[0], "rad": worst[1]})


def order(bench: Bench, rng: np.random.Generator) -> Measured:
    """Each solution comes once; the nearest to the seed comes first, by sum, squares or largest of the differences."""
    for _ in range(POSTURES):
        q, seed = random_posture(bench.chain, rng), random_posture(bench.chain, rng)
        solutions = bench.inverse(bench.tip(q), InverseOptions(seed=seed)).solutions
        for i, solution in enumerate(solutions):
            twins = [j for j in range(i) if np.abs(solutions[j] - solution).max() < 1e-6]
            if twins:
                raise LawBroken(f"solutions {twins[0]} and {i} of inverse are the same: {_numbers(solution)}")
        norms = [np.linalg.norm(solutions - seed, ord, axis=1) for ord in (1, 2, np.inf)] if len(solutions) else []
        if norms and not any((np.diff(norm) >= -1e-9).all() for norm in norms):
            raise LawBroken(
                f"from the seed {_numbers(seed)} inverse returned solutions at distances {_numbers(norms[1])}; they "
                "must come by their distance, the nearest first"
            )
    return Measured(POSTURES)


def singular(bench: Bench, rng: np.random.Generator) -> Measured:
    """Poses of arms that are stretched, folded or in line are solved like others; beside them numbers are finite."""
    tried = 0
    worst = np.zeros(2)
    for i in range(len(bench.chain.joint_names)):
        for angle in (0.0, np.pi / 2, np.pi, None):
            q = random_posture(bench.chain, rng) if angle is not None else np.zeros(len(bench.chain.joint_names))
            q[i] = angle or 0.0
            q = np.clip(q, bench.chain.lower, bench.chain.upper)
            worst = np.maximum(worst, _solved(bench, bench.tip(q), q))
            beside = bench.tip(q) @ _shifted(1e-9 * rng.normal(size=3))
            worst = np.maximum(worst, _closing(bench, beside, bench.inverse(beside, InverseOptions(seed=q))))
            tried += 2
    return Measured(tried, {"m": worst[0], "rad": worst[1]})


def near(bench: Bench, rng: np.random.Generator) -> Measured:
    """Poses that are almost alike are told apart: each is answered at its own place, to the last digits or not at all.

    One after the other the posture is moved by 1e-8 to 1e-3 (rad, m), and the target tilted and shifted by as much.
    """
    worst = np.zeros(2)
    for _ in range(POSTURES):
        q = random_posture(bench.chain, rng)
        size = 10.0 ** rng.uniform(-8.0, -3.0)
        moved = np.clip(q + size * rng.uniform(-1.0, 1.0, len(q)), bench.chain.lower, bench.chain.upper)
        for posture in (q, moved):
            worst = np.maximum(worst, _solved(bench, bench.tip(posture), posture))
        tilted = bench.tip(q) @ _tilted(size * rng.normal(size=3))
        for target in (tilted, bench.tip(q) @ _shifted(size * rng.normal(size=3))):
            worst = np.maximum(worst, _closing(bench, target, bench.inverse(target, InverseOptions(seed=q))))
    return Measured(4 * POSTURES, {"m": worst[0], "rad": worst[1]})


def configurations(bench: Bench, rng: np.random.Generator) -> Measured:
    """The name of a solution is that of its branch, whatever the seed; asked by it, only that branch is answered.

    A name that the component doesn't know is refused. Where none has a name, nothing else is tried.
    """
    tried = 0
    for _ in range(POSTURES):
        q, seed = random_posture(bench.chain, rng), random_posture(bench.chain, rng)
        target = bench.tip(q)
        found = bench.inverse(target, InverseOptions(seed=q))
        elsewhere = bench.inverse(target, InverseOptions(seed=seed))
        for name, solution in zip(found.configurations, found.solutions, strict=True):
            if not name:
                continue
            # Names of other branches are found by the check of every answer.
            asked = bench.inverse(target, InverseOptions(seed=q, configuration=name))
            if not any(np.abs(other - solution).max() < SAME for other in asked.solutions):
                raise LawBroken(
                    f"asked for the configuration {name!r} inverse does not return {_numbers(solution)}, which it "
                    f"returned by that name: {asked.reason or asked.status.value}"
                )
            others = [o for n, o in zip(elsewhere.configurations, elsewhere.solutions, strict=True) if n == name]
            if others and not is_redundant(bench.chain, q) and not same(bench.chain, others[0], solution):
                raise LawBroken(
                    f"the configuration {name!r} is {_numbers(solution)} from one seed and {_numbers(others[0])} from "
                    "another"
                )
            tried += 1
    try:
        bench.call("inverse", target, InverseOptions(seed=q, configuration="no such configuration"))
    except ArgumentError:
        return Measured(tried + 1)
    raise LawBroken(
        "the configuration 'no such configuration' must be refused by an ArgumentError that names the valid ones"
    )


def branches(bench: Bench, rng: np.random.Generator) -> Measured:
    """Count the solutions that the component returns, and those within limits that there are; a law for no one.

    Nothing is counted for a redundant arm, which has endlessly many.
    """
    returned = existing = tried = 0
    missing = ""
    for _ in range(BRANCH_POSES):
        q = random_posture(bench.chain, rng)
        if is_redundant(bench.chain, q):
            continue
        target = bench.tip(q)
        known: list[Floats] = []
        for solution in bench.inverse(target, InverseOptions(seed=q)).solutions:
            _closes(bench, target, solution)
            if not any(same(bench.chain, solution, other) for other in known):
                known.append(solution)
        others = all_solutions(bench.chain, target, rng)
        unknown = [o for o in others if not any(same(bench.chain, o, solution) for solution in known)]
        tried += 1
        returned += len(known)
        existing += len(known) + len(unknown)
        if unknown and not missing:
            missing = f"for the pose of q = {_numbers(q)} it does not return {_numbers(unknown[0])}"
    return Measured(tried, {RETURNED: returned, EXISTING: existing}, missing)


def complete(bench: Bench, rng: np.random.Generator) -> Measured:
    """All solutions within limits are returned: a law for components that say so."""
    found = branches(bench, rng)
    if found.note:
        raise LawBroken(f"{found.worst[RETURNED]:g} of {found.worst[EXISTING]:g} solutions are returned: {found.note}")
    return found


def unreachable(bench: Bench, rng: np.random.Generator) -> Measured:
    """A pose out of reach is refused with a reason."""
    reach = _reach(bench.chain)
    tried = 0
    for distance in (1.01, 1.5, 10.0):
        if np.isfinite(reach):
            direction = rng.normal(size=3)
            target = bench.tip(random_posture(bench.chain, rng))
            target[:3, 3] = bench.chain.pre[0, :3, 3] + distance * reach * direction / np.linalg.norm(direction)
            _refused(bench, target, f"{distance:g} times as far as all links together reach")
            tried += 1
    return Measured(tried)


def _solved(bench: Bench, target: Floats, q: Floats, respect_limits: bool = True) -> tuple[float, float]:
    """Return how far the solutions found from q, which is one, are from the target."""
    result = bench.inverse(target, InverseOptions(seed=q, respect_limits=respect_limits))
    if result.status is not InverseStatus.SOLVED:
        said = "" if respect_limits else " and limits that do not count"
        raise LawBroken(
            f"inverse found no solution for the pose of q = {_numbers(q)} with q as its seed{said}: "
            f"{result.status.value}, {result.reason or 'without a reason'}"
        )
    return _closing(bench, target, result)


def _closing(bench: Bench, target: Floats, result: InverseResult) -> tuple[float, float]:
    offs = [_closes(bench, target, solution) for solution in result.solutions]
    worst = max((off[0] for off in offs), default=0.0), max((off[1] for off in offs), default=0.0)
    for what, said, true in zip(
        ("position", "rotation"), (result.position_error, result.rotation_error), worst, strict=True
    ):
        if offs and abs(said - true) > POSE_TOLERANCE:
            raise LawBroken(f"inverse says {what}_error = {said:g}; its worst solution misses the target by {true:.3g}")
    return worst


def _closes(bench: Bench, target: Floats, solution: Floats) -> tuple[float, float]:
    off = pose_distance(bench.tip(solution), target)
    if max(off) > POSE_TOLERANCE:
        raise LawBroken(
            f"inverse returned {_numbers(solution)}, which misses the target by {off[0]:.3g} m and {off[1]:.3g} rad; "
            f"the target's position is {_numbers(target[:3, 3])}"
        )
    return off


def _refused(bench: Bench, target: Floats, what: str) -> None:
    result = bench.inverse(target, InverseOptions())
    if result.status is InverseStatus.SOLVED:
        raise LawBroken(f"inverse solved a pose that is {what}: {_numbers(result.solutions[0])}")
    # Beyond the stroke of a sliding joint it is outside limits.
    if result.status is not InverseStatus.UNREACHABLE and (bench.chain.joint_type != PRISMATIC).all():
        raise LawBroken(f"inverse answered {result.status.value} for a pose that is {what}; it must be UNREACHABLE")
    if not result.reason:
        raise LawBroken(f"inverse gave no reason why a pose that is {what} has no solution")


def _shifted(shift: Floats) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = shift
    return pose


def _tilted(vector: Floats) -> Floats:
    """Return a turn by a small rotation vector (rad), by Rodrigues' formula."""
    x, y, z = vector
    angle = float(np.linalg.norm(vector))
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    pose = np.eye(4)
    pose[:3, :3] += np.sinc(angle / np.pi) * skew + 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2 * skew @ skew
    return pose


def _reach(chain: SerialChain) -> float:
    """Return a distance from the first joint (m) that the tip cannot pass."""
    links = [*chain.pre[1:], chain.post]
    slides = chain.joint_type == PRISMATIC
    stroke = np.maximum(np.abs(chain.lower), np.abs(chain.upper))[chain.q_index[slides]]
    shifts = np.abs(chain.multiplier[slides]) * stroke + np.abs(chain.offset[slides])
    return float(sum(np.linalg.norm(link[:3, 3]) for link in links) + shifts.sum())


def _numbers(values: Floats) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"
