"""Where all goes when it brakes now: the same as when the ticks are made, of all kinds of motion, at any moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode, SetpointMotion
from virtualrobot_kernel.planning.moves import Linear, PointToPoint, ToolStateMove
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import DwellStep, MotionSpec, MoveStep, SetSignalStep, Zone
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.braking import braking, braking_of, going
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    Command,
    CreateSignal,
    PauseMotion,
    SetSetpoint,
    SetSpeedFactor,
    StartSetpointMotion,
    StopMotions,
)
from virtualrobot_kernel.world.state import Signal

from tests.unit.planning.cell import JOINTS, TICK, cell, chain, pictured, tcp
from tests.unit.world.builders import after, ticked


def line(change: Change, rng: np.random.Generator) -> Linear:
    goal = tcp(change)
    goal[:3, 3] += rng.uniform(-0.1, 0.1, 3)
    return Linear("arm", PoseGoal(goal), max_velocity=0.8, max_acceleration=4.0)


def belt(rng: np.random.Generator) -> PointToPoint:
    return PointToPoint("belt", {"slide": float(rng.uniform(0.3, 1.0))})


def planned(change: Change, wish: MotionSpec) -> Command:
    return plan_motion(pictured(change), wish, chain).command


def point_to_point(change: Change, rng: np.random.Generator) -> list[Command]:
    goal = dict(zip(JOINTS, rng.uniform(-1.5, 1.5, 7).tolist(), strict=True))
    return [planned(change, MotionSpec((PointToPoint("arm", goal),))), planned(change, MotionSpec((belt(rng),)))]


def group(change: Change, rng: np.random.Generator) -> list[Command]:
    return [planned(change, MotionSpec((line(change, rng), belt(rng))))]


def program(change: Change, rng: np.random.Generator) -> list[Command]:
    steps = (
        *(MoveStep((line(change, rng),), Zone(0.03)) for _ in range(2)),
        MoveStep((line(change, rng),)),
        SetSignalStep("lamp", True),
        MoveStep((ToolStateMove("arm", "hand", "off"),)),
        DwellStep(0.1),
        MoveStep((belt(rng),)),
        MoveStep((ToolStateMove("arm", "hand", "on"), line(change, rng))),
    )
    return [planned(change, MotionSpec(steps=steps))]


def setpoints(change: Change, rng: np.random.Generator) -> list[Command]:
    return [StartSetpointMotion("arm", JOINTS, SetpointMode(str(rng.choice(["POSITION", "VELOCITY"]))), 10.0)]


def another_setpoint(change: Change, rng: np.random.Generator) -> list[Command]:
    """Return the next setpoint of the first motion; nothing where that is another kind of motion."""
    motion = change.state.motions[0]
    if not isinstance(motion.running, SetpointMotion):
        return []
    limits, wanted = motion.running.limits, rng.uniform(-1.0, 1.0, 7)
    if motion.running.mode is SetpointMode.POSITION:
        wanted = np.clip(change.state.q[motion.q_index] + 0.01 * wanted, limits.lower, limits.upper)
    return [SetSetpoint(motion.id, tuple(wanted.tolist()))]


@pytest.mark.parametrize("made", [point_to_point, group, program, setpoints])
def test_it_is_what_the_ticks_are(
    made: Callable[[Change, np.random.Generator], list[Command]], rng: np.random.Generator
) -> None:
    change = after(cell(), CreateSignal(Signal("lamp", False)))
    change = after(change, *made(change, rng))
    looked = 0
    for _ in range(400):
        if not change.state.motions:
            break
        chance = rng.random()
        motion = change.state.motions[0]
        if given := another_setpoint(change, rng):
            change = after(change, *given)
        elif chance < 0.01:
            change = after(change, SetSpeedFactor("", float(rng.uniform(0.1, 1.0))))
        elif chance < 0.012:
            change = after(change, PauseMotion(motion.id))
        if chance > 0.9:
            looked += 1
            way = braking(change.structure, change.state, TICK, world_poses)
            assert way.ends
            now = after(change, StopMotions())
            for row, at in enumerate(way.positions):
                np.testing.assert_allclose(at, now.state.q, atol=1e-9, err_msg=f"row {row} of {len(way.positions)}")
                tools = [held for begin, held in way.tools if begin <= row][-1]
                if row + 1 < len(way.positions):
                    assert tools == now.state.tool_states
                    now = ticked(now)
            assert not now.state.motions or not ticked(now).state.motions
            np.testing.assert_allclose(way.positions[-1], ticked(now).state.q, atol=1e-9)
        change = ticked(change)
    assert looked


def test_the_way_with_the_tick_before() -> None:
    change = ticked(after(cell(), *point_to_point(cell(), np.random.default_rng(1))), 40)
    later = ticked(change)
    way = braking(later.structure, later.state, TICK, world_poses)
    whole = way.after(change.structure, change.state, later.state.motions)
    assert whole.tick == change.state.tick
    assert (whole.positions[0] == change.state.q).all() and (whole.positions[1:] == way.positions).all()
    assert whole.tools == way.tools
    looks_otherwise = replace(change.state, tool_states={**change.state.tool_states})
    other = way.after(change.structure, looks_otherwise, later.state.motions)
    assert [row for row, _ in other.tools] == [0, 1]


def test_the_way_of_some_robots_is_theirs_in_the_way_of_all() -> None:
    change = ticked(after(cell(), *point_to_point(cell(), np.random.default_rng(1))), 40)
    arm, belt_there = (change.structure.robots[change.structure.node(name).uid].q_slice for name in ("arm", "belt"))
    uid = change.structure.node("arm").uid
    whole = braking(change.structure, change.state, TICK, world_poses)
    own = braking_of({uid}, change.structure, change.state, TICK, world_poses)
    count = len(own.positions)
    assert own.ends and (own.positions[:, arm] == whole.positions[:count, arm]).all()
    assert (whole.positions[count:, arm] == own.positions[-1, arm]).all()
    assert np.ptp(whole.positions[:, belt_there]) > 0.0 == np.ptp(own.positions[:, belt_there])
    nobody = braking_of({0}, change.structure, change.state, TICK, world_poses)
    assert nobody.ends and (nobody.positions == change.state.q).all() and len(nobody.positions) == 1


def test_the_way_of_a_robot_that_goes_along_with_a_joint_is_that_of_all() -> None:
    change = ticked(after(cell(), *point_to_point(cell(), np.random.default_rng(1))), 40)
    uid, belt_uid = (change.structure.node(name).uid for name in ("arm", "belt"))
    motions = (replace(change.state.motions[0], tracked_joint=(belt_uid, "slide")), change.state.motions[1])
    state = replace(change.state, motions=motions)
    assert motions[0].robots == (uid,)
    whole = braking(change.structure, state, TICK, world_poses)
    own = braking_of({uid}, change.structure, state, TICK, world_poses)
    assert np.array_equal(own.positions, whole.positions)
    assert np.ptp(own.positions[:, change.structure.robots[belt_uid].q_slice]) > 0.0


def test_who_goes_and_who_brakes_already() -> None:
    change = ticked(after(cell(), *point_to_point(cell(), np.random.default_rng(2))), 40)
    robots = {uid for motion in change.state.motions for uid in motion.robots}
    assert going(change.state) == robots
    belt_alone = after(change, StopMotions(("arm",)))
    assert going(belt_alone.state) == {change.structure.node("belt").uid}
    assert not going(after(change, StopMotions()).state)
