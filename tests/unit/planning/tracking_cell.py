"""Cells in which an arm goes along with a conveyor's belt or a turntable, drawn at random, and what is seen in them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.tracking_motion import TrackingMotion
from virtualrobot_kernel.planning.moves import Linear, PointToPoint
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import TrackingSpec
from virtualrobot_kernel.planning.robots import arm_of, tcp_frame, world_poses
from virtualrobot_kernel.planning.together import moved_arms
from virtualrobot_kernel.planning.tracking import tracked
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import Command, CreateNodes, SetJointPositions, StartMotion
from virtualrobot_kernel.world.state import Motion
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, NodeSpec, RobotData
from virtualrobot_kernel.world.tick import advance
from virtualrobot_sdk.poses import inverse, rotation_matrix

from tests.unit.formats.models import ROBOTS, load
from tests.unit.numeric.urdf_arrays import MODELS
from tests.unit.planning.cell import TICK, chain, pictured
from tests.unit.planning.starts import start_of
from tests.unit.world.builders import after, empty, link

#: A tick and ten points between two ticks.
FINE = TICK / 11
URDFS = {"iiwa": ROBOTS["iiwa"], "puma560": MODELS / "puma560.urdf"}
BELT = JointLimits(-20.0, 20.0, 0.6, 0.8, 8.0)


@cache
def _model(name: str) -> tuple[NodeSpec, ...]:
    return tuple(load(URDFS[name], name="arm")[0].nodes)


@dataclass
class Cell:
    """A world in which the motion `command` can start; its line goes to tray_t_goal from where the arm stands."""

    change: Change
    command: StartMotion
    wish: TrackingSpec
    tray_t_start: np.ndarray
    tray_t_goal: np.ndarray

    def tick(self, seconds: float = TICK) -> None:
        """Let time go on."""
        structure = self.change.structure
        self.change = Change(structure, advance(structure, self.change.state, seconds, world_poses))

    def apply(self, *commands: Command) -> None:
        """Apply commands as one batch."""
        self.change = after(self.change, *commands)

    def run_belt(self, distance: float, speed: float) -> None:
        """Start moving the belt by a distance with a share of its greatest speed."""
        at = float(self.change.state.q[self.belt])
        move = PointToPoint("conveyor", {"run": at + distance}, speed)
        self.apply(start_of(pictured(self.change), [move], chain))

    def replanned(self, wish: TrackingSpec) -> StartMotion:
        """Return the line planned anew from here, with another wish; raise KernelError where it is refused."""
        snapshot = pictured(self.change)
        moves = [Linear("arm", PoseGoal(self.tray_t_goal, "conveyor.tray"))]
        return tracked(snapshot, start_of(snapshot, moves, chain), wish, moved_arms(snapshot, moves))

    @property
    def belt(self) -> int:
        """Where the belt's coordinate is in q."""
        structure = self.change.structure
        return structure.robots[structure.node("conveyor").uid].q_start[0]

    @property
    def motion(self) -> Motion:
        """The motion that goes along, also when it has ended."""
        state = self.change.state
        return next(motion for motion in (*state.motions, *state.ended) if motion.tracked_joint)

    @property
    def tracked(self) -> TrackingMotion:
        """How it is doing."""
        running = self.motion.running
        assert isinstance(running, TrackingMotion)
        return running

    @property
    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities of the arm."""
        return self.change.state.q[self.motion.q_index], self.change.state.v[self.motion.v_index]

    def limits(self, field: str) -> np.ndarray:
        """Return limits of the arm's joints."""
        structure = self.change.structure
        joints = {joint.name: joint for joint in structure.robots[structure.node("arm").uid].joints}
        return np.array([getattr(joints[name].limits, field) for _, name in self.motion.joints])

    def tray_t_tcp(self) -> np.ndarray:
        """Return where the tool centre point is in the tray's frame."""
        return tray_t_tcp(self.change)

    def off_line(self) -> tuple[float, float, float]:
        """Return how far the tool centre point is off its line in the tray's frame, in m and rad, and its share of it.

        The turn that belongs to the share is scipy's slerp.
        """
        now, start = self.tray_t_tcp(), self.tray_t_start
        way = self.tray_t_goal[:3, 3] - start[:3, 3]
        share = float((now[:3, 3] - start[:3, 3]) @ way / (way @ way))
        turn = Rotation.from_matrix(start[:3, :3].T @ self.tray_t_goal[:3, :3]).as_rotvec()
        even = start[:3, :3] @ Rotation.from_rotvec(share * turn).as_matrix()
        off = float(np.linalg.norm(start[:3, 3] + share * way - now[:3, 3]))
        return off, float(Rotation.from_matrix(even.T @ now[:3, :3]).magnitude()), share


def tray_t_tcp(change: Change) -> np.ndarray:
    """Return where the arm's tool centre point is in the tray's frame."""
    snapshot = pictured(change)
    tray = snapshot.world_t(snapshot.structure.node("conveyor.tray").uid)
    return inverse(tray) @ tcp_frame(snapshot, snapshot.structure.node("arm"))


def conveyor(kind: str, rng: np.random.Generator, near: np.ndarray) -> CreateNodes:
    """Return a belt that runs any way, or a table that turns about any upright axis 0.3 to 0.8 m from a point (3,)."""
    direction = float(rng.uniform(-np.pi, np.pi))
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", direction).as_matrix()
    if kind == "belt":
        pose[:3, 3] = near * (1.0, 1.0, 0.0)
        joint = Joint("run", JointType.PRISMATIC, (1.0, 0.0, 0.0), BELT)
    else:
        distance = float(rng.uniform(0.3, 0.8))
        pose[:3, 3] = near + distance * np.array([np.cos(direction), np.sin(direction), -1.0])
        joint = Joint("run", JointType.CONTINUOUS, (0.0, 0.0, 1.0), BELT)
    return CreateNodes(
        (
            NodeSpec("conveyor", Kind.ROBOT, "world", pose, data=RobotData()),
            link("conveyor.tray", "conveyor", joint),
        )
    )


def random_cell(rng: np.random.Generator, arm: str, kind: str, window: float, velocity: float) -> Cell:
    """Return a cell with a line of some centimetres in the tray's frame that the arm can do all along the window.

    It keeps up with whatever its belt does within its limits, up to the velocity.
    """
    for _ in range(200):
        change = after(empty(), CreateNodes(_model(arm)))
        node = change.structure.node("arm")
        chain_of = arm_of(pictured(change), node).serial()
        lower, upper = np.maximum(chain_of.lower, -2.5), np.minimum(chain_of.upper, 2.5)
        q = rng.uniform(0.8 * lower + 0.2 * upper, 0.2 * lower + 0.8 * upper)
        change = after(change, SetJointPositions("arm", dict(zip(chain_of.joint_names, q.tolist(), strict=True))))
        near = tcp_frame(pictured(change), node)[:3, 3]
        change = after(change, conveyor(kind, rng, near))
        snapshot = pictured(change)
        start = tray_t_tcp(change)
        goal = start.copy()
        goal[:3, 3] += rng.uniform(-0.06, 0.06, 3)
        goal[:3, :3] = rotation_matrix(rng.normal(size=3) * 0.1) @ goal[:3, :3]
        wish = TrackingSpec("conveyor.tray", window, velocity)
        try:
            moves = [Linear("arm", PoseGoal(goal, "conveyor.tray"))]
            planned = start_of(snapshot, moves, chain)
            command = tracked(snapshot, planned, wish, moved_arms(snapshot, moves))
        except KernelError:
            continue
        if command.tracking and command.tracking.law.max_acceleration == BELT.acceleration:
            return Cell(change, command, wish, start, goal)
    raise AssertionError(f"no line of 200 could be planned for {arm} with a {kind}")
