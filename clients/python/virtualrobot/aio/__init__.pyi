"""Types of the client library for programs that use asyncio.

Written by tools/generate_aio.py from the library; run it again instead of changing this file.
"""
# ruff: noqa
# pyright: reportIncompatibleMethodOverride=false, reportGeneralTypeIssues=false

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager

from virtualrobot.aio.faces import Face as Face
from virtualrobot.aio.orders import Order as Order
from collections.abc import Callable as Callable
from collections.abc import Iterable as Iterable
from collections.abc import Iterator as Iterator
from collections.abc import Mapping as Mapping
from collections.abc import Sequence as Sequence
from datetime import datetime as datetime
from numpy import float64 as float64
from numpy.typing import NDArray as NDArray
from numpy import uint8 as uint8
from pathlib import Path as Path
from typing import Any as Any
from typing import Unpack as Unpack
from virtualrobot._wire.arguments import ArrayLike as ArrayLike
from virtualrobot._wire.arguments import Count as Count
from virtualrobot._wire.arguments import PoseLike as PoseLike
from virtualrobot._wire.arguments import Text as Text
from virtualrobot._wire.signal_values import GivenValue as GivenValue
from virtualrobot._wire.signal_values import SignalValue as SignalValue
from virtualrobot.cell import CellStop as CellStop
from virtualrobot.clock import ClockState as ClockState
from virtualrobot.clock import Observation as Observation
from virtualrobot.collisions.allowed_pairs import AllowedPair as AllowedPair
from virtualrobot.collisions.allowed_pairs import SampledPair as SampledPair
from virtualrobot.collisions.collisions import Check as Check
from virtualrobot.collisions.collisions import Configurations as Configurations
from virtualrobot.collisions.collisions import Distance as Distance
from virtualrobot.collisions.configurations import ConfigurationsCheck as ConfigurationsCheck
from virtualrobot.collisions.meshes import CollisionMesh as CollisionMesh
from virtualrobot.collisions.settings import CollisionOptions as CollisionOptions
from virtualrobot.collisions.settings import CollisionSettings as CollisionSettings
from virtualrobot.collisions.settings import GuardCost as GuardCost
from virtualrobot.collisions.watch import CollisionReport as CollisionReport
from virtualrobot.connection import KernelInfo as KernelInfo
from virtualrobot.drivers import DriverJoint as DriverJoint
from virtualrobot.drivers import DriverStatus as DriverStatus
from virtualrobot.errors import VirtualRobotError as VirtualRobotError
from virtualrobot.files.assets import Upload as Upload
from virtualrobot.files.scene_files import Export as Export
from virtualrobot.files.scene_files import FileWarning as FileWarning
from virtualrobot.geometry import Matrix as Matrix
from virtualrobot.history.values import Checkpoint as Checkpoint
from virtualrobot.history.values import Step as Step
from virtualrobot.leases import LeaseInfo as LeaseInfo
from virtualrobot.motions.motion import StartOptions as StartOptions
from virtualrobot.motions.motion import Tracking as Tracking
from virtualrobot.motions.moves import CartesianOptions as CartesianOptions
from virtualrobot.motions.moves import CircularOptions as CircularOptions
from virtualrobot.motions.moves import JogOptions as JogOptions
from virtualrobot.motions.moves import LinearOptions as LinearOptions
from virtualrobot.motions.moves import Move as Move
from virtualrobot.motions.moves import MoveOptions as MoveOptions
from virtualrobot.motions.moves import PointToPointOptions as PointToPointOptions
from virtualrobot.motions.moves import TrajectoryOptions as TrajectoryOptions
from virtualrobot.motions.moves import Until as Until
from virtualrobot.motions.paths import PathProgress as PathProgress
from virtualrobot.motions.paths import ToolPathOptions as ToolPathOptions
from virtualrobot.motions.plans import CheckOptions as CheckOptions
from virtualrobot.motions.plans import MotionCheck as MotionCheck
from virtualrobot.motions.plans import MotionPlan as MotionPlan
from virtualrobot.motions.plans import PlanOptions as PlanOptions
from virtualrobot.motions.plans import ShownPlan as ShownPlan
from virtualrobot.motions.proposals import Proposal as Proposal
from virtualrobot.motions.proposals import ProposalChange as ProposalChange
from virtualrobot.motions.setpoints import Setpoint as Setpoint
from virtualrobot.motions.setpoints import StreamState as StreamState
from virtualrobot.motions.state import MotionState as MotionState
from virtualrobot.motions.state import Phase as Phase
from virtualrobot.motions.state import PlanNote as PlanNote
from virtualrobot.motions.state import ProgramStepEvent as ProgramStepEvent
from virtualrobot.motions.state import Search as Search
from virtualrobot.motions.steps import Named as Named
from virtualrobot.motions.steps import NodeNamed as NodeNamed
from virtualrobot.motions.steps import Pattern as Pattern
from virtualrobot.motions.steps import PickAtOptions as PickAtOptions
from virtualrobot.motions.steps import PlaceAtOptions as PlaceAtOptions
from virtualrobot.motions.tool_paths import ExternalMotion as ExternalMotion
from virtualrobot.motions.tool_paths import Floats as Floats
from virtualrobot.motions.tool_paths import PartnerMotion as PartnerMotion
from virtualrobot.motions.tool_paths import ToolPathPartner as ToolPathPartner
from virtualrobot.motions.tool_paths import ToolPathProgress as ToolPathProgress
from virtualrobot.physics import JointMotor as JointMotor
from virtualrobot.physics import PhysicsStatus as PhysicsStatus
from virtualrobot.plugins import Component as Component
from virtualrobot.plugins import Plugin as Plugin
from virtualrobot.progress import OnProgress as OnProgress
from virtualrobot.recording.recording import Recorded as Recorded
from virtualrobot.recording.start import RecordingOptions as RecordingOptions
from virtualrobot.records import Record as Record
from virtualrobot.records import RecordChange as RecordChange
from virtualrobot.records import Wish as Wish
from virtualrobot.robots.calibration import BaseCalibration as BaseCalibration
from virtualrobot.robots.calibration import JointCalibration as JointCalibration
from virtualrobot.robots.calibration import ToolCalibration as ToolCalibration
from virtualrobot.robots.denavit_hartenberg import Row as Row
from virtualrobot.robots.dynamics import Inertial as Inertial
from virtualrobot.robots.dynamics import InverseDynamics as InverseDynamics
from virtualrobot.robots.dynamics import Samples as Samples
from virtualrobot.robots.kinematics_check import KinematicsCheck as KinematicsCheck
from virtualrobot.robots.mechanism import JointPositions as JointPositions
from virtualrobot.robots.models import KnownModel as KnownModel
from virtualrobot.robots.mover import _CartesianStart as _CartesianStart
from virtualrobot.robots.mover import _CircularStart as _CircularStart
from virtualrobot.robots.mover import _JogStart as _JogStart
from virtualrobot.robots.mover import _LinearStart as _LinearStart
from virtualrobot.robots.mover import _MoveStart as _MoveStart
from virtualrobot.robots.mover import _PointToPointStart as _PointToPointStart
from virtualrobot.robots.mover import _TrajectoryStart as _TrajectoryStart
from virtualrobot.robots.odometry import Floats as virtualrobot_robots_odometry_Floats
from virtualrobot.robots.odometry import OdometryReading as OdometryReading
from virtualrobot.robots.redundancy import Lock as Lock
from virtualrobot.robots.redundancy import Prefer as Prefer
from virtualrobot.robots.values import Actuator as Actuator
from virtualrobot.robots.values import ForwardSolution as ForwardSolution
from virtualrobot.robots.values import InverseSolution as InverseSolution
from virtualrobot.robots.values import Jacobians as Jacobians
from virtualrobot.robots.values import JointGroup as JointGroup
from virtualrobot.robots.values import JointLimits as JointLimits
from virtualrobot.robots.values import LinkPair as LinkPair
from virtualrobot.robots.values import PointSolution as PointSolution
from virtualrobot.robots.values import RobotState as RobotState
from virtualrobot.robots.ways import Floats as virtualrobot_robots_ways_Floats
from virtualrobot.scene.editor import SignalOptions as SignalOptions
from virtualrobot.scene.figures import Figure as Figure
from virtualrobot.scene.figures import Figures as Figures
from virtualrobot.scene.node import NodeInfo as NodeInfo
from virtualrobot.scene.scene import LoadOptions as LoadOptions
from virtualrobot.scene.scene import SceneChange as SceneChange
from virtualrobot.sensors.cameras import CameraSettings as CameraSettings
from virtualrobot.sensors.cameras import LightSettings as LightSettings
from virtualrobot.sensors.contact_sensors import ContactSensorSettings as ContactSensorSettings
from virtualrobot.sensors.motion_sensors import EncoderReading as EncoderReading
from virtualrobot.sensors.motion_sensors import MotionSensorSettings as MotionSensorSettings
from virtualrobot.sensors.range_sensors import RangeSensorSettings as RangeSensorSettings
from virtualrobot.sensors.rays import RayCasterComparison as RayCasterComparison
from virtualrobot.sensors.rays import RayHits as RayHits
from virtualrobot.sensors.readings import ComponentTrial as ComponentTrial
from virtualrobot.sensors.readings import Reading as Reading
from virtualrobot.sensors.readings import SensorPreset as SensorPreset
from virtualrobot.sensors.readings import SensorStatus as SensorStatus
from virtualrobot.sensors.sensors import ReadingOptions as ReadingOptions
from virtualrobot.signals import Signal as Signal
from virtualrobot.signals import SignalChange as SignalChange
from virtualrobot.stepping import Event as Event
from virtualrobot.stepping import Values as Values
from virtualrobot.streams.sample import Sample as Sample
from virtualrobot.streams.scans import ScanGeometry as ScanGeometry
from virtualrobot.streams.table import Stream as Stream
from virtualrobot.tasks import ProgramTask as ProgramTask
from virtualrobot.tokens import NewToken as NewToken
from virtualrobot.tokens import TokenInfo as TokenInfo
from virtualrobot.view.coats import CoatHandle as CoatHandle
from virtualrobot.view.ghosts import Ghost as Ghost
from virtualrobot.view.ghosts import Positions as Positions
from virtualrobot.view.measuring import Measure as Measure
from virtualrobot.view.measuring import Place as Place
from virtualrobot.view.pictures import Camera as Camera
from virtualrobot.view.pictures import Picked as Picked
from virtualrobot.view.pictures import Picture as Picture
from virtualrobot.view.pictures import Size as Size
from virtualrobot.view.state import SensorOverlay as SensorOverlay
from virtualrobot.view.state import ViewState as ViewState
from virtualrobot.view.view import Vector as Vector

class Cell(Face):
    """The cell of one kernel: all its robots, simulated and real ones."""
    def stop(self, reason: Text = ...) -> Order[None]:
        """Bring all robots to rest on their paths, and refuse all motions until the cell is released."""
    @property
    def stopped(self) -> Order[CellStop | None]:
        """The stop of the cell; None while nobody has stopped it."""
    def watch(self) -> AsyncIterator[CellStop | None]:
        """Yield the stop of the cell, None while there is none: at once, and then whenever that changes."""
    def release(self) -> Order[None]:
        """End a stop; nothing moves by that, and each real robot is set to `execute` again by its own call."""

class Clock(Face):
    """The clock of one kernel."""
    def read(self) -> Order[ClockState]:
        """Return how time runs now."""
    def watch(self, max_rate: float | None = ...) -> AsyncIterator[ClockState]:
        """Yield how time runs, now, at each change of mode, and `max_rate` (1 by default) times a second."""
    @property
    def mode(self) -> Order[str]:
        """Mode of the simulation clock: `realtime` or `stepped`."""
    @property
    def simulation_time(self) -> Order[float]:
        """Seconds of simulation time."""
    @property
    def real_time_factor(self) -> Order[float]:
        """Simulated seconds for each second of the wall clock that were reached lately."""
    @property
    def speed_factor(self) -> Order[float]:
        """Simulated seconds for each second of the wall clock that are aimed at; set it for REALTIME."""
    def set_speed_factor(self, value: float) -> Order[None]:
        """Set `speed_factor`: Simulated seconds for each second of the wall clock that are aimed at; set it for REALTIME."""
    def set_realtime(self, speed_factor: float = ...) -> Order[ClockState]:
        """Let time follow the wall clock times a factor of 0.01 to 100."""
    def set_stepped(self) -> Order[ClockState]:
        """Let time go on only by `step`."""
    def hold_stepped(self) -> Order[ClockHold]:
        """Let time go on only by `step` for as long as this program lives, and as before at the end of the block."""
    def step(self, ticks: Count = ..., *, twists: Mapping[str, Values] | None = ..., positions: Mapping[str, Values] | None = ..., velocities: Mapping[str, Values] | None = ..., signals: Mapping[str, GivenValue] | None = ..., changes: Batch | None = ..., until: Iterable[Event] | None = ..., sensors: Iterable[str] | None = ..., setpoint_timeout: float = ..., preempt: bool = ..., **options: Unpack[ReadingOptions]) -> Order[Observation]:
        """Set what is given, let time go on by some ticks, and return the state after the last one: in one call."""
    def seek(self, simulation_time: float) -> Order[ClockState]:
        """Go to a moment of a replay (`virtualrobot replay`), back or forth; return the clock there."""
    def run(self, *motions: Motion, timeout: float | None = ...) -> Order[ClockState]:
        """Let time go on by steps until these motions have ended; return the clock as it is then."""

class ClockHold(Face):
    """Time that goes on by steps alone for as long as this program holds it; `Clock.hold_stepped` makes one."""
    def close(self) -> Order[None]:
        """Let time go on as before; may be called again."""
    async def __aenter__(self) -> ClockHold: ...

class Client(Face):
    """A connection to one kernel; a context manager. `virtualrobot.connect` makes it."""
    address: str
    info: KernelInfo
    scene: Scene
    robots: Robots
    signals: Signals
    clock: Clock
    cell: Cell
    view: View
    assets: Assets
    plugins: Plugins
    physics: Physics
    rays: Rays
    collisions: Collisions
    sensors: Sensors
    streams: Streams
    paths: Paths
    proposals: Proposals
    records: Records
    tasks: Tasks
    history: History
    tokens: Tokens
    drivers: Drivers
    def robot(self, name: str) -> Order[Robot]:
        """Return the robot of this name, as `robots[name]` does."""
    @property
    def targets(self) -> Order[dict[str, Target]]:
        """The targets of the scene by name: places that robots were taught; see `Robot.teach`."""
    def load_robot(self, file: str | Path, **options: Unpack[LoadOptions]) -> Order[Robot]:
        """Load a robot from a model file and return it; as `Scene.load` does."""
    def load_denavit_hartenberg(self, rows: Iterable[Row], *, convention: str, name: str | None = ..., pose: PoseLike | None = ..., parent: str = ..., base_t_first: PoseLike | None = ..., last_t_flange: PoseLike | None = ..., request_id: str | None = ...) -> Order[Robot]:
        """Make a serial arm of a Denavit-Hartenberg table and return it."""
    def models(self, search: Text | None = ..., *, maker: Text | None = ...) -> Order[list[KnownModel]]:
        """Return the models of robots and grippers that the kernel knows by name."""
    def move_together(self, moves: Iterable[Move], **options: Unpack[StartOptions]) -> Order[Motion]:
        """Move several robots so that they start and end together."""
    def plan(self, moves: Iterable[Move] | Motion, *, tracking: Tracking | None = ..., **options: Unpack[PlanOptions]) -> Order[MotionPlan]:
        """Return what moves that start and end together would do, or what a motion that runs will do. Nothing moves."""
    def check(self, moves: Iterable[Move], *, tracking: Tracking | None = ..., **options: Unpack[CheckOptions]) -> Order[MotionCheck]:
        """Return whether moves that go together keep all limits and touch nothing, and else what they violate first."""
    def check_plan(self, planned: ShownPlan, **options: Unpack[CheckOptions]) -> Order[MotionCheck]:
        """Return whether a plan that was shown keeps all limits and touches nothing, as `check` does of moves."""
    def start_plan(self, planned: ShownPlan, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Start a plan as `plan` has shown it, or as it was checked, without planning again."""
    def program(self, text: str | None = ...) -> Program:
        """Return an empty program: moves of several robots, signals, waits and dwells, one after the other."""
    def read_program(self, file: str | Path) -> Order[Program]:
        """Return what a program file (YAML) says, to be started."""
    def motions(self, running_only: bool = ...) -> Order[list[Motion]]:
        """Return the motions that run, whoever started them; with False also the last ones that ended."""
    def watch_motions(self, max_rate: float | None = ...) -> AsyncIterator[list[Motion]]:
        """Yield the motions that run, whoever started them, and whenever that changes those and what has ended since."""
    def record(self, path: str | Path, *, duration: float, told: Callable[[Recording], None] | None = ..., **options: Unpack[RecordingOptions]) -> Order[Recorded]:
        """Record so much simulation time (s) to a file, and return what is in it."""
    def start_recording(self, path: str | Path, *, duration: float | None = ..., **options: Unpack[RecordingOptions]) -> Order[Recording]:
        """Begin to record while the program goes on; the end of the block makes the file whole."""
    def stop(self, *robots: Named) -> Order[list[Motion]]:
        """Cancel every motion, or every motion of these robots; return them. `client.cell.stop` lets none start."""
    def lease(self, *robots: Named, take: bool = ..., owner: str | None = ...) -> Order[Lease]:
        """Lease robots, all or none, so that nobody but this client moves them; return the lease, a context manager."""
    def leases(self) -> Order[list[LeaseInfo]]:
        """Return who has leased which robots, oldest lease first."""
    def watch_leases(self) -> AsyncIterator[list[LeaseInfo]]:
        """Yield who has leased which robots, oldest lease first, now and after each change."""
    def undo(self, number: int | None = ..., *, mine: bool = ...) -> Order[Step]:
        """Take back the newest edit that stands, of anybody or only of this client; as `History.undo` does."""
    def redo(self, number: int | None = ..., *, mine: bool = ...) -> Order[Step]:
        """Do again what was undone last, as `History.redo` does."""
    @property
    def speed_factor(self) -> Order[float]:
        """Factor by which all motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
    def set_speed_factor(self, value: float) -> Order[None]:
        """Set `speed_factor`: Factor by which all motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
    def report(self, path: str | Path, max_journal_bytes: int | None = ...) -> Order[Path]:
        """Write what a report of a fault needs to a zip archive, and return its path."""
    def shutdown(self) -> Order[None]:
        """End the kernel."""
    def close(self) -> Order[None]:
        """Close the connection; motions that this client watched are cancelled by the kernel after a second."""
    async def __aenter__(self) -> Client: ...

class Drivers(Face):
    """The drivers of one kernel: connections to the real robots whose twins are in its world."""
    def connect(self, robot: str, component: str, settings: Mapping[str, object] | None = ..., *, joints: Sequence[DriverJoint] = ..., lead: float | None = ..., following_warning: float | None = ..., following_limit: float | None = ..., without_watchdog: bool = ...) -> Order[DriverStatus]:
        """Connect a robot's driver to its controller; nothing moves. Return how it is."""
    def disconnect(self, robot: str) -> Order[None]:
        """End a robot's driver; a robot that moves is stopped first, and the twin stays where it is."""
    def set_mode(self, robot: str, mode: str) -> Order[DriverStatus]:
        """Choose how a robot and its twin go together; return how the driver is."""
    def reset(self, robot: str) -> Order[DriverStatus]:
        """Clear a fault at the controller, where that helps, and connect again; nothing moves before `set_mode`."""
    def list(self) -> Order[list[DriverStatus]]:
        """Return all drivers as they are, by the names of their robots."""
    def __getitem__(self, robot: str) -> Order[DriverStatus]:
        """Return the driver of a robot as it is; raise UnknownNameError where it has none."""
    def watch(self, max_rate: float | None = ...) -> AsyncIterator[list[DriverStatus]]:
        """Yield all drivers again and again, at most `max_rate` (30 by default) times a second."""

class Lease(Face):
    """Robots that only this client can move, until the lease is released; a context manager."""
    @property
    def id(self) -> str:
        """The name of the lease, for people and logs."""
    @property
    def robots(self) -> tuple[str, ...]:
        """The robots that it is for now; none once it has ended."""
    @property
    def owner(self) -> str:
        """Owner of the lease, in words."""
    @property
    def since(self) -> datetime:
        """Begin of the lease, by the kernel's wall clock."""
    @property
    def lost(self) -> str:
        """Reason for which it has lost robots, such as who took them; empty while it has all of them."""
    def wait_for_loss(self, timeout: float | None = ...) -> Order[str]:
        """Wait until it has lost robots, for at most `timeout` seconds; return why, or nothing when it has not."""
    def release(self) -> Order[None]:
        """Give the robots back; motions that run go on. Does nothing when the lease has ended already."""
    async def __aenter__(self) -> Lease: ...

class Physics(Face):
    """Handle of the physics of one kernel."""
    def set(self, engine: str | None = ..., *, engine_settings: Mapping[str, object] | None = ..., gravity: ArrayLike | None = ..., substeps: int | None = ...) -> Order[None]:
        """Change how forces move parts that are dynamic; what is not given stays. Saved with the scene."""
    def enable(self, *names: str) -> Order[None]:
        """Let parts and robots move by forces; a robot's motions command its motors then."""
    def disable(self, *names: str) -> Order[None]:
        """Let parts stay where they are, and go with what they hang on; let robots move by their motions alone."""
    def motors(self, robot: str) -> Order[dict[str, JointMotor]]:
        """Return the motors of a robot's joints that are not the usual ones, by joint."""
    def set_motors(self, robot: str, motors: Mapping[str, JointMotor]) -> Order[None]:
        """Choose the motors of some of a robot's joints; other joints keep theirs."""
    def set_efforts(self, robot: str, efforts: Mapping[str, float]) -> Order[None]:
        """Set what motors of the mode `effort` exert from now on, by joint: N m or N; others keep theirs."""
    @property
    def status(self) -> Order[PhysicsStatus]:
        """Settings, fault, what moves and what touches."""

class Plugins(Face):
    """The plugins of one kernel; it can be iterated over. Each question is asked anew."""
    def list(self) -> Order[tuple[Plugin, ...]]:
        """Return all plugins that are installed, by name, those that failed included."""
    def reload(self) -> Order[tuple[Plugin, ...]]:
        """Look for plugins again, so that one installed since the kernel's start is found; return all."""
    def components(self, kind: str = ...) -> Order[tuple[Component, ...]]:
        """Return the components of all plugins, or those of one kind, such as `kinematics`."""
    def __aiter__(self) -> Plugins: ...
    async def __anext__(self) -> Plugin: ...

class Records(Face):
    """The records of one kernel, which all of its clients share."""
    def list(self, *kinds: str) -> Order[list[Record]]:
        """Return the records of some kinds, or all, oldest first: 100 at most, until the kernel ends."""
    def get(self, id: str) -> Order[Record]:
        """Return a record as it is now."""
    def create(self, kind: str, content: Any = ..., *, title: Text = ..., state: Text = ..., wishes: Iterable[str] = ..., keep: bool = ..., is_over: bool = ...) -> Order[Record]:
        """Make a record and return it."""
    def update(self, seen: Record | str, content: Any = ..., *, title: Text | None = ..., state: Text | None = ..., wishes: Iterable[str] | None = ..., keep: bool | None = ..., is_over: bool | None = ...) -> Order[Record]:
        """Change what is given of a record, leave the rest, and return it; arguments and errors are those of `create`."""
    def wish(self, seen: Record | str, word: str, text: Text = ...) -> Order[None]:
        """Tell the client that holds a record to do something; `seen` as of `update`."""
    def hold(self, seen: Record | str) -> Order[RecordHold]:
        """Hold a record, and return the wishes that are filed, a context manager; it is held when this returns."""
    def forget(self, seen: Record | str) -> Order[None]:
        """Have the kernel forget a record; `seen` as of `update`."""
    def watch(self, *kinds: str) -> Order[RecordWatch]:
        """Return a watch of the records of some kinds, or of all, a context manager."""

class RecordHold(Face):
    """Wishes of a record as they are filed, none lost; it is held until this is closed, which any thread may do."""
    def close(self) -> Order[None]:
        """Let the record go."""
    async def __aenter__(self) -> RecordHold: ...
    def __aiter__(self) -> RecordHold: ...
    async def __anext__(self) -> Wish: ...

class RecordWatch(Face):
    """Changes of records as they come, until it is closed, which any thread may do."""
    def close(self) -> Order[None]:
        """End it; whoever waits for a change comes to the end."""
    async def __aenter__(self) -> RecordWatch: ...
    def __aiter__(self) -> RecordWatch: ...
    async def __anext__(self) -> RecordChange: ...

class Tasks(Face):
    """The programs at work that clients of one kernel tell of, whoever runs them."""
    def list(self) -> Order[list[ProgramTask]]:
        """Return those that are at work, and the last ones that have ended, oldest first."""
    def get(self, task: str) -> Order[ProgramTask]:
        """Return a task by its record's name, or by its own: of several that of the one at work."""
    def stop(self, task: str) -> Order[None]:
        """Have a program stop before its next statement, and its robot brake on its path; errors as of `get`."""
    def answer(self, task: str, text: Text) -> Order[None]:
        """Answer what a program asks on its pendant; errors as of `stop`."""
    def watch(self) -> AsyncIterator[list[ProgramTask]]:
        """Yield those tasks that are new or have changed, all at first, until the iterator is closed."""

class Signals(Face):
    """The signals of one kernel, like a dictionary of names to values."""
    def __getitem__(self, name: str) -> Order[SignalValue]:
        """Return the value of a signal."""
    def create(self, name: str, value: GivenValue = ..., **options: Unpack[SignalOptions]) -> Order[None]:
        """Add a signal, as `Editor.create_signal` does."""
    def read(self, names: Sequence[str] = ...) -> Order[list[Signal]]:
        """Return all signals, or these."""
    def set(self, values: Mapping[str, GivenValue]) -> Order[None]:
        """Set several signals at the same instant; all or none when one is unknown or takes no such value."""
    def watch(self, names: Sequence[str] = ...) -> AsyncIterator[dict[str, SignalValue]]:
        """Yield the values of all signals, or of these, and then those that are new or changed; no change is lost."""
    def follow(self, names: Sequence[str] = ...) -> Order[SignalWatch]:
        """Return a watch of all signals, or of these, which tells each change with its instant."""
    def wait_for(self, name: str, value: GivenValue = ..., timeout: float | None = ..., comparison: str = ...) -> Order[None]:
        """Wait until a signal compares so with this value; return at once when it does already."""
    def __aiter__(self) -> Signals: ...
    async def __anext__(self) -> str: ...

class SignalWatch(Face):
    """Changes of signals as they come, in order and without a gap, until it is closed, which any thread may do."""
    def close(self) -> Order[None]:
        """End it; whoever waits for a change comes to the end."""
    async def __aenter__(self) -> SignalWatch: ...
    def __aiter__(self) -> SignalWatch: ...
    async def __anext__(self) -> SignalChange: ...

class Tokens(Face):
    """The tokens of a kernel beside its own."""
    def create(self, name: str, role: str) -> Order[NewToken]:
        """Make a token and return it with its secret, which the kernel does not keep."""
    def list(self) -> Order[list[TokenInfo]]:
        """Return the tokens, oldest first, without what they are; raise RoleTooLowError for all but admins."""
    def revoke(self, name: str) -> Order[TokenInfo]:
        """Withdraw a token and return it: its calls, streams and leases end, and its leased robots stop."""

class Assets(Face):
    """The kernel's store of files."""
    def upload(self, data: bytes) -> Order[str]:
        """Give the kernel a file's bytes; return their SHA-256. Bytes that it holds already are not sent."""
    def download(self, sha256: str) -> Order[bytes]:
        """Take a file's bytes from the kernel."""
    def find(self, sha256s: Iterable[str]) -> Order[set[str]]:
        """Return which of these files the kernel holds."""
    def mesh(self, file: str | Path, *, scale: float | Sequence[float] = ..., color: str | ArrayLike | None = ..., pose: PoseLike | None = ..., roles: Sequence[str] = ...) -> Order[Figure]:
        """Return a mesh file of this machine as a figure, with its materials and textures, all uploaded."""
    def triangles(self, corners: ArrayLike, triangles: ArrayLike, *, color: str | ArrayLike | None = ..., pose: PoseLike | None = ..., roles: Sequence[str] = ...) -> Order[Figure]:
        """Return a mesh of arrays as a figure, uploaded, such as ground from a height field."""
    def upload_with_references(self, file: str | Path, packages: Mapping[str, str | Path] | None = ..., settings: Mapping[str, object] | None = ..., *, text: str | None = ...) -> Order[Upload]:
        """Give the kernel a file of this machine and all files that it names, and those that these name."""

class AllowedPairs(Face):
    """Allowed collisions: pairs of nodes of one kernel that may touch each other."""
    def list(self, *nodes: str) -> Order[list[AllowedPair]]:
        """Return the pairs that may touch, all or those with one of these nodes or what hangs below them."""
    def add(self, first: str, second: str, reason: str = ...) -> Order[None]:
        """Let two nodes touch each other; saved with the scene."""
    def remove(self, first: str, second: str) -> Order[None]:
        """Let two nodes touch no more; raises UnknownNameError when neither a client nor an import had."""
    def forbid_built(self, *nodes: str) -> Order[list[AllowedPair]]:
        """Let pairs touch no more that imports have found to touch as built; return them."""
    def change(self, allow: Iterable[tuple[str, str, str]] = ..., forbid: Iterable[tuple[str, str]] = ...) -> Order[None]:
        """Let pairs touch no more, then let others (name, name, why) touch, as one change."""
    def find(self, robot: str, *, samples: int | None = ..., seed: int = ..., progress: Callable[[float], None] | None = ...) -> Order[Sequence[SampledPair]]:
        """Return how often nodes of a robot touch in random configurations, those that do most often first."""
    def __aiter__(self) -> AllowedPairs: ...
    async def __anext__(self) -> AllowedPair: ...

class Collisions(Face):
    """Collisions in the world of one kernel."""
    allowed: AllowedPairs
    @property
    def settings(self) -> Order[CollisionSettings]:
        """The collision settings now."""
    @property
    def guard_cost(self) -> Order[GuardCost]:
        """Time that guarding has cost since the kernel's start."""
    def set(self, mode: str | None = ..., **options: Unpack[CollisionOptions]) -> Order[None]:
        """Change what is done about collisions; what is not given stays. Saved with the scene."""
    def check(self, configurations: Configurations | None = ..., *, detail: str = ..., robots: Iterable[Named] = ...) -> Order[Check]:
        """Return what touches and may not, now or if robots stood elsewhere."""
    def check_configurations(self, robot: Named, positions: Samples, *, joint_names: Sequence[str] = ..., others: Mapping[str, Samples] | None = ..., robots: Iterable[Named] = ..., may_touch: Iterable[tuple[str, str]] = ..., progress: Callable[[float], None] | None = ...) -> Order[ConfigurationsCheck]:
        """Return which of n configurations are free, in the world as it is now."""
    def distance(self, *first: NodeNamed, to: Iterable[NodeNamed] = ..., configurations: Configurations | None = ...) -> Order[Distance]:
        """Return how far some nodes, such as a robot, are from everything else: the nearest pair that may not touch."""
    def distances(self, *first: NodeNamed, max_distance: float, to: Iterable[NodeNamed] = ..., configurations: Configurations | None = ...) -> Order[list[Distance]]:
        """Return all pairs of nodes that are at most so far apart and may not touch, the nearest first."""
    def meshes(self, *nodes: str) -> Order[list[CollisionMesh]]:
        """Return what the meshes of nodes and all below them collide as, and what is wrong with them; none means all."""
    def use_hulls(self, *nodes: str, vertices: int = ...) -> Order[list[CollisionMesh]]:
        """Have the meshes of nodes and of all below them collide as their convex hulls; return what they do then."""
    def use_triangles(self, *nodes: str) -> Order[list[CollisionMesh]]:
        """Have the meshes of nodes and of all below them collide as their triangles again; see `use_hulls`."""
    def watch(self) -> AsyncIterator[CollisionReport]:
        """Yield what touches now, of robots whose mode is not off, and then what begins and ends as it happens."""

class History(Face):
    """The steps of one kernel's world, newest last in number, and its checkpoints."""
    def list(self, *, node: str | None = ..., author: Text | None = ..., mine: bool = ..., since: datetime | None = ..., until: datetime | None = ..., kinds: Sequence[str] = ..., limit: Count = ...) -> Order[list[Step]]:
        """Return steps, newest first."""
    def watch(self, since: int | None = ...) -> AsyncIterator[Step]:
        """Yield steps as they are done, none left out; what is dragged comes again as it grows, with its first number."""
    def undo(self, number: int | None = ..., *, mine: bool = ..., request_id: str | None = ...) -> Order[Step]:
        """Take a step back: by default the newest edit that stands, with `mine` of this client's; return the undo."""
    def redo(self, number: int | None = ..., *, mine: bool = ..., request_id: str | None = ...) -> Order[Step]:
        """Take an undo back: by default the newest one, when nothing was edited since; return the redo."""
    def checkpoint(self, name: str | None = ..., *, request_id: str | None = ...) -> Order[Checkpoint]:
        """Keep the world as it is under a name, by default one that the kernel gives; return the checkpoint."""
    @property
    def checkpoints(self) -> Order[dict[str, Checkpoint]]:
        """The checkpoints by name, oldest first."""
    def restore(self, name: str, *, request_id: str | None = ...) -> Order[Checkpoint]:
        """Put the world back to how it was at a checkpoint, joints included; return one of how it was before."""
    def remove_checkpoint(self, name: str) -> Order[None]:
        """Forget a checkpoint; the world stays as it is."""

class Motion(Face):
    """One motion of a robot, of several that move together, or a program of many steps."""
    notes: object
    @property
    def state(self) -> Order[MotionState]:
        """State of the motion now, as the kernel tells it: after `clock.step` that of the last tick, or a later one."""
    @property
    def id(self) -> str:
        """Its name in the kernel, never used again."""
    @property
    def robots(self) -> tuple[str, ...]:
        """The robots that it moves."""
    @property
    def planned_duration(self) -> float:
        """Duration at full speed factors (s)."""
    @property
    def step_count(self) -> Order[int]:
        """Number of steps of its program; 0 for moves that are no program."""
    @property
    def phase(self) -> Order[Phase]:
        """Phase of the motion now."""
    @property
    def progress(self) -> Order[float]:
        """Part of the planned time law that is done, 0 to 1."""
    @property
    def step(self) -> Order[int]:
        """Number of the program's step that it is at, from 0."""
    @property
    def step_path(self) -> Order[str]:
        """Step that it is at as the program's text has it: `4[2].0` is the first step of step 4 in its third round."""
    @property
    def search(self) -> Order[Search | None]:
        """Result of its search; None before, and for motions that don't search."""
    def wait(self, timeout: float | None = ...) -> Order[Motion]:
        """Wait until it has reached its goal; return itself. Ctrl-C cancels it."""
    def append(self, program: Program | None = ..., *, last: bool = ..., expected_step_count: int | None = ..., expected_structure_revision: int | None = ..., request_id: str | None = ...) -> Order[tuple[PlanNote, ...]]:
        """Append the steps of a program to one that was started `open`."""
    def pause(self) -> Order[None]:
        """Slow it to standstill on its path; it can go on by `resume`."""
    def resume(self) -> Order[None]:
        """Let it go on after a pause."""
    def held(self) -> AbstractAsyncContextManager[Motion]:
        """Hold it for the length of a block: hold-to-run."""
    def beats(self) -> AbstractAsyncContextManager[Callable[[], None]]:
        """Hold it for as long as beats come, by the function that the block is given: hold-to-run by hand."""
    def run_step(self) -> Order[None]:
        """Let its program go on to the end of the present step and pause there; steps that zones join count as one."""
    def cancel(self, reason: str = ...) -> Order[None]:
        """Slow it to standstill on its path and end it."""
    def watch(self, max_rate: float | None = ...) -> AsyncIterator[MotionState]:
        """Yield its state again and again until it has ended, at most `max_rate` (30 by default) times a second."""
    def watch_steps(self, max_rate: float | None = ...) -> AsyncIterator[ProgramStepEvent]:
        """Yield what becomes of its steps with the tick of each event, none left out, until it has ended."""
    def keep_watching(self) -> Order[None]:
        """Watch it in a thread until it ends, so that the kernel knows that somebody cares."""
    async def __aenter__(self) -> Motion: ...

class FreePath(Face):
    """A path on which an arm touches nothing that it may not, as the world was when it was looked for."""
    joint_names: tuple[str, ...]
    waypoints: NDArray[float64]
    straight: bool
    length: float
    straight_length: float
    program: Program
    duration: float
    planner: str
    planning_time: float
    checks: int
    states: int
    def start(self, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Go along the path; the options are those of `Robot`."""

class Paths(Face):
    """Free ways in the world of one kernel."""
    def find(self, robot: Named, goal: Mapping[str, float] | str | ArrayLike, *, start: Mapping[str, float] | None = ..., reference: str = ..., configuration: str | None = ..., planner: str = ..., seed: int = ..., time_limit: float | None = ..., speed_factor: float | None = ..., zone_percent: float | None = ..., group: str | tuple[str, str] | None = ..., clearance: float = ..., progress: Callable[[PathProgress], None] | None = ...) -> Order[FreePath]:
        """Return a path on which an arm touches nothing that it may not. Nothing moves."""
    def find_tool_path(self, robot: Named, frames: ArrayLike, velocity: float, *, tolerance: Mapping[str, float | tuple[float, float] | str] | None = ..., reference: str = ..., acceleration: float | None = ..., time_limit: float | None = ..., group: str | tuple[str, str] | None = ..., external: Sequence[Named] = ..., may_touch: Iterable[tuple[str, str]] = ..., slope: float | None = ..., partners: Sequence[ToolPathPartner] = ..., progress: Callable[[ToolPathProgress], None] | None = ...) -> Order[ToolPath]:
        """Return how an arm leads its tool along frames at an even speed and touches nothing that it may not."""
    def find_tool_path_parts(self, robot: Named, frames: ArrayLike, velocity: float, **options: Unpack[ToolPathOptions]) -> Order[tuple[ToolPathPart, ...]]:
        """Return how an arm leads its tool along frames in as few parts as it can, and where it can't at all."""

class Program(Face):
    """Steps that one motion makes one after the other, planned as a whole before anything moves."""
    def move(self, *moves: Move, zone: float | None = ..., zone_percent: float | None = ..., zone_radius: float | None = ..., zone_extended: float | None = ..., min_duration: float | None = ...) -> Program:
        """Add moves that start and end together."""
    def set(self, signal: str, value: GivenValue = ..., *, lead: float = ...) -> Program:
        """Add a step that sets a signal; between moves with a zone it is set in the zone's middle."""
    def wait(self, signal: str, value: GivenValue = ..., timeout: float | None = ..., comparison: str = ...) -> Program:
        """Add a step that stands still until a signal compares so with a value (`==`, `!=`, `<`, `<=`, `>`, `>=`)."""
    def dwell(self, duration: float) -> Program:
        """Add a step that stands still for `duration` seconds of simulation time, at most 86,400 (a day)."""
    def tool_state(self, robot: Named, state: str, tool: str | None = ..., *, speed: float | None = ...) -> Program:
        """Add a step that brings a tool, the robot's chosen one by default, into a state."""
    def tool_width(self, robot: Named, width: float, tool: str | None = ..., *, speed: float | None = ...) -> Program:
        """Add a step that opens a tool, the robot's chosen one by default, to a width in meters."""
    def pick(self, robot: Named, part: str | None = ..., max_distance: float | None = ...) -> Program:
        """Add a step that fixes a part to the robot's chosen tool, as `Robot.pick` does; what follows carries it."""
    def place(self, robot: Named, part: str | None = ..., parent: str = ...) -> Program:
        """Add a step that lets a part of the robot's chosen tool go, or all parts, as `Robot.place` does."""
    def attach(self, name: str, parent: str = ..., pose: PoseLike | None = ...) -> Program:
        """Add a step that gives a node another parent; without `pose` (`parent_t_node`) it stays where it is."""
    def select_tool(self, robot: Named, tool: str | None = ..., tool_center_point: str | None = ...) -> Program:
        """Add a step that chooses the tool and tool centre point that a robot works with from then on."""
    def allow(self, allow: Iterable[tuple[str, str, str]] = ..., forbid: Iterable[tuple[str, str]] = ...) -> Program:
        """Add a step that lets pairs touch no more, then lets others (name, name, why) touch."""
    def speed(self, factor: float, robot: Named | None = ...) -> Program:
        """Add a step that multiplies the speed factors of all moves after it, or of one robot's, in this program."""
    def wait_part(self, part: str | None = ..., *, position: ArrayLike = ..., reference: str = ..., max_distance: float | None = ..., timeout: float | None = ...) -> Program:
        """Add a step that stands still until a part, or any, is within `max_distance` (m, 0.2) of a place."""
    def pick_at(self, robot: Named, goal: PoseLike, part: str | None = ..., **options: Unpack[PickAtOptions]) -> Program:
        """Add a step that goes to before a part, along a line to it, picks it, closes the tool and goes back."""
    def place_at(self, robot: Named, goal: PoseLike, part: str | None = ..., **options: Unpack[PlaceAtOptions]) -> Program:
        """Add a step that goes to before a place, along a line to it, opens the tool, lets go and goes back."""
    def repeat(self, count: Count, steps: Program) -> Program:
        """Add a step that makes the steps of a program `count` times."""
    def call(self, steps: Program, name: str | None = ...) -> Program:
        """Add a step that makes the steps of another program, which is told once however often it is called."""
    def pattern(self, name: str, pattern: Pattern, steps: Program, *, reference: str = ...) -> Program:
        """Add a step that makes the steps of a program at each place of a pattern, in the frame of `reference`."""
    def if_(self, signal: str, value: GivenValue = ..., comparison: str = ..., *, then: Program, otherwise: Program | None = ...) -> Program:
        """Add a step that makes the steps of one program or of another, as a signal compares with a value then."""
    def while_(self, steps: Program, signal: str | None = ..., value: GivenValue = ..., comparison: str = ...) -> Program:
        """Add a step that makes the steps of a program again and again, as long as a signal compares so with a value."""
    def start(self, *, open: bool = ..., breakpoints: Iterable[str] = ..., **options: Unpack[StartOptions]) -> Order[Motion]:
        """Plan all steps and start; the options are those of `Robot`."""
    def plan(self, **options: Unpack[PlanOptions]) -> Order[MotionPlan]:
        """Return what it would do, in samples; see `Client.plan`. Nothing moves."""
    def check(self, **options: Unpack[CheckOptions]) -> Order[MotionCheck]:
        """Return whether it keeps all limits and touches nothing, and else what it violates; see `Client.check`."""
    def flat(self) -> tuple[Program, tuple[str, ...]]:
        """Return a program of the elementary steps that it makes, and the place of each in the text."""
    @property
    def text(self) -> str:
        """The program as its file says it (JSON, which is YAML too); `Client.program` takes it."""
    def __len__(self) -> int:
        """Return the number of steps."""

class Proposals(Face):
    """The proposals of one kernel, which all of its clients share."""
    def list(self) -> Order[list[Proposal]]:
        """Return the proposals that the kernel remembers, oldest first: 50 at most, until it ends."""
    def get(self, id: str) -> Order[Proposal]:
        """Return a proposal as it is now."""
    def create(self, what: Program | Iterable[Move], title: Text = ...) -> Order[Proposal]:
        """Plan and check a program, or moves that go together, and propose it. Nothing moves."""
    def update(self, seen: Proposal | str, what: Program | Iterable[Move] | None = ..., *, title: Text | None = ...) -> Order[Proposal]:
        """Give a proposal another motion or title, plan and check it anew, and return it; it is `proposed` again."""
    def undo(self, seen: Proposal | str) -> Order[Proposal]:
        """Take back the last change of its motion, plan and check that of before, and return it."""
    def reject(self, seen: Proposal | str, reason: Text = ...) -> Order[Proposal]:
        """Turn a proposal down, for a reason of one line, and return it; errors as of `update`."""
    def approve(self, seen: Proposal, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Start the very plan of a proposal that was seen, and return its motion."""
    def plan(self, seen: Proposal, **options: Unpack[PlanOptions]) -> Order[MotionPlan]:
        """Return the plan of a proposal in samples, as it would run; see `Client.plan`. Nothing is planned again."""
    def program(self, seen: Proposal | str) -> Order[Program]:
        """Return the motion of a proposal as it is now, to be looked at, or changed and given to `update`."""
    def watch(self) -> Order[ProposalWatch]:
        """Return a watch of all proposals, a context manager."""

class ProposalWatch(Face):
    """Changes of proposals as they come, until it is closed, which any thread may do."""
    def close(self) -> Order[None]:
        """End it; whoever waits for a change comes to the end."""
    async def __aenter__(self) -> ProposalWatch: ...
    def __aiter__(self) -> ProposalWatch: ...
    async def __anext__(self) -> ProposalChange: ...

class ToolPathPart(Face):
    """Part of a tool path, from one of its frames to another."""
    first: int
    last: int
    path: ToolPath | None
    refusal: VirtualRobotError | None

class ToolPath(Face):
    """A way of an arm that leads its tool along n frames and touches nothing that it may not."""
    joint_names: tuple[str, ...]
    times: Floats
    positions: Floats
    freedoms: Floats
    length: float
    held: tuple[float, float]
    duration: float
    program: Program
    planning_time: float
    checks: int
    searches: int
    external: dict[str, ExternalMotion]
    partners: dict[str, PartnerMotion]
    @property
    def start_joints(self) -> Order[dict[str, float]]:
        """Joints at the start of the path, by name."""
    def start(self, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Go along the path; the options are those of `Robot`."""

class SetpointStream(Face):
    """Joints that follow the setpoints which this program sends; `Robot.stream` opens one. A context manager."""
    joint_names: object
    motion: Motion
    @property
    def state(self) -> StreamState:
        """State of the joints, as it was last told: at most 60 times a second."""
    def send(self, setpoint: Setpoint, *, wait: bool = ...) -> Order[None]:
        """Send a setpoint: radians or meters, or per second; one that has not left yet is replaced."""
    def check(self) -> Order[None]:
        """Raise what `send` would raise of the setpoints so far; nothing while all is well."""
    def close(self, timeout: float | None = ...) -> Order[None]:
        """End the stream well and wait until the joints rest, for at most `timeout` seconds; raises as `send` does."""
    def cancel(self, reason: str = ...) -> Order[None]:
        """Stop the joints at once, smoothly, and end the stream; the motion is cancelled."""
    async def __aenter__(self) -> SetpointStream: ...
    def __aiter__(self) -> SetpointStream: ...
    async def __anext__(self) -> StreamState: ...

class Recording(Face):
    """A recording that goes on while the program does; `finish` or `cancel` ends it. `Client.start_recording` makes it."""
    path: Path
    @property
    def simulation_time(self) -> Order[float]:
        """Simulation time that is recorded so far (s)."""
    @property
    def running(self) -> Order[bool]:
        """True until its duration is over, the kernel has gone or the file cannot be written any more."""
    def wait(self, timeout: float | None = ...) -> Order[bool]:
        """Wait until it has come to its end by itself, or `timeout` seconds are over; return whether it has ended."""
    def step(self, ticks: Count = ..., *, every: Count = ...) -> Order[None]:
        """Let time go on by some ticks and record each of them, or one of `every` so many and the last: none is missed."""
    def finish(self) -> Order[Recorded]:
        """Record what has happened so far, make the file whole, and return what is in it."""
    def cancel(self) -> Order[Recorded]:
        """End it with what is written; the file is whole. As `finish` without waiting for what is on its way."""
    async def __aenter__(self) -> Recording: ...

class Calibration(Face):
    """Computations of what a robot differs in from its model, by postures and what was measured. Nothing changes."""
    def tool(self, postures: Iterable[JointPositions]) -> Order[ToolCalibration]:
        """Return the tip of the tool that touched one fixed point in at least four postures, turned differently."""
    def base(self, postures: Iterable[JointPositions], points: ArrayLike) -> Order[BaseCalibration]:
        """Return where the robot stands whose tool centre point was at points (n, 3), m in the world, in n postures."""
    def joints(self, postures: Iterable[JointPositions], points: ArrayLike, *, fixed: Sequence[str] = ..., with_base: bool = ..., with_tip: bool = ...) -> Order[JointCalibration]:
        """Return the offsets of joints with which the tool centre point is where it was measured."""

class Group(Face):
    """Group of a robot: one of its named groups, or the chain from one link to another."""
    name: str
    @property
    def chain_joint_names(self) -> Order[list[str]]:
        """The joints that move the flange, in the order of inverse solutions; without a gripper's fingers."""
    @property
    def joint_types(self) -> Order[dict[str, str]]:
        """Type of each joint of the robot, by name: `revolute`, `continuous`, `prismatic`, `planar` or `floating`."""
    @property
    def coordinates(self) -> Order[dict[str, str]]:
        """Joint of each coordinate of the robot, by name in the order of `positions`."""
    def solve_forward(self, positions: JointPositions | None = ..., with_configuration: bool = ...) -> Order[ForwardSolution]:
        """Return where links and tool centre point would be; joints that are not named stand as they are now."""
    def solve_jacobian(self, positions: JointPositions | None = ..., points: Iterable[tuple[str, ArrayLike]] = ..., reference: str = ...) -> Order[Jacobians]:
        """Return how the tool centre point, and points fixed to links, tools or held parts, move with the joints."""
    def solve_inverse(self, reference_t_tcp: PoseLike, seed: JointPositions | None = ..., reference: str = ..., configuration: str | None = ..., *, lock: Lock = ..., arm_angle: float | None = ..., prefer: Prefer | None = ...) -> Order[InverseSolution]:
        """Return the joints that bring the tool centre point to a 4x4 pose, nearest to `seed` (default: now) first."""
    def solve_points(self, points: ArrayLike, seed: JointPositions | None = ..., reference: str = ...) -> Order[PointSolution]:
        """Return the joints that bring the tool centre point to each of many points, however it is turned there."""
    @property
    def calibration(self) -> Calibration:
        """Tool, base and joints as measurements at the real robot have them."""
    def solve_inverse_dynamics(self, positions: Samples | None = ..., velocities: Samples | None = ..., accelerations: Samples | None = ..., joint_names: list[str] | None = ...) -> Order[InverseDynamics]:
        """Return which torques a movement takes, tools and held parts included; gravity is 9.81 m/s^2."""
    def gravity_torques(self, positions: Mapping[str, float] | None = ...) -> Order[dict[str, float]]:
        """Return what holds each joint at rest, N m (sliding joints: N), now or with some joints elsewhere."""
    @property
    def kinematics(self) -> Order[str]:
        """The name of the component that solves its kinematics; `set_kinematics` gives it another one."""
    @property
    def kinematics_settings(self) -> Order[dict[str, Any]]:
        """The settings of that component; those that are not named have their defaults."""
    @property
    def kinematics_fault(self) -> Order[str]:
        """The latest fault of that component since it was chosen; empty while there was none."""
    def set_kinematics(self, name: str | None, settings: Mapping[str, object] | None = ..., **named: object) -> Order[KinematicsCheck]:
        """Give it another kinematics component, or make its own anew; return how well that fits."""
    def teach(self, name: str, parent: str = ..., *, replace: bool = ...) -> Order[Target]:
        """Save where the tool centre point is now, and in which posture, as a target with a name; return it."""
    @property
    def targets(self) -> Order[dict[str, Target]]:
        """The targets that were taught with this robot, by name; `Client.targets` are all."""
    def ptp(self, goal: JointPositions | str, **options: Unpack[PointToPointOptions]) -> Order[Move]:
        """Return a point-to-point move: all joints start and end together, straight in joint space."""
    def actuated(self, positions: Mapping[str, float], **options: Unpack[MoveOptions]) -> Order[Move]:
        """Return a point-to-point move to where actuators, by name and in their own units, have the joints."""
    def linear(self, reference_t_tcp: PoseLike | str, *, until: Until | None = ..., **options: Unpack[LinearOptions]) -> Order[Move]:
        """Return a straight move of the tool centre point to a 4x4 pose or a target; with `until` a `search`."""
    def circular(self, via: ArrayLike | None = ..., goal: ArrayLike | None = ..., *, until: Until | None = ..., **options: Unpack[CircularOptions]) -> Order[Move]:
        """Return a move of the tool centre point along an arc to the 4x4 pose `goal`; with `until` a search."""
    def spline(self, goals: Iterable[ArrayLike | str], *, references: Sequence[str] | None = ..., **options: Unpack[CartesianOptions]) -> Order[Move]:
        """Return a move of the tool centre point along a smooth curve through 4x4 poses or targets, up to 1,000."""
    def trajectory(self, times: ArrayLike, positions: ArrayLike, velocities: ArrayLike | None = ..., *, joints: Sequence[str] | None = ..., **options: Unpack[TrajectoryOptions]) -> Order[Move]:
        """Return a move through `positions` (n, k) at `times` (n,) in seconds from 0; the first row is where it is now."""
    def read_trajectory(self, file: str | Path, text: str | None = ..., *, speed_factor: float | None = ...) -> Order[Move]:
        """Return the `trajectory` that a CSV or JSON file describes; with `text`, its content, `file` only names it."""
    def joint_jog(self, joint: str, velocity: float, distance: float | None = ...) -> Order[Move]:
        """Return a jog of one joint; see `jog_joint`."""
    def cartesian_jog(self, translation: ArrayLike | None = ..., **options: Unpack[JogOptions]) -> Order[Move]:
        """Return a jog of the tool centre point; see `jog`."""
    def start(self, move: Move, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Start one move."""
    def move_joints(self, goal: JointPositions, **options: Unpack[_MoveStart]) -> Order[Motion]:
        """Move joints to values by name, or in order (all joints, or those of the chain)."""
    def move_pose(self, reference_t_tcp: PoseLike, **options: Unpack[_PointToPointStart]) -> Order[Motion]:
        """Move the tool centre point to a 4x4 pose, point to point, with the posture nearest to the present one."""
    def move_to(self, name: str, **options: Unpack[_PointToPointStart]) -> Order[Motion]:
        """Move, point to point, to a posture with a name, such as `home`, or to a target."""
    def move_actuators(self, positions: Mapping[str, float], **options: Unpack[_MoveStart]) -> Order[Motion]:
        """Move to where actuators, by name and in their own units, have the joints; see `Robot.actuators`."""
    def move_linear(self, reference_t_tcp: PoseLike | str, **options: Unpack[_LinearStart]) -> Order[Motion]:
        """Move the tool centre point straight to a 4x4 pose or a target."""
    def search(self, reference_t_tcp: PoseLike | str, until: Until, **options: Unpack[_LinearStart]) -> Order[Motion]:
        """Move straight to a 4x4 pose or a target, or until a signal is on; `Motion.search` tells where that was."""
    def move_circular(self, via: ArrayLike | None = ..., goal: ArrayLike | None = ..., **options: Unpack[_CircularStart]) -> Order[Motion]:
        """Move the tool centre point along an arc; see `circular`."""
    def move_spline(self, goals: Iterable[ArrayLike | str], **options: Unpack[_CartesianStart]) -> Order[Motion]:
        """Move the tool centre point along a smooth curve through 4x4 poses or targets; see `spline`."""
    def move_trajectory(self, times: ArrayLike, positions: ArrayLike, velocities: ArrayLike | None = ..., *, joints: Sequence[str] | None = ..., **options: Unpack[_TrajectoryStart]) -> Order[Motion]:
        """Pass joint positions at given times; see `trajectory`."""
    def jog_joint(self, joint: str, velocity: float, distance: float | None = ..., **options: Unpack[StartOptions]) -> Order[Motion]:
        """Move one joint at a velocity in rad/s or m/s, whose sign says which way, and return at once."""
    def jog(self, translation: ArrayLike | None = ..., **options: Unpack[_JogStart]) -> Order[Motion]:
        """Move the tool centre point along `translation`, or turn it about the axis `rotation`, and return at once."""
    def stream_tool(self, mode: str = ..., *, frame: str | None = ..., node: str | None = ..., max_velocity: float | None = ..., max_rotation_velocity: float | None = ..., timeout: float = ..., preempt: bool = ...) -> Order[SetpointStream]:
        """Open a stream of twists or poses of the tool centre point, which it follows as this program sends them."""
    def stop(self) -> Order[list[Motion]]:
        """Cancel every motion of this robot; return them."""
    def plan(self, move: Move, **options: Unpack[PlanOptions]) -> Order[MotionPlan]:
        """Return what a move would do, in samples; see `Client.plan`."""
    def check(self, move: Move, **options: Unpack[CheckOptions]) -> Order[MotionCheck]:
        """Return whether a move keeps all limits and touches nothing, and else what it violates; see `Client.check`."""
    @property
    def joint_names(self) -> Order[list[str]]:
        """Joints of the group in the order of `positions`; of a chain from its base to its tip."""
    @property
    def tip(self) -> Order[str]:
        """Link that the group's chain ends at; empty for a group that is no chain."""
    @property
    def limits(self) -> Order[dict[str, JointLimits]]:
        """Limits of the group's joints, by name."""
    @property
    def positions(self) -> Order[NDArray[float64]]:
        """Positions of the group's joints now, (k,), radians and meters; to be read only, as of `Robot`."""
    def set_positions(self, positions: JointPositions) -> Order[None]:
        """Put joints of the group somewhere at once, without a motion; values by name, or in order."""
    @property
    def tcp(self) -> Order[Matrix]:
        """`world_t_tcp`, 4x4: where the group's tool centre point is."""

class Odometry(Face):
    """Way of a craft, reckoned from the angles of its drives by its component, or one that is thought to be otherwise."""
    @property
    def reading(self) -> Order[OdometryReading]:
        """Return the place as of the last update."""
    def update(self, encoders: EncoderReading | None = ...) -> Order[OdometryReading]:
        """Return where the craft should be by now."""
    def reckon(self, encoders: Sequence[EncoderReading]) -> Order[virtualrobot_robots_odometry_Floats]:
        """Return where the craft should have been, (n, 3) x, y (m) and heading (rad), at readings of its encoders."""
    def drift(self, true_pose: ArrayLike | None = ...) -> Order[virtualrobot_robots_odometry_Floats]:
        """Return by how much the last update is off: x, y (m) and heading (rad, within half a turn), shape (3,)."""

class Postures(Face):
    """Postures of a robot by name, radians and meters by joint; `move_to` goes there. They are saved in scene files."""
    def __getitem__(self, name: str) -> Order[dict[str, float]]:
        """Return the joint values of a posture; raises UnknownNameError when the robot has none of this name."""
    def add(self, name: str, positions: JointPositions | None = ..., *, replace: bool = ...) -> Order[None]:
        """Give the robot a posture: joint values by name or in order, or its joints as they stand now."""
    def remove(self, name: str) -> Order[None]:
        """Take a posture away; raises UnknownNameError when there is none of this name."""
    def __aiter__(self) -> Postures: ...
    async def __anext__(self) -> str: ...

class Robot(Face):
    """A robot by its name: an arm, a conveyor, a turntable, a vehicle, whatever has joints."""
    name: str
    @property
    def chain_joint_names(self) -> Order[list[str]]:
        """The joints that move the flange, in the order of inverse solutions; without a gripper's fingers."""
    @property
    def joint_types(self) -> Order[dict[str, str]]:
        """Type of each joint of the robot, by name: `revolute`, `continuous`, `prismatic`, `planar` or `floating`."""
    @property
    def coordinates(self) -> Order[dict[str, str]]:
        """Joint of each coordinate of the robot, by name in the order of `positions`."""
    def solve_forward(self, positions: JointPositions | None = ..., with_configuration: bool = ...) -> Order[ForwardSolution]:
        """Return where links and tool centre point would be; joints that are not named stand as they are now."""
    def solve_jacobian(self, positions: JointPositions | None = ..., points: Iterable[tuple[str, ArrayLike]] = ..., reference: str = ...) -> Order[Jacobians]:
        """Return how the tool centre point, and points fixed to links, tools or held parts, move with the joints."""
    def solve_inverse(self, reference_t_tcp: PoseLike, seed: JointPositions | None = ..., reference: str = ..., configuration: str | None = ..., *, lock: Lock = ..., arm_angle: float | None = ..., prefer: Prefer | None = ...) -> Order[InverseSolution]:
        """Return the joints that bring the tool centre point to a 4x4 pose, nearest to `seed` (default: now) first."""
    def solve_points(self, points: ArrayLike, seed: JointPositions | None = ..., reference: str = ...) -> Order[PointSolution]:
        """Return the joints that bring the tool centre point to each of many points, however it is turned there."""
    @property
    def calibration(self) -> Calibration:
        """Tool, base and joints as measurements at the real robot have them."""
    def solve_inverse_dynamics(self, positions: Samples | None = ..., velocities: Samples | None = ..., accelerations: Samples | None = ..., joint_names: list[str] | None = ...) -> Order[InverseDynamics]:
        """Return which torques a movement takes, tools and held parts included; gravity is 9.81 m/s^2."""
    def gravity_torques(self, positions: Mapping[str, float] | None = ...) -> Order[dict[str, float]]:
        """Return what holds each joint at rest, N m (sliding joints: N), now or with some joints elsewhere."""
    @property
    def kinematics(self) -> Order[str]:
        """The name of the component that solves its kinematics; `set_kinematics` gives it another one."""
    @property
    def kinematics_settings(self) -> Order[dict[str, Any]]:
        """The settings of that component; those that are not named have their defaults."""
    @property
    def kinematics_fault(self) -> Order[str]:
        """The latest fault of that component since it was chosen; empty while there was none."""
    def set_kinematics(self, name: str | None, settings: Mapping[str, object] | None = ..., **named: object) -> Order[KinematicsCheck]:
        """Give it another kinematics component, or make its own anew; return how well that fits."""
    def teach(self, name: str, parent: str = ..., *, replace: bool = ...) -> Order[Target]:
        """Save where the tool centre point is now, and in which posture, as a target with a name; return it."""
    @property
    def targets(self) -> Order[dict[str, Target]]:
        """The targets that were taught with this robot, by name; `Client.targets` are all."""
    def ptp(self, goal: JointPositions | str, **options: Unpack[PointToPointOptions]) -> Order[Move]:
        """Return a point-to-point move: all joints start and end together, straight in joint space."""
    def actuated(self, positions: Mapping[str, float], **options: Unpack[MoveOptions]) -> Order[Move]:
        """Return a point-to-point move to where actuators, by name and in their own units, have the joints."""
    def linear(self, reference_t_tcp: PoseLike | str, *, until: Until | None = ..., **options: Unpack[LinearOptions]) -> Order[Move]:
        """Return a straight move of the tool centre point to a 4x4 pose or a target; with `until` a `search`."""
    def circular(self, via: ArrayLike | None = ..., goal: ArrayLike | None = ..., *, until: Until | None = ..., **options: Unpack[CircularOptions]) -> Order[Move]:
        """Return a move of the tool centre point along an arc to the 4x4 pose `goal`; with `until` a search."""
    def spline(self, goals: Iterable[ArrayLike | str], *, references: Sequence[str] | None = ..., **options: Unpack[CartesianOptions]) -> Order[Move]:
        """Return a move of the tool centre point along a smooth curve through 4x4 poses or targets, up to 1,000."""
    def trajectory(self, times: ArrayLike, positions: ArrayLike, velocities: ArrayLike | None = ..., *, joints: Sequence[str] | None = ..., **options: Unpack[TrajectoryOptions]) -> Order[Move]:
        """Return a move through `positions` (n, k) at `times` (n,) in seconds from 0; the first row is where it is now."""
    def read_trajectory(self, file: str | Path, text: str | None = ..., *, speed_factor: float | None = ...) -> Order[Move]:
        """Return the `trajectory` that a CSV or JSON file describes; with `text`, its content, `file` only names it."""
    def joint_jog(self, joint: str, velocity: float, distance: float | None = ...) -> Order[Move]:
        """Return a jog of one joint; see `jog_joint`."""
    def cartesian_jog(self, translation: ArrayLike | None = ..., **options: Unpack[JogOptions]) -> Order[Move]:
        """Return a jog of the tool centre point; see `jog`."""
    def start(self, move: Move, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Start one move."""
    def move_joints(self, goal: JointPositions, **options: Unpack[_MoveStart]) -> Order[Motion]:
        """Move joints to values by name, or in order (all joints, or those of the chain)."""
    def move_pose(self, reference_t_tcp: PoseLike, **options: Unpack[_PointToPointStart]) -> Order[Motion]:
        """Move the tool centre point to a 4x4 pose, point to point, with the posture nearest to the present one."""
    def move_to(self, name: str, **options: Unpack[_PointToPointStart]) -> Order[Motion]:
        """Move, point to point, to a posture with a name, such as `home`, or to a target."""
    def move_actuators(self, positions: Mapping[str, float], **options: Unpack[_MoveStart]) -> Order[Motion]:
        """Move to where actuators, by name and in their own units, have the joints; see `Robot.actuators`."""
    def move_linear(self, reference_t_tcp: PoseLike | str, **options: Unpack[_LinearStart]) -> Order[Motion]:
        """Move the tool centre point straight to a 4x4 pose or a target."""
    def search(self, reference_t_tcp: PoseLike | str, until: Until, **options: Unpack[_LinearStart]) -> Order[Motion]:
        """Move straight to a 4x4 pose or a target, or until a signal is on; `Motion.search` tells where that was."""
    def move_circular(self, via: ArrayLike | None = ..., goal: ArrayLike | None = ..., **options: Unpack[_CircularStart]) -> Order[Motion]:
        """Move the tool centre point along an arc; see `circular`."""
    def move_spline(self, goals: Iterable[ArrayLike | str], **options: Unpack[_CartesianStart]) -> Order[Motion]:
        """Move the tool centre point along a smooth curve through 4x4 poses or targets; see `spline`."""
    def move_trajectory(self, times: ArrayLike, positions: ArrayLike, velocities: ArrayLike | None = ..., *, joints: Sequence[str] | None = ..., **options: Unpack[_TrajectoryStart]) -> Order[Motion]:
        """Pass joint positions at given times; see `trajectory`."""
    def jog_joint(self, joint: str, velocity: float, distance: float | None = ..., **options: Unpack[StartOptions]) -> Order[Motion]:
        """Move one joint at a velocity in rad/s or m/s, whose sign says which way, and return at once."""
    def jog(self, translation: ArrayLike | None = ..., **options: Unpack[_JogStart]) -> Order[Motion]:
        """Move the tool centre point along `translation`, or turn it about the axis `rotation`, and return at once."""
    def stream_tool(self, mode: str = ..., *, frame: str | None = ..., node: str | None = ..., max_velocity: float | None = ..., max_rotation_velocity: float | None = ..., timeout: float = ..., preempt: bool = ...) -> Order[SetpointStream]:
        """Open a stream of twists or poses of the tool centre point, which it follows as this program sends them."""
    def stop(self) -> Order[list[Motion]]:
        """Cancel every motion of this robot; return them."""
    def plan(self, move: Move, **options: Unpack[PlanOptions]) -> Order[MotionPlan]:
        """Return what a move would do, in samples; see `Client.plan`."""
    def check(self, move: Move, **options: Unpack[CheckOptions]) -> Order[MotionCheck]:
        """Return whether a move keeps all limits and touches nothing, and else what it violates; see `Client.check`."""
    def stream_twist(self, *, timeout: float = ..., preempt: bool = ...) -> Order[SetpointStream]:
        """Open a stream of twists of a craft: its drives move it as this program says, within their limits."""
    def drive(self, forward: float = ..., turn: float = ..., *, left: float = ..., seconds: float, timeout: float = ..., preempt: bool = ...) -> Order[StreamState]:
        """Drive a craft with a twist for some seconds of simulation time, brake, and return where it rests."""
    def drive_path(self, parts: ArrayLike, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Drive a craft along lines and arcs, one after the other, as a planned motion; it stands between them."""
    def drive_to(self, x: float, y: float, heading: float | None = ..., *, reverse: bool = ..., turning_radius: float | None = ..., **options: Unpack[StartOptions]) -> Order[Motion]:
        """Drive a craft to a place, by the shortest way of lines and arcs: that of `way_to`."""
    def way(self, parts: ArrayLike, *, joints: JointPositions | None = ...) -> Order[Way]:
        """Return a way of a craft along lines and arcs, as `drive_path` drives it; nothing moves."""
    def way_to(self, x: float, y: float, heading: float | None = ..., *, reverse: bool = ..., turning_radius: float | None = ..., joints: JointPositions | None = ...) -> Order[Way]:
        """Return the shortest way of a craft to a place; nothing moves."""
    def way_to_reach(self, world_t_tcp: PoseLike, *, reverse: bool = ..., turning_radius: float | None = ...) -> Order[Way]:
        """Return a way on which base and arm of a mobile manipulator bring its tool centre point to a pose together."""
    def odometry(self, *, counts_per_turn: int | None = ..., settings: Mapping[str, object] | None = ..., variance_per_radian: float = ..., encoders: EncoderReading | None = ...) -> Order[Odometry]:
        """Return what reckons the way of a craft from the angles of its drives, from now on."""
    @property
    def joint_names(self) -> Order[list[str]]:
        """The joints that can be moved, in the order of `positions`."""
    @property
    def limits(self) -> Order[dict[str, JointLimits]]:
        """Limits of each joint, by name."""
    @property
    def links(self) -> Order[list[str]]:
        """The names of the links, parents before children."""
    @property
    def flange(self) -> Order[str]:
        """The link that tools are mounted on."""
    @property
    def rated_payload(self) -> Order[float]:
        """Greatest load at the flange by the data sheet (kg), with tools; 0 where none is told."""
    @property
    def postures(self) -> Postures:
        """Postures with a name, for `move_to`: joint values by name, like a dictionary, with `add` and `remove`."""
    @property
    def groups(self) -> Order[dict[str, JointGroup]]:
        """Groups of joints by name, as an SRDF file or `set_groups` gives them; `group` handles one of them."""
    def group(self, name: str | None = ..., *, base: str | None = ..., tip: str | None = ...) -> Order[Group]:
        """Return a handle for a part of the robot that is solved and moved by itself."""
    def set_groups(self, groups: Iterable[JointGroup]) -> Order[None]:
        """Give the robot these groups, in place of those that it has; chains need no joint names."""
    @property
    def actuators(self) -> Order[list[Actuator]]:
        """Actuators of the joints, in the order of `RobotState.actuator_positions`; empty where motors are joints."""
    @property
    def allowed_collisions(self) -> Order[list[LinkPair]]:
        """Pairs of links that may touch: adjacent ones, and those that the model says."""
    @property
    def state(self) -> Order[RobotState]:
        """State of joints, tool centre point and tools now."""
    @property
    def positions(self) -> Order[NDArray[float64]]:
        """All joint coordinates now, in radians and meters; to be read only, `copy()` is an array of one's own."""
    @property
    def tcp(self) -> Order[Matrix]:
        """`world_t_tcp`, 4x4: where the chosen tool centre point is (without a tool: the flange)."""
    def watch(self, max_rate: float | None = ...) -> AsyncIterator[RobotState]:
        """Yield the state now and whenever it has changed, at most `max_rate` (30 by default) times a second."""
    @property
    def speed_factor(self) -> Order[float]:
        """Factor by which its motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
    def set_speed_factor(self, value: float) -> Order[None]:
        """Set `speed_factor`: Factor by which its motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
    @property
    def tcp_speed_limit(self) -> Order[float]:
        """Greatest speed of its tool centre point (m/s), as 0.25 for teaching; 0: it has none."""
    def set_tcp_speed_limit(self, value: float) -> Order[None]:
        """Set `tcp_speed_limit`: Greatest speed of its tool centre point (m/s), as 0.25 for teaching; 0: it has none."""
    def set_positions(self, positions: JointPositions) -> Order[None]:
        """Put joints somewhere at once, without a motion; values by name, or all coordinates in order."""
    def lease(self, *, take: bool = ..., owner: str | None = ...) -> Order[Lease]:
        """Lease it, so that nobody but this client moves it; see `Client.lease`."""
    def stream(self, mode: str = ..., joints: Sequence[str] | None = ..., *, timeout: float = ..., preempt: bool = ...) -> Order[SetpointStream]:
        """Open a stream of setpoints, which moves joints as this program sends them."""
    @property
    def tools(self) -> Order[list[str]]:
        """The names of the tools mounted on it."""
    def tool(self, name: str | None = ...) -> Order[Tool]:
        """Return a handle for a tool of this robot, by its name or its gripper's; without a name the chosen one."""
    def mount(self, what: NodeNamed | Path, *, name: str | None = ..., adapter: NodeNamed | None = ..., pose: PoseLike | None = ..., tcp: str | ArrayLike | None = ...) -> Order[Tool]:
        """Mount a tool or gripper at the flange, work with it, and return it."""
    def unmount(self, tool: NodeNamed | None = ..., *, to: NodeNamed = ..., pose: PoseLike | None = ...) -> Order[None]:
        """Take a tool off: by default the chosen one with its gripper, or a tool, gripper or adapter by name."""
    def change_tool(self, what: NodeNamed, *, rack: NodeNamed = ..., rack_pose: PoseLike | None = ..., adapter: NodeNamed | None = ..., pose: PoseLike | None = ..., tcp: str | None = ...) -> Order[Tool]:
        """Take the chosen tool off, if there is one, and mount another one that is there, as one change; return that."""
    def pick(self, part: str | None = ..., max_distance: float | None = ...) -> Order[str]:
        """Fix a part to the chosen tool and return its name."""
    def place(self, part: str | None = ..., parent: str = ...) -> Order[None]:
        """Let a part go, or all; it stays where it is, fixed to `parent`."""

class Robots(Face):
    """The robots of one kernel by name; called, it returns them all."""
    def __getitem__(self, name: str) -> Order[Robot]:
        """Return a robot; raises UnknownNameError, a KeyError that lists the right names, when there is none."""
    def __call__(self) -> Order[list[Robot]]:
        """Return all robots."""
    def __aiter__(self) -> Robots: ...
    async def __anext__(self) -> str: ...

class Tool(Face):
    """A tool of a robot by its name."""
    robot: str
    name: str
    @property
    def state(self) -> Order[str]:
        """The state that it is in."""
    @property
    def states(self) -> Order[dict[str, dict[str, float]]]:
        """States that it can be told to take: the joint positions of each, radians or meters."""
    @property
    def widths(self) -> Order[dict[float, dict[str, float]]]:
        """Joint positions (rad or m) by how wide it is open (m), rising; empty for a tool that does not open."""
    @property
    def width(self) -> Order[float]:
        """Distance between its fingers now, in meters."""
    @property
    def tool_center_points(self) -> Order[dict[str, Matrix]]:
        """`tool_t_tcp`, 4x4, by name."""
    def set(self, state: str, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Move its joints to where a state has them; then it is in that state."""
    def open(self, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Move to the state `open`."""
    def close(self, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Move to the state `closed`."""
    def state_move(self, state: str) -> Order[Move]:
        """Return the move to a state, for `Client.move_together`."""
    def move_to_width(self, width: float, **options: Unpack[StartOptions]) -> Order[Motion]:
        """Open or close its fingers to a distance (m), between the least and greatest of `widths`."""
    def width_move(self, width: float) -> Order[Move]:
        """Return the move to a width (m), for `Client.move_together`."""
    def select(self, tool_center_point: str | None = ...) -> Order[Tool]:
        """Let the robot work with this tool and this point of it (by default its first); return the tool."""

class Way(Face):
    """Way of a craft, a program whose moves are its lines and arcs; it stands between them."""
    parts: virtualrobot_robots_ways_Floats
    joint_names: object
    length: object
    word: object
    turning_radius: object
    begin: object
    def move(self, *moves: Move, zone: float | None = ..., zone_percent: float | None = ..., zone_radius: float | None = ..., zone_extended: float | None = ..., min_duration: float | None = ...) -> Program:
        """Add moves that start and end together."""
    def set(self, signal: str, value: GivenValue = ..., *, lead: float = ...) -> Program:
        """Add a step that sets a signal; between moves with a zone it is set in the zone's middle."""
    def wait(self, signal: str, value: GivenValue = ..., timeout: float | None = ..., comparison: str = ...) -> Program:
        """Add a step that stands still until a signal compares so with a value (`==`, `!=`, `<`, `<=`, `>`, `>=`)."""
    def dwell(self, duration: float) -> Program:
        """Add a step that stands still for `duration` seconds of simulation time, at most 86,400 (a day)."""
    def tool_state(self, robot: Named, state: str, tool: str | None = ..., *, speed: float | None = ...) -> Program:
        """Add a step that brings a tool, the robot's chosen one by default, into a state."""
    def tool_width(self, robot: Named, width: float, tool: str | None = ..., *, speed: float | None = ...) -> Program:
        """Add a step that opens a tool, the robot's chosen one by default, to a width in meters."""
    def pick(self, robot: Named, part: str | None = ..., max_distance: float | None = ...) -> Program:
        """Add a step that fixes a part to the robot's chosen tool, as `Robot.pick` does; what follows carries it."""
    def place(self, robot: Named, part: str | None = ..., parent: str = ...) -> Program:
        """Add a step that lets a part of the robot's chosen tool go, or all parts, as `Robot.place` does."""
    def attach(self, name: str, parent: str = ..., pose: PoseLike | None = ...) -> Program:
        """Add a step that gives a node another parent; without `pose` (`parent_t_node`) it stays where it is."""
    def select_tool(self, robot: Named, tool: str | None = ..., tool_center_point: str | None = ...) -> Program:
        """Add a step that chooses the tool and tool centre point that a robot works with from then on."""
    def allow(self, allow: Iterable[tuple[str, str, str]] = ..., forbid: Iterable[tuple[str, str]] = ...) -> Program:
        """Add a step that lets pairs touch no more, then lets others (name, name, why) touch."""
    def speed(self, factor: float, robot: Named | None = ...) -> Program:
        """Add a step that multiplies the speed factors of all moves after it, or of one robot's, in this program."""
    def wait_part(self, part: str | None = ..., *, position: ArrayLike = ..., reference: str = ..., max_distance: float | None = ..., timeout: float | None = ...) -> Program:
        """Add a step that stands still until a part, or any, is within `max_distance` (m, 0.2) of a place."""
    def pick_at(self, robot: Named, goal: PoseLike, part: str | None = ..., **options: Unpack[PickAtOptions]) -> Program:
        """Add a step that goes to before a part, along a line to it, picks it, closes the tool and goes back."""
    def place_at(self, robot: Named, goal: PoseLike, part: str | None = ..., **options: Unpack[PlaceAtOptions]) -> Program:
        """Add a step that goes to before a place, along a line to it, opens the tool, lets go and goes back."""
    def repeat(self, count: Count, steps: Program) -> Program:
        """Add a step that makes the steps of a program `count` times."""
    def call(self, steps: Program, name: str | None = ...) -> Program:
        """Add a step that makes the steps of another program, which is told once however often it is called."""
    def pattern(self, name: str, pattern: Pattern, steps: Program, *, reference: str = ...) -> Program:
        """Add a step that makes the steps of a program at each place of a pattern, in the frame of `reference`."""
    def if_(self, signal: str, value: GivenValue = ..., comparison: str = ..., *, then: Program, otherwise: Program | None = ...) -> Program:
        """Add a step that makes the steps of one program or of another, as a signal compares with a value then."""
    def while_(self, steps: Program, signal: str | None = ..., value: GivenValue = ..., comparison: str = ...) -> Program:
        """Add a step that makes the steps of a program again and again, as long as a signal compares so with a value."""
    def start(self, *, open: bool = ..., breakpoints: Iterable[str] = ..., **options: Unpack[StartOptions]) -> Order[Motion]:
        """Plan all steps and start; the options are those of `Robot`."""
    def plan(self, **options: Unpack[PlanOptions]) -> Order[MotionPlan]:
        """Return what it would do, in samples; see `Client.plan`. Nothing moves."""
    def check(self, **options: Unpack[CheckOptions]) -> Order[MotionCheck]:
        """Return whether it keeps all limits and touches nothing, and else what it violates; see `Client.check`."""
    def flat(self) -> tuple[Program, tuple[str, ...]]:
        """Return a program of the elementary steps that it makes, and the place of each in the text."""
    @property
    def text(self) -> str:
        """The program as its file says it (JSON, which is YAML too); `Client.program` takes it."""
    def __len__(self) -> int:
        """Return the number of steps."""

class Batch(Face):
    """Commands that are collected and applied together; see `Scene.batch`."""
    def add_object(self, name: str, figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> str:
        """Add a piece of the environment: a table, a fence, or without figures a frame of reference."""
    def add_part(self, name: str, figures: Figures, *, pose: PoseLike | None = ..., parent: str = ..., mass: float | None = ..., inertial: Inertial | None = ..., dynamic: bool = ...) -> str:
        """Add a thing that robots handle."""
    def add_adapter(self, name: str, parent: str, figures: Figures = ..., *, pose: PoseLike | None = ...) -> str:
        """Add what stands between a flange (the link `parent`) and a tool."""
    def add_tool(self, name: str, parent: str, figures: Figures = ..., *, pose: PoseLike | None = ..., tool_center_points: Mapping[str, ArrayLike] | None = ..., states: Mapping[str, Mapping[str, float]] | None = ..., inertial: Inertial | None = ..., widths: Mapping[float, Mapping[str, float]] | None = ...) -> str:
        """Mount a tool on a flange or adapter (`parent`)."""
    def add_camera(self, name: str, settings: CameraSettings | None = ..., figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> str:
        """Add a camera; it looks along z of its pose (`parent_t_camera`), x to the right of the picture and y down."""
    def add_range_sensor(self, name: str, settings: RangeSensorSettings | None = ..., figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> str:
        """Add a range sensor; it looks along x of its pose (`parent_t_sensor`), z upwards."""
    def add_light(self, name: str, settings: LightSettings | None = ..., figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> str:
        """Add a light, as `virtualrobot.light` makes it; spots and directional ones shine along z of their pose."""
    def add_motion_sensor(self, name: str, settings: MotionSensorSettings, figures: Figures = ..., *, parent: str, pose: PoseLike | None = ...) -> str:
        """Fix a motion sensor to something that moves; `pose` is `parent_t_sensor`."""
    def add_contact_sensor(self, name: str, settings: ContactSensorSettings | None = ..., figures: Figures = ..., *, parent: str = ..., pose: PoseLike | None = ...) -> str:
        """Add a contact sensor, as `virtualrobot.contact_sensor` makes it; without a `watched` node its parent feels."""
    def add_annotation(self, name: str, figures: Figures, *, pose: PoseLike | None = ..., parent: str = ...) -> str:
        """Add something that is drawn for people only."""
    def add_frame(self, name: str, *, pose: PoseLike | None = ..., parent: str = ..., size: float | None = ...) -> str:
        """Add a frame of reference, drawn as arrows of `size` meters (0.1 by default): x red, y green, z blue."""
    def add_target(self, name: str, *, pose: PoseLike | None = ..., parent: str = ..., robot: str = ..., joint_positions: Mapping[str, float] | None = ...) -> str:
        """Add a target, a place where tools work, at a pose (`parent_t_target`); `Robot.teach` saves one."""
    def add_viewpoint(self, name: str, *, pose: PoseLike | None = ..., parent: str = ..., distance: float | None = ..., field_of_view: float | None = ...) -> str:
        """Add a viewpoint, a view of people under a name, at a pose (`parent_t_eye`); `client.view.save` saves one."""
    def set_viewpoint(self, name: str, distance: float | None = ..., field_of_view: float | None = ...) -> None:
        """Change how far ahead of a viewpoint is what is looked at (m), and its field of view (rad), as it is added."""
    def rename(self, name: str, new_name: str) -> None:
        """Give a node another name."""
    def hide(self, name: str, hidden: bool = ...) -> None:
        """Hide a node and what hangs below, or show it again."""
    def describe(self, name: str, description: Text | None = ..., *, tags: Iterable[str] | None = ..., icon: str | None = ...) -> None:
        """Say what a node is for, by which words it is found, and which icon pages show for it; what is None stays."""
    def lock(self, name: str, locked: bool = ...) -> None:
        """Keep a node's name, parent, pose and figures as they are, and it in the world, or let go of it again."""
    def set_pose(self, name: str, parent_t_node: PoseLike) -> None:
        """Put a node somewhere else in its parent's frame, at once."""
    def set_figures(self, name: str, figures: Figures) -> None:
        """Give a node other shapes."""
    def remove(self, name: str) -> None:
        """Take a node and all below it out of the world."""
    def attach(self, name: str, parent: str = ..., pose: PoseLike | None = ...) -> None:
        """Give a node another parent; without `pose` (`parent_t_node`) it stays where it is in the world."""
    def pick(self, robot: str, part: str | None = ..., max_distance: float | None = ...) -> None:
        """Fix a part to the robot's chosen tool; without a name the one nearest to the tool centre point."""
    def place(self, robot: str, part: str | None = ..., parent: str = ...) -> None:
        """Let a part of the robot's chosen tool go, or all parts; it stays where it is, fixed to `parent`."""
    def set_joint_positions(self, robot: str, positions: Mapping[str, float] | ArrayLike) -> None:
        """Put joints somewhere at once: values by joint name, or all coordinates in order; radians and meters."""
    def set_groups(self, robot: str, groups: Iterable[JointGroup]) -> None:
        """Give a robot these groups of joints, in place of those that it has."""
    def set_postures(self, robot: str, postures: Mapping[str, Mapping[str, float]] | None = ..., *, removed: Iterable[str] = ...) -> None:
        """Take postures of a robot away by name, then add others (rad or m by joint name); see `Robot.postures`."""
    def select_tool(self, robot: str, tool: str | None = ..., tool_center_point: str | None = ...) -> None:
        """Choose what a robot works with; no tool means the flange, no point the tool's first."""
    def mount_tool(self, robot: str, node: str, parent: str | None = ..., pose: PoseLike | None = ..., tool_center_point: str | None = ...) -> None:
        """Mount a tool, a gripper, or an adapter with one, on a robot, which works with it then."""
    def unmount_tool(self, robot: str, node: str | None = ..., parent: str = ..., pose: PoseLike | None = ...) -> None:
        """Take a tool off a robot, by default the chosen one with its gripper, and fix it to `parent`, such as a rack."""
    def set_tool_state(self, tool: str, state: str) -> None:
        """Put a tool into a state at once, without a motion."""
    def create_signal(self, name: str, value: GivenValue = ..., **options: Unpack[SignalOptions]) -> None:
        """Add a signal, whose type is that of `value`."""
    def remove_signal(self, name: str) -> None:
        """Take a signal out of the world."""
    def set_signal(self, name: str, value: GivenValue) -> None:
        """Set a signal to a value of its type."""
    def set_speed_factor(self, factor: float, robot: str | None = ...) -> None:
        """Slow the motions of one robot, or with no name of all: above 0, up to 1; running ones change smoothly."""
    def set_tcp_speed_limit(self, limit: float, robot: str) -> None:
        """Limit the speed of a robot's tool centre point (m/s), as for teaching (0.25); 0 lifts the limit."""
    def set_kinematics(self, robot: str, kinematics: str | None = ..., settings: Mapping[str, object] | None = ...) -> None:
        """Give a robot another kinematics component, tried at its first use; `Robot.set_kinematics` tries it now."""
    def set_craft(self, robot: str, kinematics: str, settings: Mapping[str, object] | None = ..., drives: Mapping[str, str | tuple[str, float]] | None = ..., *, base_joint: str | None = ..., center: tuple[float, float] = ..., heading: float = ..., current: Sequence[float] = ..., density: float | None = ..., surface: float = ...) -> None:
        """Make a robot a craft: from now on its drives move its base."""
    def remove_craft(self, robot: str) -> None:
        """Make a robot no craft any more: its base is moved as other joints are."""
    def set_collisions(self, mode: str | None = ..., **options: Unpack[CollisionOptions]) -> None:
        """Change what is done about collisions, as `client.collisions.set` does."""
    def set_allowed_pairs(self, allow: Iterable[tuple[str, str, str]] = ..., forbid: Iterable[tuple[str, str]] = ...) -> None:
        """Let pairs touch no more, then let others (name, name, why) touch."""
    def start_sensors(self, *names: str) -> None:
        """Let sensors read at their rates (none named: all)."""
    def stop_sensors(self, *names: str) -> None:
        """Let sensors read no more (none named: all)."""

class Node(Face):
    """A node of the scene by its name. What it tells is read anew each time; `name`, `uid` and `kind` are kept."""
    name: object
    uid: object
    kind: object
    @property
    def info(self) -> Order[NodeInfo]:
        """Description of the node now."""
    @property
    def parent(self) -> Order[str]:
        """The name of the node that it is fixed to."""
    @property
    def hidden(self) -> Order[bool]:
        """True where it is hidden by itself (its ancestors may be hidden too)."""
    @property
    def figures(self) -> Order[tuple[Figure, ...]]:
        """Its shapes."""
    @property
    def pose(self) -> Order[Matrix]:
        """`world_t_node`, 4x4: its pose in the world's frame."""
    @property
    def parent_t_node(self) -> Order[Matrix]:
        """Pose in its parent's frame, 4x4; setting it moves the node at once."""
    def set_parent_t_node(self, value: PoseLike) -> Order[None]:
        """Set `parent_t_node`: Pose in its parent's frame, 4x4; setting it moves the node at once."""
    def attach(self, parent: str = ..., pose: PoseLike | None = ...) -> Order[None]:
        """Give it another parent; without `pose` (`parent_t_node`) it stays where it is in the world."""
    def rename(self, new_name: str) -> Order[None]:
        """Give it another name."""
    def hide(self, hidden: bool = ...) -> Order[None]:
        """Hide it and what hangs below, or show it again."""
    @property
    def description(self) -> Order[str]:
        """Description in words; set it, in at most 2000 characters, to say what it is or is for."""
    def set_description(self, value: Text) -> Order[None]:
        """Set `description`: Description in words; set it, in at most 2000 characters, to say what it is or is for."""
    @property
    def tags(self) -> Order[tuple[str, ...]]:
        """Words by which people and programs find it (`scene.nodes(tag="fixture")`); set it to others."""
    def set_tags(self, value: Iterable[str]) -> Order[None]:
        """Set `tags`: Words by which people and programs find it (`scene.nodes(tag="fixture")`); set it to others."""
    @property
    def locked(self) -> Order[bool]:
        """True where it can be neither changed nor removed."""
    def lock(self, locked: bool = ...) -> Order[None]:
        """Keep its name, parent, pose and figures as they are, and it in the world, or let go of it again."""
    def set_figures(self, figures: Figures) -> Order[None]:
        """Give it other shapes."""
    def remove(self) -> Order[None]:
        """Take it and all below it out of the world."""

class Scene(Face):
    """The tree of nodes of one kernel. Each change here is applied at once; `batch` applies several as one."""
    def add_object(self, name: str, figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> Order[Node]:
        """Add a piece of the environment: a table, a fence, or without figures a frame of reference."""
    def add_part(self, name: str, figures: Figures, *, pose: PoseLike | None = ..., parent: str = ..., mass: float | None = ..., inertial: Inertial | None = ..., dynamic: bool = ...) -> Order[Node]:
        """Add a thing that robots handle."""
    def add_adapter(self, name: str, parent: str, figures: Figures = ..., *, pose: PoseLike | None = ...) -> Order[Node]:
        """Add what stands between a flange (the link `parent`) and a tool."""
    def add_tool(self, name: str, parent: str, figures: Figures = ..., *, pose: PoseLike | None = ..., tool_center_points: Mapping[str, ArrayLike] | None = ..., states: Mapping[str, Mapping[str, float]] | None = ..., inertial: Inertial | None = ..., widths: Mapping[float, Mapping[str, float]] | None = ...) -> Order[Node]:
        """Mount a tool on a flange or adapter (`parent`)."""
    def add_camera(self, name: str, settings: CameraSettings | None = ..., figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> Order[Node]:
        """Add a camera; it looks along z of its pose (`parent_t_camera`), x to the right of the picture and y down."""
    def add_range_sensor(self, name: str, settings: RangeSensorSettings | None = ..., figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> Order[Node]:
        """Add a range sensor; it looks along x of its pose (`parent_t_sensor`), z upwards."""
    def add_light(self, name: str, settings: LightSettings | None = ..., figures: Figures = ..., *, pose: PoseLike | None = ..., parent: str = ...) -> Order[Node]:
        """Add a light, as `virtualrobot.light` makes it; spots and directional ones shine along z of their pose."""
    def add_motion_sensor(self, name: str, settings: MotionSensorSettings, figures: Figures = ..., *, parent: str, pose: PoseLike | None = ...) -> Order[Node]:
        """Fix a motion sensor to something that moves; `pose` is `parent_t_sensor`."""
    def add_contact_sensor(self, name: str, settings: ContactSensorSettings | None = ..., figures: Figures = ..., *, parent: str = ..., pose: PoseLike | None = ...) -> Order[Node]:
        """Add a contact sensor, as `virtualrobot.contact_sensor` makes it; without a `watched` node its parent feels."""
    def add_annotation(self, name: str, figures: Figures, *, pose: PoseLike | None = ..., parent: str = ...) -> Order[Node]:
        """Add something that is drawn for people only."""
    def add_frame(self, name: str, *, pose: PoseLike | None = ..., parent: str = ..., size: float | None = ...) -> Order[Node]:
        """Add a frame of reference, drawn as arrows of `size` meters (0.1 by default): x red, y green, z blue."""
    def add_target(self, name: str, *, pose: PoseLike | None = ..., parent: str = ..., robot: str = ..., joint_positions: Mapping[str, float] | None = ...) -> Order[Node]:
        """Add a target, a place where tools work, at a pose (`parent_t_target`); `Robot.teach` saves one."""
    def add_viewpoint(self, name: str, *, pose: PoseLike | None = ..., parent: str = ..., distance: float | None = ..., field_of_view: float | None = ...) -> Order[Node]:
        """Add a viewpoint, a view of people under a name, at a pose (`parent_t_eye`); `client.view.save` saves one."""
    def set_viewpoint(self, name: str, distance: float | None = ..., field_of_view: float | None = ...) -> Order[None]:
        """Change how far ahead of a viewpoint is what is looked at (m), and its field of view (rad), as it is added."""
    def rename(self, name: str, new_name: str) -> Order[None]:
        """Give a node another name."""
    def hide(self, name: str, hidden: bool = ...) -> Order[None]:
        """Hide a node and what hangs below, or show it again."""
    def describe(self, name: str, description: Text | None = ..., *, tags: Iterable[str] | None = ..., icon: str | None = ...) -> Order[None]:
        """Say what a node is for, by which words it is found, and which icon pages show for it; what is None stays."""
    def lock(self, name: str, locked: bool = ...) -> Order[None]:
        """Keep a node's name, parent, pose and figures as they are, and it in the world, or let go of it again."""
    def set_pose(self, name: str, parent_t_node: PoseLike) -> Order[None]:
        """Put a node somewhere else in its parent's frame, at once."""
    def set_figures(self, name: str, figures: Figures) -> Order[None]:
        """Give a node other shapes."""
    def remove(self, name: str) -> Order[None]:
        """Take a node and all below it out of the world."""
    def attach(self, name: str, parent: str = ..., pose: PoseLike | None = ...) -> Order[None]:
        """Give a node another parent; without `pose` (`parent_t_node`) it stays where it is in the world."""
    def pick(self, robot: str, part: str | None = ..., max_distance: float | None = ...) -> Order[None]:
        """Fix a part to the robot's chosen tool; without a name the one nearest to the tool centre point."""
    def place(self, robot: str, part: str | None = ..., parent: str = ...) -> Order[None]:
        """Let a part of the robot's chosen tool go, or all parts; it stays where it is, fixed to `parent`."""
    def set_joint_positions(self, robot: str, positions: Mapping[str, float] | ArrayLike) -> Order[None]:
        """Put joints somewhere at once: values by joint name, or all coordinates in order; radians and meters."""
    def set_groups(self, robot: str, groups: Iterable[JointGroup]) -> Order[None]:
        """Give a robot these groups of joints, in place of those that it has."""
    def set_postures(self, robot: str, postures: Mapping[str, Mapping[str, float]] | None = ..., *, removed: Iterable[str] = ...) -> Order[None]:
        """Take postures of a robot away by name, then add others (rad or m by joint name); see `Robot.postures`."""
    def select_tool(self, robot: str, tool: str | None = ..., tool_center_point: str | None = ...) -> Order[None]:
        """Choose what a robot works with; no tool means the flange, no point the tool's first."""
    def mount_tool(self, robot: str, node: str, parent: str | None = ..., pose: PoseLike | None = ..., tool_center_point: str | None = ...) -> Order[None]:
        """Mount a tool, a gripper, or an adapter with one, on a robot, which works with it then."""
    def unmount_tool(self, robot: str, node: str | None = ..., parent: str = ..., pose: PoseLike | None = ...) -> Order[None]:
        """Take a tool off a robot, by default the chosen one with its gripper, and fix it to `parent`, such as a rack."""
    def set_tool_state(self, tool: str, state: str) -> Order[None]:
        """Put a tool into a state at once, without a motion."""
    def create_signal(self, name: str, value: GivenValue = ..., **options: Unpack[SignalOptions]) -> Order[None]:
        """Add a signal, whose type is that of `value`."""
    def remove_signal(self, name: str) -> Order[None]:
        """Take a signal out of the world."""
    def set_signal(self, name: str, value: GivenValue) -> Order[None]:
        """Set a signal to a value of its type."""
    def set_speed_factor(self, factor: float, robot: str | None = ...) -> Order[None]:
        """Slow the motions of one robot, or with no name of all: above 0, up to 1; running ones change smoothly."""
    def set_tcp_speed_limit(self, limit: float, robot: str) -> Order[None]:
        """Limit the speed of a robot's tool centre point (m/s), as for teaching (0.25); 0 lifts the limit."""
    def set_kinematics(self, robot: str, kinematics: str | None = ..., settings: Mapping[str, object] | None = ...) -> Order[None]:
        """Give a robot another kinematics component, tried at its first use; `Robot.set_kinematics` tries it now."""
    def set_craft(self, robot: str, kinematics: str, settings: Mapping[str, object] | None = ..., drives: Mapping[str, str | tuple[str, float]] | None = ..., *, base_joint: str | None = ..., center: tuple[float, float] = ..., heading: float = ..., current: Sequence[float] = ..., density: float | None = ..., surface: float = ...) -> Order[None]:
        """Make a robot a craft: from now on its drives move its base."""
    def remove_craft(self, robot: str) -> Order[None]:
        """Make a robot no craft any more: its base is moved as other joints are."""
    def set_collisions(self, mode: str | None = ..., **options: Unpack[CollisionOptions]) -> Order[None]:
        """Change what is done about collisions, as `client.collisions.set` does."""
    def set_allowed_pairs(self, allow: Iterable[tuple[str, str, str]] = ..., forbid: Iterable[tuple[str, str]] = ...) -> Order[None]:
        """Let pairs touch no more, then let others (name, name, why) touch."""
    def start_sensors(self, *names: str) -> Order[None]:
        """Let sensors read at their rates (none named: all)."""
    def stop_sensors(self, *names: str) -> Order[None]:
        """Let sensors read no more (none named: all)."""
    def nodes(self, kind: str | None = ..., *, tag: str | None = ...) -> Order[list[Node]]:
        """Return all nodes, parents before children, or those of a kind such as `part`, or with a tag, or both."""
    def node(self, name: str) -> Order[Node]:
        """Return the node of this name; raises UnknownNameError when there is none."""
    def targets(self) -> Order[dict[str, Target]]:
        """Return all targets by name: places that were taught, or added by `add_target`."""
    def target(self, name: str) -> Order[Target]:
        """Return the target of this name; raises UnknownNameError when there is none."""
    def viewpoints(self) -> Order[dict[str, Viewpoint]]:
        """Return all viewpoints by name: views that people have saved, or added by `add_viewpoint`."""
    def viewpoint(self, name: str) -> Order[Viewpoint]:
        """Return the viewpoint of this name; raises UnknownNameError when there is none."""
    def pose(self, name: str) -> Order[Matrix]:
        """Return `world_t_node`, 4x4: where a node is in the world now."""
    def poses(self, names: Sequence[str] = ...) -> Order[dict[str, Matrix]]:
        """Return `world_t_node`, 4x4, by name, of all nodes or of these, all of the same instant."""
    def bounds(self, name: str) -> Order[Matrix | None]:
        """Return the box about a node and all below it, (2, 3): least and greatest x, y, z in its own frame (m)."""
    def twists(self, *names: str) -> Order[dict[str, Matrix]]:
        """Return how fast nodes are now, (6,) by name, all of the same instant."""
    @property
    def revision(self) -> Order[int]:
        """The revision of the structure, for `batch(expected_structure_revision=...)`."""
    def tree(self, links: bool = ...) -> Order[str]:
        """Return the scene as a drawn tree; without `links` what hangs there is shown at the robot."""
    def watch(self, names: Sequence[str] = ..., max_rate: float | None = ...) -> AsyncIterator[SceneChange]:
        """Yield the whole scene and then what changes, at most `max_rate` (30 by default) times a second."""
    def batch(self, expected_structure_revision: int | None = ..., *, request_id: str | None = ...) -> AbstractAsyncContextManager[Batch]:
        """Collect changes and apply them as one at the end of the block, all or none."""
    def load(self, file: str | Path, *, as_part: bool = ..., scale: float | Sequence[float] = ..., **options: Unpack[LoadOptions]) -> Order[Node]:
        """Load a model (URDF, a mesh, or what an importer reads) and return its node: a robot, an object or a part."""
    @property
    def warnings(self) -> tuple[FileWarning, ...]:
        """Warnings about the model or scene file that was loaded last, and about what it names."""
    @property
    def allowed_pairs(self) -> tuple[AllowedPair, ...]:
        """Pairs that touch as the model that was loaded last is built or stands, and so may touch from then on."""
    def export(self, node: Text | Node | Robot, file: str | Path, *, tolerance: float = ...) -> Order[Export]:
        """Write a robot as URDF (`.urdf`), or whatever hangs below a node as binary glTF or USDZ, to this machine."""
    def load_scene(self, file: str | Path, *, add: bool = ..., packages: Mapping[str, str | Path] | None = ..., strict: bool = ..., request_id: str | None = ...) -> Order[list[str]]:
        """Replace the world by a scene file of this machine, or `add` it; return the names of the created nodes."""
    def clear(self) -> Order[None]:
        """Take everything out of the world: all nodes and signals; motions end."""
    def save(self, file: str | Path, *, bundle: bool = ...) -> Order[list[Path]]:
        """Write the world to a scene file; with `bundle` put the files that it names beside it, under `assets/`."""
    def __getitem__(self, name: str) -> Order[Node]:
        """Return the node of this name; raises UnknownNameError, a KeyError, when there is none."""
    def __aiter__(self) -> Scene: ...
    async def __anext__(self) -> str: ...

class Target(Face):
    """Target of the scene by its name, a node like others: it is renamed, attached, hidden and removed as they are."""
    name: object
    uid: object
    kind: object
    @property
    def info(self) -> Order[NodeInfo]:
        """Description of the node now."""
    @property
    def parent(self) -> Order[str]:
        """The name of the node that it is fixed to."""
    @property
    def hidden(self) -> Order[bool]:
        """True where it is hidden by itself (its ancestors may be hidden too)."""
    @property
    def figures(self) -> Order[tuple[Figure, ...]]:
        """Its shapes."""
    @property
    def pose(self) -> Order[Matrix]:
        """`world_t_node`, 4x4: its pose in the world's frame."""
    @property
    def parent_t_node(self) -> Order[Matrix]:
        """Pose in its parent's frame, 4x4; setting it moves the node at once."""
    def set_parent_t_node(self, value: PoseLike) -> Order[None]:
        """Set `parent_t_node`: Pose in its parent's frame, 4x4; setting it moves the node at once."""
    def attach(self, parent: str = ..., pose: PoseLike | None = ...) -> Order[None]:
        """Give it another parent; without `pose` (`parent_t_node`) it stays where it is in the world."""
    def rename(self, new_name: str) -> Order[None]:
        """Give it another name."""
    def hide(self, hidden: bool = ...) -> Order[None]:
        """Hide it and what hangs below, or show it again."""
    @property
    def description(self) -> Order[str]:
        """Description in words; set it, in at most 2000 characters, to say what it is or is for."""
    def set_description(self, value: Text) -> Order[None]:
        """Set `description`: Description in words; set it, in at most 2000 characters, to say what it is or is for."""
    @property
    def tags(self) -> Order[tuple[str, ...]]:
        """Words by which people and programs find it (`scene.nodes(tag="fixture")`); set it to others."""
    def set_tags(self, value: Iterable[str]) -> Order[None]:
        """Set `tags`: Words by which people and programs find it (`scene.nodes(tag="fixture")`); set it to others."""
    @property
    def locked(self) -> Order[bool]:
        """True where it can be neither changed nor removed."""
    def lock(self, locked: bool = ...) -> Order[None]:
        """Keep its name, parent, pose and figures as they are, and it in the world, or let go of it again."""
    def set_figures(self, figures: Figures) -> Order[None]:
        """Give it other shapes."""
    def remove(self) -> Order[None]:
        """Take it and all below it out of the world."""
    @property
    def robot(self) -> Order[str]:
        """The robot that it was taught with; empty for none, or one that is gone."""
    @property
    def tool(self) -> Order[str]:
        """The tool that the robot worked with; empty for none, or one that is gone."""
    @property
    def tool_center_point(self) -> Order[str]:
        """The name of that tool's tool centre point."""
    @property
    def joint_positions(self) -> Order[dict[str, float]]:
        """The posture in which it was taught, radians and meters by joint name."""

class Viewpoint(Face):
    """Viewpoint of the scene by its name, a node like others: it is renamed, attached and removed as they are."""
    name: object
    uid: object
    kind: object
    @property
    def info(self) -> Order[NodeInfo]:
        """Description of the node now."""
    @property
    def parent(self) -> Order[str]:
        """The name of the node that it is fixed to."""
    @property
    def hidden(self) -> Order[bool]:
        """True where it is hidden by itself (its ancestors may be hidden too)."""
    @property
    def figures(self) -> Order[tuple[Figure, ...]]:
        """Its shapes."""
    @property
    def pose(self) -> Order[Matrix]:
        """`world_t_node`, 4x4: its pose in the world's frame."""
    @property
    def parent_t_node(self) -> Order[Matrix]:
        """Pose in its parent's frame, 4x4; setting it moves the node at once."""
    def set_parent_t_node(self, value: PoseLike) -> Order[None]:
        """Set `parent_t_node`: Pose in its parent's frame, 4x4; setting it moves the node at once."""
    def attach(self, parent: str = ..., pose: PoseLike | None = ...) -> Order[None]:
        """Give it another parent; without `pose` (`parent_t_node`) it stays where it is in the world."""
    def rename(self, new_name: str) -> Order[None]:
        """Give it another name."""
    def hide(self, hidden: bool = ...) -> Order[None]:
        """Hide it and what hangs below, or show it again."""
    @property
    def description(self) -> Order[str]:
        """Description in words; set it, in at most 2000 characters, to say what it is or is for."""
    def set_description(self, value: Text) -> Order[None]:
        """Set `description`: Description in words; set it, in at most 2000 characters, to say what it is or is for."""
    @property
    def tags(self) -> Order[tuple[str, ...]]:
        """Words by which people and programs find it (`scene.nodes(tag="fixture")`); set it to others."""
    def set_tags(self, value: Iterable[str]) -> Order[None]:
        """Set `tags`: Words by which people and programs find it (`scene.nodes(tag="fixture")`); set it to others."""
    @property
    def locked(self) -> Order[bool]:
        """True where it can be neither changed nor removed."""
    def lock(self, locked: bool = ...) -> Order[None]:
        """Keep its name, parent, pose and figures as they are, and it in the world, or let go of it again."""
    def set_figures(self, figures: Figures) -> Order[None]:
        """Give it other shapes."""
    def remove(self) -> Order[None]:
        """Take it and all below it out of the world."""
    @property
    def distance(self) -> Order[float]:
        """Distance from the eye to what is looked at, in meters."""
    @property
    def field_of_view(self) -> Order[float]:
        """The vertical field of view in radians."""

class Rays(Face):
    """Rays through the world of one kernel."""
    def cast(self, origins: ArrayLike, directions: ArrayLike, *, frame: str = ..., max_range: float | None = ..., ray_caster: str = ..., ignored: str | Iterable[str] = ...) -> Order[RayHits]:
        """Return what n rays hit in the world as it is now."""
    def compare(self, ray_casters: Sequence[str] = ..., *, count: int | None = ..., seed: int = ..., progress: Callable[[float], None] | None = ...) -> Order[list[RayCasterComparison]]:
        """Return how ray casters agree on random rays through the world as it is now, and what they cost."""

class Sensor(Face):
    """One sensor by its name; `client.sensors["lidar"]` makes it."""
    name: str
    @property
    def status(self) -> Order[SensorStatus]:
        """Status of the sensor now."""
    def start(self) -> Order[None]:
        """Let it read at its rate; one with a fault is tried anew."""
    def stop(self) -> Order[None]:
        """Stop reading."""
    def read(self, **options: Unpack[ReadingOptions]) -> Order[Reading]:
        """Return one reading of the world as it is now, whether the sensor runs or not."""
    def watch(self, *, max_rate: float | None = ..., **options: Unpack[ReadingOptions]) -> AsyncIterator[Reading]:
        """Yield the latest reading and then each new one; who is slow gets the latest."""
    def set_ray_caster(self, name: str, settings: Mapping[str, object] | None = ...) -> Order[ComponentTrial]:
        """Give a range sensor another ray caster, while it runs or not; it is tried first."""
    def set_model(self, name: str, settings: Mapping[str, object] | None = ...) -> Order[ComponentTrial]:
        """Give a range sensor another sensor model, while it runs or not; it is tried first."""

class Sensors(Face):
    """The sensors of one kernel by name; they are made and removed as nodes of the scene."""
    def __getitem__(self, name: str) -> Order[Sensor]:
        """Return a sensor; raises UnknownNameError, a KeyError, when there is none of this name."""
    def statuses(self) -> Order[list[SensorStatus]]:
        """Return how all sensors are, in the order of their creation."""
    def status(self, name: str) -> Order[SensorStatus]:
        """Return how a sensor is; raises UnknownNameError, a KeyError, when there is none of this name."""
    def start(self, *names: str) -> Order[None]:
        """Let sensors read at their rates (none named: all)."""
    def stop(self, *names: str) -> Order[None]:
        """Let sensors read no more (none named: all)."""
    def watch(self, *names: str, max_rate: float | None = ..., **options: Unpack[ReadingOptions]) -> AsyncIterator[Reading]:
        """Yield the readings of several sensors (none named: all, later ones too); see `Sensor.watch`."""
    def presets(self) -> Order[dict[str, SensorPreset]]:
        """Return the devices that a range sensor may be set as, by name."""
    def __aiter__(self) -> Sensors: ...
    async def __anext__(self) -> str: ...

class Publisher(Face):
    """Publisher to one stream; a context manager. `Streams.publisher` makes it."""
    stream: Stream
    def send(self, value: GivenValue | Mapping[str, float] | ArrayLike) -> Order[None]:
        """Publish a value: of a signal its value, else numbers in the order of the joints, or by name."""
    def check(self) -> Order[None]:
        """Raise why a robot follows no more, such as a value that was refused; nothing while all is well."""
    def close(self) -> Order[None]:
        """Let a robot come to rest."""
    async def __aenter__(self) -> Publisher: ...

class Streams(Face):
    """The streams of one kernel, like a dictionary of names to rows of the table."""
    def __getitem__(self, name: str) -> Order[Stream]:
        """Return a stream; raises UnknownNameError, a KeyError, when there is none of this name."""
    def table(self) -> Order[list[Stream]]:
        """Return the streams that there are now, in the table's order."""
    def watch(self, *names: str) -> Order[StreamWatch]:
        """Watch streams by their names, or by patterns such as `/robots/*`; every tick and reading comes."""
    def sample(self, name: str, timeout: float = ...) -> Order[Sample]:
        """Return the next sample of a stream; raises CallTimeoutError after `timeout` (s of the wall clock) without."""
    def scan_geometry(self, sensor: str) -> Order[ScanGeometry]:
        """Return what the distances of a range sensor are measured along, and how far; for those who draw them."""
    def publisher(self, name: str, *, timeout: float = ...) -> Order[Publisher]:
        """Publish to a stream that the world hears: a signal, or commands of a robot."""
    def __aiter__(self) -> Streams: ...
    async def __anext__(self) -> str: ...

class StreamWatch(Face):
    """Samples of streams as they come, every tick and every reading, until it is closed. `Streams.watch` makes it."""
    streams: object
    def next(self, timeout: float) -> Order[Sample | None]:
        """Return the next sample; None where none has come after `timeout` seconds of the wall clock."""
    def close(self) -> Order[None]:
        """End it; any thread may."""
    async def __aenter__(self) -> StreamWatch: ...
    def __aiter__(self) -> StreamWatch: ...
    async def __anext__(self) -> Sample: ...

class FilmThread(Face):
    """Writes a film in a thread of its own while the program goes on; `finish` or `cancel` ends it."""
    @property
    def ended(self) -> Order[bool]:
        """True once no picture comes any more; `finish` tells why."""
    def finish(self) -> Order[int]:
        """Wait until all is drawn that has happened so far, and return how many pictures there are."""
    def cancel(self) -> Order[None]:
        """End it with the pictures that are drawn."""
    async def __aenter__(self) -> FilmThread: ...

class PictureRecording(Face):
    """Pictures of a film as they are drawn; it ends with its time, or when it is cancelled."""
    def cancel(self) -> Order[None]:
        """End it; pictures that are not drawn yet are not drawn."""
    async def __aenter__(self) -> PictureRecording: ...
    def __aiter__(self) -> PictureRecording: ...
    async def __anext__(self) -> Picture: ...

class View(Face):
    """Picture in every open viewer of one kernel."""
    def read(self) -> Order[ViewState]:
        """Return the set-up now."""
    def watch(self) -> AsyncIterator[ViewState]:
        """Yield the set-up now and after each change."""
    @property
    def viewer_count(self) -> Order[int]:
        """Number of browsers that show it now."""
    @property
    def background(self) -> Order[NDArray[float64]]:
        """The colour behind everything, red, green, blue, 0 to 1; set it to anything that names a colour."""
    def set_background(self, value: str | ArrayLike) -> Order[None]:
        """Set `background`: The colour behind everything, red, green, blue, 0 to 1; set it to anything that names a colour."""
    @property
    def grid(self) -> Order[bool]:
        """True where the grid on the floor is shown."""
    def set_grid(self, value: bool) -> Order[None]:
        """Set `grid`: True where the grid on the floor is shown."""
    @property
    def collisions(self) -> Order[bool]:
        """True where nodes that the collision monitor finds to touch are red, and the background rose meanwhile."""
    def set_collisions(self, value: bool) -> Order[None]:
        """Set `collisions`: True where nodes that the collision monitor finds to touch are red, and the background rose meanwhile."""
    @property
    def joint_axes(self) -> Order[list[str]]:
        """The robots whose joint axes are shown."""
    def set_joint_axes(self, value: Iterable[str]) -> Order[None]:
        """Set `joint_axes`: The robots whose joint axes are shown."""
    @property
    def bounding_boxes(self) -> Order[list[str]]:
        """The nodes whose bounding boxes are shown."""
    def set_bounding_boxes(self, value: Iterable[str]) -> Order[None]:
        """Set `bounding_boxes`: The nodes whose bounding boxes are shown."""
    @property
    def measurements(self) -> Order[dict[str, tuple[Place, Place]]]:
        """The distances that are shown, by name; set it to show others."""
    def set_measurements(self, value: Mapping[str, tuple[Place, Place]]) -> Order[None]:
        """Set `measurements`: The distances that are shown, by name; set it to show others."""
    @property
    def clearances(self) -> Order[dict[str, tuple[list[str], list[str]]]]:
        """The least distances that are shown between what can collide, by name; set it to show others."""
    def set_clearances(self, value: Mapping[str, tuple[str | Iterable[str], str | Iterable[str]]]) -> Order[None]:
        """Set `clearances`: The least distances that are shown between what can collide, by name; set it to show others."""
    @property
    def ghosts(self) -> Order[dict[str, Ghost]]:
        """Robots that are shown, translucent, where they are not, by name; set it to show others."""
    def set_ghosts(self, value: Mapping[str, Ghost | tuple[str, Positions]]) -> Order[None]:
        """Set `ghosts`: Robots that are shown, translucent, where they are not, by name; set it to show others."""
    @property
    def sensors(self) -> Order[dict[str, SensorOverlay]]:
        """Overlays of sensors, by the sensors' names."""
    def show_sensor(self, sensor: str, *, points: bool = ..., rays: bool = ..., color_by: str = ..., frustum: bool = ..., image: bool = ...) -> Order[None]:
        """Show what a sensor says, in every open viewer; what was shown of it before is replaced."""
    def hide_sensor(self, *sensors: str) -> Order[None]:
        """Show nothing of these sensors; without a name, of none. One that is not shown is none to hide."""
    def set_camera(self, position: ArrayLike, target: ArrayLike = ..., field_of_view: float | None = ..., *, node: str = ..., keeps_direction: bool = ...) -> Order[None]:
        """Look from `position` at `target`, meters in the world's frame, or in that of a node, and go along with it."""
    def eye_and_target(self) -> Order[tuple[Vector, Vector] | None]:
        """Return from where the view looks now and at what, (3,) each, meters in the world's frame."""
    def follow(self, node: str, *, turns: bool = ...) -> Order[None]:
        """Have the view go along with a node, in every open viewer, pictures and films; with "world" it stays."""
    def save(self, name: str) -> Order[Viewpoint]:
        """Save from where the view looks as a viewpoint of the scene; one of this name looks from there then."""
    def look_from(self, viewpoint: str) -> Order[None]:
        """Look from a viewpoint of the scene, in every open viewer, and go along with it where it moves."""
    def measure(self, first: Place, second: Place) -> Order[Measure]:
        """Return how far two points are apart now."""
    def watch_measure(self, first: Place, second: Place, max_rate: float | None = ...) -> AsyncIterator[Measure]:
        """Yield how far two points are apart now and whenever that changes, at most `max_rate` (30) times a second."""
    def capture(self, camera: Camera | None = ..., *, size: Size | None = ..., format: str = ..., plain: bool = ...) -> Order[Picture]:
        """Return a picture of the world as it is now; it needs no browser."""
    def capture_model(self, name: str) -> Order[Picture]:
        """Return a small picture of a known model that is installed, a PNG file; it is taken once and kept."""
    def record(self, camera: Camera | None = ..., *, size: Size | None = ..., format: str = ..., plain: bool = ..., rate: float = ..., duration: float | None = ...) -> Order[PictureRecording]:
        """Return pictures at equal steps of simulation time, none left out, however long each takes to be drawn."""
    def film(self, path: str | Path, camera: Camera | None = ..., *, duration: float | None = ..., size: Size | None = ..., plain: bool = ..., rate: float = ..., told: Callable[[Picture], None] | None = ...) -> Order[int]:
        """Film so much simulation time, and return how many pictures there are; arguments are those of `record`."""
    def start_film(self, path: str | Path, camera: Camera | None = ..., *, size: Size | None = ..., plain: bool = ..., rate: float = ..., told: Callable[[Picture], None] | None = ...) -> Order[FilmThread]:
        """Begin to film while the program goes on; the end of the block draws the rest and closes the file."""
    def pick(self, column: float, row: float, camera: Camera | None = ..., *, size: Size | None = ...) -> Order[Picked]:
        """Return what is under a pixel of a picture that `capture` takes with this camera and size."""
    def add_points(self, positions: ArrayLike, *, color: str | ArrayLike | None = ..., colors: ArrayLike | None = ..., size: float | None = ..., name: str | None = ..., pose: PoseLike | None = ..., parent: str = ...) -> Order[Node]:
        """Show points (n, 3) in meters, with one colour or `colors` (n, 3), 0 to 255; `remove()` takes them away."""
    def add_lines(self, segments: ArrayLike, *, color: str | ArrayLike | None = ..., width: float | None = ..., name: str | None = ..., pose: PoseLike | None = ..., parent: str = ...) -> Order[Node]:
        """Show line segments (n, 2, 3), or a line through points (n, 3), in meters; options as in `add_points`."""
    def add_frame(self, pose: PoseLike | None = ..., *, length: float | None = ..., name: str | None = ..., parent: str = ...) -> Order[Node]:
        """Show a frame, x red, y green, z blue, at `pose` (`parent_t_node`); `length` is 0.1 m by default."""
    def add_label(self, text: Text, pose: PoseLike | None = ..., *, name: str | None = ..., parent: str = ...) -> Order[Node]:
        """Show words at `pose` (`parent_t_node`)."""
    def add_coat(self, name: str, node: str, vertices: ArrayLike, faces: ArrayLike, *, low: float, high: float, unit: str = ..., title: str = ..., color_map: str = ...) -> Order[CoatHandle]:
        """Put triangles on a node that are coloured by a quantity at each corner, in place of a coat of the same name."""
    def watch_coats(self) -> AsyncIterator[dict[str, NDArray[uint8]]]:
        """Yield the bytes of all coats by name, now and after changes, at most ten times a second."""
    def remove_coats(self, names: str | Iterable[str] = ...) -> Order[None]:
        """Take coats away; without names all."""

def connect(address: str | None = ..., token: Text | None = ..., *, token_file: str | Path | None = ..., root_certificate: str | Path | None = ..., timeout: float = ..., name: str | None = ..., on_progress: OnProgress | None = ...) -> Order[Client]:
    """Connect to a kernel and return the client."""
