"""Random programs for a kernel: what thousands of clients might ask of it, drawn from a seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import grpc
import numpy as np
from google.protobuf.field_mask_pb2 import FieldMask
from google.protobuf.message import Message
from virtualrobot._wire.signal_values import set_command, value_message
from virtualrobot.v1 import (
    geometry_pb2,
    kernel_pb2,
    motion_pb2,
    nodes_pb2,
    robot_pb2,
    scene_pb2,
    signal_pb2,
)

from tests.pybullet_models import pybullet_data

MODELS = {"iiwa": "kuka_iiwa/model.urdf", "panda": "franka_panda/panda.urdf", "r2d2": "r2d2.urdf"}


class Program:
    """Asks a kernel for one random thing after the other, and keeps every answer without its wall-clock time.

    All choices come from the seed and from earlier answers, so that equal kernels are asked equal things.
    """

    def __init__(self, stubs: Any, seed: int) -> None:  # noqa: ANN401 the Stubs of conftest
        """Load the robots; nothing random yet."""
        self.stubs = stubs
        self.rng = np.random.default_rng(seed)
        self.answers: list[bytes] = []
        self.names: list[str] = []
        self.motions: list[str] = []
        self.count = 0
        for place, (name, path) in enumerate(MODELS.items()):
            self.ask(
                stubs.scene.ImportModel,
                scene_pb2.ImportModelRequest(
                    model=scene_pb2.ModelSource(
                        uri=f"{pybullet_data.getDataPath()}/{path}",
                        name=name,
                        parent_t_node=geometry_pb2.Pose(position=geometry_pb2.Vector3(x=1.5 * place)),
                        base_joint=nodes_pb2.JOINT_TYPE_FLOATING if name == "r2d2" else nodes_pb2.JOINT_TYPE_FIXED,
                    )
                ),
            )
        fingers = {"panda_finger_joint1": 0.04}
        closed = dict.fromkeys(fingers, 0.01)
        states = [
            nodes_pb2.ToolState(name="open", joint_positions=fingers),
            nodes_pb2.ToolState(name="closed", joint_positions=closed),
        ]
        tool = nodes_pb2.Node(name="hand", parent="panda.panda_hand", tool=nodes_pb2.Tool(states=states))
        mounted = self.apply(scene_pb2.Command(create_node=scene_pb2.CreateNode(node=tool)))
        assert mounted, "the program needs its hand"
        self.joints = {
            name: stubs.robot.GetRobot(robot_pb2.GetRobotRequest(name=name)).joints for name in ("iiwa", "panda")
        }

    def run(self, commands: int) -> None:
        """Ask for this many things."""
        asks: list[Callable[[], None]] = [
            self.create,
            self.create,
            self.remove,
            self.attach,
            self.update,
            self.jump,
            self.signal,
            self.speed,
            self.pick,
            self.place,
            self.tool,
            self.move_joints,
            self.move_line,
            self.move_arc,
            self.move_tool,
            self.move_program,
            self.append,
            self.steer,
            self.steer,
            self.step,
            self.step,
        ]
        for _ in range(commands):
            asks[self.rng.integers(len(asks))]()

    def ask(self, call: Callable[[Message], Message], request: Message) -> Any:  # noqa: ANN401 any answer
        """Call, keep the answer (or the refusal), and return the answer or None."""
        try:
            answer = call(request)
        except grpc.RpcError as error:
            self.answers.append(f"{error.code()} {error.details()}".encode())  # pyright: ignore[reportAttributeAccessIssue] calls raise errors that are calls
            assert error.code() is not grpc.StatusCode.INTERNAL, error.details()  # pyright: ignore[reportAttributeAccessIssue]
            return None
        self.answers.append(timeless(answer))
        return answer

    def apply(self, *commands: scene_pb2.Command) -> Any:  # noqa: ANN401 an ApplyResponse or None
        """Apply commands as one batch."""
        return self.ask(self.stubs.scene.Apply, scene_pb2.ApplyRequest(commands=commands))

    def pose(self) -> geometry_pb2.Pose:
        """Return a pose within a cube of 2 m about the origin."""
        x, y, z = self.rng.uniform(-1, 1, 3)
        a, b, c, d = self.rng.normal(size=4)
        return geometry_pb2.Pose(
            position=geometry_pb2.Vector3(x=x, y=y, z=z), orientation=geometry_pb2.Quaternion(x=a, y=b, z=c, w=d)
        )

    def some(self, names: list[str]) -> str:
        """Return one of the names, sometimes one that isn't there."""
        return str(self.rng.choice(names)) if names and self.rng.random() < 0.97 else "nobody"

    def create(self) -> None:
        """Create one to three objects, parts or targets."""
        commands = []
        for _ in range(self.rng.integers(1, 4)):
            self.count += 1
            size = geometry_pb2.Vector3(x=0.1, y=0.05, z=0.02)
            node = nodes_pb2.Node(
                name=f"thing{self.count}",
                parent=self.some(self.names) if self.rng.random() < 0.3 else "",
                parent_t_node=self.pose(),
                figures=[nodes_pb2.Figure(box=nodes_pb2.Box(size=size))],
            )
            getattr(node, str(self.rng.choice(["part", "object", "annotation", "target"]))).SetInParent()
            if node.HasField("target"):
                node.target.robot = "iiwa"
                node.target.joint_positions.update(self.joint_positions("iiwa"))
            commands.append(scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node)))
        if answer := self.apply(*commands):
            self.names += [created.name for created in answer.created]

    def remove(self) -> None:
        """Remove a node with all below it."""
        name = self.some(self.names)
        if self.apply(scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name=name))):
            left = {node.name for node in self.stubs.scene.GetScene(scene_pb2.GetSceneRequest()).nodes}
            self.names = [name for name in self.names if name in left]

    def attach(self) -> None:
        """Attach a node to another, a robot's link or the world, where it is or at a pose."""
        parents = [*self.names, "iiwa.lbr_iiwa_link_7", "panda.panda_link5", "world", "r2d2"]
        attach = scene_pb2.AttachNode(name=self.some(self.names), parent=self.some(parents))
        if self.rng.random() < 0.5:
            attach.parent_t_node.CopyFrom(self.pose())
        self.apply(scene_pb2.Command(attach_node=attach))

    def update(self) -> None:
        """Change pose, visibility or name."""
        name = self.some(self.names)
        field = str(self.rng.choice(["parent_t_node", "hidden", "name"]))
        node = nodes_pb2.Node(hidden=bool(self.rng.integers(2)), parent_t_node=self.pose())
        node.name = f"named{len(self.answers)}"
        update = scene_pb2.UpdateNode(name=name, node=node, update_mask=FieldMask(paths=[field]))
        if self.apply(scene_pb2.Command(update_node=update)) and field == "name":
            self.names[self.names.index(name)] = node.name

    def joint_positions(self, robot: str) -> dict[str, float]:
        """Return random positions of some joints, now and then one outside its limits."""
        chosen = [joint for joint in self.joints[robot] if self.rng.random() < 0.5]
        return {
            joint.name: float(self.rng.uniform(joint.limits.lower, joint.limits.upper))
            * (1.5 if self.rng.random() < 0.02 else 1.0)
            for joint in chosen
        }

    def jump(self) -> None:
        """Put joints somewhere at once."""
        robot = self.some(["iiwa", "panda"])
        if robot == "nobody":
            return
        jump = scene_pb2.SetJointPositions(robot=robot, joint_positions=self.joint_positions(robot))
        self.apply(scene_pb2.Command(set_joint_positions=jump))

    def signal(self) -> None:
        """Create, set or remove a signal."""
        name = f"signal{self.rng.integers(6)}"
        kind = self.rng.integers(4)
        if kind == 0:
            signal = signal_pb2.Signal(name=name, value=value_message(bool(self.rng.integers(2))))
            self.apply(scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal)))
        elif kind == 1:
            self.apply(scene_pb2.Command(remove_signal=scene_pb2.RemoveSignal(name=name)))
        else:
            self.apply(set_command(name, bool(self.rng.integers(2))))

    def speed(self) -> None:
        """Slow one robot or all."""
        factor = float(self.rng.uniform(-0.05, 1.05))
        speed = scene_pb2.SetSpeedFactor(robot=str(self.rng.choice(["", "iiwa", "panda"])), factor=factor)
        self.apply(scene_pb2.Command(set_speed_factor=speed))

    def pick(self) -> None:
        """Pick a part, near or far."""
        part = self.some(self.names) if self.rng.random() < 0.7 else ""
        self.apply(scene_pb2.Command(pick_part=scene_pb2.PickPart(robot="panda", part=part)))

    def place(self) -> None:
        """Let go."""
        parent = self.some(self.names) if self.rng.random() < 0.3 else ""
        self.apply(scene_pb2.Command(place_part=scene_pb2.PlacePart(robot="panda", parent=parent)))

    def tool(self) -> None:
        """Choose the hand or none, or put it into a state."""
        if self.rng.random() < 0.5:
            state = scene_pb2.SetToolState(tool="hand", state=str(self.rng.choice(["open", "closed", "ajar"])))
            self.apply(scene_pb2.Command(set_tool_state=state))
        else:
            chosen = scene_pb2.SelectTool(robot="panda", tool=str(self.rng.choice(["hand", "hand", ""])))
            self.apply(scene_pb2.Command(select_tool=chosen))

    def start(self, *moves: motion_pb2.Move, steps: Sequence[motion_pb2.ProgramStep] = (), open: bool = False) -> None:
        """Start a motion that goes on without a watch."""
        request = motion_pb2.StartMotionRequest(
            spec=motion_pb2.MotionSpec(moves=moves, steps=steps),
            on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE,
            open=open,
        )
        if answer := self.ask(self.stubs.motion.StartMotion, request):
            self.motions.append(answer.motion.id)

    def move_joints(self) -> None:
        """Move one arm or both, point to point."""
        robots = ["iiwa", "panda"] if self.rng.random() < 0.3 else [str(self.rng.choice(["iiwa", "panda"]))]
        moves = []
        for robot in robots:
            goal = motion_pb2.JointGoal(joint_positions=self.joint_positions(robot))
            point_to_point = motion_pb2.PointToPoint(joints=goal)
            speed = float(self.rng.uniform(0.2, 1.0))
            moves.append(motion_pb2.Move(robot=robot, speed_factor=speed, point_to_point=point_to_point))
        self.start(*moves)

    def move_line(self) -> None:
        """Move an arm's tool centre point by up to 5 cm along a line."""
        robot = str(self.rng.choice(["iiwa", "panda"]))
        request = robot_pb2.GetRobotStatesRequest(names=[robot])
        pose = self.stubs.robot.GetRobotStates(request).robots[0].world_t_tcp
        dx, dy, dz = self.rng.uniform(-0.05, 0.05, 3)
        pose.position.x += dx
        pose.position.y += dy
        pose.position.z += dz
        linear = motion_pb2.Linear(goal=motion_pb2.PoseGoal(reference_t_tcp=pose))
        self.start(motion_pb2.Move(robot=robot, linear=linear))

    def move_arc(self) -> None:
        """Move an arm's tool centre point along an arc about a centre up to 5 cm away, for up to a whole turn."""
        robot = str(self.rng.choice(["iiwa", "panda"]))
        request = robot_pb2.GetRobotStatesRequest(names=[robot])
        center = self.stubs.robot.GetRobotStates(request).robots[0].world_t_tcp.position
        center.x += self.rng.uniform(-0.05, 0.05)
        center.y += self.rng.uniform(-0.05, 0.05)
        angle = float(self.rng.uniform(-6.28, 6.28))
        about = motion_pb2.ArcCenter(position=center, axis=geometry_pb2.Vector3(z=1.0), angle_radians=angle)
        self.start(motion_pb2.Move(robot=robot, circular=motion_pb2.Circular(center=about)))

    def move_tool(self) -> None:
        """Open or close the hand as a motion."""
        state = motion_pb2.ToolStateMove(tool="hand", state=str(self.rng.choice(["open", "closed"])))
        self.start(motion_pb2.Move(robot="panda", tool_state=state))

    def move_program(self) -> None:
        """Start a program of up to six steps, open or closed."""
        self.start(steps=self.steps(), open=bool(self.rng.random() < 0.3))

    def append(self) -> None:
        """Append up to six steps to one of the last motions, and perhaps close it."""
        if self.motions:
            id, last = str(self.rng.choice(self.motions[-4:])), bool(self.rng.random() < 0.3)
            self.ask(
                self.stubs.motion.AppendMotion, motion_pb2.AppendMotionRequest(id=id, steps=self.steps(), last=last)
            )

    def steps(self) -> list[motion_pb2.ProgramStep]:
        """Return up to six steps: moves with zones, signals set and waited for, dwells, picks and places, rounds."""
        steps = []
        for _ in range(self.rng.integers(1, 7)):
            signal, value = f"signal{self.rng.integers(6)}", bool(self.rng.integers(2))
            kind = self.rng.integers(8)
            if kind < 2:
                robot = str(self.rng.choice(["iiwa", "panda"]))
                goal = motion_pb2.JointGoal(joint_positions=self.joint_positions(robot))
                move = motion_pb2.Move(robot=robot, point_to_point=motion_pb2.PointToPoint(joints=goal))
                percent = float(self.rng.uniform(5, 50)) if self.rng.random() < 0.5 else None
                steps.append(motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[move], blend_percent=percent)))
            elif kind == 2:
                steps.append(
                    motion_pb2.ProgramStep(
                        set_signal=motion_pb2.SetSignalStep(signal=signal, value=value_message(value))
                    )
                )
            elif kind == 3:
                condition = motion_pb2.SignalCondition(signal=signal, value=value_message(value))
                wait = motion_pb2.WaitSignalStep(condition=condition, timeout_seconds=float(self.rng.uniform(0.1, 1)))
                steps.append(motion_pb2.ProgramStep(wait_signal=wait))
            elif kind == 4:
                pick = scene_pb2.PickPart(robot="panda", part=self.some(self.names), max_distance_meters=3.0)
                steps.append(motion_pb2.ProgramStep(pick=pick))
            elif kind == 5:
                steps.append(motion_pb2.ProgramStep(place=scene_pb2.PlacePart(robot="panda")))
            elif kind == 6 and steps:
                repeat = motion_pb2.RepeatStep(count=2, steps=steps[-1:])
                steps.append(motion_pb2.ProgramStep(repeat=repeat))
            else:
                dwell = motion_pb2.DwellStep(seconds=float(self.rng.uniform(0.01, 0.5)))
                steps.append(motion_pb2.ProgramStep(dwell=dwell))
        return steps

    def steer(self) -> None:
        """Pause, resume or cancel one of the last motions."""
        if not self.motions:
            return
        id = str(self.rng.choice(self.motions[-4:]))
        kind = self.rng.integers(3)
        if kind == 0:
            self.ask(self.stubs.motion.PauseMotion, motion_pb2.PauseMotionRequest(id=id))
        elif kind == 1:
            self.ask(self.stubs.motion.ResumeMotion, motion_pb2.ResumeMotionRequest(id=id))
        else:
            self.ask(self.stubs.motion.CancelMotion, motion_pb2.CancelMotionRequest(id=id))

    def step(self) -> None:
        """Let time go on by up to 60 ticks."""
        self.ask(self.stubs.kernel.StepClock, kernel_pb2.StepClockRequest(ticks=int(self.rng.integers(1, 60))))


def timeless(message: Message) -> bytes:
    """Return the message's bytes without wall-clock time and the epoch, which tells kernels apart; maps in order."""
    if "stamp" in message.DESCRIPTOR.fields_by_name:
        for field in ("wall_time", "epoch"):
            message.stamp.ClearField(field)  # pyright: ignore[reportAttributeAccessIssue] it has the field
    return message.SerializeToString(deterministic=True)
