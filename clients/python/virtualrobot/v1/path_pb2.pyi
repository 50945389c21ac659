from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import motion_pb2 as _motion_pb2
from virtualrobot.v1 import nodes_pb2 as _nodes_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PathPlanner(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PATH_PLANNER_UNSPECIFIED: _ClassVar[PathPlanner]
    PATH_PLANNER_RRT_CONNECT: _ClassVar[PathPlanner]
    PATH_PLANNER_RRT: _ClassVar[PathPlanner]
    PATH_PLANNER_KPIECE1: _ClassVar[PathPlanner]
    PATH_PLANNER_BKPIECE1: _ClassVar[PathPlanner]
    PATH_PLANNER_LBKPIECE1: _ClassVar[PathPlanner]
    PATH_PLANNER_RRT_STAR: _ClassVar[PathPlanner]
    PATH_PLANNER_INFORMED_RRT_STAR: _ClassVar[PathPlanner]
PATH_PLANNER_UNSPECIFIED: PathPlanner
PATH_PLANNER_RRT_CONNECT: PathPlanner
PATH_PLANNER_RRT: PathPlanner
PATH_PLANNER_KPIECE1: PathPlanner
PATH_PLANNER_BKPIECE1: PathPlanner
PATH_PLANNER_LBKPIECE1: PathPlanner
PATH_PLANNER_RRT_STAR: PathPlanner
PATH_PLANNER_INFORMED_RRT_STAR: PathPlanner

class FindPathRequest(_message.Message):
    __slots__ = ("robot", "start", "goal", "planner", "seed", "time_limit_seconds", "speed_factor", "blend_percent", "group", "clearance_meters")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    START_FIELD_NUMBER: _ClassVar[int]
    GOAL_FIELD_NUMBER: _ClassVar[int]
    PLANNER_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    TIME_LIMIT_SECONDS_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    BLEND_PERCENT_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    CLEARANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    start: _motion_pb2.JointGoal
    goal: _motion_pb2.PointToPoint
    planner: PathPlanner
    seed: int
    time_limit_seconds: float
    speed_factor: float
    blend_percent: float
    group: _nodes_pb2.GroupSelection
    clearance_meters: float
    def __init__(self, robot: _Optional[str] = ..., start: _Optional[_Union[_motion_pb2.JointGoal, _Mapping]] = ..., goal: _Optional[_Union[_motion_pb2.PointToPoint, _Mapping]] = ..., planner: _Optional[_Union[PathPlanner, str]] = ..., seed: _Optional[int] = ..., time_limit_seconds: _Optional[float] = ..., speed_factor: _Optional[float] = ..., blend_percent: _Optional[float] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., clearance_meters: _Optional[float] = ...) -> None: ...

class FindPathResponse(_message.Message):
    __slots__ = ("stamp", "elapsed_seconds", "states", "checks", "path")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    ELAPSED_SECONDS_FIELD_NUMBER: _ClassVar[int]
    STATES_FIELD_NUMBER: _ClassVar[int]
    CHECKS_FIELD_NUMBER: _ClassVar[int]
    PATH_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    elapsed_seconds: float
    states: int
    checks: int
    path: FoundPath
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., elapsed_seconds: _Optional[float] = ..., states: _Optional[int] = ..., checks: _Optional[int] = ..., path: _Optional[_Union[FoundPath, _Mapping]] = ...) -> None: ...

class FoundPath(_message.Message):
    __slots__ = ("joint_names", "waypoints", "straight", "length", "straight_length", "spec", "duration_seconds", "planner", "planning_seconds")
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    WAYPOINTS_FIELD_NUMBER: _ClassVar[int]
    STRAIGHT_FIELD_NUMBER: _ClassVar[int]
    LENGTH_FIELD_NUMBER: _ClassVar[int]
    STRAIGHT_LENGTH_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PLANNER_FIELD_NUMBER: _ClassVar[int]
    PLANNING_SECONDS_FIELD_NUMBER: _ClassVar[int]
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    waypoints: _containers.RepeatedCompositeFieldContainer[Waypoint]
    straight: bool
    length: float
    straight_length: float
    spec: _motion_pb2.MotionSpec
    duration_seconds: float
    planner: PathPlanner
    planning_seconds: float
    def __init__(self, joint_names: _Optional[_Iterable[str]] = ..., waypoints: _Optional[_Iterable[_Union[Waypoint, _Mapping]]] = ..., straight: bool = ..., length: _Optional[float] = ..., straight_length: _Optional[float] = ..., spec: _Optional[_Union[_motion_pb2.MotionSpec, _Mapping]] = ..., duration_seconds: _Optional[float] = ..., planner: _Optional[_Union[PathPlanner, str]] = ..., planning_seconds: _Optional[float] = ...) -> None: ...

class Waypoint(_message.Message):
    __slots__ = ("positions",)
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    positions: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, positions: _Optional[_Iterable[float]] = ...) -> None: ...

class AxisTolerance(_message.Message):
    __slots__ = ("lower", "upper", "free")
    LOWER_FIELD_NUMBER: _ClassVar[int]
    UPPER_FIELD_NUMBER: _ClassVar[int]
    FREE_FIELD_NUMBER: _ClassVar[int]
    lower: float
    upper: float
    free: bool
    def __init__(self, lower: _Optional[float] = ..., upper: _Optional[float] = ..., free: bool = ...) -> None: ...

class ToolPath(_message.Message):
    __slots__ = ("frames", "reference", "x", "y", "z", "rotation_x", "rotation_y", "rotation_z", "velocity_meters_per_second", "acceleration_meters_per_second_squared", "max_slope_radians")
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    ROTATION_X_FIELD_NUMBER: _ClassVar[int]
    ROTATION_Y_FIELD_NUMBER: _ClassVar[int]
    ROTATION_Z_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    MAX_SLOPE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    frames: _geometry_pb2.NumericArray
    reference: str
    x: AxisTolerance
    y: AxisTolerance
    z: AxisTolerance
    rotation_x: AxisTolerance
    rotation_y: AxisTolerance
    rotation_z: AxisTolerance
    velocity_meters_per_second: float
    acceleration_meters_per_second_squared: float
    max_slope_radians: float
    def __init__(self, frames: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., reference: _Optional[str] = ..., x: _Optional[_Union[AxisTolerance, _Mapping]] = ..., y: _Optional[_Union[AxisTolerance, _Mapping]] = ..., z: _Optional[_Union[AxisTolerance, _Mapping]] = ..., rotation_x: _Optional[_Union[AxisTolerance, _Mapping]] = ..., rotation_y: _Optional[_Union[AxisTolerance, _Mapping]] = ..., rotation_z: _Optional[_Union[AxisTolerance, _Mapping]] = ..., velocity_meters_per_second: _Optional[float] = ..., acceleration_meters_per_second_squared: _Optional[float] = ..., max_slope_radians: _Optional[float] = ...) -> None: ...

class FindToolPathRequest(_message.Message):
    __slots__ = ("robot", "group", "path", "time_limit_seconds", "external_robots", "may_touch", "partners")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    PATH_FIELD_NUMBER: _ClassVar[int]
    TIME_LIMIT_SECONDS_FIELD_NUMBER: _ClassVar[int]
    EXTERNAL_ROBOTS_FIELD_NUMBER: _ClassVar[int]
    MAY_TOUCH_FIELD_NUMBER: _ClassVar[int]
    PARTNERS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    group: _nodes_pb2.GroupSelection
    path: ToolPath
    time_limit_seconds: float
    external_robots: _containers.RepeatedScalarFieldContainer[str]
    may_touch: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    partners: _containers.RepeatedCompositeFieldContainer[ToolPathPartner]
    def __init__(self, robot: _Optional[str] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., path: _Optional[_Union[ToolPath, _Mapping]] = ..., time_limit_seconds: _Optional[float] = ..., external_robots: _Optional[_Iterable[str]] = ..., may_touch: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ..., partners: _Optional[_Iterable[_Union[ToolPathPartner, _Mapping]]] = ...) -> None: ...

class ToolPathPartner(_message.Message):
    __slots__ = ("robot", "group", "path")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    PATH_FIELD_NUMBER: _ClassVar[int]
    robot: str
    group: _nodes_pb2.GroupSelection
    path: ToolPath
    def __init__(self, robot: _Optional[str] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., path: _Optional[_Union[ToolPath, _Mapping]] = ...) -> None: ...

class ExternalMotion(_message.Message):
    __slots__ = ("robot", "joint_names", "positions")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    def __init__(self, robot: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class FindToolPathResponse(_message.Message):
    __slots__ = ("stamp", "elapsed_seconds", "searches", "checks", "path")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    ELAPSED_SECONDS_FIELD_NUMBER: _ClassVar[int]
    SEARCHES_FIELD_NUMBER: _ClassVar[int]
    CHECKS_FIELD_NUMBER: _ClassVar[int]
    PATH_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    elapsed_seconds: float
    searches: int
    checks: int
    path: FoundToolPath
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., elapsed_seconds: _Optional[float] = ..., searches: _Optional[int] = ..., checks: _Optional[int] = ..., path: _Optional[_Union[FoundToolPath, _Mapping]] = ...) -> None: ...

class FoundToolPath(_message.Message):
    __slots__ = ("joint_names", "times", "positions", "freedoms", "length_meters", "held_from_seconds", "held_until_seconds", "duration_seconds", "spec", "planning_seconds", "external", "partners")
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    TIMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    FREEDOMS_FIELD_NUMBER: _ClassVar[int]
    LENGTH_METERS_FIELD_NUMBER: _ClassVar[int]
    HELD_FROM_SECONDS_FIELD_NUMBER: _ClassVar[int]
    HELD_UNTIL_SECONDS_FIELD_NUMBER: _ClassVar[int]
    DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    PLANNING_SECONDS_FIELD_NUMBER: _ClassVar[int]
    EXTERNAL_FIELD_NUMBER: _ClassVar[int]
    PARTNERS_FIELD_NUMBER: _ClassVar[int]
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    times: _geometry_pb2.NumericArray
    positions: _geometry_pb2.NumericArray
    freedoms: _geometry_pb2.NumericArray
    length_meters: float
    held_from_seconds: float
    held_until_seconds: float
    duration_seconds: float
    spec: _motion_pb2.MotionSpec
    planning_seconds: float
    external: _containers.RepeatedCompositeFieldContainer[ExternalMotion]
    partners: _containers.RepeatedCompositeFieldContainer[PartnerMotion]
    def __init__(self, joint_names: _Optional[_Iterable[str]] = ..., times: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., freedoms: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., length_meters: _Optional[float] = ..., held_from_seconds: _Optional[float] = ..., held_until_seconds: _Optional[float] = ..., duration_seconds: _Optional[float] = ..., spec: _Optional[_Union[_motion_pb2.MotionSpec, _Mapping]] = ..., planning_seconds: _Optional[float] = ..., external: _Optional[_Iterable[_Union[ExternalMotion, _Mapping]]] = ..., partners: _Optional[_Iterable[_Union[PartnerMotion, _Mapping]]] = ...) -> None: ...

class PartnerMotion(_message.Message):
    __slots__ = ("robot", "joint_names", "times", "positions", "freedoms", "length_meters", "velocity_meters_per_second")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    TIMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    FREEDOMS_FIELD_NUMBER: _ClassVar[int]
    LENGTH_METERS_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    times: _geometry_pb2.NumericArray
    positions: _geometry_pb2.NumericArray
    freedoms: _geometry_pb2.NumericArray
    length_meters: float
    velocity_meters_per_second: float
    def __init__(self, robot: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., times: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., freedoms: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., length_meters: _Optional[float] = ..., velocity_meters_per_second: _Optional[float] = ...) -> None: ...
