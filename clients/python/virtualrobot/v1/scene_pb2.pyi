from google.protobuf import field_mask_pb2 as _field_mask_pb2
from google.protobuf import struct_pb2 as _struct_pb2
from virtualrobot.v1 import collision_pb2 as _collision_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import lease_pb2 as _lease_pb2
from virtualrobot.v1 import nodes_pb2 as _nodes_pb2
from virtualrobot.v1 import physics_pb2 as _physics_pb2
from virtualrobot.v1 import robot_pb2 as _robot_pb2
from virtualrobot.v1 import sensor_pb2 as _sensor_pb2
from virtualrobot.v1 import signal_pb2 as _signal_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class TwinGhostKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    TWIN_GHOST_KIND_UNSPECIFIED: _ClassVar[TwinGhostKind]
    TWIN_GHOST_KIND_COMMANDED: _ClassVar[TwinGhostKind]
    TWIN_GHOST_KIND_MEASURED: _ClassVar[TwinGhostKind]

class DenavitHartenbergConvention(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DENAVIT_HARTENBERG_CONVENTION_UNSPECIFIED: _ClassVar[DenavitHartenbergConvention]
    DENAVIT_HARTENBERG_CONVENTION_STANDARD: _ClassVar[DenavitHartenbergConvention]
    DENAVIT_HARTENBERG_CONVENTION_MODIFIED: _ClassVar[DenavitHartenbergConvention]
TWIN_GHOST_KIND_UNSPECIFIED: TwinGhostKind
TWIN_GHOST_KIND_COMMANDED: TwinGhostKind
TWIN_GHOST_KIND_MEASURED: TwinGhostKind
DENAVIT_HARTENBERG_CONVENTION_UNSPECIFIED: DenavitHartenbergConvention
DENAVIT_HARTENBERG_CONVENTION_STANDARD: DenavitHartenbergConvention
DENAVIT_HARTENBERG_CONVENTION_MODIFIED: DenavitHartenbergConvention

class GetSceneRequest(_message.Message):
    __slots__ = ("names", "read_mask")
    NAMES_FIELD_NUMBER: _ClassVar[int]
    READ_MASK_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    read_mask: _field_mask_pb2.FieldMask
    def __init__(self, names: _Optional[_Iterable[str]] = ..., read_mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ...) -> None: ...

class GetSceneResponse(_message.Message):
    __slots__ = ("stamp", "nodes", "world_t_node")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_NODE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    nodes: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.Node]
    world_t_node: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., nodes: _Optional[_Iterable[_Union[_nodes_pb2.Node, _Mapping]]] = ..., world_t_node: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class GetNodeBoundsRequest(_message.Message):
    __slots__ = ("names",)
    NAMES_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, names: _Optional[_Iterable[str]] = ...) -> None: ...

class GetNodeBoundsResponse(_message.Message):
    __slots__ = ("stamp", "bounds")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    BOUNDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    bounds: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., bounds: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class GetNodeTwistsRequest(_message.Message):
    __slots__ = ("names",)
    NAMES_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, names: _Optional[_Iterable[str]] = ...) -> None: ...

class GetNodeTwistsResponse(_message.Message):
    __slots__ = ("stamp", "twists", "world_t_node")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    TWISTS_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_NODE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    twists: _geometry_pb2.NumericArray
    world_t_node: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., twists: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., world_t_node: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class WatchSceneRequest(_message.Message):
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

class WatchSceneResponse(_message.Message):
    __slots__ = ("stamp", "nodes", "removed_uids", "moved_uids", "world_t_node", "twin_ghosts", "ticks", "lost_ticks")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    REMOVED_UIDS_FIELD_NUMBER: _ClassVar[int]
    MOVED_UIDS_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_NODE_FIELD_NUMBER: _ClassVar[int]
    TWIN_GHOSTS_FIELD_NUMBER: _ClassVar[int]
    TICKS_FIELD_NUMBER: _ClassVar[int]
    LOST_TICKS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    nodes: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.Node]
    removed_uids: _containers.RepeatedScalarFieldContainer[int]
    moved_uids: _containers.RepeatedScalarFieldContainer[int]
    world_t_node: _geometry_pb2.NumericArray
    twin_ghosts: TwinGhosts
    ticks: _containers.RepeatedCompositeFieldContainer[WatchSceneResponse]
    lost_ticks: int
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., nodes: _Optional[_Iterable[_Union[_nodes_pb2.Node, _Mapping]]] = ..., removed_uids: _Optional[_Iterable[int]] = ..., moved_uids: _Optional[_Iterable[int]] = ..., world_t_node: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., twin_ghosts: _Optional[_Union[TwinGhosts, _Mapping]] = ..., ticks: _Optional[_Iterable[_Union[WatchSceneResponse, _Mapping]]] = ..., lost_ticks: _Optional[int] = ...) -> None: ...

class TwinGhost(_message.Message):
    __slots__ = ("robot_uid", "kind", "node_uids", "world_t_node")
    ROBOT_UID_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    NODE_UIDS_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_NODE_FIELD_NUMBER: _ClassVar[int]
    robot_uid: int
    kind: TwinGhostKind
    node_uids: _containers.RepeatedScalarFieldContainer[int]
    world_t_node: _geometry_pb2.NumericArray
    def __init__(self, robot_uid: _Optional[int] = ..., kind: _Optional[_Union[TwinGhostKind, str]] = ..., node_uids: _Optional[_Iterable[int]] = ..., world_t_node: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class TwinGhosts(_message.Message):
    __slots__ = ("ghosts",)
    GHOSTS_FIELD_NUMBER: _ClassVar[int]
    ghosts: _containers.RepeatedCompositeFieldContainer[TwinGhost]
    def __init__(self, ghosts: _Optional[_Iterable[_Union[TwinGhost, _Mapping]]] = ...) -> None: ...

class ApplyRequest(_message.Message):
    __slots__ = ("commands", "expected_structure_revision", "request_id")
    COMMANDS_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_STRUCTURE_REVISION_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    commands: _containers.RepeatedCompositeFieldContainer[Command]
    expected_structure_revision: int
    request_id: str
    def __init__(self, commands: _Optional[_Iterable[_Union[Command, _Mapping]]] = ..., expected_structure_revision: _Optional[int] = ..., request_id: _Optional[str] = ...) -> None: ...

class ApplyResponse(_message.Message):
    __slots__ = ("stamp", "created", "picked_parts", "allowed_pairs")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CREATED_FIELD_NUMBER: _ClassVar[int]
    PICKED_PARTS_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_PAIRS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    created: _containers.RepeatedCompositeFieldContainer[CreatedNode]
    picked_parts: _containers.RepeatedScalarFieldContainer[str]
    allowed_pairs: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., created: _Optional[_Iterable[_Union[CreatedNode, _Mapping]]] = ..., picked_parts: _Optional[_Iterable[str]] = ..., allowed_pairs: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ...) -> None: ...

class CreatedNode(_message.Message):
    __slots__ = ("uid", "name")
    UID_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    uid: int
    name: str
    def __init__(self, uid: _Optional[int] = ..., name: _Optional[str] = ...) -> None: ...

class Command(_message.Message):
    __slots__ = ("create_node", "update_node", "remove_node", "attach_node", "pick_part", "place_part", "set_joint_positions", "select_tool", "set_tool_state", "create_signal", "remove_signal", "set_signal", "set_speed_factor", "set_collision_settings", "set_allowed_pairs", "set_kinematics", "start_sensors", "stop_sensors", "set_groups", "set_postures", "mount_tool", "unmount_tool", "set_tcp_speed_limit", "set_craft", "set_physics", "set_joint_efforts")
    CREATE_NODE_FIELD_NUMBER: _ClassVar[int]
    UPDATE_NODE_FIELD_NUMBER: _ClassVar[int]
    REMOVE_NODE_FIELD_NUMBER: _ClassVar[int]
    ATTACH_NODE_FIELD_NUMBER: _ClassVar[int]
    PICK_PART_FIELD_NUMBER: _ClassVar[int]
    PLACE_PART_FIELD_NUMBER: _ClassVar[int]
    SET_JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    SELECT_TOOL_FIELD_NUMBER: _ClassVar[int]
    SET_TOOL_STATE_FIELD_NUMBER: _ClassVar[int]
    CREATE_SIGNAL_FIELD_NUMBER: _ClassVar[int]
    REMOVE_SIGNAL_FIELD_NUMBER: _ClassVar[int]
    SET_SIGNAL_FIELD_NUMBER: _ClassVar[int]
    SET_SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    SET_COLLISION_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    SET_ALLOWED_PAIRS_FIELD_NUMBER: _ClassVar[int]
    SET_KINEMATICS_FIELD_NUMBER: _ClassVar[int]
    START_SENSORS_FIELD_NUMBER: _ClassVar[int]
    STOP_SENSORS_FIELD_NUMBER: _ClassVar[int]
    SET_GROUPS_FIELD_NUMBER: _ClassVar[int]
    SET_POSTURES_FIELD_NUMBER: _ClassVar[int]
    MOUNT_TOOL_FIELD_NUMBER: _ClassVar[int]
    UNMOUNT_TOOL_FIELD_NUMBER: _ClassVar[int]
    SET_TCP_SPEED_LIMIT_FIELD_NUMBER: _ClassVar[int]
    SET_CRAFT_FIELD_NUMBER: _ClassVar[int]
    SET_PHYSICS_FIELD_NUMBER: _ClassVar[int]
    SET_JOINT_EFFORTS_FIELD_NUMBER: _ClassVar[int]
    create_node: CreateNode
    update_node: UpdateNode
    remove_node: RemoveNode
    attach_node: AttachNode
    pick_part: PickPart
    place_part: PlacePart
    set_joint_positions: SetJointPositions
    select_tool: SelectTool
    set_tool_state: SetToolState
    create_signal: CreateSignal
    remove_signal: RemoveSignal
    set_signal: SetSignal
    set_speed_factor: SetSpeedFactor
    set_collision_settings: _collision_pb2.SetCollisionSettings
    set_allowed_pairs: _collision_pb2.SetAllowedPairs
    set_kinematics: _robot_pb2.KinematicsChoice
    start_sensors: _sensor_pb2.StartSensors
    stop_sensors: _sensor_pb2.StopSensors
    set_groups: SetGroups
    set_postures: SetPostures
    mount_tool: MountTool
    unmount_tool: UnmountTool
    set_tcp_speed_limit: SetTcpSpeedLimit
    set_craft: SetCraft
    set_physics: _physics_pb2.SetPhysics
    set_joint_efforts: SetJointEfforts
    def __init__(self, create_node: _Optional[_Union[CreateNode, _Mapping]] = ..., update_node: _Optional[_Union[UpdateNode, _Mapping]] = ..., remove_node: _Optional[_Union[RemoveNode, _Mapping]] = ..., attach_node: _Optional[_Union[AttachNode, _Mapping]] = ..., pick_part: _Optional[_Union[PickPart, _Mapping]] = ..., place_part: _Optional[_Union[PlacePart, _Mapping]] = ..., set_joint_positions: _Optional[_Union[SetJointPositions, _Mapping]] = ..., select_tool: _Optional[_Union[SelectTool, _Mapping]] = ..., set_tool_state: _Optional[_Union[SetToolState, _Mapping]] = ..., create_signal: _Optional[_Union[CreateSignal, _Mapping]] = ..., remove_signal: _Optional[_Union[RemoveSignal, _Mapping]] = ..., set_signal: _Optional[_Union[SetSignal, _Mapping]] = ..., set_speed_factor: _Optional[_Union[SetSpeedFactor, _Mapping]] = ..., set_collision_settings: _Optional[_Union[_collision_pb2.SetCollisionSettings, _Mapping]] = ..., set_allowed_pairs: _Optional[_Union[_collision_pb2.SetAllowedPairs, _Mapping]] = ..., set_kinematics: _Optional[_Union[_robot_pb2.KinematicsChoice, _Mapping]] = ..., start_sensors: _Optional[_Union[_sensor_pb2.StartSensors, _Mapping]] = ..., stop_sensors: _Optional[_Union[_sensor_pb2.StopSensors, _Mapping]] = ..., set_groups: _Optional[_Union[SetGroups, _Mapping]] = ..., set_postures: _Optional[_Union[SetPostures, _Mapping]] = ..., mount_tool: _Optional[_Union[MountTool, _Mapping]] = ..., unmount_tool: _Optional[_Union[UnmountTool, _Mapping]] = ..., set_tcp_speed_limit: _Optional[_Union[SetTcpSpeedLimit, _Mapping]] = ..., set_craft: _Optional[_Union[SetCraft, _Mapping]] = ..., set_physics: _Optional[_Union[_physics_pb2.SetPhysics, _Mapping]] = ..., set_joint_efforts: _Optional[_Union[SetJointEfforts, _Mapping]] = ...) -> None: ...

class SetJointEfforts(_message.Message):
    __slots__ = ("robot", "efforts")
    class EffortsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    EFFORTS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    efforts: _containers.ScalarMap[str, float]
    def __init__(self, robot: _Optional[str] = ..., efforts: _Optional[_Mapping[str, float]] = ...) -> None: ...

class SetCraft(_message.Message):
    __slots__ = ("robot", "craft")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    CRAFT_FIELD_NUMBER: _ClassVar[int]
    robot: str
    craft: _nodes_pb2.Craft
    def __init__(self, robot: _Optional[str] = ..., craft: _Optional[_Union[_nodes_pb2.Craft, _Mapping]] = ...) -> None: ...

class CreateNode(_message.Message):
    __slots__ = ("node",)
    NODE_FIELD_NUMBER: _ClassVar[int]
    node: _nodes_pb2.Node
    def __init__(self, node: _Optional[_Union[_nodes_pb2.Node, _Mapping]] = ...) -> None: ...

class UpdateNode(_message.Message):
    __slots__ = ("name", "node", "update_mask")
    NAME_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    UPDATE_MASK_FIELD_NUMBER: _ClassVar[int]
    name: str
    node: _nodes_pb2.Node
    update_mask: _field_mask_pb2.FieldMask
    def __init__(self, name: _Optional[str] = ..., node: _Optional[_Union[_nodes_pb2.Node, _Mapping]] = ..., update_mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ...) -> None: ...

class RemoveNode(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class AttachNode(_message.Message):
    __slots__ = ("name", "parent", "parent_t_node")
    NAME_FIELD_NUMBER: _ClassVar[int]
    PARENT_FIELD_NUMBER: _ClassVar[int]
    PARENT_T_NODE_FIELD_NUMBER: _ClassVar[int]
    name: str
    parent: str
    parent_t_node: _geometry_pb2.Pose
    def __init__(self, name: _Optional[str] = ..., parent: _Optional[str] = ..., parent_t_node: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ...) -> None: ...

class PickPart(_message.Message):
    __slots__ = ("robot", "part", "max_distance_meters")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    PART_FIELD_NUMBER: _ClassVar[int]
    MAX_DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    part: str
    max_distance_meters: float
    def __init__(self, robot: _Optional[str] = ..., part: _Optional[str] = ..., max_distance_meters: _Optional[float] = ...) -> None: ...

class PlacePart(_message.Message):
    __slots__ = ("robot", "part", "parent")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    PART_FIELD_NUMBER: _ClassVar[int]
    PARENT_FIELD_NUMBER: _ClassVar[int]
    robot: str
    part: str
    parent: str
    def __init__(self, robot: _Optional[str] = ..., part: _Optional[str] = ..., parent: _Optional[str] = ...) -> None: ...

class SetJointPositions(_message.Message):
    __slots__ = ("robot", "joint_positions", "coordinates")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    COORDINATES_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_positions: _containers.ScalarMap[str, float]
    coordinates: _geometry_pb2.NumericArray
    def __init__(self, robot: _Optional[str] = ..., joint_positions: _Optional[_Mapping[str, float]] = ..., coordinates: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class SetGroups(_message.Message):
    __slots__ = ("robot", "groups")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    GROUPS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    groups: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.JointGroup]
    def __init__(self, robot: _Optional[str] = ..., groups: _Optional[_Iterable[_Union[_nodes_pb2.JointGroup, _Mapping]]] = ...) -> None: ...

class SetPostures(_message.Message):
    __slots__ = ("robot", "postures", "removed")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    POSTURES_FIELD_NUMBER: _ClassVar[int]
    REMOVED_FIELD_NUMBER: _ClassVar[int]
    robot: str
    postures: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NamedPosture]
    removed: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, robot: _Optional[str] = ..., postures: _Optional[_Iterable[_Union[_nodes_pb2.NamedPosture, _Mapping]]] = ..., removed: _Optional[_Iterable[str]] = ...) -> None: ...

class SelectTool(_message.Message):
    __slots__ = ("robot", "tool", "tool_center_point")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    TOOL_FIELD_NUMBER: _ClassVar[int]
    TOOL_CENTER_POINT_FIELD_NUMBER: _ClassVar[int]
    robot: str
    tool: str
    tool_center_point: str
    def __init__(self, robot: _Optional[str] = ..., tool: _Optional[str] = ..., tool_center_point: _Optional[str] = ...) -> None: ...

class MountTool(_message.Message):
    __slots__ = ("robot", "node", "parent", "parent_t_node", "tool_center_point")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    PARENT_FIELD_NUMBER: _ClassVar[int]
    PARENT_T_NODE_FIELD_NUMBER: _ClassVar[int]
    TOOL_CENTER_POINT_FIELD_NUMBER: _ClassVar[int]
    robot: str
    node: str
    parent: str
    parent_t_node: _geometry_pb2.Pose
    tool_center_point: str
    def __init__(self, robot: _Optional[str] = ..., node: _Optional[str] = ..., parent: _Optional[str] = ..., parent_t_node: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., tool_center_point: _Optional[str] = ...) -> None: ...

class UnmountTool(_message.Message):
    __slots__ = ("robot", "node", "parent", "parent_t_node")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    PARENT_FIELD_NUMBER: _ClassVar[int]
    PARENT_T_NODE_FIELD_NUMBER: _ClassVar[int]
    robot: str
    node: str
    parent: str
    parent_t_node: _geometry_pb2.Pose
    def __init__(self, robot: _Optional[str] = ..., node: _Optional[str] = ..., parent: _Optional[str] = ..., parent_t_node: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ...) -> None: ...

class SetToolState(_message.Message):
    __slots__ = ("tool", "state")
    TOOL_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    tool: str
    state: str
    def __init__(self, tool: _Optional[str] = ..., state: _Optional[str] = ...) -> None: ...

class CreateSignal(_message.Message):
    __slots__ = ("signal",)
    SIGNAL_FIELD_NUMBER: _ClassVar[int]
    signal: _signal_pb2.Signal
    def __init__(self, signal: _Optional[_Union[_signal_pb2.Signal, _Mapping]] = ...) -> None: ...

class RemoveSignal(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class SetSignal(_message.Message):
    __slots__ = ("name", "value")
    NAME_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    name: str
    value: _signal_pb2.SignalValue
    def __init__(self, name: _Optional[str] = ..., value: _Optional[_Union[_signal_pb2.SignalValue, _Mapping]] = ...) -> None: ...

class SetSpeedFactor(_message.Message):
    __slots__ = ("robot", "factor")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    FACTOR_FIELD_NUMBER: _ClassVar[int]
    robot: str
    factor: float
    def __init__(self, robot: _Optional[str] = ..., factor: _Optional[float] = ...) -> None: ...

class SetTcpSpeedLimit(_message.Message):
    __slots__ = ("robot", "meters_per_second")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    robot: str
    meters_per_second: float
    def __init__(self, robot: _Optional[str] = ..., meters_per_second: _Optional[float] = ...) -> None: ...

class ModelSource(_message.Message):
    __slots__ = ("uri", "files", "name", "parent", "parent_t_node", "base_joint", "as_part", "scale", "settings", "srdf_uri", "denavit_hartenberg", "strict", "mount_on", "tool_center_point")
    URI_FIELD_NUMBER: _ClassVar[int]
    FILES_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    PARENT_FIELD_NUMBER: _ClassVar[int]
    PARENT_T_NODE_FIELD_NUMBER: _ClassVar[int]
    BASE_JOINT_FIELD_NUMBER: _ClassVar[int]
    AS_PART_FIELD_NUMBER: _ClassVar[int]
    SCALE_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    SRDF_URI_FIELD_NUMBER: _ClassVar[int]
    DENAVIT_HARTENBERG_FIELD_NUMBER: _ClassVar[int]
    STRICT_FIELD_NUMBER: _ClassVar[int]
    MOUNT_ON_FIELD_NUMBER: _ClassVar[int]
    TOOL_CENTER_POINT_FIELD_NUMBER: _ClassVar[int]
    uri: str
    files: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.AssetFile]
    name: str
    parent: str
    parent_t_node: _geometry_pb2.Pose
    base_joint: _nodes_pb2.JointType
    as_part: bool
    scale: _geometry_pb2.Vector3
    settings: _struct_pb2.Struct
    srdf_uri: str
    denavit_hartenberg: DenavitHartenberg
    strict: bool
    mount_on: str
    tool_center_point: str
    def __init__(self, uri: _Optional[str] = ..., files: _Optional[_Iterable[_Union[_nodes_pb2.AssetFile, _Mapping]]] = ..., name: _Optional[str] = ..., parent: _Optional[str] = ..., parent_t_node: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., base_joint: _Optional[_Union[_nodes_pb2.JointType, str]] = ..., as_part: bool = ..., scale: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., srdf_uri: _Optional[str] = ..., denavit_hartenberg: _Optional[_Union[DenavitHartenberg, _Mapping]] = ..., strict: bool = ..., mount_on: _Optional[str] = ..., tool_center_point: _Optional[str] = ...) -> None: ...

class ImportModelRequest(_message.Message):
    __slots__ = ("model", "request_id")
    MODEL_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    model: ModelSource
    request_id: str
    def __init__(self, model: _Optional[_Union[ModelSource, _Mapping]] = ..., request_id: _Optional[str] = ...) -> None: ...

class DenavitHartenberg(_message.Message):
    __slots__ = ("convention", "rows", "base_t_first", "last_t_flange")
    CONVENTION_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    BASE_T_FIRST_FIELD_NUMBER: _ClassVar[int]
    LAST_T_FLANGE_FIELD_NUMBER: _ClassVar[int]
    convention: DenavitHartenbergConvention
    rows: _containers.RepeatedCompositeFieldContainer[DenavitHartenbergRow]
    base_t_first: _geometry_pb2.Pose
    last_t_flange: _geometry_pb2.Pose
    def __init__(self, convention: _Optional[_Union[DenavitHartenbergConvention, str]] = ..., rows: _Optional[_Iterable[_Union[DenavitHartenbergRow, _Mapping]]] = ..., base_t_first: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., last_t_flange: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ...) -> None: ...

class DenavitHartenbergRow(_message.Message):
    __slots__ = ("name", "type", "a_meters", "alpha_radians", "d_meters", "theta_radians", "limits", "inertial")
    NAME_FIELD_NUMBER: _ClassVar[int]
    TYPE_FIELD_NUMBER: _ClassVar[int]
    A_METERS_FIELD_NUMBER: _ClassVar[int]
    ALPHA_RADIANS_FIELD_NUMBER: _ClassVar[int]
    D_METERS_FIELD_NUMBER: _ClassVar[int]
    THETA_RADIANS_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    INERTIAL_FIELD_NUMBER: _ClassVar[int]
    name: str
    type: _nodes_pb2.JointType
    a_meters: float
    alpha_radians: float
    d_meters: float
    theta_radians: float
    limits: _nodes_pb2.JointLimits
    inertial: _nodes_pb2.Inertial
    def __init__(self, name: _Optional[str] = ..., type: _Optional[_Union[_nodes_pb2.JointType, str]] = ..., a_meters: _Optional[float] = ..., alpha_radians: _Optional[float] = ..., d_meters: _Optional[float] = ..., theta_radians: _Optional[float] = ..., limits: _Optional[_Union[_nodes_pb2.JointLimits, _Mapping]] = ..., inertial: _Optional[_Union[_nodes_pb2.Inertial, _Mapping]] = ...) -> None: ...

class ImportModelResponse(_message.Message):
    __slots__ = ("stamp", "created", "mesh_count", "warnings", "allowed_pairs")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CREATED_FIELD_NUMBER: _ClassVar[int]
    MESH_COUNT_FIELD_NUMBER: _ClassVar[int]
    WARNINGS_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_PAIRS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    created: _containers.RepeatedCompositeFieldContainer[CreatedNode]
    mesh_count: int
    warnings: _containers.RepeatedCompositeFieldContainer[FileWarning]
    allowed_pairs: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., created: _Optional[_Iterable[_Union[CreatedNode, _Mapping]]] = ..., mesh_count: _Optional[int] = ..., warnings: _Optional[_Iterable[_Union[FileWarning, _Mapping]]] = ..., allowed_pairs: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ...) -> None: ...

class FileWarning(_message.Message):
    __slots__ = ("file", "line", "text")
    FILE_FIELD_NUMBER: _ClassVar[int]
    LINE_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    file: str
    line: int
    text: str
    def __init__(self, file: _Optional[str] = ..., line: _Optional[int] = ..., text: _Optional[str] = ...) -> None: ...

class ExportModelRequest(_message.Message):
    __slots__ = ("node", "format", "tolerance_meters")
    NODE_FIELD_NUMBER: _ClassVar[int]
    FORMAT_FIELD_NUMBER: _ClassVar[int]
    TOLERANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    node: str
    format: str
    tolerance_meters: float
    def __init__(self, node: _Optional[str] = ..., format: _Optional[str] = ..., tolerance_meters: _Optional[float] = ...) -> None: ...

class ExportModelResponse(_message.Message):
    __slots__ = ("stamp", "files", "warnings")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    FILES_FIELD_NUMBER: _ClassVar[int]
    WARNINGS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    files: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.AssetFile]
    warnings: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., files: _Optional[_Iterable[_Union[_nodes_pb2.AssetFile, _Mapping]]] = ..., warnings: _Optional[_Iterable[str]] = ...) -> None: ...

class ListModelsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListModelsResponse(_message.Message):
    __slots__ = ("models",)
    MODELS_FIELD_NUMBER: _ClassVar[int]
    models: _containers.RepeatedCompositeFieldContainer[KnownModel]
    def __init__(self, models: _Optional[_Iterable[_Union[KnownModel, _Mapping]]] = ...) -> None: ...

class KnownModel(_message.Message):
    __slots__ = ("name", "description", "uri", "package", "installed", "maker", "kind", "axes", "payload_kilograms", "reach_meters", "license", "source")
    NAME_FIELD_NUMBER: _ClassVar[int]
    DESCRIPTION_FIELD_NUMBER: _ClassVar[int]
    URI_FIELD_NUMBER: _ClassVar[int]
    PACKAGE_FIELD_NUMBER: _ClassVar[int]
    INSTALLED_FIELD_NUMBER: _ClassVar[int]
    MAKER_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    AXES_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_KILOGRAMS_FIELD_NUMBER: _ClassVar[int]
    REACH_METERS_FIELD_NUMBER: _ClassVar[int]
    LICENSE_FIELD_NUMBER: _ClassVar[int]
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    name: str
    description: str
    uri: str
    package: str
    installed: bool
    maker: str
    kind: str
    axes: int
    payload_kilograms: float
    reach_meters: float
    license: str
    source: str
    def __init__(self, name: _Optional[str] = ..., description: _Optional[str] = ..., uri: _Optional[str] = ..., package: _Optional[str] = ..., installed: bool = ..., maker: _Optional[str] = ..., kind: _Optional[str] = ..., axes: _Optional[int] = ..., payload_kilograms: _Optional[float] = ..., reach_meters: _Optional[float] = ..., license: _Optional[str] = ..., source: _Optional[str] = ...) -> None: ...

class LoadSceneRequest(_message.Message):
    __slots__ = ("text", "uri", "files", "add", "strict", "request_id")
    TEXT_FIELD_NUMBER: _ClassVar[int]
    URI_FIELD_NUMBER: _ClassVar[int]
    FILES_FIELD_NUMBER: _ClassVar[int]
    ADD_FIELD_NUMBER: _ClassVar[int]
    STRICT_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    text: str
    uri: str
    files: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.AssetFile]
    add: bool
    strict: bool
    request_id: str
    def __init__(self, text: _Optional[str] = ..., uri: _Optional[str] = ..., files: _Optional[_Iterable[_Union[_nodes_pb2.AssetFile, _Mapping]]] = ..., add: bool = ..., strict: bool = ..., request_id: _Optional[str] = ...) -> None: ...

class LoadSceneResponse(_message.Message):
    __slots__ = ("stamp", "created", "warnings", "allowed_pairs")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CREATED_FIELD_NUMBER: _ClassVar[int]
    WARNINGS_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_PAIRS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    created: _containers.RepeatedCompositeFieldContainer[CreatedNode]
    warnings: _containers.RepeatedCompositeFieldContainer[FileWarning]
    allowed_pairs: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., created: _Optional[_Iterable[_Union[CreatedNode, _Mapping]]] = ..., warnings: _Optional[_Iterable[_Union[FileWarning, _Mapping]]] = ..., allowed_pairs: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ...) -> None: ...

class SaveSceneRequest(_message.Message):
    __slots__ = ("bundle",)
    BUNDLE_FIELD_NUMBER: _ClassVar[int]
    bundle: bool
    def __init__(self, bundle: bool = ...) -> None: ...

class SaveSceneResponse(_message.Message):
    __slots__ = ("stamp", "text", "files")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    FILES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    text: str
    files: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.AssetFile]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., text: _Optional[str] = ..., files: _Optional[_Iterable[_Union[_nodes_pb2.AssetFile, _Mapping]]] = ...) -> None: ...

class SceneFile(_message.Message):
    __slots__ = ("schema_version", "nodes", "signals", "robot_states", "speed_factor", "models", "allowed_pairs", "collision_settings", "physics")
    SCHEMA_VERSION_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    SIGNALS_FIELD_NUMBER: _ClassVar[int]
    ROBOT_STATES_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    MODELS_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_PAIRS_FIELD_NUMBER: _ClassVar[int]
    COLLISION_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    PHYSICS_FIELD_NUMBER: _ClassVar[int]
    schema_version: int
    nodes: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.Node]
    signals: _containers.RepeatedCompositeFieldContainer[_signal_pb2.Signal]
    robot_states: _containers.RepeatedCompositeFieldContainer[_robot_pb2.RobotState]
    speed_factor: float
    models: _containers.RepeatedCompositeFieldContainer[ModelSource]
    allowed_pairs: _containers.RepeatedCompositeFieldContainer[_nodes_pb2.NodePair]
    collision_settings: _collision_pb2.CollisionSettings
    physics: _physics_pb2.PhysicsSettings
    def __init__(self, schema_version: _Optional[int] = ..., nodes: _Optional[_Iterable[_Union[_nodes_pb2.Node, _Mapping]]] = ..., signals: _Optional[_Iterable[_Union[_signal_pb2.Signal, _Mapping]]] = ..., robot_states: _Optional[_Iterable[_Union[_robot_pb2.RobotState, _Mapping]]] = ..., speed_factor: _Optional[float] = ..., models: _Optional[_Iterable[_Union[ModelSource, _Mapping]]] = ..., allowed_pairs: _Optional[_Iterable[_Union[_nodes_pb2.NodePair, _Mapping]]] = ..., collision_settings: _Optional[_Union[_collision_pb2.CollisionSettings, _Mapping]] = ..., physics: _Optional[_Union[_physics_pb2.PhysicsSettings, _Mapping]] = ...) -> None: ...
