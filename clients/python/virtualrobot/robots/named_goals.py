"""Names of goals: postures of a robot, and targets of the world."""

from __future__ import annotations

from google.protobuf.field_mask_pb2 import FieldMask

from virtualrobot._wire.names import unknown_name
from virtualrobot._wire.services import Services
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.robots.description import coordinate_names, described, described_anew
from virtualrobot.v1 import scene_pb2


def is_target(services: Services, robot: str, name: str) -> bool:
    """Return whether a goal's name is a target's, or else, False, a posture's of this robot.

    Raises UnknownNameError, which lists both, for neither, and InvalidArgumentError where it may be either.
    """
    postures, targets = postures_of(services, robot), target_names(services)
    if name not in postures and name not in targets:  # somebody may have taught it a moment ago
        postures, targets = postures_of(services, robot, anew=True), target_names(services, anew=True)
    if name in postures and name in targets:
        raise InvalidArgumentError(
            f"{name!r} is a posture of {robot!r} and a target; rename one of them, or say which: move_joints with "
            f"postures[{name!r}], or move_pose with an identity pose and reference={name!r}"
        )
    if name not in postures and name not in targets:
        raise unknown_name(f"no posture of {robot!r} and no target", name, {*postures, *targets})
    return name in targets


def check_target(services: Services, robot: str, name: str) -> None:
    """Raise InvalidArgumentError for a posture's name, UnknownNameError for one that no target has."""
    if not is_target(services, robot, name):
        raise InvalidArgumentError(
            f"{name!r} is a posture of {robot!r}, and only point-to-point moves go to postures; a path of the tool "
            "centre point leads to a target or a pose"
        )


def postures_of(services: Services, robot: str, anew: bool = False) -> dict[str, dict[str, float]]:
    """Return the postures of a robot by name: radians and meters by joint, in the robot's order."""
    said = described_anew(services, robot) if anew else described(services, robot)
    every = coordinate_names(said)
    return {
        posture.name: {name: posture.joint_positions[name] for name in every if name in posture.joint_positions}
        for posture in said.robot.postures
    }


def target_names(services: Services, anew: bool = False) -> frozenset[str]:
    """Return the names of all targets."""

    def read() -> scene_pb2.GetSceneResponse:
        return services.scene.GetScene(scene_pb2.GetSceneRequest(read_mask=FieldMask(paths=["name", "target"])))

    said = read() if anew else services.descriptions.get("targets", read)
    return frozenset(node.name for node in said.nodes if node.WhichOneof("kind") == "target")
