"""Tasks of RAPID: a program that is loaded, and one run of it."""

from __future__ import annotations

import sys
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import CodeType
from typing import Any, NoReturn

from virtualrobot.clock import Observation
from virtualrobot.errors import VirtualRobotError, WrongStateError

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError, did_you_mean
from virtualrobot_apps.languages.core.pendant import Pendant
from virtualrobot_apps.languages.core.source import Source, read_source
from virtualrobot_apps.languages.core.task import Task, here
from virtualrobot_apps.languages.rapid import builtin
from virtualrobot_apps.languages.rapid.cell import Cell
from virtualrobot_apps.languages.rapid.check import Checked, check, is_common
from virtualrobot_apps.languages.rapid.faults import (
    CAUGHT,
    CycleEnded,
    ProgramEnded,
    RapidFault,
    RapidStopped,
    as_fault,
)
from virtualrobot_apps.languages.rapid.generate import generate
from virtualrobot_apps.languages.rapid.interrupts import Interrupt, Interrupts
from virtualrobot_apps.languages.rapid.parser import parse
from virtualrobot_apps.languages.rapid.predefined import ALL_ERRORS, CONSTANTS, VARIABLES
from virtualrobot_apps.languages.rapid.signals import Signals
from virtualrobot_apps.languages.rapid.support import copied, names_of_support
from virtualrobot_apps.languages.rapid.symbols import Datum, RoutineSymbol, Use
from virtualrobot_apps.languages.rapid.table import BUILTINS
from virtualrobot_apps.languages.rapid.tree import Data, Module
from virtualrobot_apps.languages.rapid.values import Clock, FileDevice, FolderDevice, SocketDevice
from virtualrobot_apps.languages.rapid.world import World
from virtualrobot_apps.languages.rapid.zones import Zones

builtin.load()

ROUND_SECONDS = 0.01
"""Time (s of the wall clock) from the end of a static task's round to the next one."""


class Loaded:
    """A program that was read, checked and translated; it may be run many times."""

    def __init__(self, checked: Checked, code: list[CodeType], files: list[str]) -> None:
        """Keep it; `load` makes one."""
        self.checked, self.code, self.files = checked, code, files

    @property
    def signals(self) -> dict[str, Use]:
        """Signals of the world that it names, by name in small letters."""
        return self.checked.uses


def load(sources: Iterable[Source], signals: Iterable[str] = ()) -> Loaded:
    """Return the program that sources make together; `signals` are names that the world has.

    Raises ProgramError with all that is wrong in them.
    """
    return load_tasks({"": sources}, signals)[""]


def load_tasks(
    tasks: Mapping[str, Iterable[Source]],
    signals: Iterable[str] = (),
    *,
    watched: bool = False,
    debugged: bool = False,
) -> dict[str, Loaded]:
    """Return the programs of several tasks, by the tasks' names; a persistent that several have is one for them all.

    `watched`: somebody beside the tasks reads and writes persistents, so that programs do when the robot is so far.
    `debugged`: a debugger may change all data.
    Raises ProgramError with all that is wrong in them.
    """
    diagnostics, signals = Diagnostics(), list(signals)
    sources = {task: list(given) for task, given in tasks.items()}
    modules = {task: [one for source in given for one in parse(source, diagnostics)] for task, given in sources.items()}
    counted = Counter(name for given in modules.values() for name in _persistents(given))
    common = frozenset(name for name, count in counted.items() if count > 1 or watched)
    checked = {task: check(given, diagnostics, signals, common) for task, given in modules.items()}
    first: dict[str, tuple[str, Datum]] = {}
    for task, one in checked.items():
        for datum in one.data:
            if not datum.common or datum.node is None or datum.source is None:
                continue
            other, same = first.setdefault(datum.name.lower(), (task, datum))
            if same.type != datum.type:
                said = (
                    f"{datum.name!r} is a {same.type} in the task {other}, and a persistent of both tasks has one type"
                )
                diagnostics.add(datum.source, datum.node.at, said)
    if len(diagnostics):
        raise ProgramError(diagnostics.sorted())
    return {
        task: Loaded(one, generate(one, debugged), [source.file for source in sources[task]])
        for task, one in checked.items()
    }


def _persistents(modules: Iterable[Module]) -> set[str]:
    """Return the names, in small letters, of the data that other tasks may have, too."""
    data = [one for module in modules for one in module.declarations if isinstance(one, Data)]
    return {one.name.lower() for one in data if is_common(one)}


def load_files(files: Iterable[Path], signals: Iterable[str] = ()) -> Loaded:
    """Return the program that files make together; raises ProgramError, or MissingFileError."""
    return load(map(read_source, files), signals)


class RapidTask(Task):
    """One run of a program: its data, and what its instructions work on.

    Attributes:
        world: the robot and the signals; None where the program has none, and may compute only.
        pendant: what it writes, and what it is answered.
        listen_at: the address at which its sockets may listen; None: they may not.
        files: the folder below which its files are; None: it may use none.
        egm: the UDP devices of EGM, by name in small letters, with host and port of the computer that each one is.
        sockets: the sockets that are open.
        open_files: the files that are open.
        handled: give the numbers of the handlers that have some, of the routines at work, the outermost first.
        name: the task's, and `cell` the tasks that it runs beside.
        prepared: whether all data have their first values, and no run has changed them.
        undoing: whether it has ended and does its UNDO parts.
    """

    def __init__(
        self,
        program: Loaded,
        world: Signals | None = None,
        write: Callable[[str], None] = print,
        listen_at: str | None = None,
        *,
        files: Path | None = None,
        answers: Iterable[str] = (),
        name: str = "T_ROB1",
        cell: Cell | None = None,
        egm: Mapping[str, tuple[str, int]] | None = None,
    ) -> None:
        """Set up the data; nothing runs yet.

        A world without a robot (`Signals`) has signals and time alone. Tasks that share a cell need names of their own.

        `write` gets each line of the pendant, and `answers` what the program asks there, one after the other. Raises
        WrongStateError for signals that the world has not.
        """
        super().__init__()
        self.program, self.listen_at, self.files = program, listen_at, files
        self.name, self.cell = name, cell or Cell()
        if name.lower() in self.cell.tasks:
            raise WrongStateError(f"there is a task {name!r} already; give each task a name of its own")
        self.cell.tasks[name.lower()] = self
        self.egm = {device.lower(): to for device, to in (egm or {}).items()}
        self.prepared = False
        self.pendant = Pendant(write, answers)
        self.write = self.pendant.write
        self.sockets: set[SocketDevice] = set()
        self.open_files: set[FileDevice] = set()
        self.booked = 0
        self.handled: list[Callable[[], tuple[float, ...]]] = []
        self._left: list[Callable[[], None]] = []
        self._world = world
        self._interrupts: Interrupts | None = None
        self._zones: Zones | None = None
        self._thread, self.undoing = 0, False
        if world is not None:
            world.find_signals(program.signals.values())
            if isinstance(world, World):
                world.find_units(program.checked.data)
            world.begin(self)
        names = names_of_support()
        names |= {f"b_{one.name.lower()}": one.run for one in BUILTINS.values()}
        names |= {"task": self, "flags": self.flags, "poll": self.poll, "seen": self.seen}
        for name, (_, value) in CONSTANTS.items():
            names[f"s_{name.lower()}"] = [copied(value)]
        for name, (_, kind, value) in VARIABLES.items():
            names[f"s_{name.lower()}"] = [Clock(self.time) if kind == "clock" else copied(value)]
        for datum in program.checked.data:
            names[datum.python] = self.cell.holder(datum)
        self._names: dict[str, Any] = names
        self._routines = {
            routine.node.name.lower(): routine for scope in program.checked.modules for routine in scope.routines
        }

    def persistents(self) -> list[tuple[Datum, list[Any]]]:
        """Return the persistents of the task's modules, and what holds the value of each."""
        return [(one, self._names[one.python]) for one in self.program.checked.data if one.storage == "pers"]

    @property
    def world(self) -> World:
        """Robot and signals; raises a fault where there is no robot."""
        if not isinstance(self._world, World):
            raise RapidStopped("this program was started without a robot, and can't do that")
        return self._world

    @property
    def own_world(self) -> Signals | None:
        """Robot and signals, or these alone; None where there are none."""
        return self._world

    @property
    def has_robot(self) -> bool:
        """True where the task moves a robot."""
        return isinstance(self._world, World)

    @property
    def signals(self) -> Signals:
        """Signals and time; raises a fault where there are none."""
        if self._world is None:
            raise RapidStopped("this program was started without a robot, and can't do that")
        return self._world

    @property
    def interrupts(self) -> Interrupts:
        """Interrupts of the program; raises a fault where there is no robot, and so nothing that orders them."""
        if self._interrupts is None:
            watches = self.passing is None
            self._interrupts = Interrupts(
                self.signals.client, lambda: self.ask("interrupt"), self.time, watches=watches
            )
        return self._interrupts

    def place(self) -> str:
        """Return file and line of the statement that is being done; empty where none is, as at the end."""
        found = here()
        return found if found.rpartition(":")[0] in self.program.files else ""

    def line(self) -> tuple[str, int] | None:
        """Return file and line of the statement that is being done, to any thread; None where nothing runs."""
        frame = sys._current_frames().get(self._thread) if self._thread else None
        while frame is not None and frame.f_code.co_filename not in self.program.files:
            frame = frame.f_back
        return None if frame is None else (frame.f_code.co_filename, frame.f_lineno)

    def program_pointer(self) -> str:
        """Return file and line of the statement that is being done."""
        found = self.line()
        return "" if found is None else f"{found[0]}:{found[1]}"

    def motion_pointer(self) -> str:
        """Return file and line of the move that the robot makes."""
        return self.world.queue.doing() if self.has_robot else ""

    @property
    def zones(self) -> Zones:
        """World zones of the program; raises a fault where there is no robot."""
        if self._zones is None:
            self._zones = Zones(self.world, lambda: self.ask("zone"), watches=self.passing is None)
        return self._zones

    def passed(self, seen: Observation) -> None:
        """Let interrupts and world zones take notice."""
        if self._interrupts is not None:
            self._interrupts.look(seen.stamp.simulation_time, seen.signals)
        if self._zones is not None:
            self._zones.look(seen.robots[self.world.robot.name])

    def serve(self) -> None:
        """Call the traps of interrupts that have come; end the program in a world zone that it may not enter."""
        if self._zones is not None and self._zones.entered:
            self._zones.entered = False
            file, _, line = (self.world.queue.doing() or self.place()).rpartition(":")
            metadata = {"file": file, "line": line} if file else {}
            raise RapidStopped("the robot is in a world zone that WZLimSup keeps it out of", metadata=metadata)
        if self._interrupts is not None:
            self._interrupts.serve(self._trapped)

    def _trapped(self, interrupt: Interrupt) -> None:
        self._names["s_intno"][0] = interrupt.number
        with self.signals.queue.aside():
            interrupt.trap()

    def prepare(self) -> None:
        """Give all data their first values; `run` does so where nobody has."""

        def set_all() -> None:
            for code in self.program.code:
                exec(code, self._names)

        self.cell.set_first_values(self.program.checked.data, set_all)
        self.prepared = True

    def prepare_alone(self) -> None:
        """Do so outside of a run, with an error as `run` tells it."""
        try:
            self.prepare()
        except BaseException as error:
            self._tell(error)

    def run(self, name: str = "main", forever: bool = False) -> None:
        """Run a procedure to its end, or again and again, and wait until the robot stands.

        Raises:
            RapidStopped: for an error that nothing handled, with file, line and the routines on the way there.
            TaskStopped: when somebody stopped it; the robot brakes on its path.
            WrongStateError: when there is no such procedure, or it takes arguments.
        """
        self._thread = threading.get_ident()
        try:
            with self.at_work():
                self._run(name, forever)
        finally:
            self._thread = 0

    def _run(self, name: str, forever: bool) -> None:
        routine = self._routines.get(name.lower())
        procedures = [one.node.name for one in self._routines.values() if one.node.kind == "proc"]
        if routine is None or routine.node.kind != "proc":
            known = ", ".join(procedures) or "none"
            raise WrongStateError(f"there is no procedure {name!r}{did_you_mean(name, procedures)}; there are: {known}")
        if any(not parameter.optional for parameter, _ in routine.parameters):
            raise WrongStateError(f"the procedure {name!r} takes arguments; run one that takes none")
        try:
            if not self.prepared:
                self.prepare()
            self.prepared = False
            if self._world is not None and not self.has_robot:
                with self._world.queue.aside():
                    self._rounds(routine, forever)
            else:
                self._rounds(routine, forever)
            if self._world is not None:
                self._world.close()
        except ProgramEnded:
            if self._world is not None:
                self._world.close()
            self._undo()
        except BaseException as error:
            if self._world is not None:
                self._world.cancel("the program ended early")
            self._undo()
            self._tell(error)
        finally:
            if self._interrupts is not None:
                self._interrupts.close()
            if self._zones is not None:
                self._zones.close()
                self._zones = None
            for device in (*self.sockets, *self.open_files):
                device.close()

    def _rounds(self, routine: RoutineSymbol, forever: bool) -> None:
        """Call a procedure once, or for ever: ExitCycle ends a round then, and what the robot has not done."""
        while forever:
            try:
                self._called(routine, [])
            except CycleEnded:
                if isinstance(self._world, World):
                    self._world.leave_path("ExitCycle")
                self._undo_left()
            self.pause(ROUND_SECONDS)
        self._called(routine, [])

    def report(self, kind: str, number: float | None, lines: Sequence[str]) -> None:
        """Write an error, a warning or an information into the log, which is the pendant here: its number and lines."""
        self.write(f"{kind}{'' if number is None else f' {number:g}'}: {'; '.join(lines)}")

    def left(self, undo: Callable[[], None]) -> None:
        """Remember the UNDO part of a routine that is left early: it counts unless a handler lets the program go on."""
        self._left.append(undo)

    def answered(self, then: Any) -> Any:  # noqa: ANN401 what a handler says
        """Return what an error handler says, which is that the program goes on."""
        self._left.clear()
        return then

    def _undo(self) -> None:
        """Do the UNDO parts of the routines that the program was in; a stop is over then."""
        self.undoing = True
        self.flags.clear()
        self._why = ""
        self._undo_left()

    def _undo_left(self) -> None:
        """Do the UNDO parts of the routines that were left early, the innermost first."""
        while self._left:
            try:
                self._left.pop(0)()
            except (*CAUGHT, VirtualRobotError, RecursionError) as error:
                told = as_fault(error) if isinstance(error, CAUGHT) else error
                self.write(f"error: in UNDO: {told}")

    def _tell(self, error: BaseException) -> NoReturn:
        """Raise an error as one of the program's, with the lines of RAPID that led to it."""
        if not isinstance(error, (*CAUGHT, VirtualRobotError, RecursionError)):
            raise error
        summary = list(traceback.extract_tb(error.__traceback__))
        if isinstance(error, RapidStopped) and error.__cause__ is not None:
            summary += traceback.extract_tb(error.__cause__.__traceback__)
        frames = [one for one in summary if one.filename in self.program.files]
        names = {routine.python: routine.node.name for routine in self._routines.values()}
        where = [f"{one.filename}:{one.lineno}" for one in frames if one.name in names or one.name != "handler"]
        if isinstance(error, RapidStopped) and "line" in error.metadata:
            where = [f"{error.metadata['file']}:{error.metadata['line']}"]
        if isinstance(error, RecursionError):
            message = "ERR_STACK: routines call each other without an end"
        else:
            message = str(as_fault(error) if isinstance(error, CAUGHT) else error)
        called = [f"{names[one.name]} ({one.filename}:{one.lineno})" for one in frames if one.name in names]
        way = f"\ncalled from {' from '.join(reversed(called[:-1]))}" if 1 < len(called) <= 20 else ""
        place = where[-1] if where else self.program.files[0]
        metadata = {"file": place.rpartition(":")[0], "line": place.rpartition(":")[2]} if where else {}
        raise RapidStopped(f"{place}: {message}{way}", metadata=metadata) from error

    # What generated code asks for.

    def seen(self, holder: list[Any]) -> list[Any]:
        """Return what holds a datum that other tasks see, when the robot is so far."""
        self.settle()
        return holder

    def caught(self, fault: RapidFault, handled: tuple[float, ...] | None) -> None:
        """Tell the program the number of an error that its handler has caught; raise one that it leaves alone.

        `handled` are the numbers of a handler that has numbers; one without is left out by an error on a long jump.
        """
        if fault.jumps if handled is None else not _are_for(handled, fault):
            raise fault
        fault.jumps = False
        self._names["s_errno"][0] = fault.number

    def passed_by(self, fault: RapidFault, handles: bool) -> NoReturn:
        """Raise the error of a handler again: in the caller, or in the first one that has a handler for its number.

        `handles` tells whether the handler has numbers itself. Source: ABB, RAPID reference manual part 1a,
        Instructions A-R, RAISE: "With a long jump it is possible to propagate an error from an error handler from a
        deep nested call chain to a higher level in one step".
        """
        callers = self.handled[:-1] if handles else self.handled
        fault.jumps = any(_are_for(one(), fault) for one in callers)
        raise fault

    def passed_on(self, fault: RapidFault, other: BaseException) -> NoReturn:
        """Raise the error of a handler again; another one, of the handler itself, ends the program.

        Source: ABB, RAPID Reference Manual, 5-34: "it is not possible to recover from errors that occur within an error
        clause".
        """
        if other is fault:
            raise fault
        raise RapidStopped(f"{as_fault(other)}, in an error handler, whose own errors nothing handles") from other

    def bounds(self, first: float, last: float, step: float | None = None) -> tuple[float, float, float]:
        """Return begin, end and step of FOR, by 1 or -1 where there is none."""
        if step is None:
            step = 1.0 if last >= first else -1.0
        if step == 0.0:
            raise RapidFault("ERR_ARGVALERR", "the step of FOR is 0")
        return first, last, step

    def call_late(self, name: str, given: list[tuple[list[Any], int]]) -> None:
        """Call a procedure by its name."""
        routine = self._routines.get(name.lower())
        if routine is None or routine.node.kind != "proc":
            raise RapidFault("ERR_REFUNKPRC", f"there is no procedure {name!r}")
        self._called(routine, given)

    def _called(self, routine: RoutineSymbol, given: list[tuple[list[Any], int]]) -> None:
        required = [one for one, _ in routine.parameters if not one.optional]
        if len(required) != len(given):
            said = f"{routine.node.name!r} takes {len(required)} arguments, and gets {len(given)}"
            raise RapidFault("ERR_CALLPROC", said)
        rest, arguments = iter(given), []
        for parameter, _ in routine.parameters:
            holder, index = (None, 0) if parameter.optional else next(rest)
            if parameter.mode != "in":
                arguments += [holder, index]
            else:
                arguments.append(None if holder is None else holder[index])
        self._names[routine.python](*arguments)

    def clock(self) -> Clock:
        """Return a clock that stands at 0."""
        return Clock(self.time)

    def file(self) -> FileDevice:
        """Return a file that is closed."""
        return FileDevice()

    def folder(self) -> FolderDevice:
        """Return a folder that is closed."""
        return FolderDevice()

    def socket(self) -> SocketDevice:
        """Return a socket that is closed."""
        return SocketDevice()

    def time(self) -> float:
        """Return the time (s): that of the simulation, or of the wall where there is no robot."""
        return time.monotonic() if self._world is None else self._world.time()

    def signal_value(self, name: str) -> float:
        """Return the value of a signal as a number."""
        return self.world.signal_value(name)

    def settle(self) -> None:
        """Wait until the world may be looked at or told something."""
        if self._world is not None:
            self._world.settle()

    def finish(self) -> None:
        """Wait until the robot stands."""
        if self._world is not None:
            self._world.queue.finish()


def _are_for(handled: tuple[float, ...], fault: RapidFault) -> bool:
    """Return whether numbers of a handler have that of an error, or are for all."""
    return fault.number in handled or ALL_ERRORS in handled
