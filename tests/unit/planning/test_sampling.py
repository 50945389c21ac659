"""A motion in samples: what the world then does tick by tick, and the same numbers by other ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.circle import Via
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_kernel.planning.moves import Circular, JointTrajectory, Linear, Move, PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import DwellStep, MotionSpec, MoveStep, Zone
from virtualrobot_kernel.planning.robots import arm_of, tip_t_tcp, world_poses
from virtualrobot_kernel.planning.sampling import MOST_NUMBERS, Samples, check_size, joint_states, sample_times, sampled
from virtualrobot_kernel.world.change import Change, joint_places
from virtualrobot_kernel.world.commands import AttachNode, SetJointPositions, StartMotion
from virtualrobot_kernel.world.tick import advance

from tests.unit.planning.cell import JOINTS, TICK, cell, chain, pictured, tcp
from tests.unit.planning.starts import start_of
from tests.unit.world.builders import after, shifted


def random_joints(rng: np.random.Generator) -> dict[str, float]:
    return dict(zip(JOINTS, rng.uniform(-1.0, 1.0, 7).tolist(), strict=True))


def random_moves(change: Change, rng: np.random.Generator, kind: str) -> list[Move]:
    here = tcp(change)
    if kind == "linear":
        return [Linear("arm", PoseGoal(shifted(*rng.uniform(-0.08, 0.08, 3)) @ here))]
    if kind == "circular":
        # The way is by the side of the chord: one beyond its end could need nearly all of a circle of metres.
        chord = rng.uniform(-0.08, 0.08, 3)
        via = here[:3, 3] + 0.5 * chord + np.cross(rng.uniform(-0.5, 0.5, 3), chord)
        return [Circular("arm", Via(via), shifted(*chord) @ here)]
    if kind == "trajectory":
        snapshot = pictured(change)
        start = snapshot.state.q[arm_of(snapshot, snapshot.structure.node("arm")).q_index]
        positions = start + np.vstack([np.zeros(7), rng.uniform(-0.3, 0.3, (3, 7))])
        return [JointTrajectory("arm", JOINTS, np.array([0.0, 0.701, 1.3, 2.0]), positions)]
    moves: list[Move] = [PointToPoint("arm", random_joints(rng))]
    return [*moves, PointToPoint("belt", {"slide": 0.7})] if kind == "group" else moves


def plan_of(command: StartMotion) -> Plan:
    """Return the plan of moves without a program."""
    (stage,) = command.program.stages
    assert stage.plan is not None
    return stage.plan


def samples_of(change: Change, command: StartMotion, seconds: float = TICK) -> Samples:
    program = command.program
    times = sample_times(program.duration, seconds)
    return sampled(pictured(change), program, command.joints, times, lambda: False)


KINDS = ("ptp", "linear", "circular", "trajectory", "group")


@pytest.mark.parametrize("kind", KINDS)
def test_the_world_does_at_each_tick_what_was_sampled(kind: str, rng: np.random.Generator) -> None:
    """The joints are the same bit for bit: what was shown is what runs."""
    change = cell()
    command = start_of(pictured(change), random_moves(change, rng, kind), chain)
    told = samples_of(change, command)
    assert np.all(np.diff(told.times) > 0.0)
    assert told.times[-1] == command.program.duration
    started = after(change, command)
    structure, state = started.structure, started.state
    for row in range(len(told.times)):
        world = world_poses(structure, state)
        moving = bool(state.motions)
        for robot in told.robots:
            q_index, v_index, _ = joint_places(structure, tuple((robot.robot.uid, name) for name in robot.joint_names))
            np.testing.assert_array_equal(state.q[q_index], robot.positions[row])
            np.testing.assert_array_equal(state.v[v_index], robot.velocities[row])
            if moving:
                accelerations = state.motions[0].running.sample()[2][list(robot.columns)]
                np.testing.assert_array_equal(accelerations, robot.accelerations[row])
            if robot.robot.name == "arm":
                here = world[structure.rows[structure.node("hand").uid]] @ shifted(z=0.1)
                np.testing.assert_allclose(robot.tools[0].world_t_tcp[row], here, atol=1e-12)
        assert moving == (row < len(told.times) - 1)
        state = advance(structure, state, TICK, world_poses)
    for robot in told.robots:
        np.testing.assert_array_equal(robot.positions[-1], plan_of(command).goal[list(robot.columns)])
        assert (
            not robot.velocities[-1].any()
            and not robot.accelerations[-1].any()
            and robot.tools[0].tcp_speeds[-1] == 0.0
        )


def test_the_world_runs_a_program_as_it_was_sampled(rng: np.random.Generator) -> None:
    """Zones, a dwell, two robots in turn: a stage begins with what its predecessor leaves of a tick."""
    change = cell()
    here = tcp(change)
    corner, end = (shifted(*rng.uniform(-0.08, 0.08, 3)) @ here for _ in range(2))
    steps = (
        MoveStep((Linear("arm", PoseGoal(corner)),), Zone(meters=0.02)),
        MoveStep((Linear("arm", PoseGoal(end)),)),
        MoveStep((PointToPoint("belt", {"slide": 0.3}),)),
        DwellStep(0.1234),
        MoveStep((PointToPoint("arm", random_joints(rng)), PointToPoint("belt", {"slide": 0.0}))),
    )
    command = plan_motion(pictured(change), MotionSpec(steps=steps), chain).command
    told = samples_of(change, command)
    assert told.steps.tolist() == sorted(told.steps) and set(told.steps) == {0, 1, 2, 3, 4}
    begins = [told.times[told.steps == step][0] for step in (3, 4)]
    assert begins[1] - begins[0] == pytest.approx(0.1234, abs=TICK)
    started = after(change, command)
    structure, state = started.structure, started.state
    for row in range(len(told.times)):
        for robot in told.robots:
            q_index, v_index, _ = joint_places(structure, tuple((robot.robot.uid, name) for name in robot.joint_names))
            np.testing.assert_allclose(state.q[q_index], robot.positions[row], atol=1e-9)
            np.testing.assert_allclose(state.v[v_index], robot.velocities[row], atol=1e-7)
        state = advance(structure, state, TICK, world_poses)
    assert not state.motions


def test_a_line_s_speed_is_its_law_s(rng: np.random.Generator) -> None:
    """Length times du/dt."""
    change = cell()
    command = start_of(pictured(change), random_moves(change, rng, "linear"), chain)
    told = samples_of(change, command)
    (arm,) = told.robots[0].tools
    length = np.linalg.norm(arm.world_t_tcp[-1, :3, 3] - arm.world_t_tcp[0, :3, 3])
    law = plan_of(command).tracks[0].time_law.states(told.times, 1)[1, :, 0]
    np.testing.assert_allclose(arm.tcp_speeds, length * law, atol=1e-6)


def test_the_speed_counts_what_carries_the_arm(rng: np.random.Generator) -> None:
    """The arm on the belt's tray, both on their way: against differences of the world's own forward pass."""
    change = after(cell(), AttachNode("stand", "belt.tray"))
    command = start_of(pictured(change), random_moves(change, rng, "group"), chain)
    told = samples_of(change, command, 0.03)
    arm = next(robot for robot in told.robots if robot.robot.name == "arm")
    structure, step = change.structure, 1e-6
    hand = structure.rows[structure.node("hand").uid]
    places = joint_places(structure, tuple((structure.node(robot).uid, name) for robot, name in command.joints))[0]

    def position(time: float) -> np.ndarray:
        q = change.state.q.copy()
        q[places] = joint_states(command.program, np.array([time]))[0][0]
        return (world_poses(structure, replace(change.state, q=q))[hand] @ shifted(z=0.1))[:3, 3]

    for time, speed in zip(told.times[1:-1], arm.tools[0].tcp_speeds[1:-1], strict=True):
        rate = (position(time + step) - position(time - step)) / (2 * step)
        assert speed == pytest.approx(np.linalg.norm(rate), abs=1e-6)


def test_singular_values_are_those_that_lines_are_judged_by(rng: np.random.Generator) -> None:
    """The component's own Jacobian, its linear rows over the longest lever arm at the start."""
    change = cell()
    snapshot = pictured(change)
    (arm,) = samples_of(change, start_of(snapshot, random_moves(change, rng, "ptp"), chain), 0.05).robots
    moved = arm_of(snapshot, arm.robot)
    kinematics = TcpKinematics(chain(snapshot, moved), tip_t_tcp(snapshot, moved))
    lever = np.linalg.norm(kinematics.jacobian(arm.positions[0])[:3], axis=0).max()
    for q, value in zip(arm.positions, arm.tools[0].singular_values, strict=True):
        jacobian = kinematics.jacobian(q)
        jacobian[:3] /= lever
        assert value == pytest.approx(np.linalg.svd(jacobian, compute_uv=False)[-1], abs=1e-9)


def test_a_motion_without_length_is_one_sample() -> None:
    change = cell()
    command = start_of(pictured(change), [PointToPoint("belt", {"slide": 0.0})], chain)
    told = samples_of(change, command)
    assert told.times.tolist() == [0.0]
    assert told.robots[0].positions.tolist() == [[0.0]]


def test_a_joint_limit_s_edge_is_told_too() -> None:
    """A goal exactly at a limit is within it; the dynamics mind limits as motions do."""
    change = after(cell(), SetJointPositions("belt", {"slide": 1.9}))
    command = start_of(pictured(change), [PointToPoint("belt", {"slide": 2.0})], chain)
    assert samples_of(change, command).robots[0].positions[-1, 0] == 2.0


def test_times_end_at_the_end() -> None:
    assert sample_times(0.01, 0.004).tolist() == [0.0, 0.004, 0.008, 0.01]
    assert sample_times(0.012, 0.004).tolist() == [0.0, 0.004, 0.008, 0.012]
    assert sample_times(0.012 + 1e-12, 0.004).tolist() == [0.0, 0.004, 0.008, 0.012 + 1e-12]
    assert sample_times(0.003, 0.004).tolist() == [0.0, 0.003]


def test_too_many_samples_are_refused_with_what_would_do() -> None:
    duration, joints = 3600.0, 7
    with pytest.raises(KernelError) as refused:
        check_size(duration, 0.004, joints, 1)
    assert refused.value.reason is Reason.TOO_LARGE
    most = int(refused.value.metadata["most"])
    assert refused.value.metadata["samples"] == str(round(duration / 0.004) + 1)
    assert most * (2 + 4 * joints + 8) <= MOST_NUMBERS
    seconds = float(str(refused.value).rpartition("sample_seconds of ")[2].partition(" ")[0])
    assert 0.9 * most < len(sample_times(duration, seconds)) <= most
    check_size(duration, seconds, joints, 1)
