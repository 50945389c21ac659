"""Launch of a program for a debugger: what an editor says, the tasks that it asks for, and their run."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from virtualrobot.cli.options import GO_ON
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.emulators.body import Body, SimulatedArm, Twin
from virtualrobot_apps.emulators.ur.command import HOME
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.kinematics import MODELS
from virtualrobot_apps.emulators.ur.lengths import USUAL, model_of
from virtualrobot_apps.emulators.ur.touches import Touches
from virtualrobot_apps.languages.core.debugger import Debugger
from virtualrobot_apps.languages.core.pendant import Question
from virtualrobot_apps.languages.core.source import Source, read_source
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.editor.urscript import URSCRIPT
from virtualrobot_apps.languages.rapid.cell import Cell
from virtualrobot_apps.languages.rapid.command import add_signals
from virtualrobot_apps.languages.rapid.debugger import DebuggedTask
from virtualrobot_apps.languages.rapid.signals import Signals
from virtualrobot_apps.languages.rapid.task import load_tasks
from virtualrobot_apps.languages.rapid.world import World
from virtualrobot_apps.languages.urscript.debugger import DebuggedScript
from virtualrobot_apps.languages.urscript.robot import ScriptProgram
from virtualrobot_apps.languages.urscript.task import load_source

if TYPE_CHECKING:
    from virtualrobot import Client
    from virtualrobot.cli.options import Target

OWN = "T_ROB1"
"""Name of the task of `program`."""

KNOWN: dict[str, type | tuple[type, ...]] = {
    "program": (str, list),
    "robot": str,
    "address": str,
    "routine": str,
    "stopOnEntry": bool,
    "continuous": bool,
    "createSignals": bool,
    "files": str,
    "listen": str,
    "answers": list,
    "tasks": list,
}
"""Names that the launch of a program in RAPID has, and the types of their values."""
OF_SCRIPTS: dict[str, type | tuple[type, ...]] = {
    "program": str,
    "robot": str,
    "address": str,
    "stopOnEntry": bool,
    "model": str,
}
"""Those of a script in URScript."""
TEXTS = "texts"
"""Name of the texts, by their files' names, that an editor on another machine has in a launch."""
NOT_FROM_ELSEWHERE = "address", "files", "listen"
"""Names that such a launch has not, since they are of this machine."""


class WrongLaunch(Exception):
    """A launch that can't be done as it is; its message says why."""


class Launch(Protocol):
    """Tasks that are debugged."""

    @property
    def tasks(self) -> Sequence[Debugger]:
        """The tasks, in the order of their threads' numbers."""
        ...

    def run(self) -> None:
        """Run all tasks to their end; raises the error of one that ended by it, or TaskStopped."""
        ...

    def answer(self, text: str) -> bool:
        """Answer what a task asks on its pendant; return whether one asks."""
        ...

    def hear(self, asking: Callable[[Question | None], None]) -> None:
        """Tell of each question on a pendant, and None as nobody waits for its answer any more."""
        ...

    def close(self) -> None:
        """End what they use."""
        ...


Read = Callable[[str], Source]
"""Returns the source of a file by its name; raises MissingFileError."""


def read_here(name: str) -> Source:
    """Return the source of a file of this machine."""
    return read_source(Path(name).resolve())


def launched(given: Mapping[str, Any], target: Target, write: Callable[[str], None], read: Read = read_here) -> Launch:
    """Return the launch of a program, whose language its file's ending tells; as `RapidLaunch`."""
    program = given.get("program")
    if isinstance(program, str) and program.endswith(URSCRIPT.endings):
        return ScriptLaunch(given, target, write, read)
    return RapidLaunch(given, target, write, read)


def launched_from_elsewhere(given: Mapping[str, Any], target: Target, write: Callable[[str], None]) -> Launch:
    """Return the launch of a program whose texts an editor on another machine sends along; as `launched`."""
    for name in NOT_FROM_ELSEWHERE:
        if name in given:
            raise WrongLaunch(f"{name!r} is for editors on this machine")
    texts = given.get(TEXTS)
    if not isinstance(texts, dict) or not all(isinstance(one, str) for one in texts.values()):
        raise WrongLaunch(f"{TEXTS!r} are the texts of the program's files by their names")

    def read(name: str) -> Source:
        if name not in texts:
            raise WrongLaunch(f"{TEXTS!r} has no {name!r}")
        return Source(texts[name], name)

    return launched({name: one for name, one in given.items() if name != TEXTS}, target, write, read)


class ScriptLaunch:
    """Script on an emulated controller, in real time but where it stands; its arm is a robot, or one of its own."""

    def __init__(self, given: Mapping[str, Any], target: Target, write: Callable[[str], None], read: Read) -> None:
        """Load the script, and connect to the kernel where a robot is asked for; nothing runs yet.

        `write` gets each line of its log. Raises WrongLaunch, ProgramError, or an error of the kernel.
        """
        _check_types(given, OF_SCRIPTS)
        if wrong := sorted({*given} & {*KNOWN} - {*OF_SCRIPTS}):
            raise WrongLaunch(f"{wrong[0]!r} is for programs in RAPID: a script has an emulated controller of its own")
        model = given.get("model")
        if model is not None and model not in MODELS:
            raise WrongLaunch(f"'model' is one of {', '.join(MODELS)}, not {model!r}")
        (file,) = _files(given.get("program"), "program")
        loaded = load_source(read(file), debugged=True)
        if loaded.secondary:
            raise WrongLaunch(f"{loaded.name!r} is a secondary program (sec), which takes no time to stand in")
        with ExitStack() as opened:
            body: Body = SimulatedArm(HOME)
            touches: Touches | None = None
            if robot := given.get("robot"):
                client = opened.enter_context(_connected(given, target))
                if client.clock.mode == "stepped":
                    raise WrongLaunch(f"time stands still, and nothing would move; {GO_ON}")
                arm = client.robot(robot)
                body, model = (twin := Twin(arm)), model or model_of(arm)
                touches = Touches(client, arm, twin)
            opened.callback(body.close)
            try:
                self._controller = Controller(body, model or USUAL)
            except ValueError as error:
                raise WrongLaunch(f"{robot}: {error}") from error
            self._controller.touches = touches
            self._opened = opened.pop_all()
        self._program = ScriptProgram(loaded, self._controller, DebuggedScript)
        assert isinstance(self._program.task, DebuggedScript)
        self._task = self._program.task
        self._task.write, self._task.stops_first = write, bool(given.get("stopOnEntry"))
        self.tasks = [self._task]

    def run(self) -> None:
        """Run it until the arm rests; raises VirtualRobotError with the controller's words, or TaskStopped."""
        controller = self._controller
        controller.play(self._program)
        due = time.monotonic()
        while controller.program is not None or controller.moving:
            controller.cycle()
            due = max(due + controller.dt, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
        if self._task.ended:
            raise TaskStopped("stopped")
        if controller.words:
            raise VirtualRobotError(controller.words[-1][2])

    def answer(self, text: str) -> bool:
        """Return that nobody asks: the emulated controller has no pendant."""
        return False

    def hear(self, asking: Callable[[Question | None], None]) -> None:
        """Tell of nothing."""

    def close(self) -> None:
        """Stop the arm, and close all connections."""
        self._program.close()
        self._opened.close()


def _connected(given: Mapping[str, Any], target: Target) -> AbstractContextManager[Client]:
    """Connect to the kernel of a launch: the one that it names, or else `target`."""
    return replace(target, address=given.get("address", target.address)).connect("debugger")


class RapidLaunch:
    """Tasks that are debugged; `close` ends what they use."""

    def __init__(self, given: Mapping[str, Any], target: Target, write: Callable[[str], None], read: Read) -> None:
        """Load the program, and connect to the kernel where a robot is asked for; nothing runs yet.

        The kernel is `target`, unless the launch gives another address. `write` gets each line of a pendant. Raises
        WrongLaunch, ProgramError, or an error of the kernel.
        """
        _check_types(given, KNOWN)
        self._given = given
        parts = [(OWN, _files(given.get("program"), "program"), given.get("robot"), False)]
        for one in given.get("tasks", ()):
            if not isinstance(one, dict) or not isinstance(one.get("name"), str):
                raise WrongLaunch("each of 'tasks' has a 'name', a 'program', and a 'robot' or 'static'")
            parts.append(
                (one["name"], _files(one.get("program"), one["name"]), one.get("robot"), bool(one.get("static")))
            )
        names = [name.lower() for name, *_ in parts]
        if len({*names}) < len(names):
            raise WrongLaunch(f"each task has a name of its own, not {', '.join(name for name, *_ in parts)}")
        self._opened = ExitStack()
        self._typed: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        try:
            wanted = any(robot for _, _, robot, _ in parts)
            client = self._opened.enter_context(_connected(given, target)) if wanted else None
            sources = {name: [read(file) for file in files] for name, files, _, _ in parts}
            signals = list(client.signals) if client is not None else []
            programs = load_tasks(sources, signals, debugged=True)
            if client is not None and given.get("createSignals"):
                add_signals(client, programs.values())
            self.cell = Cell()
            self.tasks: list[DebuggedTask] = []
            answers = chain(map(str, given.get("answers", ())), iter(self._typed.get, None))
            folder = given.get("files")
            for name, _, robot, _ in parts:
                where = f"{name}: " if len(parts) > 1 else ""
                world = (
                    None
                    if client is None
                    else World(client, robot, lambda note: write(f"note: {note}"))
                    if robot
                    else Signals(client)
                )
                task = DebuggedTask(
                    programs[name],
                    world,
                    lambda line, where=where: write(where + line),
                    given.get("listen"),
                    files=None if folder is None else Path(folder),
                    answers=answers,
                    name=name,
                    cell=self.cell,
                )
                task.stops_first = bool(given.get("stopOnEntry"))
                self.tasks.append(task)
        except BaseException:
            self._opened.close()
            raise
        self._static = [task for task, (*_, static) in zip(self.tasks, parts, strict=True) if static]

    def run(self) -> None:
        """Run all tasks to their end; raises the error of one that ended by it."""
        routine = str(self._given.get("routine", "main"))
        self.cell.run(routine, self._static, forever=bool(self._given.get("continuous")))

    def answer(self, text: str) -> bool:
        """Answer what a task asks on its pendant; return whether one asks."""
        asks = any(one.pendant.question is not None for one in self.tasks)
        if asks:
            self._typed.put(text)
        return asks

    def hear(self, asking: Callable[[Question | None], None]) -> None:
        """Tell of each question."""
        for one in self.tasks:
            one.pendant.asking = asking

    def close(self) -> None:
        """End the connection to the kernel, and the wait for answers."""
        for _ in self.tasks:
            self._typed.put(None)
        self._opened.close()


def _check_types(given: Mapping[str, Any], known: Mapping[str, type | tuple[type, ...]]) -> None:
    for name, kinds in known.items():
        if name in given and not isinstance(given[name], kinds):
            told = " or ".join(one.__name__ for one in (kinds if isinstance(kinds, tuple) else (kinds,)))
            raise WrongLaunch(f"{name!r} of a launch is a {told}, not {given[name]!r}")


def _files(given: object, of: str) -> list[str]:
    """Return the files of a task, as the launch names them."""
    found = given if isinstance(given, list) else [given]
    names = [one for one in found if isinstance(one, str) and one]
    if not names or len(names) < len(found):
        raise WrongLaunch(f"'program' is the file of {of}, or a list of its files, not {given!r}")
    return names
