from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import lease_pb2 as _lease_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class BusyPolicy(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    BUSY_POLICY_UNSPECIFIED: _ClassVar[BusyPolicy]
    BUSY_POLICY_REJECT: _ClassVar[BusyPolicy]
    BUSY_POLICY_PREEMPT: _ClassVar[BusyPolicy]

class DisconnectPolicy(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DISCONNECT_POLICY_UNSPECIFIED: _ClassVar[DisconnectPolicy]
    DISCONNECT_POLICY_STOP: _ClassVar[DisconnectPolicy]
    DISCONNECT_POLICY_CONTINUE: _ClassVar[DisconnectPolicy]

class ArcOrientation(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ARC_ORIENTATION_UNSPECIFIED: _ClassVar[ArcOrientation]
    ARC_ORIENTATION_TO_GOAL: _ClassVar[ArcOrientation]
    ARC_ORIENTATION_WITH_ARC: _ClassVar[ArcOrientation]

class MotionPhase(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    MOTION_PHASE_UNSPECIFIED: _ClassVar[MotionPhase]
    MOTION_PHASE_RUNNING: _ClassVar[MotionPhase]
    MOTION_PHASE_PAUSING: _ClassVar[MotionPhase]
    MOTION_PHASE_PAUSED: _ClassVar[MotionPhase]
    MOTION_PHASE_STOPPING: _ClassVar[MotionPhase]
    MOTION_PHASE_SUCCEEDED: _ClassVar[MotionPhase]
    MOTION_PHASE_CANCELLED: _ClassVar[MotionPhase]

class CancelCause(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CANCEL_CAUSE_UNSPECIFIED: _ClassVar[CancelCause]
    CANCEL_CAUSE_CALL: _ClassVar[CancelCause]
    CANCEL_CAUSE_STOP: _ClassVar[CancelCause]
    CANCEL_CAUSE_PREEMPTED: _ClassVar[CancelCause]
    CANCEL_CAUSE_UNWATCHED: _ClassVar[CancelCause]
    CANCEL_CAUSE_WORLD_CLEARED: _ClassVar[CancelCause]
    CANCEL_CAUSE_LEASE_EXPIRED: _ClassVar[CancelCause]
    CANCEL_CAUSE_LEASE_TAKEN: _ClassVar[CancelCause]
BUSY_POLICY_UNSPECIFIED: BusyPolicy
BUSY_POLICY_REJECT: BusyPolicy
BUSY_POLICY_PREEMPT: BusyPolicy
DISCONNECT_POLICY_UNSPECIFIED: DisconnectPolicy
DISCONNECT_POLICY_STOP: DisconnectPolicy
DISCONNECT_POLICY_CONTINUE: DisconnectPolicy
ARC_ORIENTATION_UNSPECIFIED: ArcOrientation
ARC_ORIENTATION_TO_GOAL: ArcOrientation
ARC_ORIENTATION_WITH_ARC: ArcOrientation
MOTION_PHASE_UNSPECIFIED: MotionPhase
MOTION_PHASE_RUNNING: MotionPhase
MOTION_PHASE_PAUSING: MotionPhase
MOTION_PHASE_PAUSED: MotionPhase
MOTION_PHASE_STOPPING: MotionPhase
MOTION_PHASE_SUCCEEDED: MotionPhase
MOTION_PHASE_CANCELLED: MotionPhase
CANCEL_CAUSE_UNSPECIFIED: CancelCause
CANCEL_CAUSE_CALL: CancelCause
CANCEL_CAUSE_STOP: CancelCause
CANCEL_CAUSE_PREEMPTED: CancelCause
CANCEL_CAUSE_UNWATCHED: CancelCause
CANCEL_CAUSE_WORLD_CLEARED: CancelCause
CANCEL_CAUSE_LEASE_EXPIRED: CancelCause
CANCEL_CAUSE_LEASE_TAKEN: CancelCause

class StartMotionRequest(_message.Message):
    __slots__ = ("moves", "busy_policy", "on_disconnect")
    MOVES_FIELD_NUMBER: _ClassVar[int]
    BUSY_POLICY_FIELD_NUMBER: _ClassVar[int]
    ON_DISCONNECT_FIELD_NUMBER: _ClassVar[int]
    moves: _containers.RepeatedCompositeFieldContainer[Move]
    busy_policy: BusyPolicy
    on_disconnect: DisconnectPolicy
    def __init__(self, moves: _Optional[_Iterable[_Union[Move, _Mapping]]] = ..., busy_policy: _Optional[_Union[BusyPolicy, str]] = ..., on_disconnect: _Optional[_Union[DisconnectPolicy, str]] = ...) -> None: ...

class Move(_message.Message):
    __slots__ = ("robot", "speed_factor", "point_to_point", "linear", "joint_trajectory", "tool_state", "circular")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    POINT_TO_POINT_FIELD_NUMBER: _ClassVar[int]
    LINEAR_FIELD_NUMBER: _ClassVar[int]
    JOINT_TRAJECTORY_FIELD_NUMBER: _ClassVar[int]
    TOOL_STATE_FIELD_NUMBER: _ClassVar[int]
    CIRCULAR_FIELD_NUMBER: _ClassVar[int]
    robot: str
    speed_factor: float
    point_to_point: PointToPoint
    linear: Linear
    joint_trajectory: JointTrajectory
    tool_state: ToolStateMove
    circular: Circular
    def __init__(self, robot: _Optional[str] = ..., speed_factor: _Optional[float] = ..., point_to_point: _Optional[_Union[PointToPoint, _Mapping]] = ..., linear: _Optional[_Union[Linear, _Mapping]] = ..., joint_trajectory: _Optional[_Union[JointTrajectory, _Mapping]] = ..., tool_state: _Optional[_Union[ToolStateMove, _Mapping]] = ..., circular: _Optional[_Union[Circular, _Mapping]] = ...) -> None: ...

class PoseGoal(_message.Message):
    __slots__ = ("reference_t_tcp", "reference", "configuration")
    REFERENCE_T_TCP_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATION_FIELD_NUMBER: _ClassVar[int]
    reference_t_tcp: _geometry_pb2.Pose
    reference: str
    configuration: str
    def __init__(self, reference_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., reference: _Optional[str] = ..., configuration: _Optional[str] = ...) -> None: ...

class JointGoal(_message.Message):
    __slots__ = ("joint_positions",)
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    joint_positions: _containers.ScalarMap[str, float]
    def __init__(self, joint_positions: _Optional[_Mapping[str, float]] = ...) -> None: ...

class PointToPoint(_message.Message):
    __slots__ = ("joints", "pose", "posture")
    JOINTS_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    POSTURE_FIELD_NUMBER: _ClassVar[int]
    joints: JointGoal
    pose: PoseGoal
    posture: str
    def __init__(self, joints: _Optional[_Union[JointGoal, _Mapping]] = ..., pose: _Optional[_Union[PoseGoal, _Mapping]] = ..., posture: _Optional[str] = ...) -> None: ...

class Linear(_message.Message):
    __slots__ = ("goal", "max_velocity_meters_per_second", "max_acceleration_meters_per_second_squared")
    GOAL_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    goal: PoseGoal
    max_velocity_meters_per_second: float
    max_acceleration_meters_per_second_squared: float
    def __init__(self, goal: _Optional[_Union[PoseGoal, _Mapping]] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_acceleration_meters_per_second_squared: _Optional[float] = ...) -> None: ...

class Circular(_message.Message):
    __slots__ = ("goal", "via", "center", "orientation", "max_velocity_meters_per_second", "max_acceleration_meters_per_second_squared")
    GOAL_FIELD_NUMBER: _ClassVar[int]
    VIA_FIELD_NUMBER: _ClassVar[int]
    CENTER_FIELD_NUMBER: _ClassVar[int]
    ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    goal: PoseGoal
    via: _geometry_pb2.Vector3
    center: ArcCenter
    orientation: ArcOrientation
    max_velocity_meters_per_second: float
    max_acceleration_meters_per_second_squared: float
    def __init__(self, goal: _Optional[_Union[PoseGoal, _Mapping]] = ..., via: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., center: _Optional[_Union[ArcCenter, _Mapping]] = ..., orientation: _Optional[_Union[ArcOrientation, str]] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_acceleration_meters_per_second_squared: _Optional[float] = ...) -> None: ...

class ArcCenter(_message.Message):
    __slots__ = ("position", "axis", "angle_radians")
    POSITION_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    ANGLE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    position: _geometry_pb2.Vector3
    axis: _geometry_pb2.Vector3
    angle_radians: float
    def __init__(self, position: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., axis: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., angle_radians: _Optional[float] = ...) -> None: ...

class JointTrajectory(_message.Message):
    __slots__ = ("joint_names", "times", "positions", "velocities")
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    TIMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    times: _geometry_pb2.NumericArray
    positions: _geometry_pb2.NumericArray
    velocities: _geometry_pb2.NumericArray
    def __init__(self, joint_names: _Optional[_Iterable[str]] = ..., times: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., velocities: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class ToolStateMove(_message.Message):
    __slots__ = ("tool", "state")
    TOOL_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    tool: str
    state: str
    def __init__(self, tool: _Optional[str] = ..., state: _Optional[str] = ...) -> None: ...

class Motion(_message.Message):
    __slots__ = ("id", "robots", "phase", "progress", "planned_duration_seconds", "start_time_seconds", "cancel_reason", "cancel_cause")
    ID_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    PHASE_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    PLANNED_DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    START_TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    CANCEL_REASON_FIELD_NUMBER: _ClassVar[int]
    CANCEL_CAUSE_FIELD_NUMBER: _ClassVar[int]
    id: str
    robots: _containers.RepeatedScalarFieldContainer[str]
    phase: MotionPhase
    progress: float
    planned_duration_seconds: float
    start_time_seconds: float
    cancel_reason: str
    cancel_cause: CancelCause
    def __init__(self, id: _Optional[str] = ..., robots: _Optional[_Iterable[str]] = ..., phase: _Optional[_Union[MotionPhase, str]] = ..., progress: _Optional[float] = ..., planned_duration_seconds: _Optional[float] = ..., start_time_seconds: _Optional[float] = ..., cancel_reason: _Optional[str] = ..., cancel_cause: _Optional[_Union[CancelCause, str]] = ...) -> None: ...

class StartMotionResponse(_message.Message):
    __slots__ = ("stamp", "motion")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motion: Motion
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class GetMotionRequest(_message.Message):
    __slots__ = ("id",)
    ID_FIELD_NUMBER: _ClassVar[int]
    id: str
    def __init__(self, id: _Optional[str] = ...) -> None: ...

class GetMotionResponse(_message.Message):
    __slots__ = ("stamp", "motion")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motion: Motion
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class ListMotionsRequest(_message.Message):
    __slots__ = ("running_only",)
    RUNNING_ONLY_FIELD_NUMBER: _ClassVar[int]
    running_only: bool
    def __init__(self, running_only: bool = ...) -> None: ...

class ListMotionsResponse(_message.Message):
    __slots__ = ("stamp", "motions", "speed_factor")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTIONS_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motions: _containers.RepeatedCompositeFieldContainer[Motion]
    speed_factor: float
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motions: _Optional[_Iterable[_Union[Motion, _Mapping]]] = ..., speed_factor: _Optional[float] = ...) -> None: ...

class WatchMotionRequest(_message.Message):
    __slots__ = ("id", "max_rate_hertz")
    ID_FIELD_NUMBER: _ClassVar[int]
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    id: str
    max_rate_hertz: float
    def __init__(self, id: _Optional[str] = ..., max_rate_hertz: _Optional[float] = ...) -> None: ...

class WatchMotionResponse(_message.Message):
    __slots__ = ("stamp", "motion")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motion: Motion
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class PauseMotionRequest(_message.Message):
    __slots__ = ("id",)
    ID_FIELD_NUMBER: _ClassVar[int]
    id: str
    def __init__(self, id: _Optional[str] = ...) -> None: ...

class PauseMotionResponse(_message.Message):
    __slots__ = ("motion",)
    MOTION_FIELD_NUMBER: _ClassVar[int]
    motion: Motion
    def __init__(self, motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class ResumeMotionRequest(_message.Message):
    __slots__ = ("id",)
    ID_FIELD_NUMBER: _ClassVar[int]
    id: str
    def __init__(self, id: _Optional[str] = ...) -> None: ...

class ResumeMotionResponse(_message.Message):
    __slots__ = ("motion",)
    MOTION_FIELD_NUMBER: _ClassVar[int]
    motion: Motion
    def __init__(self, motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class CancelMotionRequest(_message.Message):
    __slots__ = ("id", "reason")
    ID_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    id: str
    reason: str
    def __init__(self, id: _Optional[str] = ..., reason: _Optional[str] = ...) -> None: ...

class CancelMotionResponse(_message.Message):
    __slots__ = ("motion",)
    MOTION_FIELD_NUMBER: _ClassVar[int]
    motion: Motion
    def __init__(self, motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class StopRequest(_message.Message):
    __slots__ = ("robots",)
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    robots: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, robots: _Optional[_Iterable[str]] = ...) -> None: ...

class StopResponse(_message.Message):
    __slots__ = ("motions",)
    MOTIONS_FIELD_NUMBER: _ClassVar[int]
    motions: _containers.RepeatedCompositeFieldContainer[Motion]
    def __init__(self, motions: _Optional[_Iterable[_Union[Motion, _Mapping]]] = ...) -> None: ...
