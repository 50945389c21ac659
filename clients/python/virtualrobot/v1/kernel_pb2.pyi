from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import lease_pb2 as _lease_pb2
from virtualrobot.v1 import motion_pb2 as _motion_pb2
from virtualrobot.v1 import robot_pb2 as _robot_pb2
from virtualrobot.v1 import scene_pb2 as _scene_pb2
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

class ClockMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CLOCK_MODE_UNSPECIFIED: _ClassVar[ClockMode]
    CLOCK_MODE_REALTIME: _ClassVar[ClockMode]
    CLOCK_MODE_STEPPED: _ClassVar[ClockMode]
CLOCK_MODE_UNSPECIFIED: ClockMode
CLOCK_MODE_REALTIME: ClockMode
CLOCK_MODE_STEPPED: ClockMode

class GetInfoRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetInfoResponse(_message.Message):
    __slots__ = ("version", "api_version", "capabilities", "model_formats", "kinematics", "max_message_bytes", "max_asset_bytes", "viewer_url", "process_id", "role", "token_name", "limits")
    VERSION_FIELD_NUMBER: _ClassVar[int]
    API_VERSION_FIELD_NUMBER: _ClassVar[int]
    CAPABILITIES_FIELD_NUMBER: _ClassVar[int]
    MODEL_FORMATS_FIELD_NUMBER: _ClassVar[int]
    KINEMATICS_FIELD_NUMBER: _ClassVar[int]
    MAX_MESSAGE_BYTES_FIELD_NUMBER: _ClassVar[int]
    MAX_ASSET_BYTES_FIELD_NUMBER: _ClassVar[int]
    VIEWER_URL_FIELD_NUMBER: _ClassVar[int]
    PROCESS_ID_FIELD_NUMBER: _ClassVar[int]
    ROLE_FIELD_NUMBER: _ClassVar[int]
    TOKEN_NAME_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    version: str
    api_version: str
    capabilities: _containers.RepeatedScalarFieldContainer[str]
    model_formats: _containers.RepeatedScalarFieldContainer[str]
    kinematics: _containers.RepeatedScalarFieldContainer[str]
    max_message_bytes: int
    max_asset_bytes: int
    viewer_url: str
    process_id: int
    role: _token_pb2.Role
    token_name: str
    limits: _containers.RepeatedCompositeFieldContainer[Limit]
    def __init__(self, version: _Optional[str] = ..., api_version: _Optional[str] = ..., capabilities: _Optional[_Iterable[str]] = ..., model_formats: _Optional[_Iterable[str]] = ..., kinematics: _Optional[_Iterable[str]] = ..., max_message_bytes: _Optional[int] = ..., max_asset_bytes: _Optional[int] = ..., viewer_url: _Optional[str] = ..., process_id: _Optional[int] = ..., role: _Optional[_Union[_token_pb2.Role, str]] = ..., token_name: _Optional[str] = ..., limits: _Optional[_Iterable[_Union[Limit, _Mapping]]] = ...) -> None: ...

class Limit(_message.Message):
    __slots__ = ("name", "value", "description")
    NAME_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    DESCRIPTION_FIELD_NUMBER: _ClassVar[int]
    name: str
    value: int
    description: str
    def __init__(self, name: _Optional[str] = ..., value: _Optional[int] = ..., description: _Optional[str] = ...) -> None: ...

class Clock(_message.Message):
    __slots__ = ("mode", "speed_factor", "tick_nanoseconds", "real_time_factor", "late_ticks", "recorded")
    MODE_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    TICK_NANOSECONDS_FIELD_NUMBER: _ClassVar[int]
    REAL_TIME_FACTOR_FIELD_NUMBER: _ClassVar[int]
    LATE_TICKS_FIELD_NUMBER: _ClassVar[int]
    RECORDED_FIELD_NUMBER: _ClassVar[int]
    mode: ClockMode
    speed_factor: float
    tick_nanoseconds: int
    real_time_factor: float
    late_ticks: int
    recorded: Recorded
    def __init__(self, mode: _Optional[_Union[ClockMode, str]] = ..., speed_factor: _Optional[float] = ..., tick_nanoseconds: _Optional[int] = ..., real_time_factor: _Optional[float] = ..., late_ticks: _Optional[int] = ..., recorded: _Optional[_Union[Recorded, _Mapping]] = ...) -> None: ...

class Recorded(_message.Message):
    __slots__ = ("first_tick", "last_tick")
    FIRST_TICK_FIELD_NUMBER: _ClassVar[int]
    LAST_TICK_FIELD_NUMBER: _ClassVar[int]
    first_tick: int
    last_tick: int
    def __init__(self, first_tick: _Optional[int] = ..., last_tick: _Optional[int] = ...) -> None: ...

class GetClockRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetClockResponse(_message.Message):
    __slots__ = ("stamp", "clock")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CLOCK_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    clock: Clock
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., clock: _Optional[_Union[Clock, _Mapping]] = ...) -> None: ...

class SetClockRequest(_message.Message):
    __slots__ = ("mode", "speed_factor")
    MODE_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    mode: ClockMode
    speed_factor: float
    def __init__(self, mode: _Optional[_Union[ClockMode, str]] = ..., speed_factor: _Optional[float] = ...) -> None: ...

class SetClockResponse(_message.Message):
    __slots__ = ("stamp", "clock")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CLOCK_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    clock: Clock
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., clock: _Optional[_Union[Clock, _Mapping]] = ...) -> None: ...

class HoldClockRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class HoldClockResponse(_message.Message):
    __slots__ = ("stamp", "clock")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CLOCK_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    clock: Clock
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., clock: _Optional[_Union[Clock, _Mapping]] = ...) -> None: ...

class WatchClockRequest(_message.Message):
    __slots__ = ("max_rate_hertz",)
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    max_rate_hertz: float
    def __init__(self, max_rate_hertz: _Optional[float] = ...) -> None: ...

class WatchClockResponse(_message.Message):
    __slots__ = ("stamp", "clock")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CLOCK_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    clock: Clock
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., clock: _Optional[_Union[Clock, _Mapping]] = ...) -> None: ...

class StepClockRequest(_message.Message):
    __slots__ = ("ticks", "commands", "setpoints", "until", "sensors", "reading_options")
    TICKS_FIELD_NUMBER: _ClassVar[int]
    COMMANDS_FIELD_NUMBER: _ClassVar[int]
    SETPOINTS_FIELD_NUMBER: _ClassVar[int]
    UNTIL_FIELD_NUMBER: _ClassVar[int]
    SENSORS_FIELD_NUMBER: _ClassVar[int]
    READING_OPTIONS_FIELD_NUMBER: _ClassVar[int]
    ticks: int
    commands: _containers.RepeatedCompositeFieldContainer[_scene_pb2.Command]
    setpoints: _containers.RepeatedCompositeFieldContainer[StepSetpoint]
    until: _containers.RepeatedCompositeFieldContainer[StepEvent]
    sensors: _containers.RepeatedScalarFieldContainer[str]
    reading_options: _sensor_pb2.ReadingOptions
    def __init__(self, ticks: _Optional[int] = ..., commands: _Optional[_Iterable[_Union[_scene_pb2.Command, _Mapping]]] = ..., setpoints: _Optional[_Iterable[_Union[StepSetpoint, _Mapping]]] = ..., until: _Optional[_Iterable[_Union[StepEvent, _Mapping]]] = ..., sensors: _Optional[_Iterable[str]] = ..., reading_options: _Optional[_Union[_sensor_pb2.ReadingOptions, _Mapping]] = ...) -> None: ...

class StepSetpoint(_message.Message):
    __slots__ = ("target", "values")
    TARGET_FIELD_NUMBER: _ClassVar[int]
    VALUES_FIELD_NUMBER: _ClassVar[int]
    target: _motion_pb2.SetpointTarget
    values: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, target: _Optional[_Union[_motion_pb2.SetpointTarget, _Mapping]] = ..., values: _Optional[_Iterable[float]] = ...) -> None: ...

class StepEvent(_message.Message):
    __slots__ = ("motion_ended", "signal", "collision_of", "reading_of")
    MOTION_ENDED_FIELD_NUMBER: _ClassVar[int]
    SIGNAL_FIELD_NUMBER: _ClassVar[int]
    COLLISION_OF_FIELD_NUMBER: _ClassVar[int]
    READING_OF_FIELD_NUMBER: _ClassVar[int]
    motion_ended: str
    signal: _motion_pb2.SignalCondition
    collision_of: str
    reading_of: str
    def __init__(self, motion_ended: _Optional[str] = ..., signal: _Optional[_Union[_motion_pb2.SignalCondition, _Mapping]] = ..., collision_of: _Optional[str] = ..., reading_of: _Optional[str] = ...) -> None: ...

class StepClockResponse(_message.Message):
    __slots__ = ("stamp", "robots", "signals", "motions", "readings", "ticks", "events", "setpoint_motion_ids")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    SIGNALS_FIELD_NUMBER: _ClassVar[int]
    MOTIONS_FIELD_NUMBER: _ClassVar[int]
    READINGS_FIELD_NUMBER: _ClassVar[int]
    TICKS_FIELD_NUMBER: _ClassVar[int]
    EVENTS_FIELD_NUMBER: _ClassVar[int]
    SETPOINT_MOTION_IDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    robots: _containers.RepeatedCompositeFieldContainer[_robot_pb2.RobotState]
    signals: _containers.RepeatedCompositeFieldContainer[_signal_pb2.Signal]
    motions: _containers.RepeatedCompositeFieldContainer[_motion_pb2.Motion]
    readings: _containers.RepeatedCompositeFieldContainer[_sensor_pb2.SensorReading]
    ticks: int
    events: _containers.RepeatedScalarFieldContainer[int]
    setpoint_motion_ids: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., robots: _Optional[_Iterable[_Union[_robot_pb2.RobotState, _Mapping]]] = ..., signals: _Optional[_Iterable[_Union[_signal_pb2.Signal, _Mapping]]] = ..., motions: _Optional[_Iterable[_Union[_motion_pb2.Motion, _Mapping]]] = ..., readings: _Optional[_Iterable[_Union[_sensor_pb2.SensorReading, _Mapping]]] = ..., ticks: _Optional[int] = ..., events: _Optional[_Iterable[int]] = ..., setpoint_motion_ids: _Optional[_Iterable[str]] = ...) -> None: ...

class SeekClockRequest(_message.Message):
    __slots__ = ("tick",)
    TICK_FIELD_NUMBER: _ClassVar[int]
    tick: int
    def __init__(self, tick: _Optional[int] = ...) -> None: ...

class SeekClockResponse(_message.Message):
    __slots__ = ("stamp", "clock")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CLOCK_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    clock: Clock
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., clock: _Optional[_Union[Clock, _Mapping]] = ...) -> None: ...

class GetReportRequest(_message.Message):
    __slots__ = ("max_journal_bytes",)
    MAX_JOURNAL_BYTES_FIELD_NUMBER: _ClassVar[int]
    max_journal_bytes: int
    def __init__(self, max_journal_bytes: _Optional[int] = ...) -> None: ...

class GetReportResponse(_message.Message):
    __slots__ = ("data",)
    DATA_FIELD_NUMBER: _ClassVar[int]
    data: bytes
    def __init__(self, data: _Optional[bytes] = ...) -> None: ...

class ShutdownRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ShutdownResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...
