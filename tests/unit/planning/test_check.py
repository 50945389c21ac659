"""Checked motions: each kind of violation made by a formula, with its time, place and amount; and what just passes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.planning.check import Checked, check_motion
from virtualrobot_kernel.planning.moves import JointTrajectory, Linear, Move, PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import DwellStep, MotionSpec, MoveStep, Zone
from virtualrobot_kernel.planning.redundancy import Redundancy
from virtualrobot_kernel.planning.violations import Violation, ViolationKind
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes, SelectTool, SetJointPositions, UpdateNode
from virtualrobot_kernel.world.structure import Inertial, Kind, LinkData, NodeSpec, PartData

from tests.unit.planning.cell import JOINTS, READY, TICK, cell, chain, pictured, tcp
from tests.unit.world.builders import after, shifted


def waiting() -> bool:
    """Tell that somebody waits for the answer."""
    return False


def checked(change: Change, *moves: Move, min_singular_value: float = 0.0) -> Checked:
    return check_motion(pictured(change), MotionSpec(moves), chain, min_singular_value, waiting)


def violated(change: Change, *moves: Move, min_singular_value: float = 0.0) -> Violation:
    found = checked(change, *moves, min_singular_value=min_singular_value).first_violation
    assert found is not None
    return found


def limited(change: Change, link: str, **limits: float) -> Change:
    """Return the world with other limits of the joint before a link."""
    data = change.structure.node(link).data
    assert isinstance(data, LinkData)
    joint = replace(data.joint, limits=replace(data.joint.limits, **limits))
    return after(change, UpdateNode(link, data=replace(data, joint=joint)))


def slid(times: np.ndarray, way: np.ndarray, velocities: np.ndarray | None = None) -> JointTrajectory:
    return JointTrajectory("belt", ("slide",), times, way[:, None], None if velocities is None else velocities[:, None])


def quintic(length: float, seconds: float) -> JointTrajectory:
    """Return a slide of a quintic from rest to rest: s = L (10 x^3 - 15 x^4 + 6 x^5), x = t / T."""
    return slid(np.array([0.0, seconds]), np.array([0.0, length]), np.zeros(2))


def parabola_peak(length: float, seconds: float) -> tuple[float, float]:
    """Return the greatest speed and acceleration of that quintic: 15/8 L / T and 10 / sqrt(3) L / T^2."""
    return 15.0 / 8.0 * length / seconds, 10.0 / np.sqrt(3.0) * length / seconds**2


def test_what_keeps_all_limits_has_no_violation_and_lasts_as_planned(rng: np.random.Generator) -> None:
    change = cell()
    goal = PoseGoal(shifted(*rng.uniform(-0.05, 0.05, 3)) @ tcp(change))
    found = checked(change, Linear("arm", goal))
    assert found.first_violation is None
    assert (
        found.duration
        == plan_motion(pictured(change), MotionSpec((Linear("arm", goal),)), chain, waiting).command.program.duration
    )
    assert found.min_singular_value is not None and found.min_singular_value > 0.01


def test_a_goal_beyond_its_limit_is_told_where_the_limit_is_met(rng: np.random.Generator) -> None:
    """The belt from 0 to 2.5 m, its end at 2 m: four fifths of a straight line."""
    change = cell()
    told = violated(change, PointToPoint("belt", {"slide": 2.5}))
    assert (told.kind, told.robot, told.joint, told.step) == (ViolationKind.JOINT_POSITION, "belt", "slide", 0)
    assert (told.value, told.limit) == (pytest.approx(2.5), 2.0)
    assert told.path_fraction == pytest.approx(0.8, abs=1e-5)
    # At full speed 0.5 m/s, 2 m/s^2, 20 m/s^3: the ramp takes v/a + a/j = 0.35 s and v/2 of that in way; then evenly.
    assert told.time == pytest.approx(0.35 + (2.0 - 0.5 * 0.35 / 2.0) / 0.5, abs=1e-5)
    assert told.world_t_tcp is not None
    np.testing.assert_allclose(told.world_t_tcp[:3, 3], [2.0, -0.5, 0.0], atol=1e-5)
    assert "'slide' of 'belt' leaves its range" in told.message and "its limit is 2 m" in told.message


def test_a_trajectory_too_fast_is_told_when_it_is(rng: np.random.Generator) -> None:
    """The quintic's speed 30 L/T x^2 (1 - x)^2 meets the limit where x (1 - x) = sqrt(v T / (30 L))."""
    length, seconds = 1.0, 3.0
    change = limited(cell(), "belt.tray", acceleration=100.0)
    told = violated(change, quintic(length, seconds))
    assert (told.kind, told.joint) == (ViolationKind.JOINT_VELOCITY, "slide")
    root = np.sqrt(0.5 * seconds / (30.0 * length))
    assert told.time == pytest.approx(seconds * (0.5 - np.sqrt(0.25 - root)), abs=1e-4)
    assert (told.value, told.limit) == (pytest.approx(parabola_peak(length, seconds)[0]), 0.5)


def test_a_trajectory_that_accelerates_too_much_is_told_though_it_may_be_started() -> None:
    """The greatest acceleration of the quintic is at x = (1 - 1/sqrt(3)) / 2."""
    length, seconds = 0.5, 2.0
    speed, acceleration = parabola_peak(length, seconds)
    change = limited(cell(), "belt.tray", acceleration=acceleration * 0.999)
    assert speed < 0.5
    told = violated(change, quintic(length, seconds))
    assert told.kind is ViolationKind.JOINT_ACCELERATION
    assert (told.value, told.limit) == (pytest.approx(acceleration), pytest.approx(0.999 * acceleration))
    assert told.time == pytest.approx(seconds * (1.0 - 1.0 / np.sqrt(3.0)) / 2.0, abs=0.05)
    assert told.time < seconds * (1.0 - 1.0 / np.sqrt(3.0)) / 2.0
    just = limited(cell(), "belt.tray", acceleration=acceleration * 1.0000001)
    assert checked(just, quintic(length, seconds)).first_violation is None


def test_the_first_violation_in_time_counts() -> None:
    """Too far at the end, too fast in the middle, too much acceleration before: the planner alone refuses the end."""
    change = cell()
    kinds = []
    for limits in ({}, {"acceleration": 100.0}, {"acceleration": 100.0, "velocity": 100.0}):
        change = limited(change, "belt.tray", **limits)
        kinds.append(violated(change, quintic(2.5, 2.0)).kind)
    assert kinds == [ViolationKind.JOINT_ACCELERATION, ViolationKind.JOINT_VELOCITY, ViolationKind.JOINT_POSITION]


def test_a_torque_that_a_joint_cannot_give_is_told() -> None:
    """Joint 2 of the iiwa lying level holds its arm's weight; a heavy box in its hand needs more, m g r."""
    level = {**dict.fromkeys(JOINTS, 0.0), JOINTS[1]: 1.5}
    change = after(cell(), SetJointPositions("arm", level))
    lift = JointTrajectory("arm", (JOINTS[1],), np.array([0.0, 10.0]), np.array([[1.5], [1.4]]))
    snapshot = pictured(change)
    reach = float(tcp(change)[0, 3] - snapshot.world_t(snapshot.structure.node("arm.lbr_iiwa_link_2").uid)[0, 3])
    mass = 40.0
    inertial = Inertial(mass, np.eye(4), (0.1, 0.1, 0.1), (0.0, 0.0, 0.0))
    weight = NodeSpec("weight", Kind.PART, "hand", shifted(z=0.1), data=PartData(mass, inertial))
    enough = limited(change, "arm.lbr_iiwa_link_2", effort=mass * 9.81 * reach)
    assert checked(enough, lift).first_violation is None
    told = violated(after(enough, CreateNodes((weight,))), lift)
    assert (told.kind, told.joint, told.robot) == (ViolationKind.EFFORT, JOINTS[1], "arm")
    assert told.time == 0.0 and told.path_fraction == 0.0
    assert abs(told.value) > abs(told.limit) == pytest.approx(mass * 9.81 * reach)
    assert "N m" in told.message
    strong = limited(after(change, CreateNodes((weight,))), "arm.lbr_iiwa_link_2", effort=abs(told.value) * 1.01)
    assert checked(strong, lift).first_violation is None


def test_a_pose_out_of_reach_is_an_answer() -> None:
    change = cell()
    far = shifted(x=3.0, z=0.3)
    told = violated(change, PointToPoint("arm", PoseGoal(far)))
    assert told.kind is ViolationKind.REACH
    assert 1.0 < told.value < 3.0, "the iiwa reaches less than 1.3 m"
    assert (told.time, told.limit) == (None, 0.0)
    told = violated(change, Linear("arm", PoseGoal(shifted(x=2.0) @ tcp(change))))
    assert told.kind is ViolationKind.REACH
    assert told.path_fraction is not None and 0.0 < told.path_fraction < 1.0
    assert told.world_t_tcp is not None
    moved = told.path_fraction * np.array([2.0, 0.0, 0.0])
    np.testing.assert_allclose(told.world_t_tcp, shifted(*moved) @ tcp(change), atol=1e-5)
    assert told.value > 0.5


def test_the_margin_to_singularities_is_that_of_point_to_point_moves_too() -> None:
    """The iiwa is stretched where joint 4 is 0: half way of a move from -1.4 to 1.4."""
    change = cell()
    move = PointToPoint("arm", {JOINTS[3]: -READY[JOINTS[3]]})
    free = checked(change, move)
    assert free.first_violation is None
    told = violated(change, move, min_singular_value=0.05)
    assert told.kind is ViolationKind.SINGULARITY
    assert told.value < told.limit == 0.05
    assert told.time is not None and 0.0 < told.time < free.duration / 2.0
    assert free.min_singular_value is not None and free.min_singular_value < told.value
    assert checked(change, move, min_singular_value=free.min_singular_value * 0.999).first_violation is None
    assert violated(change, move, min_singular_value=free.min_singular_value * 1.001).kind is ViolationKind.SINGULARITY


def test_a_line_into_a_singularity_is_told_with_its_place() -> None:
    """A stretched arm: the line ends near the arm's whole length."""
    change = after(cell(), SelectTool("arm"))
    snapshot = pictured(change)
    here = snapshot.world_t(snapshot.structure.robots[snapshot.structure.node("arm").uid].flange)
    shoulder = snapshot.world_t(snapshot.structure.node("arm.lbr_iiwa_link_2").uid)[:3, 3]
    out = (here[:3, 3] - shoulder) / np.linalg.norm(here[:3, 3] - shoulder)
    told = violated(change, Linear("arm", PoseGoal(shifted(*(0.6 * out)) @ here)))
    assert told.kind in (ViolationKind.SINGULARITY, ViolationKind.REACH, ViolationKind.JOINT_POSITION)
    assert told.path_fraction is not None
    assert told.world_t_tcp is not None
    np.testing.assert_allclose(told.world_t_tcp[:3, 3], here[:3, 3] + told.path_fraction * 0.6 * out, atol=1e-4)


@pytest.mark.parametrize("locked", [(), (2,)], ids=["free", "locked"])
def test_a_line_that_meets_a_joint_s_end_is_told_with_time_and_place(locked: tuple[int, ...]) -> None:
    """The end is put where the line's middle has the joint: there the line is cut, by its own symmetric law."""
    change = cell()
    still = Redundancy({JOINTS[joint]: READY[JOINTS[joint]] for joint in locked})
    line = Linear("arm", PoseGoal(shifted(x=0.1) @ tcp(change)), redundancy=still)
    program = plan_motion(pictured(change), MotionSpec((line,)), chain, waiting).command.program
    plan = program.stages[0].plan
    assert plan is not None
    q = plan.tracks[0].path.evaluate(np.linspace(0.0, 1.0, 101))
    column = int(np.abs(q[-1] - q[0]).argmax())
    joint = [joint for joint in range(len(JOINTS)) if joint not in locked][column]
    end = "upper" if q[-1, column] > q[0, column] else "lower"
    told = violated(limited(change, f"arm.lbr_iiwa_link_{joint + 1}", **{end: float(q[50, column])}), line)
    assert (told.kind, told.joint) == (ViolationKind.JOINT_POSITION, JOINTS[joint])
    assert told.limit == q[50, column]
    assert told.path_fraction == pytest.approx(0.5, abs=1e-4)
    assert told.time == pytest.approx(program.duration / 2.0, abs=0.02)
    assert told.world_t_tcp is not None
    np.testing.assert_allclose(told.world_t_tcp, shifted(x=0.05) @ tcp(change), atol=1e-5)


def test_a_program_tells_step_and_time_of_all_of_it() -> None:
    change = cell()
    there, back = (MoveStep((PointToPoint("belt", {"slide": way}),)) for way in (1.0, -2.5))
    good = check_motion(pictured(change), MotionSpec(steps=(there, DwellStep(0.5))), chain, 0.0, waiting)
    assert good.first_violation is None
    wish = MotionSpec(steps=(there, DwellStep(0.5), back))
    told = check_motion(pictured(change), wish, chain, 0.0, waiting).first_violation
    assert told is not None
    assert (told.kind, told.step, told.limit) == (ViolationKind.JOINT_POSITION, 2, -2.0)
    assert told.path_fraction == pytest.approx(3.0 / 3.5, abs=1e-5)
    assert told.time == pytest.approx(good.duration + 0.35 + (3.0 - 0.5 * 0.35 / 2.0) / 0.5, abs=1e-5)


def test_what_comes_before_a_step_that_cannot_be_planned_is_told_first() -> None:
    change = limited(cell(), "belt.tray", acceleration=0.1)
    steps = (MoveStep((quintic(0.5, 2.0),)), MoveStep((PointToPoint("arm", PoseGoal(shifted(x=3.0))),)))
    told = check_motion(pictured(change), MotionSpec(steps=steps), chain, 0.0, waiting).first_violation
    assert told is not None
    assert (told.kind, told.step) == (ViolationKind.JOINT_ACCELERATION, 0)
    told = check_motion(pictured(cell()), MotionSpec(steps=steps), chain, 0.0, waiting).first_violation
    assert told is not None
    assert (told.kind, told.step, told.robot) == (ViolationKind.REACH, 1, "arm")


@pytest.mark.long
@pytest.mark.parametrize("law", TimeLaw)
def test_programs_that_can_be_planned_keep_the_joints_limits(law: TimeLaw, rng: np.random.Generator) -> None:
    """Lines and joint moves in any order, with zones or without; planner and check share nothing but the limits."""
    change = cell()
    here = tcp(change)

    def step() -> MoveStep:
        zone = Zone(meters=float(rng.uniform(0.005, 0.06))) if rng.random() < 0.8 else None
        if rng.random() < 0.4:
            goal = {name: READY[name] + float(rng.uniform(-0.4, 0.4)) for name in JOINTS}
            return MoveStep((PointToPoint("arm", goal, time_law=law),), zone)
        goal = PoseGoal(shifted(*rng.uniform(-0.15, 0.15, 3)) @ here)
        rates = (float(rng.uniform(0.1, 1.5)), float(rng.uniform(1.0, 8.0)))
        return MoveStep((Linear("arm", goal, 1.0, *rates, time_law=law),), zone)

    planned = 0
    for _ in range(4):
        wish = MotionSpec(steps=tuple(step() for _ in range(3)))
        found = check_motion(pictured(change), wish, chain, 0.0, waiting)
        if found.duration > 0.0:  # else it could not be planned
            planned += 1
            assert found.first_violation is None or found.first_violation.kind is ViolationKind.EFFORT, str(found)
    assert planned > 0


def test_what_is_no_motion_stays_an_error() -> None:
    change = cell()
    with pytest.raises(UnknownNameError):
        checked(change, PointToPoint("arn", {}))
    with pytest.raises(KernelError) as refused:
        checked(change, slid(np.array([0.0, 1.0]), np.array([0.5, 1.0])))
    assert refused.value.reason is Reason.INVALID_ARGUMENT, "it does not start where the joint is"


def test_a_caller_who_gives_up_ends_the_work() -> None:
    asked = 0

    def gone() -> bool:
        nonlocal asked
        asked += 1
        return asked > 2

    change = limited(cell(), "belt.tray", velocity=0.001)
    with pytest.raises(KernelError, match="nobody waits"):
        check_motion(pictured(change), MotionSpec((PointToPoint("belt", {"slide": 2.0}),)), chain, 0.0, gone)
    assert asked == 3, f"{2.0 / 0.001 / TICK:.0f} ticks are many chunks"
