from google.protobuf import field_mask_pb2 as _field_mask_pb2
from google.protobuf import struct_pb2 as _struct_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import lease_pb2 as _lease_pb2
from virtualrobot.v1 import nodes_pb2 as _nodes_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class RedundancyPreference(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    REDUNDANCY_PREFERENCE_UNSPECIFIED: _ClassVar[RedundancyPreference]
    REDUNDANCY_PREFERENCE_JOINT_LIMITS: _ClassVar[RedundancyPreference]
    REDUNDANCY_PREFERENCE_MANIPULABILITY: _ClassVar[RedundancyPreference]
    REDUNDANCY_PREFERENCE_POSTURE: _ClassVar[RedundancyPreference]
    REDUNDANCY_PREFERENCE_DISTANCE: _ClassVar[RedundancyPreference]

class InverseStatus(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    INVERSE_STATUS_UNSPECIFIED: _ClassVar[InverseStatus]
    INVERSE_STATUS_SOLVED: _ClassVar[InverseStatus]
    INVERSE_STATUS_UNREACHABLE: _ClassVar[InverseStatus]
    INVERSE_STATUS_OUTSIDE_LIMITS: _ClassVar[InverseStatus]
REDUNDANCY_PREFERENCE_UNSPECIFIED: RedundancyPreference
REDUNDANCY_PREFERENCE_JOINT_LIMITS: RedundancyPreference
REDUNDANCY_PREFERENCE_MANIPULABILITY: RedundancyPreference
REDUNDANCY_PREFERENCE_POSTURE: RedundancyPreference
REDUNDANCY_PREFERENCE_DISTANCE: RedundancyPreference
INVERSE_STATUS_UNSPECIFIED: InverseStatus
INVERSE_STATUS_SOLVED: InverseStatus
INVERSE_STATUS_UNREACHABLE: InverseStatus
INVERSE_STATUS_OUTSIDE_LIMITS: InverseStatus

class GetRobotRequest(_message.Message):
    __slots__ = ("name", "group")
    NAME_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    name: str
    group: _nodes_pb2.GroupSelection
    def __init__(self, name: _Optional[str] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ...) -> None: ...

class GetRobotResponse(_message.Message):
    __slots__ = ("stamp", "uid", "robot", "joints", "links", "tools", "flange", "kinematics", "chain_joints", "kinematics_settings", "kinematics_fault")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    UID_FIELD_NUMBER: _ClassVar[int]
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINTS_FIELD_NUMBER: _ClassVar[int]
    LINKS_FIELD_NUMBER: _ClassVar[int]
    TOOLS_FIELD_NUMBER: _ClassVar[int]
    FLANGE_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_FIELD_NUMBER: _ClassVar[int]
    CHAIN_JOINTS_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_FAULT_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    uid: int
    robot: _nodes_pb2.Robot
    joints: _containers.RepeatedCompositeFieldContainer[JointDescription]
    links: _containers.RepeatedScalarFieldContainer[str]
    tools: _containers.RepeatedScalarFieldContainer[str]
    flange: str
    kinematics: str
    chain_joints: _containers.RepeatedScalarFieldContainer[str]
    kinematics_settings: _struct_pb2.Struct
    kinematics_fault: str
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., uid: _Optional[int] = ..., robot: _Optional[_Union[_nodes_pb2.Robot, _Mapping]] = ..., joints: _Optional[_Iterable[_Union[JointDescription, _Mapping]]] = ..., links: _Optional[_Iterable[str]] = ..., tools: _Optional[_Iterable[str]] = ..., flange: _Optional[str] = ..., kinematics: _Optional[str] = ..., chain_joints: _Optional[_Iterable[str]] = ..., kinematics_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., kinematics_fault: _Optional[str] = ...) -> None: ...

class JointDescription(_message.Message):
    __slots__ = ("name", "type", "limits", "coordinate_count", "velocity_count", "coordinate_names")
    NAME_FIELD_NUMBER: _ClassVar[int]
    TYPE_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    COORDINATE_COUNT_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_COUNT_FIELD_NUMBER: _ClassVar[int]
    COORDINATE_NAMES_FIELD_NUMBER: _ClassVar[int]
    name: str
    type: _nodes_pb2.JointType
    limits: _nodes_pb2.JointLimits
    coordinate_count: int
    velocity_count: int
    coordinate_names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, name: _Optional[str] = ..., type: _Optional[_Union[_nodes_pb2.JointType, str]] = ..., limits: _Optional[_Union[_nodes_pb2.JointLimits, _Mapping]] = ..., coordinate_count: _Optional[int] = ..., velocity_count: _Optional[int] = ..., coordinate_names: _Optional[_Iterable[str]] = ...) -> None: ...

class RobotState(_message.Message):
    __slots__ = ("name", "positions", "velocities", "world_t_tcp", "tool", "tool_center_point", "tool_states", "speed_factor", "motion_ids", "actuator_positions", "commanded_positions", "commanded_velocities", "tool_widths", "tcp_speed_limit", "efforts")
    class ToolStatesEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: str
        def __init__(self, key: _Optional[str] = ..., value: _Optional[str] = ...) -> None: ...
    class ToolWidthsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    NAME_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_TCP_FIELD_NUMBER: _ClassVar[int]
    TOOL_FIELD_NUMBER: _ClassVar[int]
    TOOL_CENTER_POINT_FIELD_NUMBER: _ClassVar[int]
    TOOL_STATES_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    MOTION_IDS_FIELD_NUMBER: _ClassVar[int]
    ACTUATOR_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    COMMANDED_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    COMMANDED_VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    TOOL_WIDTHS_FIELD_NUMBER: _ClassVar[int]
    TCP_SPEED_LIMIT_FIELD_NUMBER: _ClassVar[int]
    EFFORTS_FIELD_NUMBER: _ClassVar[int]
    name: str
    positions: _containers.RepeatedScalarFieldContainer[float]
    velocities: _containers.RepeatedScalarFieldContainer[float]
    world_t_tcp: _geometry_pb2.Pose
    tool: str
    tool_center_point: str
    tool_states: _containers.ScalarMap[str, str]
    speed_factor: float
    motion_ids: _containers.RepeatedScalarFieldContainer[str]
    actuator_positions: _containers.RepeatedScalarFieldContainer[float]
    commanded_positions: _containers.RepeatedScalarFieldContainer[float]
    commanded_velocities: _containers.RepeatedScalarFieldContainer[float]
    tool_widths: _containers.ScalarMap[str, float]
    tcp_speed_limit: float
    efforts: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, name: _Optional[str] = ..., positions: _Optional[_Iterable[float]] = ..., velocities: _Optional[_Iterable[float]] = ..., world_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., tool: _Optional[str] = ..., tool_center_point: _Optional[str] = ..., tool_states: _Optional[_Mapping[str, str]] = ..., speed_factor: _Optional[float] = ..., motion_ids: _Optional[_Iterable[str]] = ..., actuator_positions: _Optional[_Iterable[float]] = ..., commanded_positions: _Optional[_Iterable[float]] = ..., commanded_velocities: _Optional[_Iterable[float]] = ..., tool_widths: _Optional[_Mapping[str, float]] = ..., tcp_speed_limit: _Optional[float] = ..., efforts: _Optional[_Iterable[float]] = ...) -> None: ...

class GetRobotStatesRequest(_message.Message):
    __slots__ = ("names", "read_mask")
    NAMES_FIELD_NUMBER: _ClassVar[int]
    READ_MASK_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    read_mask: _field_mask_pb2.FieldMask
    def __init__(self, names: _Optional[_Iterable[str]] = ..., read_mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ...) -> None: ...

class GetRobotStatesResponse(_message.Message):
    __slots__ = ("stamp", "robots")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    robots: _containers.RepeatedCompositeFieldContainer[RobotState]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., robots: _Optional[_Iterable[_Union[RobotState, _Mapping]]] = ...) -> None: ...

class WatchRobotStatesRequest(_message.Message):
    __slots__ = ("names", "read_mask", "max_rate_hertz", "every_tick")
    NAMES_FIELD_NUMBER: _ClassVar[int]
    READ_MASK_FIELD_NUMBER: _ClassVar[int]
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    EVERY_TICK_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    read_mask: _field_mask_pb2.FieldMask
    max_rate_hertz: float
    every_tick: bool
    def __init__(self, names: _Optional[_Iterable[str]] = ..., read_mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ..., max_rate_hertz: _Optional[float] = ..., every_tick: bool = ...) -> None: ...

class WatchRobotStatesResponse(_message.Message):
    __slots__ = ("stamp", "robots", "removed_names", "ticks", "lost_ticks")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    REMOVED_NAMES_FIELD_NUMBER: _ClassVar[int]
    TICKS_FIELD_NUMBER: _ClassVar[int]
    LOST_TICKS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    robots: _containers.RepeatedCompositeFieldContainer[RobotState]
    removed_names: _containers.RepeatedScalarFieldContainer[str]
    ticks: _containers.RepeatedCompositeFieldContainer[WatchRobotStatesResponse]
    lost_ticks: int
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., robots: _Optional[_Iterable[_Union[RobotState, _Mapping]]] = ..., removed_names: _Optional[_Iterable[str]] = ..., ticks: _Optional[_Iterable[_Union[WatchRobotStatesResponse, _Mapping]]] = ..., lost_ticks: _Optional[int] = ...) -> None: ...

class SolveForwardRequest(_message.Message):
    __slots__ = ("robot", "joint_positions", "group", "with_configuration")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    WITH_CONFIGURATION_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_positions: _containers.ScalarMap[str, float]
    group: _nodes_pb2.GroupSelection
    with_configuration: bool
    def __init__(self, robot: _Optional[str] = ..., joint_positions: _Optional[_Mapping[str, float]] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., with_configuration: bool = ...) -> None: ...

class SolveForwardResponse(_message.Message):
    __slots__ = ("stamp", "world_t_tcp", "links", "world_t_link", "configuration")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_TCP_FIELD_NUMBER: _ClassVar[int]
    LINKS_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_LINK_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATION_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    world_t_tcp: _geometry_pb2.Pose
    links: _containers.RepeatedScalarFieldContainer[str]
    world_t_link: _geometry_pb2.NumericArray
    configuration: str
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., world_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., links: _Optional[_Iterable[str]] = ..., world_t_link: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., configuration: _Optional[str] = ...) -> None: ...

class SolveJacobianRequest(_message.Message):
    __slots__ = ("robot", "joint_positions", "points", "group")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_positions: _containers.ScalarMap[str, float]
    points: _containers.RepeatedCompositeFieldContainer[RobotPoint]
    group: _nodes_pb2.GroupSelection
    def __init__(self, robot: _Optional[str] = ..., joint_positions: _Optional[_Mapping[str, float]] = ..., points: _Optional[_Iterable[_Union[RobotPoint, _Mapping]]] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ...) -> None: ...

class RobotPoint(_message.Message):
    __slots__ = ("node", "point", "reference")
    NODE_FIELD_NUMBER: _ClassVar[int]
    POINT_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    node: str
    point: _geometry_pb2.Vector3
    reference: str
    def __init__(self, node: _Optional[str] = ..., point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., reference: _Optional[str] = ...) -> None: ...

class SolveJacobianResponse(_message.Message):
    __slots__ = ("stamp", "joint_names", "world_t_tcp", "tcp_jacobian", "point_jacobians")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_TCP_FIELD_NUMBER: _ClassVar[int]
    TCP_JACOBIAN_FIELD_NUMBER: _ClassVar[int]
    POINT_JACOBIANS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    world_t_tcp: _geometry_pb2.Pose
    tcp_jacobian: _geometry_pb2.NumericArray
    point_jacobians: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., joint_names: _Optional[_Iterable[str]] = ..., world_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., tcp_jacobian: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., point_jacobians: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class SolveInverseRequest(_message.Message):
    __slots__ = ("robot", "reference_t_tcp", "reference", "seed", "configuration", "redundancy", "group")
    class SeedEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_T_TCP_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATION_FIELD_NUMBER: _ClassVar[int]
    REDUNDANCY_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    robot: str
    reference_t_tcp: _geometry_pb2.Pose
    reference: str
    seed: _containers.ScalarMap[str, float]
    configuration: str
    redundancy: Redundancy
    group: _nodes_pb2.GroupSelection
    def __init__(self, robot: _Optional[str] = ..., reference_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., reference: _Optional[str] = ..., seed: _Optional[_Mapping[str, float]] = ..., configuration: _Optional[str] = ..., redundancy: _Optional[_Union[Redundancy, _Mapping]] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ...) -> None: ...

class Redundancy(_message.Message):
    __slots__ = ("locked_joints", "arm_angle_radians", "preference", "posture")
    class LockedJointsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    class PostureEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    LOCKED_JOINTS_FIELD_NUMBER: _ClassVar[int]
    ARM_ANGLE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    PREFERENCE_FIELD_NUMBER: _ClassVar[int]
    POSTURE_FIELD_NUMBER: _ClassVar[int]
    locked_joints: _containers.ScalarMap[str, float]
    arm_angle_radians: float
    preference: RedundancyPreference
    posture: _containers.ScalarMap[str, float]
    def __init__(self, locked_joints: _Optional[_Mapping[str, float]] = ..., arm_angle_radians: _Optional[float] = ..., preference: _Optional[_Union[RedundancyPreference, str]] = ..., posture: _Optional[_Mapping[str, float]] = ...) -> None: ...

class SolveInverseResponse(_message.Message):
    __slots__ = ("stamp", "status", "joint_names", "solutions", "configurations", "position_error_meters", "rotation_error_radians", "explanation", "arm_angles_radians")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    SOLUTIONS_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATIONS_FIELD_NUMBER: _ClassVar[int]
    POSITION_ERROR_METERS_FIELD_NUMBER: _ClassVar[int]
    ROTATION_ERROR_RADIANS_FIELD_NUMBER: _ClassVar[int]
    EXPLANATION_FIELD_NUMBER: _ClassVar[int]
    ARM_ANGLES_RADIANS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    status: InverseStatus
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    solutions: _geometry_pb2.NumericArray
    configurations: _containers.RepeatedScalarFieldContainer[str]
    position_error_meters: float
    rotation_error_radians: float
    explanation: str
    arm_angles_radians: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., status: _Optional[_Union[InverseStatus, str]] = ..., joint_names: _Optional[_Iterable[str]] = ..., solutions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., configurations: _Optional[_Iterable[str]] = ..., position_error_meters: _Optional[float] = ..., rotation_error_radians: _Optional[float] = ..., explanation: _Optional[str] = ..., arm_angles_radians: _Optional[_Iterable[float]] = ...) -> None: ...

class SolvePointsRequest(_message.Message):
    __slots__ = ("robot", "group", "points", "reference", "seed")
    class SeedEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    robot: str
    group: _nodes_pb2.GroupSelection
    points: _geometry_pb2.NumericArray
    reference: str
    seed: _containers.ScalarMap[str, float]
    def __init__(self, robot: _Optional[str] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., points: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., reference: _Optional[str] = ..., seed: _Optional[_Mapping[str, float]] = ...) -> None: ...

class SolvePointsResponse(_message.Message):
    __slots__ = ("stamp", "status", "joint_names", "positions", "position_error_meters", "explanation")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    POSITION_ERROR_METERS_FIELD_NUMBER: _ClassVar[int]
    EXPLANATION_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    status: InverseStatus
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    position_error_meters: float
    explanation: str
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., status: _Optional[_Union[InverseStatus, str]] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., position_error_meters: _Optional[float] = ..., explanation: _Optional[str] = ...) -> None: ...

class SolveDrivesRequest(_message.Message):
    __slots__ = ("robot", "parts", "goal")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    PARTS_FIELD_NUMBER: _ClassVar[int]
    GOAL_FIELD_NUMBER: _ClassVar[int]
    robot: str
    parts: _geometry_pb2.NumericArray
    goal: DriveGoal
    def __init__(self, robot: _Optional[str] = ..., parts: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., goal: _Optional[_Union[DriveGoal, _Mapping]] = ...) -> None: ...

class DriveGoal(_message.Message):
    __slots__ = ("x_meters", "y_meters", "heading_radians", "may_reverse", "turning_radius_meters")
    X_METERS_FIELD_NUMBER: _ClassVar[int]
    Y_METERS_FIELD_NUMBER: _ClassVar[int]
    HEADING_RADIANS_FIELD_NUMBER: _ClassVar[int]
    MAY_REVERSE_FIELD_NUMBER: _ClassVar[int]
    TURNING_RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    x_meters: float
    y_meters: float
    heading_radians: float
    may_reverse: bool
    turning_radius_meters: float
    def __init__(self, x_meters: _Optional[float] = ..., y_meters: _Optional[float] = ..., heading_radians: _Optional[float] = ..., may_reverse: bool = ..., turning_radius_meters: _Optional[float] = ...) -> None: ...

class SolveDrivesResponse(_message.Message):
    __slots__ = ("stamp", "joint_names", "positions", "x_meters", "y_meters", "heading_radians", "parts", "length_meters", "word", "turning_radius_meters")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    X_METERS_FIELD_NUMBER: _ClassVar[int]
    Y_METERS_FIELD_NUMBER: _ClassVar[int]
    HEADING_RADIANS_FIELD_NUMBER: _ClassVar[int]
    PARTS_FIELD_NUMBER: _ClassVar[int]
    LENGTH_METERS_FIELD_NUMBER: _ClassVar[int]
    WORD_FIELD_NUMBER: _ClassVar[int]
    TURNING_RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    x_meters: float
    y_meters: float
    heading_radians: float
    parts: _geometry_pb2.NumericArray
    length_meters: float
    word: str
    turning_radius_meters: float
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., x_meters: _Optional[float] = ..., y_meters: _Optional[float] = ..., heading_radians: _Optional[float] = ..., parts: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., length_meters: _Optional[float] = ..., word: _Optional[str] = ..., turning_radius_meters: _Optional[float] = ...) -> None: ...

class ReckonDrivesRequest(_message.Message):
    __slots__ = ("robot", "joint_names", "positions", "settings", "x_meters", "y_meters", "heading_radians", "covariance", "variance_per_radian")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    X_METERS_FIELD_NUMBER: _ClassVar[int]
    Y_METERS_FIELD_NUMBER: _ClassVar[int]
    HEADING_RADIANS_FIELD_NUMBER: _ClassVar[int]
    COVARIANCE_FIELD_NUMBER: _ClassVar[int]
    VARIANCE_PER_RADIAN_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    settings: _struct_pb2.Struct
    x_meters: float
    y_meters: float
    heading_radians: float
    covariance: _geometry_pb2.NumericArray
    variance_per_radian: float
    def __init__(self, robot: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., x_meters: _Optional[float] = ..., y_meters: _Optional[float] = ..., heading_radians: _Optional[float] = ..., covariance: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., variance_per_radian: _Optional[float] = ...) -> None: ...

class ReckonDrivesResponse(_message.Message):
    __slots__ = ("stamp", "poses", "covariances")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    POSES_FIELD_NUMBER: _ClassVar[int]
    COVARIANCES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    poses: _geometry_pb2.NumericArray
    covariances: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., poses: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., covariances: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class KinematicsChoice(_message.Message):
    __slots__ = ("robot", "kinematics", "settings", "group")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    robot: str
    kinematics: str
    settings: _struct_pb2.Struct
    group: str
    def __init__(self, robot: _Optional[str] = ..., kinematics: _Optional[str] = ..., settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., group: _Optional[str] = ...) -> None: ...

class SetKinematicsRequest(_message.Message):
    __slots__ = ("choice",)
    CHOICE_FIELD_NUMBER: _ClassVar[int]
    choice: KinematicsChoice
    def __init__(self, choice: _Optional[_Union[KinematicsChoice, _Mapping]] = ...) -> None: ...

class SetKinematicsResponse(_message.Message):
    __slots__ = ("stamp", "check")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CHECK_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    check: KinematicsCheck
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., check: _Optional[_Union[KinematicsCheck, _Mapping]] = ...) -> None: ...

class KinematicsCheck(_message.Message):
    __slots__ = ("postures", "forward_position_error_meters", "forward_rotation_error_radians", "inverse_position_error_meters", "inverse_rotation_error_radians", "jacobian_error", "forward_seconds", "jacobian_seconds", "inverse_seconds")
    POSTURES_FIELD_NUMBER: _ClassVar[int]
    FORWARD_POSITION_ERROR_METERS_FIELD_NUMBER: _ClassVar[int]
    FORWARD_ROTATION_ERROR_RADIANS_FIELD_NUMBER: _ClassVar[int]
    INVERSE_POSITION_ERROR_METERS_FIELD_NUMBER: _ClassVar[int]
    INVERSE_ROTATION_ERROR_RADIANS_FIELD_NUMBER: _ClassVar[int]
    JACOBIAN_ERROR_FIELD_NUMBER: _ClassVar[int]
    FORWARD_SECONDS_FIELD_NUMBER: _ClassVar[int]
    JACOBIAN_SECONDS_FIELD_NUMBER: _ClassVar[int]
    INVERSE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    postures: int
    forward_position_error_meters: float
    forward_rotation_error_radians: float
    inverse_position_error_meters: float
    inverse_rotation_error_radians: float
    jacobian_error: float
    forward_seconds: float
    jacobian_seconds: float
    inverse_seconds: float
    def __init__(self, postures: _Optional[int] = ..., forward_position_error_meters: _Optional[float] = ..., forward_rotation_error_radians: _Optional[float] = ..., inverse_position_error_meters: _Optional[float] = ..., inverse_rotation_error_radians: _Optional[float] = ..., jacobian_error: _Optional[float] = ..., forward_seconds: _Optional[float] = ..., jacobian_seconds: _Optional[float] = ..., inverse_seconds: _Optional[float] = ...) -> None: ...

class SolveInverseDynamicsRequest(_message.Message):
    __slots__ = ("robot", "joint_names", "positions", "velocities", "accelerations")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    ACCELERATIONS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    velocities: _geometry_pb2.NumericArray
    accelerations: _geometry_pb2.NumericArray
    def __init__(self, robot: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., velocities: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., accelerations: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class SolveInverseDynamicsResponse(_message.Message):
    __slots__ = ("stamp", "joint_names", "efforts", "gravity_efforts", "base_wrenches", "first_violation", "payload_kilograms", "warnings")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    EFFORTS_FIELD_NUMBER: _ClassVar[int]
    GRAVITY_EFFORTS_FIELD_NUMBER: _ClassVar[int]
    BASE_WRENCHES_FIELD_NUMBER: _ClassVar[int]
    FIRST_VIOLATION_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_KILOGRAMS_FIELD_NUMBER: _ClassVar[int]
    WARNINGS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    efforts: _geometry_pb2.NumericArray
    gravity_efforts: _geometry_pb2.NumericArray
    base_wrenches: _geometry_pb2.NumericArray
    first_violation: EffortViolation
    payload_kilograms: float
    warnings: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., joint_names: _Optional[_Iterable[str]] = ..., efforts: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., gravity_efforts: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., base_wrenches: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., first_violation: _Optional[_Union[EffortViolation, _Mapping]] = ..., payload_kilograms: _Optional[float] = ..., warnings: _Optional[_Iterable[str]] = ...) -> None: ...

class EffortViolation(_message.Message):
    __slots__ = ("joint", "sample", "effort", "limit")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    SAMPLE_FIELD_NUMBER: _ClassVar[int]
    EFFORT_FIELD_NUMBER: _ClassVar[int]
    LIMIT_FIELD_NUMBER: _ClassVar[int]
    joint: str
    sample: int
    effort: float
    limit: float
    def __init__(self, joint: _Optional[str] = ..., sample: _Optional[int] = ..., effort: _Optional[float] = ..., limit: _Optional[float] = ...) -> None: ...
