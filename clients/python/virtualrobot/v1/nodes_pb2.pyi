from google.protobuf import struct_pb2 as _struct_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import sensing_pb2 as _sensing_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class MotorMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    MOTOR_MODE_UNSPECIFIED: _ClassVar[MotorMode]
    MOTOR_MODE_FREE: _ClassVar[MotorMode]
    MOTOR_MODE_VELOCITY: _ClassVar[MotorMode]
    MOTOR_MODE_POSITION: _ClassVar[MotorMode]
    MOTOR_MODE_EFFORT: _ClassVar[MotorMode]

class JointType(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    JOINT_TYPE_UNSPECIFIED: _ClassVar[JointType]
    JOINT_TYPE_FIXED: _ClassVar[JointType]
    JOINT_TYPE_REVOLUTE: _ClassVar[JointType]
    JOINT_TYPE_CONTINUOUS: _ClassVar[JointType]
    JOINT_TYPE_PRISMATIC: _ClassVar[JointType]
    JOINT_TYPE_FLOATING: _ClassVar[JointType]
    JOINT_TYPE_PLANAR: _ClassVar[JointType]

class FigureRole(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    FIGURE_ROLE_UNSPECIFIED: _ClassVar[FigureRole]
    FIGURE_ROLE_VISUAL: _ClassVar[FigureRole]
    FIGURE_ROLE_COLLISION: _ClassVar[FigureRole]
MOTOR_MODE_UNSPECIFIED: MotorMode
MOTOR_MODE_FREE: MotorMode
MOTOR_MODE_VELOCITY: MotorMode
MOTOR_MODE_POSITION: MotorMode
MOTOR_MODE_EFFORT: MotorMode
JOINT_TYPE_UNSPECIFIED: JointType
JOINT_TYPE_FIXED: JointType
JOINT_TYPE_REVOLUTE: JointType
JOINT_TYPE_CONTINUOUS: JointType
JOINT_TYPE_PRISMATIC: JointType
JOINT_TYPE_FLOATING: JointType
JOINT_TYPE_PLANAR: JointType
FIGURE_ROLE_UNSPECIFIED: FigureRole
FIGURE_ROLE_VISUAL: FigureRole
FIGURE_ROLE_COLLISION: FigureRole

class Node(_message.Message):
    __slots__ = ("uid", "name", "parent", "parent_t_node", "hidden", "figures", "world", "object", "part", "robot", "link", "adapter", "tool", "annotation", "range_sensor", "camera_sensor", "contact_sensor", "motion_sensor", "light", "target", "viewpoint", "description", "tags", "icon", "locked")
    UID_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    PARENT_FIELD_NUMBER: _ClassVar[int]
    PARENT_T_NODE_FIELD_NUMBER: _ClassVar[int]
    HIDDEN_FIELD_NUMBER: _ClassVar[int]
    FIGURES_FIELD_NUMBER: _ClassVar[int]
    WORLD_FIELD_NUMBER: _ClassVar[int]
    OBJECT_FIELD_NUMBER: _ClassVar[int]
    PART_FIELD_NUMBER: _ClassVar[int]
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    LINK_FIELD_NUMBER: _ClassVar[int]
    ADAPTER_FIELD_NUMBER: _ClassVar[int]
    TOOL_FIELD_NUMBER: _ClassVar[int]
    ANNOTATION_FIELD_NUMBER: _ClassVar[int]
    RANGE_SENSOR_FIELD_NUMBER: _ClassVar[int]
    CAMERA_SENSOR_FIELD_NUMBER: _ClassVar[int]
    CONTACT_SENSOR_FIELD_NUMBER: _ClassVar[int]
    MOTION_SENSOR_FIELD_NUMBER: _ClassVar[int]
    LIGHT_FIELD_NUMBER: _ClassVar[int]
    TARGET_FIELD_NUMBER: _ClassVar[int]
    VIEWPOINT_FIELD_NUMBER: _ClassVar[int]
    DESCRIPTION_FIELD_NUMBER: _ClassVar[int]
    TAGS_FIELD_NUMBER: _ClassVar[int]
    ICON_FIELD_NUMBER: _ClassVar[int]
    LOCKED_FIELD_NUMBER: _ClassVar[int]
    uid: int
    name: str
    parent: str
    parent_t_node: _geometry_pb2.Pose
    hidden: bool
    figures: _containers.RepeatedCompositeFieldContainer[Figure]
    world: World
    object: SceneObject
    part: Part
    robot: Robot
    link: Link
    adapter: Adapter
    tool: Tool
    annotation: Annotation
    range_sensor: _sensing_pb2.RangeSensor
    camera_sensor: _sensing_pb2.CameraSensor
    contact_sensor: _sensing_pb2.ContactSensor
    motion_sensor: _sensing_pb2.MotionSensor
    light: _sensing_pb2.Light
    target: Target
    viewpoint: Viewpoint
    description: str
    tags: _containers.RepeatedScalarFieldContainer[str]
    icon: str
    locked: bool
    def __init__(self, uid: _Optional[int] = ..., name: _Optional[str] = ..., parent: _Optional[str] = ..., parent_t_node: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., hidden: bool = ..., figures: _Optional[_Iterable[_Union[Figure, _Mapping]]] = ..., world: _Optional[_Union[World, _Mapping]] = ..., object: _Optional[_Union[SceneObject, _Mapping]] = ..., part: _Optional[_Union[Part, _Mapping]] = ..., robot: _Optional[_Union[Robot, _Mapping]] = ..., link: _Optional[_Union[Link, _Mapping]] = ..., adapter: _Optional[_Union[Adapter, _Mapping]] = ..., tool: _Optional[_Union[Tool, _Mapping]] = ..., annotation: _Optional[_Union[Annotation, _Mapping]] = ..., range_sensor: _Optional[_Union[_sensing_pb2.RangeSensor, _Mapping]] = ..., camera_sensor: _Optional[_Union[_sensing_pb2.CameraSensor, _Mapping]] = ..., contact_sensor: _Optional[_Union[_sensing_pb2.ContactSensor, _Mapping]] = ..., motion_sensor: _Optional[_Union[_sensing_pb2.MotionSensor, _Mapping]] = ..., light: _Optional[_Union[_sensing_pb2.Light, _Mapping]] = ..., target: _Optional[_Union[Target, _Mapping]] = ..., viewpoint: _Optional[_Union[Viewpoint, _Mapping]] = ..., description: _Optional[str] = ..., tags: _Optional[_Iterable[str]] = ..., icon: _Optional[str] = ..., locked: bool = ...) -> None: ...

class World(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class SceneObject(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class Target(_message.Message):
    __slots__ = ("robot", "tool", "tool_center_point", "joint_positions")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    TOOL_FIELD_NUMBER: _ClassVar[int]
    TOOL_CENTER_POINT_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    tool: str
    tool_center_point: str
    joint_positions: _containers.ScalarMap[str, float]
    def __init__(self, robot: _Optional[str] = ..., tool: _Optional[str] = ..., tool_center_point: _Optional[str] = ..., joint_positions: _Optional[_Mapping[str, float]] = ...) -> None: ...

class Viewpoint(_message.Message):
    __slots__ = ("distance_meters", "field_of_view_radians")
    DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    FIELD_OF_VIEW_RADIANS_FIELD_NUMBER: _ClassVar[int]
    distance_meters: float
    field_of_view_radians: float
    def __init__(self, distance_meters: _Optional[float] = ..., field_of_view_radians: _Optional[float] = ...) -> None: ...

class Part(_message.Message):
    __slots__ = ("mass_kilograms", "inertial", "dynamic")
    MASS_KILOGRAMS_FIELD_NUMBER: _ClassVar[int]
    INERTIAL_FIELD_NUMBER: _ClassVar[int]
    DYNAMIC_FIELD_NUMBER: _ClassVar[int]
    mass_kilograms: float
    inertial: Inertial
    dynamic: bool
    def __init__(self, mass_kilograms: _Optional[float] = ..., inertial: _Optional[_Union[Inertial, _Mapping]] = ..., dynamic: bool = ...) -> None: ...

class Robot(_message.Message):
    __slots__ = ("joint_names", "flange", "kinematics", "postures", "source", "kinematics_settings", "groups", "allowed_collisions", "actuators", "craft", "dynamic", "motors", "payload_kilograms")
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    FLANGE_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_FIELD_NUMBER: _ClassVar[int]
    POSTURES_FIELD_NUMBER: _ClassVar[int]
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    GROUPS_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_COLLISIONS_FIELD_NUMBER: _ClassVar[int]
    ACTUATORS_FIELD_NUMBER: _ClassVar[int]
    CRAFT_FIELD_NUMBER: _ClassVar[int]
    DYNAMIC_FIELD_NUMBER: _ClassVar[int]
    MOTORS_FIELD_NUMBER: _ClassVar[int]
    PAYLOAD_KILOGRAMS_FIELD_NUMBER: _ClassVar[int]
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    flange: str
    kinematics: str
    postures: _containers.RepeatedCompositeFieldContainer[NamedPosture]
    source: str
    kinematics_settings: _struct_pb2.Struct
    groups: _containers.RepeatedCompositeFieldContainer[JointGroup]
    allowed_collisions: _containers.RepeatedCompositeFieldContainer[LinkPair]
    actuators: _containers.RepeatedCompositeFieldContainer[Actuator]
    craft: Craft
    dynamic: bool
    motors: _containers.RepeatedCompositeFieldContainer[JointMotor]
    payload_kilograms: float
    def __init__(self, joint_names: _Optional[_Iterable[str]] = ..., flange: _Optional[str] = ..., kinematics: _Optional[str] = ..., postures: _Optional[_Iterable[_Union[NamedPosture, _Mapping]]] = ..., source: _Optional[str] = ..., kinematics_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., groups: _Optional[_Iterable[_Union[JointGroup, _Mapping]]] = ..., allowed_collisions: _Optional[_Iterable[_Union[LinkPair, _Mapping]]] = ..., actuators: _Optional[_Iterable[_Union[Actuator, _Mapping]]] = ..., craft: _Optional[_Union[Craft, _Mapping]] = ..., dynamic: bool = ..., motors: _Optional[_Iterable[_Union[JointMotor, _Mapping]]] = ..., payload_kilograms: _Optional[float] = ...) -> None: ...

class JointMotor(_message.Message):
    __slots__ = ("joint", "mode", "stiffness", "damping", "max_effort")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    STIFFNESS_FIELD_NUMBER: _ClassVar[int]
    DAMPING_FIELD_NUMBER: _ClassVar[int]
    MAX_EFFORT_FIELD_NUMBER: _ClassVar[int]
    joint: str
    mode: MotorMode
    stiffness: float
    damping: float
    max_effort: float
    def __init__(self, joint: _Optional[str] = ..., mode: _Optional[_Union[MotorMode, str]] = ..., stiffness: _Optional[float] = ..., damping: _Optional[float] = ..., max_effort: _Optional[float] = ...) -> None: ...

class Craft(_message.Message):
    __slots__ = ("kinematics", "settings", "drives", "base_joint", "center_x_meters", "center_y_meters", "heading_radians", "water")
    KINEMATICS_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    DRIVES_FIELD_NUMBER: _ClassVar[int]
    BASE_JOINT_FIELD_NUMBER: _ClassVar[int]
    CENTER_X_METERS_FIELD_NUMBER: _ClassVar[int]
    CENTER_Y_METERS_FIELD_NUMBER: _ClassVar[int]
    HEADING_RADIANS_FIELD_NUMBER: _ClassVar[int]
    WATER_FIELD_NUMBER: _ClassVar[int]
    kinematics: str
    settings: _struct_pb2.Struct
    drives: _containers.RepeatedCompositeFieldContainer[CraftDrive]
    base_joint: str
    center_x_meters: float
    center_y_meters: float
    heading_radians: float
    water: Water
    def __init__(self, kinematics: _Optional[str] = ..., settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., drives: _Optional[_Iterable[_Union[CraftDrive, _Mapping]]] = ..., base_joint: _Optional[str] = ..., center_x_meters: _Optional[float] = ..., center_y_meters: _Optional[float] = ..., heading_radians: _Optional[float] = ..., water: _Optional[_Union[Water, _Mapping]] = ...) -> None: ...

class Water(_message.Message):
    __slots__ = ("current", "density", "surface_height_meters")
    CURRENT_FIELD_NUMBER: _ClassVar[int]
    DENSITY_FIELD_NUMBER: _ClassVar[int]
    SURFACE_HEIGHT_METERS_FIELD_NUMBER: _ClassVar[int]
    current: _geometry_pb2.Vector3
    density: float
    surface_height_meters: float
    def __init__(self, current: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., density: _Optional[float] = ..., surface_height_meters: _Optional[float] = ...) -> None: ...

class CraftDrive(_message.Message):
    __slots__ = ("drive", "joint", "ratio")
    DRIVE_FIELD_NUMBER: _ClassVar[int]
    JOINT_FIELD_NUMBER: _ClassVar[int]
    RATIO_FIELD_NUMBER: _ClassVar[int]
    drive: str
    joint: str
    ratio: float
    def __init__(self, drive: _Optional[str] = ..., joint: _Optional[str] = ..., ratio: _Optional[float] = ...) -> None: ...

class Actuator(_message.Message):
    __slots__ = ("name", "terms", "offset", "lower", "upper")
    NAME_FIELD_NUMBER: _ClassVar[int]
    TERMS_FIELD_NUMBER: _ClassVar[int]
    OFFSET_FIELD_NUMBER: _ClassVar[int]
    LOWER_FIELD_NUMBER: _ClassVar[int]
    UPPER_FIELD_NUMBER: _ClassVar[int]
    name: str
    terms: _containers.RepeatedCompositeFieldContainer[ActuatorTerm]
    offset: float
    lower: float
    upper: float
    def __init__(self, name: _Optional[str] = ..., terms: _Optional[_Iterable[_Union[ActuatorTerm, _Mapping]]] = ..., offset: _Optional[float] = ..., lower: _Optional[float] = ..., upper: _Optional[float] = ...) -> None: ...

class ActuatorTerm(_message.Message):
    __slots__ = ("joint", "ratio")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    RATIO_FIELD_NUMBER: _ClassVar[int]
    joint: str
    ratio: float
    def __init__(self, joint: _Optional[str] = ..., ratio: _Optional[float] = ...) -> None: ...

class JointGroup(_message.Message):
    __slots__ = ("name", "joint_names", "base_link", "tip_link", "kinematics", "kinematics_settings")
    NAME_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    BASE_LINK_FIELD_NUMBER: _ClassVar[int]
    TIP_LINK_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    name: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    base_link: str
    tip_link: str
    kinematics: str
    kinematics_settings: _struct_pb2.Struct
    def __init__(self, name: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., base_link: _Optional[str] = ..., tip_link: _Optional[str] = ..., kinematics: _Optional[str] = ..., kinematics_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ...) -> None: ...

class GroupSelection(_message.Message):
    __slots__ = ("name", "base_link", "tip_link")
    NAME_FIELD_NUMBER: _ClassVar[int]
    BASE_LINK_FIELD_NUMBER: _ClassVar[int]
    TIP_LINK_FIELD_NUMBER: _ClassVar[int]
    name: str
    base_link: str
    tip_link: str
    def __init__(self, name: _Optional[str] = ..., base_link: _Optional[str] = ..., tip_link: _Optional[str] = ...) -> None: ...

class NodePair(_message.Message):
    __slots__ = ("first", "second", "reason", "built")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    BUILT_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    reason: str
    built: bool
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., reason: _Optional[str] = ..., built: bool = ...) -> None: ...

class LinkPair(_message.Message):
    __slots__ = ("first", "second", "reason")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    reason: str
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., reason: _Optional[str] = ...) -> None: ...

class NamedPosture(_message.Message):
    __slots__ = ("name", "joint_positions")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    NAME_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    name: str
    joint_positions: _containers.ScalarMap[str, float]
    def __init__(self, name: _Optional[str] = ..., joint_positions: _Optional[_Mapping[str, float]] = ...) -> None: ...

class Link(_message.Message):
    __slots__ = ("joint", "inertial")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    INERTIAL_FIELD_NUMBER: _ClassVar[int]
    joint: Joint
    inertial: Inertial
    def __init__(self, joint: _Optional[_Union[Joint, _Mapping]] = ..., inertial: _Optional[_Union[Inertial, _Mapping]] = ...) -> None: ...

class Inertial(_message.Message):
    __slots__ = ("mass_kilograms", "link_t_inertial", "diagonal", "products")
    MASS_KILOGRAMS_FIELD_NUMBER: _ClassVar[int]
    LINK_T_INERTIAL_FIELD_NUMBER: _ClassVar[int]
    DIAGONAL_FIELD_NUMBER: _ClassVar[int]
    PRODUCTS_FIELD_NUMBER: _ClassVar[int]
    mass_kilograms: float
    link_t_inertial: _geometry_pb2.Pose
    diagonal: _geometry_pb2.Vector3
    products: _geometry_pb2.Vector3
    def __init__(self, mass_kilograms: _Optional[float] = ..., link_t_inertial: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., diagonal: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., products: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class Joint(_message.Message):
    __slots__ = ("name", "type", "axis", "limits", "mimic")
    NAME_FIELD_NUMBER: _ClassVar[int]
    TYPE_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    MIMIC_FIELD_NUMBER: _ClassVar[int]
    name: str
    type: JointType
    axis: _geometry_pb2.Vector3
    limits: JointLimits
    mimic: Mimic
    def __init__(self, name: _Optional[str] = ..., type: _Optional[_Union[JointType, str]] = ..., axis: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., limits: _Optional[_Union[JointLimits, _Mapping]] = ..., mimic: _Optional[_Union[Mimic, _Mapping]] = ...) -> None: ...

class JointLimits(_message.Message):
    __slots__ = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")
    LOWER_FIELD_NUMBER: _ClassVar[int]
    UPPER_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_FIELD_NUMBER: _ClassVar[int]
    ACCELERATION_FIELD_NUMBER: _ClassVar[int]
    JERK_FIELD_NUMBER: _ClassVar[int]
    EFFORT_FIELD_NUMBER: _ClassVar[int]
    lower: float
    upper: float
    velocity: float
    acceleration: float
    jerk: float
    effort: float
    def __init__(self, lower: _Optional[float] = ..., upper: _Optional[float] = ..., velocity: _Optional[float] = ..., acceleration: _Optional[float] = ..., jerk: _Optional[float] = ..., effort: _Optional[float] = ...) -> None: ...

class Mimic(_message.Message):
    __slots__ = ("joint", "multiplier", "offset")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    MULTIPLIER_FIELD_NUMBER: _ClassVar[int]
    OFFSET_FIELD_NUMBER: _ClassVar[int]
    joint: str
    multiplier: float
    offset: float
    def __init__(self, joint: _Optional[str] = ..., multiplier: _Optional[float] = ..., offset: _Optional[float] = ...) -> None: ...

class Adapter(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class Tool(_message.Message):
    __slots__ = ("tool_center_points", "states", "inertial", "widths")
    TOOL_CENTER_POINTS_FIELD_NUMBER: _ClassVar[int]
    STATES_FIELD_NUMBER: _ClassVar[int]
    INERTIAL_FIELD_NUMBER: _ClassVar[int]
    WIDTHS_FIELD_NUMBER: _ClassVar[int]
    tool_center_points: _containers.RepeatedCompositeFieldContainer[ToolCenterPoint]
    states: _containers.RepeatedCompositeFieldContainer[ToolState]
    inertial: Inertial
    widths: _containers.RepeatedCompositeFieldContainer[ToolWidth]
    def __init__(self, tool_center_points: _Optional[_Iterable[_Union[ToolCenterPoint, _Mapping]]] = ..., states: _Optional[_Iterable[_Union[ToolState, _Mapping]]] = ..., inertial: _Optional[_Union[Inertial, _Mapping]] = ..., widths: _Optional[_Iterable[_Union[ToolWidth, _Mapping]]] = ...) -> None: ...

class ToolWidth(_message.Message):
    __slots__ = ("width_meters", "joint_positions")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    WIDTH_METERS_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    width_meters: float
    joint_positions: _containers.ScalarMap[str, float]
    def __init__(self, width_meters: _Optional[float] = ..., joint_positions: _Optional[_Mapping[str, float]] = ...) -> None: ...

class ToolCenterPoint(_message.Message):
    __slots__ = ("name", "tool_t_tcp")
    NAME_FIELD_NUMBER: _ClassVar[int]
    TOOL_T_TCP_FIELD_NUMBER: _ClassVar[int]
    name: str
    tool_t_tcp: _geometry_pb2.Pose
    def __init__(self, name: _Optional[str] = ..., tool_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ...) -> None: ...

class ToolState(_message.Message):
    __slots__ = ("name", "joint_positions")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    NAME_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    name: str
    joint_positions: _containers.ScalarMap[str, float]
    def __init__(self, name: _Optional[str] = ..., joint_positions: _Optional[_Mapping[str, float]] = ...) -> None: ...

class Annotation(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class Figure(_message.Message):
    __slots__ = ("node_t_figure", "material", "roles", "tool_state", "box", "sphere", "cylinder", "cone", "capsule", "mesh", "points", "lines", "frame", "label")
    NODE_T_FIGURE_FIELD_NUMBER: _ClassVar[int]
    MATERIAL_FIELD_NUMBER: _ClassVar[int]
    ROLES_FIELD_NUMBER: _ClassVar[int]
    TOOL_STATE_FIELD_NUMBER: _ClassVar[int]
    BOX_FIELD_NUMBER: _ClassVar[int]
    SPHERE_FIELD_NUMBER: _ClassVar[int]
    CYLINDER_FIELD_NUMBER: _ClassVar[int]
    CONE_FIELD_NUMBER: _ClassVar[int]
    CAPSULE_FIELD_NUMBER: _ClassVar[int]
    MESH_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    LINES_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    LABEL_FIELD_NUMBER: _ClassVar[int]
    node_t_figure: _geometry_pb2.Pose
    material: Material
    roles: _containers.RepeatedScalarFieldContainer[FigureRole]
    tool_state: str
    box: Box
    sphere: Sphere
    cylinder: Cylinder
    cone: Cone
    capsule: Capsule
    mesh: Mesh
    points: Points
    lines: Lines
    frame: Frame
    label: Label
    def __init__(self, node_t_figure: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., material: _Optional[_Union[Material, _Mapping]] = ..., roles: _Optional[_Iterable[_Union[FigureRole, str]]] = ..., tool_state: _Optional[str] = ..., box: _Optional[_Union[Box, _Mapping]] = ..., sphere: _Optional[_Union[Sphere, _Mapping]] = ..., cylinder: _Optional[_Union[Cylinder, _Mapping]] = ..., cone: _Optional[_Union[Cone, _Mapping]] = ..., capsule: _Optional[_Union[Capsule, _Mapping]] = ..., mesh: _Optional[_Union[Mesh, _Mapping]] = ..., points: _Optional[_Union[Points, _Mapping]] = ..., lines: _Optional[_Union[Lines, _Mapping]] = ..., frame: _Optional[_Union[Frame, _Mapping]] = ..., label: _Optional[_Union[Label, _Mapping]] = ...) -> None: ...

class Material(_message.Message):
    __slots__ = ("color", "reflectance", "friction", "restitution", "rolling_friction_meters", "spinning_friction_meters", "stiffness", "damping", "roughness", "metalness")
    COLOR_FIELD_NUMBER: _ClassVar[int]
    REFLECTANCE_FIELD_NUMBER: _ClassVar[int]
    FRICTION_FIELD_NUMBER: _ClassVar[int]
    RESTITUTION_FIELD_NUMBER: _ClassVar[int]
    ROLLING_FRICTION_METERS_FIELD_NUMBER: _ClassVar[int]
    SPINNING_FRICTION_METERS_FIELD_NUMBER: _ClassVar[int]
    STIFFNESS_FIELD_NUMBER: _ClassVar[int]
    DAMPING_FIELD_NUMBER: _ClassVar[int]
    ROUGHNESS_FIELD_NUMBER: _ClassVar[int]
    METALNESS_FIELD_NUMBER: _ClassVar[int]
    color: _geometry_pb2.Color
    reflectance: float
    friction: float
    restitution: float
    rolling_friction_meters: float
    spinning_friction_meters: float
    stiffness: float
    damping: float
    roughness: float
    metalness: float
    def __init__(self, color: _Optional[_Union[_geometry_pb2.Color, _Mapping]] = ..., reflectance: _Optional[float] = ..., friction: _Optional[float] = ..., restitution: _Optional[float] = ..., rolling_friction_meters: _Optional[float] = ..., spinning_friction_meters: _Optional[float] = ..., stiffness: _Optional[float] = ..., damping: _Optional[float] = ..., roughness: _Optional[float] = ..., metalness: _Optional[float] = ...) -> None: ...

class Box(_message.Message):
    __slots__ = ("size",)
    SIZE_FIELD_NUMBER: _ClassVar[int]
    size: _geometry_pb2.Vector3
    def __init__(self, size: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class Sphere(_message.Message):
    __slots__ = ("radius_meters",)
    RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    radius_meters: float
    def __init__(self, radius_meters: _Optional[float] = ...) -> None: ...

class Cylinder(_message.Message):
    __slots__ = ("radius_meters", "length_meters")
    RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    LENGTH_METERS_FIELD_NUMBER: _ClassVar[int]
    radius_meters: float
    length_meters: float
    def __init__(self, radius_meters: _Optional[float] = ..., length_meters: _Optional[float] = ...) -> None: ...

class Cone(_message.Message):
    __slots__ = ("radius_meters", "length_meters")
    RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    LENGTH_METERS_FIELD_NUMBER: _ClassVar[int]
    radius_meters: float
    length_meters: float
    def __init__(self, radius_meters: _Optional[float] = ..., length_meters: _Optional[float] = ...) -> None: ...

class Capsule(_message.Message):
    __slots__ = ("radius_meters", "length_meters")
    RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    LENGTH_METERS_FIELD_NUMBER: _ClassVar[int]
    radius_meters: float
    length_meters: float
    def __init__(self, radius_meters: _Optional[float] = ..., length_meters: _Optional[float] = ...) -> None: ...

class Mesh(_message.Message):
    __slots__ = ("uri", "sha256", "scale", "files", "collision_hull_vertices")
    URI_FIELD_NUMBER: _ClassVar[int]
    SHA256_FIELD_NUMBER: _ClassVar[int]
    SCALE_FIELD_NUMBER: _ClassVar[int]
    FILES_FIELD_NUMBER: _ClassVar[int]
    COLLISION_HULL_VERTICES_FIELD_NUMBER: _ClassVar[int]
    uri: str
    sha256: str
    scale: _geometry_pb2.Vector3
    files: _containers.RepeatedCompositeFieldContainer[AssetFile]
    collision_hull_vertices: int
    def __init__(self, uri: _Optional[str] = ..., sha256: _Optional[str] = ..., scale: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., files: _Optional[_Iterable[_Union[AssetFile, _Mapping]]] = ..., collision_hull_vertices: _Optional[int] = ...) -> None: ...

class AssetFile(_message.Message):
    __slots__ = ("uri", "sha256")
    URI_FIELD_NUMBER: _ClassVar[int]
    SHA256_FIELD_NUMBER: _ClassVar[int]
    uri: str
    sha256: str
    def __init__(self, uri: _Optional[str] = ..., sha256: _Optional[str] = ...) -> None: ...

class Points(_message.Message):
    __slots__ = ("positions", "colors", "size_meters")
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    COLORS_FIELD_NUMBER: _ClassVar[int]
    SIZE_METERS_FIELD_NUMBER: _ClassVar[int]
    positions: _geometry_pb2.NumericArray
    colors: _geometry_pb2.NumericArray
    size_meters: float
    def __init__(self, positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., colors: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., size_meters: _Optional[float] = ...) -> None: ...

class Lines(_message.Message):
    __slots__ = ("segments", "width_pixels")
    SEGMENTS_FIELD_NUMBER: _ClassVar[int]
    WIDTH_PIXELS_FIELD_NUMBER: _ClassVar[int]
    segments: _geometry_pb2.NumericArray
    width_pixels: float
    def __init__(self, segments: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., width_pixels: _Optional[float] = ...) -> None: ...

class Frame(_message.Message):
    __slots__ = ("length_meters",)
    LENGTH_METERS_FIELD_NUMBER: _ClassVar[int]
    length_meters: float
    def __init__(self, length_meters: _Optional[float] = ...) -> None: ...

class Label(_message.Message):
    __slots__ = ("text",)
    TEXT_FIELD_NUMBER: _ClassVar[int]
    text: str
    def __init__(self, text: _Optional[str] = ...) -> None: ...
