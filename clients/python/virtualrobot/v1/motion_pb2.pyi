from virtualrobot.v1 import collision_pb2 as _collision_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import lease_pb2 as _lease_pb2
from virtualrobot.v1 import nodes_pb2 as _nodes_pb2
from virtualrobot.v1 import robot_pb2 as _robot_pb2
from virtualrobot.v1 import scene_pb2 as _scene_pb2
from virtualrobot.v1 import signal_pb2 as _signal_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
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
    BUSY_POLICY_REPLACE: _ClassVar[BusyPolicy]

class DisconnectPolicy(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DISCONNECT_POLICY_UNSPECIFIED: _ClassVar[DisconnectPolicy]
    DISCONNECT_POLICY_STOP: _ClassVar[DisconnectPolicy]
    DISCONNECT_POLICY_CONTINUE: _ClassVar[DisconnectPolicy]

class PatternOrder(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PATTERN_ORDER_UNSPECIFIED: _ClassVar[PatternOrder]
    PATTERN_ORDER_COLUMN_BY_COLUMN: _ClassVar[PatternOrder]
    PATTERN_ORDER_ROW_BY_ROW: _ClassVar[PatternOrder]
    PATTERN_ORDER_COLUMNS_TO_AND_FRO: _ClassVar[PatternOrder]
    PATTERN_ORDER_ROWS_TO_AND_FRO: _ClassVar[PatternOrder]

class Comparison(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    COMPARISON_UNSPECIFIED: _ClassVar[Comparison]
    COMPARISON_EQUAL: _ClassVar[Comparison]
    COMPARISON_NOT_EQUAL: _ClassVar[Comparison]
    COMPARISON_LESS: _ClassVar[Comparison]
    COMPARISON_AT_MOST: _ClassVar[Comparison]
    COMPARISON_GREATER: _ClassVar[Comparison]
    COMPARISON_AT_LEAST: _ClassVar[Comparison]

class TimeLaw(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    TIME_LAW_UNSPECIFIED: _ClassVar[TimeLaw]
    TIME_LAW_JERK_LIMITED: _ClassVar[TimeLaw]
    TIME_LAW_TIME_OPTIMAL: _ClassVar[TimeLaw]

class JogFrame(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    JOG_FRAME_UNSPECIFIED: _ClassVar[JogFrame]
    JOG_FRAME_BASE: _ClassVar[JogFrame]
    JOG_FRAME_TOOL: _ClassVar[JogFrame]
    JOG_FRAME_NODE: _ClassVar[JogFrame]

class ArcOrientation(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ARC_ORIENTATION_UNSPECIFIED: _ClassVar[ArcOrientation]
    ARC_ORIENTATION_TO_GOAL: _ClassVar[ArcOrientation]
    ARC_ORIENTATION_WITH_ARC: _ClassVar[ArcOrientation]

class TrajectoryInterpolation(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    TRAJECTORY_INTERPOLATION_UNSPECIFIED: _ClassVar[TrajectoryInterpolation]
    TRAJECTORY_INTERPOLATION_SMOOTH: _ClassVar[TrajectoryInterpolation]
    TRAJECTORY_INTERPOLATION_SEGMENTS: _ClassVar[TrajectoryInterpolation]

class MotionPhase(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    MOTION_PHASE_UNSPECIFIED: _ClassVar[MotionPhase]
    MOTION_PHASE_RUNNING: _ClassVar[MotionPhase]
    MOTION_PHASE_PAUSING: _ClassVar[MotionPhase]
    MOTION_PHASE_PAUSED: _ClassVar[MotionPhase]
    MOTION_PHASE_STOPPING: _ClassVar[MotionPhase]
    MOTION_PHASE_SUCCEEDED: _ClassVar[MotionPhase]
    MOTION_PHASE_CANCELLED: _ClassVar[MotionPhase]
    MOTION_PHASE_WAITING: _ClassVar[MotionPhase]
    MOTION_PHASE_ABORTED: _ClassVar[MotionPhase]
    MOTION_PHASE_STARVED: _ClassVar[MotionPhase]

class EndCause(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    END_CAUSE_UNSPECIFIED: _ClassVar[EndCause]
    END_CAUSE_CALL: _ClassVar[EndCause]
    END_CAUSE_STOP: _ClassVar[EndCause]
    END_CAUSE_PREEMPTED: _ClassVar[EndCause]
    END_CAUSE_UNWATCHED: _ClassVar[EndCause]
    END_CAUSE_WORLD_CLEARED: _ClassVar[EndCause]
    END_CAUSE_LEASE_EXPIRED: _ClassVar[EndCause]
    END_CAUSE_LEASE_TAKEN: _ClassVar[EndCause]
    END_CAUSE_SIGNAL_TIMEOUT: _ClassVar[EndCause]
    END_CAUSE_SETPOINT_TIMEOUT: _ClassVar[EndCause]
    END_CAUSE_SETPOINT_REFUSED: _ClassVar[EndCause]
    END_CAUSE_WINDOW_LEFT: _ClassVar[EndCause]
    END_CAUSE_TRACKING_LOST: _ClassVar[EndCause]
    END_CAUSE_FAILED: _ClassVar[EndCause]
    END_CAUSE_COLLISION: _ClassVar[EndCause]
    END_CAUSE_STEP_REFUSED: _ClassVar[EndCause]
    END_CAUSE_PART_TIMEOUT: _ClassVar[EndCause]
    END_CAUSE_WORLD_RESTORED: _ClassVar[EndCause]
    END_CAUSE_KERNEL_RESTARTED: _ClassVar[EndCause]
    END_CAUSE_DRIVER: _ClassVar[EndCause]
    END_CAUSE_CELL_STOPPED: _ClassVar[EndCause]
    END_CAUSE_PATH_TOLERANCE: _ClassVar[EndCause]
    END_CAUSE_GOAL_TOLERANCE: _ClassVar[EndCause]

class DeviationKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    DEVIATION_KIND_UNSPECIFIED: _ClassVar[DeviationKind]
    DEVIATION_KIND_POSITION: _ClassVar[DeviationKind]
    DEVIATION_KIND_VELOCITY: _ClassVar[DeviationKind]

class PlanNoteKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PLAN_NOTE_KIND_UNSPECIFIED: _ClassVar[PlanNoteKind]
    PLAN_NOTE_KIND_ZONE_SHRUNK: _ClassVar[PlanNoteKind]
    PLAN_NOTE_KIND_ZONE_DROPPED: _ClassVar[PlanNoteKind]
    PLAN_NOTE_KIND_JOG_ENDS: _ClassVar[PlanNoteKind]
    PLAN_NOTE_KIND_UNFORESEEN: _ClassVar[PlanNoteKind]
    PLAN_NOTE_KIND_DEFERRED: _ClassVar[PlanNoteKind]
    PLAN_NOTE_KIND_TOUCHING: _ClassVar[PlanNoteKind]

class ViolationKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    VIOLATION_KIND_UNSPECIFIED: _ClassVar[ViolationKind]
    VIOLATION_KIND_JOINT_POSITION: _ClassVar[ViolationKind]
    VIOLATION_KIND_JOINT_VELOCITY: _ClassVar[ViolationKind]
    VIOLATION_KIND_JOINT_ACCELERATION: _ClassVar[ViolationKind]
    VIOLATION_KIND_EFFORT: _ClassVar[ViolationKind]
    VIOLATION_KIND_REACH: _ClassVar[ViolationKind]
    VIOLATION_KIND_SINGULARITY: _ClassVar[ViolationKind]
    VIOLATION_KIND_OTHER: _ClassVar[ViolationKind]
    VIOLATION_KIND_COLLISION: _ClassVar[ViolationKind]
    VIOLATION_KIND_PAYLOAD: _ClassVar[ViolationKind]

class SetpointMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    SETPOINT_MODE_UNSPECIFIED: _ClassVar[SetpointMode]
    SETPOINT_MODE_POSITION: _ClassVar[SetpointMode]
    SETPOINT_MODE_VELOCITY: _ClassVar[SetpointMode]
    SETPOINT_MODE_TWIST: _ClassVar[SetpointMode]
    SETPOINT_MODE_TOOL_TWIST: _ClassVar[SetpointMode]
    SETPOINT_MODE_TOOL_POSE: _ClassVar[SetpointMode]

class ProgramStepEventKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PROGRAM_STEP_EVENT_KIND_UNSPECIFIED: _ClassVar[ProgramStepEventKind]
    PROGRAM_STEP_EVENT_KIND_BEGUN: _ClassVar[ProgramStepEventKind]
    PROGRAM_STEP_EVENT_KIND_ZONE_ENTERED: _ClassVar[ProgramStepEventKind]
    PROGRAM_STEP_EVENT_KIND_DONE: _ClassVar[ProgramStepEventKind]
BUSY_POLICY_UNSPECIFIED: BusyPolicy
BUSY_POLICY_REJECT: BusyPolicy
BUSY_POLICY_PREEMPT: BusyPolicy
BUSY_POLICY_REPLACE: BusyPolicy
DISCONNECT_POLICY_UNSPECIFIED: DisconnectPolicy
DISCONNECT_POLICY_STOP: DisconnectPolicy
DISCONNECT_POLICY_CONTINUE: DisconnectPolicy
PATTERN_ORDER_UNSPECIFIED: PatternOrder
PATTERN_ORDER_COLUMN_BY_COLUMN: PatternOrder
PATTERN_ORDER_ROW_BY_ROW: PatternOrder
PATTERN_ORDER_COLUMNS_TO_AND_FRO: PatternOrder
PATTERN_ORDER_ROWS_TO_AND_FRO: PatternOrder
COMPARISON_UNSPECIFIED: Comparison
COMPARISON_EQUAL: Comparison
COMPARISON_NOT_EQUAL: Comparison
COMPARISON_LESS: Comparison
COMPARISON_AT_MOST: Comparison
COMPARISON_GREATER: Comparison
COMPARISON_AT_LEAST: Comparison
TIME_LAW_UNSPECIFIED: TimeLaw
TIME_LAW_JERK_LIMITED: TimeLaw
TIME_LAW_TIME_OPTIMAL: TimeLaw
JOG_FRAME_UNSPECIFIED: JogFrame
JOG_FRAME_BASE: JogFrame
JOG_FRAME_TOOL: JogFrame
JOG_FRAME_NODE: JogFrame
ARC_ORIENTATION_UNSPECIFIED: ArcOrientation
ARC_ORIENTATION_TO_GOAL: ArcOrientation
ARC_ORIENTATION_WITH_ARC: ArcOrientation
TRAJECTORY_INTERPOLATION_UNSPECIFIED: TrajectoryInterpolation
TRAJECTORY_INTERPOLATION_SMOOTH: TrajectoryInterpolation
TRAJECTORY_INTERPOLATION_SEGMENTS: TrajectoryInterpolation
MOTION_PHASE_UNSPECIFIED: MotionPhase
MOTION_PHASE_RUNNING: MotionPhase
MOTION_PHASE_PAUSING: MotionPhase
MOTION_PHASE_PAUSED: MotionPhase
MOTION_PHASE_STOPPING: MotionPhase
MOTION_PHASE_SUCCEEDED: MotionPhase
MOTION_PHASE_CANCELLED: MotionPhase
MOTION_PHASE_WAITING: MotionPhase
MOTION_PHASE_ABORTED: MotionPhase
MOTION_PHASE_STARVED: MotionPhase
END_CAUSE_UNSPECIFIED: EndCause
END_CAUSE_CALL: EndCause
END_CAUSE_STOP: EndCause
END_CAUSE_PREEMPTED: EndCause
END_CAUSE_UNWATCHED: EndCause
END_CAUSE_WORLD_CLEARED: EndCause
END_CAUSE_LEASE_EXPIRED: EndCause
END_CAUSE_LEASE_TAKEN: EndCause
END_CAUSE_SIGNAL_TIMEOUT: EndCause
END_CAUSE_SETPOINT_TIMEOUT: EndCause
END_CAUSE_SETPOINT_REFUSED: EndCause
END_CAUSE_WINDOW_LEFT: EndCause
END_CAUSE_TRACKING_LOST: EndCause
END_CAUSE_FAILED: EndCause
END_CAUSE_COLLISION: EndCause
END_CAUSE_STEP_REFUSED: EndCause
END_CAUSE_PART_TIMEOUT: EndCause
END_CAUSE_WORLD_RESTORED: EndCause
END_CAUSE_KERNEL_RESTARTED: EndCause
END_CAUSE_DRIVER: EndCause
END_CAUSE_CELL_STOPPED: EndCause
END_CAUSE_PATH_TOLERANCE: EndCause
END_CAUSE_GOAL_TOLERANCE: EndCause
DEVIATION_KIND_UNSPECIFIED: DeviationKind
DEVIATION_KIND_POSITION: DeviationKind
DEVIATION_KIND_VELOCITY: DeviationKind
PLAN_NOTE_KIND_UNSPECIFIED: PlanNoteKind
PLAN_NOTE_KIND_ZONE_SHRUNK: PlanNoteKind
PLAN_NOTE_KIND_ZONE_DROPPED: PlanNoteKind
PLAN_NOTE_KIND_JOG_ENDS: PlanNoteKind
PLAN_NOTE_KIND_UNFORESEEN: PlanNoteKind
PLAN_NOTE_KIND_DEFERRED: PlanNoteKind
PLAN_NOTE_KIND_TOUCHING: PlanNoteKind
VIOLATION_KIND_UNSPECIFIED: ViolationKind
VIOLATION_KIND_JOINT_POSITION: ViolationKind
VIOLATION_KIND_JOINT_VELOCITY: ViolationKind
VIOLATION_KIND_JOINT_ACCELERATION: ViolationKind
VIOLATION_KIND_EFFORT: ViolationKind
VIOLATION_KIND_REACH: ViolationKind
VIOLATION_KIND_SINGULARITY: ViolationKind
VIOLATION_KIND_OTHER: ViolationKind
VIOLATION_KIND_COLLISION: ViolationKind
VIOLATION_KIND_PAYLOAD: ViolationKind
SETPOINT_MODE_UNSPECIFIED: SetpointMode
SETPOINT_MODE_POSITION: SetpointMode
SETPOINT_MODE_VELOCITY: SetpointMode
SETPOINT_MODE_TWIST: SetpointMode
SETPOINT_MODE_TOOL_TWIST: SetpointMode
SETPOINT_MODE_TOOL_POSE: SetpointMode
PROGRAM_STEP_EVENT_KIND_UNSPECIFIED: ProgramStepEventKind
PROGRAM_STEP_EVENT_KIND_BEGUN: ProgramStepEventKind
PROGRAM_STEP_EVENT_KIND_ZONE_ENTERED: ProgramStepEventKind
PROGRAM_STEP_EVENT_KIND_DONE: ProgramStepEventKind

class MotionSpec(_message.Message):
    __slots__ = ("moves", "steps", "tracking", "programs")
    class ProgramsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: SubProgram
        def __init__(self, key: _Optional[str] = ..., value: _Optional[_Union[SubProgram, _Mapping]] = ...) -> None: ...
    MOVES_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    TRACKING_FIELD_NUMBER: _ClassVar[int]
    PROGRAMS_FIELD_NUMBER: _ClassVar[int]
    moves: _containers.RepeatedCompositeFieldContainer[Move]
    steps: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    tracking: Tracking
    programs: _containers.MessageMap[str, SubProgram]
    def __init__(self, moves: _Optional[_Iterable[_Union[Move, _Mapping]]] = ..., steps: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ..., tracking: _Optional[_Union[Tracking, _Mapping]] = ..., programs: _Optional[_Mapping[str, SubProgram]] = ...) -> None: ...

class SubProgram(_message.Message):
    __slots__ = ("steps",)
    STEPS_FIELD_NUMBER: _ClassVar[int]
    steps: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    def __init__(self, steps: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ...) -> None: ...

class StartMotionRequest(_message.Message):
    __slots__ = ("spec", "busy_policy", "on_disconnect", "expected_structure_revision", "request_id", "open", "breakpoints", "hold", "plan", "proposal")
    SPEC_FIELD_NUMBER: _ClassVar[int]
    BUSY_POLICY_FIELD_NUMBER: _ClassVar[int]
    ON_DISCONNECT_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_STRUCTURE_REVISION_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    OPEN_FIELD_NUMBER: _ClassVar[int]
    BREAKPOINTS_FIELD_NUMBER: _ClassVar[int]
    HOLD_FIELD_NUMBER: _ClassVar[int]
    PLAN_FIELD_NUMBER: _ClassVar[int]
    PROPOSAL_FIELD_NUMBER: _ClassVar[int]
    spec: MotionSpec
    busy_policy: BusyPolicy
    on_disconnect: DisconnectPolicy
    expected_structure_revision: int
    request_id: str
    open: bool
    breakpoints: _containers.RepeatedScalarFieldContainer[str]
    hold: bool
    plan: PlanReference
    proposal: ProposalReference
    def __init__(self, spec: _Optional[_Union[MotionSpec, _Mapping]] = ..., busy_policy: _Optional[_Union[BusyPolicy, str]] = ..., on_disconnect: _Optional[_Union[DisconnectPolicy, str]] = ..., expected_structure_revision: _Optional[int] = ..., request_id: _Optional[str] = ..., open: bool = ..., breakpoints: _Optional[_Iterable[str]] = ..., hold: bool = ..., plan: _Optional[_Union[PlanReference, _Mapping]] = ..., proposal: _Optional[_Union[ProposalReference, _Mapping]] = ...) -> None: ...

class ProposalReference(_message.Message):
    __slots__ = ("id", "revision")
    ID_FIELD_NUMBER: _ClassVar[int]
    REVISION_FIELD_NUMBER: _ClassVar[int]
    id: str
    revision: int
    def __init__(self, id: _Optional[str] = ..., revision: _Optional[int] = ...) -> None: ...

class PlanReference(_message.Message):
    __slots__ = ("id", "digest")
    ID_FIELD_NUMBER: _ClassVar[int]
    DIGEST_FIELD_NUMBER: _ClassVar[int]
    id: str
    digest: str
    def __init__(self, id: _Optional[str] = ..., digest: _Optional[str] = ...) -> None: ...

class AppendMotionRequest(_message.Message):
    __slots__ = ("id", "steps", "last", "expected_step_count", "expected_structure_revision", "request_id", "programs", "breakpoints")
    class ProgramsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: SubProgram
        def __init__(self, key: _Optional[str] = ..., value: _Optional[_Union[SubProgram, _Mapping]] = ...) -> None: ...
    ID_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    LAST_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_STEP_COUNT_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_STRUCTURE_REVISION_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    PROGRAMS_FIELD_NUMBER: _ClassVar[int]
    BREAKPOINTS_FIELD_NUMBER: _ClassVar[int]
    id: str
    steps: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    last: bool
    expected_step_count: int
    expected_structure_revision: int
    request_id: str
    programs: _containers.MessageMap[str, SubProgram]
    breakpoints: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, id: _Optional[str] = ..., steps: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ..., last: bool = ..., expected_step_count: _Optional[int] = ..., expected_structure_revision: _Optional[int] = ..., request_id: _Optional[str] = ..., programs: _Optional[_Mapping[str, SubProgram]] = ..., breakpoints: _Optional[_Iterable[str]] = ...) -> None: ...

class AppendMotionResponse(_message.Message):
    __slots__ = ("stamp", "motion", "notes")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    NOTES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motion: Motion
    notes: _containers.RepeatedCompositeFieldContainer[PlanNote]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ..., notes: _Optional[_Iterable[_Union[PlanNote, _Mapping]]] = ...) -> None: ...

class ProgramStep(_message.Message):
    __slots__ = ("move", "set_signal", "wait_signal", "dwell", "pick", "place", "attach", "select_tool", "set_allowed_pairs", "set_speed", "wait_part", "repeat", "call", "pattern", "pick_at", "place_at", "if_signal", "while_signal")
    MOVE_FIELD_NUMBER: _ClassVar[int]
    SET_SIGNAL_FIELD_NUMBER: _ClassVar[int]
    WAIT_SIGNAL_FIELD_NUMBER: _ClassVar[int]
    DWELL_FIELD_NUMBER: _ClassVar[int]
    PICK_FIELD_NUMBER: _ClassVar[int]
    PLACE_FIELD_NUMBER: _ClassVar[int]
    ATTACH_FIELD_NUMBER: _ClassVar[int]
    SELECT_TOOL_FIELD_NUMBER: _ClassVar[int]
    SET_ALLOWED_PAIRS_FIELD_NUMBER: _ClassVar[int]
    SET_SPEED_FIELD_NUMBER: _ClassVar[int]
    WAIT_PART_FIELD_NUMBER: _ClassVar[int]
    REPEAT_FIELD_NUMBER: _ClassVar[int]
    CALL_FIELD_NUMBER: _ClassVar[int]
    PATTERN_FIELD_NUMBER: _ClassVar[int]
    PICK_AT_FIELD_NUMBER: _ClassVar[int]
    PLACE_AT_FIELD_NUMBER: _ClassVar[int]
    IF_SIGNAL_FIELD_NUMBER: _ClassVar[int]
    WHILE_SIGNAL_FIELD_NUMBER: _ClassVar[int]
    move: MoveStep
    set_signal: SetSignalStep
    wait_signal: WaitSignalStep
    dwell: DwellStep
    pick: _scene_pb2.PickPart
    place: _scene_pb2.PlacePart
    attach: _scene_pb2.AttachNode
    select_tool: _scene_pb2.SelectTool
    set_allowed_pairs: _collision_pb2.SetAllowedPairs
    set_speed: SetSpeedStep
    wait_part: WaitPartStep
    repeat: RepeatStep
    call: CallStep
    pattern: PatternStep
    pick_at: PickAtStep
    place_at: PlaceAtStep
    if_signal: IfStep
    while_signal: WhileStep
    def __init__(self, move: _Optional[_Union[MoveStep, _Mapping]] = ..., set_signal: _Optional[_Union[SetSignalStep, _Mapping]] = ..., wait_signal: _Optional[_Union[WaitSignalStep, _Mapping]] = ..., dwell: _Optional[_Union[DwellStep, _Mapping]] = ..., pick: _Optional[_Union[_scene_pb2.PickPart, _Mapping]] = ..., place: _Optional[_Union[_scene_pb2.PlacePart, _Mapping]] = ..., attach: _Optional[_Union[_scene_pb2.AttachNode, _Mapping]] = ..., select_tool: _Optional[_Union[_scene_pb2.SelectTool, _Mapping]] = ..., set_allowed_pairs: _Optional[_Union[_collision_pb2.SetAllowedPairs, _Mapping]] = ..., set_speed: _Optional[_Union[SetSpeedStep, _Mapping]] = ..., wait_part: _Optional[_Union[WaitPartStep, _Mapping]] = ..., repeat: _Optional[_Union[RepeatStep, _Mapping]] = ..., call: _Optional[_Union[CallStep, _Mapping]] = ..., pattern: _Optional[_Union[PatternStep, _Mapping]] = ..., pick_at: _Optional[_Union[PickAtStep, _Mapping]] = ..., place_at: _Optional[_Union[PlaceAtStep, _Mapping]] = ..., if_signal: _Optional[_Union[IfStep, _Mapping]] = ..., while_signal: _Optional[_Union[WhileStep, _Mapping]] = ...) -> None: ...

class SetSpeedStep(_message.Message):
    __slots__ = ("robot", "factor")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    FACTOR_FIELD_NUMBER: _ClassVar[int]
    robot: str
    factor: float
    def __init__(self, robot: _Optional[str] = ..., factor: _Optional[float] = ...) -> None: ...

class WaitPartStep(_message.Message):
    __slots__ = ("part", "reference", "position", "max_distance_meters", "timeout_seconds")
    PART_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    POSITION_FIELD_NUMBER: _ClassVar[int]
    MAX_DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    TIMEOUT_SECONDS_FIELD_NUMBER: _ClassVar[int]
    part: str
    reference: str
    position: _geometry_pb2.Vector3
    max_distance_meters: float
    timeout_seconds: float
    def __init__(self, part: _Optional[str] = ..., reference: _Optional[str] = ..., position: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., max_distance_meters: _Optional[float] = ..., timeout_seconds: _Optional[float] = ...) -> None: ...

class RepeatStep(_message.Message):
    __slots__ = ("count", "steps")
    COUNT_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    count: int
    steps: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    def __init__(self, count: _Optional[int] = ..., steps: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ...) -> None: ...

class IfStep(_message.Message):
    __slots__ = ("condition", "then", "otherwise")
    CONDITION_FIELD_NUMBER: _ClassVar[int]
    THEN_FIELD_NUMBER: _ClassVar[int]
    OTHERWISE_FIELD_NUMBER: _ClassVar[int]
    condition: SignalCondition
    then: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    otherwise: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    def __init__(self, condition: _Optional[_Union[SignalCondition, _Mapping]] = ..., then: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ..., otherwise: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ...) -> None: ...

class WhileStep(_message.Message):
    __slots__ = ("condition", "steps")
    CONDITION_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    condition: SignalCondition
    steps: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    def __init__(self, condition: _Optional[_Union[SignalCondition, _Mapping]] = ..., steps: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ...) -> None: ...

class CallStep(_message.Message):
    __slots__ = ("program",)
    PROGRAM_FIELD_NUMBER: _ClassVar[int]
    program: str
    def __init__(self, program: _Optional[str] = ...) -> None: ...

class PatternStep(_message.Message):
    __slots__ = ("name", "reference", "pattern", "steps")
    NAME_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    PATTERN_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    name: str
    reference: str
    pattern: Pattern
    steps: _containers.RepeatedCompositeFieldContainer[ProgramStep]
    def __init__(self, name: _Optional[str] = ..., reference: _Optional[str] = ..., pattern: _Optional[_Union[Pattern, _Mapping]] = ..., steps: _Optional[_Iterable[_Union[ProgramStep, _Mapping]]] = ...) -> None: ...

class Pattern(_message.Message):
    __slots__ = ("columns", "rows", "layers", "column_pitch_meters", "row_pitch_meters", "layer_pitch_meters", "reference_t_pattern", "layer_turn_radians", "layer_offset", "order")
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    LAYERS_FIELD_NUMBER: _ClassVar[int]
    COLUMN_PITCH_METERS_FIELD_NUMBER: _ClassVar[int]
    ROW_PITCH_METERS_FIELD_NUMBER: _ClassVar[int]
    LAYER_PITCH_METERS_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_T_PATTERN_FIELD_NUMBER: _ClassVar[int]
    LAYER_TURN_RADIANS_FIELD_NUMBER: _ClassVar[int]
    LAYER_OFFSET_FIELD_NUMBER: _ClassVar[int]
    ORDER_FIELD_NUMBER: _ClassVar[int]
    columns: int
    rows: int
    layers: int
    column_pitch_meters: float
    row_pitch_meters: float
    layer_pitch_meters: float
    reference_t_pattern: _geometry_pb2.Pose
    layer_turn_radians: float
    layer_offset: _geometry_pb2.Vector3
    order: PatternOrder
    def __init__(self, columns: _Optional[int] = ..., rows: _Optional[int] = ..., layers: _Optional[int] = ..., column_pitch_meters: _Optional[float] = ..., row_pitch_meters: _Optional[float] = ..., layer_pitch_meters: _Optional[float] = ..., reference_t_pattern: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., layer_turn_radians: _Optional[float] = ..., layer_offset: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., order: _Optional[_Union[PatternOrder, str]] = ...) -> None: ...

class PickAtStep(_message.Message):
    __slots__ = ("robot", "goal", "approach_meters", "retreat_meters", "state_before", "state", "part", "max_distance_meters", "speed_factor", "max_velocity_meters_per_second", "max_acceleration_meters_per_second_squared", "redundancy", "width_before_meters", "width_meters")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    GOAL_FIELD_NUMBER: _ClassVar[int]
    APPROACH_METERS_FIELD_NUMBER: _ClassVar[int]
    RETREAT_METERS_FIELD_NUMBER: _ClassVar[int]
    STATE_BEFORE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    PART_FIELD_NUMBER: _ClassVar[int]
    MAX_DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    REDUNDANCY_FIELD_NUMBER: _ClassVar[int]
    WIDTH_BEFORE_METERS_FIELD_NUMBER: _ClassVar[int]
    WIDTH_METERS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    goal: PoseGoal
    approach_meters: float
    retreat_meters: float
    state_before: str
    state: str
    part: str
    max_distance_meters: float
    speed_factor: float
    max_velocity_meters_per_second: float
    max_acceleration_meters_per_second_squared: float
    redundancy: _robot_pb2.Redundancy
    width_before_meters: float
    width_meters: float
    def __init__(self, robot: _Optional[str] = ..., goal: _Optional[_Union[PoseGoal, _Mapping]] = ..., approach_meters: _Optional[float] = ..., retreat_meters: _Optional[float] = ..., state_before: _Optional[str] = ..., state: _Optional[str] = ..., part: _Optional[str] = ..., max_distance_meters: _Optional[float] = ..., speed_factor: _Optional[float] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_acceleration_meters_per_second_squared: _Optional[float] = ..., redundancy: _Optional[_Union[_robot_pb2.Redundancy, _Mapping]] = ..., width_before_meters: _Optional[float] = ..., width_meters: _Optional[float] = ...) -> None: ...

class PlaceAtStep(_message.Message):
    __slots__ = ("robot", "goal", "approach_meters", "retreat_meters", "state_before", "state", "part", "parent", "speed_factor", "max_velocity_meters_per_second", "max_acceleration_meters_per_second_squared", "redundancy", "width_before_meters", "width_meters")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    GOAL_FIELD_NUMBER: _ClassVar[int]
    APPROACH_METERS_FIELD_NUMBER: _ClassVar[int]
    RETREAT_METERS_FIELD_NUMBER: _ClassVar[int]
    STATE_BEFORE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    PART_FIELD_NUMBER: _ClassVar[int]
    PARENT_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    REDUNDANCY_FIELD_NUMBER: _ClassVar[int]
    WIDTH_BEFORE_METERS_FIELD_NUMBER: _ClassVar[int]
    WIDTH_METERS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    goal: PoseGoal
    approach_meters: float
    retreat_meters: float
    state_before: str
    state: str
    part: str
    parent: str
    speed_factor: float
    max_velocity_meters_per_second: float
    max_acceleration_meters_per_second_squared: float
    redundancy: _robot_pb2.Redundancy
    width_before_meters: float
    width_meters: float
    def __init__(self, robot: _Optional[str] = ..., goal: _Optional[_Union[PoseGoal, _Mapping]] = ..., approach_meters: _Optional[float] = ..., retreat_meters: _Optional[float] = ..., state_before: _Optional[str] = ..., state: _Optional[str] = ..., part: _Optional[str] = ..., parent: _Optional[str] = ..., speed_factor: _Optional[float] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_acceleration_meters_per_second_squared: _Optional[float] = ..., redundancy: _Optional[_Union[_robot_pb2.Redundancy, _Mapping]] = ..., width_before_meters: _Optional[float] = ..., width_meters: _Optional[float] = ...) -> None: ...

class MoveStep(_message.Message):
    __slots__ = ("moves", "blend_distance_meters", "blend_percent", "blend_radius", "min_duration_seconds")
    MOVES_FIELD_NUMBER: _ClassVar[int]
    BLEND_DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    BLEND_PERCENT_FIELD_NUMBER: _ClassVar[int]
    BLEND_RADIUS_FIELD_NUMBER: _ClassVar[int]
    MIN_DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    moves: _containers.RepeatedCompositeFieldContainer[Move]
    blend_distance_meters: float
    blend_percent: float
    blend_radius: BlendRadius
    min_duration_seconds: float
    def __init__(self, moves: _Optional[_Iterable[_Union[Move, _Mapping]]] = ..., blend_distance_meters: _Optional[float] = ..., blend_percent: _Optional[float] = ..., blend_radius: _Optional[_Union[BlendRadius, _Mapping]] = ..., min_duration_seconds: _Optional[float] = ...) -> None: ...

class BlendRadius(_message.Message):
    __slots__ = ("radius_meters", "extended_radius_meters")
    RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    EXTENDED_RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    radius_meters: float
    extended_radius_meters: float
    def __init__(self, radius_meters: _Optional[float] = ..., extended_radius_meters: _Optional[float] = ...) -> None: ...

class SetSignalStep(_message.Message):
    __slots__ = ("signal", "value", "lead_seconds")
    SIGNAL_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    LEAD_SECONDS_FIELD_NUMBER: _ClassVar[int]
    signal: str
    value: _signal_pb2.SignalValue
    lead_seconds: float
    def __init__(self, signal: _Optional[str] = ..., value: _Optional[_Union[_signal_pb2.SignalValue, _Mapping]] = ..., lead_seconds: _Optional[float] = ...) -> None: ...

class SignalCondition(_message.Message):
    __slots__ = ("signal", "value", "comparison")
    SIGNAL_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    COMPARISON_FIELD_NUMBER: _ClassVar[int]
    signal: str
    value: _signal_pb2.SignalValue
    comparison: Comparison
    def __init__(self, signal: _Optional[str] = ..., value: _Optional[_Union[_signal_pb2.SignalValue, _Mapping]] = ..., comparison: _Optional[_Union[Comparison, str]] = ...) -> None: ...

class WaitSignalStep(_message.Message):
    __slots__ = ("condition", "timeout_seconds")
    CONDITION_FIELD_NUMBER: _ClassVar[int]
    TIMEOUT_SECONDS_FIELD_NUMBER: _ClassVar[int]
    condition: SignalCondition
    timeout_seconds: float
    def __init__(self, condition: _Optional[_Union[SignalCondition, _Mapping]] = ..., timeout_seconds: _Optional[float] = ...) -> None: ...

class DwellStep(_message.Message):
    __slots__ = ("seconds",)
    SECONDS_FIELD_NUMBER: _ClassVar[int]
    seconds: float
    def __init__(self, seconds: _Optional[float] = ...) -> None: ...

class Tracking(_message.Message):
    __slots__ = ("node", "window", "max_velocity")
    NODE_FIELD_NUMBER: _ClassVar[int]
    WINDOW_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    node: str
    window: float
    max_velocity: float
    def __init__(self, node: _Optional[str] = ..., window: _Optional[float] = ..., max_velocity: _Optional[float] = ...) -> None: ...

class Move(_message.Message):
    __slots__ = ("robot", "speed_factor", "time_law", "redundancy", "group", "acceleration_factor", "jerk_factor", "fixed_tool", "point_to_point", "linear", "joint_trajectory", "tool_state", "circular", "spline", "joint_jog", "cartesian_jog")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    TIME_LAW_FIELD_NUMBER: _ClassVar[int]
    REDUNDANCY_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    ACCELERATION_FACTOR_FIELD_NUMBER: _ClassVar[int]
    JERK_FACTOR_FIELD_NUMBER: _ClassVar[int]
    FIXED_TOOL_FIELD_NUMBER: _ClassVar[int]
    POINT_TO_POINT_FIELD_NUMBER: _ClassVar[int]
    LINEAR_FIELD_NUMBER: _ClassVar[int]
    JOINT_TRAJECTORY_FIELD_NUMBER: _ClassVar[int]
    TOOL_STATE_FIELD_NUMBER: _ClassVar[int]
    CIRCULAR_FIELD_NUMBER: _ClassVar[int]
    SPLINE_FIELD_NUMBER: _ClassVar[int]
    JOINT_JOG_FIELD_NUMBER: _ClassVar[int]
    CARTESIAN_JOG_FIELD_NUMBER: _ClassVar[int]
    robot: str
    speed_factor: float
    time_law: TimeLaw
    redundancy: _robot_pb2.Redundancy
    group: _nodes_pb2.GroupSelection
    acceleration_factor: float
    jerk_factor: float
    fixed_tool: str
    point_to_point: PointToPoint
    linear: Linear
    joint_trajectory: JointTrajectory
    tool_state: ToolStateMove
    circular: Circular
    spline: Spline
    joint_jog: JointJog
    cartesian_jog: CartesianJog
    def __init__(self, robot: _Optional[str] = ..., speed_factor: _Optional[float] = ..., time_law: _Optional[_Union[TimeLaw, str]] = ..., redundancy: _Optional[_Union[_robot_pb2.Redundancy, _Mapping]] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., acceleration_factor: _Optional[float] = ..., jerk_factor: _Optional[float] = ..., fixed_tool: _Optional[str] = ..., point_to_point: _Optional[_Union[PointToPoint, _Mapping]] = ..., linear: _Optional[_Union[Linear, _Mapping]] = ..., joint_trajectory: _Optional[_Union[JointTrajectory, _Mapping]] = ..., tool_state: _Optional[_Union[ToolStateMove, _Mapping]] = ..., circular: _Optional[_Union[Circular, _Mapping]] = ..., spline: _Optional[_Union[Spline, _Mapping]] = ..., joint_jog: _Optional[_Union[JointJog, _Mapping]] = ..., cartesian_jog: _Optional[_Union[CartesianJog, _Mapping]] = ...) -> None: ...

class PoseGoal(_message.Message):
    __slots__ = ("reference_t_tcp", "reference", "configuration", "moving")
    REFERENCE_T_TCP_FIELD_NUMBER: _ClassVar[int]
    REFERENCE_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATION_FIELD_NUMBER: _ClassVar[int]
    MOVING_FIELD_NUMBER: _ClassVar[int]
    reference_t_tcp: _geometry_pb2.Pose
    reference: str
    configuration: str
    moving: bool
    def __init__(self, reference_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., reference: _Optional[str] = ..., configuration: _Optional[str] = ..., moving: bool = ...) -> None: ...

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

class ActuatorGoal(_message.Message):
    __slots__ = ("actuator_positions",)
    class ActuatorPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    ACTUATOR_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    actuator_positions: _containers.ScalarMap[str, float]
    def __init__(self, actuator_positions: _Optional[_Mapping[str, float]] = ...) -> None: ...

class PointToPoint(_message.Message):
    __slots__ = ("joints", "pose", "posture", "actuators", "max_velocity_meters_per_second", "max_angular_velocity_radians_per_second")
    JOINTS_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    POSTURE_FIELD_NUMBER: _ClassVar[int]
    ACTUATORS_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ANGULAR_VELOCITY_RADIANS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    joints: JointGoal
    pose: PoseGoal
    posture: str
    actuators: ActuatorGoal
    max_velocity_meters_per_second: float
    max_angular_velocity_radians_per_second: float
    def __init__(self, joints: _Optional[_Union[JointGoal, _Mapping]] = ..., pose: _Optional[_Union[PoseGoal, _Mapping]] = ..., posture: _Optional[str] = ..., actuators: _Optional[_Union[ActuatorGoal, _Mapping]] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_angular_velocity_radians_per_second: _Optional[float] = ...) -> None: ...

class Linear(_message.Message):
    __slots__ = ("goal", "max_velocity_meters_per_second", "max_acceleration_meters_per_second_squared", "until", "max_angular_velocity_radians_per_second")
    GOAL_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    UNTIL_FIELD_NUMBER: _ClassVar[int]
    MAX_ANGULAR_VELOCITY_RADIANS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    goal: PoseGoal
    max_velocity_meters_per_second: float
    max_acceleration_meters_per_second_squared: float
    until: SignalCondition
    max_angular_velocity_radians_per_second: float
    def __init__(self, goal: _Optional[_Union[PoseGoal, _Mapping]] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_acceleration_meters_per_second_squared: _Optional[float] = ..., until: _Optional[_Union[SignalCondition, _Mapping]] = ..., max_angular_velocity_radians_per_second: _Optional[float] = ...) -> None: ...

class Spline(_message.Message):
    __slots__ = ("goals", "max_velocity_meters_per_second", "max_acceleration_meters_per_second_squared", "max_angular_velocity_radians_per_second")
    GOALS_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    MAX_ANGULAR_VELOCITY_RADIANS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    goals: _containers.RepeatedCompositeFieldContainer[PoseGoal]
    max_velocity_meters_per_second: float
    max_acceleration_meters_per_second_squared: float
    max_angular_velocity_radians_per_second: float
    def __init__(self, goals: _Optional[_Iterable[_Union[PoseGoal, _Mapping]]] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_acceleration_meters_per_second_squared: _Optional[float] = ..., max_angular_velocity_radians_per_second: _Optional[float] = ...) -> None: ...

class JointJog(_message.Message):
    __slots__ = ("joint", "velocity", "distance")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    joint: str
    velocity: float
    distance: float
    def __init__(self, joint: _Optional[str] = ..., velocity: _Optional[float] = ..., distance: _Optional[float] = ...) -> None: ...

class CartesianJog(_message.Message):
    __slots__ = ("translation", "rotation", "frame", "node", "velocity", "distance")
    TRANSLATION_FIELD_NUMBER: _ClassVar[int]
    ROTATION_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    translation: _geometry_pb2.Vector3
    rotation: _geometry_pb2.Vector3
    frame: JogFrame
    node: str
    velocity: float
    distance: float
    def __init__(self, translation: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., rotation: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., frame: _Optional[_Union[JogFrame, str]] = ..., node: _Optional[str] = ..., velocity: _Optional[float] = ..., distance: _Optional[float] = ...) -> None: ...

class Circular(_message.Message):
    __slots__ = ("goal", "via", "center", "orientation", "max_velocity_meters_per_second", "max_acceleration_meters_per_second_squared", "until", "max_angular_velocity_radians_per_second")
    GOAL_FIELD_NUMBER: _ClassVar[int]
    VIA_FIELD_NUMBER: _ClassVar[int]
    CENTER_FIELD_NUMBER: _ClassVar[int]
    ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ACCELERATION_METERS_PER_SECOND_SQUARED_FIELD_NUMBER: _ClassVar[int]
    UNTIL_FIELD_NUMBER: _ClassVar[int]
    MAX_ANGULAR_VELOCITY_RADIANS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    goal: PoseGoal
    via: _geometry_pb2.Vector3
    center: ArcCenter
    orientation: ArcOrientation
    max_velocity_meters_per_second: float
    max_acceleration_meters_per_second_squared: float
    until: SignalCondition
    max_angular_velocity_radians_per_second: float
    def __init__(self, goal: _Optional[_Union[PoseGoal, _Mapping]] = ..., via: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., center: _Optional[_Union[ArcCenter, _Mapping]] = ..., orientation: _Optional[_Union[ArcOrientation, str]] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_acceleration_meters_per_second_squared: _Optional[float] = ..., until: _Optional[_Union[SignalCondition, _Mapping]] = ..., max_angular_velocity_radians_per_second: _Optional[float] = ...) -> None: ...

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
    __slots__ = ("joint_names", "times", "positions", "velocities", "accelerations", "interpolation", "start_time_seconds", "path_tolerances", "goal_tolerances", "goal_time_tolerance_seconds")
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    TIMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    ACCELERATIONS_FIELD_NUMBER: _ClassVar[int]
    INTERPOLATION_FIELD_NUMBER: _ClassVar[int]
    START_TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PATH_TOLERANCES_FIELD_NUMBER: _ClassVar[int]
    GOAL_TOLERANCES_FIELD_NUMBER: _ClassVar[int]
    GOAL_TIME_TOLERANCE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    times: _geometry_pb2.NumericArray
    positions: _geometry_pb2.NumericArray
    velocities: _geometry_pb2.NumericArray
    accelerations: _geometry_pb2.NumericArray
    interpolation: TrajectoryInterpolation
    start_time_seconds: float
    path_tolerances: _containers.RepeatedCompositeFieldContainer[JointTolerance]
    goal_tolerances: _containers.RepeatedCompositeFieldContainer[JointTolerance]
    goal_time_tolerance_seconds: float
    def __init__(self, joint_names: _Optional[_Iterable[str]] = ..., times: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., velocities: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., accelerations: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., interpolation: _Optional[_Union[TrajectoryInterpolation, str]] = ..., start_time_seconds: _Optional[float] = ..., path_tolerances: _Optional[_Iterable[_Union[JointTolerance, _Mapping]]] = ..., goal_tolerances: _Optional[_Iterable[_Union[JointTolerance, _Mapping]]] = ..., goal_time_tolerance_seconds: _Optional[float] = ...) -> None: ...

class JointTolerance(_message.Message):
    __slots__ = ("joint", "position", "velocity")
    JOINT_FIELD_NUMBER: _ClassVar[int]
    POSITION_FIELD_NUMBER: _ClassVar[int]
    VELOCITY_FIELD_NUMBER: _ClassVar[int]
    joint: str
    position: float
    velocity: float
    def __init__(self, joint: _Optional[str] = ..., position: _Optional[float] = ..., velocity: _Optional[float] = ...) -> None: ...

class ToolStateMove(_message.Message):
    __slots__ = ("tool", "state", "width_meters")
    TOOL_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    WIDTH_METERS_FIELD_NUMBER: _ClassVar[int]
    tool: str
    state: str
    width_meters: float
    def __init__(self, tool: _Optional[str] = ..., state: _Optional[str] = ..., width_meters: _Optional[float] = ...) -> None: ...

class Motion(_message.Message):
    __slots__ = ("id", "robots", "phase", "progress", "planned_duration_seconds", "start_time_seconds", "end_reason", "end_cause", "step", "step_count", "search", "step_path", "deviations")
    ID_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    PHASE_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    PLANNED_DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    START_TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    END_REASON_FIELD_NUMBER: _ClassVar[int]
    END_CAUSE_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    STEP_COUNT_FIELD_NUMBER: _ClassVar[int]
    SEARCH_FIELD_NUMBER: _ClassVar[int]
    STEP_PATH_FIELD_NUMBER: _ClassVar[int]
    DEVIATIONS_FIELD_NUMBER: _ClassVar[int]
    id: str
    robots: _containers.RepeatedScalarFieldContainer[str]
    phase: MotionPhase
    progress: float
    planned_duration_seconds: float
    start_time_seconds: float
    end_reason: str
    end_cause: EndCause
    step: int
    step_count: int
    search: SearchResult
    step_path: str
    deviations: _containers.RepeatedCompositeFieldContainer[JointDeviation]
    def __init__(self, id: _Optional[str] = ..., robots: _Optional[_Iterable[str]] = ..., phase: _Optional[_Union[MotionPhase, str]] = ..., progress: _Optional[float] = ..., planned_duration_seconds: _Optional[float] = ..., start_time_seconds: _Optional[float] = ..., end_reason: _Optional[str] = ..., end_cause: _Optional[_Union[EndCause, str]] = ..., step: _Optional[int] = ..., step_count: _Optional[int] = ..., search: _Optional[_Union[SearchResult, _Mapping]] = ..., step_path: _Optional[str] = ..., deviations: _Optional[_Iterable[_Union[JointDeviation, _Mapping]]] = ...) -> None: ...

class JointDeviation(_message.Message):
    __slots__ = ("robot", "joint", "kind", "value", "tolerance")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    TOLERANCE_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint: str
    kind: DeviationKind
    value: float
    tolerance: float
    def __init__(self, robot: _Optional[str] = ..., joint: _Optional[str] = ..., kind: _Optional[_Union[DeviationKind, str]] = ..., value: _Optional[float] = ..., tolerance: _Optional[float] = ...) -> None: ...

class SearchResult(_message.Message):
    __slots__ = ("found", "joint_positions", "world_t_tcp", "time_seconds")
    class JointPositionsEntry(_message.Message):
        __slots__ = ("key", "value")
        KEY_FIELD_NUMBER: _ClassVar[int]
        VALUE_FIELD_NUMBER: _ClassVar[int]
        key: str
        value: float
        def __init__(self, key: _Optional[str] = ..., value: _Optional[float] = ...) -> None: ...
    FOUND_FIELD_NUMBER: _ClassVar[int]
    JOINT_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_TCP_FIELD_NUMBER: _ClassVar[int]
    TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    found: bool
    joint_positions: _containers.ScalarMap[str, float]
    world_t_tcp: _geometry_pb2.Pose
    time_seconds: float
    def __init__(self, found: bool = ..., joint_positions: _Optional[_Mapping[str, float]] = ..., world_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., time_seconds: _Optional[float] = ...) -> None: ...

class PlanNote(_message.Message):
    __slots__ = ("kind", "step", "robot", "wanted", "kept", "message", "step_path")
    KIND_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    WANTED_FIELD_NUMBER: _ClassVar[int]
    KEPT_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    STEP_PATH_FIELD_NUMBER: _ClassVar[int]
    kind: PlanNoteKind
    step: int
    robot: str
    wanted: float
    kept: float
    message: str
    step_path: str
    def __init__(self, kind: _Optional[_Union[PlanNoteKind, str]] = ..., step: _Optional[int] = ..., robot: _Optional[str] = ..., wanted: _Optional[float] = ..., kept: _Optional[float] = ..., message: _Optional[str] = ..., step_path: _Optional[str] = ...) -> None: ...

class StartMotionResponse(_message.Message):
    __slots__ = ("stamp", "motion", "notes")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    NOTES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motion: Motion
    notes: _containers.RepeatedCompositeFieldContainer[PlanNote]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ..., notes: _Optional[_Iterable[_Union[PlanNote, _Mapping]]] = ...) -> None: ...

class ReadProgramRequest(_message.Message):
    __slots__ = ("text", "uri", "spec", "flat")
    TEXT_FIELD_NUMBER: _ClassVar[int]
    URI_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    FLAT_FIELD_NUMBER: _ClassVar[int]
    text: str
    uri: str
    spec: MotionSpec
    flat: bool
    def __init__(self, text: _Optional[str] = ..., uri: _Optional[str] = ..., spec: _Optional[_Union[MotionSpec, _Mapping]] = ..., flat: bool = ...) -> None: ...

class ReadProgramResponse(_message.Message):
    __slots__ = ("spec", "step_paths")
    SPEC_FIELD_NUMBER: _ClassVar[int]
    STEP_PATHS_FIELD_NUMBER: _ClassVar[int]
    spec: MotionSpec
    step_paths: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, spec: _Optional[_Union[MotionSpec, _Mapping]] = ..., step_paths: _Optional[_Iterable[str]] = ...) -> None: ...

class PlanMotionRequest(_message.Message):
    __slots__ = ("spec", "sample_seconds", "expected_structure_revision", "plan", "motion_id")
    SPEC_FIELD_NUMBER: _ClassVar[int]
    SAMPLE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_STRUCTURE_REVISION_FIELD_NUMBER: _ClassVar[int]
    PLAN_FIELD_NUMBER: _ClassVar[int]
    MOTION_ID_FIELD_NUMBER: _ClassVar[int]
    spec: MotionSpec
    sample_seconds: float
    expected_structure_revision: int
    plan: PlanReference
    motion_id: str
    def __init__(self, spec: _Optional[_Union[MotionSpec, _Mapping]] = ..., sample_seconds: _Optional[float] = ..., expected_structure_revision: _Optional[int] = ..., plan: _Optional[_Union[PlanReference, _Mapping]] = ..., motion_id: _Optional[str] = ...) -> None: ...

class PlanMotionResponse(_message.Message):
    __slots__ = ("stamp", "duration_seconds", "times", "steps", "robots", "notes", "plan")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    TIMES_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    NOTES_FIELD_NUMBER: _ClassVar[int]
    PLAN_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    duration_seconds: float
    times: _geometry_pb2.NumericArray
    steps: _geometry_pb2.NumericArray
    robots: _containers.RepeatedCompositeFieldContainer[RobotTrajectory]
    notes: _containers.RepeatedCompositeFieldContainer[PlanNote]
    plan: PlanReference
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., duration_seconds: _Optional[float] = ..., times: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., steps: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., robots: _Optional[_Iterable[_Union[RobotTrajectory, _Mapping]]] = ..., notes: _Optional[_Iterable[_Union[PlanNote, _Mapping]]] = ..., plan: _Optional[_Union[PlanReference, _Mapping]] = ...) -> None: ...

class RobotTrajectory(_message.Message):
    __slots__ = ("robot", "joint_names", "positions", "velocities", "accelerations", "efforts", "world_t_tcp", "tcp_speeds", "groups")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    ACCELERATIONS_FIELD_NUMBER: _ClassVar[int]
    EFFORTS_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_TCP_FIELD_NUMBER: _ClassVar[int]
    TCP_SPEEDS_FIELD_NUMBER: _ClassVar[int]
    GROUPS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    velocities: _geometry_pb2.NumericArray
    accelerations: _geometry_pb2.NumericArray
    efforts: _geometry_pb2.NumericArray
    world_t_tcp: _geometry_pb2.NumericArray
    tcp_speeds: _geometry_pb2.NumericArray
    groups: _containers.RepeatedCompositeFieldContainer[GroupTrajectory]
    def __init__(self, robot: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., velocities: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., accelerations: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., efforts: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., world_t_tcp: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., tcp_speeds: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., groups: _Optional[_Iterable[_Union[GroupTrajectory, _Mapping]]] = ...) -> None: ...

class GroupTrajectory(_message.Message):
    __slots__ = ("group", "world_t_tcp", "tcp_speeds")
    GROUP_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_TCP_FIELD_NUMBER: _ClassVar[int]
    TCP_SPEEDS_FIELD_NUMBER: _ClassVar[int]
    group: _nodes_pb2.GroupSelection
    world_t_tcp: _geometry_pb2.NumericArray
    tcp_speeds: _geometry_pb2.NumericArray
    def __init__(self, group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., world_t_tcp: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., tcp_speeds: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CheckMotionRequest(_message.Message):
    __slots__ = ("spec", "min_singular_value", "ignore_collisions", "resolution_meters", "expected_structure_revision", "plan")
    SPEC_FIELD_NUMBER: _ClassVar[int]
    MIN_SINGULAR_VALUE_FIELD_NUMBER: _ClassVar[int]
    IGNORE_COLLISIONS_FIELD_NUMBER: _ClassVar[int]
    RESOLUTION_METERS_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_STRUCTURE_REVISION_FIELD_NUMBER: _ClassVar[int]
    PLAN_FIELD_NUMBER: _ClassVar[int]
    spec: MotionSpec
    min_singular_value: float
    ignore_collisions: bool
    resolution_meters: float
    expected_structure_revision: int
    plan: PlanReference
    def __init__(self, spec: _Optional[_Union[MotionSpec, _Mapping]] = ..., min_singular_value: _Optional[float] = ..., ignore_collisions: bool = ..., resolution_meters: _Optional[float] = ..., expected_structure_revision: _Optional[int] = ..., plan: _Optional[_Union[PlanReference, _Mapping]] = ...) -> None: ...

class Violation(_message.Message):
    __slots__ = ("kind", "step", "robot", "joint", "time_seconds", "path_fraction", "world_t_tcp", "value", "limit", "message", "first", "second", "first_point", "second_point", "step_path")
    KIND_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_FIELD_NUMBER: _ClassVar[int]
    TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PATH_FRACTION_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_TCP_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    LIMIT_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    FIRST_POINT_FIELD_NUMBER: _ClassVar[int]
    SECOND_POINT_FIELD_NUMBER: _ClassVar[int]
    STEP_PATH_FIELD_NUMBER: _ClassVar[int]
    kind: ViolationKind
    step: int
    robot: str
    joint: str
    time_seconds: float
    path_fraction: float
    world_t_tcp: _geometry_pb2.Pose
    value: float
    limit: float
    message: str
    first: str
    second: str
    first_point: _geometry_pb2.Vector3
    second_point: _geometry_pb2.Vector3
    step_path: str
    def __init__(self, kind: _Optional[_Union[ViolationKind, str]] = ..., step: _Optional[int] = ..., robot: _Optional[str] = ..., joint: _Optional[str] = ..., time_seconds: _Optional[float] = ..., path_fraction: _Optional[float] = ..., world_t_tcp: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., value: _Optional[float] = ..., limit: _Optional[float] = ..., message: _Optional[str] = ..., first: _Optional[str] = ..., second: _Optional[str] = ..., first_point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., second_point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., step_path: _Optional[str] = ...) -> None: ...

class CheckMotionResponse(_message.Message):
    __slots__ = ("stamp", "first_violation", "duration_seconds", "min_singular_value", "notes", "plan")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    FIRST_VIOLATION_FIELD_NUMBER: _ClassVar[int]
    DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    MIN_SINGULAR_VALUE_FIELD_NUMBER: _ClassVar[int]
    NOTES_FIELD_NUMBER: _ClassVar[int]
    PLAN_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    first_violation: Violation
    duration_seconds: float
    min_singular_value: float
    notes: _containers.RepeatedCompositeFieldContainer[PlanNote]
    plan: PlanReference
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., first_violation: _Optional[_Union[Violation, _Mapping]] = ..., duration_seconds: _Optional[float] = ..., min_singular_value: _Optional[float] = ..., notes: _Optional[_Iterable[_Union[PlanNote, _Mapping]]] = ..., plan: _Optional[_Union[PlanReference, _Mapping]] = ...) -> None: ...

class SetpointTarget(_message.Message):
    __slots__ = ("robot", "joint_names", "mode", "timeout_seconds", "busy_policy", "frame", "node", "group", "max_velocity_meters_per_second", "max_rotation_velocity_radians_per_second")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    TIMEOUT_SECONDS_FIELD_NUMBER: _ClassVar[int]
    BUSY_POLICY_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    MAX_VELOCITY_METERS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_ROTATION_VELOCITY_RADIANS_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    robot: str
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    mode: SetpointMode
    timeout_seconds: float
    busy_policy: BusyPolicy
    frame: JogFrame
    node: str
    group: _nodes_pb2.GroupSelection
    max_velocity_meters_per_second: float
    max_rotation_velocity_radians_per_second: float
    def __init__(self, robot: _Optional[str] = ..., joint_names: _Optional[_Iterable[str]] = ..., mode: _Optional[_Union[SetpointMode, str]] = ..., timeout_seconds: _Optional[float] = ..., busy_policy: _Optional[_Union[BusyPolicy, str]] = ..., frame: _Optional[_Union[JogFrame, str]] = ..., node: _Optional[str] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., max_velocity_meters_per_second: _Optional[float] = ..., max_rotation_velocity_radians_per_second: _Optional[float] = ...) -> None: ...

class StreamSetpointsRequest(_message.Message):
    __slots__ = ("target", "values")
    TARGET_FIELD_NUMBER: _ClassVar[int]
    VALUES_FIELD_NUMBER: _ClassVar[int]
    target: SetpointTarget
    values: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, target: _Optional[_Union[SetpointTarget, _Mapping]] = ..., values: _Optional[_Iterable[float]] = ...) -> None: ...

class StreamSetpointsResponse(_message.Message):
    __slots__ = ("stamp", "motion", "positions", "velocities", "setpoint_count", "held_by")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    SETPOINT_COUNT_FIELD_NUMBER: _ClassVar[int]
    HELD_BY_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motion: Motion
    positions: _containers.RepeatedScalarFieldContainer[float]
    velocities: _containers.RepeatedScalarFieldContainer[float]
    setpoint_count: int
    held_by: str
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ..., positions: _Optional[_Iterable[float]] = ..., velocities: _Optional[_Iterable[float]] = ..., setpoint_count: _Optional[int] = ..., held_by: _Optional[str] = ...) -> None: ...

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

class HoldMotionRequest(_message.Message):
    __slots__ = ("id", "sent_seconds")
    ID_FIELD_NUMBER: _ClassVar[int]
    SENT_SECONDS_FIELD_NUMBER: _ClassVar[int]
    id: str
    sent_seconds: float
    def __init__(self, id: _Optional[str] = ..., sent_seconds: _Optional[float] = ...) -> None: ...

class HoldMotionResponse(_message.Message):
    __slots__ = ("stamp", "motion")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motion: Motion
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

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

class WatchMotionStepsRequest(_message.Message):
    __slots__ = ("id", "max_rate_hertz")
    ID_FIELD_NUMBER: _ClassVar[int]
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    id: str
    max_rate_hertz: float
    def __init__(self, id: _Optional[str] = ..., max_rate_hertz: _Optional[float] = ...) -> None: ...

class WatchMotionStepsResponse(_message.Message):
    __slots__ = ("stamp", "events", "motion")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    EVENTS_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    events: _containers.RepeatedCompositeFieldContainer[ProgramStepEvent]
    motion: Motion
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., events: _Optional[_Iterable[_Union[ProgramStepEvent, _Mapping]]] = ..., motion: _Optional[_Union[Motion, _Mapping]] = ...) -> None: ...

class ProgramStepEvent(_message.Message):
    __slots__ = ("kind", "step", "step_path", "tick", "simulation_time_seconds")
    KIND_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    STEP_PATH_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    SIMULATION_TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    kind: ProgramStepEventKind
    step: int
    step_path: str
    tick: int
    simulation_time_seconds: float
    def __init__(self, kind: _Optional[_Union[ProgramStepEventKind, str]] = ..., step: _Optional[int] = ..., step_path: _Optional[str] = ..., tick: _Optional[int] = ..., simulation_time_seconds: _Optional[float] = ...) -> None: ...

class WatchMotionsRequest(_message.Message):
    __slots__ = ("max_rate_hertz",)
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    max_rate_hertz: float
    def __init__(self, max_rate_hertz: _Optional[float] = ...) -> None: ...

class WatchMotionsResponse(_message.Message):
    __slots__ = ("stamp", "motions", "speed_factor")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    MOTIONS_FIELD_NUMBER: _ClassVar[int]
    SPEED_FACTOR_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    motions: _containers.RepeatedCompositeFieldContainer[Motion]
    speed_factor: float
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., motions: _Optional[_Iterable[_Union[Motion, _Mapping]]] = ..., speed_factor: _Optional[float] = ...) -> None: ...

class PauseMotionRequest(_message.Message):
    __slots__ = ("id",)
    ID_FIELD_NUMBER: _ClassVar[int]
    id: str
    def __init__(self, id: _Optional[str] = ...) -> None: ...

class PauseMotionResponse(_message.Message):
    __slots__ = ("motion", "stamp")
    MOTION_FIELD_NUMBER: _ClassVar[int]
    STAMP_FIELD_NUMBER: _ClassVar[int]
    motion: Motion
    stamp: _geometry_pb2.Stamp
    def __init__(self, motion: _Optional[_Union[Motion, _Mapping]] = ..., stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ...) -> None: ...

class ResumeMotionRequest(_message.Message):
    __slots__ = ("id",)
    ID_FIELD_NUMBER: _ClassVar[int]
    id: str
    def __init__(self, id: _Optional[str] = ...) -> None: ...

class ResumeMotionResponse(_message.Message):
    __slots__ = ("motion", "stamp")
    MOTION_FIELD_NUMBER: _ClassVar[int]
    STAMP_FIELD_NUMBER: _ClassVar[int]
    motion: Motion
    stamp: _geometry_pb2.Stamp
    def __init__(self, motion: _Optional[_Union[Motion, _Mapping]] = ..., stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ...) -> None: ...

class StepMotionRequest(_message.Message):
    __slots__ = ("id",)
    ID_FIELD_NUMBER: _ClassVar[int]
    id: str
    def __init__(self, id: _Optional[str] = ...) -> None: ...

class StepMotionResponse(_message.Message):
    __slots__ = ("motion", "stamp")
    MOTION_FIELD_NUMBER: _ClassVar[int]
    STAMP_FIELD_NUMBER: _ClassVar[int]
    motion: Motion
    stamp: _geometry_pb2.Stamp
    def __init__(self, motion: _Optional[_Union[Motion, _Mapping]] = ..., stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ...) -> None: ...

class CancelMotionRequest(_message.Message):
    __slots__ = ("id", "reason")
    ID_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    id: str
    reason: str
    def __init__(self, id: _Optional[str] = ..., reason: _Optional[str] = ...) -> None: ...

class CancelMotionResponse(_message.Message):
    __slots__ = ("motion", "stamp")
    MOTION_FIELD_NUMBER: _ClassVar[int]
    STAMP_FIELD_NUMBER: _ClassVar[int]
    motion: Motion
    stamp: _geometry_pb2.Stamp
    def __init__(self, motion: _Optional[_Union[Motion, _Mapping]] = ..., stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ...) -> None: ...

class StopRequest(_message.Message):
    __slots__ = ("robots",)
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    robots: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, robots: _Optional[_Iterable[str]] = ...) -> None: ...

class StopResponse(_message.Message):
    __slots__ = ("motions", "stamp")
    MOTIONS_FIELD_NUMBER: _ClassVar[int]
    STAMP_FIELD_NUMBER: _ClassVar[int]
    motions: _containers.RepeatedCompositeFieldContainer[Motion]
    stamp: _geometry_pb2.Stamp
    def __init__(self, motions: _Optional[_Iterable[_Union[Motion, _Mapping]]] = ..., stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ...) -> None: ...
