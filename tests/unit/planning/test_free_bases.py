"""Motions of planar and floating joints: their ways against pinocchio, and their limits by formulas."""

from __future__ import annotations

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.running_motion import Phase
from virtualrobot_kernel.planning.check import check_motion
from virtualrobot_kernel.planning.moves import JointJog, JointTrajectory, PointToPoint
from virtualrobot_kernel.planning.program import MotionSpec, MoveStep, Zone
from virtualrobot_kernel.planning.relative_frame import axes_in_plane
from virtualrobot_kernel.planning.sampling import sample_times, sampled
from virtualrobot_kernel.planning.violations import ViolationKind
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    PauseMotion,
    ResumeMotion,
    SetJointPositions,
    SetMeasuredJoints,
    SetSpeedFactor,
    UpdateNode,
)
from virtualrobot_kernel.world.state import Cancellation, EndCause
from virtualrobot_kernel.world.structure import JointType, RobotData

from tests.tiers import Draws
from tests.unit.planning.cell import chain, pictured
from tests.unit.planning.crafts import (
    ACCELERATION,
    FLOATING,
    JERK,
    PLANAR,
    SPEED,
    anywhere,
    at,
    craft,
    model_of,
    moving,
    pinocchio_q,
    pinocchio_v,
    planned,
    run,
    standing,
)
from tests.unit.world.builders import TICK, after, empty, random_pose, ticked, world_t

KINDS = [PLANAR, FLOATING]
ANY = (0.36, 0.48, -0.8)


def ramp(distance: float) -> float:
    """Return how long the jerk-limited way takes that reaches SPEED and ACCELERATION (double S profile)."""
    return distance / SPEED + SPEED / ACCELERATION + ACCELERATION / JERK


def sizes(kind: JointType, values: np.ndarray) -> np.ndarray:
    """Return the lengths (n, 2) of the linear and the angular part of rates (n, nv)."""
    split = 2 if kind is PLANAR else 3
    return np.stack([np.linalg.norm(values[:, :split], axis=1), np.linalg.norm(values[:, split:-1], axis=1)], axis=1)


def test_a_planar_base_drives_straight_and_keeps_the_limit_along_its_way() -> None:
    world = moving(after(empty(), craft(PLANAR)), {"base/y": 4.0, "mast": 0.5, "base/theta": 1.0, "base/x": 3.0})
    assert world.state.motions[0].running.duration == pytest.approx(ramp(5.0))
    world, q, v = run(world)
    assert world.state.ended[-1].phase is Phase.SUCCEEDED
    assert world.state.q.tolist() == [3.0, 4.0, 1.0, 0.5]
    assert np.allclose(q[:, 1:], q[:, :1] / 3.0 * [4.0, 1.0, 0.5], atol=1e-12)
    assert np.linalg.norm(v[:, :2], axis=1).max() == pytest.approx(SPEED)


def test_theta_goes_by_the_plain_difference_as_a_continuous_joint() -> None:
    _, q, _ = run(moving(after(empty(), craft(PLANAR)), {"base/theta": 7.0}))
    assert q[-1, 2] == 7.0 and np.all(np.diff(q[:, 2]) >= 0.0)
    assert not q[:, :2].any()


@pytest.mark.parametrize("law", list(TimeLaw))
def test_a_floating_base_turns_as_slerp_does_and_shifts_straight(
    rng: np.random.Generator, draws: Draws, law: TimeLaw
) -> None:
    for _ in range(draws(20)):
        world, goal = standing(FLOATING, rng), anywhere(FLOATING, rng)
        start = world.state.q[:7]
        world = after(world, planned(world, PointToPoint("craft", at(FLOATING, goal), 1.0, time_law=law)).command)
        ends = pinocchio.Quaternion(start[3:]), pinocchio.Quaternion(goal[3:])
        angle = min(ends[0].angularDistance(ends[1]), 2 * np.pi - ends[0].angularDistance(ends[1]))
        if law is TimeLaw.JERK_LIMITED and angle > 1.0:
            way = max(float(np.linalg.norm(goal[:3] - start[:3])), angle)
            assert world.state.motions[0].running.duration == pytest.approx(ramp(way))
        world, q, v = run(world)
        share = np.linalg.norm(q[:, :3] - start[:3], axis=1) / np.linalg.norm(goal[:3] - start[:3])
        for u, one in zip(share, q, strict=True):
            assert np.allclose(one[:3], start[:3] + u * (goal[:3] - start[:3]), atol=1e-12)
            there = ends[0].slerp(float(u), ends[1]).coeffs()
            assert min(np.abs(there - one[3:7]).max(), np.abs(there + one[3:7]).max()) < 1e-11
        assert np.abs(np.linalg.norm(q[:, 3:7], axis=1) - 1.0).max() < 1e-13
        linear, angular = sizes(FLOATING, v).max(axis=0)
        assert max(linear, angular) <= SPEED * (1.0 + 1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_velocities_are_those_that_pinocchio_finds_between_ticks(kind: JointType, rng: np.random.Generator) -> None:
    model, count = model_of(kind), 3 if kind is PLANAR else 7
    _, q, v = run(moving(standing(kind, rng), at(kind, anywhere(kind, rng))))
    for before, here, later, velocity in zip(q, q[1:], q[2:], v[1:], strict=False):
        # The rate of change of second order, seen from where it is.
        ends = [pinocchio_q(kind, one[:count]) for one in (before, here, later)]
        ways = [pinocchio.difference(model, ends[1], end) for end in (ends[0], ends[2])]
        rate = (ways[1] - ways[0]) / (2.0 * TICK)
        assert np.allclose(rate, pinocchio_v(kind, here[:count], velocity[:-1]), atol=JERK * TICK**2)


@pytest.mark.parametrize("kind", KINDS)
def test_cancelled_and_paused_on_the_way_it_stays_on_it_and_keeps_its_limits(
    kind: JointType, rng: np.random.Generator, draws: Draws
) -> None:
    count = 3 if kind is PLANAR else 7
    for number in range(draws(10)):
        world, goal = standing(kind, rng), anywhere(kind, rng)
        _, whole, _ = run(moving(world, at(kind, goal)))
        world = ticked(moving(world, at(kind, goal)), int(rng.integers(1, len(whole) // 2)))
        id = world.state.motions[0].id
        if number % 2:
            world = ticked(after(world, PauseMotion(id), SetSpeedFactor("", 0.5)), 400)
            assert world.state.motions[0].phase is Phase.PAUSED
            world = ticked(after(world, ResumeMotion(id)), int(rng.integers(1, 100)))
        world = after(world, CancelMotion(id, Cancellation(EndCause.CALL, "")))
        world, q, v = run(world)
        assert world.state.ended[-1].phase in (Phase.CANCELLED, Phase.SUCCEEDED)
        assert not world.state.v.any()
        way = (whole[-1] - whole[0])[:2]
        for one in q:
            share = float(way @ (one - whole[0])[:2] / (way @ way))
            near = whole[:, :count][np.argmin(np.abs((whole - whole[0])[:, :2] @ way / (way @ way) - share))]
            assert np.abs(near - one[:count]).max() <= SPEED * TICK
        assert sizes(kind, np.diff(v, axis=0) / TICK).max() <= ACCELERATION * (1.0 + 2e-2)


@pytest.mark.parametrize("kind", KINDS)
def test_the_speed_of_a_tool_is_the_rate_of_its_place(kind: JointType, rng: np.random.Generator, draws: Draws) -> None:
    for _ in range(draws(5)):
        world = standing(kind, rng, axis=ANY, pose=random_pose(rng))
        goal = {**at(kind, anywhere(kind, rng)), "mast": 1.0}
        command = planned(world, PointToPoint("craft", goal)).command
        times = sample_times(command.program.duration, 1e-3)
        (robot,) = sampled(pictured(world), command.program, command.joints, times, lambda: False).robots
        tool = robot.tools[0]
        way = np.linalg.norm(tool.world_t_tcp[2:, :3, 3] - tool.world_t_tcp[:-2, :3, 3], axis=1) / 2e-3
        assert np.allclose(way[:-1], tool.tcp_speeds[1:-2], atol=1e-4)
        assert robot.efforts.shape == robot.positions.shape
        assert not robot.efforts[:, [name != "mast" for name in robot.joint_names]].any()


def test_axes_in_the_plane_are_those_of_the_forward_pass(rng: np.random.Generator) -> None:
    world = standing(PLANAR, rng, axis=ANY)
    here = world_t(world, "craft.body")[:3, 3]
    for name, axis in zip(("base/x", "base/y"), axes_in_plane(np.array(ANY)), strict=True):
        place = world.state.q[("base/x", "base/y").index(name)]
        there = world_t(after(world, SetJointPositions("craft", {name: float(place) + 1.0})), "craft.body")[:3, 3]
        assert np.allclose(there - here, axis, atol=1e-15)


def test_zones_join_the_ways_of_a_base_and_keep_the_limit_of_its_speed() -> None:
    steps = (
        MoveStep((PointToPoint("craft", {"base/x": 2.0, "base/y": 2.0}),), Zone(percent=40.0)),
        MoveStep((PointToPoint("craft", {"base/x": 4.0, "base/y": 0.0}),)),
    )
    world = after(empty(), craft(PLANAR))
    motion = planned(world, steps=steps)
    world, q, v = run(after(world, motion.command))
    assert not motion.notes and q[:, 1].max() < 2.0 - 0.05, "the corner is rounded"
    assert np.linalg.norm(v[:, :2], axis=1).max() <= SPEED * (1.0 + 1e-3)
    acceleration = np.diff(v[:, :2], axis=0) / TICK
    assert np.linalg.norm(acceleration, axis=1).max() <= ACCELERATION * (1.0 + 1e-2)


def test_a_corner_in_which_a_floating_base_turns_is_reached_at_rest() -> None:
    turn = {"base/qx": 0.0, "base/qy": 0.0, "base/qz": 1.0, "base/qw": 0.0}
    steps = (
        MoveStep((PointToPoint("craft", {"base/x": 1.0, **turn}),), Zone(percent=40.0)),
        MoveStep((PointToPoint("craft", {"base/x": 2.0}),)),
    )
    motion = planned(after(empty(), craft(FLOATING)), steps=steps)
    assert [note.message for note in motion.notes] == [
        "the corner after step 0 is reached exactly and at rest: step 0 can't be joined: it turns a floating joint"
    ]


def test_coordinates_of_a_base_move_each_in_a_motion_of_its_own() -> None:
    world = moving(after(empty(), craft(PLANAR)), {"base/x": 1.0})
    world = moving(world, {"base/theta": 1.0})
    with pytest.raises(KernelError) as busy:
        moving(world, {"base/theta": 0.5})
    assert busy.value.reason is Reason.ROBOT_BUSY
    world, _, _ = run(world)
    assert world.state.q.tolist() == [1.0, 0.0, 1.0, 0.0]


def test_motions_of_a_measured_base_go_on_from_what_is_commanded() -> None:
    world = after(empty(), craft(FLOATING))
    uid = world.structure.node("craft").uid
    measured = np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.6, 0.8, 0.0])
    world = ticked(after(world, SetMeasuredJoints(uid, measured, np.zeros(7))))
    world, _, _ = run(moving(world, {"base/x": 1.0, "base/qx": 0.0, "base/qy": 1.0, "base/qz": 0.0, "base/qw": 0.0}))
    assert np.allclose(world.state.q, measured)
    assert np.allclose(np.abs(world.state.commanded[uid].q), [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], atol=1e-12)


def test_a_posture_with_no_orientation_is_refused_when_it_is_given() -> None:
    made = craft(FLOATING)
    data = RobotData(flange="tip", postures={"up": at(FLOATING, np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]))})
    world = after(empty(), made, UpdateNode("craft", data=data))
    world, _, _ = run(after(world, planned(world, PointToPoint("craft", "up")).command))
    assert world.state.q[2] == 1.0
    for postures, words in (
        ({"up": {"base/qw": 1.0}}, "the posture 'up' of 'craft': .* turns by a quaternion; name all of"),
        ({"up": at(FLOATING, np.full(7, 1.0))}, "the posture 'up' of 'craft': .* of length 2; it must have length 1"),
    ):
        with pytest.raises(KernelError, match=words):
            after(world, UpdateNode("craft", data=RobotData(flange="tip", postures=postures)))


BAD = {
    "a joint of several coordinates": (
        PLANAR,
        {"base": 1.0},
        "'base' of 'craft' is planar and has several coordinates; name 'base/x', 'base/y', 'base/theta'",
    ),
    "a part of a quaternion": (
        FLOATING,
        {"base/qx": 1.0, "base/qw": 0.0},
        "turns by a quaternion; name all of 'base/qx', 'base/qy', 'base/qz', 'base/qw' or none",
    ),
    "a quaternion of length 2": (
        FLOATING,
        {"base/qx": 2.0, "base/qy": 0.0, "base/qz": 0.0, "base/qw": 0.0},
        r"the goal of 'craft' has the quaternion \[2.0, 0.0, 0.0, 0.0\] of length 2; it must have length 1, to 0.001",
    ),
    "no number": (PLANAR, {"base/theta": np.nan}, "it must be finite"),
    "another one's coordinate": (PLANAR, {"base/z": 1.0}, "'base/z'; did you mean"),
}


@pytest.mark.parametrize("case", BAD)
def test_goals_that_make_no_sense_are_refused(case: str) -> None:
    kind, goal, words = BAD[case]
    with pytest.raises((KernelError, UnknownNameError), match=words):
        moving(after(empty(), craft(kind)), goal)


@pytest.mark.parametrize("length", [0.0, 0.5, 1.0015])
def test_places_with_quaternions_that_are_not_unit_are_refused(length: float) -> None:
    world: Change = after(empty(), craft(FLOATING))
    values = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, length, 0.0])
    uid = world.structure.node("craft").uid
    for command in (
        SetJointPositions("craft", {}, values),
        SetJointPositions("craft", {"base/qw": length}),
        SetMeasuredJoints(uid, values),
    ):
        with pytest.raises(KernelError, match=f"'base' of 'craft' has the quaternion .* of length {length:g}"):
            after(world, command)
    rounded = after(world, SetJointPositions("craft", {"base/qw": 0.9995}))
    assert rounded.state.q[6] == 1.0


@pytest.mark.parametrize("given", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_trajectory_passes_its_samples_as_pinocchio_sees_it(
    kind: JointType, given: bool, rng: np.random.Generator, draws: Draws
) -> None:
    model = model_of(kind)
    for _ in range(draws(5)):
        world = standing(kind, rng)
        count = world.structure.q_count - 1
        times = np.cumsum([0.0, *(TICK * rng.integers(300, 500, 5))])
        rates = np.zeros((6, count))
        rates[1:-1, : count - 1 if kind is FLOATING else count] = rng.uniform(-0.1, 0.1, 3 if kind is PLANAR else 6)
        places = [pinocchio_q(kind, world.state.q[:count])]
        for span in np.diff(times):
            step = rng.uniform(-0.3, 0.3, model.nv) * span
            places.append(pinocchio.integrate(model, places[-1], step))
        samples = np.array(places) * rng.choice([1.0, -1.0], 6)[:, None] if kind is FLOATING else np.array(
            [[x, y, np.arctan2(sine, cosine)] for x, y, cosine, sine in places]
        )  # fmt: skip
        if kind is FLOATING:
            samples[:, :3] = np.array(places)[:, :3]  # a quaternion and its negative are one orientation
        else:
            samples[:, 2] = np.unwrap(samples[:, 2]) + world.state.q[2] - samples[0, 2]
        names = tuple(at(kind, samples[0]))
        move = JointTrajectory("craft", names, times, samples, rates if given else None)
        _, q, v = run(after(world, planned(world, move).command))
        for row, time in enumerate(times):
            there = pinocchio_q(kind, q[round(time / TICK), :count])
            assert np.abs(pinocchio.difference(model, there, places[row])).max() < 1e-9
            if given:
                assert np.allclose(v[round(time / TICK), : model.nv], rates[row, : model.nv], atol=1e-9)
        for before, here, later, velocity in zip(q, q[1:], q[2:], v[1:], strict=False):
            ends = [pinocchio_q(kind, one[:count]) for one in (before, here, later)]
            ways = [pinocchio.difference(model, ends[1], end) for end in (ends[0], ends[2])]
            rate = (ways[1] - ways[0]) / (2.0 * TICK)
            assert np.allclose(rate, pinocchio_v(kind, here[:count], velocity[:-1]), atol=1e-4)


def test_a_trajectory_that_turns_too_fast_or_is_no_orientation_is_refused() -> None:
    world = after(empty(), craft(FLOATING))
    names, times = tuple(at(FLOATING, np.zeros(7))), np.array([0.0, 1.0])
    here = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    half = np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.sin(0.5), np.cos(0.5)])
    # A quintic from rest to rest is 15/8 times as fast in the middle as on the mean.
    with pytest.raises(KernelError, match=r"joint 'base/qz' has velocity 1\.\d+, its limit is 1"):
        planned(world, JointTrajectory("craft", names, times, np.array([here, half])))
    with pytest.raises(KernelError, match=r"the joint 'base' of a trajectory at 1 s has the quaternion .* of length 2"):
        planned(world, JointTrajectory("craft", names, times, np.array([here, 2.0 * here])))
    spec = MotionSpec((JointTrajectory("craft", names, times, np.array([here, half])),))
    found = check_motion(pictured(world), spec, chain, 0.0, lambda: False).first_violation
    assert found and (found.kind, found.joint, found.limit) == (
        ViolationKind.JOINT_ACCELERATION,
        "base/qz",
        ACCELERATION,
    )


@pytest.mark.parametrize(("joint", "place"), [("base/x", 0), ("base/y", 1), ("base/theta", 2)])
def test_a_base_is_jogged_by_its_coordinates(joint: str, place: int, rng: np.random.Generator) -> None:
    world = standing(PLANAR, rng)
    after_jog, _, v = run(after(world, planned(world, JointJog("craft", joint, -0.5, 0.3)).command))
    assert after_jog.state.q[place] == pytest.approx(world.state.q[place] - 0.3, abs=1e-12)
    assert v[:, place].min() == pytest.approx(-0.5) and not np.delete(v, place, axis=1).any()
    if joint == "base/theta":
        turned, _, _ = run(after(world, planned(world, JointJog("craft", joint, 0.5)).command))
        assert turned.state.q[2] == pytest.approx(world.state.q[2] + 2.0 * np.pi)
    else:
        with pytest.raises(KernelError, match=f"joint '{joint}' has no limit that way, so its jog needs a distance"):
            planned(world, JointJog("craft", joint, 0.5))
