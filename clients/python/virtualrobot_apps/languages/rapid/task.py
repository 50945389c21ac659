"""Tasks of RAPID: a program that is loaded, and one run of it."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable, Iterable
from pathlib import Path
from types import CodeType
from typing import Any, NoReturn

from virtualrobot.errors import VirtualRobotError, WrongStateError

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError, did_you_mean
from virtualrobot_apps.languages.core.pendant import Pendant
from virtualrobot_apps.languages.core.source import Source, read_source
from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.rapid import builtin
from virtualrobot_apps.languages.rapid.check import Checked, check
from virtualrobot_apps.languages.rapid.faults import CAUGHT, ProgramEnded, RapidFault, RapidStopped, as_fault
from virtualrobot_apps.languages.rapid.generate import generate
from virtualrobot_apps.languages.rapid.interrupts import Interrupt, Interrupts
from virtualrobot_apps.languages.rapid.parser import parse
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS, VARIABLES
from virtualrobot_apps.languages.rapid.support import copied, names_of_support
from virtualrobot_apps.languages.rapid.symbols import RoutineSymbol, Use
from virtualrobot_apps.languages.rapid.table import BUILTINS
from virtualrobot_apps.languages.rapid.values import Clock, FileDevice, FolderDevice, SocketDevice
from virtualrobot_apps.languages.rapid.world import World

builtin.load()


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
    diagnostics = Diagnostics()
    sources = list(sources)
    modules = [module for source in sources for module in parse(source, diagnostics)]
    checked = check(modules, diagnostics, signals)
    if len(diagnostics):
        raise ProgramError(diagnostics.sorted())
    return Loaded(checked, generate(checked), [source.file for source in sources])


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
        sockets: the sockets that are open.
        open_files: the files that are open.
    """

    def __init__(
        self,
        program: Loaded,
        world: World | None = None,
        write: Callable[[str], None] = print,
        listen_at: str | None = None,
        *,
        files: Path | None = None,
        answers: Iterable[str] = (),
    ) -> None:
        """Set up the data; nothing runs yet.

        `write` gets each line of the pendant, and `answers` what the program asks there, one after the other. Raises
        WrongStateError for signals that the world has not.
        """
        super().__init__()
        self.program, self.listen_at, self.files = program, listen_at, files
        self.pendant = Pendant(write, answers)
        self.write = self.pendant.write
        self.sockets: set[SocketDevice] = set()
        self.open_files: set[FileDevice] = set()
        self.booked = 0
        self.shared_lock = threading.Lock()
        self._left: list[Callable[[], None]] = []
        self._world = world
        self._interrupts: Interrupts | None = None
        if world is not None:
            world.find_signals(program.signals.values())
            world.begin(self)
        names = names_of_support()
        names |= {f"b_{one.name.lower()}": one.run for one in BUILTINS.values()}
        names |= {"task": self, "flags": self.flags, "poll": self.poll}
        for name, (_, value) in CONSTANTS.items():
            names[f"s_{name.lower()}"] = [copied(value)]
        for name, (_, kind, value) in VARIABLES.items():
            names[f"s_{name.lower()}"] = [Clock(self.time) if kind == "clock" else copied(value)]
        for datum in program.checked.data:
            names[datum.python] = [None]
        self._names: dict[str, Any] = names
        self._routines = {
            routine.node.name.lower(): routine for scope in program.checked.modules for routine in scope.routines
        }

    @property
    def world(self) -> World:
        """Robot and signals; raises a fault where there are none."""
        if self._world is None:
            raise RapidStopped("this program was started without a robot, and can't do that")
        return self._world

    @property
    def interrupts(self) -> Interrupts:
        """Interrupts of the program; raises a fault where there is no robot, and so nothing that orders them."""
        if self._interrupts is None:
            self._interrupts = Interrupts(self.world.client, lambda: self.ask("interrupt"), self.time)
        return self._interrupts

    def serve(self) -> None:
        """Call the traps of interrupts that have come."""
        if self._interrupts is not None:
            self._interrupts.serve(self._trapped)

    def _trapped(self, interrupt: Interrupt) -> None:
        self._names["s_intno"][0] = interrupt.number
        with self.world.queue.aside():
            interrupt.trap()

    def run(self, name: str = "main") -> None:
        """Run a procedure to its end, and wait until the robot stands.

        Raises:
            RapidStopped: for an error that nothing handled, with file, line and the routines on the way there.
            TaskStopped: when somebody stopped it; the robot brakes on its path.
            WrongStateError: when there is no such procedure, or it takes arguments.
        """
        routine = self._routines.get(name.lower())
        procedures = [one.node.name for one in self._routines.values() if one.node.kind == "proc"]
        if routine is None or routine.node.kind != "proc":
            known = ", ".join(procedures) or "none"
            raise WrongStateError(f"there is no procedure {name!r}{did_you_mean(name, procedures)}; there are: {known}")
        if any(not parameter.optional for parameter, _ in routine.parameters):
            raise WrongStateError(f"the procedure {name!r} takes arguments; run one that takes none")
        try:
            for code in self.program.code:
                exec(code, self._names)
            self._called(routine, [])
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
            for device in (*self.sockets, *self.open_files):
                device.close()

    def left(self, undo: Callable[[], None]) -> None:
        """Remember the UNDO part of a routine that is left early: it counts unless a handler lets the program go on."""
        self._left.append(undo)

    def answered(self, then: Any) -> Any:  # noqa: ANN401 what a handler says
        """Return what an error handler says, which is that the program goes on."""
        self._left.clear()
        return then

    def _undo(self) -> None:
        """Do the UNDO parts of the routines that the program was in, the innermost first; a stop is over then."""
        self.flags.clear()
        self._why = ""
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
        if isinstance(error, RecursionError):
            message = "ERR_STACK: routines call each other without an end"
            where = where[:1]
        else:
            message = str(as_fault(error) if isinstance(error, CAUGHT) else error)
        called = [f"{names[one.name]} ({one.filename}:{one.lineno})" for one in frames if one.name in names]
        way = f"\ncalled from {' from '.join(reversed(called[:-1]))}" if 1 < len(called) <= 20 else ""
        place = where[-1] if where else self.program.files[0]
        metadata = {"file": place.rpartition(":")[0], "line": place.rpartition(":")[2]} if where else {}
        raise RapidStopped(f"{place}: {message}{way}", metadata=metadata) from error

    # What generated code asks for.

    def caught(self, fault: RapidFault) -> None:
        """Tell the program the number of an error that its handler has caught."""
        self._names["s_errno"][0] = fault.number

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
