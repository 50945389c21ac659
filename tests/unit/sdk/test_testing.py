"""The test kit's judge and laws: right components pass, each small wrong is found, in this process."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_sdk.denavit_hartenberg import Table, frames
from virtualrobot_sdk.errors import ComponentFault
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, Floats
from virtualrobot_sdk.reference import chain_frames, joint_motion, tip_pose
from virtualrobot_sdk.selfcheck import finite_differences, random_posture
from virtualrobot_sdk.testing.bench import Bench
from virtualrobot_sdk.testing.branches import all_solutions, geometric_jacobian, is_redundant, same, turned_within
from virtualrobot_sdk.testing.chains import PUMA560, chain_of, kit_chains, puma560, scara, ur5
from virtualrobot_sdk.testing.examination import LAWS
from virtualrobot_sdk.testing.laws import EXISTING, RETURNED, LawBroken, branches, complete
from virtualrobot_sdk.testing.probe import Probe
from virtualrobot_sdk.testing.subject import Subject

CASES = "tests.unit.sdk.kit_cases"


class HereBench(Bench):
    """A bench whose component is in this process."""

    def __init__(self, case: str, chain: str = "scara") -> None:
        """Make the component here."""
        self.probe = Probe(f"{CASES}:{case}", "", {}, kit_chains()[chain])
        super().__init__(Subject(case, f"{CASES}:{case}", ""), chain, kit_chains()[chain])

    def _started(self) -> Any:  # noqa: ANN401  there is no process
        return None

    @property
    def has_ended(self) -> bool:
        return False

    def twin(self) -> Bench:
        return HereBench(self.subject.component)

    def call(self, method: str, *arguments: object) -> Any:  # noqa: ANN401
        return getattr(self.probe, method)(*arguments)

    look = call

    def close(self) -> None:
        pass


@pytest.mark.parametrize("law", [law for law in LAWS if law != "memory"])
def test_a_right_component_keeps_the_law(law: str, rng: np.random.Generator) -> None:
    assert LAWS[law](HereBench("Right"), rng).tried > 0


@pytest.mark.parametrize(
    ("case", "law", "said"),
    [
        ("OtherTip", "forward", r"forward puts the tip 0 m and 3\.14 rad from where the chain has it"),
        ("FramesComeAndGo", "forward", r"forward returned 1 or 5 frames; it must always be one number"),
        ("JacobianOfTheTip", "jacobian", r"entry in row \d, column \d \('joint_\d'\) is \S+; finite differences give"),
        ("BeyondLimits", "inverse", r"outside its limits"),
        ("LimitsAlways", "limits", r"with q as its seed and limits that do not count: OUTSIDE_LIMITS, limits"),
        ("LimitsTooTight", "limits", r"inverse found no solution for the pose of q = \["),
        ("Twice", "order", r"solutions 0 and 1 of inverse are the same"),
        ("FarthestFirst", "order", r"come by their distance, the nearest first"),
        ("LeavesOutTurns", "inverse", r"from the seed \[.*\], which solves the pose, inverse returned \[.*\] first"),
        ("FarFromExact", "inverse", r"says position_error = 1e\+06; its worst solution misses the target by "),
        ("NaNWhereStretched", "singular", r"inverse found no solution for the pose of q = \["),
        ("RoundsTheTarget", "near", r"misses the target by 0\.000|found no solution for the pose of q"),
        ("TiltedAsUpright", "near", r"misses the target by \S+ m and \S+ rad"),
        ("NamesByOrder", "configurations", r"where '\w+' was asked for|from one seed and \[.*\] from another"),
        ("IgnoresConfiguration", "configurations", r"returned the configuration '\w+' where '\w+' was asked for"),
        ("NamelessWhenAsked", "configurations", r"'no such configuration' must be refused by an ArgumentError"),
        ("StartsWhereItEnded", "answers", r"inverse answers the same question otherwise after another one"),
        ("ReachesForTheMoon", "unreachable", r"inverse solved a pose that is 1\.01 times as far as all links"),
        ("GivesNoReason", "unreachable", r"inverse gave no reason why"),
        ("TakesAnything", "refusals", r"forward of q with NaN was answered; forward of q with infinity was answered"),
        ("RaisesWrongly", "refusals", r"forward of q with NaN: forward raised ValueError: q must be finite"),
        ("Sulks", "refusals", r"after refusals forward answers otherwise than before them, by 0\.1"),
        ("Moody", "determinism", r"jacobian gives another answer to the same question"),
        ("WritesToTheSeed", "arguments", r"inverse changes the seed"),
        ("WritesToQ", "arguments", r"forward changes q|read-only"),
        ("KeepsItsBuffer", "answers", r"an answer of forward changes with the next call"),
        ("Remembers", "answers", r"who writes to an answer of jacobian changes the next one"),
    ],
)
def test_a_small_wrong_is_found(case: str, law: str, said: str, rng: np.random.Generator) -> None:
    with pytest.raises((LawBroken, ComponentFault)) as broken:
        LAWS[law](HereBench(case), rng)
    assert re.search(said, str(broken.value)), str(broken.value)


def test_out_of_reach_is_not_outside_limits(rng: np.random.Generator) -> None:
    with pytest.raises(LawBroken, match=r"answered OUTSIDE_LIMITS for a pose that is 1\.01 times as far"):
        LAWS["unreachable"](HereBench("OutsideLimitsAlways", "puma560"), rng)


@pytest.mark.parametrize("case", ["IgnoresTheBase", "IgnoresTheTool"])
def test_base_and_tool_count(case: str, rng: np.random.Generator) -> None:
    assert LAWS["forward"](HereBench(case), rng).tried > 0
    with pytest.raises(LawBroken, match=r"forward puts the tip 0\.\d+ m and"):
        LAWS["forward"](HereBench(case, "scara_mounted"), rng)


def test_a_wrong_forward_pass_is_no_wrong_refusal(rng: np.random.Generator) -> None:
    assert LAWS["refusals"](HereBench("OtherTip"), rng).tried > 0


def test_an_argument_that_must_be_writable_is_found(rng: np.random.Generator) -> None:
    bench = HereBench("WritesToQ")
    q = random_posture(bench.chain, rng) % 1.0  # so that nothing is changed
    with pytest.raises(ComponentFault, match="read-only"):
        bench.look("written", q, bench.tip(q), q)


def test_solutions_are_counted(rng: np.random.Generator) -> None:
    found = complete(HereBench("Right"), rng).worst
    assert found[RETURNED] == found[EXISTING] >= 4
    counted = branches(HereBench("OneElbow"), rng).worst
    assert counted[RETURNED] == 4


def test_a_missing_solution_is_found(seed: int) -> None:
    """Some poses have one solution within limits only; not all of 20 have."""
    said = r"\d+ of \d+ solutions are returned: for the pose of q = \[.*it does not return \["
    with pytest.raises(LawBroken, match=said):
        for i in range(5):
            complete(HereBench("OneElbow"), np.random.default_rng([seed, i]))


def test_the_judge_agrees_with_the_textbook(rng: np.random.Generator) -> None:
    """Against the product of the A_i of Paul 1981, and of Craig 1986 for the same rows."""
    q = rng.uniform(-3.0, 3.0, 6)
    np.testing.assert_allclose(tip_pose(puma560(), q), frames(PUMA560, q)[-1], atol=1e-14)
    # Corke's model at zero: the arm stretched forward, the wrist up.
    np.testing.assert_allclose(tip_pose(puma560(), np.zeros(6))[:3, 3], [0.4521, -0.15005, 0.4318], atol=1e-15)
    modified = Table("modified", PUMA560.rows)
    chain = chain_of(modified, [(-3.0, 3.0)] * 6)
    np.testing.assert_allclose(tip_pose(chain, q), frames(modified, q)[-1], atol=1e-14)


def test_joints_move_as_they_should(rng: np.random.Generator) -> None:
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    value = rng.uniform(-6.0, 6.0, 4)
    expected = Rotation.from_rotvec(value[:, None] * axis).as_matrix()
    np.testing.assert_allclose(joint_motion(REVOLUTE, axis, value)[:, :3, :3], expected, atol=1e-14)
    np.testing.assert_allclose(joint_motion(PRISMATIC, axis, value)[:, :3, 3], value[:, None] * axis)


@pytest.mark.parametrize("name", kit_chains())
def test_stacks_and_derivatives(name: str, rng: np.random.Generator) -> None:
    chain = kit_chains()[name]
    postures = np.array([random_posture(chain, rng) for _ in range(3)])
    stack = chain_frames(chain, postures)
    for q, each, jacobian in zip(postures, stack, geometric_jacobian(chain, stack), strict=True):
        np.testing.assert_array_equal(chain_frames(chain, q), each)
        np.testing.assert_allclose(jacobian, finite_differences(lambda q: tip_pose(chain, q), q), atol=1e-7)
    assert is_redundant(chain, postures[0]) == (name == "iiwa")


def test_all_eight_solutions_of_a_spherical_wrist_are_found(rng: np.random.Generator) -> None:
    """Pieper 1968: shoulder, elbow and wrist have two ways each; limits of two turns leave all of them."""
    chain = puma560()._replace(lower=np.full(6, -2.0 * np.pi), upper=np.full(6, 2.0 * np.pi))
    q, volume = np.zeros(6), 0.0
    while volume < 1e-3:  # at a singular pose two ways are one; 0.05 is a common volume
        q = random_posture(puma560(), rng)
        q[4] = rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.5)
        volume = abs(np.linalg.det(finite_differences(lambda at: tip_pose(chain, at), q)))
    target = tip_pose(chain, q)
    found = all_solutions(chain, target, rng)
    np.testing.assert_allclose(tip_pose(chain, found), np.tile(target, (len(found), 1, 1)), atol=1e-8)
    assert any(same(chain, q, solution) for solution in found)
    assert len(found) == 8


def test_full_turns_bring_a_posture_within_limits() -> None:
    chain = ur5(2.0 * np.pi)
    q = np.array([7.0, -7.0, 0.0, 13.0, 6.0, -6.0])
    inside: Floats | None = turned_within(chain, q)
    assert inside is not None
    np.testing.assert_allclose(inside, [7.0 - 2 * np.pi, 2 * np.pi - 7.0, 0.0, 13.0 - 4 * np.pi, 6.0, -6.0])
    assert same(chain, q, inside)
    assert turned_within(scara(), np.array([3.0, 0.0, 0.0, 0.0])) is None
    assert turned_within(scara(), np.array([0.0, 0.0, 0.1, 0.0])) is None
    np.testing.assert_array_equal(turned_within(ur5(np.inf), q), q)
