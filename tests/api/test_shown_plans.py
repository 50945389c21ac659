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
    for row in values(told.positions):
        np.testing.assert_allclose(state(cell, "arm").positions, row, atol=1e-12)
        step(cell, 1)
    refused = outdated(cell, again.plan)
    assert (refused.metadata["node"], refused.metadata["aspect"]) == ("arm", "START")
    assert "'lbr_iiwa_joint_1' of 'arm' stands at" in refused.metadata["changes"] and "plan again" in refused.message
    back = scene_pb2.SetJointPositions(robot="arm", joint_positions=READY)
    apply(cell, scene_pb2.Command(set_joint_positions=back))
    held = begin(cell, again.plan, hold=True)
    step(cell, 5)
    assert cell.motion.GetMotion(motion_pb2.GetMotionRequest(id=held.id)).motion.phase == motion_pb2.MOTION_PHASE_PAUSED


def moved(name: str) -> scene_pb2.Command:
    pose = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=3.0, z=0.5))
    return scene_pb2.Command(attach_node=scene_pb2.AttachNode(name=name, parent_t_node=pose))


def turned(robot: str) -> scene_pb2.Command:
    put = scene_pb2.SetJointPositions(robot=robot, joint_positions={"lbr_iiwa_joint_2": 0.1})
    return scene_pb2.Command(set_joint_positions=put)


def allowed(*names: str) -> scene_pb2.Command:
    pair = nodes_pb2.NodePair(first=names[0], second=names[1])
    return scene_pb2.Command(set_allowed_pairs=collision_pb2.SetAllowedPairs(allow=[pair]))


CHANGES: dict[str, tuple[scene_pb2.Command, str]] = {
    "PLACE": (moved("box"), "where it is fixed on its parent has changed of 'box'"),
    "POSITION": (turned("other"), "where its joint stands has changed of 'other.lbr_iiwa_link_2'"),
    "NODE": (create(box("new", x=5.0)), "'new' is new"),
    "REMOVED": (scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="box")), "'box' was removed"),
    "PADDING": (
        scene_pb2.Command(
            set_collision_settings=collision_pb2.SetCollisionSettings(
                paddings=[collision_pb2.NodePadding(node="box", padding_meters=0.01)]
            )
        ),
        "by how much it counts as thicker has changed of 'box'",
    ),
    "ALLOWED": (allowed("box", "lid"), "what it may touch has changed of 'box'"),
    "PARENT": (
        scene_pb2.Command(attach_node=scene_pb2.AttachNode(name="lid", parent="box")),
        "what it hangs on has changed of 'lid'",
    ),
}


@pytest.mark.parametrize("aspect", CHANGES)
def test_what_a_check_used_is_another_one(cell: Stubs, aspect: str) -> None:
    command, words = CHANGES[aspect]
    alone, checked = plan(cell).plan, check(cell).plan
    assert alone.digest != checked.digest
    apply(cell, command)
    refused = outdated(cell, checked)
    assert words in refused.message and words in refused.metadata["changes"].splitlines()
    assert refused.metadata["aspect"] == aspect.replace("REMOVED", "NODE")
    # Nobody has looked at what the plan alone would touch.
    assert begin(cell, alone).robots == ["arm"]


def test_all_that_has_changed_is_told(cell: Stubs) -> None:
    checked = check(cell).plan
    apply(cell, moved("box"), moved("lid"), create(box("new", x=5.0)), create(box("newer", x=6.0)))
    refused = outdated(cell, checked)
    assert len(refused.metadata["changes"].splitlines()) == 4
    assert ", and 1 more; plan again" in refused.message


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
