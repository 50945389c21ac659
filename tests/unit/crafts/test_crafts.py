"""Crafts in a world: bases go where their drives take them, are replayed without components, and stop on faults."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.collision.guard import CollisionGuard
from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.motion.limits import JointLimits as MotionLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import of_plan
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import (
    CreateNodes,
    RemoveNode,
    SetCollisionSettings,
    SetCraft,
    SetJointPositions,
    SetSetpoint,
    StartMotion,
    StartSetpointMotion,
    StopMotions,
)
from virtualrobot_kernel.world.craft_data import Craft, CraftDrive
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import replay
from virtualrobot_kernel.world.state import EndCause
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData

from tests.unit.collision.worlds import SHAPES
from tests.unit.crafts.rover import DRIVES, RADIUS, TRACK, TWO_WHEELS, Yard, rover, yard
from tests.unit.journals import entries_of
from tests.unit.world.builders import TICK, empty, link, shifted


@pytest.fixture
def course() -> Iterator[Yard]:
    with yard(rover()) as made:
        yield made


@pytest.mark.parametrize("base", [JointType.PLANAR, pytest.param(JointType.FLOATING, marks=pytest.mark.long)])
def test_equal_speeds_take_it_straight_and_others_on_a_circle(base: JointType) -> None:
    with yard(rover(base=base)) as course:
        id = course.drive(4.0, 4.0)
        course.step(500)
        x, y, heading = course.base
        wheel = course.world.snapshot.state.q[-1]
        assert (x, y, heading) == (pytest.approx(RADIUS * wheel), pytest.approx(0.0, abs=1e-12), pytest.approx(0.0))
        assert wheel > 7.0
        course.do(SetSetpoint(id, (3.0, 5.0)))
        course.step(500)
        before = course.base
        course.step(250)
        after = course.base
        # One second at 0.4 m/s and 0.4 rad/s: a circle of one meter.
        chord, middle = 2.0 * math.sin(0.2), before[2] + 0.2
        np.testing.assert_allclose(after[:2] - before[:2], [chord * np.cos(middle), chord * np.sin(middle)], atol=1e-9)
        assert after[2] - before[2] == pytest.approx(0.4)


@pytest.mark.parametrize("base", [JointType.PLANAR, pytest.param(JointType.FLOATING, marks=pytest.mark.long)])
def test_velocities_of_the_base_are_those_of_its_coordinates_and_it_rests_in_the_end(base: JointType) -> None:
    with yard(rover(base=base)) as course:
        id = course.drive(3.0, 5.0)
        course.step(700)
        turning = 2 if base is JointType.PLANAR else 5
        before, v = course.base, course.world.snapshot.state.v
        course.step()
        np.testing.assert_allclose(v[[0, 1, turning]], (course.base - before) / TICK, atol=1e-3)
        assert v[turning] == pytest.approx(0.4)
        course.do(SetSetpoint(id, (0.0, 0.0)))
        course.step(500)
        there = course.base
        state = course.step(10).state
        assert not state.v.any()
        np.testing.assert_array_equal(course.base, there)
        entries = len(entries_of(course.world))
        course.step(10)
        assert len(entries_of(course.world)) == entries  # what rests says nothing


def test_a_replay_needs_no_component(course: Yard) -> None:
    course.drive(3.0, 5.0)
    last = course.step(300)
    begin = empty()
    again = replay(begin.structure, begin.state, entries_of(course.world), last.state.tick, TICK, world_poses)
    assert same(image_of(last.structure, last.state), image_of(again.structure, again.state)) == ""
    assert course.base[0] > 0.3


def test_its_base_is_no_joint_to_be_moved_by_itself_but_may_be_put_elsewhere(course: Yard) -> None:
    with pytest.raises(
        KernelError, match=r"'base/x' is moved by the drives of the craft 'rover'; move these"
    ) as caught:
        course.do(StartSetpointMotion("rover", ("base/x",), SetpointMode.VELOCITY, 1.0))
    assert caught.value.reason is Reason.WRONG_STATE
    course.do(SetJointPositions("rover", {"base/x": 3.0, "base/theta": math.pi / 2.0}))
    course.drive(4.0, 4.0)
    course.step(250)
    assert course.base[0] == pytest.approx(3.0)
    assert course.base[1] > 0.2


@pytest.mark.long
def test_it_is_another_craft_while_it_runs_and_none_at_last(course: Yard) -> None:
    course.drive(4.0, 4.0)
    with pytest.raises(KernelError) as caught:
        course.choose(None)
    assert caught.value.reason is Reason.ROBOT_BUSY
    course.do(StopMotions(()))
    course.step(200)
    wider = replace(TWO_WHEELS, settings={"track_meters": 2.0 * TRACK, "wheel_radius_meters": RADIUS})
    course.choose(wider)
    course.drive(-5.0, 5.0)
    course.step(500)
    state = course.world.snapshot.state
    assert course.base[2] == pytest.approx(state.q[-1] * RADIUS / TRACK)
    course.do(StopMotions(()))
    course.step(200)
    course.choose(None)
    before = course.base
    course.do(StartSetpointMotion("rover", ("base/x",), SetpointMode.VELOCITY, 1.0))
    course.drive(4.0, 4.0)
    course.step(100)
    np.testing.assert_array_equal(course.base, before)


def test_a_twist_beyond_limits_steers_nothing_and_costs_no_craft_its_ticks(
    course: Yard, caplog: pytest.LogCaptureFixture
) -> None:
    """Refused as it comes, and in a tick too, where limits of the drives are met as a steering angle turns."""
    (id,) = course.do(StartSetpointMotion("rover", ("left", "right"), SetpointMode.VELOCITY, 60.0))
    uid = course.world.snapshot.structure.node("rover").uid
    course.do(SetSetpoint(str(id), course.crafts.follow(str(id), uid, np.array([0.4, 0.0, 0.0]))))
    course.step(200)
    for _ in range(3):
        with pytest.raises(KernelError, match="'left' would move at 200, its limit is 20"):
            course.crafts.follow(str(id), uid, np.array([20.0, 0.0, 0.0]))
        course.step(10)
    assert course.base[0] == pytest.approx(RADIUS * course.world.snapshot.state.q[-1])
    assert course.world.snapshot.state.v[-1] == pytest.approx(4.0)
    course.crafts._twists[str(id)] = course.crafts._twists[str(id)]._replace(twist=np.array([20.0, 0.0, 0.0]))
    ended = course.step(400).state.ended[-1].cancellation
    assert ended is not None
    assert (ended.cause, "its limit is 20" in ended.reason) == (EndCause.SETPOINT_REFUSED, True)
    assert course.base[0] == pytest.approx(RADIUS * course.world.snapshot.state.q[-1])
    assert not caplog.records


@pytest.mark.long
def test_wheels_may_turn_backwards_and_stand_off_the_middle() -> None:
    """The left wheel's axis points the other way, with a gear of 2; the axle is 0.2 m behind the base's origin."""
    drives = (CraftDrive("left_wheel", "left", -2.0), CraftDrive("right_wheel", "right"))
    with yard(rover(replace(TWO_WHEELS, drives=drives, center_x=-0.2))) as course:
        course.drive(8.0, 4.0)
        course.step(400)
        x, y, heading = course.base
        left, right = course.world.snapshot.state.q[-2:]
        assert heading == pytest.approx((right + left / 2.0) * RADIUS / TRACK)
        axle = np.array([x, y]) - 0.2 * np.array([math.cos(heading), math.sin(heading)])
        np.testing.assert_allclose(axle, [-0.2, 0.0], atol=0.02)  # while it gathers speed its wheels differ


@pytest.mark.long
def test_passive_wheels_turn_as_they_roll_and_a_steering_angle_follows_its_linkage() -> None:
    """Of a bicycle the left wheel steers, and the right one, ahead of nothing, stands for the rear wheel."""
    drives = (CraftDrive("steering", "left"), CraftDrive("front_wheel", "right"))
    settings = {"wheelbase_meters": 1.0, "wheel_radius_meters": RADIUS, "driven": "front"}
    with yard(rover(Craft("bicycle", settings, drives))) as course:
        course.drive(0.0, 4.0)
        course.step(500)
        assert course.base[0] == pytest.approx(course.world.snapshot.state.q[-1] * RADIUS)
        course.do(StopMotions(()))
        course.step(300)
        course.do(SetJointPositions("rover", {"left": 0.3, "base/x": 0.0}))
        course.drive(0.0, 4.0)
        before = course.world.snapshot.state.q[-1]
        course.step(500)
        turned = course.world.snapshot.state.q[-1] - before
        assert course.base[2] == pytest.approx(turned * RADIUS * math.sin(0.3))


@pytest.mark.parametrize(
    ("craft", "said"),
    [
        (
            Craft("differential", TWO_WHEELS.settings, (CraftDrive("left_wheel", "lef"),)),
            "'left_wheel' of 'rover'.*'lef'",
        ),
        (replace(TWO_WHEELS, drives=(DRIVES[0], DRIVES[0])), "is named twice"),
        (replace(TWO_WHEELS, drives=(CraftDrive("left_wheel", "left", 0.0),)), "has the ratio 0"),
        (replace(TWO_WHEELS, base_joint="left"), "planar or floating joint of 'rover'"),
        (
            replace(TWO_WHEELS, drives=(DRIVES[0], CraftDrive("right_wheel", "left"))),
            "the drive 'right_wheel' of 'rover' moves 'left', which another drive moves already",
        ),
    ],
)
def test_what_is_no_craft_is_refused(course: Yard, craft: Craft, said: str) -> None:
    with pytest.raises(KernelError, match=said):
        course.choose(craft)


def test_two_drives_have_two_joints_of_any_names() -> None:
    """Names of drives and of joints are two things; a drive that is not named is the joint of its own name."""
    wheels = {"left": "left_wheel", "right": "right_wheel"}
    made = rover(craft=None)
    specs = tuple(
        replace(spec, data=replace(spec.data, joint=replace(spec.data.joint, name=wheels[spec.data.joint.name])))
        if isinstance(spec.data, LinkData) and spec.data.joint and spec.data.joint.name in wheels
        else spec
        for spec in made.specs
    )
    with yard(replace(made, specs=specs)) as course:
        swapped = (CraftDrive("left_wheel", "right_wheel"), CraftDrive("right_wheel", "left_wheel"))
        course.choose(replace(TWO_WHEELS, drives=swapped))
        course.drive(2.0, 1.0, joints=("left_wheel", "right_wheel"))
        course.step(100)
        assert course.base[2] > 0.0  # the left wheel is told as the right one is, so that it turns to the left
        with pytest.raises(KernelError, match="'right_wheel' of 'rover' would be moved by the drives 'left_wheel' and"):
            course.crafts.check([SetCraft("rover", replace(TWO_WHEELS, drives=swapped[:1]))])


def test_a_robot_without_a_base_that_moves_is_no_craft() -> None:
    with (
        pytest.raises(KernelError, match="no planar or floating joint that its drives could move; load"),
        yard(rover(base=JointType.FIXED)),
    ):
        pass


def test_drives_of_one_name_are_told(course: Yard, monkeypatch: pytest.MonkeyPatch) -> None:
    called = ComponentHandle.call

    def twice(self: ComponentHandle, name: str, *arguments: object) -> object:
        return ("left_wheel", "left_wheel") if name == "drive_names" else called(self, name, *arguments)

    monkeypatch.setattr(ComponentHandle, "call", twice)
    with pytest.raises(KernelError, match="component 'differential' has the drive 'left_wheel' twice"):
        course.crafts.check([SetCraft("rover", TWO_WHEELS)])


@pytest.mark.parametrize(
    ("method", "answer", "said"),
    [
        ("step", (np.full((4, 4), np.nan), np.zeros(2)), "step returned .*nan.*; all must be finite"),
        *(
            pytest.param(*one, marks=pytest.mark.long)
            for one in (
                ("step", 7, "step returned int; it must be a pose"),
                ("step", (2.0 * np.eye(4), np.zeros(2)), "a pose that is not rigid"),
                ("step", (shifted(z=0.1), np.zeros(2)), "step tilts or lifts the base"),
                ("step", (shifted(x=1e77), np.zeros(2)), "all must be within 1e\\+09"),
                ("base_twist", RuntimeError("boom"), "boom"),
            )
        ),
    ],
)
def test_a_component_that_fails_stops_its_craft_and_no_other(
    course: Yard, monkeypatch: pytest.MonkeyPatch, method: str, answer: object, said: str
) -> None:
    course.drive(4.0, 4.0)
    course.step(100)
    called = ComponentHandle.call

    def wrong(self: ComponentHandle, name: str, *arguments: object) -> object:
        if name == method:
            if isinstance(answer, Exception):
                raise KernelError(str(answer), reason=Reason.PLUGIN_FAILED)
            return answer
        return called(self, name, *arguments)

    monkeypatch.setattr(ComponentHandle, "call", wrong)
    there = course.base
    snapshot = course.step(200)
    monkeypatch.undo()
    assert np.abs(course.base - there).max() < 1e-12
    assert not snapshot.state.v.any()
    assert not snapshot.state.motions
    cancellation = snapshot.state.ended[-1].cancellation
    assert cancellation is not None
    assert cancellation.cause is EndCause.FAILED
    uid = snapshot.structure.node("rover").uid
    with pytest.raises(KernelError, match=said):
        raise KernelError(course.crafts.fault_of(uid))
    with pytest.raises(KernelError, match="the craft 'rover' stands"):
        course.do(StartSetpointMotion("rover", ("left", "right"), SetpointMode.VELOCITY, 1.0))
    course.choose(replace(TWO_WHEELS))
    course.drive(4.0, 4.0)
    course.step(100)
    assert course.base[0] > there[0]


def test_a_craft_that_goes_takes_its_component_with_it(course: Yard) -> None:
    course.drive(4.0, 4.0)
    course.step(10)
    course.do(StopMotions(()))
    course.step(200)
    course.do(RemoveNode("rover"))
    assert course.step(10).state.tick == 220


@pytest.mark.parametrize(
    "speeds", [(6.0, 6.0), *(pytest.param(one, marks=pytest.mark.long) for one in ((4.0, 5.0), (-5.0, 5.0)))]
)
def test_a_guarded_craft_on_setpoints_stops_before_a_wall(course: Yard, speeds: tuple[float, float]) -> None:
    """However it comes: straight, on an arc, and with a corner as it turns on the spot."""
    CollisionGuard(SHAPES, course.world, course.crafts.carry)
    face = 0.33 if speeds[0] < 0.0 else 0.9
    wall = NodeSpec("wall", Kind.OBJECT, "world", shifted(x=face + 0.1), figures=(Figure(Box((0.2, 4.0, 1.0))),))
    course.do(CreateNodes((wall,)), SetCollisionSettings(CollisionMode.GUARD))
    course.drive(*speeds)
    corners = np.array([[x, y, 0.0, 1.0] for x in (-0.3, 0.3) for y in (-0.2, 0.2)])
    body = course.world.snapshot.structure.node("rover.hull").uid
    for _ in range(60):
        now = course.step(10)
        gap = face - float((now.world_t(body) @ corners.T)[0].max())
        assert gap > 0.0
    assert gap < 0.02
    cancellation = now.state.ended[-1].cancellation
    assert cancellation is not None
    assert cancellation.cause is EndCause.COLLISION
    assert not now.state.v.any()


@pytest.mark.long
def test_a_guarded_craft_on_a_planned_motion_of_its_wheels_stops_too_and_its_arm_is_carried(course: Yard) -> None:
    """The path of the wheels tells nothing of the base: it is followed through the component."""
    CollisionGuard(SHAPES, course.world, course.crafts.carry)
    turning = Joint("m", JointType.REVOLUTE, (0.0, 0.0, 1.0), JointLimits(-2.0, 2.0))
    arm = NodeSpec("arm", Kind.ROBOT, "rover.hull", shifted(z=0.2), data=RobotData())
    course.do(CreateNodes((arm, link("arm.mast", "arm", turning))))
    wall = NodeSpec("wall", Kind.OBJECT, "world", shifted(x=1.0), figures=(Figure(Box((0.2, 4.0, 1.0))),))
    course.do(CreateNodes((wall,)), SetCollisionSettings(CollisionMode.GUARD))
    course.do(planned("rover", {"left": 20.0, "right": 20.0}), planned("arm", {"m": 1.5}))
    now = course.step(900)
    end = next(one for one in now.state.ended if "left" in [name for _, name in one.joints])
    assert end.cancellation is not None
    assert end.cancellation.cause is EndCause.COLLISION
    assert 0.0 < 0.9 - 0.3 - course.base[0] < 0.01
    np.testing.assert_allclose(now.world_t(now.structure.node("arm.mast").uid)[:2, 3], course.base[:2], atol=1e-12)


def planned(robot: str, goals: dict[str, float]) -> StartMotion:
    """Return a motion of joints from 0 to goals."""
    names = tuple(goals)
    limits = MotionLimits(names, *(np.full(len(names), value) for value in (-99.0, 99.0, 8.0, 20.0, 200.0)))
    plan = plan_ptp([0.0] * len(names), [*goals.values()], limits)
    return StartMotion(tuple((robot, name) for name in names), of_plan(plan))
