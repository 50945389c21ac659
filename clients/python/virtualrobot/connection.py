"""The connection to a kernel, from which everything else is reached."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Unpack

from virtualrobot._wire.arguments import PoseLike, Text, checked
from virtualrobot._wire.messages import count_or_default, value_or_default
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot._wire.transport import Channel
from virtualrobot.cell import Cell
from virtualrobot.clock import Clock
from virtualrobot.collisions.collisions import Collisions
from virtualrobot.drivers import Drivers
from virtualrobot.errors import WrongStateError
from virtualrobot.files.assets import Assets
from virtualrobot.files.scene_files import model_request
from virtualrobot.files.writing import write_file
from virtualrobot.history.history import History
from virtualrobot.history.values import Step
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.leases import Lease, LeaseInfo, acquire, list_leases, watch_leases
from virtualrobot.motions import motion, plans
from virtualrobot.motions.motion import Motion, Tracking
from virtualrobot.motions.moves import Move
from virtualrobot.motions.paths import Paths
from virtualrobot.motions.program import Program, parsed, read
from virtualrobot.motions.proposals import Proposals
from virtualrobot.motions.steps import Named, name_of
from virtualrobot.physics import Physics
from virtualrobot.plugins import Plugins
from virtualrobot.recording.recording import Recorded, Recording
from virtualrobot.recording.start import RecordingOptions, start
from virtualrobot.records import Records
from virtualrobot.robots.denavit_hartenberg import Row, table_message
from virtualrobot.robots.models import KnownModel, known_models
from virtualrobot.robots.robot import Robot
from virtualrobot.robots.robots import Robots
from virtualrobot.scene.editor import Direct
from virtualrobot.scene.scene import LoadOptions, Scene
from virtualrobot.scene.target import Target
from virtualrobot.sensors.rays import Rays
from virtualrobot.sensors.sensors import Sensors
from virtualrobot.signals import Signals
from virtualrobot.streams.streams import Streams
from virtualrobot.tasks import Tasks
from virtualrobot.tokens import Tokens, role_name
from virtualrobot.v1 import kernel_pb2, motion_pb2, scene_pb2
from virtualrobot.view.view import View


@shown
@dataclass(frozen=True, slots=True)
class KernelInfo:
    """Versions, limits and capabilities of a kernel.

    Attributes:
        version: the version of its package, such as 0.2.0.
        api_version: the version of the contract: virtualrobot.v1.
        capabilities: what it can do, such as `motion.linear` or `viewer`.
        model_formats: the endings of the model files that it reads.
        kinematics: its kinematics components by name.
        max_message_bytes: size of the largest message.
        max_asset_bytes: size of the largest file that can be uploaded.
        viewer_url: the address of the viewer for a browser on its machine; empty without viewer.
        process_id: its process number on its machine.
        role: what this client may do: `observer`, `operator`, `engineer` or `admin`.
        token_name: the name of its token; empty for the kernel's own, and where none is wanted.
        limits: the kernel's limits by name, such as `limits["nodes"]`.
    """

    version: str
    api_version: str
    capabilities: tuple[str, ...]
    model_formats: tuple[str, ...]
    kinematics: tuple[str, ...]
    max_message_bytes: int
    max_asset_bytes: int
    viewer_url: str
    process_id: int
    role: str = ""
    token_name: str = ""
    limits: dict[str, int] = field(default_factory=dict)

    @staticmethod
    def of(message: kernel_pb2.GetInfoResponse) -> KernelInfo:
        """Return what a message tells."""
        return KernelInfo(
            message.version,
            message.api_version,
            tuple(message.capabilities),
            tuple(message.model_formats),
            tuple(message.kinematics),
            message.max_message_bytes,
            message.max_asset_bytes,
            message.viewer_url,
            message.process_id,
            role_name(message.role),
            message.token_name,
            {limit.name: limit.value for limit in message.limits},
        )


@checked
class Client:
    """A connection to one kernel; a context manager. `virtualrobot.connect` makes it.

    Attributes:
        scene: the tree of nodes: `client.scene.add_part(...)`, `client.scene.load(...)`, `print(client.scene.tree())`.
        robots: robots by name: `client.robots["arm"]`; `client.robots()` returns all.
        signals: signals, like a dictionary.
        clock: the simulation clock.
        cell: all robots together: `client.cell.stop("a hand in the cell")`, until `client.cell.release()`.
        view: the picture in the browser.
        assets: files to and from the kernel.
        plugins: the kernel's plugins: `client.plugins.list()`.
        physics: parts that forces move: `client.physics.set("mujoco")`.
        rays: ray casts: `client.rays.cast(...)`.
        collisions: collisions and distances: `client.collisions.check()`.
        tokens: who is let in, and with which role: `client.tokens.create("panel", "operator")`.
        proposals: motions that people approve: `client.proposals.create([arm.linear(goal)])`.
        records: what clients tell each other: `client.records.create("note", {"text": "oiled"})`.
        tasks: programs at work, whoever runs them: `client.tasks.stop("T_ROB1")`.
        paths: free ways around what stands in between: `client.paths.find("arm", goal)`.
        sensors: sensors by name: `client.sensors["lidar"].read()`.
        streams: all that the world tells, by name: `client.streams.watch("/robots/arm/tcp")`.
        history: who has changed what, and the way back: `client.history.list()`, `client.history.checkpoint()`.
        info: versions, limits and capabilities of the kernel, as it was when connected, a `KernelInfo`.
    """

    def __init__(self, channel: Channel, address: str, info: KernelInfo) -> None:
        """Take a channel to a kernel that has answered."""
        self._channel = channel
        self._own_kernel: KernelProcess | None = None
        self._services = Services(channel, address)
        self.address = address
        self.info = info
        self.scene = Scene(self._services)
        self.robots = Robots(self._services)
        self.signals = Signals(self._services)
        self.clock = Clock(self._services)
        self.cell = Cell(self._services)
        self.view = View(self._services, self.scene)
        self.assets = Assets(self._services)
        self.plugins = Plugins(self._services)
        self.physics = Physics(self._services)
        self.rays = Rays(self._services)
        self.collisions = Collisions(self._services)
        self.sensors = Sensors(self._services)
        self.streams = Streams(self._services)
        self.paths = Paths(self._services)
        self.proposals = Proposals(self._services)
        self.records = Records(self._services)
        self.tasks = Tasks(self._services)
        self.history = History(self._services)
        self.tokens = Tokens(self._services)
        self.drivers = Drivers(self._services)

    @property
    def services(self) -> Services:
        """The stubs of the contract, for what has no handle here; errors are raised as everywhere."""
        return self._services

    def robot(self, name: str) -> Robot:
        """Return the robot of this name, as `robots[name]` does.

        Raises UnknownNameError, which lists the right names, when there is none.
        """
        return self.robots[name]

    @property
    def targets(self) -> dict[str, Target]:
        """The targets of the scene by name: places that robots were taught; see `Robot.teach`."""
        return self.scene.targets()

    def load_robot(self, file: str | Path, **options: Unpack[LoadOptions]) -> Robot:
        """Load a robot from a model file and return it; as `Scene.load` does.

        Example:
            >>> robot = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
            >>> other = client.load_robot("arm.urdf.xacro", settings={"arguments": {"prefix": "left_"}})
        """
        node = self.scene.load(file, **options)
        if node.kind != "robot":
            raise WrongStateError(f"{file} is no robot: it was loaded as the {node.kind} {node.name!r}")
        return Robot(self._services, node.name)

    def load_denavit_hartenberg(
        self,
        rows: Iterable[Row],
        *,
        convention: str,
        name: str | None = None,
        pose: PoseLike | None = None,
        parent: str = "world",
        base_t_first: PoseLike | None = None,
        last_t_flange: PoseLike | None = None,
        request_id: str | None = None,
    ) -> Robot:
        """Make a serial arm of a Denavit-Hartenberg table and return it.

        Args:
            rows: the joints from base to tip, each the four numbers a (m), alpha (rad), d (m), theta (rad), or a
                dictionary with those of them that are not 0 and, where wanted, `name`, `type` (`revolute`,
                `continuous` or `prismatic`) and `limits`: (lower, upper), or a dictionary with those of `lower`,
                `upper`, `velocity`, `acceleration`, `jerk` and `effort` that are known. A turning joint's position is
                added to theta, a sliding one's to d. Without `type` a joint turns: between its limits where it has
                some.
            convention: `standard`: theta and d about and along z, then a and alpha along and about x (Paul 1981); or
                `modified`: alpha and a first, then theta and d (Craig 1986).
            name: the robot's name; by default one that the kernel gives.
            pose: `parent_t_node`, 4x4.
            parent: the node that it is fixed to.
            base_t_first: pose of the frame before the first row in the robot's frame, 4x4.
            last_t_flange: pose of the flange in the frame of the last row, 4x4.
            request_id: a name of this call, as of `Scene.load`.

        Raises:
            InvalidArgumentError: when a row or the convention is not as above.

        Example:
            >>> rows = [(0.0, np.pi / 2, 0.4, 0.0), {"a": 0.5, "name": "elbow", "limits": (-2.0, 2.0)}]
            >>> arm = client.load_denavit_hartenberg(rows, convention="standard", name="arm")
        """
        request = model_request(name, pose, parent, "fixed")
        request.denavit_hartenberg.CopyFrom(table_message(rows, convention, base_t_first, last_t_flange))
        response = self._services.scene.ImportModel(
            scene_pb2.ImportModelRequest(model=request, request_id=request_id), timeout=LONG_TIMEOUT_SECONDS
        )
        return Robot(self._services, response.created[0].name)

    def models(self, search: Text | None = None, *, maker: Text | None = None) -> list[KnownModel]:
        """Return the models of robots and grippers that the kernel knows by name.

        Args:
            search: words that must all occur in name, description, maker or kind, in any case; by default any model.
            maker: part of the maker's name, in any case.

        Example:
            >>> [model.name for model in client.models("simple", maker="Universal") if (model.reach or 0.0) > 1.2]
            ['ur10', 'ur10e', 'ur20', 'ur30']
            >>> client.load_robot("model://ur10e")
        """
        return known_models(self._services, search, maker)

    def move_together(self, moves: Iterable[Move], **options: Unpack[motion.StartOptions]) -> Motion:
        """Move several robots so that they start and end together.

        Example:
            >>> client.move_together([left.ptp("home"), right.linear(goal)], wait=True)
        """
        return motion.start(self._services, moves, **options)

    def plan(
        self, moves: Iterable[Move] | Motion, *, tracking: Tracking | None = None, **options: Unpack[plans.PlanOptions]
    ) -> plans.MotionPlan:
        """Return what moves that start and end together would do, or what a motion that runs will do. Nothing moves.

        It tells joints, efforts, tool centre points and duration in samples. With `tracking` the samples are those of
        the motion while the node that it goes along with stands still. Those of a motion that runs begin where it is on
        its path, and end with what is planned of it by now.

        Raises:
            VirtualRobotError: as the start of the motion would; TooLargeError for more samples than one answer holds.

        Example:
            >>> plan = client.plan([left.ptp("home"), right.linear(goal)])
            >>> plan.duration, plan.robots["right"].tcp_speeds.max()
            (2.31, 0.25)
        """
        if isinstance(moves, Motion):
            return plans.plan_left(self._services, moves, **options)
        return plans.plan(self._services, plans.motion_of(moves, tracking), **options)

    def check(
        self, moves: Iterable[Move], *, tracking: Tracking | None = None, **options: Unpack[plans.CheckOptions]
    ) -> plans.MotionCheck:
        """Return whether moves that go together keep all limits and touch nothing, and else what they violate first.

        Nothing moves. Collisions are looked for everywhere on the way, with all else as it stands now; what touches
        already and is moved by the motion does so after 0 s. With `tracking` limits are checked all along its window;
        for collisions the node that it goes along with stands still.

        Raises:
            VirtualRobotError: when it is no motion at all, such as for unknown names.

        Example:
            >>> print(client.check([arm.linear(goal)]).first_violation)
            the joint 'lbr_iiwa_joint_4' of 'arm' leaves its range, up to -2.14 rad after 1.32 s, ...
        """
        return plans.check(self._services, plans.motion_of(moves, tracking), **options)

    def check_plan(self, planned: plans.ShownPlan, **options: Unpack[plans.CheckOptions]) -> plans.MotionCheck:
        """Return whether a plan that was shown keeps all limits and touches nothing, as `check` does of moves.

        Nothing is planned again. What is started by the answer's reference is what was checked, or it is refused.

        Raises:
            PlanOutdatedError: when its path would be another one now.
            UnknownNameError: when the kernel doesn't remember it any more: it keeps the last 100 plans, until it ends.
        """
        return plans.check_plan(self._services, planned, **options)

    def start_plan(self, planned: plans.ShownPlan, **options: Unpack[motion.StartOptions]) -> Motion:
        """Start a plan as `plan` has shown it, or as it was checked, without planning again.

        Raises:
            PlanOutdatedError: when anything that the plan used of the world is another one now, or anything that its
                check used, and it violates something by that; `changes` in its metadata tells what, one a line. Nothing
                moves.
            UnknownNameError: when the kernel doesn't remember it any more: it keeps the last 100 plans, until it ends.

        Example:
            >>> checked = client.check_plan(client.plan([arm.linear(goal)]))
            >>> if checked.ok:
            ...     client.start_plan(checked)  # the very motion that was looked at
        """
        return plans.start_plan(self._services, planned, **options)

    def program(self, text: str | None = None) -> Program:
        """Return an empty program: moves of several robots, signals, waits and dwells, one after the other.

        With `text` it is what that says, as `Program.text` or a program file; errors as of `read_program`.

        Example:
            >>> client.program().move(robot.ptp("home")).set("gripper", True).dwell(0.2).start()
        """
        return Program(self._services) if text is None else parsed(self._services, text, "program")

    def read_program(self, file: str | Path) -> Program:
        """Return what a program file (YAML) says, to be started.

        Raises:
            MalformedFileError: `cell.yaml:12: steps[3].move: ...`, with what would be right.
        """
        return read(self._services, file)

    def motions(self, running_only: bool = True) -> list[Motion]:
        """Return the motions that run, whoever started them; with False also the last ones that ended."""
        request = motion_pb2.ListMotionsRequest(running_only=running_only)
        messages = self._services.motion.ListMotions(request).motions
        return [Motion(self._services, message) for message in messages]

    def watch_motions(self, max_rate: float | None = None) -> Iterator[list[Motion]]:
        """Yield the motions that run, whoever started them, and whenever that changes those and what has ended since.

        At most `max_rate` (30) times a second; each end is told. It keeps no motion alive, as watching one does.

        Example:
            >>> for motions in client.watch_motions():
            ...     print([(motion.id, motion.phase) for motion in motions])
        """
        rate = value_or_default(max_rate, "max_rate")
        request = motion_pb2.WatchMotionsRequest(max_rate_hertz=rate)
        with self._services.motion.WatchMotions(request) as stream:
            for response in stream:
                yield [Motion(self._services, message) for message in response.motions]

    def record(
        self,
        path: str | Path,
        *,
        duration: float,
        told: Callable[[Recording], None] | None = None,
        **options: Unpack[RecordingOptions],
    ) -> Recorded:
        """Record so much simulation time (s) to a file, and return what is in it.

        `path` ends with .mcap (all topics, for Foxglove, PlotJuggler and readers of MCAP), .csv or .parquet (a table of
        joints, tool centre points and signals), .glb (the scene and how it moved, as glTF) or .html (a page that plays
        that without a kernel). `told` is called several times a second. Ctrl-C leaves a whole file. It
        needs packages: `pip install 'virtualrobot[record]'` for .mcap, `[parquet]` for .parquet.

        Raises:
            InvalidArgumentError: when the file's name has another ending, is there already, or cannot be written.
            UnknownNameError: when there is no such topic.
            WrongStateError: when a package is missing, or the file cannot be written any more.

        Example:
            >>> client.record("run.mcap", duration=10.0, topics=["/robots/*", "/transforms*"]).counts
            {'/robots/arm/joint_states': 2500, '/robots/arm/tcp': 2500, '/transforms': 2500, '/transforms/fixed': 3}
        """
        with self.start_recording(path, duration=duration, **options) as recording:
            while not recording.wait(0.25):
                if told is not None:
                    told(recording)
            return recording.finish()

    def start_recording(
        self, path: str | Path, *, duration: float | None = None, **options: Unpack[RecordingOptions]
    ) -> Recording:
        """Begin to record while the program goes on; the end of the block makes the file whole.

        The arguments are those of `record`. Without a block, `finish()` does the same, and tells what is in the file.

        Example:
            >>> with client.start_recording("move.parquet"):
            ...     robot.move_joints(goal)
        """
        check_options(options, RecordingOptions, "a recording")
        return start(self._services, path, duration, options)

    def stop(self, *robots: Named) -> list[Motion]:
        """Cancel every motion, or every motion of these robots; return them. `client.cell.stop` lets none start."""
        return motion.stop(self._services, map(name_of, robots))

    def lease(self, *robots: Named, take: bool = False, owner: str | None = None) -> Lease:
        """Lease robots, all or none, so that nobody but this client moves them; return the lease, a context manager.

        Args:
            robots: the robots, or their names; several are leased together.
            take: takes the robots over from whoever has them, and stops their motions.
            owner: the owner's name for people who are refused; by default user, machine and program.

        Raises:
            LeasedError: when somebody has one of the robots; the message says who.

        Example:
            >>> with client.lease("left", "right", owner="cell 3"):
            ...     client.move_together([left.ptp("home"), right.ptp("home")])
        """
        return acquire(self._services, list(map(name_of, robots)), owner, take)

    def leases(self) -> list[LeaseInfo]:
        """Return who has leased which robots, oldest lease first."""
        return list_leases(self._services)

    def watch_leases(self) -> Iterator[list[LeaseInfo]]:
        """Yield who has leased which robots, oldest lease first, now and after each change."""
        return watch_leases(self._services)

    def undo(self, number: int | None = None, *, mine: bool = False) -> Step:
        """Take back the newest edit that stands, of anybody or only of this client; as `History.undo` does.

        Example:
            >>> client.undo().label
            "took back: moved 'table' by 0.10 m"
        """
        return self.history.undo(number, mine=mine)

    def redo(self, number: int | None = None, *, mine: bool = False) -> Step:
        """Do again what was undone last, as `History.redo` does."""
        return self.history.redo(number, mine=mine)

    @property
    def speed_factor(self) -> float:
        """Factor by which all motions are slowed, above 0, up to 1; setting it changes running ones smoothly."""
        return self._services.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).speed_factor

    @speed_factor.setter
    def speed_factor(self, factor: float) -> None:
        Direct(self._services).set_speed_factor(factor)

    def report(self, path: str | Path, max_journal_bytes: int | None = None) -> Path:
        """Write what a report of a fault needs to a zip archive, and return its path.

        It has the scene, the journal, versions, plugins and the log, and no token. Unpacked it is a folder that
        `virtualrobot replay` shows.

        Args:
            path: the archive; one that is there is replaced.
            max_journal_bytes: about so many bytes of the journal at most, the newest; None: 100 MB.

        Raises:
            InvalidArgumentError: when the file cannot be written.

        Example:
            >>> client.report("fault.zip")
        """
        request = kernel_pb2.GetReportRequest(
            max_journal_bytes=count_or_default(max_journal_bytes, "max_journal_bytes")
        )
        with self._services.kernel.GetReport(request) as stream:
            data = b"".join(response.data for response in stream)
        return write_file(Path(path), data)

    def shutdown(self) -> None:
        """End the kernel."""
        self._services.kernel.Shutdown(kernel_pb2.ShutdownRequest())

    def close(self) -> None:
        """Close the connection; motions that this client watched are cancelled by the kernel after a second.

        A kernel of this program's own, of `connect("local")`, ends.
        """
        self._channel.close()
        if self._own_kernel is not None:
            self._own_kernel.close()

    def __enter__(self) -> Client:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the connection."""
        self.close()

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Client of VirtualRobot {self.info.version} at {self.address}>"
