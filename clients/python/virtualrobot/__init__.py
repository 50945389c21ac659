"""The client library of VirtualRobot.

    import virtualrobot

    with virtualrobot.connect() as client:
        robot = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
        robot.move_joints([0, 0.5, 0, -1.2, 0, 0.8, 0])
        robot.move_linear(robot.tcp @ virtualrobot.pose(z=0.1))

Meters, seconds, radians; poses are 4x4 arrays, `a_t_b` takes coordinates given in frame b to frame a.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from virtualrobot.connecting import connect as connect
    from virtualrobot.connection import Client as Client
    from virtualrobot.connection import KernelInfo as KernelInfo
    from virtualrobot.errors import *  # noqa: F403 every exception class; the names are listed below
    from virtualrobot.geometry import pose as pose
    from virtualrobot.geometry import pose_from_quaternion as pose_from_quaternion
    from virtualrobot.geometry import quaternion_of as quaternion_of
    from virtualrobot.geometry import roll_pitch_yaw_of as roll_pitch_yaw_of
    from virtualrobot.history.values import Checkpoint as Checkpoint
    from virtualrobot.history.values import Step as Step
    from virtualrobot.leases import Lease as Lease
    from virtualrobot.leases import LeaseInfo as LeaseInfo
    from virtualrobot.motions.motion import Motion as Motion
    from virtualrobot.motions.motion import Tracking as Tracking
    from virtualrobot.motions.moves import Move as Move
    from virtualrobot.motions.paths import FreePath as FreePath
    from virtualrobot.motions.plans import MotionCheck as MotionCheck
    from virtualrobot.motions.plans import MotionPlan as MotionPlan
    from virtualrobot.motions.plans import Violation as Violation
    from virtualrobot.motions.plans import ViolationKind as ViolationKind
    from virtualrobot.motions.program import Program as Program
    from virtualrobot.motions.proposals import Proposal as Proposal
    from virtualrobot.motions.setpoints import SetpointStream as SetpointStream
    from virtualrobot.motions.setpoints import StreamState as StreamState
    from virtualrobot.motions.state import MotionState as MotionState
    from virtualrobot.motions.state import Phase as Phase
    from virtualrobot.motions.state import PlanReference as PlanReference
    from virtualrobot.motions.state import ProgramStepEvent as ProgramStepEvent
    from virtualrobot.motions.state import Search as Search
    from virtualrobot.motions.steps import Pattern as Pattern
    from virtualrobot.motions.tool_paths import ToolPath as ToolPath
    from virtualrobot.motions.tool_paths import ToolPathPartner as ToolPathPartner
    from virtualrobot.motions.tool_paths import path_frames as path_frames
    from virtualrobot.physics import JointMotor as JointMotor
    from virtualrobot.progress import Progress as Progress
    from virtualrobot.records import Record as Record
    from virtualrobot.records import Wish as Wish
    from virtualrobot.robots.dynamics import inertial as inertial
    from virtualrobot.robots.group import Group as Group
    from virtualrobot.robots.robot import Robot as Robot
    from virtualrobot.robots.values import JointGroup as JointGroup
    from virtualrobot.scene.figures import Figure as Figure
    from virtualrobot.scene.figures import box as box
    from virtualrobot.scene.figures import capsule as capsule
    from virtualrobot.scene.figures import cone as cone
    from virtualrobot.scene.figures import cylinder as cylinder
    from virtualrobot.scene.figures import frame as frame
    from virtualrobot.scene.figures import sphere as sphere
    from virtualrobot.scene.figures import table as table
    from virtualrobot.scene.node import NodeInfo as NodeInfo
    from virtualrobot.scene.target import Target as Target
    from virtualrobot.scene.viewpoint import Viewpoint as Viewpoint
    from virtualrobot.sensors.cameras import CameraReading as CameraReading
    from virtualrobot.sensors.cameras import camera as camera
    from virtualrobot.sensors.cameras import light as light
    from virtualrobot.sensors.cameras import looking_at as looking_at
    from virtualrobot.sensors.contact_sensors import Contact as Contact
    from virtualrobot.sensors.contact_sensors import contact_sensor as contact_sensor
    from virtualrobot.sensors.motion_sensors import EncoderReading as EncoderReading
    from virtualrobot.sensors.motion_sensors import ImuReading as ImuReading
    from virtualrobot.sensors.motion_sensors import PoseReading as PoseReading
    from virtualrobot.sensors.motion_sensors import WrenchReading as WrenchReading
    from virtualrobot.sensors.motion_sensors import encoders as encoders
    from virtualrobot.sensors.motion_sensors import force_torque_sensor as force_torque_sensor
    from virtualrobot.sensors.motion_sensors import imu as imu
    from virtualrobot.sensors.motion_sensors import noise as noise
    from virtualrobot.sensors.motion_sensors import pose_sensor as pose_sensor
    from virtualrobot.sensors.range_sensors import RangeReading as RangeReading
    from virtualrobot.sensors.range_sensors import beams as beams
    from virtualrobot.sensors.range_sensors import fan as fan
    from virtualrobot.sensors.range_sensors import range_sensor as range_sensor
    from virtualrobot.sensors.range_sensors import raster as raster
    from virtualrobot.sensors.range_sensors import ring as ring
    from virtualrobot.sensors.range_sensors import spinning as spinning
    from virtualrobot.sensors.readings import Reading as Reading
    from virtualrobot.sensors.readings import SensorStatus as SensorStatus
    from virtualrobot.sensors.sensors import Sensor as Sensor
    from virtualrobot.tasks import ProgramTask as ProgramTask
    from virtualrobot.tokens import NewToken as NewToken
    from virtualrobot.tokens import TokenInfo as TokenInfo
    from virtualrobot.view.ghosts import Ghost as Ghost

_MODULES = {
    "sensors.cameras": ("CameraReading", "camera", "light", "looking_at"),
    "connecting": ("connect",),
    "connection": ("Client", "KernelInfo"),
    "sensors.contact_sensors": ("Contact", "contact_sensor"),
    "robots.dynamics": ("inertial",),
    "errors": (
        "AssetError", "AuthenticationError", "CallTimeoutError", "ClientClosedError", "CollisionError",
        "ConflictError", "DriverFaultError", "InvalidArgumentError", "KernelFaultError", "KernelGoneError",
        "LeaseEndedError", "LeasedError", "LimitError", "MalformedFileError", "MissingFileError", "MotionAbortedError",
        "MotionCancelledError", "MotionEndedError", "NameTakenError", "PlanOutdatedError",
        "PluginFailedError", "RobotBusyError", "RoleTooLowError", "SingularityError", "StaleRevisionError",
        "TooLargeError", "TooManyCallsError",
        "UnknownNameError", "UnreachableError", "VersionError", "VirtualRobotError", "WrongStateError",
    ),
    "scene.figures": ("Figure", "box", "capsule", "cone", "cylinder", "frame", "sphere", "table"),
    "scene.node": ("NodeInfo",),
    "scene.target": ("Target",),
    "scene.viewpoint": ("Viewpoint",),
    "view.ghosts": ("Ghost",),
    "physics": ("JointMotor",),
    "robots.group": ("Group",),
    "leases": ("Lease", "LeaseInfo"),
    "history.values": ("Checkpoint", "Step"),
    "tokens": ("NewToken", "TokenInfo"),
    "geometry": ("pose", "pose_from_quaternion", "quaternion_of", "roll_pitch_yaw_of"),
    "motions.motion": ("Motion", "Tracking"),
    "motions.steps": ("Pattern",),
    "sensors.motion_sensors": (
        "EncoderReading", "ImuReading", "PoseReading", "WrenchReading", "encoders", "force_torque_sensor", "imu",
        "noise", "pose_sensor",
    ),
    "motions.moves": ("Move",),
    "motions.paths": ("FreePath",),
    "motions.tool_paths": ("ToolPath", "ToolPathPartner", "path_frames"),
    "motions.plans": ("MotionCheck", "MotionPlan", "Violation", "ViolationKind"),
    "motions.program": ("Program",),
    "motions.proposals": ("Proposal",),
    "records": ("Record", "Wish"),
    "tasks": ("ProgramTask",),
    "sensors.range_sensors": ("RangeReading", "beams", "fan", "range_sensor", "raster", "ring", "spinning"),
    "sensors.readings": ("Reading", "SensorStatus"),
    "progress": ("Progress",),
    "robots.robot": ("Robot",),
    "robots.values": ("JointGroup",),
    "sensors.sensors": ("Sensor",),
    "motions.state": ("MotionState", "Phase", "PlanReference", "Search", "ProgramStepEvent"),
    "motions.setpoints": ("SetpointStream", "StreamState"),
}  # fmt: skip
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> object:
    """Import what is asked for only then: the command line and the kernel's resolver want a quick start."""
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULE_OF[name]}"), name)


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(_MODULE_OF)
