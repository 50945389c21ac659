from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import nodes_pb2 as _nodes_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class CollisionDetail(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    COLLISION_DETAIL_UNSPECIFIED: _ClassVar[CollisionDetail]
    COLLISION_DETAIL_FIRST: _ClassVar[CollisionDetail]
    COLLISION_DETAIL_PAIRS: _ClassVar[CollisionDetail]
    COLLISION_DETAIL_CONTACTS: _ClassVar[CollisionDetail]

class AllowedCause(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ALLOWED_CAUSE_UNSPECIFIED: _ClassVar[AllowedCause]
    ALLOWED_CAUSE_RIGID: _ClassVar[AllowedCause]
    ALLOWED_CAUSE_ADJACENT: _ClassVar[AllowedCause]
    ALLOWED_CAUSE_MOUNTED: _ClassVar[AllowedCause]
    ALLOWED_CAUSE_HELD: _ClassVar[AllowedCause]
    ALLOWED_CAUSE_FILE: _ClassVar[AllowedCause]
    ALLOWED_CAUSE_CLIENT: _ClassVar[AllowedCause]
    ALLOWED_CAUSE_BUILT: _ClassVar[AllowedCause]

class CollisionMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    COLLISION_MODE_UNSPECIFIED: _ClassVar[CollisionMode]
    COLLISION_MODE_OFF: _ClassVar[CollisionMode]
    COLLISION_MODE_MONITOR: _ClassVar[CollisionMode]
    COLLISION_MODE_STOP: _ClassVar[CollisionMode]
    COLLISION_MODE_GUARD: _ClassVar[CollisionMode]
COLLISION_DETAIL_UNSPECIFIED: CollisionDetail
COLLISION_DETAIL_FIRST: CollisionDetail
COLLISION_DETAIL_PAIRS: CollisionDetail
COLLISION_DETAIL_CONTACTS: CollisionDetail
ALLOWED_CAUSE_UNSPECIFIED: AllowedCause
ALLOWED_CAUSE_RIGID: AllowedCause
ALLOWED_CAUSE_ADJACENT: AllowedCause
ALLOWED_CAUSE_MOUNTED: AllowedCause
ALLOWED_CAUSE_HELD: AllowedCause
ALLOWED_CAUSE_FILE: AllowedCause
ALLOWED_CAUSE_CLIENT: AllowedCause
ALLOWED_CAUSE_BUILT: AllowedCause
COLLISION_MODE_UNSPECIFIED: CollisionMode
COLLISION_MODE_OFF: CollisionMode
COLLISION_MODE_MONITOR: CollisionMode
COLLISION_MODE_STOP: CollisionMode
COLLISION_MODE_GUARD: CollisionMode

class RobotConfiguration(_message.Message):
    __slots__ = ("robot", "joint_positions")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_positions: _containers.ScalarMap[str, float]
    def __init__(self, robot: _Optional[str] = ..., joint_positions: _Optional[_Mapping[str, float]] = ...) -> None: ...

class CheckCollisionRequest(_message.Message):
    __slots__ = ("configurations", "detail", "robots")
    CONFIGURATIONS_FIELD_NUMBER: _ClassVar[int]
    DETAIL_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    configurations: _containers.RepeatedCompositeFieldContainer[RobotConfiguration]
    detail: CollisionDetail
    robots: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, configurations: _Optional[_Iterable[_Union[RobotConfiguration, _Mapping]]] = ..., detail: _Optional[_Union[CollisionDetail, str]] = ..., robots: _Optional[_Iterable[str]] = ...) -> None: ...

class CheckCollisionResponse(_message.Message):
    __slots__ = ("stamp", "pairs", "check_seconds")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    CHECK_SECONDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    pairs: _containers.RepeatedCompositeFieldContainer[CollisionPair]
    check_seconds: float
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., pairs: _Optional[_Iterable[_Union[CollisionPair, _Mapping]]] = ..., check_seconds: _Optional[float] = ...) -> None: ...

class RobotConfigurations(_message.Message):
    __slots__ = ("robot", "joint_names", "positions")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    def __init__(self, robot: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CheckConfigurationsRequest(_message.Message):
    __slots__ = ("configurations", "robots", "may_touch")
    CONFIGURATIONS_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    MAY_TOUCH_FIELD_NUMBER: _ClassVar[int]
    configurations: _containers.RepeatedCompositeFieldContainer[RobotConfigurations]
    robots: _containers.RepeatedScalarFieldContainer[str]
    may_touch: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    def __init__(self, configurations: _Optional[_Iterable[_Union[RobotConfigurations, _Mapping]]] = ..., robots: _Optional[_Iterable[str]] = ..., may_touch: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ...) -> None: ...

class CheckConfigurationsResponse(_message.Message):
    __slots__ = ("stamp", "progress", "first_row", "touching", "pairs")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    FIRST_ROW_FIELD_NUMBER: _ClassVar[int]
    TOUCHING_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    progress: float
    first_row: int
    touching: _geometry_pb2.NumericArray
    pairs: _containers.RepeatedCompositeFieldContainer[CollisionPair]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., progress: _Optional[float] = ..., first_row: _Optional[int] = ..., touching: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., pairs: _Optional[_Iterable[_Union[CollisionPair, _Mapping]]] = ...) -> None: ...

class CollisionPair(_message.Message):
    __slots__ = ("first", "second", "contacts", "depth_meters", "depth_approximate")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    DEPTH_METERS_FIELD_NUMBER: _ClassVar[int]
    DEPTH_APPROXIMATE_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    contacts: _containers.RepeatedCompositeFieldContainer[CollisionContact]
    depth_meters: float
    depth_approximate: bool
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., contacts: _Optional[_Iterable[_Union[CollisionContact, _Mapping]]] = ..., depth_meters: _Optional[float] = ..., depth_approximate: bool = ...) -> None: ...

class CollisionContact(_message.Message):
    __slots__ = ("point", "normal")
    POINT_FIELD_NUMBER: _ClassVar[int]
    NORMAL_FIELD_NUMBER: _ClassVar[int]
    point: _geometry_pb2.Vector3
    normal: _geometry_pb2.Vector3
    def __init__(self, point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., normal: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class MeasureDistancesRequest(_message.Message):
    __slots__ = ("first", "second", "range_meters", "configurations")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    RANGE_METERS_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATIONS_FIELD_NUMBER: _ClassVar[int]
    first: _containers.RepeatedScalarFieldContainer[str]
    second: _containers.RepeatedScalarFieldContainer[str]
    range_meters: float
    configurations: _containers.RepeatedCompositeFieldContainer[RobotConfiguration]
    def __init__(self, first: _Optional[_Iterable[str]] = ..., second: _Optional[_Iterable[str]] = ..., range_meters: _Optional[float] = ..., configurations: _Optional[_Iterable[_Union[RobotConfiguration, _Mapping]]] = ...) -> None: ...

class MeasureDistancesResponse(_message.Message):
    __slots__ = ("stamp", "pairs", "measure_seconds")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    MEASURE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    pairs: _containers.RepeatedCompositeFieldContainer[DistancePair]
    measure_seconds: float
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., pairs: _Optional[_Iterable[_Union[DistancePair, _Mapping]]] = ..., measure_seconds: _Optional[float] = ...) -> None: ...

class DistancePair(_message.Message):
    __slots__ = ("first", "second", "distance_meters", "first_point", "second_point")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    FIRST_POINT_FIELD_NUMBER: _ClassVar[int]
    SECOND_POINT_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    distance_meters: float
    first_point: _geometry_pb2.Vector3
    second_point: _geometry_pb2.Vector3
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., distance_meters: _Optional[float] = ..., first_point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., second_point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class AllowedPair(_message.Message):
    __slots__ = ("first", "second", "cause", "reason")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    CAUSE_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    cause: AllowedCause
    reason: str
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., cause: _Optional[_Union[AllowedCause, str]] = ..., reason: _Optional[str] = ...) -> None: ...

class ListAllowedPairsRequest(_message.Message):
    __slots__ = ("nodes",)
    NODES_FIELD_NUMBER: _ClassVar[int]
    nodes: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, nodes: _Optional[_Iterable[str]] = ...) -> None: ...

class ListAllowedPairsResponse(_message.Message):
    __slots__ = ("stamp", "pairs")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    pairs: _containers.RepeatedCompositeFieldContainer[AllowedPair]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., pairs: _Optional[_Iterable[_Union[AllowedPair, _Mapping]]] = ...) -> None: ...

class SetAllowedPairs(_message.Message):
    __slots__ = ("forbid", "allow")
    FORBID_FIELD_NUMBER: _ClassVar[int]
    ALLOW_FIELD_NUMBER: _ClassVar[int]
    forbid: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    allow: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    def __init__(self, forbid: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ..., allow: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ...) -> None: ...

class FindAllowedPairsRequest(_message.Message):
    __slots__ = ("robot", "samples", "seed")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    SAMPLES_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    robot: str
    samples: int
    seed: int
    def __init__(self, robot: _Optional[str] = ..., samples: _Optional[int] = ..., seed: _Optional[int] = ...) -> None: ...

class FindAllowedPairsResponse(_message.Message):
    __slots__ = ("stamp", "progress", "pairs", "samples")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    SAMPLES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    progress: float
    pairs: _containers.RepeatedCompositeFieldContainer[SampledPair]
    samples: int
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., progress: _Optional[float] = ..., pairs: _Optional[_Iterable[_Union[SampledPair, _Mapping]]] = ..., samples: _Optional[int] = ...) -> None: ...

class RobotCollisionMode(_message.Message):
    __slots__ = ("robot", "mode")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    robot: str
    mode: CollisionMode
    def __init__(self, robot: _Optional[str] = ..., mode: _Optional[_Union[CollisionMode, str]] = ...) -> None: ...

class NodePadding(_message.Message):
    __slots__ = ("node", "padding_meters")
    NODE_FIELD_NUMBER: _ClassVar[int]
    PADDING_METERS_FIELD_NUMBER: _ClassVar[int]
    node: str
    padding_meters: float
    def __init__(self, node: _Optional[str] = ..., padding_meters: _Optional[float] = ...) -> None: ...

class CollisionSettings(_message.Message):
    __slots__ = ("mode", "robots", "look_ahead_seconds", "paddings")
    MODE_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    LOOK_AHEAD_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PADDINGS_FIELD_NUMBER: _ClassVar[int]
    mode: CollisionMode
    robots: _containers.RepeatedCompositeFieldContainer[RobotCollisionMode]
    look_ahead_seconds: float
    paddings: _containers.RepeatedCompositeFieldContainer[NodePadding]
    def __init__(self, mode: _Optional[_Union[CollisionMode, str]] = ..., robots: _Optional[_Iterable[_Union[RobotCollisionMode, _Mapping]]] = ..., look_ahead_seconds: _Optional[float] = ..., paddings: _Optional[_Iterable[_Union[NodePadding, _Mapping]]] = ...) -> None: ...

class GetCollisionSettingsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetCollisionSettingsResponse(_message.Message):
    __slots__ = ("stamp", "settings", "guard_cost")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    GUARD_COST_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    settings: CollisionSettings
    guard_cost: GuardCost
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., settings: _Optional[_Union[CollisionSettings, _Mapping]] = ..., guard_cost: _Optional[_Union[GuardCost, _Mapping]] = ...) -> None: ...

class GuardCost(_message.Message):
    __slots__ = ("ticks", "mean_seconds", "worst_seconds")
    TICKS_FIELD_NUMBER: _ClassVar[int]
    MEAN_SECONDS_FIELD_NUMBER: _ClassVar[int]
    WORST_SECONDS_FIELD_NUMBER: _ClassVar[int]
    ticks: int
    mean_seconds: float
    worst_seconds: float
    def __init__(self, ticks: _Optional[int] = ..., mean_seconds: _Optional[float] = ..., worst_seconds: _Optional[float] = ...) -> None: ...

class SetCollisionSettings(_message.Message):
    __slots__ = ("mode", "robots", "look_ahead_seconds", "paddings")
    MODE_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    LOOK_AHEAD_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PADDINGS_FIELD_NUMBER: _ClassVar[int]
    mode: CollisionMode
    robots: _containers.RepeatedCompositeFieldContainer[RobotCollisionMode]
    look_ahead_seconds: float
    paddings: _containers.RepeatedCompositeFieldContainer[NodePadding]
    def __init__(self, mode: _Optional[_Union[CollisionMode, str]] = ..., robots: _Optional[_Iterable[_Union[RobotCollisionMode, _Mapping]]] = ..., look_ahead_seconds: _Optional[float] = ..., paddings: _Optional[_Iterable[_Union[NodePadding, _Mapping]]] = ...) -> None: ...

class SampledPair(_message.Message):
    __slots__ = ("first", "second", "touched")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    TOUCHED_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    touched: int
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., touched: _Optional[int] = ...) -> None: ...

class WatchCollisionsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchCollisionsResponse(_message.Message):
    __slots__ = ("stamp", "touching", "events", "missed_events", "fault", "checks", "check_seconds")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    TOUCHING_FIELD_NUMBER: _ClassVar[int]
    EVENTS_FIELD_NUMBER: _ClassVar[int]
    MISSED_EVENTS_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    CHECKS_FIELD_NUMBER: _ClassVar[int]
    CHECK_SECONDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    touching: _containers.RepeatedCompositeFieldContainer[ReportedCollision]
    events: _containers.RepeatedCompositeFieldContainer[CollisionEvent]
    missed_events: int
    fault: str
    checks: int
    check_seconds: float
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., touching: _Optional[_Iterable[_Union[ReportedCollision, _Mapping]]] = ..., events: _Optional[_Iterable[_Union[CollisionEvent, _Mapping]]] = ..., missed_events: _Optional[int] = ..., fault: _Optional[str] = ..., checks: _Optional[int] = ..., check_seconds: _Optional[float] = ...) -> None: ...

class ReportedCollision(_message.Message):
    __slots__ = ("pair", "tolerated", "tick", "simulation_time_seconds")
    PAIR_FIELD_NUMBER: _ClassVar[int]
    TOLERATED_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    SIMULATION_TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    pair: CollisionPair
    tolerated: bool
    tick: int
    simulation_time_seconds: float
    def __init__(self, pair: _Optional[_Union[CollisionPair, _Mapping]] = ..., tolerated: bool = ..., tick: _Optional[int] = ..., simulation_time_seconds: _Optional[float] = ...) -> None: ...

class CollisionEvent(_message.Message):
    __slots__ = ("number", "tick", "simulation_time_seconds", "begun", "ended", "stopped", "fault")
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    SIMULATION_TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    BEGUN_FIELD_NUMBER: _ClassVar[int]
    ENDED_FIELD_NUMBER: _ClassVar[int]
    STOPPED_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    number: int
    tick: int
    simulation_time_seconds: float
    begun: ReportedCollision
    ended: EndedCollision
    stopped: StoppedRobots
    fault: str
    def __init__(self, number: _Optional[int] = ..., tick: _Optional[int] = ..., simulation_time_seconds: _Optional[float] = ..., begun: _Optional[_Union[ReportedCollision, _Mapping]] = ..., ended: _Optional[_Union[EndedCollision, _Mapping]] = ..., stopped: _Optional[_Union[StoppedRobots, _Mapping]] = ..., fault: _Optional[str] = ...) -> None: ...

class EndedCollision(_message.Message):
    __slots__ = ("first", "second", "apart")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    APART_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    apart: bool
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., apart: bool = ...) -> None: ...

class StoppedRobots(_message.Message):
    __slots__ = ("robots", "motion_ids", "reason")
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    MOTION_IDS_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    robots: _containers.RepeatedScalarFieldContainer[str]
    motion_ids: _containers.RepeatedScalarFieldContainer[str]
    reason: str
    def __init__(self, robots: _Optional[_Iterable[str]] = ..., motion_ids: _Optional[_Iterable[str]] = ..., reason: _Optional[str] = ...) -> None: ...

class ListCollisionMeshesRequest(_message.Message):
    __slots__ = ("nodes",)
    NODES_FIELD_NUMBER: _ClassVar[int]
    nodes: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, nodes: _Optional[_Iterable[str]] = ...) -> None: ...

class ListCollisionMeshesResponse(_message.Message):
    __slots__ = ("stamp", "meshes")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MESHES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    meshes: _containers.RepeatedCompositeFieldContainer[CollisionMesh]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., meshes: _Optional[_Iterable[_Union[CollisionMesh, _Mapping]]] = ...) -> None: ...

class CollisionMesh(_message.Message):
    __slots__ = ("node", "figure", "uri", "mesh_triangles", "triangles", "hull", "deviation_meters", "convex", "seconds", "warning")
    NODE_FIELD_NUMBER: _ClassVar[int]
    FIGURE_FIELD_NUMBER: _ClassVar[int]
    URI_FIELD_NUMBER: _ClassVar[int]
    MESH_TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    HULL_FIELD_NUMBER: _ClassVar[int]
    DEVIATION_METERS_FIELD_NUMBER: _ClassVar[int]
    CONVEX_FIELD_NUMBER: _ClassVar[int]
    SECONDS_FIELD_NUMBER: _ClassVar[int]
    WARNING_FIELD_NUMBER: _ClassVar[int]
    node: str
    figure: int
    uri: str
    mesh_triangles: int
    triangles: int
    hull: bool
    deviation_meters: float
    convex: bool
    seconds: float
    warning: str
    def __init__(self, node: _Optional[str] = ..., figure: _Optional[int] = ..., uri: _Optional[str] = ..., mesh_triangles: _Optional[int] = ..., triangles: _Optional[int] = ..., hull: bool = ..., deviation_meters: _Optional[float] = ..., convex: bool = ..., seconds: _Optional[float] = ..., warning: _Optional[str] = ...) -> None: ...
