from google.protobuf import struct_pb2 as _struct_pb2
from google.protobuf import timestamp_pb2 as _timestamp_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import lease_pb2 as _lease_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class DriverMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DRIVER_MODE_UNSPECIFIED: _ClassVar[DriverMode]
    DRIVER_MODE_SIMULATED: _ClassVar[DriverMode]
    DRIVER_MODE_MONITOR: _ClassVar[DriverMode]
    DRIVER_MODE_EXECUTE: _ClassVar[DriverMode]

class DriverState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DRIVER_STATE_UNSPECIFIED: _ClassVar[DriverState]
    DRIVER_STATE_DISCONNECTED: _ClassVar[DriverState]
    DRIVER_STATE_CONNECTING: _ClassVar[DriverState]
    DRIVER_STATE_INACTIVE: _ClassVar[DriverState]
    DRIVER_STATE_BEGINNING: _ClassVar[DriverState]
    DRIVER_STATE_ACTIVE: _ClassVar[DriverState]
    DRIVER_STATE_STOPPING: _ClassVar[DriverState]
    DRIVER_STATE_ERROR: _ClassVar[DriverState]

class ControllerMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CONTROLLER_MODE_UNSPECIFIED: _ClassVar[ControllerMode]
    CONTROLLER_MODE_OFF: _ClassVar[ControllerMode]
    CONTROLLER_MODE_STARTING: _ClassVar[ControllerMode]
    CONTROLLER_MODE_READY: _ClassVar[ControllerMode]
    CONTROLLER_MODE_RUNNING: _ClassVar[ControllerMode]
    CONTROLLER_MODE_HAND_GUIDED: _ClassVar[ControllerMode]
    CONTROLLER_MODE_LOCAL: _ClassVar[ControllerMode]

class ControllerSafety(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CONTROLLER_SAFETY_UNSPECIFIED: _ClassVar[ControllerSafety]
    CONTROLLER_SAFETY_NORMAL: _ClassVar[ControllerSafety]
    CONTROLLER_SAFETY_REDUCED: _ClassVar[ControllerSafety]
    CONTROLLER_SAFETY_PROTECTIVE_STOP: _ClassVar[ControllerSafety]
    CONTROLLER_SAFETY_SAFEGUARD_STOP: _ClassVar[ControllerSafety]
    CONTROLLER_SAFETY_EMERGENCY_STOP: _ClassVar[ControllerSafety]
    CONTROLLER_SAFETY_FAULT: _ClassVar[ControllerSafety]

class ControllerPace(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CONTROLLER_PACE_UNSPECIFIED: _ClassVar[ControllerPace]
    CONTROLLER_PACE_HOST: _ClassVar[ControllerPace]
    CONTROLLER_PACE_CONTROLLER: _ClassVar[ControllerPace]
    CONTROLLER_PACE_JOBS: _ClassVar[ControllerPace]
DRIVER_MODE_UNSPECIFIED: DriverMode
DRIVER_MODE_SIMULATED: DriverMode
DRIVER_MODE_MONITOR: DriverMode
DRIVER_MODE_EXECUTE: DriverMode
DRIVER_STATE_UNSPECIFIED: DriverState
DRIVER_STATE_DISCONNECTED: DriverState
DRIVER_STATE_CONNECTING: DriverState
DRIVER_STATE_INACTIVE: DriverState
DRIVER_STATE_BEGINNING: DriverState
DRIVER_STATE_ACTIVE: DriverState
DRIVER_STATE_STOPPING: DriverState
DRIVER_STATE_ERROR: DriverState
CONTROLLER_MODE_UNSPECIFIED: ControllerMode
CONTROLLER_MODE_OFF: ControllerMode
CONTROLLER_MODE_STARTING: ControllerMode
CONTROLLER_MODE_READY: ControllerMode
CONTROLLER_MODE_RUNNING: ControllerMode
CONTROLLER_MODE_HAND_GUIDED: ControllerMode
CONTROLLER_MODE_LOCAL: ControllerMode
CONTROLLER_SAFETY_UNSPECIFIED: ControllerSafety
CONTROLLER_SAFETY_NORMAL: ControllerSafety
CONTROLLER_SAFETY_REDUCED: ControllerSafety
CONTROLLER_SAFETY_PROTECTIVE_STOP: ControllerSafety
CONTROLLER_SAFETY_SAFEGUARD_STOP: ControllerSafety
CONTROLLER_SAFETY_EMERGENCY_STOP: ControllerSafety
CONTROLLER_SAFETY_FAULT: ControllerSafety
CONTROLLER_PACE_UNSPECIFIED: ControllerPace
CONTROLLER_PACE_HOST: ControllerPace
CONTROLLER_PACE_CONTROLLER: ControllerPace
CONTROLLER_PACE_JOBS: ControllerPace

class DriverJoint(_message.Message):
    __slots__ = ("joint", "reversed", "offset")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    REVERSED_FIELD_NUMBER: _ClassVar[int]
    OFFSET_FIELD_NUMBER: _ClassVar[int]
    joint: str
    reversed: bool
    offset: float
    def __init__(self, joint: _Optional[str] = ..., reversed: bool = ..., offset: _Optional[float] = ...) -> None: ...

class ControllerDescription(_message.Message):
    __slots__ = ("joint_count", "rate_hertz", "pace", "watchdog_seconds", "model", "version", "serial", "has_speed_scaling", "input_count", "output_count")
    JOINT_COUNT_FIELD_NUMBER: _ClassVar[int]
    RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    PACE_FIELD_NUMBER: _ClassVar[int]
    WATCHDOG_SECONDS_FIELD_NUMBER: _ClassVar[int]
    MODEL_FIELD_NUMBER: _ClassVar[int]
    VERSION_FIELD_NUMBER: _ClassVar[int]
    SERIAL_FIELD_NUMBER: _ClassVar[int]
    HAS_SPEED_SCALING_FIELD_NUMBER: _ClassVar[int]
    INPUT_COUNT_FIELD_NUMBER: _ClassVar[int]
    OUTPUT_COUNT_FIELD_NUMBER: _ClassVar[int]
    joint_count: int
    rate_hertz: float
    pace: ControllerPace
    watchdog_seconds: float
    model: str
    version: str
    serial: str
    has_speed_scaling: bool
    input_count: int
    output_count: int
    def __init__(self, joint_count: _Optional[int] = ..., rate_hertz: _Optional[float] = ..., pace: _Optional[_Union[ControllerPace, str]] = ..., watchdog_seconds: _Optional[float] = ..., model: _Optional[str] = ..., version: _Optional[str] = ..., serial: _Optional[str] = ..., has_speed_scaling: bool = ..., input_count: _Optional[int] = ..., output_count: _Optional[int] = ...) -> None: ...

class DriverStatus(_message.Message):
    __slots__ = ("robot", "component", "mode", "state", "controller_mode", "controller_safety", "text", "code", "clears", "controller", "joint_names", "positions", "velocities", "outside_limits", "following_error", "following_warning", "following_limit", "follows_badly", "speed_scaling", "inputs", "outputs", "lead_seconds", "play_rate", "played_tick", "cycles", "skipped_cycles", "lateness_seconds", "process_id", "halted")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    COMPONENT_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    CONTROLLER_MODE_FIELD_NUMBER: _ClassVar[int]
    CONTROLLER_SAFETY_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    CODE_FIELD_NUMBER: _ClassVar[int]
    CLEARS_FIELD_NUMBER: _ClassVar[int]
    CONTROLLER_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    OUTSIDE_LIMITS_FIELD_NUMBER: _ClassVar[int]
    FOLLOWING_ERROR_FIELD_NUMBER: _ClassVar[int]
    FOLLOWING_WARNING_FIELD_NUMBER: _ClassVar[int]
    FOLLOWING_LIMIT_FIELD_NUMBER: _ClassVar[int]
    FOLLOWS_BADLY_FIELD_NUMBER: _ClassVar[int]
    SPEED_SCALING_FIELD_NUMBER: _ClassVar[int]
    INPUTS_FIELD_NUMBER: _ClassVar[int]
    OUTPUTS_FIELD_NUMBER: _ClassVar[int]
    LEAD_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PLAY_RATE_FIELD_NUMBER: _ClassVar[int]
    PLAYED_TICK_FIELD_NUMBER: _ClassVar[int]
    CYCLES_FIELD_NUMBER: _ClassVar[int]
    SKIPPED_CYCLES_FIELD_NUMBER: _ClassVar[int]
    LATENESS_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PROCESS_ID_FIELD_NUMBER: _ClassVar[int]
    HALTED_FIELD_NUMBER: _ClassVar[int]
    robot: str
    component: str
    mode: DriverMode
    state: DriverState
    controller_mode: ControllerMode
    controller_safety: ControllerSafety
    text: str
    code: str
    clears: bool
    controller: ControllerDescription
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _containers.RepeatedScalarFieldContainer[float]
    velocities: _containers.RepeatedScalarFieldContainer[float]
    outside_limits: _containers.RepeatedScalarFieldContainer[str]
    following_error: _containers.RepeatedScalarFieldContainer[float]
    following_warning: float
    following_limit: float
    follows_badly: bool
    speed_scaling: float
    inputs: int
    outputs: int
    lead_seconds: float
    play_rate: float
    played_tick: int
    cycles: int
    skipped_cycles: int
    lateness_seconds: float
    process_id: int
    halted: bool
    def __init__(self, robot: _Optional[str] = ..., component: _Optional[str] = ..., mode: _Optional[_Union[DriverMode, str]] = ..., state: _Optional[_Union[DriverState, str]] = ..., controller_mode: _Optional[_Union[ControllerMode, str]] = ..., controller_safety: _Optional[_Union[ControllerSafety, str]] = ..., text: _Optional[str] = ..., code: _Optional[str] = ..., clears: bool = ..., controller: _Optional[_Union[ControllerDescription, _Mapping]] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Iterable[float]] = ..., velocities: _Optional[_Iterable[float]] = ..., outside_limits: _Optional[_Iterable[str]] = ..., following_error: _Optional[_Iterable[float]] = ..., following_warning: _Optional[float] = ..., following_limit: _Optional[float] = ..., follows_badly: bool = ..., speed_scaling: _Optional[float] = ..., inputs: _Optional[int] = ..., outputs: _Optional[int] = ..., lead_seconds: _Optional[float] = ..., play_rate: _Optional[float] = ..., played_tick: _Optional[int] = ..., cycles: _Optional[int] = ..., skipped_cycles: _Optional[int] = ..., lateness_seconds: _Optional[float] = ..., process_id: _Optional[int] = ..., halted: bool = ...) -> None: ...

class CellStatus(_message.Message):
    __slots__ = ("stopped", "reason", "stopper_address", "stopper_key", "stopped_by", "stop_time")
    STOPPED_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    STOPPER_ADDRESS_FIELD_NUMBER: _ClassVar[int]
    STOPPER_KEY_FIELD_NUMBER: _ClassVar[int]
    STOPPED_BY_FIELD_NUMBER: _ClassVar[int]
    STOP_TIME_FIELD_NUMBER: _ClassVar[int]
    stopped: bool
    reason: str
    stopper_address: str
    stopper_key: str
    stopped_by: str
    stop_time: _timestamp_pb2.Timestamp
    def __init__(self, stopped: bool = ..., reason: _Optional[str] = ..., stopper_address: _Optional[str] = ..., stopper_key: _Optional[str] = ..., stopped_by: _Optional[str] = ..., stop_time: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping]] = ...) -> None: ...

class ConnectDriverRequest(_message.Message):
    __slots__ = ("robot", "component", "settings", "joints", "lead_seconds", "following_warning", "following_limit", "without_watchdog")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    COMPONENT_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    JOINTS_FIELD_NUMBER: _ClassVar[int]
    LEAD_SECONDS_FIELD_NUMBER: _ClassVar[int]
    FOLLOWING_WARNING_FIELD_NUMBER: _ClassVar[int]
    FOLLOWING_LIMIT_FIELD_NUMBER: _ClassVar[int]
    WITHOUT_WATCHDOG_FIELD_NUMBER: _ClassVar[int]
    robot: str
    component: str
    settings: _struct_pb2.Struct
    joints: _containers.RepeatedCompositeFieldContainer[DriverJoint]
    lead_seconds: float
    following_warning: float
    following_limit: float
    without_watchdog: bool
    def __init__(self, robot: _Optional[str] = ..., component: _Optional[str] = ..., settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., joints: _Optional[_Iterable[_Union[DriverJoint, _Mapping]]] = ..., lead_seconds: _Optional[float] = ..., following_warning: _Optional[float] = ..., following_limit: _Optional[float] = ..., without_watchdog: bool = ...) -> None: ...

class ConnectDriverResponse(_message.Message):
    __slots__ = ("stamp", "driver")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DRIVER_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    driver: DriverStatus
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., driver: _Optional[_Union[DriverStatus, _Mapping]] = ...) -> None: ...

class DisconnectDriverRequest(_message.Message):
    __slots__ = ("robot",)
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    robot: str
    def __init__(self, robot: _Optional[str] = ...) -> None: ...

class DisconnectDriverResponse(_message.Message):
    __slots__ = ("stamp", "driver")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DRIVER_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    driver: DriverStatus
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., driver: _Optional[_Union[DriverStatus, _Mapping]] = ...) -> None: ...

class SetDriverModeRequest(_message.Message):
    __slots__ = ("robot", "mode")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    robot: str
    mode: DriverMode
    def __init__(self, robot: _Optional[str] = ..., mode: _Optional[_Union[DriverMode, str]] = ...) -> None: ...

class SetDriverModeResponse(_message.Message):
    __slots__ = ("stamp", "driver", "twin_moved")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DRIVER_FIELD_NUMBER: _ClassVar[int]
    TWIN_MOVED_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    driver: DriverStatus
    twin_moved: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., driver: _Optional[_Union[DriverStatus, _Mapping]] = ..., twin_moved: _Optional[_Iterable[float]] = ...) -> None: ...

class ResetDriverRequest(_message.Message):
    __slots__ = ("robot",)
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    robot: str
    def __init__(self, robot: _Optional[str] = ...) -> None: ...

class ResetDriverResponse(_message.Message):
    __slots__ = ("stamp", "driver")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DRIVER_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    driver: DriverStatus
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., driver: _Optional[_Union[DriverStatus, _Mapping]] = ...) -> None: ...

class GetDriversRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetDriversResponse(_message.Message):
    __slots__ = ("stamp", "drivers", "cell")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DRIVERS_FIELD_NUMBER: _ClassVar[int]
    CELL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    drivers: _containers.RepeatedCompositeFieldContainer[DriverStatus]
    cell: CellStatus
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., drivers: _Optional[_Iterable[_Union[DriverStatus, _Mapping]]] = ..., cell: _Optional[_Union[CellStatus, _Mapping]] = ...) -> None: ...

class WatchDriversRequest(_message.Message):
    __slots__ = ("max_rate_hertz",)
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    max_rate_hertz: float
    def __init__(self, max_rate_hertz: _Optional[float] = ...) -> None: ...

class WatchDriversResponse(_message.Message):
    __slots__ = ("stamp", "drivers", "cell")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DRIVERS_FIELD_NUMBER: _ClassVar[int]
    CELL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    drivers: _containers.RepeatedCompositeFieldContainer[DriverStatus]
    cell: CellStatus
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., drivers: _Optional[_Iterable[_Union[DriverStatus, _Mapping]]] = ..., cell: _Optional[_Union[CellStatus, _Mapping]] = ...) -> None: ...

class StopCellRequest(_message.Message):
    __slots__ = ("reason",)
    REASON_FIELD_NUMBER: _ClassVar[int]
    reason: str
    def __init__(self, reason: _Optional[str] = ...) -> None: ...

class StopCellResponse(_message.Message):
    __slots__ = ("stamp", "cell")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CELL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    cell: CellStatus
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., cell: _Optional[_Union[CellStatus, _Mapping]] = ...) -> None: ...

class ReleaseCellRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ReleaseCellResponse(_message.Message):
    __slots__ = ("stamp", "cell")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CELL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    cell: CellStatus
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., cell: _Optional[_Union[CellStatus, _Mapping]] = ...) -> None: ...
