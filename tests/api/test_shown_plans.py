"""Plans that were shown, over TCP: started as they were, or refused with what has changed in what they used."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from virtualrobot.v1 import collision_pb2, geometry_pb2, motion_pb2, nodes_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, Refusal, apply, box, create, joints, load, refusal, start
from tests.api.moving import READY, linear
from tests.api.reading import matrix, state, step, values
from tests.kernels import Stubs

CONTINUE = motion_pb2.DISCONNECT_POLICY_CONTINUE
TURN = joints("arm", lbr_iiwa_joint_1=0.5)


@pytest.fixture
def cell(stepped: Stubs) -> Stubs:
    """Give a kernel with an arm at READY, another one, and boxes that are far from both."""
    load(stepped, IIWA, "arm")
    load(stepped, IIWA, "other", parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(y=4.0)))
    jump = scene_pb2.SetJointPositions(robot="arm", joint_positions=READY)
    apply(stepped, scene_pb2.Command(set_joint_positions=jump), create(box("box", x=3.0)), create(box("lid", x=4.0)))
    return stepped


def plan(stubs: Stubs, move: motion_pb2.Move = TURN) -> motion_pb2.PlanMotionResponse:
    return stubs.motion.PlanMotion(motion_pb2.PlanMotionRequest(spec=motion_pb2.MotionSpec(moves=[move])))


def check(stubs: Stubs, **fields: object) -> motion_pb2.CheckMotionResponse:
    said = fields or {"spec": motion_pb2.MotionSpec(moves=[TURN])}
    return stubs.motion.CheckMotion(motion_pb2.CheckMotionRequest(**said))  # pyright: ignore[reportArgumentType]


def begin(stubs: Stubs, reference: motion_pb2.PlanReference, **fields: object) -> motion_pb2.Motion:
    request = motion_pb2.StartMotionRequest(plan=reference, on_disconnect=CONTINUE, **fields)  # pyright: ignore[reportArgumentType]
    return stubs.motion.StartMotion(request).motion


def outdated(stubs: Stubs, reference: motion_pb2.PlanReference) -> Refusal:
    refused = refusal(lambda: begin(stubs, reference))
    assert (refused.reason, refused.metadata["plan"]) == ("PLAN_OUTDATED", reference.id), refused
    assert not stubs.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions
    return refused


def test_a_plan_is_started_as_it_was_shown_and_as_often_as_it_fits(cell: Stubs) -> None:
    """A plan that its client forgets is planned no more; another plan of the same motion has the same digest."""
    here = matrix(state(cell, "arm").world_t_tcp)
    goal = here.copy()
    goal[2, 3] -= 0.1
    shown, again = plan(cell, linear("arm", goal)), plan(cell, linear("arm", goal))
    assert shown.plan.id != again.plan.id and len(shown.plan.digest) == 64
    assert shown.plan.digest == again.plan.digest != plan(cell).plan.digest
    motion = begin(cell, shown.plan)
    assert motion.planned_duration_seconds == shown.duration_seconds
    (told,) = shown.robots
    for positions, velocities in zip(values(told.positions), values(told.velocities), strict=True):
        here = state(cell, "arm")  # bit for bit
        np.testing.assert_array_equal(here.positions, positions)
        np.testing.assert_array_equal(here.velocities, velocities)
        step(cell, 1)
    refused = outdated(cell, again.plan)
    assert (refused.metadata["node"], refused.metadata["aspect"]) == ("arm", "START")
    assert "'lbr_iiwa_joint_1' of 'arm' stands at" in refused.metadata["changes"] and "plan again" in refused.message
    back = scene_pb2.SetJointPositions(robot="arm", joint_positions=READY)
    apply(cell, scene_pb2.Command(set_joint_positions=back))
    held = begin(cell, again.plan, hold=True)
    step(cell, 5)
    assert cell.motion.GetMotion(motion_pb2.GetMotionRequest(id=held.id)).motion.phase == motion_pb2.MOTION_PHASE_PAUSED


def moved(name: str, x: float = 3.0, y: float = 0.0, z: float = 0.5) -> scene_pb2.Command:
    pose = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x, y=y, z=z))
    return scene_pb2.Command(attach_node=scene_pb2.AttachNode(name=name, parent_t_node=pose))


def turned(robot: str, **positions: float) -> scene_pb2.Command:
    put = scene_pb2.SetJointPositions(robot=robot, joint_positions=positions or {"lbr_iiwa_joint_2": 0.1})
    return scene_pb2.Command(set_joint_positions=put)


def may_touch(*pairs: tuple[str, str], never: bool = False) -> scene_pb2.Command:
    named = [nodes_pb2.NodePair(first=first, second=second) for first, second in pairs]
    said = collision_pb2.SetAllowedPairs(forbid=named if never else (), allow=() if never else named)
    return scene_pb2.Command(set_allowed_pairs=said)


def padded(name: str, meters: float) -> scene_pb2.Command:
    padding = collision_pb2.NodePadding(node=name, padding_meters=meters)
    return scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings(paddings=[padding]))


def other_size(name: str, meters: float) -> scene_pb2.Command:
    node = box(name)
    node.figures[0].box.size.CopyFrom(geometry_pb2.Vector3(x=meters, y=meters, z=meters))
    command = scene_pb2.UpdateNode(name=name, node=node)
    command.update_mask.paths.append("figures")
    return scene_pb2.Command(update_node=command)


def heavy(name: str, kilograms: float) -> scene_pb2.Command:
    command = scene_pb2.UpdateNode(name=name, node=nodes_pb2.Node(part=nodes_pb2.Part(mass_kilograms=kilograms)))
    command.update_mask.paths.append("part")
    return scene_pb2.Command(update_node=command)


def on(name: str, parent: str) -> scene_pb2.Command:
    return scene_pb2.Command(attach_node=scene_pb2.AttachNode(name=name, parent=parent))


FAR: dict[str, scene_pb2.Command] = {
    "PLACE": moved("box"),
    "POSITION": turned("other"),
    "NODE": create(box("new", x=5.0)),
    "REMOVED": scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="box")),
    "PADDING": padded("box", 0.01),
    "ALLOWED": may_touch(("box", "lid")),
    "PARENT": on("lid", "box"),
    "SHAPE": other_size("box", 0.2),
    "LOAD": heavy("box", 7.0),
}
"""Changes, each of another input, by which the check would come to the same."""


@pytest.mark.parametrize("aspect", FAR)
def test_what_a_check_used_may_change_where_it_would_come_to_the_same(cell: Stubs, aspect: str) -> None:
    alone, checked = plan(cell).plan, check(cell).plan
    assert alone.digest != checked.digest
    apply(cell, FAR[aspect])
    assert begin(cell, checked).robots == ["arm"]


LINKS = [f"arm.lbr_iiwa_link_{number}" for number in range(8)]
WAY = (0.35, 0.25, 0.6)
"""Place (m) that the arm goes through."""

# Of each input: what makes the cell, the change that makes the arm touch or fail, and what is told of it. The arm's
# greatest reach at READY is 0.72 m from its axis, and its first joint turns by 0.2 rad.
INPUTS: dict[str, tuple[list[scene_pb2.Command], scene_pb2.Command, str]] = {
    "PLACE": ([], moved("box", *WAY), "where it is fixed on its parent has changed of 'box'"),
    "NODE": ([], create(box("new", *WAY)), "'new' is new"),
    "SHAPE": ([], other_size("box", 6.0), "its shape has changed of 'box'"),
    "PADDING": (
        [create(box("near", x=1.3, y=0.3, z=0.5))],
        padded("near", 0.8),
        "by how much it counts as thicker has changed of 'near'",
    ),
    "ALLOWED": (
        [create(box("post", *WAY)), may_touch(*(("post", link) for link in LINKS))],
        may_touch(*(("post", link) for link in LINKS), never=True),
        "what it may touch has changed of 'arm.lbr_iiwa_link_0'",
    ),
    # The box is turned with the arm to where the post stands: by 0.2 rad on a circle of 3 m.
    "PARENT": (
        [create(box("post", x=3.0 * np.cos(0.2), y=3.0 * np.sin(0.2)))],
        on("box", "arm.lbr_iiwa_link_1"),
        "what it hangs on has changed of 'box'",
    ),
    # Another arm, which stands upright 1 m beside it, lies down across it.
    "POSITION": (
        [moved("other", x=0.0, y=1.0, z=0.0)],
        turned("other", lbr_iiwa_joint_1=-np.pi / 2, lbr_iiwa_joint_2=1.5),
        "where its joint stands has changed of 'other.lbr_iiwa_link_1'",
    ),
    "LOAD": (
        [create(box("load", x=1.5, parent="arm.lbr_iiwa_link_3"))],
        heavy("load", 1000.0),
        "its mass, or where that is has changed of 'load'",
    ),
}


@pytest.mark.parametrize("aspect", INPUTS)
def test_what_a_check_used_is_another_one_and_it_comes_to_another_verdict(cell: Stubs, aspect: str) -> None:
    made, changed, words = INPUTS[aspect]
    apply(cell, *made)
    alone, checked = plan(cell).plan, check(cell)
    assert not checked.HasField("first_violation"), checked.first_violation
    apply(cell, changed)
    refused = outdated(cell, checked.plan)
    assert words in refused.metadata["changes"].splitlines()
    found = check(cell).first_violation
    assert found.message and f", and {found.message}; plan again" in refused.message
    assert [refused.metadata.get(name, "") for name in ("first", "second")] == [found.first, found.second]
    # Nobody has looked at what the plan alone would touch.
    assert begin(cell, alone).robots == ["arm"]


def test_things_that_move_meanwhile_are_the_guards(cell: Stubs) -> None:
    checked = check(cell).plan
    start(cell, joints("other", 0.1, lbr_iiwa_joint_1=1.0))
    step(cell, 10)
    assert begin(cell, checked).robots == ["arm"]


def test_all_that_has_changed_is_told(cell: Stubs) -> None:
    checked = check(cell).plan
    apply(cell, moved("box"), moved("lid"), create(box("new", x=5.0)), create(box("newer", *WAY)))
    refused = outdated(cell, checked)
    assert len(refused.metadata["changes"].splitlines()) == 4
    assert ", and 1 more, and " in refused.message


def test_what_nobody_can_run_into_may_change(cell: Stubs) -> None:
    checked = check(cell)
    assert not checked.HasField("first_violation")
    frame = nodes_pb2.Node(name="frame", object=nodes_pb2.SceneObject())
    named = scene_pb2.Command(update_node=scene_pb2.UpdateNode(name="box", node=nodes_pb2.Node(name="crate")))
    named.update_node.update_mask.paths.append("name")
    apply(cell, create(frame), named)
    cell.scene.Apply(scene_pb2.ApplyRequest())
    step(cell, 3)
    assert begin(cell, checked.plan).planned_duration_seconds == checked.duration_seconds


def test_what_the_plan_itself_used_counts_without_a_check(cell: Stubs) -> None:
    here = matrix(state(cell, "arm").world_t_tcp)
    here[2, 3] -= 0.05
    shown = plan(cell, linear("arm", here)).plan
    slow = scene_pb2.Command(set_tcp_speed_limit=scene_pb2.SetTcpSpeedLimit(robot="arm", meters_per_second=0.1))
    apply(cell, slow)
    refused = outdated(cell, shown)
    assert (refused.metadata["node"], refused.metadata["aspect"]) == ("arm", "TCP_SPEED")


def test_a_plan_is_checked_as_it_is(cell: Stubs) -> None:
    shown = plan(cell)
    told = check(cell, plan=shown.plan)
    assert told.duration_seconds == shown.duration_seconds and told.plan.digest not in ("", shown.plan.digest)
    apply(cell, create(box("in the way", x=0.35, y=0.25, z=0.6)))
    refused = outdated(cell, told.plan)
    assert "'in the way' is new" in refused.message
    told = check(cell, plan=shown.plan)
    assert told.first_violation.second == "in the way" and not told.HasField("plan")
    apply(cell, scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="in the way")))
    assert check(cell, plan=shown.plan, ignore_collisions=True).plan.digest == shown.plan.digest
    begin(cell, shown.plan)
    refused = refusal(lambda: check(cell, plan=shown.plan))
    assert refused.reason == "ROBOT_BUSY", refused


def test_a_robot_that_took_the_name_of_another_one_is_not_moved(cell: Stubs) -> None:
    shown = plan(cell, joints("other", lbr_iiwa_joint_1=0.5)).plan

    def renamed(old: str, new: str) -> scene_pb2.Command:
        command = scene_pb2.UpdateNode(name=old, node=nodes_pb2.Node(name=new))
        command.update_mask.paths.append("name")
        return scene_pb2.Command(update_node=command)

    apply(cell, renamed("other", "old"))
    assert outdated(cell, shown).metadata["changes"] == "another robot is called 'other'"


def test_what_is_no_plan_or_is_more_than_one_is_refused(cell: Stubs) -> None:
    shown = plan(cell).plan
    lost = refusal(lambda: begin(cell, motion_pb2.PlanReference(id="plan-0")))
    assert (lost.reason, lost.metadata["kind"]) == ("UNKNOWN_NAME", "plan")
    assert "the kernel keeps the last 100" in lost.message

    def field(call: Callable[[], object]) -> str:
        refused = refusal(call)
        assert refused.reason == "INVALID_ARGUMENT", refused
        return refused.metadata["field"]

    other = motion_pb2.PlanReference(id=shown.id, digest="0" * 64)
    assert field(lambda: begin(cell, other)) == "plan.digest"
    assert field(lambda: begin(cell, shown, spec=motion_pb2.MotionSpec(moves=[TURN]))) == "plan"
    assert field(lambda: begin(cell, shown, open=True)) == "open"
    assert field(lambda: begin(cell, shown, breakpoints=["1"])) == "breakpoints"
    assert field(lambda: begin(cell, shown, busy_policy=motion_pb2.BUSY_POLICY_PREEMPT)) == "busy_policy"
    start(cell, joints("arm", 0.1, lbr_iiwa_joint_1=0.1))
    assert refusal(lambda: begin(cell, shown)).reason == "ROBOT_BUSY"


def test_only_the_last_hundred_plans_are_remembered(cell: Stubs) -> None:
    request = motion_pb2.PlanMotionRequest(spec=motion_pb2.MotionSpec(moves=[TURN]), sample_seconds=1.0)
    first, *_, last = (cell.motion.PlanMotion(request).plan for _ in range(101))
    assert refusal(lambda: begin(cell, first)).reason == "UNKNOWN_NAME"
    assert begin(cell, last).robots == ["arm"]


def test_a_program_is_planned_checked_and_started_and_one_with_decisions_belongs_to_the_moment(cell: Stubs) -> None:
    ready = signal_pb2.Signal(name="ready")
    ready.value.boolean = True
    apply(cell, scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=ready)))
    turn = motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[TURN]))
    wait = motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=0.1))
    program = motion_pb2.MotionSpec(steps=[turn, wait, turn])
    checked = check(cell, spec=program)
    assert begin(cell, checked.plan).step_count == 3
    condition = motion_pb2.SignalCondition(signal="ready")
    condition.value.boolean = True
    decision = motion_pb2.ProgramStep(if_signal=motion_pb2.IfStep(condition=condition, then=[turn]))
    told = check(cell, spec=motion_pb2.MotionSpec(steps=[turn, decision]))
    assert not told.HasField("first_violation") and not told.HasField("plan")
