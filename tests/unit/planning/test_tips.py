"""Checks of many answers at once: what they let through, and how they refuse, is what checks one by one do."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.robots import arm_of, tip_of, tips_of
from virtualrobot_kernel.planning.solvers import Solver
from virtualrobot_sdk.answers import check_solution, check_solutions, checked_result, checked_results
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.kinematics import REVOLUTE, InverseMany, InverseOptions, InverseResult, InverseStatus
from virtualrobot_sdk.reference import joint_motion

from tests.unit.planning.robots import standing


@pytest.mark.parametrize("model", ["panda", "nine_axis"])
def test_tips_are_those_of_one_posture_each(rng: np.random.Generator, model: str) -> None:
    """By the tree's own forward pass, with all joints, and with two of them locked."""
    snapshot, node = standing(model)
    arm = arm_of(snapshot, node)
    stand = {int(arm.q_index[1]): 0.3, int(arm.q_index[4]): -1.1}
    locked = replace(arm, locked=stand, q_index=np.delete(arm.q_index, [1, 4]))
    for one in (arm, locked):
        postures = rng.uniform(-3.0, 3.0, (40, len(one.q_index)))
        tip, found = tip_of(snapshot, one), tips_of(snapshot, one)(postures)
        np.testing.assert_allclose(found, [tip(q) for q in postures], atol=1e-13)
    assert tips_of(snapshot, arm)(np.empty((0, len(arm.q_index)))).shape == (0, 4, 4)


@pytest.mark.parametrize("off", [0.0, 0.9e-6, 1.1e-6, 0.1, 3.0])
def test_what_misses_its_target_is_told_in_the_same_words(rng: np.random.Generator, off: float) -> None:
    """Misses below and above the micrometre and microradian that count."""
    axis = np.array([0.6, 0.0, 0.8])
    targets = np.array([joint_motion(REVOLUTE, axis, np.array(angle)) for angle in rng.uniform(-3.0, 3.0, 5)])
    shifted, turned = targets.copy(), targets.copy()
    shifted[3, :3, 3] += off * axis
    turned[2] = targets[2] @ joint_motion(REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array(off))
    for reached, row in ((shifted, 3), (turned, 2)):
        if off < 1e-6:
            check_solutions(reached, targets, InverseOptions())
            check_solution(reached[row], targets[row], InverseOptions())
            continue
        for options in (InverseOptions(), InverseOptions(position_tolerance=0.01, rotation_tolerance=0.01)):
            if off < options.position_tolerance:
                check_solutions(reached, targets, options)
                continue
            with pytest.raises(ComponentFault) as alone:
                check_solution(reached[row], targets[row], options)
            with pytest.raises(ComponentFault) as together:
                check_solutions(reached, targets, options)
            assert str(together.value) == str(alone.value)


def damaged(what: str, answer: InverseResult) -> Any:  # noqa: ANN401  nonsense of any kind
    """Return an answer with something wrong."""
    solutions = answer.solutions.copy()
    if what == "type":
        return None
    if what == "names":
        return answer._replace(configurations=("one",))
    if what == "shape":
        return answer._replace(solutions=solutions[:, :4])
    if what == "status":
        return answer._replace(status=InverseStatus.UNREACHABLE)
    solutions[1, 4] = {"nan": np.nan, "overflow": np.inf, "limit": 7.0}[what]
    return answer._replace(solutions=solutions)


@pytest.mark.parametrize("what", ["type", "names", "shape", "status", "nan", "overflow", "limit"])
def test_answers_that_make_no_sense_are_told_in_the_same_words(rng: np.random.Generator, what: str) -> None:
    """The place of a wrong number is that in its own answer, though it is found among all."""
    chain, options = arm_of(*standing("panda")).serial(), InverseOptions()
    answers: list[InverseResult] = []
    for count in (3, 0, 2, 4):
        status = InverseStatus.SOLVED if count else InverseStatus.UNREACHABLE
        answers.append(
            InverseResult(status, rng.uniform(chain.lower, chain.upper, (count, 7)), ("a branch",) * count, 0.0, 0.0)
        )
    for found, answer in zip(checked_results(answers, chain, options), answers, strict=True):
        np.testing.assert_array_equal(found.solutions, answer.solutions)
        assert found.solutions is not answer.solutions
        assert found._replace(solutions=answer.solutions) == answer
    assert checked_results([], chain, options) == []
    wrong = damaged(what, answers[2])
    with pytest.raises(ComponentFault) as alone:
        checked_result(wrong, chain, options)
    with pytest.raises(ComponentFault) as together:
        checked_results([*answers[:2], wrong, answers[3]], chain, options)
    assert str(together.value) == str(alone.value)


class Chosen:
    """Component that gives the answers it was told, one after the other, and keeps its faults."""

    def __init__(self, answers: list[InverseResult]) -> None:
        """Take the answers."""
        self.answers = answers

    def has(self, method: str) -> bool:
        return False

    def call(self, method: str, *arguments: object) -> InverseResult:
        assert method == "inverse" and len(arguments) == 2
        return self.answers.pop(0)

    def failed(self, fault: ComponentFault) -> KernelError:
        return KernelError(f"it failed: {fault.reason}")


def test_a_solver_asked_for_many_poses_compares_each_with_the_tree(rng: np.random.Generator) -> None:
    snapshot, node = standing("panda")
    arm = arm_of(snapshot, node)
    tip, tips, chain = tip_of(snapshot, arm), tips_of(snapshot, arm), arm.serial()
    postures = rng.uniform(chain.lower, chain.upper, (4, 7))
    answers = [InverseResult(InverseStatus.SOLVED, q[None], ("",), 0.0, 0.0) for q in postures]
    solver = Solver(Chosen(answers.copy()), chain, tip, tips)  # pyright: ignore[reportArgumentType]  as far as it is used
    found = solver.inverse_each(tips(postures))
    assert [result.solutions.tolist() for result in found] == [[q.tolist()] for q in postures]
    assert solver.inverse_each(np.empty((0, 4, 4))) == []
    solver = Solver(Chosen(answers.copy()), chain, tip, tips)  # pyright: ignore[reportArgumentType]
    with pytest.raises(KernelError, match="it failed: inverse returned a solution that misses its target by"):
        solver.inverse_each(tips(postures[::-1]))
    solver = Solver(Chosen(answers.copy()), chain, tip, tips)  # pyright: ignore[reportArgumentType]
    many = solver.inverse_many(tips(postures))
    assert (many.target.tolist(), many.solutions.tolist()) == ([0, 1, 2, 3], postures.tolist())


class Together(Chosen):
    """Component that has a method besides, of many poses at once or of a name, and gives one answer for all."""

    def __init__(self, answer: object, method: str = "inverse_many") -> None:
        """Take the answer of the method."""
        self.answer = answer
        self.method = method

    def has(self, method: str) -> bool:
        return method == self.method

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401  nonsense of any kind
        assert method == self.method and len(arguments) == 1
        return self.answer


def test_a_name_of_a_posture_is_looked_at(rng: np.random.Generator) -> None:
    snapshot, node = standing("panda")
    chain = arm_of(snapshot, node).serial()
    q = rng.uniform(chain.lower, chain.upper)
    named = Solver(Together("elbow up", "configuration"), chain, None)  # pyright: ignore[reportArgumentType]
    assert named.configuration(q) == "elbow up"
    wrong = Solver(Together(b"up", "configuration"), chain, None)  # pyright: ignore[reportArgumentType]
    with pytest.raises(KernelError, match="configuration returned a bytes as the name; it must be text"):
        wrong.configuration(q)


def test_answers_for_many_poses_are_looked_at(rng: np.random.Generator) -> None:
    snapshot, node = standing("panda")
    arm = arm_of(snapshot, node)
    tip, tips, chain = tip_of(snapshot, arm), tips_of(snapshot, arm), arm.serial()
    postures = rng.uniform(chain.lower, chain.upper, (3, 7))
    poses, target = tips(postures)[[0, 2, 2]], np.array([0, 1])
    right = InverseMany(target, postures[[0, 2]])
    outside = postures[[0, 2]].copy()
    outside[1, 4] = 7.0
    for answer, said in (
        (right, ""),
        (right._replace(target=np.array([0, 3])), "targets that do not go up from 0 to 2 at the most"),
        (right._replace(target=np.array([1, 0])), "targets that do not go up"),
        (right._replace(target=np.array([0])), r"target of shape \(1,\) for 2 solutions"),
        (right._replace(target=[0, 1]), "a list as target; it must be an int64 array"),
        (right._replace(solutions=postures[:2, :4]), r"shape \(2, 4\); they must be \(m, 7\)"),
        (right._replace(solutions=postures[:2]), "misses its target"),
        (right._replace(solutions=outside), "outside its limits"),
        (right._replace(solutions=np.full((2, 7), np.nan)), "all values must be finite"),
        ([right], "a list; it must be an InverseMany"),
    ):
        solver = Solver(Together(answer), chain, tip, tips)  # pyright: ignore[reportArgumentType]
        if said:
            with pytest.raises(KernelError, match=said):
                solver.inverse_many(poses)
            continue
        found = solver.inverse_many(poses)
        assert (found.target.tolist(), found.solutions.tolist()) == ([0, 1], postures[[0, 2]].tolist())
