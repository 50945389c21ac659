"""Debug adapter of RAPID and URScript, by the Debug Adapter Protocol: each task is a thread that stops by itself.

Program pointer and motion pointer of RAPID are two entries of the call stack: the first is what the program does next,
the last one, where the robot is still on its way, the move that it makes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.languages.core.debugger import RUNS, Datum, Debugger, Place, WrongExpression
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.core.pendant import Question
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.editor.channel import Channel, ChannelError
from virtualrobot_apps.languages.editor.launch import Launch, WrongLaunch, launched

if TYPE_CHECKING:
    from virtualrobot.cli.options import Target

WHERE = "virtualrobot/where"
"""Request besides those of the protocol: where tasks are, whether or not they stand."""
UNCAUGHT = "uncaught"
"""Filter of exceptions: a task stops where an error was that nothing has handled."""
_CAPABILITIES = {
    "supportsConfigurationDoneRequest": True,
    "supportsConditionalBreakpoints": True,
    "supportsEvaluateForHovers": True,
    "supportsSetVariable": True,
    "supportsTerminateRequest": True,
    "exceptionBreakpointFilters": [{"filter": UNCAUGHT, "label": "Errors that nothing handles", "default": True}],
}
_STOPPED_CODE = 130
"""Exit code of a program that somebody has stopped, as that of a command that Ctrl-C ends."""


Launching = Callable[[Mapping[str, Any], "Target", Callable[[str], None]], Launch]
"""Begins a program as a launch says, for a kernel; what it writes is told."""


class Refused(Exception):
    """A request that can't be answered; its message says why."""


class DebugAdapter:
    """Debug adapter of one editor and one program."""

    def __init__(self, channel: Channel, target: Target, launch: Launching = launched) -> None:
        """Begin without a program; `target` is the kernel of one that moves a robot, and `launch` begins one."""
        self._channel, self._target, self._launching = channel, target, launch
        self._sent = self._numbered = 0
        self._lock = threading.Lock()
        self._launch: Launch | None = None
        self._thread: threading.Thread | None = None
        self._frames: dict[int, tuple[Debugger, Place]] = {}
        self._slots: dict[int, tuple[Debugger, Place, Callable[[], Sequence[Datum]]]] = {}
        self._after: Callable[[], None] | None = None
        self._ended = False
        self._requests: dict[str, Callable[[Mapping[str, Any]], dict[str, Any] | None]] = {
            "initialize": self._initialize,
            "launch": self._launched,
            "setBreakpoints": self._set_breakpoints,
            "setExceptionBreakpoints": self._set_exception_breakpoints,
            "configurationDone": self._configured,
            "threads": self._threads,
            "stackTrace": self._stack_trace,
            "scopes": self._scopes,
            "variables": self._variables,
            "setVariable": self._set_variable,
            "evaluate": self._evaluate,
            WHERE: self._where,
            "continue": lambda given: self._go_on(given, "") or {"allThreadsContinued": False},
            "next": lambda given: self._go_on(given, "over"),
            "stepIn": lambda given: self._go_on(given, "in"),
            "stepOut": lambda given: self._go_on(given, "out"),
            "pause": lambda given: self._task(given).halt(),
            "terminate": lambda given: self._stop(),
            "disconnect": self._disconnect,
        }

    def run(self) -> int:
        """Serve until the editor ends, which stops the program; return the exit code."""
        code = 0
        try:
            while not self._ended:
                try:
                    message = self._channel.read()
                except ValueError:
                    continue  # a text that is no JSON has no number that an answer could name
                if message is None:
                    break
                self._handle(message)
        except (ChannelError, OSError):
            code = 1
        finally:
            self._stop()
            if self._thread is not None:
                self._thread.join()
            if self._launch is not None:
                self._launch.close()
        return code

    # Messages.

    def _handle(self, message: Any) -> None:  # noqa: ANN401 JSON
        if not isinstance(message, dict) or message.get("type") != "request":
            return
        command, given = str(message.get("command")), message.get("arguments")
        answer: dict[str, Any] = {
            "type": "response",
            "request_seq": message.get("seq", 0),
            "command": command,
            "success": True,
        }
        try:
            if command not in self._requests:
                raise Refused(f"there is no request {command!r}")
            body = self._requests[command](given if isinstance(given, dict) else {})
            if body is not None:
                answer["body"] = body
        except (Refused, WrongLaunch, WrongExpression, VirtualRobotError) as error:
            told = str(error)
            if isinstance(error, ProgramError):
                told = "\n".join(map(str, error.diagnostics[:20]))
            self._fail(answer, told)
        except Exception as error:  # such as a KeyError for what a request lacks
            self._fail(answer, f"{command}: {type(error).__name__}: {error}")
        self._send(answer)
        after, self._after = self._after, None
        if after is not None:
            after()

    def _fail(self, answer: dict[str, Any], told: str) -> None:
        """Make an answer one that says why there is none."""
        error = {"id": 1, "format": "{told}", "variables": {"told": told}, "showUser": True}
        answer.update(success=False, message=told, body={"error": error})

    def _send(self, message: dict[str, Any]) -> None:
        with self._lock:
            self._sent += 1
            self._channel.send({"seq": self._sent, **message})

    def _event(self, event: str, **body: Any) -> None:  # noqa: ANN401 JSON
        self._send({"type": "event", "event": event, "body": body})

    def _write(self, line: str, category: str = "stdout") -> None:
        self._event("output", category=category, output=f"{line}\n")

    def _asking(self, question: Question | None) -> None:
        """Tell of a question beside the line that is written of it: in the data of an output without a word."""
        asks = None if question is None else {"text": question.text, "choices": list(question.choices)}
        self._event("output", category="console", output="", data={"asks": asks})

    # The program.

    def _initialize(self, given: Mapping[str, Any]) -> dict[str, Any]:
        for name in ("linesStartAt1", "columnsStartAt1"):
            if given.get(name, True) is not True:
                raise Refused(f"{name!r} is true here")
        if given.get("pathFormat", "path") != "path":
            raise Refused("'pathFormat' is 'path' here")
        return dict(_CAPABILITIES)

    def _launched(self, given: Mapping[str, Any]) -> None:
        if self._launch is not None:
            raise Refused("a program is launched already")
        self._launch = self._launching(given, self._target, self._write)
        self._launch.hear(self._asking)
        for number, task in enumerate(self._launch.tasks, 1):
            task.stopped = self._stopper(number)
        self._after = lambda: self._event("initialized")

    def _stopper(self, number: int) -> Callable[[str, str], None]:
        def stopped(reason: str, told: str) -> None:
            more = {"description": told, "text": told} if told else {}
            self._event("stopped", reason=reason, threadId=number, allThreadsStopped=False, **more)

        return stopped

    @property
    def _program(self) -> Launch:
        if self._launch is None:
            raise Refused("no program is launched")
        return self._launch

    def _configured(self, given: Mapping[str, Any]) -> None:
        launch = self._program
        if self._thread is not None:
            raise Refused("the program runs already")
        self._thread = threading.Thread(target=self._run, args=(launch,), name="debugged program", daemon=True)
        self._after = self._thread.start

    def _run(self, launch: Launch) -> None:
        """Run the program to its end, and tell of that."""
        code = 0
        try:
            launch.run()
        except TaskStopped:
            code = _STOPPED_CODE
        except VirtualRobotError as error:
            self._write(str(error), "stderr")
            code = 1
        except BaseException as error:
            self._write(f"{type(error).__name__}: {error}", "stderr")
            code = 1
        self._event("exited", exitCode=code)
        self._event("terminated")

    def _stop(self) -> None:
        if self._launch is not None:
            for task in self._launch.tasks:
                task.stop("stopped by the debugger")

    def _disconnect(self, given: Mapping[str, Any]) -> None:
        self._ended = True

    def _set_breakpoints(self, given: Mapping[str, Any]) -> dict[str, Any]:
        path = given["source"].get("path")
        if not isinstance(path, str):
            raise Refused("a source has a path")
        file = self._launching_file(path)
        asked = {int(one["line"]): str(one.get("condition") or "") for one in given.get("breakpoints") or ()}
        tasks = [one for one in self._program.tasks if file in one.files]
        if not tasks:
            told = [{"verified": False, "line": line, "message": "the program has no such file"} for line in asked]
            return {"breakpoints": told}
        for task in tasks:
            became = task.set_breakpoints(file, asked)
        told = []
        for number, one in enumerate(became, 1):
            told.append({"id": number, "verified": not one.fault, "line": one.line, "source": {"path": path}})
            if one.fault:
                told[-1]["message"] = one.fault
        return {"breakpoints": told}

    def _set_exception_breakpoints(self, given: Mapping[str, Any]) -> None:
        for task in self._program.tasks:
            task.stops_at_errors = UNCAUGHT in given["filters"]

    def _launching_file(self, path: str) -> str:
        """Return the name that a program has for a file of the editor."""
        known = any(path in one.files for one in self._program.tasks)
        return path if known else str(Path(path).resolve())

    # Where tasks stand.

    def _where(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return the statement that each task does, and the move that its robot makes; no request of the protocol."""
        running = self._thread is not None and self._thread.is_alive()
        found = []
        for number, one in enumerate(self._program.tasks if running else (), 1):
            entry: dict[str, Any] = {"threadId": number, "stands": one.stands}
            if (at := one.at) is not None:
                entry["program"] = {"path": at[0], "line": at[1]}
            path, _, line = one.moves_at.rpartition(":")
            if path:
                entry["motion"] = {"path": path, "line": int(line)}
            found.append(entry)
        return {"tasks": found}

    def _task(self, given: Mapping[str, Any]) -> Debugger:
        number = int(given["threadId"])
        tasks = self._program.tasks
        if not 1 <= number <= len(tasks):
            raise Refused(f"threads are 1 to {len(tasks)}, not {number}")
        return tasks[number - 1]

    def _threads(self, given: Mapping[str, Any]) -> dict[str, Any]:
        return {"threads": [{"id": number, "name": one.name} for number, one in enumerate(self._program.tasks, 1)]}

    def _go_on(self, given: Mapping[str, Any], step: str) -> None:
        task = self._task(given)
        self._frames = {key: one for key, one in self._frames.items() if one[0] is not task}
        self._slots = {key: one for key, one in self._slots.items() if one[0] is not task}
        if not task.stands:
            raise Refused(RUNS)

        def after() -> None:
            with suppress(WrongExpression):  # it was stopped in between
                task.go_on(step)

        self._after = after

    def _stack_trace(self, given: Mapping[str, Any]) -> dict[str, Any]:
        task = self._task(given)
        if not task.stands:
            raise Refused(RUNS)
        places = task.stack()
        first = int(given.get("startFrame") or 0)
        count = int(given.get("levels") or 0) or len(places)
        found = []
        for place in places[first : first + count]:
            number = self._number()
            self._frames[number] = (task, place)
            entry = {"id": number, "name": place.name, "line": place.line, "column": 1}
            entry["source"] = {"name": Path(place.file).name, "path": place.file}
            if place.frame is None:
                entry["presentationHint"] = "subtle"
            found.append(entry)
        return {"stackFrames": found, "totalFrames": len(places)}

    def _number(self) -> int:
        """Return a number that no frame and no variable has had."""
        self._numbered += 1
        return self._numbered

    def _frame(self, number: Any) -> tuple[Debugger, Place]:  # noqa: ANN401 JSON
        if number not in self._frames:
            raise Refused("the program has gone on; ask for its stack again")
        return self._frames[number]

    def _scopes(self, given: Mapping[str, Any]) -> dict[str, Any]:
        task, place = self._frame(given["frameId"])
        if place.frame is None:
            return {"scopes": []}
        found = []
        for one in task.scopes(place.frame):
            reference = self._kept(task, place, one.data)
            found.append({"name": one.name, "variablesReference": reference, "expensive": one.aside})
            if one.local:
                found[-1]["presentationHint"] = "locals"
        return {"scopes": found}

    def _kept(self, task: Debugger, place: Place, slots: Callable[[], Sequence[Datum]]) -> int:
        number = self._number()
        self._slots[number] = (task, place, slots)
        return number

    def _shown(self, task: Debugger, place: Place, slot: Datum) -> dict[str, Any]:
        """Return value and type of a datum, and a number by which its parts are asked for."""
        reference = self._kept(task, place, lambda: slot.parts) if slot.parts else 0
        return {"type": slot.kind, "variablesReference": reference}

    def _variables(self, given: Mapping[str, Any]) -> dict[str, Any]:
        task, place, slots = self._slot(given["variablesReference"])
        found = [{"name": one.name, "value": one.text, **self._shown(task, place, one)} for one in slots()]
        first = int(given.get("start") or 0)
        return {"variables": found[first : first + (int(given.get("count") or 0) or len(found))]}

    def _slot(self, number: Any) -> tuple[Debugger, Place, Callable[[], Sequence[Datum]]]:  # noqa: ANN401 JSON
        if number not in self._slots:
            raise Refused("the program has gone on; ask for its variables again")
        return self._slots[number]

    def _set_variable(self, given: Mapping[str, Any]) -> dict[str, Any]:
        task, place, slots = self._slot(given["variablesReference"])
        slot = next((one for one in slots() if one.name == given["name"]), None)
        if slot is None or place.frame is None:
            raise Refused(f"there is no variable {given['name']!r} here")
        task.assign(slot, str(given["value"]), place.frame)
        return {"value": slot.text, **self._shown(task, place, slot)}

    def _evaluate(self, given: Mapping[str, Any]) -> dict[str, Any]:
        if given.get("context") == "repl" and self._program.answer(str(given["expression"])):
            return {"result": "", "variablesReference": 0}
        if given.get("frameId") is None:
            raise Refused("an expression is computed where a task stands; choose an entry of its call stack")
        task, place = self._frame(given["frameId"])
        if place.frame is None:
            raise Refused("an expression is computed in a routine, not where the robot is")
        slot = task.value(str(given["expression"]), place.frame)
        return {"result": slot.text, **self._shown(task, place, slot)}
