"""Short ways to ask a kernel for things, and to read its refusals."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import grpc
from google.rpc import error_details_pb2
from grpc_status import rpc_status
from virtualrobot._wire.signal_values import SignalValue, set_command
from virtualrobot.v1 import geometry_pb2, motion_pb2, nodes_pb2, scene_pb2

from tests.kernels import Stubs
from tests.pybullet_models import pybullet_data

MODELS = Path(pybullet_data.getDataPath())
IIWA = str(MODELS / "kuka_iiwa/model.urdf")
PANDA = str(MODELS / "franka_panda/panda.urdf")


@dataclass(frozen=True)
class Refusal:
    """What a refused call says."""

    code: grpc.StatusCode
    reason: str
    message: str
    metadata: dict[str, str]


def refusal(call: Callable[[], object]) -> Refusal:
    """Return how a call is refused; fail when it isn't."""
    try:
        call()
    except grpc.RpcError as error:
        status = rpc_status.from_call(error)  # pyright: ignore[reportArgumentType] errors of calls are calls
        assert status is not None, f"no status details in {error}"
        info = error_details_pb2.ErrorInfo()
        assert status.details[0].Unpack(info)
        assert info.domain == "virtualrobot"
        code = error.code()  # pyright: ignore[reportAttributeAccessIssue]
        return Refusal(code, info.reason, status.message, dict(info.metadata))
    raise AssertionError("the call was not refused")


def load(stubs: Stubs, uri: str, name: str = "", **fields: object) -> scene_pb2.ImportModelResponse:
    """Import a model from the kernel's disk."""
    source = scene_pb2.ModelSource(uri=uri, name=name, **fields)  # pyright: ignore[reportArgumentType]
    return stubs.scene.ImportModel(scene_pb2.ImportModelRequest(model=source))


def apply(stubs: Stubs, *commands: scene_pb2.Command) -> scene_pb2.ApplyResponse:
    """Apply commands as one batch."""
    return stubs.scene.Apply(scene_pb2.ApplyRequest(commands=commands))


def set_signals(stubs: Stubs, values: Mapping[str, SignalValue]) -> scene_pb2.ApplyResponse:
    """Set signals as one batch."""
    return apply(stubs, *(set_command(name, value) for name, value in values.items()))


def create(node: nodes_pb2.Node) -> scene_pb2.Command:
    """Return the command that adds a node."""
    return scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node))


def box(name: str, x: float = 0.0, y: float = 0.0, z: float = 0.0, parent: str = "") -> nodes_pb2.Node:
    """Return a part: a cube of 10 cm."""
    size = geometry_pb2.Vector3(x=0.1, y=0.1, z=0.1)
    return nodes_pb2.Node(
        name=name,
        parent=parent,
        part=nodes_pb2.Part(),
        parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x, y=y, z=z)),
        figures=[nodes_pb2.Figure(box=nodes_pb2.Box(size=size))],
    )


def joints(robot: str, speed_factor: float = 0.0, **positions: float) -> motion_pb2.Move:
    """Return a point-to-point move to joint positions."""
    goal = motion_pb2.JointGoal(joint_positions=positions)
    return motion_pb2.Move(robot=robot, speed_factor=speed_factor, point_to_point=motion_pb2.PointToPoint(joints=goal))


def start(
    stubs: Stubs,
    *moves: motion_pb2.Move,
    busy: motion_pb2.BusyPolicy = motion_pb2.BUSY_POLICY_REJECT,
    leave: motion_pb2.DisconnectPolicy = motion_pb2.DISCONNECT_POLICY_CONTINUE,
) -> motion_pb2.Motion:
    """Start a motion that goes on without a watch."""
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=moves), busy_policy=busy, on_disconnect=leave
    )
    return stubs.motion.StartMotion(request).motion


def ended(stubs: Stubs, id: str) -> motion_pb2.Motion:
    """Watch a motion to its end and return it."""
    *_, last = stubs.motion.WatchMotion(motion_pb2.WatchMotionRequest(id=id, max_rate_hertz=100), timeout=60)
    return last.motion
