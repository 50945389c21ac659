"""Teaching: the place where a tool centre point is now becomes a target of the world."""

from __future__ import annotations

import numpy as np

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import pose_message
from virtualrobot.errors import InvalidArgumentError, NameTakenError, UnknownNameError
from virtualrobot.robots.named_goals import postures_of
from virtualrobot.robots.solver import Solver
from virtualrobot.scene.scene import Scene
from virtualrobot.scene.target import Target
from virtualrobot.v1 import nodes_pb2, robot_pb2


@checked
class Teacher(Solver):
    """Targets of a robot, or of a group of it."""

    def teach(self, name: str, parent: str = "world", *, replace: bool = False) -> Target:
        """Save where the tool centre point is now, and in which posture, as a target with a name; return it.

        `move_to`, `linear`, `move_linear` and splines take its name, programs do, and scene files keep it. It is fixed
        to `parent` (a frame, a part, a robot, the world), and moves along with it. With `replace` a target that has the
        name already is taught anew; what runs goes on as it was planned.

        Raises:
            NameTakenError: when something else has the name, a posture of the robot does, or, without `replace`, a
                target.
            InvalidArgumentError: when no joint moves the tool centre point: `postures.add` saves joints alone.
            LeasedError: when somebody else has leased the robot.

        Example:
            >>> arm.teach("pick 1", "table")
            >>> arm.move_to("pick 1", above=0.1)
            >>> arm.move_linear("pick 1")
        """
        scene = Scene(self._services)
        description = self._description
        if not description.flange or not description.chain_joints:
            raise InvalidArgumentError(
                f"no joint of {self.name!r} moves a tool centre point, so that there is no place to teach; "
                "postures.add saves its joints"
            )
        if name in postures_of(self._services, self.name):
            raise NameTakenError(
                f"{self.name!r} has a posture {name!r}, and a move there could mean both; choose another name"
            )
        taken = _kind_of(scene, name)
        if taken and not (replace and taken == "target"):
            way = "replace=True teaches it anew" if taken == "target" else "choose another one"
            raise NameTakenError(f"the name {name!r} is taken by a node ({taken}); {way}", metadata={"name": name})
        here, tip = self._joints_now(), description.flange
        there = self.solve_forward(here)
        tip_t_tcp = np.linalg.inv(there.world_t_link[tip]) @ there.world_t_tcp
        tool, point = self._tool_in_use()
        target = nodes_pb2.Target(
            robot=self.name,
            tool=tool,
            tool_center_point=point,
            joint_positions={joint: here[joint] for joint in description.chain_joints},
        )
        # First on the link that carries it, then on its parent where it is: at one tick, even where both move.
        with scene.batch() as batch:
            if taken:
                batch._update(name, nodes_pb2.Node(target=target), "target")
                batch.attach(name, tip, tip_t_tcp)
            else:
                node = nodes_pb2.Node(name=name, parent=tip, parent_t_node=pose_message(tip_t_tcp), target=target)
                batch._created(node)
            batch.attach(name, parent)
        return scene.target(name)

    @property
    def targets(self) -> dict[str, Target]:
        """The targets that were taught with this robot, by name; `Client.targets` are all."""
        return {name: target for name, target in Scene(self._services).targets().items() if target.robot == self.name}

    def _tool_in_use(self) -> tuple[str, str]:
        """Return the chosen tool and tool centre point; of a group none, since it may work with another tool."""
        if self._group is not None:
            return "", ""
        state = self._services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=[self.name])).robots[0]
        return state.tool, state.tool_center_point


def _kind_of(scene: Scene, name: str) -> str:
    """Return the kind of the node that has a name; empty where none has."""
    try:
        return scene.node(name).kind
    except UnknownNameError:
        return ""
