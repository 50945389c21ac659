"""An emulated ABB controller: tasks with their modules, execution, panel, signals, log, files and message queues."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.emulators.abb.log import Log
from virtualrobot_apps.emulators.abb.program import ControlledTask, Symbol
from virtualrobot_apps.emulators.abb.refused import Refused, unknown
from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.rapid.cell import Cell
from virtualrobot_apps.languages.rapid.configuration import confdata
from virtualrobot_apps.languages.rapid.frames import matrix_of, pose_of
from virtualrobot_apps.languages.rapid.parser import parse
from virtualrobot_apps.languages.rapid.predefined import VARIABLES
from virtualrobot_apps.languages.rapid.symbols import first_value
from virtualrobot_apps.languages.rapid.task import Loaded, load_tasks
from virtualrobot_apps.languages.rapid.values import read_value
from virtualrobot_apps.languages.rapid.world import World

CYCLES = ("once", "forever")
KEPT = {"pers": ("pers",), "all": ("pers", "var")}
"""Storages whose values stay: when the program pointer is set to main, and when main begins anew by itself."""
MOTION_PROGRAMS = Path(__file__).parent / "motion_program_exec.mod"
END_SECONDS = 15.0
"""Time (s of the wall clock) that a program has to end that was stopped for good."""


@dataclass(slots=True)
class Unit:
    """A task with its robot, and the modules that are loaded.

    Attributes:
        name: the task's.
        mechanical_unit: name of the robot as the controller has it.
        robot: name of the robot in the kernel.
        modules: source of each module, by its name as it is written.
        active: whether the task runs when the controller starts.
    """

    name: str
    mechanical_unit: str
    robot: str
    modules: dict[str, Source] = field(default_factory=dict)
    active: bool = True


@dataclass(frozen=True, slots=True)
class Queued:
    """A message of a queue."""

    data: str
    user_defined: str
    kind: str
    command: str


class Controller:
    """The controller; any thread calls it.

    Attributes:
        units: the tasks, by name.
        log: its event log.
        files: the folder that its disks are.
        motors_on: whether the motors have power.
        cycle: once or forever: how often main is run.
        queues: messages for clients, by the queue's name.
    """

    def __init__(
        self,
        client: Client,
        robots: Sequence[str],
        files: Path,
        *,
        create_signals: bool = False,
        listen_at: str | None = None,
        write: Callable[[str], None] = print,
        answers: Iterable[str] = (),
        egm: Mapping[str, tuple[str, int]] | None = None,
    ) -> None:
        """Have one task for each robot, T_ROB1 and so on, and no module.

        `create_signals`: signals that a module names and the world has not are added; the others are `RapidTask`'s.
        """
        self.client, self.files, self.log = client, files, Log()
        self.units = {
            f"T_ROB{number}": Unit(f"T_ROB{number}", f"ROB_{number}", robot) for number, robot in enumerate(robots, 1)
        }
        self._robots = {unit.name: client.robot(unit.robot) for unit in self.units.values()}
        self.motors_on, self.cycle = True, "forever"
        self.queues: dict[str, deque[Queued]] = {}
        self.listeners: set[Callable[[dict[str, Any]], None]] = set()
        """Are called, in a thread of the controller, with values of signals that have changed."""
        self._create, self._listen_at, self._write, self._answers = create_signals, listen_at, write, iter(answers)
        self._egm = egm
        self._lock = threading.RLock()
        self._programs: dict[str, Loaded] = {}
        self._tasks: dict[str, ControlledTask] = {}
        self._cell = Cell()
        self._thread: threading.Thread | None = None
        self._pointer: str = ""
        """`main`: it was set there; `begin`: main has ended, and begins anew; empty: nowhere."""
        self.log.write(10011)
        self._load({name: {} for name in self.units}, set())
        self._watch = client.signals.follow()
        threading.Thread(target=self._follow, name="signals", daemon=True).start()

    def close(self) -> None:
        """Stop what runs."""
        self._watch.close()
        with self._lock:
            self._end("the controller ends")

    def _follow(self) -> None:
        with suppress(VirtualRobotError):  # the kernel is gone, which each call notices itself
            for change in self._watch:
                for listener in list(self.listeners):
                    listener(change.values)

    # Programs.

    def unit(self, name: str) -> Unit:
        """Return a task by its name."""
        found = next((one for one in self.units.values() if one.name.lower() == name.lower()), None)
        if found is None:
            raise unknown("task", name, list(self.units))
        return found

    def load_module(self, task: str, source: Source, replace: bool = False) -> str:
        """Load the module of a source into a task, and return its name; refused as a whole where something is wrong."""
        with self._lock:
            unit = self.unit(task)
            self._needs_stop("a module is loaded")
            diagnostics = Diagnostics()
            modules = parse(source, diagnostics)
            if len(diagnostics):
                raise Refused("RAPID_SYNTAX_ERROR", told(ProgramError(diagnostics.sorted())))
            if len(modules) != 1:
                raise Refused("RAPID_SYNTAX_ERROR", f"{source.file} has {len(modules)} modules, and a file has one")
            name = modules[0].name
            others = {one: held for one, held in unit.modules.items() if one.lower() != name.lower()}
            if len(others) < len(unit.modules) and not replace:
                raise Refused("NAMEEXIST", f"{unit.name} has a module {name!r} already; say replace=true")
            self._load(self._modules() | {unit.name: {**others, name: source}}, {(unit.name, name.lower())})
        return name

    def load_motion_programs(self) -> None:
        """Load what runs the programs that abb-motion-program-exec uploads into all tasks; the way is logged."""
        for task in self.units:
            self.load_module(task, Source(MOTION_PROGRAMS.read_text("utf-8"), MOTION_PROGRAMS.name), replace=True)
        self.client.signals["motion_program_log_motion"] = True

    def unload_module(self, task: str, name: str) -> None:
        """Take a module out of a task."""
        with self._lock:
            unit = self.unit(task)
            self._needs_stop("a module is unloaded")
            rest = {one: source for one, source in unit.modules.items() if one.lower() != name.lower()}
            if len(rest) == len(unit.modules):
                raise unknown(f"module of {unit.name}", name, list(unit.modules))
            self._load(self._modules() | {unit.name: rest}, {(unit.name, name.lower())})

    def _modules(self) -> dict[str, dict[str, Source]]:
        return {unit.name: unit.modules for unit in self.units.values()}

    def _load(self, modules: dict[str, dict[str, Source]], changed: set[tuple[str, str]]) -> None:
        """Have these modules in the tasks, if they go together; `changed` are those whose data begin anew."""
        try:
            sources = {task: list(given.values()) for task, given in modules.items()}
            programs = load_tasks(sources, list(self.client.signals), watched=True)
        except ProgramError as error:
            raise Refused("RAPID_SYNTAX_ERROR", told(error)) from error
        if self._create:
            known = {name.lower() for name in self.client.signals}
            for use in [use for program in programs.values() for lower, use in program.signals.items()]:
                if use.name.lower() not in known:
                    known.add(use.name.lower())
                    self.client.signals.create(use.name, first_value(use))
        self._end("another program was loaded")
        before, self._programs = self._programs, programs
        try:
            self._renew("pers", changed)
        except VirtualRobotError as error:
            self._programs = before
            raise Refused("FAIL", str(error)) from error
        for task, given in modules.items():
            self.units[task].modules = given
        self._pointer = ""

    def _renew(self, kept: str, changed: AbstractSet[tuple[str, str]] = frozenset()) -> None:
        """Make tasks that have not run yet, with the values of data that stay."""
        cell, tasks = Cell(), {}
        for name, program in self._programs.items():
            world = World(self.client, self.units[name].robot, self._write)
            parts = (cell, self.files, self.log.report, self._write, self._answers, self._listen_at, self._egm)
            tasks[name] = ControlledTask(program, world, name, *parts)
        for name, task in tasks.items():
            task.prepare()
            if name in self._tasks:
                values = self._tasks[name].values()
                task.restore({key: one for key, one in values.items() if (name, key[0]) not in changed}, KEPT[kept])
        self._cell, self._tasks = cell, tasks

    # Execution.

    @property
    def running(self) -> bool:
        """True where a program is being done; one that was stopped and may go on is not."""
        thread = self._thread
        runs = self._runs()
        return thread is not None and thread.is_alive() and any(not (one.stands or one.over) for one in runs)

    def _runs(self) -> list[ControlledTask]:
        return [self._tasks[unit.name] for unit in self.units.values() if unit.active]

    @property
    def _held(self) -> bool:
        return self._thread is not None and self._thread.is_alive() and any(one.stands for one in self._runs())

    def _needs_stop(self, what: str) -> None:
        if self.running:
            raise Refused("EXEC_STATE", f"the program runs: stop it before {what}")

    def state_of(self, unit: Unit) -> str:
        """Return ready, started or stopped."""
        task = self._tasks[unit.name]
        if self._thread is None or not self._thread.is_alive() or task.over or not unit.active:
            return "ready" if self._pointer or not unit.modules else "stopped"
        return "stopped" if task.stands else "started"

    def activate(self, task: str, active: bool) -> None:
        """Say whether a task runs when the controller starts."""
        with self._lock:
            self._needs_stop("a task is activated or deactivated")
            unit = self.unit(task)
            if unit.active != active and self._held:
                raise Refused("EXEC_STATE", "tasks that were stopped go on as they are; set the pointer to main first")
            unit.active = active

    def reset_pointer(self) -> None:
        """Set the program pointer of all tasks to main, and give variables their first values; persistents stay."""
        with self._lock:
            self._needs_stop("the pointer is set to main")
            for unit in self.units.values():
                if unit.active and not self._has_main(unit):
                    raise Refused("NO_SUCH_SYMBOL", f"the modules of {unit.name} have no procedure main")
            self._end("the program pointer was set to main")
            self._renew("pers")
            self._pointer = "main"
            self.log.write(10002, *(unit.name for unit in self.units.values()))

    def _has_main(self, unit: Unit) -> bool:
        scopes = self._programs[unit.name].checked.modules
        return any(one.node.name.lower() == "main" for scope in scopes for one in scope.routines)

    def start(self, cycle: str = "asis") -> None:
        """Run main of all active tasks, or go on where they were stopped."""
        if cycle not in (*CYCLES, "asis"):
            raise unknown("cycle", cycle, (*CYCLES, "asis"))
        with self._lock:
            if self.running and not any(one.holds for one in self._runs()):
                raise Refused("EXEC_STATE", "the program runs already")
            if not self.motors_on:
                raise Refused("MECSTA_NOT_READY", "the motors are off: set the controller state to motoron")
            names = [unit.name for unit in self.units.values() if unit.active]
            self.cycle = self.cycle if cycle == "asis" else cycle
            if self._thread is not None and self._thread.is_alive() and any(one.holds for one in self._runs()):
                self.log.write(10151, *names)
                for task in self._runs():
                    task.go_on()
                return
            if not names:
                raise Refused("EXEC_STATE", "no task is active")
            if not self._pointer:
                raise Refused("NO_PP", "the program pointer is nowhere: set it to main (resetpp)")
            self._end("")
            if self._pointer == "begin":
                self._renew("all")
            self.log.write(10150, *names)
            run, idle = self._cell, [self._tasks[one.name] for one in self.units.values() if not one.active]
            forever = self.cycle == "forever"
            self._thread = threading.Thread(target=self._work, args=(run, idle, forever), name="RAPID", daemon=True)
            self._thread.start()

    def set_cycle(self, cycle: str) -> None:
        """Say how often main is run from the next start on: once or forever."""
        if cycle not in CYCLES:
            raise unknown("cycle", cycle, CYCLES)
        self.cycle = cycle

    def _work(self, cell: Cell, idle: list[ControlledTask], forever: bool) -> None:
        why, pointer = "the program has come to its end", "begin"
        try:
            cell.run("main", forever=forever, idle=idle)
        except TaskStopped as error:
            why, pointer = str(error), ""
        except Exception as error:  # of the program or of the kernel
            why, pointer = "an error has occurred", ""
            self.log.write(10020, str(error), kind="error")
            self._write(f"error: {error}")
        self._pointer = pointer
        self.log.write(10125, why)

    def stop(self) -> None:
        """Stop all tasks, whose robots brake on their paths; harmless where nothing runs."""
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                for task in self._runs():
                    task.hold()

    def _end(self, why: str) -> None:
        """End the run for good, and wait until it has ended."""
        thread = self._thread
        if thread is not None and thread.is_alive():
            for task in self._tasks.values():
                task.stop(why)
            thread.join(END_SECONDS)
            if thread.is_alive():
                raise Refused("EXEC_STATE", f"the program did not end within {END_SECONDS:g} s")
        self._thread = None

    def pointer(self, task: str) -> tuple[str, str, int] | None:
        """Return module, routine and line of the statement that a task is at; None where it is nowhere."""
        unit = self.unit(task)
        at = self._tasks[unit.name].line()
        if at is None and not self._pointer:
            return None
        best: tuple[int, str, str] | None = None
        for scope in self._programs[unit.name].checked.modules:
            source = scope.module.source
            for one in scope.routines:
                line = source.line(one.node.at)
                if at is None and one.node.name.lower() == "main":
                    return scope.module.name, one.node.name, line
                if at is not None and source.file == at[0] and line <= at[1] and (best is None or line > best[0]):
                    best = (line, scope.module.name, one.node.name)
        return None if best is None or at is None else (best[1], best[2], at[1])

    # Panel.

    def set_motors(self, on: bool) -> None:
        """Give the motors power or take it; a program that runs is stopped first."""
        with self._lock:
            if on != self.motors_on:
                self.motors_on = on
                if not on:
                    self.stop()
                self.log.write(10011 if on else 10010)

    # Data.

    def symbols(self, task: str) -> Iterator[Symbol]:
        """Yield the data of a task."""
        return self._tasks[self.unit(task).name].symbols()

    def symbol(self, path: Sequence[str]) -> Symbol:
        """Return the datum of a path: task and name, or task, module and name."""
        if len(path) not in (2, 3):
            raise Refused("NO_SUCH_SYMBOL", f"a datum is TASK/NAME or TASK/MODULE/NAME, not {'/'.join(path)!r}", 404)
        task, *module, name = path
        for one in self.symbols(task):
            if one.name.lower() == name.lower() and (not module or one.module.lower() == module[0].lower()):
                return one
        where = f"module {module[0]!r} of {task}" if module else task
        raise Refused("NO_SUCH_SYMBOL", f"there is no datum {name!r} in {where}", 404)

    def set_symbol(self, path: Sequence[str], text: str) -> None:
        """Give a datum the value that a text says."""
        with self._lock:
            one = self.symbol(path)
            if one.storage != "pers" and (one.storage != "var" or self.running):
                said = "is a constant" if one.storage == "const" else "is a variable, which is set while nothing runs"
                raise Refused("SYMBOL_NOT_PERSISTENT", f"{one.name!r} {said}; a persistent is set at any time")
            try:
                one.holder[0] = read_value(text, one.holder[0])
            except (ValueError, RecursionError):
                raise Refused("INVALIDARG", f"{text[:80]!r} is no value of {one.name!r}, a {one.type}") from None

    # The robots.

    @property
    def speed(self) -> float:
        """Factor by which its robots' motions are slowed, above 0, up to 1; those of others are as they are."""
        return next(iter(self._robots.values())).speed_factor

    @speed.setter
    def speed(self, factor: float) -> None:
        for robot in self._robots.values():
            robot.speed_factor = factor

    def robot_of(self, mechanical_unit: str) -> Unit:
        """Return the task whose robot is called so."""
        units = {one.mechanical_unit: one for one in self.units.values()}
        found = units.get(mechanical_unit.upper())
        if found is None:
            raise unknown("mechanical unit", mechanical_unit, list(units), "NO_SUCH_MECHUNIT")
        return found

    def joints(self, mechanical_unit: str) -> list[float]:
        """Return the joints of a robot, in degrees."""
        return np.degrees(self._robots[self.robot_of(mechanical_unit).name].state.positions).tolist()

    def target(self, mechanical_unit: str, tool: str, wobj: str, coordinate: str) -> tuple[list[Any], list[float]]:
        """Return the pose of a tool, in mm and by a quaternion, and the configuration of the robot.

        `coordinate` is Base (of the robot), World (the kernel's) or Wobj (the work object's).
        """
        unit = self.robot_of(mechanical_unit)
        robot = self._robots[unit.name]
        joints = robot.state.positions.tolist()
        solved = robot.solve_forward(joints, with_configuration=True)
        base, flange = solved.world_t_link[robot.links[0]], solved.world_t_link[robot.flange]
        frames = {"base": base, "world": np.eye(4)}
        if coordinate.lower() == "wobj":
            data = self._data(unit, wobj, "wobjdata")
            frames["wobj"] = base @ matrix_of(data[3]) @ matrix_of(data[4])
        if coordinate.lower() not in frames:
            raise unknown("coordinate system", coordinate, ("Base", "World", "Wobj"))
        world_t_tcp = flange @ matrix_of(self._data(unit, tool, "tooldata")[1])
        conf = confdata(joints, solved.configuration)
        return pose_of(np.linalg.inv(frames[coordinate.lower()]) @ world_t_tcp), conf

    def _data(self, unit: Unit, name: str, kind: str) -> list[Any]:
        if name.lower() in ("tool0", "wobj0"):
            return VARIABLES[name.lower()][2]
        one = self.symbol([unit.name, name])
        if one.type.name != kind or one.type.dimensions:
            raise Refused("INVALIDARG", f"{name!r} is a {one.type}, and no {kind}")
        return one.holder[0]


def told(error: ProgramError) -> str:
    """Return the first faults of a program in a line."""
    found = error.diagnostics
    more = f"; and {len(found) - 5} more" if len(found) > 5 else ""
    return "; ".join(map(str, found[:5])) + more
