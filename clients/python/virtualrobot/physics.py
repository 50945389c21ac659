"""Physics: parts that fall, slide, roll, and are pushed by what moves; robots whose joints have motors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import joint_map, settings_message, settings_of, vector_message, vector_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown, told
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import nodes_pb2, physics_pb2, robot_pb2, scene_pb2


@shown
@dataclass(frozen=True, slots=True, eq=False)
class PhysicsContact:
    """Point at which two nodes touch.

    Attributes:
        first: a node, and `second` another one.
        position: (3,), in the world, meters.
        force: (3,), on the second, in the world, N.
    """

    first: str
    second: str
    position: NDArray[np.float64]
    force: NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class PhysicsStatus:
    """Physics of the world as they are.

    Attributes:
        engine: the component that computes them; `none`: nothing moves by forces.
        engine_settings: its settings.
        gravity: (3,), in the world, m/s^2.
        substeps: number of the engine's steps in a tick.
        fault: why nothing moves though an engine is set; empty while it is well.
        moving_parts: the parts that are not at rest.
        contacts: what touched at the end of the last tick that the engine was asked for.
    """

    engine: str
    engine_settings: Mapping[str, Any]
    gravity: NDArray[np.float64]
    substeps: int
    fault: str
    moving_parts: tuple[str, ...]
    contacts: tuple[PhysicsContact, ...]


_MODES = {
    "usual": nodes_pb2.MOTOR_MODE_UNSPECIFIED,
    "free": nodes_pb2.MOTOR_MODE_FREE,
    "velocity": nodes_pb2.MOTOR_MODE_VELOCITY,
    "position": nodes_pb2.MOTOR_MODE_POSITION,
    "effort": nodes_pb2.MOTOR_MODE_EFFORT,
}
_NAMES = {number: name for name, number in _MODES.items()}


@shown
@dataclass(frozen=True, slots=True)
class JointMotor:
    """Motor of a joint of a robot under physics.

    Attributes:
        mode: `velocity` holds the velocity that motions command, as a wheel's motor does; `position` goes along with
            the position that they command; `effort` exerts what `set_efforts` says; `free` is none, as of a caster;
            `usual` is `velocity` for a joint that turns without end and `position` for others.
        stiffness: of the spring to the position that is commanded, N m/rad or N/m; 0 means as stiff as the engine's
            motors are.
        damping: beside a stiffness, N m s/rad or N s/m.
        max_effort: N m or N; 0 means that of the joint's limits, and no limit where that is 0, too.
    """

    mode: str = "usual"
    stiffness: float = 0.0
    damping: float = 0.0
    max_effort: float = 0.0

    def __post_init__(self) -> None:
        """Refuse modes that there are not."""
        if self.mode not in _MODES:
            raise InvalidArgumentError(f"the mode of a motor is one of {', '.join(_MODES)}, not {self.mode!r}")


@checked
class Physics:
    """Handle of the physics of one kernel."""

    def __init__(self, services: Services) -> None:
        """Handle the physics of one kernel."""
        self._services = services

    def set(
        self,
        engine: str | None = None,
        *,
        engine_settings: Mapping[str, object] | None = None,
        gravity: ArrayLike | None = None,
        substeps: int | None = None,
    ) -> None:
        """Change how forces move parts that are dynamic; what is not given stays. Saved with the scene.

        `engine` is a component such as `mujoco` or `bullet`, or `none`. `gravity` (3,) is in the world, m/s^2;
        `substeps` are the engine's steps in a tick.

        Example:
            >>> client.physics.set("mujoco")
            >>> client.physics.enable("box")

        Raises:
            UnknownNameError: when no such engine is installed.
            LimitError: for substeps out of range.
        """
        command = physics_pb2.SetPhysics(
            engine="" if engine == "none" else engine,
            engine_settings=None if engine_settings is None else settings_message(engine_settings),
            gravity=None if gravity is None else vector_message(gravity),
            substeps=substeps,
        )
        self._services.apply([scene_pb2.Command(set_physics=command)])

    def enable(self, *names: str) -> None:
        """Let parts and robots move by forces; a robot's motions command its motors then.

        Raises:
            UnknownNameError: when there is no such part or robot.
            InvalidArgumentError: for a link, and other nodes that are neither.
            VirtualRobotError: for a part without a mass, or one that no rigid body can be; for a robot with a link that
                moves and has none, with a joint that physics do not know, or that hangs on what moves.
        """
        self._set_dynamic(names, True)

    def disable(self, *names: str) -> None:
        """Let parts stay where they are, and go with what they hang on; let robots move by their motions alone.

        Raises:
            UnknownNameError: when there is no such part or robot.
            RobotBusyError: while a robot moves.
        """
        self._set_dynamic(names, False)

    def motors(self, robot: str) -> dict[str, JointMotor]:
        """Return the motors of a robot's joints that are not the usual ones, by joint.

        Raises:
            UnknownNameError: when there is no such robot.
        """
        return {
            one.joint: JointMotor(_NAMES.get(one.mode, "usual"), one.stiffness, one.damping, one.max_effort)
            for one in self._robot(robot).robot.motors
        }

    def set_motors(self, robot: str, motors: Mapping[str, JointMotor]) -> None:
        """Choose the motors of some of a robot's joints; other joints keep theirs.

        Raises:
            UnknownNameError: when there is no such robot or joint.
            RobotBusyError: while the robot moves.

        Example:
            >>> client.physics.set_motors("dog", {"knee": JointMotor("position", stiffness=80.0, damping=2.0)})
        """
        node = self._robot(robot)
        kept = [one for one in node.robot.motors if one.joint not in motors]
        given = [
            nodes_pb2.JointMotor(
                joint=joint,
                mode=_MODES[one.mode],
                stiffness=one.stiffness,
                damping=one.damping,
                max_effort=one.max_effort,
            )
            for joint, one in motors.items()
        ]
        del node.robot.motors[:]
        node.robot.motors.extend([*kept, *given])
        self._services.apply([_updated(node, "robot")])

    def set_efforts(self, robot: str, efforts: Mapping[str, float]) -> None:
        """Set what motors of the mode `effort` exert from now on, by joint: N m or N; others keep theirs.

        Stopping the robot sets them to 0.

        Raises:
            WrongStateError: for a robot that is not dynamic, and for a motor of another mode.
            UnknownNameError: when there is no such robot or joint.
        """
        command = scene_pb2.SetJointEfforts(robot=robot, efforts=joint_map(efforts))
        self._services.apply([scene_pb2.Command(set_joint_efforts=command)])

    @property
    def status(self) -> PhysicsStatus:
        """Settings, fault, what moves and what touches."""
        answer = self._services.physics.GetPhysics(physics_pb2.GetPhysicsRequest())
        return PhysicsStatus(
            answer.settings.engine or "none",
            settings_of(answer.settings.engine_settings),
            vector_of(answer.settings.gravity),
            answer.settings.substeps,
            answer.fault,
            tuple(answer.moving_parts),
            tuple(
                PhysicsContact(one.first, one.second, vector_of(one.position), vector_of(one.force))
                for one in answer.contacts
            ),
        )

    def _set_dynamic(self, names: tuple[str, ...], dynamic: bool) -> None:
        commands = []
        for node in self._nodes(names):
            kind = node.WhichOneof("kind")
            if kind == "link":
                robot = node.name.split(".")[0]
                raise InvalidArgumentError(f"{node.name!r} is a link; forces move a robot as a whole: name {robot!r}")
            if kind not in ("part", "robot", None):  # None: not there, which the kernel says
                word = kind.replace("_", " ")
                raise InvalidArgumentError(
                    f"{node.name!r} is a node of the kind {word}; forces move parts and robots; add it as a part"
                )
            kind = kind or "part"
            getattr(node, kind).dynamic = dynamic
            commands.append(_updated(node, kind))
        if commands:
            self._services.apply(commands)

    def _robot(self, name: str) -> nodes_pb2.Node:
        """Return the node of a robot; where it is none the kernel refuses."""
        self._services.robot.GetRobot(robot_pb2.GetRobotRequest(name=name))
        return self._nodes((name,))[0]

    def _nodes(self, names: tuple[str, ...]) -> list[nodes_pb2.Node]:
        """Return nodes as they are; one that is not there has its name alone, for the kernel to refuse."""
        scene = self._services.scene.GetScene(scene_pb2.GetSceneRequest(names=names))
        known = {node.name: node for node in scene.nodes}
        return [known.get(name) or nodes_pb2.Node(name=name) for name in names]

    def __repr__(self) -> str:
        """Return a line for people."""

        def say() -> str:
            now = self.status
            ill = f", {now.fault}" if now.fault else ""
            return f"engine {now.engine}, {len(now.moving_parts)} parts move{ill}"

        return told(type(self).__name__, say)


def _updated(node: nodes_pb2.Node, kind: str) -> scene_pb2.Command:
    """Return the command that gives a node what it says of its kind."""
    update = scene_pb2.UpdateNode(name=node.name, node=node)
    update.update_mask.paths.append(kind)
    return scene_pb2.Command(update_node=update)
