"""Names of goals: postures of a robot, and targets of the world."""

from __future__ import annotations

from google.protobuf.field_mask_pb2 import FieldMask

from virtualrobot._wire.names import unknown_name
from virtualrobot._wire.services import Services
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.robots.description import coordinate_names, described, described_anew
from virtualrobot.v1 import scene_pb2


def is_target(services: Services, robot: str, name: str) -> bool:
    """Return whether a goal's name is a target's, or else, False, a posture's of this robot.

    Raises UnknownNameError, which lists both, for neither, and InvalidArgumentError where it may be either.
    """
    postures, target = postures_of(services, robot), names_target(services, name)
    if name not in postures and not target:
        postures = postures_of(services, robot, anew=True)  # somebody may have added it a moment ago
    if name in postures and target:
        raise InvalidArgumentError(
            f"{name!r} is a posture of {robot!r} and a target; rename one of them, or say which: move_joints with "
            f"postures[{name!r}], or move_pose with an identity pose and reference={name!r}"
        )
    if name not in postures and not target:
        raise unknown_name(f"no posture of {robot!r} and no target", name, {*postures, *_targets(services)})
    return target


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


def names_target(services: Services, name: str) -> bool:
    """Return whether a name is a target's."""
    request = scene_pb2.GetSceneRequest(names=[name], read_mask=_KIND)
    try:
        said = services.descriptions.get(("target", name), lambda: services.scene.GetScene(request))
    except UnknownNameError:
        return False
    return said.nodes[0].WhichOneof("kind") == "target"


def _targets(services: Services) -> list[str]:
    said = services.scene.GetScene(scene_pb2.GetSceneRequest(read_mask=_KIND))
    return [node.name for node in said.nodes if node.WhichOneof("kind") == "target"]


_KIND = FieldMask(paths=["name", "target"])
"""Of nodes that are no targets the kind is left out."""
