"""What a lease covers: which commands and calls others are refused, and which they are not."""

from __future__ import annotations

from collections.abc import Iterator

import grpc
import pytest
from virtualrobot.v1 import (
    asset_pb2,
    geometry_pb2,
    kernel_pb2,
    lease_pb2,
    motion_pb2,
    nodes_pb2,
    plugin_pb2,
    robot_pb2,
    scene_pb2,
    signal_pb2,
    view_pb2,
)

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, set_signals, start
from tests.api.leasing import Holder, all_free, leases, two_arms, update
from tests.api.reading import state
from tests.kernels import KernelProcess, Stubs

MODULES = (asset_pb2, kernel_pb2, lease_pb2, motion_pb2, plugin_pb2, robot_pb2, scene_pb2, signal_pb2, view_pb2)


@pytest.fixture
def cell(kernel: KernelProcess, stubs: Stubs) -> Iterator[Stubs]:
    """Return stubs that hold no lease, in a world with two arms."""
    two_arms(stubs)
    yield stubs
    all_free(stubs)


def attach(name: str, parent: str) -> scene_pb2.Command:
    return scene_pb2.Command(attach_node=scene_pb2.AttachNode(name=name, parent=parent))


AWAY = nodes_pb2.Node(parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(x=3.0)))
TOUCHING = {
    "joints": scene_pb2.Command(
        set_joint_positions=scene_pb2.SetJointPositions(robot="left", joint_positions={"lbr_iiwa_joint_1": 0.5})
    ),
    "place of its base": update("left", AWAY, "parent_t_node"),
    "name": update("left", nodes_pb2.Node(name="mine"), "name"),
    "link": update("left.lbr_iiwa_link_3", nodes_pb2.Node(hidden=True), "hidden"),
    "tool": update("cup", nodes_pb2.Node(hidden=True), "hidden"),
    "held part": update("box", AWAY, "parent_t_node"),
    "theft of the held part": attach("box", "world"),
    "gift of a part": attach("loose", "cup"),
    "removal": scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="left")),
    "removal of a tool": scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name="cup")),
    "tool to elsewhere": attach("cup", "right.lbr_iiwa_link_7"),
    "attachment": attach("left", "right.lbr_iiwa_link_7"),
    "another tool": create(nodes_pb2.Node(name="new", parent="left.lbr_iiwa_link_7", tool=nodes_pb2.Tool())),
    "pick": scene_pb2.Command(pick_part=scene_pb2.PickPart(robot="left", part="loose", max_distance_meters=2.0)),
    "place": scene_pb2.Command(place_part=scene_pb2.PlacePart(robot="left")),
    "tool state": scene_pb2.Command(set_tool_state=scene_pb2.SetToolState(tool="cup", state="off")),
    "choice of tool": scene_pb2.Command(select_tool=scene_pb2.SelectTool(robot="left")),
    "speed": scene_pb2.Command(set_speed_factor=scene_pb2.SetSpeedFactor(robot="left", factor=0.5)),
    "speed of all": scene_pb2.Command(set_speed_factor=scene_pb2.SetSpeedFactor(factor=0.5)),
}


@pytest.mark.parametrize("command", TOUCHING.values(), ids=TOUCHING)
def test_others_change_nothing_of_a_leased_robot(
    cell: Stubs, kernel: KernelProcess, command: scene_pb2.Command
) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    before = stubs.scene.SaveScene(scene_pb2.SaveSceneRequest()).text
    refused = refusal(lambda: apply(stubs, create(box("with it", x=9.0)), command))
    assert (refused.reason, refused.metadata["robot"], refused.metadata["owner"]) == ("LEASED", "left", "Ada")
    assert stubs.scene.SaveScene(scene_pb2.SaveSceneRequest()).text == before
    bob = Holder(kernel, "right", owner="Bob")  # a lease of another robot does not help
    assert refusal(lambda: bob.apply(command)).metadata["owner"] == "Ada"
    bob.release()
    ada.apply(command)


def test_what_is_not_the_robot_stays_free(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    Holder(kernel, "left")
    apply(
        stubs,
        create(box("pallet", x=2.0)),
        update("loose", AWAY, "parent_t_node"),  # only lies on it
        attach("loose", "pallet"),
        attach("loose", "left.lbr_iiwa_link_0"),
        create(nodes_pb2.Node(name="note", parent="left.lbr_iiwa_link_7", annotation=nodes_pb2.Annotation())),
        scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal_pb2.Signal(name="lamp"))),
        scene_pb2.Command(set_speed_factor=scene_pb2.SetSpeedFactor(robot="right", factor=0.5)),
    )
    set_signals(stubs, {"lamp": True})
    stubs.robot.SolveForward(robot_pb2.SolveForwardRequest(robot="left"))


def test_the_world_is_not_replaced_under_a_lease(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    text = scene_pb2.LoadSceneRequest(text="schema_version: 1\n")
    assert refusal(lambda: stubs.scene.LoadScene(text)).metadata["owner"] == "Ada"
    posed = "schema_version: 1\nrobot_states: [{name: left, positions: [1, 0, 0, 0, 0, 0, 0]}]\n"
    add = scene_pb2.LoadSceneRequest(text=posed, add=True)
    try:
        stubs.scene.LoadScene(add)  # whatever it is refused for
    except grpc.RpcError:
        pass
    assert state(stubs, "left").positions[0] == 0.0
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text="schema_version: 1\n", add=True))
    under = scene_pb2.ImportModelRequest(
        model=scene_pb2.ModelSource(uri=IIWA, name="third", parent="left.lbr_iiwa_link_7")
    )
    assert refusal(lambda: stubs.scene.ImportModel(under)).reason == "LEASED"
    ada.stubs.scene.LoadScene(text, metadata=ada.metadata)
    (lease,) = leases(stubs)
    assert list(lease.robots) == []  # its robot is gone
    load(stubs, IIWA, "left")
    start(stubs, joints("left", lbr_iiwa_joint_1=0.1))  # another one of the same name is free
    ada.release()


def test_kinematics_are_swapped_by_the_holder_alone(cell: Stubs, kernel: KernelProcess) -> None:
    stubs = cell
    ada = Holder(kernel, "left")
    request = robot_pb2.SetKinematicsRequest(choice=robot_pb2.KinematicsChoice(robot="left", kinematics="chain"))
    assert refusal(lambda: stubs.robot.SetKinematics(request)).reason == "LEASED"
    ada.stubs.robot.SetKinematics(request, metadata=ada.metadata)


def test_a_program_of_a_leased_robot_is_refused_before_it_is_planned(cell: Stubs, kernel: KernelProcess) -> None:
    """Its second step can't be planned, as is told to the holder alone."""
    ada = Holder(kernel, "left")
    goal = motion_pb2.JointGoal(joint_positions={"elbow": 1.0})
    move = motion_pb2.Move(robot="left", point_to_point=motion_pb2.PointToPoint(joints=goal))
    step = motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[move]))
    dwell = motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=1.0))
    program = motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(steps=[dwell, step]))
    assert refusal(lambda: cell.motion.StartMotion(program)).reason == "LEASED"
    refused = refusal(lambda: ada.stubs.motion.StartMotion(program, metadata=ada.metadata))
    assert "elbow" in refused.message


def test_only_the_holder_appends_to_a_program_of_a_leased_robot(cell: Stubs, kernel: KernelProcess) -> None:
    ada = Holder(kernel, "left")
    steps = [motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[joints("left", lbr_iiwa_joint_1=0.1)]))]
    leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
    program = motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(steps=steps), on_disconnect=leave, open=True)
    id = ada.stubs.motion.StartMotion(program, metadata=ada.metadata).motion.id
    dwell = motion_pb2.ProgramStep(dwell=motion_pb2.DwellStep(seconds=0.01))
    for request in (
        motion_pb2.AppendMotionRequest(id=id, steps=[dwell]),
        motion_pb2.AppendMotionRequest(id=id, last=True),
    ):
        assert refusal(lambda request=request: cell.motion.AppendMotion(request)).reason == "LEASED"
        ada.stubs.motion.AppendMotion(request, metadata=ada.metadata)


def test_the_methods_that_need_a_lease() -> None:
    """Whoever adds a method that moves or changes robots marks it, and this list says so."""
    marked = {
        f"{service.name}.{method.name}"
        for module in MODULES
        for service in module.DESCRIPTOR.services_by_name.values()
        for method in service.methods
        if method.GetOptions().Extensions[lease_pb2.needs_lease]  # pyright: ignore[reportArgumentType] its stub
    }
    assert marked == {
        "KernelService.StepClock",
        "MotionService.StartMotion",
        "MotionService.AppendMotion",
        "MotionService.ResumeMotion",
        "MotionService.HoldMotion",
        "MotionService.StepMotion",
        "MotionService.StreamSetpoints",
        "RobotService.SetKinematics",
        "SceneService.Apply",
        "SceneService.ImportModel",
        "SceneService.LoadScene",
    }
